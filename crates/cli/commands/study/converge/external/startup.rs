//! Start-up time of external commands, which is subtracted from their total time.
//!
//! A command starts, reads the scene and only then renders; dapple's own seconds cover only rendering. Either the
//! command reports its rendering time, or its start-up is measured: the median of several runs at one sample per pixel,
//! minus the time of one sample according to the longest run. *Approximation*: the start-up is the same at any sample
//! count, and all samples take equally long.

use super::command::Took;

/// Number of runs at one sample per pixel.
pub const RUNS: usize = 3;

/// Rendering times below this multiple of the spread of the start-up cannot be distinguished from it.
const LOST: f64 = 2.0;

/// Least significant processor seconds: the system counts processor time of commands in hundredths of a second.
const LEAST_CPU: f64 = 0.05;

/// Seconds of a command before and after rendering.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Startup {
    pub wall: f64,
    pub cpu: f64,
    /// Range (maximum minus minimum) of the runs at one sample, in wall-clock seconds.
    pub spread: f64,
    pub cpu_spread: f64,
    /// Whether the time of one sample could be distinguished from the start-up.
    pub is_known: bool,
}

impl Startup {
    /// Estimates the start-up from runs at one sample, and the longest run with its sample count.
    pub fn of(least: &[Took], longest: (u32, Took)) -> Self {
        if longest.0 <= 1 || least.is_empty() {
            return Self::default();
        }
        let part = |of: &dyn Fn(&Took) -> f64| {
            let mut all: Vec<f64> = least.iter().map(of).collect();
            all.sort_by(f64::total_cmp);
            let (middle, spread) = (all[all.len() / 2], all[all.len() - 1] - all[0]);
            let sample = (of(&longest.1) - middle).max(0.0) / f64::from(longest.0 - 1);
            ((middle - sample).max(0.0), spread)
        };
        let ((wall, spread), (cpu, cpu_spread)) = (part(&|t| t.wall), part(&|t| t.cpu));
        Self { wall, cpu, spread, cpu_spread, is_known: true }
    }

    /// Returns wall-clock and processor seconds of rendering; 0 if too short to be distinguished from the start-up.
    pub fn rendering(&self, took: &Took) -> (f64, f64) {
        let beyond = |seconds: f64, least: f64| if seconds > least { seconds } else { 0.0 };
        let wall = took.told_wall.unwrap_or_else(|| beyond(took.wall - self.wall, LOST * self.spread));
        let least = f64::max(LEAST_CPU, LOST * self.cpu_spread);
        (wall, took.told_cpu.unwrap_or_else(|| beyond(took.cpu - self.cpu, least)))
    }

    /// Describes the seconds in a sentence; `tells` and `tells_cpu` state which times the command reports.
    pub fn said(&self, tells: bool, tells_cpu: bool) -> String {
        let wall = match (tells, self.is_known) {
            (true, _) => "Seconds are those that the command itself wrote into its {time} file".into(),
            (false, true) => format!(
                "Seconds are those of the whole command minus its start-up of {:.3} s (median of {RUNS} runs at one \
                 sample per pixel, range {:.3} s, minus one sample); rendering shorter than {LOST} times that range \
                 has no time",
                self.wall, self.spread
            ),
            (false, false) => {
                "Seconds are those of the whole command, start-up included: there was no time to measure it"
                    .into()
            }
        };
        let cpu = match (tells_cpu, self.is_known) {
            (true, _) => "so are processor seconds".into(),
            (false, true) => format!("processor seconds are those of its processes minus {:.2} s", self.cpu),
            (false, false) => "processor seconds likewise".into(),
        };
        format!("{wall}; {cpu}.")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn took(wall: f64, cpu: f64) -> Took {
        Took { wall, cpu, ..Took::default() }
    }

    #[test]
    fn a_start_up_is_what_does_not_grow() {
        // 0.5 s plus 0.01 s per sample; processor seconds are twice as many.
        let least = [took(0.52, 1.02), took(0.51, 1.02), took(0.50, 1.02)];
        let found = Startup::of(&least, (101, took(1.51, 3.02)));
        assert!((found.wall - 0.5).abs() < 1e-12 && (found.cpu - 1.0).abs() < 1e-12, "{found:?}");
        assert!(found.is_known && (found.spread - 0.02).abs() < 1e-12);
        let (wall, cpu) = found.rendering(&took(0.82, 1.64));
        assert!((wall - 0.32).abs() < 1e-12 && (cpu - 0.64).abs() < 1e-12);
        // Within the spread, and below the resolution of processor time.
        assert_eq!(found.rendering(&took(0.53, 1.04)), (0.0, 0.0));
        let told = Took { told_wall: Some(0.01), told_cpu: Some(0.02), ..took(0.53, 1.04) };
        assert_eq!(found.rendering(&told), (0.01, 0.02));
        assert!(found.said(false, false).contains("start-up of 0.500 s"));
    }

    #[test]
    fn without_a_longer_run_nothing_is_known() {
        let found = Startup::of(&[took(1.0, 1.0)], (1, took(1.0, 1.0)));
        assert_eq!(found.rendering(&took(1.0, 1.0)), (1.0, 1.0));
        assert!(!found.is_known && found.said(false, false).contains("start-up included"));
        assert!(found.said(true, true).contains("itself wrote"));
    }
}
