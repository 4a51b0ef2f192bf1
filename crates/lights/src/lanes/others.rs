//! Lights whose lanes are computed one by one.
use super::columns::{Columns, lane, lanes_of, stored, three};
use super::receiver::{Hit, Receiver};
use super::sample::Sample;
use crate::{Light, LightPoint};
use dapple_math::lanes::{MAX_LANES, Mask, Real, Vec2x, Vec3x, Word};
use glam::{Vec2, Vec3};

/// Replaces the lanes of `mask` by samples of the lights `index`.
#[inline(always)]
pub(super) fn sampled<R: Real>(
    lights: &[Light],
    mask: R::Mask,
    index: R::Word,
    from: Receiver<R>,
    u: Vec2x<R>,
    sample: Sample<R>,
) -> Sample<R> {
    let mut out = Out::default();
    let mut numbers = [0; MAX_LANES];
    index.store(&mut numbers);
    let [x, y, time] = stored([u.x, u.y, from.time]);
    sample_lanes(lights, mask.bitmask(), &numbers, &three(from.p), [&x, &y, &time], &mut out);
    let other = Sample {
        wi: loaded(&out.wi),
        pdf: R::load(&out.pdf),
        delta: R::Mask::from_bitmask(out.delta),
        radiance: loaded(&out.radiance),
        distance: R::load(&out.distance),
        has_point: R::Mask::from_bitmask(out.has_point),
        p: loaded(&out.p),
        p_error: loaded(&out.p_error),
        n: loaded(&out.n),
        triangle: R::load(&out.place[0]),
        u: R::load(&out.place[1]),
        v: R::load(&out.place[2]),
    };
    Sample::select(mask, other, sample)
}

/// Replaces the lanes of `mask` by densities of the lights `index`.
#[inline(always)]
pub(super) fn densities<R: Real>(
    lights: &[Light],
    mask: R::Mask,
    index: R::Word,
    from: Receiver<R>,
    hit: Hit<R>,
    pdf: R,
) -> R {
    let mut numbers = [0; MAX_LANES];
    index.store(&mut numbers);
    let [mut pdf, distance, time] = stored([pdf, hit.distance, from.time]);
    let vectors = [&three(from.p), &three(hit.wi), &three(hit.n)];
    pdf_lanes(lights, mask.bitmask(), &numbers, vectors, [&distance, &time], &mut pdf);
    R::load(&pdf)
}

#[inline(always)]
fn loaded<R: Real>([x, y, z]: &Columns<3>) -> Vec3x<R> {
    Vec3x::load([x, y, z])
}

/// Samples as columns.
#[derive(Default)]
struct Out {
    wi: Columns<3>,
    pdf: [f32; MAX_LANES],
    delta: u32,
    radiance: Columns<3>,
    distance: [f32; MAX_LANES],
    has_point: u32,
    p: Columns<3>,
    p_error: Columns<3>,
    n: Columns<3>,
    /// Triangle and barycentric coordinates.
    place: Columns<3>,
}

fn set(columns: &mut Columns<3>, i: usize, v: Vec3) {
    columns.iter_mut().zip(v.to_array()).for_each(|(column, x)| column[i] = x);
}

#[cold]
#[inline(never)]
fn sample_lanes(
    lights: &[Light],
    mask: u32,
    numbers: &[u32],
    p: &Columns<3>,
    [x, y, time]: [&[f32]; 3],
    out: &mut Out,
) {
    for i in lanes_of(mask) {
        let light = lights.get(numbers[i] as usize);
        let sample = light.and_then(|light| light.sample(lane(p, i), Vec2::new(x[i], y[i]), time[i]));
        let Some(s) = sample else { continue };
        set(&mut out.wi, i, s.wi);
        set(&mut out.radiance, i, s.radiance);
        (out.pdf[i], out.distance[i]) = (s.pdf, s.distance);
        out.delta |= u32::from(s.delta) << i;
        if let Some(LightPoint { p, p_error, n, triangle, u, v }) = s.point {
            out.has_point |= 1 << i;
            set(&mut out.p, i, p);
            set(&mut out.p_error, i, p_error);
            set(&mut out.n, i, n);
            set(&mut out.place, i, Vec3::new(triangle as f32, u, v));
        }
    }
}

#[cold]
#[inline(never)]
fn pdf_lanes(
    lights: &[Light],
    mask: u32,
    numbers: &[u32],
    [p, wi, n]: [&Columns<3>; 3],
    [distance, time]: [&[f32]; 2],
    pdf: &mut [f32],
) {
    for i in lanes_of(mask) {
        let light = lights.get(numbers[i] as usize);
        let density = |light: &Light| light.pdf(lane(p, i), lane(wi, i), distance[i], lane(n, i), time[i]);
        pdf[i] = light.map_or(0.0, density);
    }
}
