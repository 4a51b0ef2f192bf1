//! The results of a comparison of methods and their file formats: `results.json` and `results.csv`.
//!
//! The schema is described in `docs/results.md`. Quantities derived from curves are recomputed when writing and ignored
//! when reading.

use crate::curve::{self, Curve, EqualCost, Error, Over, Point};
use crate::statistics::Interval;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The version of the schema. Version 2: the denominator of relMSE contains the reference's own pixel; processor
/// seconds, start-up times and equal times were added.
pub const SCHEMA: u32 = 2;

/// The relative RMSEs for which the seconds are reported.
pub const TARGETS: [f64; 3] = [1e-1, 1e-2, 1e-3];

/// The contents of `results.json`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Results {
    /// The version of the schema, [`SCHEMA`].
    pub schema: u32,
    /// The version of dapple.
    pub version: String,
    /// The machine the command ran on.
    pub machine: Machine,
    /// The command line.
    pub command: String,
    /// Time limit of the last call in seconds.
    pub budget_seconds: f64,
    /// Wall time of all calls in seconds.
    pub spent_seconds: f64,
    /// The reference images.
    pub references: Vec<ReferenceRecord>,
    /// The runs: each method on each scene.
    pub runs: Vec<RunRecord>,
    /// The differences between the references of a scene.
    #[serde(default)]
    pub differences: Vec<Difference>,
    /// Sentences that describe the seeds for which there was no time.
    pub left_out: Vec<String>,
}

/// The difference between two references of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// The scene as given on the command line.
    pub scene: String,
    /// The names of both references.
    pub names: [String; 2],
    /// Root of the mean squared difference, without the noise of references that come in halves, divided by the mean of
    /// the first; null if the sizes differ.
    pub relative_rmse: Option<f64>,
    /// The relative RMSE of both means together, as far as their halves reveal it.
    pub noise: f64,
    /// Whether the difference is more than noise, at four standard errors; null if one reference is a single image,
    /// whose noise is not known.
    pub beyond_noise: Option<bool>,
}

/// The machine of a measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// The processor's name.
    pub cpu: String,
    /// Number of threads used.
    pub threads: usize,
    /// Memory in bytes; 0 = unknown.
    pub memory_bytes: u64,
    /// Operating system and architecture.
    pub system: String,
}

/// A reference image.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ReferenceRecord {
    /// The scene as given on the command line.
    pub scene: String,
    /// Key that identifies the expected image: scene, view, effects.
    pub key: String,
    /// Its name on the page; the first of a scene is called "reference".
    #[serde(default)]
    pub name: String,
    /// The renderer and method that made it: a part of a sentence.
    pub kind: String,
    /// Samples per pixel of each half; 0 for a single image.
    pub samples: u32,
    /// Its own mean squared error; 0 for a single image, which is assumed to be exact.
    pub mse: f64,
    /// Its own relative RMSE.
    pub relative_rmse: f64,
    /// Mean radiance.
    pub mean: f64,
    /// Names of its files in the folder.
    pub files: Vec<String>,
}

/// A run: one method on one scene.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct RunRecord {
    /// The scene as given on the command line.
    pub scene: String,
    /// Name of the run.
    pub name: String,
    /// Its options as given on the command line.
    pub options: String,
    /// Key of everything that affects images or times.
    pub key: String,
    /// The `key` of its reference.
    pub reference: String,
    /// `path`, `distribution` or `external`.
    pub method: String,
    /// The sampling pattern.
    pub pattern: String,
    /// The quantity that is counted: `spp` or an effect.
    pub varied: String,
    /// Width and height of the image in pixels.
    pub size: [u32; 2],
    /// The largest sample count, once the first seed has determined it.
    pub most: Option<u32>,
    /// The reason the curves end, in words; empty if the time limit ended them.
    pub ends: String,
    /// Description of how its seconds were measured.
    #[serde(default)]
    pub timing: String,
    /// Wall time of an external command before it renders, in seconds, which was subtracted.
    #[serde(default)]
    pub startup_seconds: Option<f64>,
    /// Processor time of an external command before it renders, in seconds, which was subtracted.
    #[serde(default)]
    pub startup_cpu_seconds: Option<f64>,
    /// FLIP of the last image of the first seed.
    pub flip: Option<f64>,
    /// Names of its image files in the folder.
    pub files: Vec<String>,
    /// The curves, one per seed.
    pub seeds: Vec<Seed>,
    /// The quantities derived from the curves.
    #[serde(flatten, skip_deserializing)]
    pub summary: Summary,
}

