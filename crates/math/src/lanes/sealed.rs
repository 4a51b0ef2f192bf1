//! Keeps the traits of the lanes to the types of this module: safety and equality of bits rest on them.

/// Implemented for the lane types of this module only.
pub trait Sealed {}
