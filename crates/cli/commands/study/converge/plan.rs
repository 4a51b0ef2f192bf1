//! The runs of a comparison: their options, and keys of the runs whose images should be equal.

use super::folder::plain;
use crate::args::study::ConvergeArgs;
use crate::commands::render;
use crate::error::{self, Failure};
use crate::layer;
use crate::load;
use crate::options::{OfScene, RenderOptions};
use crate::uses;
use crate::values::Size;
use dapple_analysis::converge::Run;
use dapple_integrator::MethodKind;
use dapple_integrator::sampling::SampleSet;
use dapple_integrator::scene::Scene;
use std::ffi::OsString;

/// Default height in pixels: errors are means over all pixels, so a small image suffices.
const HEIGHT: f32 = 96.0;

/// Default scattering events if runs of the distribution tracer take part: that of the distribution tracer.
const BOUNCES: u32 = 5;

/// A requested run.
pub struct Planned {
    pub run: Run,
    /// Its options, as text.
    pub text: String,
    /// Key of everything that changes its images or times.
    pub key: String,
    /// Key of everything that changes its expected image.
    pub look: String,
}

/// Returns the typed runs, or the default ones, on top of `base`.
pub fn runs(arguments: &ConvergeArgs, base: &RenderOptions, scene: &Scene) -> Result<Vec<Planned>, Failure> {
    let typed = arguments.runs.iter().map(|run| split(run)).collect::<Result<Vec<_>, _>>()?;
    let named = if typed.is_empty() { default_runs(base) } else { typed };
    names(&named)?;
    let mut options = Vec::new();
    for (name, text) in &named {
        options.push(laid(base, name, text)?);
    }
    let distribution = options.iter().any(|o| o.method == Some(MethodKind::Distribution));
    if distribution && base.max_bounces.is_none() {
        options.iter_mut().for_each(|o| o.max_bounces = o.max_bounces.or(Some(BOUNCES)));
    }
    let planned = named.into_iter().zip(options);
    planned.map(|((name, text), options)| one(arguments, name, text, options, scene)).collect()
}

fn one(
    arguments: &ConvergeArgs,
    name: String,
    text: String,
    mut options: RenderOptions,
    scene: &Scene,
) -> Result<Planned, Failure> {
    let in_run = |e: Failure| Failure::Arguments(format!("--run {name}: {e}"));
    let view = load::camera(scene, &options).map_err(in_run)?;
    if options.size.is_none() {
        let Size { width, height } = load::size(&options, &view);
        let width = (HEIGHT * width as f32 / height as f32).round().max(1.0) as u32;
        options.size = Some(Size { width, height: HEIGHT as u32 });
    }
    let settings = render::settings(&options, &view).map_err(in_run)?;
    let vary = arguments.vary;
    if settings.kind() == MethodKind::Distribution && settings.plans.is_off(vary) {
        let said = format!("--run {name}: --vary {vary}: this effect is off in this run");
        return Err(Failure::Arguments(said));
    }
    // Errors depend on the reference.
    let reference = (&arguments.reference, arguments.shared_reference);
    let scene_name = format!("{} {vary} {reference:?}", arguments.scenes.join(" "));
    let (key, look) = (key(&scene_name, &of_result(&options)), key("", &of_look(&options)));
    Ok(Planned { run: Run { name, camera: view.camera, settings, vary }, text, key, look })
}

/// Fails unless the names of all runs, and of their files, differ from one another and from those of references.
fn names(named: &[(String, String)]) -> Result<(), Failure> {
    for (i, (name, _)) in named.iter().enumerate() {
        let wrong = |why: &str| Err(Failure::Arguments(format!("--run {name}: {why}")));
        if named[..i].iter().any(|(other, _)| plain(other) == plain(name)) {
            return wrong("the name is used twice");
        }
        if name.starts_with("reference") {
            return wrong("the name is reserved for images of references; use another name");
        }
    }
    Ok(())
}

/// Parses `NAME: OPTIONS`.
fn split(text: &str) -> Result<(String, String), Failure> {
    let (name, options) = text.split_once(':').unwrap_or((text, ""));
    let name = name.trim();
    if name.is_empty() || name.starts_with('-') {
        return Err(Failure::Arguments(format!(
            "--run '{}': write it as 'NAME: OPTIONS'",
            error::short(text)
        )));
    }
    Ok((name.into(), options.trim().into()))
}

/// Returns the default runs: both tracers, each with three patterns. In runs of the distribution tracer all integrals
/// grow together, with one sample of each per pixel sample; those that `base` sets are kept.
fn default_runs(base: &RenderOptions) -> Vec<(String, String)> {
    let path = ["random", "stratified", "sobol"]
        .map(|p| (format!("path-{p}"), format!("--method path --pattern {p}")));
    let e = &base.effects;
    let given = [e.lens, e.time, e.light, e.glossy, e.refract, e.diffuse];
    let names = ["lens", "time", "light", "glossy", "refract", "diffuse"];
    let distribution = ["grid", "random", "stratified"].map(|p| {
        let free = names.iter().zip(given).filter(|(_, plan)| plan.is_none());
        let plans: String = free.map(|(name, _)| format!(" --{name} 1:{p}")).collect();
        let options = format!("--method distribution --combine paired --pixel 1:{p}{plans}");
        (format!("dist-{p}"), options)
    });
    path.into_iter().chain(distribution).collect()
}

