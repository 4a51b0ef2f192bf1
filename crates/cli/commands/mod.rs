//! One file per command.

pub mod info;
pub mod render;
pub mod replay;
