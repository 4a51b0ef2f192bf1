//! How points on area lights are sampled: by solid angle, by area, or as one central point; and hits on lights.
use glam::{Vec2, Vec3};

/// How the points of area lights are sampled. Other lights ignore it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Aiming {
    /// Uniformly in solid angle where that reduces noise ([`crate::Light::sample`]): the least noise.
    #[default]
    SolidAngle,
    /// Uniformly over the surface: equal u is the same point for every receiver, so that a fixed set of u turns the
    /// light into a set of point lights [Cook 1984].
    Surface,
    /// The whole power of the light from its centroid, as a point light: no soft shadows. No ray hits it.
    Centroid,
}

/// A hit on a light.
#[derive(Clone, Copy, Debug)]
pub struct Reached {
    /// Unit direction of the ray.
    pub wi: Vec3,
    /// Distance to the hit; infinite for the environment.
    pub distance: f32,
    /// Geometric normal at the hit.
    pub n: Vec3,
    /// Barycentric coordinates of the hit, of corners 1 and 2 of the triangle; zero for other shapes.
    pub at: Vec2,
}
