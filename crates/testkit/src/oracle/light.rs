//! Lights as seen by a receiver at the origin: solid angles, densities per solid angle and irradiance.

use glam::DVec3;
use std::f64::consts::PI;

/// Returns the solid angle of the triangle with corners `a`, `b` and `c` from the origin, with the triple product of
/// edges [Van Oosterom & Strackee 1983].
pub fn triangle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let volume = a.dot((b - a).cross(c - a)).abs();
    let [la, lb, lc] = [a, b, c].map(DVec3::length);
    2.0 * volume.atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}

/// Returns the solid angle of a sphere from outside: 2π(1 − cosθ) with sinθ = R/d.
pub fn sphere(centre: DVec3, radius: f64) -> f64 {
    let s2 = (radius * radius) / centre.length_squared();
    2.0 * PI * s2 / (1.0 + (1.0 - s2).sqrt())
}

/// Returns the density per solid angle of a point sampled uniformly by area: d²/(A cosθ).
pub fn by_area(place: DVec3, normal: DVec3, area: f64) -> f64 {
    let d2 = place.length_squared();
    d2 * d2.sqrt() / (area * normal.dot(place).abs())
}

/// Returns the irradiance on a surface that faces a point light of intensity 1 with glTF's range.
pub fn point(place: DVec3, range: f64) -> f64 {
    let d2 = place.length_squared();
    (1.0 - (d2 / (range * range)).powi(2)).clamp(0.0, 1.0) / d2
}

/// Returns the density per solid angle, uniform within a texel, if a texel of an environment map in the
/// latitude-longitude layout is selected in proportion to its `weight` times its solid angle. `total` is the sum of
/// these products.
pub fn texel(weight: f64, total: f64) -> f64 {
    weight / total
}

/// Returns the solid angle of a texel in row `y` of an environment map of `width` by `height` texels.
pub fn texel_solid_angle(y: usize, width: usize, height: usize) -> f64 {
    let edge = |y: usize| (PI * y as f64 / height as f64).cos();
    2.0 * PI / width as f64 * (edge(y) - edge(y + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_octant_is_an_eighth_and_a_far_sphere_a_disk() {
        assert!((triangle(DVec3::X, DVec3::Y, DVec3::Z) - 0.5 * PI).abs() < 1e-15);
        assert!((sphere(DVec3::X * 1e6, 1.0) / (PI * 1e-12) - 1.0).abs() < 1e-12);
        let texels: f64 = (0..8).map(|y| 16.0 * texel_solid_angle(y, 16, 8)).sum();
        assert!((texels - 4.0 * PI).abs() < 1e-14);
    }
}
