//! Observers of a sample in progress: layers of first hits, replayed paths, and the bias report.

use crate::bias_report::{BiasReport, Truncation};
use crate::vertex::Vertex;
use dapple_materials::BsdfSample;
use glam::Vec3;

/// Receives the rays of a sample as they are traced; an observer without methods costs nothing.
pub(crate) trait PathObserver {
    fn vertex(&mut self, _depth: u32, _vertex: &Vertex, _beta: Vec3, _emitted: Vec3) {}
    /// Direct light of the last vertex.
    fn direct(&mut self, _direct: Vec3) {}
    fn scattered(&mut self, _depth: u32, _sample: &BsdfSample) {}
    fn escaped(&mut self, _depth: u32, _beta: Vec3, _radiance: Vec3, _d: Vec3) {}
    /// Whether camera rays that hit no surface return black instead of the environment.
    fn hides_backdrop(&self) -> bool {
        false
    }
    /// A path of throughput `_beta` was truncated.
    fn cut(&mut self, _why: Truncation, _beta: Vec3) {}
}

/// Records only the bias events.
impl PathObserver for BiasReport {
    fn cut(&mut self, why: Truncation, beta: Vec3) {
        self.cut(why, beta);
    }
}

/// Reports a path that is truncated at a vertex which would have scattered it.
pub(crate) fn cut_short<O: PathObserver>(vertex: &Vertex, beta: Vec3, observer: &mut O) {
    if !vertex.shading.unlit && !vertex.bsdf.lobes().is_empty() {
        observer.cut(Truncation::Depth, beta * vertex.bsdf.albedo());
    }
}
