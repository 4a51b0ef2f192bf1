//! Rough walls and rough solids in front of a cap, found by BSDF sampling alone and with light sampling: the
//! counterpart of E13 for transmission.

use crate::caps::{aimed_at, found_by_chance};
use crate::common::*;
use dapple_integrator::Effect;
use dapple_scene::{Scene, TexturedMaterial};
use dapple_testkit::closed_form::{ggx_cap, ggx_refracted_cap};

/// Roughness, index (1: a thin wall, which blurs like a rough mirror, to the other side), half angle of the cap.
const CAPS: [(f32, f32, f64); 5] =
    [(0.3, 1.0, 0.1), (0.7, 1.0, 0.9), (0.4, 1.5, 0.1), (0.8, 1.5, 0.5), (1.0, 1.33, 0.3)];

fn before(roughness: f32, ior: f32, theta: f64, disk: TexturedMaterial) -> (Scene, f64) {
    let alpha = f64::from(roughness).powi(2);
    let exact =
        if ior == 1.0 { ggx_cap(alpha, theta) } else { ggx_refracted_cap(alpha, f64::from(ior), theta) };
    (under_a_cap(clear(roughness, ior), -1.0, theta, disk), exact)
}

#[test]
fn a_cap_found_by_chance() {
    for (roughness, ior, theta) in CAPS {
        let (scene, exact) = before(roughness, ior, theta, shadeless(1.0));
        let what = format!("roughness {roughness}, index {ior}");
        found_by_chance(&what, &scene, exact, Effect::Refract, 1.0 / f64::from(ior).powi(2));
    }
}

#[test]
fn a_cap_aimed_at() {
    for (roughness, ior, theta) in CAPS {
        let (scene, exact) = before(roughness, ior, theta, matte(0.0, 1.0));
        aimed_at(&format!("roughness {roughness}, index {ior}"), &scene, exact, Effect::Refract);
    }
}
