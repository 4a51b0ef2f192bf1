//! Stress cases D01 to D03, D11, D12, D15: long paths, faint paths, Russian roulette, and absorption.

use super::{Case, Check, Effort, Outcome};
use crate::closed_form::roulette_variance;
use crate::scenes::{cube, glass, irradiance_meter, matte, moments, of, pixels, run, seen, square};
use crate::tally::Tally;
use dapple_integrator::camera::Film;
use dapple_integrator::lights::Environment;
use dapple_integrator::math::PixelRect;
use dapple_integrator::sampling::{Moments, Pattern};
use dapple_integrator::scene::{Scene, SceneError, TexturedMaterial, builtin};
use dapple_integrator::{Settings, settings::Strategy};
use glam::{DAffine3, DVec3, Vec3};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "D01",
        title: "closed room of albedo 0.9999",
        naive: "a depth limit of 256 keeps 2.5 % of the light",
        source: "docs/science.md, \"Russian roulette\"",
        check: Check::Run(long),
    },
    Case {
        id: "D02",
        title: "variance law of Russian roulette",
        naive: "survival capped at 0.95 has infinite variance for albedos above 0.975",
        source: "docs/science.md, \"Russian roulette\"",
        check: Check::Run(variance),
    },
    Case {
        id: "D03",
        title: "roulette changes noise, not means",
        naive: "survivors are not weighted by their probability, or coloured light survives by one channel",
        source: "Arvo & Kirk 1990; docs/science.md, \"Russian roulette\"",
        check: Check::Run(unbiased),
    },
    Case {
        id: "D11",
        title: "subnormal radiance",
        naive: "a hundred times slower, or flushed to zero on some threads only",
        source: "docs/science.md, \"Samples that are not numbers\"",
        check: Check::Run(subnormal),
    },
    Case {
        id: "D12",
        title: "a sample that is not finite",
        naive: "one NaN turns the pixel, and then the filtered image, black",
        source: "docs/science.md, \"Samples that are not numbers\"",
        check: Check::Run(contained),
    },
    Case {
        id: "D15",
        title: "Beer–Lambert absorption, optical depths 1e-6 to 1e4",
        naive: "0·∞ behind opaque matter; 1 − e⁻ˣ cancels",
        source: "docs/science.md, \"Absorption\"",
        check: Check::Run(absorption),
    },
];

fn furnace(albedo: f32) -> Result<Scene, SceneError> {
    let mut builder = seen(DVec3::new(0.3, 0.1, 0.2), DVec3::new(-1.0, 0.0, -1.0), 1.2);
    let wall = builder.material(matte(albedo, 1.0));
    builder.mesh("cube", cube(1.0, Vec3::ZERO), DAffine3::IDENTITY, wall);
    builder.build()
}

/// BSDF sampling only, because light sampling would add its own noise to that of the roulette.
fn alone(side: u32, spp: u32) -> Settings {
    Settings {
        max_bounces: u32::MAX - 1,
        strategy: Strategy::BsdfOnly,
        pattern: Pattern::Random,
        ..square(side, spp)
    }
}

/// In a closed room: number of reflections before the first roulette that can end a path, and its survival
/// probability.
fn first_roulette(albedo: f64) -> (f64, f64) {
    let before = f64::max(3.0, (0.25f64.ln() / albedo.ln()).floor() + 1.0);
    (before, 4.0 * albedo.powf(before))
}

fn long(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let Ok(scene) = furnace(0.9999) else { return tally.finish() };
    let albedo = f64::from(0.9999f32);
    let exact = 1.0 / (1.0 - albedo);
    let (before, first) = first_roulette(albedo);
    let exact_rays = before + first * exact;
    let outcome = run(&scene, &alone(16, effort.of(2, 40, 4000)));
    let m = moments(&outcome);
    tally.mean("radiance", &m, exact, effort.of(0.1, 0.02, 0.002));
    let per_path = outcome.stats.rays as f64 / outcome.stats.samples as f64;
    let error = exact / (outcome.stats.samples as f64).sqrt();
    tally.within("rays per path", per_path, exact_rays, 4.0 * error);
    tally.finish()
}

