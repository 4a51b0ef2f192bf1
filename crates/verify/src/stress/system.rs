//! Stress cases D08 to D10, D16, D17: threads, stopping, crops, and invalid environment texels.

use super::{Case, Check, Effort, Outcome};
use crate::scenes::{irradiance_meter, moments, run, square};
use crate::tally::Tally;
use dapple_integrator::imaging::Image;
use dapple_integrator::lights::Environment;
use dapple_integrator::math::PixelRect;
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::{Scene, builtin};
use dapple_integrator::settings::Strategy;
use dapple_integrator::{Combine, MethodKind, Settings, render};
use glam::Vec3;
use std::ops::ControlFlow;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "D08",
        title: "identical bits with any number of threads",
        naive: "random numbers drawn in sequence, sums in the order of arrival",
        source: "docs/science.md, \"Reproducible pictures\"",
        check: Check::Run(threads),
    },
    Case {
        id: "D09",
        title: "stopping does not depend on the sample values",
        naive: "a pixel that stops at a small variance has missed its rare bright samples: mean 0.03 instead of 1",
        source: "Kirk & Arvo 1991; docs/science.md, \"When to stop\"",
        check: Check::Run(stopping),
    },
    Case {
        id: "D10",
        title: "invalid environment texels: NaN, infinite, negative",
        naive: "one NaN texel invalidates the table and turns everything it lights black",
        source: "docs/science.md, \"Samples that are not numbers\"",
        check: Check::Run(texels),
    },
    Case {
        id: "D16",
        title: "all pixels have the same samples wherever a render is stopped",
        naive: "slow samples are missing: the image depends on the clock",
        source: "docs/science.md, \"Reproducible pictures\"",
        check: Check::Run(stopped),
    },
    Case {
        id: "D17",
        title: "a crop equals that part of the full image",
        naive: "state left over from the previous pixel",
        source: "docs/science.md, \"Reproducible pictures\"",
        check: Check::Run(crops),
    },
];

fn rooms() -> Vec<(&'static str, Scene)> {
    let names = ["cornell", "cornell-spheres"];
    names.into_iter().filter_map(|n| Some((n, builtin::builtin(n)?.build().ok()?))).collect()
}

/// Small settings for every method and pattern, with their names.
fn methods(side: u32, spp: u32) -> Vec<(String, Settings)> {
    let mut all = Vec::new();
    for pattern in [Pattern::Sobol, Pattern::Stratified, Pattern::Random] {
        all.push((format!("path, {pattern}"), Settings { pattern, ..square(side, spp) }));
    }
    for combine in [Combine::Nested, Combine::Paired] {
        let settings = Settings { max_bounces: 2, ..square(side, spp) }
            .with_method(MethodKind::Distribution)
            .with_distribution(|d| d.combine = combine);
        all.push((format!("distribution, {combine}"), settings));
    }
    all
}

fn bits(picture: &Image) -> Vec<[u32; 3]> {
    picture.pixels.iter().map(|p| p.to_array().map(f32::to_bits)).collect()
}

fn threads(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for (room, scene) in rooms() {
        for (way, settings) in methods(effort.of(20, 40, 128), effort.of(2, 4, 16)) {
            let image = |threads| bits(&run(&scene, &settings.clone().with_threads(threads)).film.mean());
            let one = image(1);
            for n in [1, 2, 7, 64] {
                let differ = image(n).iter().zip(&one).filter(|(a, b)| a != b).count();
                tally.none(format!("pixels of {room} that differ with {n} threads, {way}"), differ as u64);
            }
        }
    }
    tally.finish()
}

/// A floor under an environment whose light comes from a cap that a cosine-weighted direction hits once in a thousand.
fn rare() -> Option<Scene> {
    let (w, h) = (64, 64);
    let mut pixels = vec![Vec3::ZERO; w * h];
    pixels[..w].fill(Vec3::ONE);
    let sky = Environment::picture(Image { width: w, height: h, pixels }, 0.0, 1.0, false).ok()?;
    let mut builder = irradiance_meter();
    builder.environment(sky);
    builder.build().ok()
}

