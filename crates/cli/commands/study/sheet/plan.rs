//! Planned cells of a sheet: the options that all of them have in common, and the settings of each.

use super::reference::Given;
use crate::args::study::SheetArgs;
use crate::commands::render;
use crate::effects;
use crate::error::Failure;
use crate::load;
use crate::options::RenderOptions;
use crate::values::Size;
use dapple_integrator::sampling::sample_set::MAX_COUNT;
use dapple_integrator::sampling::{Pattern, SampleSet};
use dapple_integrator::scene::NamedCamera;
use dapple_integrator::{Combine, Effect, MethodKind, Settings};

/// Default height of a cell.
const HEIGHT: u32 = 256;

/// Samples over lights and environment per sample of a varied integral over directions.
const FINER: u32 = 4;

/// One cell before it is rendered.
pub struct Planned {
    pub count: u32,
    pub pattern: Pattern,
    pub settings: Settings,
}

/// Returns the common options of all cells: distribution tracer, effects that no option mentions off, small images.
pub fn common(
    mut options: RenderOptions,
    vary: Effect,
    view: &NamedCamera,
    reference: Option<&Given<'_>>,
) -> RenderOptions {
    options.method = Some(MethodKind::Distribution);
    options.aov = None;
    // The two tracers have different defaults.
    options.max_bounces = options.max_bounces.or(Some(effects::DISTRIBUTION_BOUNCES));
    let paired = options.effects.combine == Some(Combine::Paired);
    let blurred = matches!(vary, Effect::Glossy | Effect::Refract);
    for (effect, _) in Effect::ALL {
        let keeps = paired
            || (effect == Effect::Light && blurred)
            || (effect == Effect::Pixel && options.spp.is_some());
        if effect != vary && !keeps {
            options.effects.plan_mut(effect).get_or_insert(SampleSet::OFF);
        }
    }
    let size = match reference {
        Some(files) if options.crop.is_none() => {
            let (width, height) = files.size();
            Size { width, height }
        }
        _ => load::default_size(view, HEIGHT),
    };
    options.size.get_or_insert(size);
    options
}

/// Returns the cells row by row: `common` are their common options, and `asked` those that were given.
pub fn cells(
    arguments: &SheetArgs,
    asked: &RenderOptions,
    common: &RenderOptions,
    view: &NamedCamera,
) -> Result<Vec<Planned>, Failure> {
    let vary = arguments.vary;
    // Lights and environment are refined for integrals over directions, unless an option mentions them.
    let inner = matches!(vary, Effect::Glossy | Effect::Refract | Effect::Diffuse);
    let refined = inner && asked.effects.light.is_none();
    let of = |pattern: Pattern, count: u32| {
        let mut options = common.clone();
        *options.effects.plan_mut(vary) = Some(SampleSet::new(count, pattern));
        if options.effects.combine == Some(Combine::Paired) {
            for (effect, _) in Effect::ALL {
                options.effects.plan_mut(effect).get_or_insert(SampleSet::new(1, pattern));
            }
        }
        let mut settings = render::settings(&options, view)?;
        if refined && settings.combine() != Combine::Paired {
            refine(&mut settings, count);
        }
        Ok(Planned { count, pattern, settings })
    };
    let rows = arguments.estimators.iter();
    rows.flat_map(|&pattern| arguments.counts.iter().map(move |&n| of(pattern, n))).collect()
}

/// For an integral over directions of `count` samples, gives lights and environment that no option mentions so
/// many samples that their error falls as fast as that of the varied integral and stays below it.
fn refine(settings: &mut Settings, count: u32) {
    let more = count.saturating_mul(FINER).min(MAX_COUNT);
    let finer = |plan: SampleSet| SampleSet::new(plan.count().max(more), plan.pattern);
    if let Some(distribution) = settings.distribution_tracer_mut() {
        distribution.sky = finer(distribution.sky);
    }
    if !settings.plans.is_off(Effect::Light) {
        settings.plans.light = finer(settings.plans.light);
    }
}