/// The curve of one seed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Seed {
    /// The seed.
    pub seed: u64,
    /// The points of the curve.
    pub points: Curve,
}

/// The quantities derived from the curves of a run. Lists are over the sample counts that at least two seeds have.
/// Intervals are 95 % intervals over seeds, and null if they are not known: for a single seed, or (except for slopes)
/// with ends more than a factor [`crate::statistics::WIDEST`] apart.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Summary {
    /// Samples per pixel, or points of the varied effect.
    pub samples: Vec<f64>,
    /// Wall time of rendering in seconds, means over seeds; 0 if it was too short to be measured.
    pub seconds: Vec<f64>,
    /// Processor time in seconds, likewise.
    pub cpu_seconds: Vec<f64>,
    /// Geometric means of the MSE over seeds.
    pub mse: Vec<f64>,
    /// Geometric means of relMSE over seeds.
    pub relmse: Vec<f64>,
    /// Geometric means of the relative RMSE over seeds.
    pub relative_rmse: Vec<f64>,
    /// Exponent of MSE over samples.
    pub slope: Option<f64>,
    /// Interval of `slope`.
    pub slope_ci: Option<[f64; 2]>,
    /// Exponent of MSE over seconds.
    pub slope_seconds: Option<f64>,
    /// Interval of `slope_seconds`.
    pub slope_seconds_ci: Option<[f64; 2]>,
    /// 1/(relMSE · seconds) at the last count.
    pub efficiency: Option<f64>,
    /// Interval of `efficiency`.
    pub efficiency_ci: Option<[f64; 2]>,
    /// Seconds to each relative RMSE of [`TARGETS`]; null if not every seed reaches it.
    pub seconds_to: BTreeMap<String, Option<f64>>,
    /// Intervals of `seconds_to`.
    pub seconds_to_ci: BTreeMap<String, Option<[f64; 2]>>,
    /// Speed-up: seconds of the scene's first run divided by the seconds of this one, for the same relative RMSE.
    pub speed_up: Option<f64>,
    /// Interval of `speed_up`.
    pub speed_up_ci: Option<[f64; 2]>,
    /// The relative RMSE at which `speed_up` is measured.
    pub speed_up_at: Option<f64>,
    /// The speed-up in processor seconds.
    pub cpu_speed_up: Option<f64>,
    /// Interval of `cpu_speed_up`.
    pub cpu_speed_up_ci: Option<[f64; 2]>,
    /// The relative RMSE at which `cpu_speed_up` is measured.
    pub cpu_speed_up_at: Option<f64>,
    /// The run after times that it has in common with the other runs of its scene.
    pub equal_time: Vec<Equal>,
    /// The run after processor times that it has in common with the others.
    pub equal_cpu_time: Vec<Equal>,
}

/// Error and efficiency of a run after a given time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Equal {
    /// Wall or processor time in seconds.
    pub seconds: f64,
    /// Relative RMSE: geometric mean over seeds, interpolated between measured points.
    pub relative_rmse: f64,
    /// Interval of `relative_rmse`.
    pub relative_rmse_ci: Option<[f64; 2]>,
    /// Efficiency divided by that of the scene's first run at this time: the inverse ratio of the squared errors.
    pub efficiency_ratio: Option<f64>,
    /// Interval of `efficiency_ratio`.
    pub efficiency_ratio_ci: Option<[f64; 2]>,
}

