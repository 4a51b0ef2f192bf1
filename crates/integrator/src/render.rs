//! The render loop: tiles, threads, passes, limits.
//!
//! A pass gives every pixel the same number of further samples. Passes start at one sample and grow to about a second.
//! A render can stop at any time, within a sample; what the pass under way has added is then taken back, so that every
//! pixel is equally sampled. Only the first pass is left as it is: some pixels have samples, others none. How a render is
//! cut into passes, tiles and threads changes no bit of the image, for each pixel's samples are added in order.
//!
//! [`Renderer`] makes a render step by step; [`render`] and [`render_watched`] are loops over it.

mod layers;
mod outcome;
mod pilot;
mod pixels;
mod pool;
mod renderer;
mod snapshot;
mod watch;
mod whole;

pub use crate::tile::BadSample;
pub use outcome::{Outcome, Progress, Stats};
pub use pixels::{render_pixels, render_pixels_until};
pub use renderer::{Advance, RenderState, Renderer};
pub use snapshot::{Look, Snapshot};
pub use whole::{render, render_watched};
