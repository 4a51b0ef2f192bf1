//! Which attributes does a mesh keep for its material?
use crate::{TexturedMaterial, tangent};
use dapple_geometry::Mesh;
use glam::Vec4;

/// Tangents only where a normal map needs them: generated if missing, dropped if useless; white vertex colours are
/// none. `everything` keeps what a file gives.
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
        // Tangents of a file that gives no normals do not count (glTF 2.0 §3.7.2.1).
        Some(map) if mesh.tangents.is_empty() || mesh.normals.is_empty() => {
            mesh.tangents = Vec::new();
            tangent::with_tangents(mesh, map)
        }
        Some(_) => mesh,
    }
}
