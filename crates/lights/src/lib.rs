//! Where light comes from, and how to aim at it.
pub mod area;
pub mod choice;
pub mod distant;
pub mod environment;
pub mod light;
pub mod point;
pub use area::{Area, AreaShape};
pub use choice::LightChoice;
pub use distant::Distant;
pub use environment::Environment;
pub use light::{Light, LightPoint, LightSample};
pub use point::{Point, Spot};
