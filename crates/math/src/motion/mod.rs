//! Where is an object at a time? A chain of node transforms, some of them key-framed, down to render space.
//!
//! `Motion::at(t)` = space · node₀(t) · … · nodeₙ(t), root first, in f64. Times count in seconds within the shutter;
//! tracks are read at `offset + t`. What does not change is folded when the chain is made, so a query evaluates only
//! the nodes that have tracks.
mod chain;
mod links;
mod node;
mod pose;
mod sweep;
mod track;

pub use chain::Chain;
pub use links::Motion;
pub use node::{Channel, Node, Trs};
pub use pose::{NormalMap, Pose};
pub use track::{Interpolation, Track, TrackError, Value};
