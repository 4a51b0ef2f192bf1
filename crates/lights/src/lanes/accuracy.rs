//! Errors of the f32 formulas of flat lights against f64.
#![cfg(test)]

use super::flat::flat;
use super::{Rectangle, Triangle};
use crate::polygon::{Facet, Outline};
use dapple_testkit::Rng;
use glam::{Vec2, Vec3};

/// Largest errors: of the solid angle relative to itself, and of the coordinates of points. For squares,
/// slivers, or halves of them, at random places that subtend at least `least` sr.
fn errors(is_quad: bool, least: f32, sliver: f32) -> [f32; 2] {
    let (mut rng, mut worst, mut count) = (Rng::new(8), [0.0; 2], 0);
    while count < 20_000 {
        let n = rng.direction().as_vec3();
        let (x, y) = n.any_orthonormal_pair();
        let corner = rng.direction().as_vec3();
        let size = 4.0 * libm::powf(least.sqrt() / 4.0, rng.f32());
        let (e1, e2) = (x * size, y * size * sliver);
        let light = flat(corner, e1, e2, true);
        let (p, u) = (rng.direction().as_vec3() * (2.0 * rng.f32()), rng.vec2());
        let aimed = match is_quad {
            true => Rectangle(light).sample(p.into(), u.into()),
            false => Triangle(light).sample(p.into(), u.into()),
        };
        let facet =
            Facet::edges(p, corner, e1, e2, if is_quad { Outline::Rectangle } else { Outline::Triangle });
        if facet.omega() < f64::from(least) {
            continue;
        }
        let Some(exact) = facet.spot(u, true) else { continue };
        count += 1;
        let off = Vec2::new(aimed.s, aimed.t) - exact.at.as_vec2();
        worst[0] = f32::max(worst[0], ((f64::from(aimed.pdf) / exact.pdf - 1.0).abs()) as f32);
        worst[1] = f32::max(worst[1], off.abs().max_element());
        let along = Vec3::from(aimed.wi).dot(exact.wi.as_vec3());
        assert!(along > 0.9999, "{p} {corner} {e1} {e2}: {} {}", Vec3::from(aimed.wi), exact.wi);
    }
    worst
}

#[test]
fn points_and_densities_are_those_of_f64() {
    for (least, sliver) in [(1.1e-3, 1.0), (1e-2, 1.0), (0.1, 1.0), (1.1e-3, 0.01), (0.1, 0.01)] {
        let rectangle = errors(true, least, sliver);
        let triangle = errors(false, least, sliver);
        let (density, place) = if sliver < 1.0 { (5e-5, 2e-3) } else { (1e-5, 3e-4) };
        assert!(rectangle[0] < density && rectangle[1] < place, "{least} {sliver}: {rectangle:?}");
        assert!(triangle[0] < density && triangle[1] < 2e-5, "{least} {sliver}: {triangle:?}");
    }
}
