//! How does an error fall with samples and with seconds?
//!
//! A [`Curve`] is one seed of one method: errors at growing sample counts. Everything said about a method is worked
//! out for each seed alone and then averaged over seeds, so that intervals show how much seeds differ.

mod equal;
mod fall;

pub use equal::{EqualCost, equal_costs};
pub use fall::{
    Curve, Error, Over, Point, SpeedUp, band, cost_to, efficiency, power_law, seconds_to, slope, speed_up,
};
