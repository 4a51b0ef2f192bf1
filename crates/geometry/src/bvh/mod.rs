//! The wide tree over triangles (TRAVERSAL §5-6).
use crate::Ray;
use glam::Vec3;
/// Which instructions traversal uses. All give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    Avx2,
    Sse2,
    Portable,
}
impl Kernel {
    /// Kernels this machine can run, fastest first.
    pub fn available() -> Vec<Self> {
        todo!()
    }
    pub fn name(self) -> &'static str {
        todo!()
    }
}
/// The triangle a ray hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    pub t: f32,
    pub u: f32,
    pub v: f32,
    pub triangle: u32,
}
/// Decides in the leaf whether a candidate counts (alpha cut-outs). `OPAQUE` compiles the question out.
pub trait Candidate {
    const OPAQUE: bool;
    fn accept(&self, hit: &TriangleHit) -> bool;
}
#[derive(Debug)]
pub struct Tree {}
impl Tree {
    /// Triangles by corner; those with non-finite corners or zero area (cross product in f64) are never hit.
    pub fn build(_triangles: &[[Vec3; 3]]) -> Self {
        todo!()
    }
    pub fn with_kernel(self, _kernel: Kernel) -> Self {
        todo!()
    }
    pub fn kernel(&self) -> Kernel {
        todo!()
    }
    pub fn closest<C: Candidate>(&self, _ray: &Ray, _candidate: &C) -> Option<TriangleHit> {
        todo!()
    }
    pub fn blocked<C: Candidate>(&self, _ray: &Ray, _candidate: &C) -> bool {
        todo!()
    }
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        todo!()
    }
    pub fn memory_bytes(&self) -> usize {
        todo!()
    }
}
