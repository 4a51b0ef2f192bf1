//! Renders the Cornell box, compares it with two halves of a reference, and estimates its error without one.
//!
//!     cargo run --release --example compare -p dapple-analysis

use dapple_analysis::estimate::within;
use dapple_analysis::metrics::{Scale, compare_halves};
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::builtin;
use dapple_integrator::{Settings, render};
use std::ops::ControlFlow;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = builtin::builtin("cornell").ok_or("no such scene")?.build()?;
    let settings = Settings { size: (64, 64), pattern: Pattern::Random, ..Settings::default() };
    let image = |seed, spp| {
        let settings = Settings { seed, ..settings.clone() }.with_spp(spp);
        render(&scene, &scene.cameras[0].camera, &settings, &|_| ControlFlow::Continue(()))
    };
    let (outcome, halves) = (image(1, 16), [2, 3].map(|seed| image(seed, 256).film.mean()));
    let found = compare_halves(&outcome.film.mean(), [&halves[0], &halves[1]], &Scale::default())?;
    let estimate = within(&outcome.film, 0.95).ok_or("no estimate")?;
    println!(
        "relative RMSE: {:.4}, estimated without the reference: {:.4}",
        found.overall.relative_rmse, estimate.error
    );
    Ok(())
}
