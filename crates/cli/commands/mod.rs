//! One file per command.

pub mod budget;
pub mod checks;
pub mod converge;
pub mod diff;
pub mod info;
pub mod plan;
pub mod rays;
pub mod render;
pub mod replay;
pub mod sheet;
pub mod stress;
pub mod verify;
