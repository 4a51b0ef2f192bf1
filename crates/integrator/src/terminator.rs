//! Soft shadow terminator for flat facets with smooth normals.
//!
//! Interpolated normals shade a facet as if it were curved, including directions from which the flat facet shadows
//! itself: the light would end at a hard edge along the facets. For these directions the ray starts on the smooth
//! surface that the vertex normals span above the facet [Hanika 2021], and so passes over the edge of the facet as it
//! would pass over the curved body. All other rays stay the same to the bit.
//!
//! There are no light leaks: the segment from the facet to the smooth surface, and as far again, must be unoccluded;
//! from there on the ray is an ordinary ray, which hits whatever is in its way, including the facet. Where the normals
//! span no such surface, the horizon of reflected light is that of the facet (`normals`).

use dapple_geometry::{Accel, Hit, Surface};
use dapple_math::Ray;
use glam::Vec3;

/// Vector from a hit to the smooth surface above it, on the side of `up`; `None` where the normals span no surface
/// above the error box of the hit.
pub(crate) fn lift(accel: &Accel, (hit, surface): (&Hit, &Surface), up: Vec3, time: f32) -> Option<Vec3> {
    let lift = accel.lift(hit, up, time);
    (lift.dot(up) > up.abs().dot(surface.p_error)).then_some(lift)
}

/// Origin of a ray that leaves a hit, on the side of `up`, below the horizon of its facet and above that of its smooth
/// surface; `None` if the segment to the origin is `occluded`. This occlusion query is not counted as a ray of the
/// image.
#[cold]
pub(crate) fn over_the_facet(
    accel: &Accel,
    (hit, surface): (&Hit, &Surface),
    up: Vec3,
    time: f32,
    occluded: impl Fn(&Ray) -> bool,
) -> Option<Vec3> {
    let lift = lift(accel, (hit, surface), up, time)?;
    let o = surface.origin_towards(up);
    let way = Ray { o, d: 2.0 * lift, t_max: 1.0 };
    (!occluded(&way)).then(|| o + lift)
}
