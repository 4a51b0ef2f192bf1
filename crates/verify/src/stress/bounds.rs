//! Stress case D20: error bounds when few samples have found the light.

use super::{Case, Check, Effort, Outcome};
use crate::scenes::{glass, matte, of, quad, run, seen};
use crate::tally::Tally;
use dapple_analysis::estimate::{Verdict, unseen, within};
use dapple_integrator::imaging::Image;
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::{Scene, builtin};
use dapple_integrator::{Settings, peak};
use glam::{DAffine3, DVec3, Vec3};

pub(super) const CASES: &[Case] = &[Case {
    id: "D20",
    title: "an error bound when few samples have found the light",
    naive: "the variance of the observed light is taken for the error: a caustic that no sample has found is ignored",
    source: "Chernoff 1952; docs/error.md",
    check: Check::Run(caustic),
}];

/// A glass sphere and a small emitter above a floor.
fn scene() -> Option<Scene> {
    let mut builder = seen(DVec3::new(0.0, 3.0, 4.0), DVec3::new(0.0, 0.3, 0.0), 0.7);
    let floor = builder.material(matte(0.7, 0.0));
    let clear = builder.material(of(glass(1.5, 0.0)));
    let lamp = builder.material(matte(0.0, 300.0));
    let plane = quad(Vec3::new(-3.0, 0.0, 3.0), Vec3::X * 6.0, Vec3::Z * -6.0);
    builder.mesh("floor", plane, DAffine3::IDENTITY, floor);
    builder.sphere("ball", DVec3::new(0.0, 0.75, 0.0), 0.7, clear);
    builder.sphere("lamp", DVec3::new(1.8, 3.2, 0.5), 0.12, lamp);
    builder.environment(dapple_integrator::lights::Environment::constant(Vec3::splat(0.05)));
    builder.build().ok()
}

fn settings(spp: u32, seed: u64) -> Settings {
    let pattern = Pattern::Random;
    Settings { size: (16, 12), seed, pattern, max_bounces: 8, ..Settings::default() }.with_spp(spp)
}

/// The verdict after 64 samples, and the image.
fn judged(scene: &Scene, seed: u64) -> Option<(Verdict, Image)> {
    let settings = settings(64, seed);
    let outcome = run(scene, &settings);
    let peak = peak(scene, &scene.cameras[0].camera, &settings);
    let unseen = unseen(&outcome.film, &outcome.tail, &peak, 0.95);
    Some((Verdict::new(within(&outcome.film, 0.95)?, unseen, None), outcome.film.mean()))
}

fn caustic(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let seeds = effort.of(8, 40, 100);
    let (Some(scene), Some(room)) = (scene(), builtin::builtin("cornell").and_then(|b| b.build().ok()))
    else {
        return tally.finish();
    };
    let reference = run(&scene, &settings(effort.of(2048, 8192, 32768), 1 << 40)).film.mean();
    let (mut stated, mut beyond, mut doubted) = (0, 0, 0);
    for seed in 0..seeds {
        if let Some((verdict, picture)) = judged(&scene, seed) {
            stated += u64::from(verdict.reliable);
            beyond += u64::from(error(&picture, &reference) > verdict.bound);
        }
        doubted += u64::from(judged(&room, seed).is_none_or(|(verdict, _)| !verdict.reliable));
    }
    tally.none(format!("bounds stated for a caustic after 64 samples, of {seeds}"), stated);
    tally.at_most(
        "true errors above the bound with unseen light",
        beyond as f64,
        (0.1 * seeds as f64).ceil(),
    );
    tally.at_most("bounds not stated for the Cornell box", doubted as f64, (0.1 * seeds as f64).floor());
    tally.finish()
}

/// The relative RMSE of an image.
fn error(picture: &Image, reference: &Image) -> f64 {
    let squares =
        picture.pixels.iter().zip(&reference.pixels).map(|(a, b)| (*a - *b).as_dvec3().length_squared());
    let mean = f64::from(reference.mean().element_sum()) / 3.0;
    (squares.sum::<f64>() / (3 * picture.pixels.len()) as f64).sqrt() / mean
}
