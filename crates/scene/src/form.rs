//! What an object looks like to a light, and how it moves.
use dapple_math::Motion;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// What an object looks like to a light.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Form {
    Triangles(usize),
    Sphere { centre: Vec3, radius: f32 },
    Disk { centre: Vec3, normal: Vec3, radius: f32 },
}

/// How an object moves while the shutter is open; its form is then given in its own space.
#[derive(Clone, Debug)]
pub(crate) struct Movement {
    pub motion: Arc<Motion>,
    /// How long the shutter is open.
    pub seconds: f32,
    /// Box that the object stays in meanwhile.
    pub whole: (DVec3, DVec3),
    /// A round shape is round all the way; true for triangles.
    pub stays_round: bool,
}

impl Form {
    /// How many triangles; None for a shape.
    pub fn triangles(&self) -> Option<usize> {
        if let Self::Triangles(count) = self { Some(*count) } else { None }
    }

    /// How many values `Hit::primitive` can take.
    pub fn primitives(&self) -> usize {
        self.triangles().unwrap_or(1)
    }
}
