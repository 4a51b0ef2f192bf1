//! Convergence curves: error against samples or time.
//!
//! A [`Curve`] belongs to one seed of one method and contains errors at increasing sample counts. Every quantity of a
//! method is computed per seed and then averaged over seeds, so that its interval measures the variation between seeds.

mod equal;
mod fall;

pub use equal::{EqualCost, equal_costs};
pub use fall::{
    Curve, Error, Over, Point, SpeedUp, band, cost_to, efficiency, power_law, seconds_to, slope, speed_up,
};
