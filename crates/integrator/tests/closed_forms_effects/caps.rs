//! A cap of light seen through a rough lobe, with every pattern and both tracers.

use crate::common::maps::midpoint_bound;
use crate::common::tracers::*;
use dapple_integrator::Effect;
use dapple_sampling::Pattern;
use dapple_scene::Scene;

/// BSDF sampling alone. The weight, at most `most`, decreases with the angle, which depends on the second coordinate;
/// cut off at the cap it varies by `most`. It does not vary with the first coordinate.
pub fn found_by_chance(what: &str, scene: &Scene, exact: f64, effect: Effect, most: f64) {
    let camera = scene.cameras[0].camera.clone();
    for (tracer, pattern) in TRACERS.into_iter().flat_map(|t| PATTERNS.map(|p| (t, p))) {
        let side = if pattern == Pattern::Grid { 64 } else { 4 };
        let settings = by_chance(one_pixel(tracer, pattern, &[(effect, [side; 2])], side * side));
        let what = format!("{what}, {tracer:?} {pattern}");
        if pattern == Pattern::Grid {
            let bound = midpoint_bound([0.0, most], [side; 2]);
            let mean = values(scene, &camera, &settings, 0)[0];
            assert!((mean - exact).abs() <= bound, "{what}: {mean}, exact {exact}, bound {bound}");
        } else {
            let moments = replicas(scene, &camera, &settings, 1000)[0];
            assert_mean_known_to(&what, &moments, exact, 0.02 * exact);
        }
    }
}

/// Light samples and BSDF samples are combined with unequal counts, which the MIS weights must take into account.
pub fn aimed_at(what: &str, scene: &Scene, exact: f64, effect: Effect) {
    let camera = scene.cameras[0].camera.clone();
    for (tracer, pattern) in TRACERS.into_iter().flat_map(|t| UNBIASED.map(|p| (t, p))) {
        let plans = [(Effect::Light, [3, 3]), (effect, [2, 1])];
        let settings = one_pixel(tracer, pattern, &plans, 9);
        let moments = replicas(scene, &camera, &settings, 1500)[0];
        assert_mean_known_to(&format!("{what}, {tracer:?} {pattern}"), &moments, exact, 0.02 * exact);
    }
}
