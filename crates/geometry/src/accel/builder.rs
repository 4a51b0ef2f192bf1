//! The builder of the acceleration structure: collects objects, then decides which are flattened, which are instances
//! and which move.
use super::facets::Facets;
use super::objects::{Body, Object, Place, baked};
use super::queries::Accel;
use super::second::SecondLevel;
use crate::Mesh;
use crate::bvh::{Kernel, Tree};
use crate::shapes::{Disk, Shape, Sphere};
use dapple_math::motion::{Motion, Pose};
use glam::{DAffine3, Vec3};
use std::sync::Arc;

/// Collects the objects of an acceleration structure.
#[derive(Debug, Default)]
pub struct AccelBuilder {
    objects: Vec<(Body, Option<Motion>)>,
}

impl AccelBuilder {
    /// Adds a static mesh whose positions are already in world (render) space and returns the index of the object.
    /// Triangles with indices out of range, without area or with corners that are not finite keep their ids and are
    /// never hit.
    pub fn add_mesh(&mut self, mesh: Mesh) -> u32 {
        self.push(Body::Mesh(Arc::new(mesh)), None)
    }

    /// Adds a placed mesh, which other objects may share; a mesh that is used once is flattened into world space.
    pub fn add_instance(&mut self, mesh: impl Into<Arc<Mesh>>, transform: DAffine3) -> u32 {
        self.push(Body::Mesh(mesh.into()), Some(Motion::fixed(transform)))
    }

    /// Adds a mesh that may move; it is flattened if it does not move while the shutter is open and no other object
    /// shares it.
    pub fn add_moving(&mut self, mesh: impl Into<Arc<Mesh>>, motion: Motion) -> u32 {
        self.push(Body::Mesh(mesh.into()), Some(motion))
    }

    /// Adds an exact sphere.
    pub fn add_sphere(&mut self, sphere: Sphere) -> u32 {
        self.push(Body::Shape(Shape::Sphere(sphere)), None)
    }

    /// Adds an exact disk.
    pub fn add_disk(&mut self, disk: Disk) -> u32 {
        self.push(Body::Shape(Shape::Disk(disk)), None)
    }

    /// Adds an exact sphere or disk in its own object space; a non-uniform scale makes it an exact ellipsoid or
    /// ellipse.
    pub fn add_moving_shape(&mut self, shape: Shape, motion: Motion) -> u32 {
        self.push(Body::Shape(shape), Some(motion))
    }

    fn push(&mut self, body: Body, motion: Option<Motion>) -> u32 {
        self.objects.push((body, motion));
        self.objects.len() as u32 - 1
    }

    /// Builds the acceleration structure for the instant 0, with the fastest traversal kernel of this machine.
    pub fn build(self) -> Accel {
        self.build_with(Kernel::available()[0])
    }

    /// As `build`, with the given traversal kernel.
    pub fn build_with(self, kernel: Kernel) -> Accel {
        self.build_for_with(0.0, 0.0, kernel)
    }

    /// Builds the acceleration structure for the shutter interval from `shutter_open` to `shutter_close`, in seconds.
    pub fn build_for(self, shutter_open: f32, shutter_close: f32) -> Accel {
        self.build_for_with(shutter_open, shutter_close, Kernel::available()[0])
    }

    /// As `build_for`, with the given traversal kernel. A shutter that closes before it opens, or whose closing time is
    /// not finite, is the instant of its opening; an opening time that is not finite is 0.
    pub fn build_for_with(self, shutter_open: f32, shutter_close: f32, kernel: Kernel) -> Accel {
        let open = if shutter_open.is_finite() { shutter_open } else { 0.0 };
        let close = if shutter_close.is_finite() { shutter_close.max(open) } else { open };
        let shutter = (open, close);
        let shared = shared(&self.objects);
        let mut objects: Vec<Object> = (self.objects.into_iter().zip(shared))
            .map(|((body, motion), shared)| place(body, motion, shared, shutter))
            .collect();
        let (corners, object_of) = flatten(&mut objects);
        let tree = Tree::build(&corners).with_kernel(kernel);
        let triangles = objects.iter().filter_map(Object::mesh).map(|m| m.triangles.len()).sum();
        let facets = Facets::new(&objects, object_of.len());
        let second = SecondLevel::build(&mut objects, shutter, kernel).map(Box::new);
        Accel { kernel: tree.kernel(), tree, object_of, objects, facets, second, shutter, triangles }
    }
}

/// Whether each object shares its mesh with another one.
fn shared(objects: &[(Body, Option<Motion>)]) -> Vec<bool> {
    let address = |body: &Body| match body {
        Body::Mesh(mesh) => Arc::as_ptr(mesh) as usize,
        Body::Shape(_) => 0,
    };
    let mut all: Vec<usize> = objects.iter().map(|(body, _)| address(body)).collect();
    all.sort_unstable();
    let uses = |a: usize| all.partition_point(|&x| x <= a) - all.partition_point(|&x| x < a);
    objects.iter().map(|(body, _)| uses(address(body)) > 1).collect()
}

/// Decides the placement of an object; a static mesh that is not shared is transformed to world space.
fn place(body: Body, motion: Option<Motion>, shared: bool, (open, close): (f32, f32)) -> Object {
    let (open, close) = (f64::from(open), f64::from(close));
    let (body, place) = match (body, motion) {
        (body, None) => (body, Place::World),
        (body, Some(motion)) if motion.is_moving_within(open, close) => {
            (body, Place::Moving(Box::new(motion)))
        }
        (body, Some(motion)) => match (motion.pose_at(open), body) {
            (None, body) => (body, Place::Nowhere(motion.at(open))),
            (Some(pose), Body::Mesh(mesh)) if !shared => {
                (Body::Mesh(Arc::new(baked(&mesh, &pose))), Place::World)
            }
            (Some(pose), body) if pose == Pose::IDENTITY => (body, Place::World),
            (Some(pose), body) => (body, Place::Fixed(Box::new(pose))),
        },
    };
    Object { body, place, first: 0, tree: 0 }
}

/// The corners of all triangles in world space, and the object of each triangle.
fn flatten(objects: &mut [Object]) -> (Vec<[Vec3; 3]>, Vec<u32>) {
    let (mut corners, mut object_of) = (Vec::new(), Vec::new());
    for (id, object) in objects.iter_mut().enumerate() {
        if let (Body::Mesh(mesh), Place::World) = (&object.body, &object.place) {
            object.first = corners.len() as u32;
            corners.extend((0..mesh.triangles.len() as u32).map(|t| mesh.corners(t)));
            object_of.resize(corners.len(), id as u32);
        }
    }
    (corners, object_of)
}
