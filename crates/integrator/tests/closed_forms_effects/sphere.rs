//! Interreflection inside a sphere, where it is the same everywhere (docs/science.md, "Integrating sphere").

use crate::common::tracers::*;
use crate::common::*;
use dapple_integrator::{Effect, Settings};
use dapple_sampling::Pattern;
use glam::DVec2;

#[test]
fn one_reflection_inside_a_sphere() {
    for light in [DVec2::ZERO, DVec2::new(0.3, 0.2), DVec2::new(-0.5, 0.4)] {
        let (scene, exact) = sphere_lit_from(light.extend(0.0));
        let camera = scene.cameras[0].camera.clone();
        for tracer in TRACERS {
            for pattern in PATTERNS {
                let side = if pattern == Pattern::Grid { 32 } else { 4 };
                let plans = [(Effect::Diffuse, [side; 2])];
                let settings = Settings { max_bounces: 2, ..one_pixel(tracer, pattern, &plans, side * side) };
                let what = format!("light at {light}, {tracer:?} {pattern}");
                // The integrand is smooth: the error of the midpoint rule is far below its bound.
                let n = if pattern == Pattern::Grid { 1 } else { 1000 };
                let moments = replicas(&scene, &camera, &settings, n)[0];
                let floor = if pattern == Pattern::Grid { 1e-3 } else { 2e-5 } * exact;
                assert!(n == 1 || moments.standard_error() < 0.01 * exact, "{what} is inconclusive");
                assert_mean(&what, &moments, exact, floor);
            }
        }
    }
}
