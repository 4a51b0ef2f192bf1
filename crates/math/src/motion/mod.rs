//! Motion of objects: chains of node transforms, some of them key-framed, from object space to render space.
//!
//! `Motion::at(t)` = space · node₀(t) · … · nodeₙ(t), root first, in f64. Times are in seconds after the shutter opens;
//! tracks are evaluated at `offset + t`. Adjacent constant transforms are multiplied when the motion is built, so that
//! a query evaluates only the nodes that have tracks.
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