fn stopping(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let Some(scene) = rare() else { return tally.finish() };
    let settings = Settings {
        strategy: Strategy::BsdfOnly,
        pattern: Pattern::Random,
        max_bounces: 1,
        ..square(effort.of(32, 64, 256), 256)
    };
    let share = (std::f64::consts::PI / 64.0).sin().powi(2);
    let m = moments(&run(&scene, &settings));
    tally.mean("rare bright samples, over their share", &m, share, 0.05);
    // Stopped after any pass, every pixel has the same number of samples.
    for passes in 1..4 {
        let camera = &scene.cameras[0].camera;
        let outcome = render(&scene, camera, &settings, &|p| {
            if p.spp >= passes { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let rect = settings.rect();
        let uneven = (0..rect.x1).flat_map(|x| (0..rect.y1).map(move |y| (x, y)));
        let uneven =
            uneven.filter(|&(x, y)| outcome.film.count(x, y) != u64::from(outcome.stats.spp)).count();
        tally.none(
            format!("pixels with another number of samples, stopped at {} of 256", outcome.stats.spp),
            uneven as u64,
        );
    }
    tally.remark("no pixel receives fewer samples than another");
    tally.finish()
}

fn texels(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let with = |value: f32| {
        let mut pixels = vec![Vec3::splat(0.5); 32 * 16];
        pixels[5 * 32 + 9] = Vec3::new(0.5, value, 0.5);
        Environment::picture(Image { width: 32, height: 16, pixels }, 0.0, 1.0, false)
    };
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0] {
        let refused = with(bad).is_err_and(|e| (e.x, e.y) == (9, 5) && e.to_string().contains("(9, 5)"));
        tally.holds(format!("a texel of {bad} is an error that names its position"), refused);
    }
    for good in [65_504.0, 1e30, 1e-40] {
        let Ok(sky) = with(good) else {
            tally.holds(format!("a texel of {good} is accepted"), false);
            continue;
        };
        let mut builder = irradiance_meter();
        builder.environment(sky);
        let Ok(scene) = builder.build() else { continue };
        let outcome = run(&scene, &Settings { max_bounces: 2, ..square(8, effort.of(16, 64, 256)) });
        tally.none(
            format!("samples that are not finite with a texel of {good}"),
            outcome.stats.bad_sample_count,
        );
        let dark = outcome.film.mean().pixels.iter().filter(|p| p.x <= 0.3).count();
        tally.none(format!("pixels that a texel of {good} darkens"), dark as u64);
    }
    tally.finish()
}

fn stopped(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for (room, scene) in rooms() {
        let side = effort.of(16, 48, 128);
        let camera = &scene.cameras[0].camera;
        for after in [1u64, 3_000, 100_000, 1_000_000] {
            let outcome = render(&scene, camera, &square(side, 64), &|p| {
                if p.rays >= after { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            // All pixels have as many samples as the render reports, the first of a set of 64.
            let uneven = (0..side * side)
                .filter(|i| outcome.film.count(i % side, i / side) != u64::from(outcome.stats.spp));
            tally.none(
                format!("pixels of {room} with another number of samples, stopped at {after} rays"),
                uneven.count() as u64,
            );
        }
    }
    tally.finish()
}

fn crops(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for (room, scene) in rooms() {
        for (way, settings) in methods(effort.of(20, 40, 128), 2) {
            let side = settings.size.0;
            let whole = run(&scene, &settings).film.mean();
            for (x, y, w, h) in [(0, 0, 1, 1), (13, 7, 1, 1), (3, 5, 9, 11), (side - 1, side - 1, 1, 1)] {
                let crop = PixelRect { x0: x, y0: y, x1: x + w, y1: y + h };
                let part = run(&scene, &Settings { crop: Some(crop), ..settings.clone() }).film.mean();
                let differ = (0..w * h).filter(|i| {
                    let at = (y + i / w) * side + x + i % w;
                    part.pixels[*i as usize].to_array().map(f32::to_bits)
                        != whole.pixels[at as usize].to_array().map(f32::to_bits)
                });
                tally.none(format!("pixels of a crop of {room} that differ, {way}"), differ.count() as u64);
            }
        }
    }
    tally.finish()
}
