//! Automatic exposure of PNG output: metered on a small render of the whole frame if none is given.
//!
//! The render is always the same for a scene, a view and the settings that change the light: it does not depend on the
//! crop, sample count, seed, sampling pattern or thread count, so that all parts of an image and all frames of a study
//! get the same exposure. Only a time limit can end it early; what it takes counts against the limit.

use crate::interrupt;
use crate::options::RenderOptions;
use crate::say::say;
use dapple_integrator::camera::Camera;
use dapple_integrator::imaging::metering;
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::Scene;
use dapple_integrator::{MethodKind, Settings, Stats, render};
use std::ops::ControlFlow;
use std::time::Instant;

/// Longer side of the metered image, in pixels, and its samples per pixel.
const SIDE: f64 = 32.0;
const SAMPLES: u32 = 16;

/// Returns the exposure in stops for images of `camera` in `scene` with `settings`. Unlit surfaces should keep their
/// colours: the exposure is 0 if all surfaces are unlit, and at most 0 if some are.
pub fn exposure(scene: &Scene, camera: &Camera, settings: &Settings) -> f32 {
    let mut unlit = scene.objects.iter().map(|o| scene.materials[o.material as usize].unlit);
    if unlit.clone().all(|unlit| unlit) {
        return 0.0;
    }
    let most = if unlit.any(|unlit| unlit) { 0.0 } else { f32::INFINITY };
    let progress = |_| if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let outcome = render(scene, camera, &small(settings), &progress);
    metering::exposure(&outcome.film.mean()).min(most)
}

/// Renders the metered image, and returns its statistics.
pub fn trial(scene: &Scene, camera: &Camera, settings: &Settings) -> Stats {
    let progress = |_| if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    render(scene, camera, &small(settings), &progress).stats
}

/// Returns the requested exposure, else the metered one for all images of `camera`, which is printed once; `what` names
/// the exposed images in the message.
pub fn for_all(
    what: &str,
    options: &RenderOptions,
    (scene, camera, settings): (&Scene, &Camera, &Settings),
) -> f32 {
    options.exposure.unwrap_or_else(|| metered(what, options, (scene, camera, settings)))
}

/// Returns [`exposure`] and prints it.
pub fn metered(
    what: &str,
    options: &RenderOptions,
    (scene, camera, settings): (&Scene, &Camera, &Settings),
) -> f32 {
    let start = Instant::now();
    let stops = exposure(scene, camera, settings);
    if !RenderOptions::is(options.quiet) {
        let seconds = start.elapsed().as_secs_f64();
        let took = if seconds < 1.0 { String::new() } else { format!(" in {seconds:.1} s") };
        say(&format!("exposure of {what} metered{took}: {stops:+.2} stops (--exposure {stops} repeats it)"));
    }
    stops
}

/// Returns settings with the same lighting, fewer pixels, and fixed samples.
fn small(settings: &Settings) -> Settings {
    let (width, height) = (f64::from(settings.size.0), f64::from(settings.size.1));
    let scale = SIDE / width.max(height);
    let side = |length: f64| (length * scale).round().max(1.0) as u32;
    Settings {
        size: (side(width), side(height)),
        crop: None,
        pattern: Pattern::Sobol,
        seed: 0,
        aovs: Vec::new(),
        picture: true,
        general: false,
        ..settings.clone()
    }
    .with_method(MethodKind::Path)
    .with_spp(SAMPLES)
    .with_path(|p| (p.of, p.adaptive, p.allocation) = (None, false, None))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_integrator::scene::builtin;

    /// A dim room with an unlit sign: the sign keeps its colour and the room stays dim.
    #[test]
    fn unlit_colours_are_not_raised() {
        let mut scene = builtin::builtin("cornell").unwrap().build().unwrap();
        let camera = scene.cameras[0].camera.clone();
        assert!(exposure(&scene, &camera, &Settings::default()) > 0.0);
        let box_of = scene.objects.last().unwrap().material as usize;
        scene.materials[box_of].unlit = true;
        assert!(exposure(&scene, &camera, &Settings::default()) <= 0.0);
        scene.materials.iter_mut().for_each(|m| m.unlit = true);
        assert_eq!(exposure(&scene, &camera, &Settings::default()), 0.0);
    }

    #[test]
    fn only_light_and_shape_change_the_exposure() {
        let scene = builtin::builtin("cornell").unwrap().build().unwrap();
        let camera = &scene.cameras[0].camera;
        let meter = |settings: &Settings| exposure(&scene, camera, settings);
        let plain = Settings { size: (96, 96), ..Settings::default() };
        let at = meter(&plain);
        assert!(at > 0.0 && at < 4.0, "{at}");
        let crop = dapple_integrator::math::PixelRect { x0: 0, y0: 0, x1: 3, y1: 2 };
        for other in [
            Settings { crop: Some(crop), ..plain.clone() },
            Settings { seed: 7, pattern: Pattern::Random, ..plain.clone() }.with_spp(1),
            plain.clone().with_method(MethodKind::Distribution).with_threads(1),
            Settings { size: (400, 400), ..plain.clone() },
        ] {
            assert_eq!(meter(&other), at);
        }
        assert_ne!(meter(&Settings { max_bounces: 0, ..plain }), at);
    }
}