fn variance(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for albedo in [0.5f32, 0.8, 0.95] {
        let Ok(scene) = furnace(albedo) else { continue };
        let spp = effort.of(16, 256, 2048);
        let outcome = run(&scene, &alone(effort.of(16, 64, 64), spp));
        let variances: Moments =
            outcome.film.variance().pixels.iter().map(|p| f64::from(p.x) * f64::from(spp)).collect();
        // Survivors of the first roulette have a throughput of ¼; every later roulette has q = ρ, the case of the law in
        // which the number of vertices is geometric.
        let rho = f64::from(albedo);
        let later = roulette_variance(rho, rho);
        let ((_, alive), mean) = (first_roulette(rho), 1.0 / (1.0 - rho));
        let exact = (alive * later + alive * (1.0 - alive) * mean * mean) / 16.0;
        let what = format!("variance at albedo {albedo}");
        tally.mean(&*what, &variances, exact, effort.of(0.2, 0.0125, 0.005));
        tally.mean(format!("mean at albedo {albedo}"), &moments(&outcome), mean, effort.of(0.2, 0.02, 0.01));
    }
    tally.holds("survival by throughput satisfies q > ρ²", roulette_variance(0.99, 0.99).is_finite());
    tally.remark(
        "a cap of 0.95 would be infinite at 0.99: ".to_owned() + &roulette_variance(0.99, 0.95).to_string(),
    );
    tally.finish()
}

fn unbiased(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let side = effort.of(8, 16, 64);
    let render = |scene: &Scene, roulette: bool| {
        let settings =
            Settings { max_bounces: 400, pattern: Pattern::Random, ..square(side, effort.of(16, 256, 1024)) }
                .with_path(|p| p.roulette = roulette);
        let outcome = run(scene, &Settings { seed: u64::from(roulette), ..settings });
        (outcome.film.mean(), outcome.film.variance())
    };
    let mut builder = seen(DVec3::new(0.3, 0.1, 0.2), DVec3::new(-1.0, 0.0, -1.0), 1.2);
    let tinted = TexturedMaterial {
        emission: Vec3::ONE,
        double_sided: true,
        ..TexturedMaterial::lambert("tinted", Vec3::new(0.95, 0.01, 0.01))
    };
    let wall = builder.material(tinted);
    builder.mesh("cube", cube(1.0, Vec3::ZERO), DAffine3::IDENTITY, wall);
    let rooms = [
        ("coloured furnace", Some(builder)),
        ("cornell", builtin::builtin("cornell")),
        ("cornell-spheres", builtin::builtin("cornell-spheres")),
    ];
    for (name, builder) in rooms {
        let Some(Ok(scene)) = builder.map(|b| b.build()) else { continue };
        let ((a, va), (b, vb)) = (render(&scene, false), render(&scene, true));
        for channel in 0..3 {
            let difference: f64 =
                a.pixels.iter().zip(&b.pixels).map(|(a, b)| f64::from(b[channel] - a[channel])).sum();
            let sum: f64 = va.pixels.iter().chain(&vb.pixels).map(|v| f64::from(v[channel])).sum();
            let scale: f64 = a.pixels.iter().map(|p| f64::from(p[channel])).sum();
            let what = format!("{name}, channel {channel}: relative difference");
            tally.within(what, difference / scale, 0.0, 4.0 * sum.sqrt() / scale + 1e-6);
        }
    }
    tally.finish()
}

fn subnormal(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let under = |radiance: f32| {
        let mut builder = irradiance_meter();
        builder.environment(Environment::constant(Vec3::splat(radiance)));
        builder.build()
    };
    let (Ok(normal), Ok(faint)) = (under(1.0), under(1e-40)) else { return tally.finish() };
    let settings = Settings { max_bounces: 4, ..square(effort.of(16, 64, 256), 16) };
    let m = moments(&run(&faint, &settings));
    tally.within("a floor under a sky of 1e-40, over that", m.mean / f64::from(1e-40f32), 1.0, 1e-4);
    let slower = crate::clock::ratio(|| run(&faint, &settings), || run(&normal, &settings));
    if effort == Effort::Quick {
        tally.remark(format!("{slower:.2} times the time of a sky of 1"));
    } else {
        tally.at_most("time under a sky of 1e-40 over that of 1", slower, 1.2);
    }
    // Paths in a nearly black room of albedo 1e-12 end, because their remaining contribution is below 1e-30.
    if let Ok(scene) = furnace(1e-12) {
        let settings = alone(8, 16).with_path(|p| p.roulette = false);
        let outcome = run(&scene, &settings);
        let rays = outcome.stats.rays as f64 / outcome.stats.samples as f64;
        tally.at_most("rays of a path without remaining throughput", rays, 5.0);
        tally.within("light in a room of albedo 1e-12", moments(&outcome).mean, 1.0, 1e-6);
    }
    tally.finish()
}

