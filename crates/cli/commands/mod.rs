//! One file per command.

pub mod info;
#[cfg(feature = "manual")]
pub mod manual;
pub mod merge;
pub mod plan;
pub mod rays;
pub mod render;
pub mod replay;
mod slices;
#[cfg(feature = "report")]
pub mod study;
