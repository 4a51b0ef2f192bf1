//! The formulas of the crate, written once over [`Real`](dapple_math::lanes::Real) and
//! [`Word`](dapple_math::lanes::Word): for one number, or for 8 or 16 at a time with the same bits. The scalar functions
//! of the other modules are the instances for one number.
//!
//! - [`Keyx`]: one key per lane. [`sobol`], [`pattern`]: sample points. An index of a Sobol point is passed with its bits
//!   reversed, which is done once per sample.
//! - [`warp`], [`mis`]: warps of the unit square with their densities, and weights of strategies.
//! - [`Choicex`], [`GridSamplex`]: samples of [`Discrete`](crate::Discrete) and [`Grid2d`](crate::Grid2d).

mod circle;
mod hash;
mod integer;
mod key;
pub mod mis;
pub mod pattern;
pub mod sobol;
pub mod warp;

pub use crate::discrete::Choicex;
pub use crate::grid2d::GridSamplex;
pub use key::Keyx;