fn contained(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let rect = PixelRect { x0: 0, y0: 0, x1: 1, y1: 1 };
    let mut film = Film::new(rect);
    let n = effort.of(100_000u32, 10_000_000, 1_000_000_000);
    let mut told = 0;
    for i in 0..n {
        let value =
            if i % 1_000_000 == 77 { [f32::NAN, f32::INFINITY][(i / 1_000_000 % 2) as usize] } else { 1.0 };
        told += u32::from(!film.add(0, 0, Vec3::splat(value), 1.0));
    }
    let bad = n.div_ceil(1_000_000);
    tally.exactly("bad samples reported", f64::from(told), f64::from(bad));
    tally.exactly("samples counted", film.count(0, 0) as f64, f64::from(n));
    tally.within("mean", film.mean_at(0, 0).x, 1.0 - f64::from(bad) / f64::from(n), 1e-9);
    let built = overflowing(&mut tally, effort);
    tally.holds("the overflowing scene is built", built.is_ok());
    tally.finish()
}

/// An environment of radiance 2e38 and a speck that emits as much and reflects everything: its radiance overflows f32.
/// The rest of the image, and all other samples of those pixels, must be unaffected.
fn overflowing(tally: &mut Tally, effort: Effort) -> Result<(), SceneError> {
    let (sky, side, spp) = (2e38f32, effort.of(32, 128, 512), 64);
    let mut builder = seen(DVec3::Z * 4.0, DVec3::ZERO, 0.5);
    let speck = builder.material(matte(1.0, sky));
    builder.mesh("speck", cube(1e-2, Vec3::ZERO), DAffine3::IDENTITY, speck);
    builder.environment(Environment::constant(Vec3::splat(sky)));
    let scene = builder.build()?;
    let settings = Settings { strategy: Strategy::BsdfOnly, ..square(side, spp) };
    let outcome = run(&scene, &settings);
    let (bad, all) = (outcome.stats.bad_sample_count, outcome.stats.samples);
    tally.holds("some samples overflow", bad > 0);
    let film = &outcome.film;
    let pixels = || (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
    let uncounted = pixels().filter(|&(x, y)| film.count(x, y) != u64::from(spp)).count();
    tally.none("pixels in which a sample that is not finite is not counted", uncounted as u64);
    let unclean = film.mean().pixels.iter().filter(|p| !p.is_finite()).count();
    tally.none("pixels that are not finite", unclean as u64);
    let mean = pixels().map(|(x, y)| film.mean_at(x, y).x).sum::<f64>() / f64::from(side).powi(2);
    tally.within("mean over the sky", mean / f64::from(sky), 1.0 - bad as f64 / all as f64, 1e-6);
    let camera = &scene.cameras[0].camera;
    let well = outcome.stats.bad_samples.iter().filter(|b| {
        let (path, value) = dapple_integrator::replay(&scene, camera, &settings, (b.x, b.y), b.sample);
        value.is_finite() || path.first().is_none_or(|vertex| vertex.object != "speck")
    });
    tally.none("reported samples that are finite in replay", well.count() as u64);
    Ok(())
}

fn absorption(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for depth in [1e-6f32, 0.1, 1.0, 1e2, 1e4] {
        // Seen through a cube of side 2 that does not refract.
        let mut builder = seen(DVec3::Z * 500.0, DVec3::ZERO, 1e-4);
        let filled = TexturedMaterial { sigma_a: Vec3::splat(0.5 * depth), ..of(glass(1.0, 0.0)) };
        let filled = builder.material(filled);
        builder.mesh("slab", cube(1.0, Vec3::ZERO), DAffine3::IDENTITY, filled);
        builder.environment(Environment::constant(Vec3::ONE));
        let m = pixels(builder, &square(8, effort.of(4, 16, 64))).unwrap_or_default();
        let exact = (-f64::from(depth)).exp();
        tally.within(
            format!("optical depth {depth}"),
            m.mean,
            exact,
            2e-6 * exact.max(1e-30) * f64::from(depth).max(1.0),
        );
    }
    tally.remark("without scattering media, which are not implemented");
    tally.finish()
}
