//! Objects, lights and cameras that move while the shutter is open, and their transformation to render space.
//!
//! A moving object is at the end of a chain of nodes, root first, some of them key-framed; every node is evaluated at
//! the time of the ray and the chain is composed in f64 ([`Motion`]). Static objects are handled elsewhere.
use crate::attributes::for_material;
use crate::builder::Body;
use crate::exposure::Exposure;
use crate::form::{Form, Movement};
use crate::{Placement, SceneBuilder, Space, TexturedMaterial, WorldPoint, bake};
use dapple_camera::{Camera, Shutter};
use dapple_geometry::{AccelBuilder, Mesh};
use dapple_math::Motion;
use dapple_math::motion::{Chain, Node};
use glam::{DAffine3, DVec3};
use std::{collections::HashMap, sync::Arc};

impl Exposure {
    /// Adds a body on a chain to the acceleration structure. `own` is the body's prepared mesh. The error describes the
    /// problem.
    pub fn insert(
        &self,
        accel: &mut AccelBuilder,
        body: &Body,
        chain: &Chain,
        own: Option<Own>,
        space: &Space,
    ) -> Result<(Form, Movement), &'static str> {
        let to_node = match (&own, body.radius()) {
            (Some(own), _) => own.to_node,
            (None, radius) => DAffine3::from_scale(DVec3::splat(radius.unwrap_or(1.0))),
        };
        let motion = self.motion(&chain.then(Node::Fixed(to_node)), space);
        let (lo, hi) = own.as_ref().map_or((-DVec3::ONE, DVec3::ONE), |own| own.bounds);
        let seconds = self.shutter.seconds();
        let whole = motion.bounds(lo, hi, 0.0, seconds.into());
        if !(whole.0.is_finite() && whole.1.is_finite()) {
            return Err("moves too far away: its coordinates overflow");
        }
        let form = match (body.unit_shape(), own) {
            (Some(shape), _) => {
                accel.add_moving_shape(shape, (*motion).clone());
                body.form()
            }
            (None, own) => {
                let mesh = own.map(|own| own.mesh).unwrap_or_default();
                let form = Form::Triangles(mesh.triangles.len());
                accel.add_moving(mesh, (*motion).clone());
                form
            }
        };
        let stays_round = chain.stays_round() || form.triangles().is_some();
        Ok((form, Movement { motion, seconds, whole, stays_round }))
    }

    /// The motion of a camera; None if it is static.
    pub fn camera(&self, chain: &Chain, own: &DAffine3, space: &Space) -> Option<Arc<Motion>> {
        Some(self.motion(&chain.then(Node::Fixed(*own)), space)).filter(|motion| self.is_moving(motion))
    }
}

/// Cache of meshes prepared in their own space, one per mesh and material.
#[derive(Default)]
pub(crate) struct OwnSpaces {
    /// Keyed by address. It is never iterated, so its order does not matter.
    known: HashMap<(usize, u32), Own>,
}

/// A mesh near unit scale about its own centre, and the transform back to the space of its node.
#[derive(Clone)]
pub(crate) struct Own {
    pub mesh: Arc<Mesh>,
    pub to_node: DAffine3,
    /// Bounding box of the mesh.
    pub bounds: (DVec3, DVec3),
    pub dropped: usize,
    pub repaired: usize,
}

impl OwnSpaces {
    /// The prepared mesh of a body; None if it is a sphere or disk.
    pub fn get(&mut self, body: &Body, index: u32, material: &TexturedMaterial) -> Option<Own> {
        let Body::Mesh(mesh) = body else { return None };
        let key = (Arc::as_ptr(mesh) as usize, index);
        Some(self.known.entry(key).or_insert_with(|| Own::new(mesh, material)).clone())
    }
}

impl Own {
    /// Prepares a mesh: whatever the size of its vertices and their distance from the origin, rays intersect them near
    /// unit scale (docs/science.md, "Render space").
    fn new(mesh: &Mesh, material: &TexturedMaterial) -> Self {
        let bounds = bake::bounds(mesh, &Placement::IDENTITY);
        let space = bounds.map_or(Space::IDENTITY, |(min, max)| Space::fit(WorldPoint(min), WorldPoint(max)));
        let baked = bake::bake(mesh, &Placement::IDENTITY, &space);
        let bounds = bake::bounds(&baked.mesh, &Placement::IDENTITY);
        Self {
            mesh: Arc::new(for_material(baked.mesh, material, false)),
            to_node: space.to_world_affine(),
            bounds: bounds.unwrap_or_default(),
            dropped: baked.dropped,
            repaired: baked.repaired,
        }
    }
}

impl SceneBuilder {
    /// Sets the exposure: `at` is the time of the animation in seconds, to which `shutter` is relative. The default is
    /// the instant 0.
    pub fn exposure(&mut self, at: f64, shutter: Shutter) {
        self.exposure = Exposure { at, shutter };
    }

    /// Adds a mesh at the end of a chain of nodes, root first; returns the object's index. A shared mesh (`Arc`) may be
    /// added many times.
    pub fn moving_mesh(
        &mut self,
        name: impl Into<Arc<str>>,
        mesh: impl Into<Arc<Mesh>>,
        chain: impl Into<Chain>,
        material: u32,
    ) -> u32 {
        self.place_moving(name, material, Body::Mesh(mesh.into()), chain.into())
    }

    /// Adds an exact sphere about the origin of the space at the end of a chain; returns the object's index.
    pub fn moving_sphere(
        &mut self,
        name: impl Into<Arc<str>>,
        radius: f64,
        chain: impl Into<Chain>,
        material: u32,
    ) -> u32 {
        self.place_moving(name, material, Body::Sphere { radius }, chain.into())
    }

    /// Adds an exact disk about the origin of the space at the end of a chain, facing its +z; returns the object's
    /// index.
    pub fn moving_disk(
        &mut self,
        name: impl Into<Arc<str>>,
        radius: f64,
        chain: impl Into<Chain>,
        material: u32,
    ) -> u32 {
        self.place_moving(name, material, Body::Disk { radius }, chain.into())
    }

    /// Adds a camera whose pose is relative to the space at the end of a chain.
    pub fn moving_camera(
        &mut self,
        name: impl Into<Arc<str>>,
        pose: crate::CameraPose,
        chain: impl Into<Chain>,
    ) {
        self.cameras.push((name.into(), pose, Some(chain.into())));
    }

    /// Attaches the light added last (point, spot or distant) to a chain: its position and direction are then relative
    /// to the space at the end of the chain. Its intensity and range keep world units.
    pub fn moving_light(&mut self, chain: impl Into<Chain>) {
        if let Some((_, slot)) = self.punctual.last_mut() {
            *slot = Some(chain.into());
        }
    }
}

/// Whether any camera moves.
pub(crate) fn any_moves<'a>(mut cameras: impl Iterator<Item = &'a Camera>) -> bool {
    cameras.any(|camera| camera.motion.is_some())
}
