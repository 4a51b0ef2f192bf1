//! Conversion of the effect options to sample sets and a lens, with notes about options without effect.

use crate::error::Failure;
use crate::idle;
use crate::options::{EffectOptions, RenderOptions};
use crate::say::say;
use dapple_integrator::camera::{Aperture, Camera, Lens};
use dapple_integrator::first_hit::centre_depth;
use dapple_integrator::sampling::{Pattern, SampleSet};
use dapple_integrator::scene::Scene;
use dapple_integrator::{Combine, Effect, MethodKind, SampleSets, Settings, forecast};
use std::io::{BufRead, IsTerminal};

/// Maximum number of scattering events of the distribution tracer; the path tracer follows more.
pub const DISTRIBUTION_BOUNCES: u32 = 5;

/// Rays per pixel above which the user has to confirm.
const MANY_RAYS: f64 = 1e5;

impl EffectOptions {
    /// Returns the sample set given for an effect.
    fn plan(&self, effect: Effect) -> Option<SampleSet> {
        match effect {
            Effect::Pixel => self.pixel,
            Effect::Lens => self.lens,
            Effect::Time => self.time,
            Effect::Light => self.light,
            Effect::Glossy => self.glossy,
            Effect::Refract => self.refract,
            Effect::Diffuse => self.diffuse,
        }
    }

    /// Returns the sample set given for an effect, mutably.
    pub fn plan_mut(&mut self, effect: Effect) -> &mut Option<SampleSet> {
        match effect {
            Effect::Pixel => &mut self.pixel,
            Effect::Lens => &mut self.lens,
            Effect::Time => &mut self.time,
            Effect::Light => &mut self.light,
            Effect::Glossy => &mut self.glossy,
            Effect::Refract => &mut self.refract,
            Effect::Diffuse => &mut self.diffuse,
        }
    }
}

/// Adds the requested lens to a camera; without a focus distance, the surface at the image centre is in focus.
pub fn with_lens(mut camera: Camera, scene: &Scene, options: &RenderOptions) -> Camera {
    let backfaces = options.backfaces();
    let options = &options.effects;
    let radius = options.aperture_radius.unwrap_or(0.0);
    if radius == 0.0 {
        return camera;
    }
    let focus = options.focus_distance.map(|d| scene.space.length_to_render(f64::from(d)));
    let focus = focus.unwrap_or_else(|| {
        let distance = centre_depth(scene, &camera, backfaces).unwrap_or(f32::INFINITY);
        say(&format!(
            "note: focus distance {:.4}, at the image centre",
            scene.space.length_to_world(f64::from(distance))
        ));
        distance
    });
    camera.lens = Some(Lens {
        aperture: options.aperture_shape.unwrap_or(Aperture::Disk),
        radius: scene.space.length_to_render(f64::from(radius)),
        focus_distance: focus,
    });
    camera
}

/// Applies the sample sets, their combination and the ambient light to `settings`.
pub fn apply(options: &RenderOptions, settings: &mut Settings) {
    let effects = &options.effects;
    let mut plans = SampleSets::default();
    let combine = effects.combine.unwrap_or_default();
    for (effect, _) in Effect::ALL {
        if let Some(plan) = effects.plan(effect) {
            *plans.of_mut(effect) = plan;
        }
    }
    if let (MethodKind::Distribution, None, Some(spp)) = (settings.kind(), effects.pixel, options.spp) {
        plans.pixel = SampleSet::new(spp, Pattern::Stratified);
    }
    if combine == Combine::Paired && settings.kind() == MethodKind::Distribution {
        let n = plans.pixel.count().max(1);
        let open = Effect::ALL.iter().filter(|(effect, _)| effects.plan(*effect).is_none());
        for (effect, _) in open.filter(|(effect, _)| *effect != Effect::Pixel) {
            let plan = plans.of_mut(*effect);
            *plan = if plan.count() == n { *plan } else { SampleSet::new(n, plan.pattern) };
        }
    }
    settings.plans = plans;
    if let Some(distribution) = settings.distribution_tracer_mut() {
        distribution.combine = combine;
        distribution.secondary = effects.secondary.unwrap_or(1);
    }
    settings.ambient = effects.ambient.map_or(glam::Vec3::ZERO, |c| c.0);
    if settings.kind() == MethodKind::Distribution {
        settings.max_bounces = options.max_bounces.unwrap_or(DISTRIBUTION_BOUNCES);
    }
}

/// Prints a note about each given option without effect.
pub fn note_idle(options: &RenderOptions, settings: &Settings, scene: &Scene, camera: &Camera) {
    let effects = &options.effects;
    let note = |what: &str, why: &str| say(&format!("note: {what} is ignored: {why}"));
    let present = dapple_integrator::forecast::present_in(scene, camera, settings);
    let path = settings.kind() == MethodKind::Path;
    for (effect, name) in Effect::ALL {
        match effects.plan(effect) {
            None => {}
            Some(_) if !present.contains(&effect) => {
                note(&format!("--{name}"), "the scene has no such effect")
            }
            Some(plan) if path && plan.count() > 0 => {
                note(&format!("--{name}"), "the path tracer samples all effects together; see --spp");
            }
            Some(_) => {}
        }
    }
    if effects.light.is_some_and(|plan| plan.count() == 0) && scene.environment.is_some() {
        say("note: --light 0 does not affect the environment");
    }
    if effects.ambient.is_some() && !settings.plans.is_off(Effect::Diffuse) {
        note("--ambient", "it replaces interreflection, which is on; see --diffuse 0");
    }
    if !path && options.spp.is_some() && effects.pixel.is_some() {
        note("--spp", "--pixel sets the samples per pixel");
    }
    if !path && options.pattern.is_some() {
        note("--pattern", "each effect sets its own pattern, as in --pixel 4x4:sobol");
    }
    if options.effects.aperture_radius.unwrap_or(0.0) == 0.0
        && (effects.focus_distance.is_some() || effects.aperture_shape.is_some())
    {
        say("note: the lens has no radius, so everything is in focus; see --aperture-radius");
    }
    idle::of_render(options, settings, scene).iter().for_each(|(what, why)| note(what, why));
}

/// Prints the maximum number of rays per pixel; a large number needs the user's confirmation.
pub fn confirm(
    options: &RenderOptions,
    settings: &Settings,
    scene: &Scene,
    camera: &Camera,
) -> Result<(), Failure> {
    if settings.kind() == MethodKind::Path {
        return Ok(());
    }
    let rays = forecast(scene, camera, settings).total();
    if !RenderOptions::is(options.quiet) {
        say(&format!("at most {rays:.0} rays per pixel"));
    }
    if rays <= MANY_RAYS || RenderOptions::is(options.effects.yes) {
        return Ok(());
    }
    if std::io::stdin().is_terminal() && std::io::stderr().is_terminal() {
        say("this is a large number; render anyway? [y/N]");
        let mut answer = String::new();
        let read = std::io::stdin().lock().read_line(&mut answer);
        if read.is_ok() && answer.trim().eq_ignore_ascii_case("y") {
            return Ok(());
        }
    }
    Err(Failure::Arguments(format!(
        "a pixel takes up to {rays:.0} rays, more than {MANY_RAYS:.0}: lower the counts, use --combine paired, or confirm \
         with --yes"
    )))
}
