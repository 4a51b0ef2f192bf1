//! Selection of the vertex attributes that a mesh keeps for its material.
use crate::{TexturedMaterial, tangent};
use dapple_geometry::Mesh;
use glam::Vec4;

/// Keeps tangents only if a normal map needs them, generates missing ones, and removes vertex colours that are all
/// white. `everything` keeps all attributes of the file.
pub(crate) fn for_material(mut mesh: Mesh, material: &TexturedMaterial, everything: bool) -> Mesh {
    if !everything && mesh.colors.iter().all(|c| *c == Vec4::ONE) {
        mesh.colors = Vec::new();
    }
    match &material.normal_texture {
        None if everything => mesh,
        None => {
            mesh.tangents = Vec::new();
            mesh
        }
        // Tangents of a mesh without normals are ignored (glTF 2.0 §3.7.2.1).
        Some(map) if mesh.tangents.is_empty() || mesh.normals.is_empty() => {
            mesh.tangents = Vec::new();
            tangent::with_tangents(mesh, map)
        }
        Some(_) => mesh,
    }
}
