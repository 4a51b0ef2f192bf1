//! Warps from the unit square to disks, spheres, cones, triangles and tents.

use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_4, TAU};

/// Returns the radius and angle of the map of concentric squares to circles [Shirley & Chiu 1997], which is defined
/// piecewise on triangles of the square.
fn polar(u: DVec2) -> (f64, f64) {
    let p = u * 2.0 - DVec2::ONE;
    if p == DVec2::ZERO {
        return (0.0, 0.0);
    }
    let (r, eighths) = match (p.x.abs() > p.y.abs(), p.x > 0.0, p.y > 0.0) {
        (true, true, _) => (p.x, p.y / p.x),
        (true, false, _) => (-p.x, 4.0 + p.y / p.x),
        (false, _, true) => (p.y, 2.0 - p.x / p.y),
        (false, _, false) => (-p.y, 6.0 - p.x / p.y),
    };
    (r, FRAC_PI_4 * eighths)
}

/// Samples the unit disk uniformly.
pub fn disk(u: DVec2) -> DVec2 {
    let (r, phi) = polar(u);
    DVec2::new(phi.cos(), phi.sin()) * r
}

/// Samples the hemisphere about +z with cosine weight, by projecting the disk up to the hemisphere.
pub fn hemisphere_cosine(u: DVec2) -> DVec3 {
    let (r, phi) = polar(u);
    DVec3::new(r * phi.cos(), r * phi.sin(), (1.0 - r * r).sqrt())
}

/// Samples the unit sphere uniformly between the pole +z and z = 1 − `height`. Zones of equal height have equal areas
/// (Archimedes).
pub fn cone(u: DVec2, height: f64) -> DVec3 {
    let (v, phi) = (u.x * height, TAU * u.y);
    let r = (v * (2.0 - v)).sqrt();
    DVec3::new(r * phi.cos(), r * phi.sin(), 1.0 - v)
}

/// Samples the unit sphere uniformly.
pub fn sphere(u: DVec2) -> DVec3 {
    cone(u, 2.0)
}

/// Samples the barycentric coordinates of the second and third corner uniformly, by folding the square [Heitz 2019].
pub fn triangle(u: DVec2) -> DVec2 {
    if u.y > u.x { DVec2::new(0.5 * u.x, u.y - 0.5 * u.x) } else { DVec2::new(u.x - 0.5 * u.y, 0.5 * u.y) }
}

/// Samples the density 1 − |x| on −1..1 by the inverse of its distribution function.
pub fn tent(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 * (1.0 - u)).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_are_kept_and_shapes_are_filled() {
        let n = 400;
        let (mut inside, mut mean, mut corner) = (0, DVec3::ZERO, 0.0);
        for i in 0..n * n {
            let u = DVec2::new((i % n) as f64 + 0.5, (i / n) as f64 + 0.5) / n as f64;
            inside += i32::from(disk(u).length() < 0.5);
            mean += hemisphere_cosine(u);
            corner += triangle(u).x;
            assert!((sphere(u).length() - 1.0).abs() < 1e-15);
        }
        let all = f64::from(n * n);
        assert!((f64::from(inside) / all - 0.25).abs() < 1e-3);
        assert!((mean / all - DVec3::Z * (2.0 / 3.0)).length() < 1e-4);
        assert!((corner / all - 1.0 / 3.0).abs() < 1e-4);
        assert_eq!((tent(0.5), tent(0.0), tent(0.125)), (0.0, -1.0, -0.5));
    }
}
