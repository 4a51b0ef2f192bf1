//! The soft edge of spot lights, and the end of the range of point lights, in f64.
use glam::DVec3;

/// Fraction of the intensity in the direction `d` for a light with the unit `axis`, see [`crate::Spot::falloff`]. The
/// angles are given as heights 1 − cosθ.
pub(crate) fn falloff(d: DVec3, axis: DVec3, inner: f64, outer: f64) -> f64 {
    let height = 0.5 * (d - axis).length_squared();
    if height <= inner {
        1.0
    } else if height >= outer {
        0.0
    } else {
        let a = (outer - height) / (outer - inner);
        a * a
    }
}

/// clamp(1 − r⁴, 0, 1): the fall-off at the distance `r` over the range that KHR_lights_punctual recommends.
pub(crate) fn window(r: f64) -> f64 {
    (1.0 - r * r * r * r).clamp(0.0, 1.0)
}
