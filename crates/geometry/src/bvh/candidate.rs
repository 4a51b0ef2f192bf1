//! The triangle that a ray hits, and the question whether it counts.

/// The triangle a ray hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Barycentric of corner 1.
    pub u: f32,
    /// Barycentric of corner 2.
    pub v: f32,
    /// Index in the order given to [`Tree::build`](super::Tree::build).
    pub triangle: u32,
}

/// Decides in the leaf whether a candidate counts (alpha cut-outs). `OPAQUE` compiles the question out.
pub trait Candidate {
    /// Everything counts.
    const OPAQUE: bool;
    /// Whether this hit counts.
    fn accept(&self, hit: &TriangleHit) -> bool;
}

/// Every triangle counts.
#[derive(Clone, Copy, Debug)]
pub struct Any;

impl Candidate for Any {
    const OPAQUE: bool = true;
    fn accept(&self, _: &TriangleHit) -> bool {
        true
    }
}
