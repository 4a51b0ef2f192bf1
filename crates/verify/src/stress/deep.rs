//! Stress case D18: ray trees thousands of bounces deep.

use super::{Case, Check, Effort, Outcome};
use crate::scenes::{cube, run, seen};
use crate::tally::Tally;
use dapple_integrator::materials::{Material, Mirror};
use dapple_integrator::sampling::{Pattern, SampleSet};
use dapple_integrator::scene::{Scene, SceneError, TexturedMaterial};
use dapple_integrator::{MethodKind, SampleSets, Settings};
use glam::{DAffine3, DVec3, Vec3};
use std::time::Duration;

pub(super) const CASES: &[Case] = &[Case {
    id: "D18",
    title: "ten thousand bounces between mirrors, in both integrators",
    naive: "a recursive ray tree overflows the stack, on some threads only",
    source: "docs/science.md, \"Parallel mirrors\"",
    check: Check::Run(deep),
}];

/// A room of mirrors of reflectance `kr` that emit `emission`.
fn hall(kr: f32, emission: f32) -> Result<Scene, SceneError> {
    let mut builder = seen(DVec3::new(0.3, 0.1, 0.2), DVec3::new(-1.0, 0.4, -0.7), 0.8);
    let mirror = builder.material(TexturedMaterial {
        base: Material { mirror: Some(Mirror { kr: Vec3::splat(kr), blur: 0.0 }), ..Material::default() },
        emission: Vec3::splat(emission),
        double_sided: true,
        ..TexturedMaterial::default()
    });
    builder.mesh("hall", cube(1.0, Vec3::ZERO), DAffine3::IDENTITY, mirror);
    builder.build()
}

fn one_sample(method: MethodKind, threads: usize, max_bounces: u32) -> Settings {
    let pixel = SampleSet::new(1, Pattern::Stratified);
    Settings {
        size: (2, 2),
        max_bounces,
        plans: SampleSets { pixel, ..SampleSets::default() },
        ..Settings::default()
    }
    .with_method(method)
    .with_threads(threads)
    .with_spp(1)
    .with_path(|p| p.roulette = false)
}

fn deep(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let (kr, emission) = (0.9998f32, 2e-4f32);
    let (Ok(dim), Ok(endless)) = (hall(kr, emission), hall(1.0, 1e-6)) else { return tally.finish() };
    for bounces in [64, 65, effort.of(2000, 10_000, 100_000)] {
        let exact = f64::from(emission) * (1.0 - f64::from(kr).powi(bounces + 1)) / (1.0 - f64::from(kr));
        for method in [MethodKind::Path, MethodKind::Distribution] {
            for threads in [1, 2] {
                let mean = run(&dim, &one_sample(method, threads, bounces as u32)).film.mean().mean();
                let what = format!("{bounces} bounces, {method:?}, {threads} threads");
                tally.within(what, f64::from(mean.y), exact, 3e-4 * exact);
            }
        }
    }
    for method in [MethodKind::Path, MethodKind::Distribution] {
        let time_limit = Some(Duration::from_millis(50));
        let settings = one_sample(method, 1, u32::MAX).with_time_limit(time_limit);
        tally.holds(format!("{method:?} ends when time is up"), run(&endless, &settings).stats.timed_out);
    }
    tally.finish()
}
