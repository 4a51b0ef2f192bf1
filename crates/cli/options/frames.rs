//! Options of frame sequences.

use crate::values;
use clap::Args;
use std::str::FromStr;

/// Frames per second without `--fps`.
const FPS: f64 = 24.0;

/// Most frames of one command.
const MOST: u64 = 1_000_000;

/// Options that select the frames of an animation.
#[derive(Args, Clone, Debug, Default)]
pub struct FrameOptions {
    /// Render the frames from A up to, but not including, B; frame f shows the animation at f/FPS seconds after --at
    ///
    /// Outputs are named with a pattern such as shot.####.exr, of which #### is replaced by the number of the frame.
    /// PNGs of all frames have the exposure metered for frame 0.
    #[arg(long, value_name = "A:B[:STEP]", allow_hyphen_values = true, help_heading = "Frames")]
    pub frames: Option<Frames>,
    /// Frames per second [default: 24]
    #[arg(long, value_name = "N", value_parser = values::positive64, help_heading = "Frames")]
    pub fps: Option<f64>,
    /// Shutter interval from the time of the frame, in degrees of which 360 are one frame; 180 is common
    #[arg(long, value_name = "DEG", value_parser = values::positive64, conflicts_with = "shutter", help_heading = "Frames")]
    pub shutter_angle: Option<f64>,
    /// Skip frames whose outputs all exist
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Frames")]
    pub skip_existing: Option<bool>,
    /// Use --seed in every frame, so that the noise stands still, instead of a seed for each frame
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Frames")]
    pub fixed_seed: Option<bool>,
}

impl FrameOptions {
    /// Returns the frames per second.
    pub fn rate(&self) -> f64 {
        self.fps.unwrap_or(FPS)
    }

    /// Returns the duration of the shutter interval in seconds, if it is given as an angle.
    pub fn shutter_seconds(&self) -> Option<f64> {
        self.shutter_angle.map(|degrees| degrees / 360.0 / self.rate())
    }
}

/// A range of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frames {
    first: i64,
    end: i64,
    step: u32,
}

impl Frames {
    /// The numbers of the frames.
    pub fn numbers(self) -> impl Iterator<Item = i64> {
        (self.first..self.end).step_by(self.step as usize)
    }

    /// How many frames there are.
    pub fn count(self) -> u64 {
        self.end.abs_diff(self.first).div_ceil(u64::from(self.step))
    }
}

impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected A:B or A:B:STEP, such as 0:240 for the frames 0 to 239".to_string();
        let parts: Vec<&str> = text.split(':').collect();
        let (first, end, step) = match parts[..] {
            [first, end] => (first, end, "1"),
            [first, end, step] => (first, end, step),
            _ => return Err(wrong()),
        };
        let number = |s: &str| s.trim().parse::<i32>().map(i64::from).map_err(|_| wrong());
        let (first, end) = (number(first)?, number(end)?);
        let step = step.trim().parse().ok().filter(|step| *step > 0).ok_or_else(wrong)?;
        let frames = Self { first, end, step };
        if end <= first {
            return Err("there are no frames; B is not included and must be greater than A".into());
        }
        if frames.count() > MOST {
            return Err(format!("more than {MOST} frames"));
        }
        Ok(frames)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_exclude_their_end() {
        let numbers = |text: &str| text.parse::<Frames>().map(|frames| frames.numbers().collect::<Vec<_>>());
        assert_eq!(numbers("0:3").unwrap(), [0, 1, 2]);
        assert_eq!(numbers("-2:3:2").unwrap(), [-2, 0, 2]);
        assert_eq!("10:31:10".parse::<Frames>().unwrap().count(), 3);
        for wrong in ["", "3", "3:3", "4:2", "0:3:0", "0:3:-1", "a:b", "0:1:2:3", "0:2000000000", "0:1.5"] {
            assert!(numbers(wrong).is_err(), "{wrong}");
        }
    }
}
