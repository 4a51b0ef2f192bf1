//! Which points of an area light are aimed at: those that even out its solid angle, its surface, or its one middle.
use glam::{Vec2, Vec3};

/// How the points of area lights are chosen. Other lights do not care.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Aiming {
    /// Evenly in solid angle where that pays ([`crate::Light::sample`]): the least noise.
    #[default]
    SolidAngle,
    /// Evenly over the surface: equal u is the same point from everywhere, so that a fixed set of u makes the light a
    /// set of point lights [Cook 1984].
    Surface,
    /// All of the light's power from its centroid, as a point light: no soft shadow. Never met by a ray.
    Centroid,
}

/// Where a ray reached a light.
#[derive(Clone, Copy, Debug)]
pub struct Reached {
    /// Unit direction of the ray.
    pub wi: Vec3,
    /// How far it went; infinite for the environment.
    pub distance: f32,
    /// Geometric normal there.
    pub n: Vec3,
    /// Barycentrics of the hit, of corners 1 and 2 of the triangle; zero for anything else.
    pub at: Vec2,
}
