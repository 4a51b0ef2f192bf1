//! Boundaries of bodies along a ray: coincident boundaries are merged, and those hidden inside a body of higher
//! priority are skipped.

use crate::job::Job;
use crate::medium::{Boundary, MediumStack};
use crate::shared_place::{self, are_one_place};
use crate::trace_context::TraceContext;
use crate::visibility::{Query, Visibility};
use dapple_geometry::{Hit, Surface};
use dapple_math::Ray;
use glam::Vec3;

/// Maximum number of coincident boundaries that are merged.
const IN_ONE_PLACE: usize = 32;

/// Maximum number of hidden boundaries that a ray passes without a bounce; the next one counts as a surface that the
/// ray passes as a bounce. This bounds the time and loses no light.
const HIDDEN: usize = 1024;

/// End of a ray, and the media along it.
pub(crate) struct Met {
    /// The surface, and its boundary if it has one; `None` where the ray leaves the scene.
    pub at: Option<(Hit, Surface, Option<Boundary>)>,
    /// Distance from the origin of the ray.
    pub distance: f32,
    /// Ray parameter of the first surface, hidden or not.
    pub first: f32,
    /// Transmittance along the ray.
    pub transmittance: Vec3,
    /// The bodies around the end of the ray, on its near side.
    pub stack: MediumStack,
    /// A body was dropped from a full medium stack along the ray.
    pub overflows: bool,
}

impl Met {
    /// Whether a camera ray that ends here continues.
    pub fn is_passed(&self, job: &Job<'_>, ray: &Ray, time: f32) -> bool {
        self.at.as_ref().is_some_and(|(hit, surface, _)| job.passes(ray, (hit, surface), 0.0, time))
    }
}

/// The nearest surface that is not a hidden boundary, in a scene with bodies. The nearest hit may be known.
#[inline(never)]
pub(crate) fn meet<V: Visibility>(
    context: &TraceContext<'_, V>,
    ray: &Ray,
    stack: &MediumStack,
    mut known: Option<(Hit, Option<Surface>)>,
) -> Met {
    let (scene, bodies) = (context.scene, context.job.media.bodies);
    let mut ray = *ray;
    let length = ray.d.length();
    let mut met = Met {
        at: None,
        distance: 0.0,
        first: f32::INFINITY,
        transmittance: Vec3::ONE,
        stack: *stack,
        overflows: false,
    };
    for passed in 0.. {
        let next = || Some((context.visibility.intersect(scene, &ray, context.time, context.key)?, None));
        let Some((mut hit, surface)) = known.take().or_else(next) else {
            met.transmittance *= met.stack.transmittance(bodies, f32::INFINITY);
            break;
        };
        let mut surface = surface.unwrap_or_else(|| scene.accel.surface(&ray, context.time, &hit));
        if let Some(places) = shared_place::of(scene) {
            shared_place::resolve_shared(places, &ray, (&mut hit, &mut surface), context);
        }
        if passed == 0 {
            met.first = hit.t;
        }
        let leg = hit.t * length;
        met.transmittance *= met.stack.transmittance(bodies, leg);
        met.distance += leg;
        if scene.objects[hit.object as usize].body == u32::MAX {
            met.at = Some((hit, surface, None));
            break;
        }
        let (boundary, _) = gather(context, &ray, &hit, &mut surface, &met.stack);
        met.overflows |= boundary.overflows;
        if !boundary.is_hidden() || passed == HIDDEN {
            met.at = Some((hit, surface, Some(boundary)));
            break;
        }
        met.stack = boundary.after;
        ray = Ray { o: surface.origin_towards(ray.d), d: ray.d, t_max: ray.t_max - hit.t };
    }
    met
}

/// Merges the boundary at `hit` with those of other bodies that coincide with it, or that lie before the origin of the
/// continuing ray: where two bodies touch, a ray leaves one and enters the other at once. Rays that continue from
/// `surface` start outside of all of them. Thin walls in between are omitted: the coincident body boundary hides them
/// (`shared_place`). Returns the boundary and the last hit.
pub(crate) fn gather<V: Visibility>(
    context: &TraceContext<'_, V>,
    ray: &Ray,
    hit: &Hit,
    surface: &mut Surface,
    stack: &MediumStack,
) -> (Boundary, Hit) {
    let (scene, media) = (context.scene, &context.job.media);
    let mut boundary = Boundary::new(stack);
    let from_outside = |of: &Surface| of.ng.dot(ray.d) < 0.0;
    let first = *surface;
    boundary.cross(scene.objects[hit.object as usize].body, from_outside(&first));
    let mut last = *hit;
    if media.bodies.len() < 2 {
        return (boundary, last);
    }
    let mut known = [(hit.object, from_outside(&first)); IN_ONE_PLACE];
    let mut count = 1;
    let at = Query { scene, ray, time: context.time, key: context.key };
    while count < IN_ONE_PLACE {
        let Some(next) = context.visibility.closest_where(&at, &|h| last.wins_over(h)) else { break };
        let body = scene.objects[next.object as usize].body;
        let other = scene.accel.surface(ray, context.time, &next);
        if !(are_one_place(&first, &other) || is_passed_over(surface, &other)) {
            break;
        }
        if body == u32::MAX {
            if !shared_place::is_wall(scene, &next) {
                break;
            }
            last = next;
            continue;
        }
        last = next;
        let crossing = (next.object, from_outside(&other));
        // A ray through an edge hits both adjacent triangles.
        if !known[..count].contains(&crossing) {
            boundary.cross(body, crossing.1);
            known[count] = crossing;
            count += 1;
        }
        surface.p_error = surface.p_error.max(first.p_error + 2.0 * other.p_error);
    }
    (boundary, last)
}

/// Whether a ray that continues from `from` starts beyond `other`.
fn is_passed_over(from: &Surface, other: &Surface) -> bool {
    from.ng.dot(other.p - from.p).abs() <= from.ng.abs().dot(from.p_error)
}