/// Returns `base` overridden with a run's options.
fn laid(base: &RenderOptions, name: &str, text: &str) -> Result<RenderOptions, Failure> {
    let mut options = base.clone();
    let in_run = |e: Failure| Failure::Arguments(format!("--run {name}: {e}"));
    let typed = layer::parsed(&words(text)).map_err(in_run)?;
    uses::refuse("converge", &typed).map_err(in_run)?;
    options.apply_matches(&typed).map_err(in_run)?;
    if format!("{:?}", of_scene(base)) != format!("{:?}", of_scene(&options)) {
        let said = "size, crop, environment, light unit, time, exposure and output are the same for all runs; give \
                    them outside of --run";
        return Err(in_run(Failure::Arguments(said.into())));
    }
    if options.spp.is_some() || options.time_limit.is_some() || options.seed.is_some() {
        let said = "--spp, --time-limit and --seed: not available in --run, because converge varies them";
        return Err(in_run(Failure::Arguments(said.into())));
    }
    Ok(options)
}

/// Splits text at spaces; quotes of either kind keep spaces together.
fn words(text: &str) -> Vec<OsString> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in text.chars() {
        match (c, quote) {
            (c, Some(q)) if c == q => quote = None,
            (c, Some(_)) => word.get_or_insert_default().push(c),
            ('"' | '\'', None) => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (c, None) if c.is_whitespace() => words.extend(word.take()),
            (c, None) => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    words.into_iter().map(OsString::from).collect()
}

/// Options that determine how a scene is loaded, and options shared by a whole report.
fn of_scene(o: &RenderOptions) -> impl std::fmt::Debug {
    let environment =
        (o.env.clone(), o.env_color, o.env_rotation, o.env_intensity, o.is_env_smooth(), o.light_unit);
    let told =
        (o.output.clone(), o.json, o.quiet, o.threads, o.exposure, o.tone.map(|tone| format!("{tone:?}")));
    (o.size, o.crop, o.at, o.choice.clone(), o.allow_path, environment, told)
}

/// Removes options that change neither images nor times.
fn of_result(o: &RenderOptions) -> RenderOptions {
    RenderOptions {
        output: None,
        json: None,
        quiet: None,
        verbose: None,
        half: None,
        settings: None,
        of_scene: OfScene::default(),
        ..o.clone()
    }
}

/// Removes options that do not change the expected image: method, samples, and Russian roulette.
fn of_look(o: &RenderOptions) -> RenderOptions {
    let mut look = of_result(o);
    (look.method, look.pattern, look.no_roulette, look.threads) = (None, None, None, None);
    look.adaptive = None;
    let e = &mut look.effects;
    (e.combine, e.secondary, e.yes) = (None, None, None);
    let plans =
        [&mut e.pixel, &mut e.lens, &mut e.time, &mut e.light, &mut e.glossy, &mut e.refract, &mut e.diffuse];
    for plan in plans {
        *plan = plan.filter(|p| p.count() == 0).map(|_| SampleSet::OFF);
    }
    look
}

/// Hashes all options to a short key (FNV-1a).
fn key(scene: &str, options: &RenderOptions) -> String {
    let bytes = format!("{scene} {options:?}").into_bytes();
    let hash = bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3));
    format!("{hash:016x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_names_and_words() {
        let (name, options) = split("path sobol: --method path --pixel 4x4:grid").unwrap();
        assert_eq!((name.as_str(), options.as_str()), ("path sobol", "--method path --pixel 4x4:grid"));
        assert!(split("--method path").is_err() && split(": --spp 3").is_err());
        assert_eq!(split("plain").unwrap().1, "");
        assert_eq!(words(" a  'b c' d\"e f\" '' "), ["a", "b c", "de f", ""]);
    }

    #[test]
    fn what_is_to_be_seen_has_a_key() {
        let base = RenderOptions::default();
        let look = |text: &str| key("", &of_look(&laid(&base, "x", text).unwrap()));
        let same = look("");
        for text in
            ["--method path --pattern random", "--method distribution --light 3x3:grid", "--no-roulette"]
        {
            assert_eq!(look(text), same, "{text}");
        }
        for text in ["--max-bounces 2", "--light 0", "--filter tent", "--aperture-radius 1", "--camera 1"] {
            assert_ne!(look(text), same, "{text}");
        }
        for text in ["--size 3x3", "--spp 3", "--seed 1", "--env-color 1,1,1", "--nonsense", "--method guess"]
        {
            let said = laid(&base, "mine", text).unwrap_err().to_string();
            assert!(said.contains("mine"), "{said}");
        }
    }

    #[test]
    fn all_default_runs_can_be_had() {
        let mut base = RenderOptions::default();
        base.effects.light = Some(SampleSet::OFF);
        let runs = default_runs(&base);
        assert_eq!(runs.len(), 6);
        for (name, text) in runs {
            assert!(!text.contains("--light"));
            laid(&base, &name, &text).unwrap();
        }
    }
}
