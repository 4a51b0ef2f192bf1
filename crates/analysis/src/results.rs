//! What a comparison of methods found, as it is written and read again: `results.json` and `results.csv`.
//!
//! The schema is described in `docs/results.md`. What is derived from curves is worked out again when writing, and not
//! believed when reading.

use crate::curve::{self, Curve, EqualCost, Error, Over, Point};
use crate::statistics::Interval;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The version of the schema. 2: relMSE has the reference's own pixel below it; processor seconds, start-up, equal times.
pub const SCHEMA: u32 = 2;

/// Relative RMSEs to which the seconds are told.
pub const TARGETS: [f64; 3] = [1e-1, 1e-2, 1e-3];

/// Everything.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Results {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Of dapple.
    pub version: String,
    /// What it ran on.
    pub machine: Machine,
    /// The command line.
    pub command: String,
    /// Wall time granted to the last call, seconds.
    pub budget_seconds: f64,
    /// Wall time of all calls, seconds.
    pub spent_seconds: f64,
    /// Pictures that others are held against.
    pub references: Vec<ReferenceRecord>,
    /// Each method on each scene.
    pub runs: Vec<RunRecord>,
    /// How far the references of a scene are from one another.
    #[serde(default)]
    pub differences: Vec<Difference>,
    /// What there was no time for, in words.
    pub left_out: Vec<String>,
}

/// Two references of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// The scene as it was named.
    pub scene: String,
    /// What both are called.
    pub names: [String; 2],
    /// Root of their mean squared difference, without the noise of those that come in halves, over the mean of the first;
    /// null where their sizes differ.
    pub relative_rmse: Option<f64>,
    /// The relative RMSE of both means together that their halves account for.
    pub noise: f64,
    /// Whether the difference is more than noise, at four standard errors; null where one of them comes as one picture,
    /// whose noise is not known.
    pub beyond_noise: Option<bool>,
}

/// A computer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// The processor's name.
    pub cpu: String,
    /// Threads used.
    pub threads: usize,
    /// Bytes of memory; 0 = unknown.
    pub memory_bytes: u64,
    /// Operating system and architecture.
    pub system: String,
}

/// A reference.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ReferenceRecord {
    /// The scene as it was named.
    pub scene: String,
    /// Tells apart what is to be seen: scene, view, effects.
    pub key: String,
    /// What it is called on the page; one of a scene is called "reference".
    #[serde(default)]
    pub name: String,
    /// Who made it and how: a part of a sentence.
    pub kind: String,
    /// Samples per pixel of each half; 0 where it is one picture.
    pub samples: u32,
    /// Its own mean squared error; 0 for one picture, which is taken as exact.
    pub mse: f64,
    /// The same as relative RMSE.
    pub relative_rmse: f64,
    /// Mean radiance.
    pub mean: f64,
    /// Names of its files.
    pub files: Vec<String>,
}

/// One method on one scene.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct RunRecord {
    /// The scene as it was named.
    pub scene: String,
    /// What the method is called.
    pub name: String,
    /// Its options as given.
    pub options: String,
    /// Tells apart everything that changes pictures or times.
    pub key: String,
    /// The key of its reference.
    pub reference: String,
    /// path, distribution or external.
    pub method: String,
    /// Of the points.
    pub pattern: String,
    /// What the samples count: "spp" or an effect.
    pub varied: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The largest count, once the first seed has found it.
    pub most: Option<u32>,
    /// Why curves end where they do, in words; empty where time ended them.
    pub ends: String,
    /// What its seconds are, in words.
    #[serde(default)]
    pub timing: String,
    /// Wall seconds of a command before it renders, which were subtracted.
    #[serde(default)]
    pub startup_seconds: Option<f64>,
    /// Its processor seconds before it renders, which were subtracted.
    #[serde(default)]
    pub startup_cpu_seconds: Option<f64>,
    /// FLIP of the last picture of the first seed.
    pub flip: Option<f64>,
    /// Names of its pictures.
    pub files: Vec<String>,
    /// Curves by seed.
    pub seeds: Vec<Seed>,
    /// What follows from them.
    #[serde(flatten, skip_deserializing)]
    pub summary: Summary,
}

/// The curve of one seed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Seed {
    /// The seed.
    pub seed: u64,
    /// Its points.
    pub points: Curve,
}

