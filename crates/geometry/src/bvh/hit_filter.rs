//! Hits on triangles, and filters that accept or reject a hit during traversal.

/// A hit on a triangle of a [`Tree`](super::Tree).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Distance along the ray, in units of the length of its direction.
    pub t: f32,
    /// Barycentric coordinate of corner 1.
    pub u: f32,
    /// Barycentric coordinate of corner 2.
    pub v: f32,
    /// Index in the order given to [`Tree::build`](super::Tree::build).
    pub triangle: u32,
}

/// Any-hit filter: accepts or rejects every hit found during traversal, for example by alpha. `H` is
/// [`TriangleHit`] for a single tree and [`Hit`](crate::Hit) for a whole scene.
pub trait HitFilter<H> {
    /// Whether all hits are accepted. The test is then compiled out of the traversal.
    const OPAQUE: bool;
    /// Whether the hit is accepted.
    fn accept(&self, hit: &H) -> bool;
}

/// Accepts all hits.
#[derive(Clone, Copy, Debug)]
pub struct Opaque;

impl<H> HitFilter<H> for Opaque {
    const OPAQUE: bool = true;
    fn accept(&self, _: &H) -> bool {
        true
    }
}
