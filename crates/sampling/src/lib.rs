//! Points in the unit square and their densities.
pub mod dimension;
pub mod discrete;
pub mod grid2d;
pub mod key;
pub mod mis;
pub mod pattern;
pub mod plan;
pub mod stats;
pub mod warp;

pub use dimension::Dimension;
pub use discrete::Discrete;
pub use grid2d::Grid2d;
pub use key::Key;
pub use pattern::{Pattern, padded_1d, padded_2d, point_1d, point_2d};
pub use plan::Plan;
pub use stats::Moments;
