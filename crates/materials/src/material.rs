//! What a surface is made of, as plain numbers at one point (textures already looked up).
use glam::Vec3;
/// glTF metallic-roughness with its extensions. Defaults are glTF's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    pub base_color: Vec3,
    pub metallic: f32,
    /// Perceptual roughness; alpha = roughness².
    pub roughness: f32,
    /// Index of refraction of the inside over the outside.
    pub ior: f32,
    /// KHR_materials_specular.
    pub specular: f32,
    pub specular_color: Vec3,
    /// KHR_materials_transmission, 0..1.
    pub transmission: f32,
    /// Infinitely thin wall (no KHR_materials_volume): transmitted light keeps its direction (blurred by roughness).
    pub thin: bool,
    /// Square-blur mirror (dapple extras): replaces everything else.
    pub mirror: Option<Mirror>,
    /// Shadeless (KHR_materials_unlit) is handled by the scene, not here.
    pub _private: (),
}
/// `k_r` times the mean over the square of side `blur` about the mirror direction; 0 = perfect mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    pub kr: Vec3,
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
