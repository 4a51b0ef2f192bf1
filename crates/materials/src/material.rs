//! What a surface is made of, as plain numbers at one point (textures already looked up).

use glam::Vec3;

/// glTF metallic-roughness with its extensions. Defaults are glTF's.
///
/// `KHR_materials_unlit` is no business of this crate: a shadeless point has no BSDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Reflectance of the diffuse base and of metals along the normal, tint of what is transmitted; linear, 0..1.
    pub base_color: Vec3,
    /// Share of metal, 0..1.
    pub metallic: f32,
    /// Perceptual roughness 0..1; alpha = roughness².
    pub roughness: f32,
    /// Index of refraction of the inside over the outside; ≥ 1, or 0: reflects like `specular_color` at every angle
    /// (`KHR_materials_ior`).
    pub ior: f32,
    /// Strength of the dielectric's reflection, 0..1; 0 leaves exactly Lambert (`KHR_materials_specular`).
    pub specular: f32,
    /// Tint of the dielectric's reflection along the normal; may exceed 1, the reflectance does not.
    pub specular_color: Vec3,
    /// Share of what enters the dielectric that goes through rather than into the diffuse base, 0..1
    /// (`KHR_materials_transmission`).
    pub transmission: f32,
    /// Infinitely thin wall (no `KHR_materials_volume`): transmitted light keeps its direction (blurred by roughness).
    pub thin: bool,
    /// Square-blur mirror (dapple extras): replaces everything else.
    pub mirror: Option<Mirror>,
    #[doc(hidden)]
    pub _private: (),
}

/// `k_r` times the mean over the square of side `blur` about the mirror direction; 0 = perfect mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Share of the light that is reflected.
    pub kr: Vec3,
    /// Side of the square, on the plane one unit away along the mirror direction.
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
