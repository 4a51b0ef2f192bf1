//! Which hits count.

use crate::Hit;

/// Decides whether a candidate hit counts (alpha). `OPAQUE = true` compiles the question out of traversal.
pub trait Filter {
    /// Everything counts.
    const OPAQUE: bool;
    /// Whether this hit counts.
    fn accept(&self, hit: &Hit) -> bool;
}

/// Everything is solid.
#[derive(Clone, Copy, Debug)]
pub struct Opaque;

impl Filter for Opaque {
    const OPAQUE: bool = true;
    fn accept(&self, _: &Hit) -> bool {
        true
    }
}
