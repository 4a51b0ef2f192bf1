//! Sample sets: the number and pattern of the points of an integral, written as `4x4:stratified`, `6x6:grid`,
//! `16:random`, `1` or `0`.

use crate::lanes::pattern::{self, Index};
use crate::pattern::{nearest_square, padded_1d, point_1d};
use crate::{Key, Pattern};
use glam::Vec2;
use std::fmt;
use std::str::FromStr;

/// Maximum number of points of one integral.
pub const MAX_COUNT: u32 = 1 << 24;

/// The sample points of one integral. A count of 0 means that the effect is off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SampleSet {
    /// Cells along the first coordinate.
    pub nx: u32,
    /// Cells along the second coordinate; the count is nx·ny.
    pub ny: u32,
    /// Arrangement of the points.
    pub pattern: Pattern,
}

/// The error for a text that is not a sample set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SampleSetError(String);

impl fmt::Display for SampleSetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "invalid sample set '{}': give a count and a pattern, such as 4x4:stratified, 16:random, 6x6:grid, 9:sobol, 1, or 0 for off (at most {MAX_COUNT} points)",
            self.0
        )
    }
}

impl std::error::Error for SampleSetError {}

impl SampleSet {
    /// The empty set, which turns the effect off.
    pub const OFF: Self = Self { nx: 0, ny: 0, pattern: Pattern::Stratified };

    /// Creates a set of `count` points in a grid that is as close to a square as possible.
    pub fn new(count: u32, pattern: Pattern) -> Self {
        let [nx, ny] = if count == 0 { [0, 0] } else { nearest_square(count) };
        Self { nx, ny, pattern }
    }

    /// Returns the number of points.
    pub fn count(self) -> u32 {
        self.nx.saturating_mul(self.ny)
    }

    /// Returns the s-th point in [0,1)², with the strata in order and x varying fastest.
    pub fn point_2d(self, s: u32, key: Key) -> Vec2 {
        pattern::point_2d(self.pattern, Index::new(s), [self.nx, self.ny], key).into()
    }

    /// Returns the s-th point in [0,1), which is divided into [`SampleSet::count`] strata.
    pub fn point_1d(self, s: u32, key: Key) -> f32 {
        point_1d(self.pattern, s, self.count(), key)
    }

    /// Like [`SampleSet::point_2d`], with the order of the cells permuted by the key, for integrals that share s.
    pub fn padded_2d(self, s: u32, key: Key) -> Vec2 {
        pattern::padded_2d(self.pattern, Index::new(s), [self.nx, self.ny], key).into()
    }

    /// Like [`SampleSet::point_1d`], with the order of the cells permuted by the key.
    pub fn padded_1d(self, s: u32, key: Key) -> f32 {
        padded_1d(self.pattern, s, self.count(), key)
    }
}

impl FromStr for SampleSet {
    type Err = SampleSetError;
    fn from_str(text: &str) -> Result<Self, SampleSetError> {
        let wrong = || SampleSetError(text.into());
        let (counts, pattern) = match text.split_once(':') {
            Some((counts, name)) => (counts, name.parse().map_err(|_| wrong())?),
            None => (text, Pattern::Stratified),
        };
        let number = |s: &str| {
            s.parse::<u32>().ok().filter(|_| s.bytes().all(|b| b.is_ascii_digit())).ok_or_else(wrong)
        };
        let set = match counts.split_once('x') {
            Some((nx, ny)) => Self { nx: number(nx)?, ny: number(ny)?, pattern },
            None => match number(counts)? {
                n if n <= MAX_COUNT => Self::new(n, pattern),
                _ => return Err(wrong()),
            },
        };
        let count = u64::from(set.nx) * u64::from(set.ny);
        if count > u64::from(MAX_COUNT) || (set.nx == 0) != (set.ny == 0) {
            return Err(wrong());
        }
        Ok(set)
    }
}

impl fmt::Display for SampleSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.count() == 0 {
            return f.write_str("0");
        }
        write!(f, "{}x{}:{}", self.nx, self.ny, self.pattern)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grammar_round_trips() {
        for text in ["4x4:stratified", "6x6:grid", "16x1:random", "3x2:sobol", "0"] {
            assert_eq!(text.parse::<SampleSet>().unwrap().to_string(), text);
        }
        assert_eq!(
            "16".parse::<SampleSet>().unwrap(),
            SampleSet { nx: 4, ny: 4, pattern: Pattern::Stratified }
        );
        assert_eq!("12:random".parse::<SampleSet>().unwrap().count(), 12);
    }

    #[test]
    fn nonsense_is_refused() {
        for text in [
            "",
            "abc",
            "0x4",
            "4x",
            "x4",
            "-1",
            "4x4:",
            "4x4:foo",
            "99999999999",
            "5000x5000",
            "+4",
            "1.5",
            "4 x4",
        ] {
            assert!(text.parse::<SampleSet>().is_err(), "{text}");
        }
    }
}
