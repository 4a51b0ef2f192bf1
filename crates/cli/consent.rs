//! Limits on the work that a settings file beside a scene (a sidecar) may request without the user's consent.
//!
//! A sidecar may set how a scene is sampled ([`crate::settings_file`]), so without limits of its own it could make a
//! render run without end. The same option on the command line, or `--yes`, lifts the limit.

use crate::error::Failure;
use crate::options::{OfScene, RenderOptions};
use crate::say::say;
use crate::uses;
use dapple_integrator::camera::Camera;
use dapple_integrator::scene::Scene;
use dapple_integrator::{Effect, MethodKind, Settings, forecast};
use std::time::Duration;

/// Longest time that a sidecar may request.
const LONGEST: Duration = Duration::from_secs(3600);

/// Most scattering events that a sidecar may request.
const MANY_BOUNCES: u32 = 1 << 16;

/// Most rays, by the forecast's upper bound, of an image whose size or samples a sidecar sets: some hours of rendering.
const MANY_RAYS: f64 = 1e11;

/// Keys that affect the number of rays, beside the names of the effects.
const OF_RAYS: [&str; 6] = ["spp", "size", "max-bounces", "method", "combine", "secondary"];

impl OfScene {
    fn refuse(&self, keys: &[&str], why: &str) -> Failure {
        let named =
            |prefix: &str| keys.iter().map(|key| format!("{prefix}{key}")).collect::<Vec<_>>().join(", ");
        let yes = if uses::serves(&self.command, "yes") { ", or confirm with --yes" } else { "" };
        let (path, key) = (self.file.clone(), named(""));
        let reason = format!(
            "{why}, more than a settings file beside the scene may request; set it on the command line ({}){yes}",
            named("--")
        );
        Failure::SettingsKey { path, key, reason }
    }
}

/// Refuses values of the sidecar beyond the limits, and sets [`LONGEST`] as the time limit of a render that only a
/// sidecar's error limit would end.
pub fn of_values(options: &mut RenderOptions) -> Result<(), Failure> {
    let (scene, renders) = (&options.of_scene, ["render", "budget", "sheet", "converge"]);
    if RenderOptions::is(options.effects.yes) || !renders.contains(&scene.command.as_str()) {
        return Ok(());
    }
    let longest = LONGEST.as_secs();
    if let Some(limit) = options.time_limit.filter(|limit| scene.set("time-limit") && *limit > LONGEST) {
        return Err(scene.refuse(&["time-limit"], &format!("{} s exceeds {longest} s", limit.as_secs())));
    }
    if let Some(n) = options.max_bounces.filter(|n| scene.set("max-bounces") && *n > MANY_BOUNCES) {
        return Err(scene.refuse(&["max-bounces"], &format!("{n} exceeds {MANY_BOUNCES}")));
    }
    let is_endless = options.spp.is_none() && options.time_limit.is_none();
    if scene.command == "render" && scene.set("error-limit") && is_endless {
        say(&format!(
            "note: {}: error-limit: the render ends after {longest} s at the latest; set --error-limit, --time-limit \
             or --yes on the command line to go further",
            scene.file.display()
        ));
        options.time_limit = Some(LONGEST);
    }
    Ok(())
}

/// Refuses an image that takes too many rays because of the sidecar's settings.
pub fn of_rays(
    options: &RenderOptions,
    settings: &Settings,
    scene: &Scene,
    camera: &Camera,
) -> Result<(), Failure> {
    let file = &options.of_scene;
    let effects = Effect::ALL.iter().map(|(_, name)| *name);
    let keys: Vec<&str> = OF_RAYS.into_iter().chain(effects).filter(|key| file.set(key)).collect();
    let is_limited = options.time_limit.is_some() || RenderOptions::is(options.effects.yes);
    if is_limited || keys.is_empty() {
        return Ok(());
    }
    let pixels = settings.rect().area() as f64;
    let (rays, own) = match settings.kind() {
        MethodKind::Path => (path_rays(pixels, settings), own_rays(pixels, file, settings)),
        MethodKind::Distribution => (forecast(scene, camera, settings).total() * pixels, 0.0),
    };
    match rays > MANY_RAYS.max(own) {
        true => Err(file.refuse(&keys, &format!("the image takes up to {rays:.0e} rays"))),
        false => Ok(()),
    }
}

/// Upper bound of the path tracer's rays: at every vertex one continuation ray and one shadow ray.
fn path_rays(pixels: f64, settings: &Settings) -> f64 {
    pixels * f64::from(settings.spp().unwrap_or(0)) * 2.0 * (1.0 + f64::from(settings.max_bounces))
}

/// As [`path_rays`], with the defaults in place of the sidecar's values: the work that the user requested.
fn own_rays(pixels: f64, file: &OfScene, settings: &Settings) -> f64 {
    let default = Settings::default();
    let spp = if file.set("spp") { Some(64) } else { settings.spp() };
    let max_bounces = if file.set("max-bounces") { default.max_bounces } else { settings.max_bounces };
    let pixels = if file.set("size") { pixels.min(512.0 * 512.0) } else { pixels };
    path_rays(pixels, &Settings { max_bounces, ..default }.with_spp(spp))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laid(keys: &str, typed: &[&str]) -> RenderOptions {
        let mut options = RenderOptions::default();
        let words = keys.split(' ').map(|word| format!("--{word}").into()).collect::<Vec<_>>();
        options.apply(&words).unwrap();
        let keys = keys.split(' ').map(|word| word.split('=').next().unwrap_or_default().into()).collect();
        options.of_scene = OfScene { file: "s.toml".into(), command: "render".into(), keys };
        options.apply(&typed.iter().map(Into::into).collect::<Vec<_>>()).unwrap();
        options
    }

    #[test]
    fn the_users_word_goes_further() {
        for (keys, word) in
            [("time-limit=1000h", "--time-limit=1000h"), ("max-bounces=65537", "--max-bounces=65537")]
        {
            let said = of_values(&mut laid(keys, &[])).unwrap_err().to_string();
            let name = word.split('=').next().unwrap();
            assert!(
                said.starts_with("s.toml: key '") && said.contains(name) && said.contains("--yes"),
                "{said}"
            );
            for typed in [word, "--yes"] {
                assert!(of_values(&mut laid(keys, &[typed])).is_ok(), "{typed}");
            }
        }
        assert!(of_values(&mut laid("time-limit=60m max-bounces=65536", &[])).is_ok());
    }

    #[test]
    fn an_error_alone_ends_in_time() {
        for (keys, typed, limit) in [
            ("error-limit=1e-9", "--seed=1", Some(LONGEST)),
            ("error-limit=1e-9", "--error-limit=1e-9", None),
            ("error-limit=1e-9", "--yes", None),
            ("error-limit=1e-9", "--time-limit=9h", Some(9 * LONGEST)),
            ("error-limit=1e-9 spp=4", "--seed=1", None),
        ] {
            let mut options = laid(keys, &[typed]);
            of_values(&mut options).unwrap();
            assert_eq!(options.time_limit, limit, "{keys} {typed}");
        }
    }

    #[test]
    fn commands_that_render_nothing_ask_nothing() {
        let mut options = laid("time-limit=1000h", &[]);
        options.of_scene.command = "rays".into();
        assert!(of_values(&mut options).is_ok());
    }
}
