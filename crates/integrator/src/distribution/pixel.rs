//! One pixel sample: means over the lens and the shutter interval of the ray trees that start there.

use super::tree::Tree;
use crate::Dimension;
use crate::effects::Effect;
use crate::emission::MisContext;
use crate::first_hit::start;
use crate::job::Job;
use crate::medium::MediumStack;
use crate::observer::PathObserver;
use crate::places::Place;
use crate::visibility::Visibility;
use dapple_sampling::Key;
use glam::{Vec2, Vec3};

/// Integral numbers of the integrals outside the ray tree; lobes use their index in `GROUPS`.
const LENS: u32 = 3;
const TIME: u32 = 4;

/// Sample `index` of the pixel (x, y): its radiance, and its pixel filter weight.
#[inline(always)]
pub(crate) fn pixel_point<V: Visibility, O: PathObserver>(
    job: &Job<'_>,
    visibility: V,
    (x, y): (u32, u32),
    index: u32,
    observer: &mut O,
    rays: &mut u64,
) -> (Vec3, f32) {
    let plans = &job.integrals.first;
    let n = plans.pixel.count().max(1);
    let pixel = Key::pixel(job.settings.seed, x, y);
    let pixel = if index < n { pixel } else { pixel.branch(index / n) };
    let place = Place::new(job.integrals.combine, pixel, index % n);
    let whole = Place::new(job.integrals.combine, pixel, 0);
    let (offset, weight) = if plans.is_off(Effect::Pixel) {
        (Vec2::ZERO, 1.0)
    } else {
        // In nested mode, the points of a pixel form one set, so that the key is that of the pixel.
        let of = if job.is_paired() { &place } else { &whole };
        job.settings.filter.sample(of.point_2d(plans.pixel, Dimension::Pixel, 0, index % n))
    };
    let mut sum = Vec3::ZERO;
    let (place, again) = (place.again(Effect::Pixel, job.again), job.again);
    let (lenses, times) = (place.count(plans.lens).max(1), place.count(plans.time).max(1));
    for l in 0..lenses {
        let lens = place.point_2d(plans.lens, Dimension::Lens, 0, l);
        let on_lens = place.within(LENS, l).again(Effect::Lens, again);
        for t in 0..times {
            if job.is_stopped() {
                return (Vec3::ZERO, weight);
            }
            let u = on_lens.point_1d(plans.time, Dimension::Time, t);
            let time = job.time(u);
            let mut ray = job.camera_ray((x, y), offset, lens, time);
            let mut near = job.near_most;
            let place = on_lens.within(TIME, t).again(Effect::Time, again);
            let mut stack = MediumStack::EMPTY;
            if !V::PLAIN && !job.media.is_empty() {
                stack = job.media.at(job.scene, &ray, time);
                if near > 0.0 && !stack.is_empty() {
                    (ray, stack, _) = start(job, &ray, time);
                    near = 0.0;
                }
            }
            let mut tree = Tree { job, visibility, time, observer, rays, held: None, nested: 0, near };
            let mut arrival = MisContext::CAMERA;
            if !V::PLAIN && ray.t_max < f32::INFINITY {
                arrival.view = ray.t_max * ray.d.length();
            }
            sum += tree.li(&ray, &arrival, place, &stack, Vec3::ONE);
        }
    }
    (sum / (lenses * times) as f32, weight)
}
