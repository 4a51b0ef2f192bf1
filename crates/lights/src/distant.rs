//! Distant (directional) lights.
use crate::LightSample;
use glam::Vec3;

/// A light at infinity in one direction (`KHR_lights_punctual` directional light; lx are read as W/m²).
#[derive(Clone, Copy, Debug)]
pub struct Distant {
    /// Unit direction from the scene to the light.
    pub towards: Vec3,
    /// Irradiance on a surface that faces the light, W·m⁻² per channel.
    pub irradiance: Vec3,
}

impl Distant {
    pub(crate) fn sample(&self) -> LightSample {
        LightSample {
            wi: self.towards,
            pdf: 1.0,
            delta: true,
            radiance: self.irradiance,
            distance: f32::INFINITY,
            point: None,
        }
    }
}
