//! Material parameters at one point, after texture lookup.

use glam::Vec3;

/// glTF metallic-roughness material with its extensions. Defaults are those of glTF.
///
/// `KHR_materials_unlit` is handled outside this crate: an unlit point has no BSDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Reflectance of the diffuse base and of metals along the normal, and tint of transmitted light; linear, 0..1.
    pub base_color: Vec3,
    /// Share of metal, 0..1.
    pub metallic: f32,
    /// Perceptual roughness 0..1; alpha = roughness².
    pub roughness: f32,
    /// Index of refraction of the inside relative to the outside; ≥ 1, or 0: the dielectric reflects `specular_color`
    /// at every angle (`KHR_materials_ior`).
    pub ior: f32,
    /// Strength of the dielectric reflection, 0..1; 0 leaves an exactly Lambertian surface (`KHR_materials_specular`).
    pub specular: f32,
    /// Tint of the dielectric reflection along the normal; may exceed 1, the reflectance does not.
    pub specular_color: Vec3,
    /// Fraction of the light entering the dielectric that is transmitted rather than scattered by the diffuse base,
    /// 0..1 (`KHR_materials_transmission`).
    pub transmission: f32,
    /// Whether the surface is an infinitely thin wall (no `KHR_materials_volume`): transmitted light keeps its
    /// direction, blurred by roughness.
    pub thin: bool,
    /// Mirror with square blur (dapple extras), which replaces the other layers.
    pub mirror: Option<Mirror>,
    #[doc(hidden)]
    pub _private: (),
}

/// Reflects `k_r` times the mean over a square of side `blur` about the mirror direction; 0 is a perfect mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Fraction of the light that is reflected.
    pub kr: Vec3,
    /// Side of the square, in the plane at distance one along the mirror direction.
    pub blur: f32,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            base_color: Vec3::ONE,
            metallic: 1.0,
            roughness: 1.0,
            ior: 1.5,
            specular: 1.0,
            specular_color: Vec3::ONE,
            transmission: 0.0,
            thin: true,
            mirror: None,
            _private: (),
        }
    }
}
