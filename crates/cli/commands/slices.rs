//! `dapple plan --slices`: ranges of samples of equal expected cost.

use crate::error::Failure;
use crate::options::RenderOptions;
use crate::part;
use dapple_integrator::sampling::Pattern;
use dapple_integrator::{MethodKind, Settings};
use serde::Serialize;

/// Most tasks of one plan.
const MOST: u64 = 1_000_000;

/// The tasks of a render.
#[derive(Serialize)]
pub struct Slices {
    slices: Vec<Slice>,
}

/// One task.
#[derive(Serialize)]
struct Slice {
    #[serde(skip_serializing_if = "Option::is_none")]
    frame: Option<i64>,
    /// The range for `--samples`.
    samples: String,
    begin: u32,
    end: u32,
    /// Samples per pixel that the task renders, pilot samples included.
    cost: u32,
}

impl Slices {
    /// Divides the samples of a render with `settings`, and of every frame if there are any, into `count` ranges.
    pub fn new(options: &RenderOptions, settings: &Settings, count: u32) -> Result<Self, Failure> {
        let wrong = |why: String| Failure::Arguments(format!("--slices {count}: {why}"));
        let Some(samples) = part::size_of_set(settings) else {
            return Err(wrong("give the number of samples to divide with --spp".into()));
        };
        if count > samples {
            return Err(wrong(format!("there are only {samples} samples per pixel; give at most as many")));
        }
        let frames = options.frames.frames.map_or(1, |frames| frames.count());
        if frames * u64::from(count) > MOST {
            return Err(wrong(format!("{frames} frames have more than {MOST} slices in all")));
        }
        let frames: Vec<Option<i64>> = match options.frames.frames {
            Some(frames) => frames.numbers().map(Some).collect(),
            None => vec![None],
        };
        let ranges = divided(samples, count, pilot(settings));
        let of = |frame: Option<i64>| {
            let slice = move |range: &Range| Slice {
                frame,
                samples: format!("{}:{}", range.begin, range.end),
                begin: range.begin,
                end: range.end,
                cost: range.cost,
            };
            ranges.iter().map(slice).collect::<Vec<_>>()
        };
        Ok(Self { slices: frames.into_iter().flat_map(of).collect() })
    }

    /// One line for each task, with its options.
    pub fn as_text(&self) -> String {
        let line = |slice: &Slice| {
            let frame = slice.frame.map_or(String::new(), |n| format!("--frames {n}:{} ", n + 1));
            format!("{frame}--samples {}", slice.samples)
        };
        self.slices.iter().map(line).collect::<Vec<_>>().join("\n")
    }
}

/// Pilot samples per pixel of the part that begins with the first sample, and of the others.
fn pilot(settings: &Settings) -> [u32; 2] {
    let is_random = settings.kind() == MethodKind::Path && settings.pattern == Pattern::Random;
    let is_needed = settings.adaptive() || !is_random;
    let samples = settings.pilot_samples().filter(|_| is_needed).unwrap_or_default();
    // An adaptive part needs the sample allocation before its first sample.
    [if settings.adaptive() { samples } else { 0 }, samples]
}

struct Range {
    begin: u32,
    end: u32,
    cost: u32,
}

/// Divides `samples` into `count` ranges that are as equal as possible, pilot samples included.
fn divided(samples: u32, count: u32, [first, other]: [u32; 2]) -> Vec<Range> {
    let (n, count_f) = (f64::from(samples), f64::from(count));
    let saved = f64::from(other - first.min(other));
    // The first range is longer by the pilot samples that it saves, if the others are not empty then.
    let rest = (n - saved) / count_f;
    let (head, rest) =
        if count > 1 && rest >= 1.0 { (rest + saved, rest) } else { (n / count_f, n / count_f) };
    let end = |i: u32| match i {
        0 => 0,
        i if i == count => samples,
        i => (head + rest * f64::from(i - 1)).round() as u32,
    };
    let range = |i: u32| {
        let (begin, end) = (end(i), end(i + 1));
        Range { begin, end, cost: end - begin + if i == 0 { first } else { other } }
    };
    (0..count).map(range).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(samples: u32, count: u32, pilot: [u32; 2]) -> Vec<u32> {
        let all = divided(samples, count, pilot);
        assert!(all.windows(2).all(|pair| pair[0].end == pair[1].begin) && all[0].begin == 0);
        assert!(all.iter().all(|range| range.begin < range.end));
        all.iter().map(|range| range.end).collect()
    }

    #[test]
    fn ranges_cost_the_same() {
        assert_eq!(ends(1024, 8, [0, 16])[..2], [142, 268]);
        assert_eq!(ends(64, 4, [0, 16]), [28, 40, 52, 64]);
        assert_eq!(ends(64, 4, [16, 16]), [16, 32, 48, 64]);
        assert_eq!(ends(10, 10, [0, 16]), (1..=10).collect::<Vec<_>>());
        assert_eq!(ends(7, 1, [0, 16]), [7]);
        let costs: Vec<u32> = divided(1000, 7, [0, 16]).iter().map(|range| range.cost).collect();
        assert!(costs.iter().max().unwrap() - costs.iter().min().unwrap() <= 1, "{costs:?}");
    }
}
