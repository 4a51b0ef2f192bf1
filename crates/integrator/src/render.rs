//! The render loop: tiles, threads, passes, limits.
//!
//! A pass adds the same number of samples to every pixel. Passes start at one sample and grow to about one second. A
//! render can stop at any time, within a sample; the samples of the pass in progress are then discarded, so that every
//! pixel has the same number of samples. Only the first pass is kept as it is: some pixels have samples, others none.
//! The division of a render into passes, tiles and threads changes no bit of the image, because the sums of the samples
//! of a pixel do not depend on where these are divided (see [`dapple_camera::sums`]).
//!
//! [`Renderer`] renders step by step; [`Renderer::run`], [`render`] and [`render_watched`] are loops over it.

mod layers;
mod outcome;
mod part;
mod pilot;
mod pilot_samples;
mod pixels;
mod pool;
mod renderer;
mod snapshot;
mod watch;
mod whole;

pub use crate::tile::BadSample;
pub use outcome::{Outcome, Progress, Stats};
pub use part::{Covered, Part, PartError, missing};
pub use pilot::PilotResult;
pub use pilot_samples::render_pilot;
pub use pixels::{render_pixels, render_pixels_until, sum_pixels_until};
pub use renderer::{Advance, RenderState, Renderer};
pub use snapshot::{Look, Snapshot};
pub use whole::{Watcher, render, render_watched};
