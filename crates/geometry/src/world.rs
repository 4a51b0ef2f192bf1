//! Everything rays can hit, behind two queries.
use crate::{
    Hit, Mesh, Ray, Surface,
    bvh::Kernel,
    shapes::{Disk, Sphere},
};
use glam::{Vec2, Vec3, Vec4};
/// Decides whether a candidate hit counts (alpha). `OPAQUE = true` compiles the question out of traversal.
pub trait Filter {
    const OPAQUE: bool;
    fn accept(&self, hit: &Hit) -> bool;
}
/// Everything is solid.
#[derive(Clone, Copy, Debug)]
pub struct Opaque;
impl Filter for Opaque {
    const OPAQUE: bool = true;
    fn accept(&self, _: &Hit) -> bool {
        true
    }
}
#[derive(Debug, Default)]
pub struct WorldBuilder {}
impl WorldBuilder {
    /// Static mesh, positions already in world (render) space. Returns the object's index.
    pub fn add_mesh(&mut self, _mesh: Mesh) -> u32 {
        todo!()
    }
    pub fn add_sphere(&mut self, _sphere: Sphere) -> u32 {
        todo!()
    }
    pub fn add_disk(&mut self, _disk: Disk) -> u32 {
        todo!()
    }
    pub fn build(self) -> World {
        todo!()
    }
    /// As `build`, with traversal pinned to one kernel.
    pub fn build_with(self, _kernel: Kernel) -> World {
        todo!()
    }
}
#[derive(Debug)]
pub struct World {}
impl World {
    pub fn closest<F: Filter>(&self, _ray: &Ray, _time: f32, _filter: &F) -> Option<Hit> {
        todo!()
    }
    pub fn blocked<F: Filter>(&self, _ray: &Ray, _time: f32, _filter: &F) -> bool {
        todo!()
    }
    /// Position, error bound and normals of a hit (position from barycentrics, never o + t·d, for triangles).
    pub fn surface(&self, _ray: &Ray, _time: f32, _hit: &Hit) -> Surface {
        todo!()
    }
    /// Interpolated texture coordinates; zero when the mesh has none.
    pub fn uv(&self, _hit: &Hit, _set: usize) -> Vec2 {
        todo!()
    }
    /// Interpolated tangent with the sign of the bitangent in w; None without tangents.
    pub fn tangent(&self, _hit: &Hit) -> Option<Vec4> {
        todo!()
    }
    /// Interpolated vertex colour; white when the mesh has none.
    pub fn color(&self, _hit: &Hit) -> Vec4 {
        todo!()
    }
    /// World-space corners of a triangle.
    pub fn corners(&self, _object: u32, _primitive: u32) -> [Vec3; 3] {
        todo!()
    }
    pub fn triangle_count(&self) -> usize {
        todo!()
    }
    pub fn object_count(&self) -> usize {
        todo!()
    }
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        todo!()
    }
    pub fn kernel(&self) -> Kernel {
        todo!()
    }
    pub fn memory_bytes(&self) -> usize {
        todo!()
    }
}
