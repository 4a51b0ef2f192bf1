//! Triangle meshes: corners and what is interpolated over them.
use glam::{Vec2, Vec3, Vec4};
/// Indexed triangles. Attribute vectors are empty when absent, else one entry per position.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    pub normals: Vec<Vec3>,
    /// xyz tangent, w = ±1 sign of the bitangent.
    pub tangents: Vec<Vec4>,
    pub uv: [Vec<Vec2>; 2],
    pub colors: Vec<Vec4>,
}
