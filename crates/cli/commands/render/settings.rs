//! Settings of the integrator from the options of a render.

use crate::error::Failure;
use crate::options::RenderOptions;
use crate::{effects, load, machine};
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::NamedCamera;
use dapple_integrator::{MethodKind, Settings, SettingsError};

/// Converts the options to settings of the integrator.
pub fn settings(options: &RenderOptions, view: &NamedCamera) -> Result<Settings, Failure> {
    let size = load::size(options, view);
    let default = Settings::default();
    let mut settings = Settings {
        size: (size.width, size.height),
        crop: load::rect(options, size)?,
        pattern: options.pattern.unwrap_or_default(),
        max_bounces: options.max_bounces.unwrap_or(default.max_bounces),
        seed: options.seed.unwrap_or(0),
        filter: options.filter.unwrap_or_default(),
        aovs: options.layers(),
        picture: options.shows_picture(),
        general: options.is_general(),
        clamp: options.clamp,
        soft_terminator: !RenderOptions::is(options.no_soft_terminator),
        transparent_shadows: RenderOptions::is(options.transparent_shadows),
        transparent: RenderOptions::is(options.transparent),
        backfaces: options.backfaces(),
        ..default
    }
    .with_method(options.method.unwrap_or_default())
    .with_time_limit(options.time_limit)
    .with_threads(machine::threads(options.threads))
    .with_spp(options.samples())
    .with_path(|p| p.roulette = !RenderOptions::is(options.no_roulette))
    .with_path(|p| p.adaptive = RenderOptions::is(options.adaptive));
    effects::apply(options, &mut settings);
    restrict(options, &mut settings)?;
    if options.error_limit.is_some() {
        settings = settings.with_distribution(|d| d.rounds = 0..u32::MAX);
    }
    check(&settings, options)?;
    Ok(settings)
}

/// Restricts the samples to those of `--samples`.
fn restrict(options: &RenderOptions, settings: &mut Settings) -> Result<(), Failure> {
    let Some(range) = options.long.samples else { return Ok(()) };
    let wrong = |why: String| Failure::Arguments(format!("--samples {range}: {why}"));
    if options.error_limit.is_some() {
        return Err(wrong("the samples are given; leave out --error-limit".into()));
    }
    let (is_path, pattern) = (settings.kind() == MethodKind::Path, settings.pattern);
    let of = match options.spp {
        _ if !is_path => settings.round(),
        Some(spp) => spp,
        None if matches!(pattern, Pattern::Stratified | Pattern::Grid) => {
            return Err(wrong(format!(
                "{pattern} points are a set of a fixed size; give the size of the whole set with --spp"
            )));
        }
        // The order of the first Sobol points depends on the size of smaller sets.
        None => range.end.max(LEAST_SET),
    };
    if range.end > of {
        let whole = if is_path { format!("--spp {of}") } else { format!("--pixel {of}") };
        return Err(wrong(format!("there are only {of} samples per pixel ({whole})")));
    }
    let samples = range.start..range.end;
    settings.path_tracer_mut().into_iter().for_each(|path| {
        (path.samples, path.of) = (samples.clone(), Some(of));
    });
    settings.distribution_tracer_mut().into_iter().for_each(|distribution| {
        distribution.samples = Some(samples.clone());
    });
    Ok(())
}

/// Smallest set to which the samples of a part belong, unless --spp is given.
const LEAST_SET: u32 = 16;

/// Checks the settings; an error names the options that it comes from.
fn check(settings: &Settings, options: &RenderOptions) -> Result<(), Failure> {
    if RenderOptions::is(options.adaptive) && settings.kind() == MethodKind::Distribution {
        let said =
            "--adaptive: the distribution tracer gives every pixel the same samples; use --method path";
        return Err(Failure::Arguments(said.into()));
    }
    // The shares of an adaptive part are computed from pilot samples of the full frame.
    let is_part = options.long.samples.is_some() && settings.adaptive();
    let checked = match is_part {
        true => settings.clone().with_path(|p| p.samples.start = 0),
        false => settings.clone(),
    };
    Settings { crop: settings.crop.filter(|_| !is_part), ..checked }.check().map_err(|error| {
        let option = match &error {
            SettingsError::AdaptivePattern(pattern) => format!("--adaptive with --pattern {pattern}: "),
            SettingsError::AdaptiveCrop => "--adaptive with --crop: ".to_string(),
            SettingsError::Paired { effect, .. } => format!("--{effect}: "),
            SettingsError::Crop(_) => "--crop: ".to_string(),
            SettingsError::Size(..) => "--size: ".to_string(),
            _ => String::new(),
        };
        Failure::Arguments(format!("{option}{error}"))
    })
}
