//! Indexed triangle meshes with interpolated attributes.
//!
//! The front side is the one from which the corners are counter-clockwise. All accessors are total, so that a mesh from
//! any source is safe: a triangle with an index out of range is degenerate (never hit), and an attribute whose length
//! differs from that of `positions` counts as absent where it has no entry.
use glam::{Vec2, Vec3, Vec4};

/// Indexed triangles. Attribute vectors are empty when absent, else they have one entry per position.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Corner positions.
    pub positions: Vec<Vec3>,
    /// Indices into `positions`, counter-clockwise from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Unit shading normals.
    pub normals: Vec<Vec3>,
    /// Tangents: direction in xyz, sign of the bitangent (±1) in w.
    pub tangents: Vec<Vec4>,
    /// Two sets of texture coordinates.
    pub uv: [Vec<Vec2>; 2],
    /// Linear RGBA factors.
    pub colors: Vec<Vec4>,
}

impl Mesh {
    /// The corners of a triangle; three zeros when the triangle does not exist or an index is out of range.
    pub fn corners(&self, primitive: u32) -> [Vec3; 3] {
        self.values(&self.positions, primitive).unwrap_or([Vec3::ZERO; 3])
    }

    /// The values of an attribute at the three corners; None when it is absent at any corner.
    pub fn values<T: Copy>(&self, attribute: &[T], primitive: u32) -> Option<[T; 3]> {
        if attribute.is_empty() {
            return None;
        }
        let [a, b, c] = *self.triangles.get(primitive as usize)?;
        Some([*attribute.get(a as usize)?, *attribute.get(b as usize)?, *attribute.get(c as usize)?])
    }

    /// Texture coordinates of set 0 or 1 at barycentric coordinates (u, v); zero when absent.
    pub fn uv_at(&self, set: usize, primitive: u32, u: f32, v: f32) -> Vec2 {
        let Some(values) = self.uv.get(set).and_then(|uv| self.values(uv, primitive)) else {
            return Vec2::ZERO;
        };
        let [a, b, c] = values;
        a * (1.0 - u - v) + b * u + c * v
    }

    /// Interpolated tangent (not normalised), with the bitangent sign of corner 0; None when absent.
    pub fn tangent_at(&self, primitive: u32, u: f32, v: f32) -> Option<Vec4> {
        let [a, b, c] = self.values(&self.tangents, primitive)?;
        let t = a.truncate() * (1.0 - u - v) + b.truncate() * u + c.truncate() * v;
        Some(t.extend(if a.w < 0.0 { -1.0 } else { 1.0 }))
    }

    /// Interpolated vertex colour; white when absent.
    pub fn color_at(&self, primitive: u32, u: f32, v: f32) -> Vec4 {
        match self.values(&self.colors, primitive) {
            Some([a, b, c]) => a * (1.0 - u - v) + b * u + c * v,
            None => Vec4::ONE,
        }
    }

    /// Heap memory in bytes.
    pub fn memory_bytes(&self) -> usize {
        fn bytes<T>(v: &[T]) -> usize {
            std::mem::size_of_val(v)
        }
        let uv = bytes(&self.uv[0]) + bytes(&self.uv[1]);
        let frames = bytes(&self.normals) + bytes(&self.tangents);
        bytes(&self.positions) + bytes(&self.triangles) + frames + uv + bytes(&self.colors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2], [0, 1, 9]],
            uv: [vec![Vec2::ZERO, Vec2::X, Vec2::Y], vec![]],
            ..Mesh::default()
        }
    }

    #[test]
    fn interpolates_what_is_there() {
        let m = triangle();
        assert_eq!(m.uv_at(0, 0, 0.25, 0.5), Vec2::new(0.25, 0.5));
        assert_eq!(m.uv_at(1, 0, 0.25, 0.5), Vec2::ZERO);
        assert_eq!(m.uv_at(7, 0, 0.25, 0.5), Vec2::ZERO);
        assert_eq!(m.color_at(0, 0.25, 0.5), Vec4::ONE);
        assert_eq!(m.tangent_at(0, 0.25, 0.5), None);
    }

    #[test]
    fn bad_indices_are_degenerate() {
        let m = triangle();
        assert_eq!(m.corners(1), [Vec3::ZERO; 3]);
        assert_eq!(m.corners(99), [Vec3::ZERO; 3]);
        assert_eq!(m.uv_at(0, 1, 0.1, 0.1), Vec2::ZERO);
    }
}