impl From<&EqualCost> for Equal {
    fn from(at: &EqualCost) -> Self {
        Self {
            seconds: at.cost,
            relative_rmse: at.error.value,
            relative_rmse_ci: at.error.known_ends(),
            efficiency_ratio: at.efficiency.map(|e| e.value),
            efficiency_ratio_ci: at.efficiency.and_then(|e| e.known_ends()),
        }
    }
}

fn ends(interval: Interval) -> Option<[f64; 2]> {
    (interval.low.is_finite() && interval.high.is_finite()).then_some([interval.low, interval.high])
}

fn known(interval: Interval) -> Option<[f64; 2]> {
    interval.known_ends()
}

impl Summary {
    /// The summary of a run from its curves and those of its scene's first run, without the equal times, which require
    /// all runs.
    pub fn of(seeds: &[Curve], first: &[Curve]) -> Self {
        let slope = curve::slope(seeds, Over::Samples, Error::Mse);
        let slope_seconds = curve::slope(seeds, Over::Seconds, Error::Mse);
        let efficiency = curve::efficiency(seeds);
        let speed_up = curve::speed_up(first, seeds, Over::Seconds);
        let cpu_speed_up = curve::speed_up(first, seeds, Over::CpuSeconds);
        let band = |over, error| curve::band(seeds, over, error);
        let errors = |error| band(Over::Samples, error).iter().map(|p| p.1.value).collect::<Vec<_>>();
        let to = TARGETS.map(|t| (t.to_string(), curve::seconds_to(seeds, Error::RelativeRmse, t)));
        Self {
            samples: band(Over::Samples, Error::Mse).iter().map(|p| p.0).collect(),
            seconds: band(Over::Seconds, Error::Mse).iter().map(|p| p.0).collect(),
            cpu_seconds: band(Over::CpuSeconds, Error::Mse).iter().map(|p| p.0).collect(),
            mse: errors(Error::Mse),
            relmse: errors(Error::Relmse),
            relative_rmse: errors(Error::RelativeRmse),
            slope: slope.map(|s| s.value),
            slope_ci: slope.and_then(ends),
            slope_seconds: slope_seconds.map(|s| s.value),
            slope_seconds_ci: slope_seconds.and_then(ends),
            efficiency: efficiency.map(|e| e.value),
            efficiency_ci: efficiency.and_then(known),
            seconds_to: to.iter().map(|(t, s)| (t.clone(), s.map(|s| s.value))).collect(),
            seconds_to_ci: to.iter().map(|(t, s)| (t.clone(), s.and_then(known))).collect(),
            speed_up: speed_up.map(|s| s.ratio.value),
            speed_up_ci: speed_up.and_then(|s| known(s.ratio)),
            speed_up_at: speed_up.map(|s| s.at_error),
            cpu_speed_up: cpu_speed_up.map(|s| s.ratio.value),
            cpu_speed_up_ci: cpu_speed_up.and_then(|s| known(s.ratio)),
            cpu_speed_up_at: cpu_speed_up.map(|s| s.at_error),
            ..Self::default()
        }
    }
}

impl RunRecord {
    /// The curves of all seeds.
    pub fn curves(&self) -> Vec<Curve> {
        self.seeds.iter().map(|s| s.points.clone()).collect()
    }
}

impl Results {
    /// Recomputes the summary of every run.
    pub fn sum_up(&mut self) {
        let mut first: BTreeMap<String, Vec<Curve>> = BTreeMap::new();
        for run in &mut self.runs {
            let curves = run.curves();
            let first = first.entry(run.scene.clone()).or_insert_with(|| curves.clone());
            run.summary = Summary::of(&curves, first);
        }
        let scenes: Vec<String> = self.scenes().iter().map(|s| s.to_string()).collect();
        scenes.iter().for_each(|scene| self.equal(scene));
    }

