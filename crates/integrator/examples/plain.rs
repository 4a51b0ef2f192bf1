//! Renders the Cornell box, a scene without special features, on one thread: `tools/feature_tax.py` counts the
//! instructions of this program. Prints the mean, so that the compiler cannot remove the render.

use dapple_integrator::scene::builtin;
use dapple_integrator::{MethodKind, Settings, render};
use std::ops::ControlFlow;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let method = match std::env::args().nth(1).as_deref() {
        Some("distribution") => MethodKind::Distribution,
        _ => MethodKind::Path,
    };
    let scene = builtin::builtin("cornell").ok_or("no such scene")?.build()?;
    let settings = Settings { size: (24, 24), max_bounces: 4, ..Settings::default() }
        .with_method(method)
        .with_threads(1)
        .with_spp(64);
    let outcome = render(&scene, &scene.cameras[0].camera, &settings, &|_| ControlFlow::Continue(()));
    println!("{}", outcome.film.mean().mean());
    Ok(())
}
