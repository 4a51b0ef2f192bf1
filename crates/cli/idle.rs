//! Detection of options without effect for the chosen method, pattern, outputs or scene. These are not errors, because
//! they may come from a settings file or a script that serves many scenes, but each produces a note.

use crate::options::{NO_ENVIRONMENT, RenderOptions};
use dapple_integrator::lights::Light;
use dapple_integrator::scene::Scene;
use dapple_integrator::{Combine, Effect, MethodKind, Settings};
use std::path::Path;

/// Options without effect, each with the reason.
pub type Idle = Vec<(&'static str, String)>;

/// Returns the options that have no effect in a render with these settings.
pub fn of_render(options: &RenderOptions, settings: &Settings, scene: &Scene) -> Idle {
    let mut idle = of_outputs(options);
    idle.extend(of_method(options, settings));
    idle.extend(of_environment(options));
    idle.extend(of_scene(options, scene));
    idle
}

/// Returns options of file formats that are not written.
pub fn of_outputs(options: &RenderOptions) -> Idle {
    let writes = |extension: &str| match &options.output {
        None => extension == "exr" || (extension == "png" && options.shows_picture()),
        Some(paths) => paths.iter().any(|path| is(path, extension)),
    };
    let mut idle = Idle::new();
    let mut say = |is_idle: bool, name, why: &str| {
        if is_idle {
            idle.push((name, why.into()));
        }
    };
    say(RenderOptions::is(options.half) && !writes("exr"), "--half", "no EXR is written");
    say(
        options.aov.is_some() && !writes("exr") && !writes("part"),
        "--aov",
        "layers are written to EXR, and none is written",
    );
    say(options.exposure.is_some() && !writes("png"), "--exposure", "no PNG is written");
    say(options.tone.is_some() && !writes("png"), "--tone", "no PNG is written");
    say(options.png_depth.is_some() && !writes("png"), "--png-depth", "no PNG is written");
    idle
}

fn is(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// Returns options of the other tracer, or of a mode of this tracer that is not used.
fn of_method(options: &RenderOptions, settings: &Settings) -> Idle {
    let mut idle = Idle::new();
    let mut say = |is_idle: bool, name, why: &str| {
        if is_idle {
            idle.push((name, why.into()));
        }
    };
    let effects = &options.effects;
    match settings.kind() {
        MethodKind::Path => {
            let why = "the path tracer samples all effects together; see --method distribution";
            say(effects.combine.is_some(), "--combine", why);
            say(effects.secondary.is_some(), "--secondary", why);
        }
        MethodKind::Distribution => {
            let why = "the distribution tracer uses no Russian roulette; see --max-bounces";
            say(RenderOptions::is(options.no_roulette), "--no-roulette", why);
            let paired = settings.combine() == Combine::Paired;
            let why = "with --combine paired, every integral has one sample per pixel sample";
            say(effects.secondary.is_some() && paired, "--secondary", why);
        }
    }
    let centre = settings.plans.is_off(Effect::Pixel);
    say(options.filter.is_some() && centre, "--filter", "--pixel 0 samples only pixel centres");
    let limited = options.max_bounces == Some(0) && settings.kind() == MethodKind::Path;
    say(RenderOptions::is(options.no_roulette) && limited, "--no-roulette", "no path is continued");
    idle
}

/// Returns options of an environment that does not exist.
fn of_environment(options: &RenderOptions) -> Idle {
    let none = Path::new(NO_ENVIRONMENT);
    let picture = options.env.as_deref().is_some_and(|env| env != none);
    let color = options.env_color.is_some();
    let mut idle = Idle::new();
    let why = match color {
        true => "--env-color is the same in all directions",
        false => "there is no environment map; see --env",
    };
    if !picture && options.env_rotation.is_some() {
        idle.push(("--env-rotation", why.into()));
    }
    if !picture && options.env_smooth.is_some() {
        idle.push(("--env-smooth", why.into()));
    }
    if !picture && options.env_nearest.is_some() {
        idle.push(("--env-nearest", why.into()));
    }
    if !picture && !color && options.env_intensity.is_some() {
        idle.push(("--env-intensity", "no environment is given; see --env and --env-color".into()));
    }
    idle
}

/// Returns options about motion, materials and lights that the scene does not have.
fn of_scene(options: &RenderOptions, scene: &Scene) -> Idle {
    let mut idle = Idle::new();
    if options.shutter.is_some_and(|s| s.close > s.open) && !scene.survey.has_motion {
        idle.push(("--shutter", "nothing moves during the shutter interval".into()));
    }
    if RenderOptions::is(options.transparent_shadows) && !scene.survey.has_transmission {
        idle.push(("--transparent-shadows", "the scene has no glass".into()));
    }
    let punctual = |light: &Light| {
        matches!(light, Light::Point(_) | Light::Spot(_) | Light::Distant(_) | Light::Moving(_))
    };
    if options.light_unit.is_some() && !scene.lights.iter().any(punctual) {
        idle.push(("--light-unit", "the scene has no point, spot or directional light".into()));
    }
    idle
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_integrator::sampling::SampleSet;
    use dapple_integrator::scene::builtin;

    fn names(typed: &[&str]) -> String {
        let mut options = RenderOptions::default();
        let typed: Vec<std::ffi::OsString> = typed.iter().map(Into::into).collect();
        options.apply(&typed).unwrap();
        let mut settings = Settings::default().with_method(options.method.unwrap_or_default());
        settings = settings.with_distribution(|d| d.combine = options.effects.combine.unwrap_or_default());
        settings.plans.pixel = options.effects.pixel.unwrap_or(SampleSet::new(1, Default::default()));
        let scene = builtin::builtin("cornell").unwrap().build().unwrap();
        let found = of_render(&options, &settings, &scene);
        found.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn what_changes_nothing_is_found() {
        for (typed, idle) in [
            (&[][..], ""),
            (&["--half", "--tone=agx", "--exposure=1", "--aov=depth,beauty"], ""),
            (&["--half", "--aov=depth", "--output=a.png"], "--half --aov"),
            (&["--tone=agx", "--exposure=1", "--output=a.exr"], "--exposure --tone"),
            (&["--tone=agx", "--output=a.PNG"], ""),
            (&["--combine=paired", "--secondary=2"], "--combine --secondary"),
            (&["--method=distribution", "--secondary=2"], ""),
            (&["--method=distribution", "--secondary=2", "--combine=paired"], "--secondary"),
            (&["--method=distribution", "--no-roulette"], "--no-roulette"),
            (&["--no-roulette"], ""),
            (&["--pixel=0", "--filter=tent"], "--filter"),
            (
                &["--env-rotation=9", "--env-intensity=2", "--env-smooth"],
                "--env-rotation --env-smooth --env-intensity",
            ),
            (&["--env=a.exr", "--env-rotation=9", "--env-intensity=2", "--env-smooth"], ""),
            (&["--env-color=1,1,1", "--env-rotation=9", "--env-intensity=2"], "--env-rotation"),
            (&["--env=none", "--env-rotation=9"], "--env-rotation"),
            (&["--shutter=0:1", "--transparent-shadows"], "--shutter --transparent-shadows"),
            (&["--shutter=1:1", "--env=a.exr", "--env-nearest"], ""),
            (&["--env-nearest", "--light-unit=auto"], "--env-nearest --light-unit"),
            (&["--png-depth=16", "--transparent", "--output=a.exr"], "--png-depth"),
            (&["--png-depth=16", "--transparent", "--output=a.hdr"], "--png-depth"),
        ] {
            assert_eq!(names(typed), idle, "{typed:?}");
        }
    }
}
