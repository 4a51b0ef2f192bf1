//! Rough walls and rough matter before a cap, found by chance and aimed at as well: what E13 is for reflection.

use crate::common::maps::midpoint_bound;
use crate::common::tracers::*;
use crate::common::*;
use dapple_integrator::Effect;
use dapple_sampling::Pattern;
use dapple_scene::{Scene, TexturedMaterial};
use dapple_testkit::closed_form::{ggx_cap, ggx_refracted_cap};

/// Roughness, index (1: a thin wall, which blurs as a rough mirror does, to the other side), half angle of the cap.
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
        let camera = scene.cameras[0].camera.clone();
        for tracer in TRACERS {
            for pattern in PATTERNS {
                // As for the rough mirror: the weight, at most 1/η², falls with the second coordinate and is cut off.
                let side = if pattern == Pattern::Grid { 64 } else { 4 };
                let settings = one_pixel(tracer, pattern, &[(Effect::Refract, [side; 2])], side * side);
                let what = format!("roughness {roughness}, index {ior}, {tracer:?} {pattern}");
                if pattern == Pattern::Grid {
                    let bound = midpoint_bound([0.0, 1.0 / f64::from(ior).powi(2)], [side; 2]);
                    let mean = values(&scene, &camera, &settings, 0)[0];
                    assert!((mean - exact).abs() <= bound, "{what}: {mean}, exact {exact}, bound {bound}");
                } else {
                    let moments = replicas(&scene, &camera, &settings, 1000)[0];
                    assert_mean_known_to(&what, &moments, exact, 0.02 * exact);
                }
            }
        }
    }
}

/// Points on the light and directions of the lobe share the work.
#[test]
fn a_cap_aimed_at() {
    for (roughness, ior, theta) in CAPS {
        let (scene, exact) = before(roughness, ior, theta, matte(0.0, 1.0));
        let camera = scene.cameras[0].camera.clone();
        for tracer in TRACERS {
            for pattern in UNBIASED {
                let plans = [(Effect::Light, [3, 3]), (Effect::Refract, [2, 1])];
                let settings = one_pixel(tracer, pattern, &plans, 9);
                let moments = replicas(&scene, &camera, &settings, 1500)[0];
                let what = format!("roughness {roughness}, index {ior}, {tracer:?} {pattern}");
                assert_mean_known_to(&what, &moments, exact, 0.02 * exact);
            }
        }
    }
}
