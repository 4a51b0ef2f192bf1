//! The names of the sample patterns.

use std::fmt;
use std::str::FromStr;

/// The arrangement of the sample points of an integral.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Pattern {
    /// Cell centres: deterministic midpoint quadrature, the same in every pixel.
    Grid,
    /// Independent random points.
    Random,
    /// One random point in each cell.
    Stratified,
    /// An Owen-scrambled (0,2)-sequence.
    #[default]
    Sobol,
}

/// The error for a text that is not the name of a pattern.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownPattern(pub String);

impl fmt::Display for UnknownPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "unknown pattern '{}' (expected grid, random, stratified or sobol)", self.0)
    }
}

impl std::error::Error for UnknownPattern {}

impl FromStr for Pattern {
    type Err = UnknownPattern;
    fn from_str(s: &str) -> Result<Self, UnknownPattern> {
        match s {
            "grid" => Ok(Self::Grid),
            "random" => Ok(Self::Random),
            "stratified" => Ok(Self::Stratified),
            "sobol" => Ok(Self::Sobol),
            _ => Err(UnknownPattern(s.into())),
        }
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Grid => "grid",
            Self::Random => "random",
            Self::Stratified => "stratified",
            Self::Sobol => "sobol",
        })
    }
}
