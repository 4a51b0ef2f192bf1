//! Shape of an object for light creation, and its motion.
use dapple_math::Motion;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Shape of an object as required to create its lights.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Form {
    Triangles(usize),
    Sphere { centre: Vec3, radius: f32 },
    Disk { centre: Vec3, normal: Vec3, radius: f32 },
}

/// Motion of an object while the shutter is open; its form is then given in its own space.
#[derive(Clone, Debug)]
pub(crate) struct Movement {
    pub motion: Arc<Motion>,
    /// Exposure time in seconds.
    pub seconds: f32,
    /// Render-space bounding box of the object over the whole exposure.
    pub whole: (DVec3, DVec3),
    /// Whether a sphere or disk remains one at all times; true for triangles.
    pub stays_round: bool,
}

impl Form {
    /// Number of triangles; None for a sphere or disk.
    pub fn triangles(&self) -> Option<usize> {
        if let Self::Triangles(count) = self { Some(*count) } else { None }
    }

    /// Number of values of `Hit::primitive`.
    pub fn primitives(&self) -> usize {
        self.triangles().unwrap_or(1)
    }
}