    /// Compares the runs of a scene after equal times.
    fn equal(&mut self, scene: &str) {
        let curves: Vec<Vec<Curve>> = self.of_scene(scene).map(RunRecord::curves).collect();
        let at = |over| {
            curve::equal_costs(&curves, over)
                .into_iter()
                .map(|all| all.iter().map(Equal::from).collect::<Vec<_>>())
        };
        let (mut wall, mut cpu) = (at(Over::Seconds), at(Over::CpuSeconds));
        for run in self.runs.iter_mut().filter(|run| run.scene == scene) {
            run.summary.equal_time = wall.next().unwrap_or_default();
            run.summary.equal_cpu_time = cpu.next().unwrap_or_default();
        }
    }

    /// The runs of one scene in order.
    pub fn of_scene<'a>(&'a self, scene: &'a str) -> impl Iterator<Item = &'a RunRecord> {
        self.runs.iter().filter(move |run| run.scene == scene)
    }

    /// The scenes in order of their first run.
    pub fn scenes(&self) -> Vec<&str> {
        let mut scenes: Vec<&str> = Vec::new();
        for run in &self.runs {
            if !scenes.contains(&run.scene.as_str()) {
                scenes.push(&run.scene);
            }
        }
        scenes
    }

    /// The points as CSV, one line per point: scene, run, seed, samples, seconds, cpu_seconds, mse, relmse,
    /// relative_rmse.
    pub fn csv(&self) -> String {
        let mut text = String::from("scene,run,seed,samples,seconds,cpu_seconds,mse,relmse,relative_rmse\n");
        for run in &self.runs {
            for seed in &run.seeds {
                let name = format!("{},{},{}", quoted(&run.scene), quoted(&run.name), seed.seed);
                let line = |p: &Point| {
                    let Point { samples, seconds, cpu_seconds, mse, relmse, relative_rmse } = p;
                    format!("{name},{samples},{seconds},{cpu_seconds},{mse},{relmse},{relative_rmse}\n")
                };
                text.extend(seed.points.iter().map(line));
            }
        }
        text
    }
}

/// Quotes a CSV field if necessary.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(name: &str, second: f64) -> RunRecord {
        let point = |k: i32| {
            let samples = f64::from(1 << k);
            let mse = 1.0 / samples;
            let relative_rmse = mse.sqrt();
            Point {
                samples,
                seconds: samples * second,
                cpu_seconds: samples,
                mse,
                relmse: mse,
                relative_rmse,
            }
        };
        let seeds = (0..5).map(|seed| Seed { seed, points: (0..9).map(point).collect() }).collect();
        RunRecord { scene: "a, b".into(), name: name.into(), seeds, ..RunRecord::default() }
    }

    #[test]
    fn summaries_are_of_the_curves() {
        let mut results =
            Results { runs: vec![record("slow", 0.02), record("fast", 0.01)], ..Results::default() };
        results.sum_up();
        let fast = &results.runs[1].summary;
        assert!((fast.slope.unwrap() + 1.0).abs() < 1e-12);
        assert!((fast.speed_up.unwrap() - 2.0).abs() < 1e-6);
        assert!((fast.seconds_to["0.1"].unwrap() - 1.0).abs() < 1e-9);
        assert_eq!(fast.seconds_to["0.001"], None);
        // Twice as fast per sample in wall time, with equally many samples per processor second.
        assert!((fast.equal_time[0].efficiency_ratio.unwrap() - 2.0).abs() < 1e-6);
        assert!((fast.equal_cpu_time[0].efficiency_ratio.unwrap() - 1.0).abs() < 1e-6);
        assert!((fast.cpu_speed_up.unwrap() - 1.0).abs() < 1e-6);
        assert_eq!((fast.samples.len(), fast.seconds[8]), (9, 2.56));
        assert_eq!(results.csv().lines().count(), 1 + 2 * 5 * 9);
        assert!(results.csv().lines().nth(1).unwrap().starts_with("\"a, b\",slow,0,1,0.02,1,1,1,1"));
    }
}
