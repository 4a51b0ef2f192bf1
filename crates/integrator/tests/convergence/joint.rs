//! Several integrals at once: the slopes of nested and paired combinations.
//!
//! Nested, with n points per integral: the outer integral is estimated by its own n points, however accurate the inner
//! ones are, so that the error decreases in n as that of one integral; the number of rays is n². Paired, N samples
//! stratify each integral but not their product: a sum of functions of one integral each converges as before, their
//! interaction as 1/N.

use crate::common::tracers::*;
use crate::edges::{any_direction, half_plane_seen};
use crate::smooth::{lit_plane, mean_radiance, moved, somewhere};
use crate::study::*;
use dapple_integrator::{Combine, Effect, Settings};
use dapple_sampling::SampleSet;
use dapple_testkit::closed_form::linear_edge;
use dapple_testkit::{Rng, quadrature};
use glam::DVec2;

fn both(combine: Combine, effects: &[Effect], plan: SampleSet) -> Settings {
    let mut settings = by_chance(one_pixel(Tracer::Nested, plan.pattern, &[], 1));
    effects.iter().for_each(|&effect| *settings.plans.of_mut(effect) = plan);
    Settings { max_bounces: 2, ..settings }.with_distribution(|d| d.combine = combine)
}

/// A lit plane through pixel and lens: 4-D, smooth.
fn nested_smooth(effort: Effort) {
    let light = DVec2::new(0.3, 0.2);
    let (scene, camera) = lit_plane(light, false);
    let error = |plan: SampleSet, seed: u64| {
        let (camera, p) = moved(&scene, &camera, somewhere(seed, 0.6));
        let over_lens = |x: f64, y: f64| mean_radiance(p.truncate() + DVec2::new(x, y), light);
        let exact = quadrature::rectangle(over_lens, [-0.5; 2], [0.5; 2], 1e-7);
        let settings = both(Combine::Nested, &[Effect::Pixel, Effect::Lens], plan);
        values(&scene, &camera, &settings, seed)[0] - exact
    };
    Study {
        name: "4-D smooth, pixel and lens nested, per integral",
        layout: Layout::Square,
        counts: if effort.long { &[4, 16, 64, 256] } else { &[4, 16, 64] },
        expected: [Some(-1.0), Some(-2.0), Some(-2.0), None],
        error: &error,
    }
    .check(effort);
}

/// An oblique edge through pixel, lens and mirror: 6-D.
fn paired_edge(effort: Effort) {
    let error = |plan: SampleSet, seed: u64| {
        let mut rng = Rng::new(seed);
        let (n, c) = (any_direction(&mut rng), (rng.f64() - 0.5) * 2.0);
        let (scene, camera) = half_plane_seen(n, c, true);
        let exact = linear_edge(&[n.x, n.y, n.x, n.y, n.x, n.y], c + 1.5 * (n.x + n.y));
        let settings = both(Combine::Paired, &[Effect::Pixel, Effect::Lens, Effect::Glossy], plan);
        values(&scene, &camera, &settings, seed)[0] - exact
    };
    Study {
        name: "6-D edge, pixel, lens and mirror paired",
        layout: Layout::Square,
        counts: effort.counts(),
        expected: [Some(-1.0); 4],
        error: &error,
    }
    .check(effort);
}

#[test]
fn several_integrals() {
    nested_smooth(QUICK);
    paired_edge(QUICK);
}

#[test]
#[ignore = "the long table: minutes"]
fn several_in_full() {
    nested_smooth(Effort { replicas: 200, ..FULL });
    paired_edge(FULL);
}
