//! Light sampling over lanes: every formula is written once over [`Real`](dapple_math::lanes::Real), and the types of
//! the crate are its instance with one lane.
//!
//! A light is first prepared: a `Record` holds what depends on the light alone, and is read per lane, so that every
//! lane may have another light. [`Rectangle`], [`Triangle`], [`Sphere`] and [`Disk`] are the shapes in lanes; their
//! samples are [`Aimed`]. Densities are per solid angle at the receiver, and 0 means that there is no sample. Lanes in
//! which f32 is not accurate enough (grazing receivers, contact with a sphere) are computed in f64, one by one.
mod accuracy;
mod aimed;
mod choice;
mod columns;
pub(crate) mod disk;
pub(crate) mod flat;
mod others;
mod point;
mod receiver;
mod rectangle;
mod sample;
mod sphere;
mod table;
mod triangle;

pub use aimed::Aimed;
pub use choice::{Chosen, probabilities};
pub use disk::Disk;
pub use flat::{Flat, Record};
pub use point::{Point, Shone, Spot};
pub use receiver::{Hit, Receiver};
pub use rectangle::Rectangle;
pub use sample::Sample;
pub use sphere::Sphere;
pub use table::{Kind, Table};
pub use triangle::Triangle;
