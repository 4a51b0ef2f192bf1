//! Replay of a single path, vertex by vertex: random numbers are keyed by decision, so that any sample of any render
//! can be reproduced.

use crate::job::Job;
use crate::kernel;
use crate::observer::PathObserver;
use crate::settings::Settings;
use crate::vertex::Vertex;
use dapple_camera::Camera;
use dapple_materials::BsdfSample;
use dapple_scene::Scene;
use glam::{DVec3, Vec3};

/// A vertex of a replayed path, in world space.
#[derive(Clone, Debug)]
pub struct PathVertex {
    /// Number of preceding scattering events. The tree of the distribution tracer is listed depth first: a vertex
    /// belongs to the last vertex of the previous depth.
    pub depth: u32,
    /// `surface` or `environment`.
    pub kind: String,
    /// Name of the object.
    pub object: String,
    /// Name of the material.
    pub material: String,
    /// Position in scene units; for the environment the direction.
    pub p: DVec3,
    /// Unit shading normal.
    pub n: Vec3,
    /// The lobes by which the path left the vertex; empty at its end.
    pub lobe: String,
    /// Solid-angle density of the last direction in which it left.
    pub pdf: f32,
    /// Throughput at arrival.
    pub beta: Vec3,
    /// Emitted radiance at the vertex, with its MIS weight.
    pub emitted: Vec3,
    /// Direct light by next-event estimation.
    pub direct: Vec3,
}

/// Replays sample `sample` of pixel `pixel`: the vertices of its path, and its radiance times the filter weight.
pub fn replay(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    pixel: (u32, u32),
    sample: u32,
) -> (Vec<PathVertex>, Vec3) {
    let job = Job::new(scene, camera, settings);
    let mut recorder = Recorder { scene, hides_backdrop: settings.transparent, vertices: Vec::new() };
    let (radiance, weight) = kernel::observed(&job, pixel, sample, &mut recorder, &mut 0);
    (recorder.vertices, radiance * weight)
}

struct Recorder<'a> {
    scene: &'a Scene,
    hides_backdrop: bool,
    vertices: Vec<PathVertex>,
}

impl PathObserver for Recorder<'_> {
    fn vertex(&mut self, depth: u32, vertex: &Vertex, beta: Vec3, emitted: Vec3) {
        let object = &self.scene.objects[vertex.hit.object as usize];
        self.vertices.push(PathVertex {
            depth,
            kind: "surface".into(),
            object: object.name.to_string(),
            material: self.scene.materials[object.material as usize].name.clone(),
            p: self.scene.space.to_world(vertex.surface.p).0,
            n: vertex.frame.z,
            lobe: String::new(),
            pdf: 0.0,
            beta,
            emitted,
            direct: Vec3::ZERO,
        });
    }

    fn direct(&mut self, direct: Vec3) {
        if let Some(last) = self.vertices.last_mut() {
            last.direct = direct;
        }
    }

    fn scattered(&mut self, depth: u32, sample: &BsdfSample) {
        if let Some(from) = self.vertices.iter_mut().rev().find(|v| v.depth == depth) {
            let lobe = format!("{:?}", sample.lobe);
            if !from.lobe.split('+').any(|known| known == lobe) {
                from.lobe += if from.lobe.is_empty() { "" } else { "+" };
                from.lobe += &lobe;
            }
            from.pdf = sample.pdf;
        }
    }

    fn hides_backdrop(&self) -> bool {
        self.hides_backdrop
    }

    fn escaped(&mut self, depth: u32, beta: Vec3, radiance: Vec3, d: Vec3) {
        self.vertices.push(PathVertex {
            depth,
            kind: "environment".into(),
            object: String::new(),
            material: String::new(),
            p: d.as_dvec3(),
            n: -d,
            lobe: String::new(),
            pdf: 0.0,
            beta,
            emitted: radiance,
            direct: Vec3::ZERO,
        });
    }
}