/// What follows from the curves of a run. Lists go over the counts that at least two seeds have; intervals are of
/// 95 % over seeds, and null where they are not known: of one seed, or (of slopes: never) with ends more than a factor
/// [`crate::statistics::WIDEST`] apart.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Summary {
    /// Samples per pixel, or points of the effect that varies.
    pub samples: Vec<f64>,
    /// Wall seconds of rendering, means over seeds; 0 where they are too short to be measured.
    pub seconds: Vec<f64>,
    /// Processor seconds, likewise.
    pub cpu_seconds: Vec<f64>,
    /// Geometric means over seeds.
    pub mse: Vec<f64>,
    /// Of relMSE.
    pub relmse: Vec<f64>,
    /// Of relative RMSE.
    pub relative_rmse: Vec<f64>,
    /// Exponent of MSE over samples.
    pub slope: Option<f64>,
    /// Its interval.
    pub slope_ci: Option<[f64; 2]>,
    /// Exponent of MSE over seconds.
    pub slope_seconds: Option<f64>,
    /// Its interval.
    pub slope_seconds_ci: Option<[f64; 2]>,
    /// 1/(relMSE · seconds) at the last count.
    pub efficiency: Option<f64>,
    /// Its interval.
    pub efficiency_ci: Option<[f64; 2]>,
    /// Seconds to a relative RMSE; null where not every seed gets there.
    pub seconds_to: BTreeMap<String, Option<f64>>,
    /// Their intervals.
    pub seconds_to_ci: BTreeMap<String, Option<[f64; 2]>>,
    /// Seconds of the scene's first run over seconds of this one, for the same relative RMSE.
    pub speed_up: Option<f64>,
    /// Its interval.
    pub speed_up_ci: Option<[f64; 2]>,
    /// The relative RMSE at which they are compared.
    pub speed_up_at: Option<f64>,
    /// As `speed_up`, in processor seconds.
    pub cpu_speed_up: Option<f64>,
    /// Its interval.
    pub cpu_speed_up_ci: Option<[f64; 2]>,
    /// The relative RMSE at which they are compared.
    pub cpu_speed_up_at: Option<f64>,
    /// The run after the same times as the others of its scene.
    pub equal_time: Vec<Equal>,
    /// The same after the same processor times.
    pub equal_cpu_time: Vec<Equal>,
}

/// A run after some time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Equal {
    /// Seconds, of the wall or of processors.
    pub seconds: f64,
    /// Geometric mean over seeds, between measured points.
    pub relative_rmse: f64,
    /// Its interval.
    pub relative_rmse_ci: Option<[f64; 2]>,
    /// Efficiency over that of the scene's first run at this time: the inverse ratio of squared errors.
    pub efficiency_ratio: Option<f64>,
    /// Its interval.
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
    /// From the curves of a run and of its scene's first run; without the times that need all runs.
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
    /// The curves alone.
    pub fn curves(&self) -> Vec<Curve> {
        self.seeds.iter().map(|s| s.points.clone()).collect()
    }
}

impl Results {
    /// Works out every run's summary again.
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

    /// The runs of one scene, in order.
    pub fn of_scene<'a>(&'a self, scene: &'a str) -> impl Iterator<Item = &'a RunRecord> {
        self.runs.iter().filter(move |run| run.scene == scene)
    }

    /// Scenes in the order in which they come.
    pub fn scenes(&self) -> Vec<&str> {
        let mut scenes: Vec<&str> = Vec::new();
        for run in &self.runs {
            if !scenes.contains(&run.scene.as_str()) {
                scenes.push(&run.scene);
            }
        }
        scenes
    }

    /// One line per point: scene, run, seed, samples, seconds, cpu_seconds, mse, relmse, relative_rmse.
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

/// A field that may hold a comma.
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
        // Twice as fast per sample; as many samples per processor second.
        assert!((fast.equal_time[0].efficiency_ratio.unwrap() - 2.0).abs() < 1e-6);
        assert!((fast.equal_cpu_time[0].efficiency_ratio.unwrap() - 1.0).abs() < 1e-6);
        assert!((fast.cpu_speed_up.unwrap() - 1.0).abs() < 1e-6);
        assert_eq!((fast.samples.len(), fast.seconds[8]), (9, 2.56));
        assert_eq!(results.csv().lines().count(), 1 + 2 * 5 * 9);
        assert!(results.csv().lines().nth(1).unwrap().starts_with("\"a, b\",slow,0,1,0.02,1,1,1,1"));
    }
}
