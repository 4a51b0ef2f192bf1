//! Triangle meshes: corners and what is interpolated over them.

use glam::{Vec2, Vec3, Vec4};

/// Indexed triangles; counter-clockwise is the front. Attribute vectors are empty when absent, else one entry per
/// position.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Corners.
    pub positions: Vec<Vec3>,
    /// Three positions each.
    pub triangles: Vec<[u32; 3]>,
    /// Shading normals; interpolated, need not be unit.
    pub normals: Vec<Vec3>,
    /// xyz tangent, w = ±1 sign of the bitangent.
    pub tangents: Vec<Vec4>,
    /// Two sets of texture coordinates.
    pub uv: [Vec<Vec2>; 2],
    /// Linear RGBA.
    pub colors: Vec<Vec4>,
}

impl Mesh {
    /// Bytes of all vectors.
    pub fn memory_bytes(&self) -> usize {
        self.positions.len() * 12
            + self.triangles.len() * 12
            + self.normals.len() * 12
            + self.tangents.len() * 16
            + (self.uv[0].len() + self.uv[1].len()) * 8
            + self.colors.len() * 16
    }
}
