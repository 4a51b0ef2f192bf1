//! Who looks at a sample while it grows: layers of first hits, replayed paths, and the ledger of what was cut.

use crate::bias_report::{BiasReport, Truncation};
use crate::vertex::Vertex;
use dapple_materials::BsdfSample;
use glam::Vec3;

/// Is told of the rays of a sample as they grow; an observer that looks at nothing costs nothing.
pub(crate) trait PathObserver {
    fn vertex(&mut self, _depth: u32, _vertex: &Vertex, _beta: Vec3, _emitted: Vec3) {}
    /// Of the vertex last met.
    fn direct(&mut self, _direct: Vec3) {}
    fn scattered(&mut self, _depth: u32, _sample: &BsdfSample) {}
    fn escaped(&mut self, _depth: u32, _beta: Vec3, _radiance: Vec3, _d: Vec3) {}
    /// Camera rays that meet no surface see nothing.
    fn hides_backdrop(&self) -> bool {
        false
    }
    /// A path of throughput `_beta` ended before the light did.
    fn cut(&mut self, _why: Truncation, _beta: Vec3) {}
}

/// Nobody looks; only what alters the estimate is written down.
impl PathObserver for BiasReport {
    fn cut(&mut self, why: Truncation, beta: Vec3) {
        self.cut(why, beta);
    }
}

/// Writes down a path that ends at a vertex which would have scattered on.
pub(crate) fn cut_short<O: PathObserver>(vertex: &Vertex, beta: Vec3, observer: &mut O) {
    if !vertex.shading.unlit && !vertex.bsdf.lobes().is_empty() {
        observer.cut(Truncation::Depth, beta * vertex.bsdf.albedo());
    }
}
