//! From a pixel to a ray, and back to a picture.
pub mod camera;
pub mod film;
pub mod filter;
pub mod lens;
pub mod shutter;
pub use camera::{Camera, Projection};
pub use film::{Film, PixelRect};
pub use filter::Filter;
pub use lens::{Aperture, Lens};
pub use shutter::Shutter;
