//! Warps from the unit square to disks, spheres, cones, triangles, polygons and tents, with their densities. All are
//! defined on the whole of [0,1)² and map adjacent points to adjacent points, so that strata are preserved.

use crate::lanes::warp;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, PI, TAU};

/// Samples the square [−1,1]² uniformly. pdf = 1/4 per area.
pub fn square(u: Vec2) -> Vec2 {
    warp::square::<f32>(u.into()).into()
}

/// Samples the unit disk uniformly, mapping concentric squares to circles [Shirley & Chiu 1997]. pdf = 1/π per area.
pub fn disk(u: Vec2) -> Vec2 {
    warp::disk::<f32>(u.into()).into()
}

/// Samples the hemisphere about +z with cosine weight, by projection of the disk [Pharr, Jakob & Humphreys 2023,
/// §A.5.3]. pdf = cosθ/π per solid angle.
pub fn hemisphere_cosine(u: Vec2) -> Vec3 {
    warp::hemisphere_cosine::<f32>(u.into()).into()
}

/// Returns the density of [`hemisphere_cosine`] per solid angle, which is 0 below the horizon.
pub fn hemisphere_cosine_pdf(cos: f32) -> f32 {
    warp::hemisphere_cosine_pdf(cos)
}

/// Samples the unit sphere uniformly. pdf = 1/4π per solid angle.
pub fn sphere(u: Vec2) -> Vec3 {
    warp::sphere::<f32>(u.into()).into()
}

/// Samples the cone about +z with 1 − cosθ_max = `one_minus_cos` (0..2) uniformly. It is stable for cones of any size:
/// with v = u₁(1 − cosθ_max), cosθ = 1 − v and sin²θ = v(2 − v).
pub fn cone(u: Vec2, one_minus_cos: f32) -> Vec3 {
    warp::cone::<f32>(u.into(), one_minus_cos).into()
}

/// Returns the density of [`cone`] inside the cone: 1 / (2π(1 − cosθ_max)) per solid angle.
pub fn cone_pdf(one_minus_cos: f32) -> f32 {
    warp::cone_pdf(one_minus_cos)
}

/// Samples barycentric coordinates (b1, b2) uniformly over a triangle, by folding the square without a square root
/// [Heitz 2019]. pdf = 1/area.
pub fn triangle(u: Vec2) -> Vec2 {
    warp::triangle::<f32>(u.into()).into()
}

/// Samples the regular n-gon of circumradius 1 uniformly, with its first corner at angle `rotation` (radians).
/// pdf = 1/(½·n·sin(2π/n)) per area. Fewer than 3 blades give the disk.
pub fn polygon(u: Vec2, blades: u32, rotation: f32) -> Vec2 {
    warp::polygon::<f32>(u.into(), blades, rotation).into()
}

/// Samples the tent filter of half-width `radius` on one axis. Its density is (1 − |x|/r)/r.
pub fn tent(u: f32, radius: f32) -> f32 {
    warp::tent(u, radius)
}

/// Returns the density of [`polygon`] inside the polygon, per area: 1/(½·n·sin(2π/n)), and that of the disk for fewer
/// than 3 blades.
pub fn polygon_pdf(blades: u32) -> f32 {
    if blades < 3 { DISK_PDF } else { 2.0 / (blades as f32 * libm::sinf(TAU / blades as f32)) }
}

/// Returns the density of [`tent`] per length.
pub fn tent_pdf(x: f32, radius: f32) -> f32 {
    warp::tent_pdf(x, radius)
}

/// The density of [`disk`] per area.
pub const DISK_PDF: f32 = FRAC_1_PI;

/// The density of [`sphere`] per solid angle.
pub const SPHERE_PDF: f32 = 1.0 / (4.0 * PI);

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(n: u32) -> impl Iterator<Item = Vec2> {
        (0..n * n).map(move |i| (Vec2::new((i % n) as f32, (i / n) as f32) + 0.5) / n as f32)
    }

    #[test]
    fn means_are_those_of_the_shapes() {
        let n = 200;
        let count = f64::from(n * n);
        let mean = |f: &dyn Fn(Vec2) -> f64| lattice(n).map(f).sum::<f64>() / count;
        let close = |a: f64, b: f64| assert!((a - b).abs() < 6e-4, "{a} {b}");
        close(mean(&|u| f64::from(disk(u).length_squared())), 0.5);
        close(mean(&|u| f64::from(hemisphere_cosine(u).z)), 2.0 / 3.0);
        close(mean(&|u| f64::from(sphere(u).z.powi(2))), 1.0 / 3.0);
        close(mean(&|u| f64::from(triangle(u).x)), 1.0 / 3.0);
        close(mean(&|u| f64::from(triangle(u).y)), 1.0 / 3.0);
        close(mean(&|u| f64::from(tent(u.x, 2.0).powi(2))), 4.0 / 6.0);
        close(mean(&|u| f64::from(polygon(u, 6, 0.3).x)), 0.0);
        // The polar second moment of a regular hexagon of circumradius 1 is (R²/6)(2 + cos(2π/n)).
        close(mean(&|u| f64::from(polygon(u, 6, 0.3).length_squared())), (2.0 + 0.5) / 6.0);
    }

    #[test]
    fn tiny_cones_keep_their_shape() {
        for one_minus_cos in [2.0, 1e-3, 1e-10, 1e-20] {
            for u in lattice(20) {
                let d = cone(u, one_minus_cos);
                assert!((d.length() - 1.0).abs() < 1e-6);
                let sin2 = d.x * d.x + d.y * d.y;
                let v = u.x * one_minus_cos;
                assert!((sin2 / (v * (2.0 - v)) - 1.0).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn ends_of_the_range_are_fine() {
        let end = 1.0 - f32::EPSILON / 2.0;
        for u in [Vec2::ZERO, Vec2::splat(end), Vec2::new(0.0, end), Vec2::new(end, 0.0), Vec2::splat(0.5)] {
            assert!(disk(u).is_finite() && hemisphere_cosine(u).is_finite() && sphere(u).is_finite());
            assert!(polygon(u, 5, 1.0).is_finite() && tent(u.x, 1.0).is_finite());
            assert!(hemisphere_cosine(u).z >= 0.0);
        }
    }
}
