//! Comparison of the chosen plan with the general one on the user's scene: paired, interleaved runs, reported as
//! ratios.

use crate::commands::render;
use crate::error::Failure;
use crate::load::{self, Source};
use crate::options::RenderOptions;
use dapple_integrator::scene::NamedCamera;
use dapple_integrator::{Settings, plan, render as draw};
use serde::Serialize;
use std::ops::ControlFlow;

/// Number of pairs of runs.
const PAIRS: usize = 7;
/// Samples per pixel of each run, unless the options set fewer.
const SPP: u32 = 4;
/// Two-sided 95 % quantile of Student's t with PAIRS − 1 degrees of freedom.
const T: f64 = 2.447;

/// Measurements of the chosen and the general plan; ratios below 1 are savings of the chosen plan.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Measured {
    pub seconds: f64,
    pub general_seconds: f64,
    /// Geometric mean of the time ratios of the pairs; `time_ratio_low` and `time_ratio_high` are its 95 % interval.
    pub time_ratio: f64,
    pub time_ratio_low: f64,
    pub time_ratio_high: f64,
    /// Memory of the scene, film and layers.
    pub bytes: usize,
    pub general_bytes: usize,
    pub load_seconds: f64,
    pub general_load_seconds: f64,
}

impl Measured {
    /// Formats the measurements for people.
    pub fn as_text(&self) -> String {
        let bytes = self.bytes as f64 / self.general_bytes.max(1) as f64;
        format!(
            "compared with the general plan, {PAIRS} interleaved pairs\n  time        ratio {:.3} ({:.3} to {:.3}): \
             {:.3} s against {:.3} s\n  memory      ratio {:.3}: {:.2} MB against {:.2} MB\n  loading     {:.3} s \
             against {:.3} s",
            self.time_ratio,
            self.time_ratio_low,
            self.time_ratio_high,
            self.seconds,
            self.general_seconds,
            bytes,
            self.bytes as f64 / 1e6,
            self.general_bytes as f64 / 1e6,
            self.load_seconds,
            self.general_load_seconds,
        )
    }
}

/// Renders the same image with both plans alternately.
pub fn against_general(source: &Source, options: &RenderOptions) -> Result<Measured, Failure> {
    let general = RenderOptions { plan: Some(crate::values::PlanKind::General), ..options.clone() };
    let mut setups: Vec<Setup> = Vec::new();
    for options in [options, &general] {
        let loaded = load::load(source, options)?;
        let view = load::camera(&loaded.scene, options)?;
        let settings = render::settings(options, &view)?;
        let few = settings.spp().unwrap_or(SPP).min(SPP);
        let settings = settings.with_spp(few).with_time_limit(None);
        setups.push((loaded, view, settings));
    }
    let mut seconds = [Vec::new(), Vec::new()];
    for _ in 0..=PAIRS {
        for ((loaded, view, settings), seconds) in setups.iter().zip(&mut seconds) {
            let outcome = draw(&loaded.scene, &view.camera, settings, &|_| ControlFlow::Continue(()));
            seconds.push(outcome.stats.seconds);
        }
    }
    // The first pair is a warm-up and is not counted.
    let logs: Vec<f64> = (1..=PAIRS).map(|i| ln(seconds[0][i] / seconds[1][i].max(1e-9))).collect();
    let mean = logs.iter().sum::<f64>() / PAIRS as f64;
    let variance = logs.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (PAIRS - 1) as f64;
    let half = T * (variance / PAIRS as f64).sqrt();
    let median = |all: &[f64]| {
        let mut sorted = all[1..].to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    };
    Ok(Measured {
        seconds: median(&seconds[0]),
        general_seconds: median(&seconds[1]),
        time_ratio: mean.exp(),
        time_ratio_low: (mean - half).exp(),
        time_ratio_high: (mean + half).exp(),
        bytes: bytes(&setups[0]),
        general_bytes: bytes(&setups[1]),
        load_seconds: setups[0].0.load_seconds,
        general_load_seconds: setups[1].0.load_seconds,
    })
}

type Setup = (load::Loaded, NamedCamera, Settings);

/// Returns the memory of scene and film, as computed by the plan.
fn bytes((loaded, view, settings): &Setup) -> usize {
    let plan = plan(&loaded.scene, &view.camera, settings);
    plan.scene_bytes + plan.bytes_per_pixel * settings.rect().area()
}

fn ln(x: f64) -> f64 {
    x.max(f64::MIN_POSITIVE).ln()
}
