//! Closed-form scenes for both integrators with every estimator (docs/science.md, "Closed-form scenes"): value, error
//! in standard errors, and the rate at which the error falls with the number of points.

mod catalogue;
mod effects;
mod estimate;
mod form;
mod rooms;
mod surfaces;

pub use catalogue::all;
pub use estimate::{Measured, measure};
pub use form::Form;
