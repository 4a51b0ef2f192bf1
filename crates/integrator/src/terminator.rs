//! Where does the shadow of a surface on itself begin, when its normals are smooth and its facets are flat?
//!
//! Interpolated normals light a facet as if it were curved, also from directions in which the flat facet shadows itself:
//! light would end at a hard edge along the facets. For those directions the ray leaves from the smooth surface that the
//! corners' normals span above the facet [Hanika 2021], and so passes over the facet's edge as it would pass over the round
//! body. All other rays stay as they are, to the bit.
//!
//! Nothing leaks: the way from the facet up to the smooth surface, and as far again, must be free; from there on the ray
//! is a ray like any other, and meets whatever is in its way, the facet included. Where the normals span no such surface,
//! the horizon of reflected light is the facet's (`normals`).

use dapple_geometry::{Accel, Hit, Surface};
use dapple_math::Ray;
use glam::Vec3;

/// From a hit to the smooth surface above it, on the side of `up`; None where the normals span none that can be told from
/// the facet: less than the error box cannot.
pub(crate) fn lift(accel: &Accel, (hit, surface): (&Hit, &Surface), up: Vec3, time: f32) -> Option<Vec3> {
    let lift = accel.lift(hit, up, time);
    (lift.dot(up) > up.abs().dot(surface.p_error)).then_some(lift)
}

/// Where a ray starts that leaves a hit, on the side of `up`, below the horizon of its facet and above that of its smooth
/// surface; None if it does not come so far, for the way is `blocked`. The look whether it does is no ray of the picture,
/// and is not counted.
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
