//! Everything rays can hit, behind two queries.
//!
//! Static meshes share one flattened tree; spheres and disks stand beside it. At equal distance the lowest object,
//! then the lowest triangle wins, whatever the tree looks like.

use crate::bvh::{Candidate, Kernel, Tree, TriangleHit};
use crate::shapes::{Disk, Shape, Sphere};
use crate::surface::{geometric_normal, interpolate};
use crate::{Hit, Mesh, Ray, Surface};
use glam::{Vec2, Vec3, Vec4};
use std::ops::{Add, Mul};

/// Decides whether a candidate hit counts (alpha). `OPAQUE = true` compiles the question out of traversal.
pub trait Filter {
    /// Everything counts.
    const OPAQUE: bool;
    /// Whether this hit counts.
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

#[derive(Debug)]
enum Object {
    /// Mesh index and its first triangle in the flat tree.
    Mesh {
        mesh: u32,
        first: u32,
    },
    Shape(Shape),
}

/// Collects what the world is made of.
#[derive(Debug, Default)]
pub struct WorldBuilder {
    meshes: Vec<Mesh>,
    objects: Vec<Object>,
    triangles: u32,
}

impl WorldBuilder {
    /// Static mesh, positions already in world space. Triangles with indices out of range are never hit.
    /// Returns the object's index.
    pub fn add_mesh(&mut self, mut mesh: Mesh) -> u32 {
        let n = mesh.positions.len() as u32;
        for t in &mut mesh.triangles {
            if t.iter().any(|&i| i >= n) {
                *t = [0; 3];
            }
        }
        if n == 0 {
            mesh.triangles.clear();
        }
        let first = self.triangles;
        self.triangles += mesh.triangles.len() as u32;
        self.meshes.push(mesh);
        self.push(Object::Mesh { mesh: self.meshes.len() as u32 - 1, first })
    }

    /// An exact sphere.
    pub fn add_sphere(&mut self, sphere: Sphere) -> u32 {
        self.push(Object::Shape(Shape::Sphere(sphere)))
    }

    /// An exact disk.
    pub fn add_disk(&mut self, disk: Disk) -> u32 {
        self.push(Object::Shape(Shape::Disk(disk)))
    }

    fn push(&mut self, object: Object) -> u32 {
        self.objects.push(object);
        self.objects.len() as u32 - 1
    }

    /// The world, with the fastest traversal this machine has.
    pub fn build(self) -> World {
        let kernel = Kernel::available()[0];
        self.build_with(kernel)
    }

    /// As `build`, with traversal pinned to one kernel.
    pub fn build_with(self, kernel: Kernel) -> World {
        let mut corners = Vec::with_capacity(self.triangles as usize);
        let mut object_of = Vec::with_capacity(self.triangles as usize);
        let mut shapes = Vec::new();
        for (id, object) in self.objects.iter().enumerate() {
            match object {
                Object::Mesh { mesh, .. } => {
                    let mesh = &self.meshes[*mesh as usize];
                    corners.extend(mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize])));
                    object_of.resize(corners.len(), id as u32);
                }
                Object::Shape(shape) => shapes.push((id as u32, *shape)),
            }
        }
        let tree = Tree::build(&corners).with_kernel(kernel);
        World { tree, object_of, shapes, meshes: self.meshes, objects: self.objects }
    }
}

/// Everything rays can hit.
#[derive(Debug)]
pub struct World {
    tree: Tree,
    /// Object of each triangle of the flat tree.
    object_of: Vec<u32>,
    shapes: Vec<(u32, Shape)>,
    meshes: Vec<Mesh>,
    objects: Vec<Object>,
}

/// Turns the tree's triangle ids into objects for the filter.
struct Flat<'a, F> {
    world: &'a World,
    filter: &'a F,
}

impl<F: Filter> Candidate for Flat<'_, F> {
    const OPAQUE: bool = F::OPAQUE;
    fn accept(&self, hit: &TriangleHit) -> bool {
        self.filter.accept(&self.world.flat_hit(hit))
    }
}

impl World {
    /// The nearest hit that counts, 0 < t < t_max. `time` in seconds within the shutter.
    #[inline]
    pub fn closest<F: Filter>(&self, ray: &Ray, _time: f32, filter: &F) -> Option<Hit> {
        let flat = self.tree.closest(ray, &Flat { world: self, filter }).map(|hit| self.flat_hit(&hit));
        if self.shapes.is_empty() { flat } else { self.closest_shape(ray, filter, flat) }
    }

    /// Whether anything that counts lies at 0 < t < t_max.
    #[inline]
    pub fn blocked<F: Filter>(&self, ray: &Ray, _time: f32, filter: &F) -> bool {
        self.tree.blocked(ray, &Flat { world: self, filter })
            || (!self.shapes.is_empty() && self.shape_blocks(ray, filter))
    }

    fn closest_shape<F: Filter>(&self, ray: &Ray, filter: &F, mut best: Option<Hit>) -> Option<Hit> {
        for (object, t) in self.shape_hits(ray) {
            let nearer = best.is_none_or(|b| t < b.t || (t == b.t && object < b.object));
            let hit = Hit { t, u: 0.0, v: 0.0, primitive: 0, object };
            if nearer && (F::OPAQUE || filter.accept(&hit)) {
                best = Some(hit);
            }
        }
        best
    }

    fn shape_blocks<F: Filter>(&self, ray: &Ray, filter: &F) -> bool {
        self.shape_hits(ray)
            .any(|(object, t)| F::OPAQUE || filter.accept(&Hit { t, u: 0.0, v: 0.0, primitive: 0, object }))
    }

    fn shape_hits<'a>(&'a self, ray: &'a Ray) -> impl Iterator<Item = (u32, f32)> + 'a {
        self.shapes.iter().flat_map(move |(object, shape)| {
            shape.intersect(ray).into_iter().flatten().map(move |t| (*object, t))
        })
    }

    #[inline]
    fn flat_hit(&self, hit: &TriangleHit) -> Hit {
        let object = self.object_of[hit.triangle as usize];
        let first = match self.objects[object as usize] {
            Object::Mesh { first, .. } => first,
            Object::Shape(_) => 0,
        };
        Hit { t: hit.t, u: hit.u, v: hit.v, primitive: hit.triangle - first, object }
    }

    /// Position, error bound and normals of a hit (on triangles from barycentrics, never o + t·d).
    pub fn surface(&self, ray: &Ray, _time: f32, hit: &Hit) -> Surface {
        let Some((mesh, triangle)) = self.mesh_triangle(hit.object, hit.primitive) else {
            return match &self.objects[hit.object as usize] {
                Object::Shape(shape) => shape.surface(ray, hit),
                Object::Mesh { .. } => Surface { p: ray.o, p_error: Vec3::ZERO, ng: Vec3::Z, ns: Vec3::Z },
            };
        };
        let corners = triangle.map(|i| mesh.positions[i as usize]);
        let (p, p_error) = interpolate(&corners, hit.u, hit.v);
        let ng = geometric_normal(&corners);
        let ns =
            if mesh.normals.is_empty() { ng } else { shading_normal(mix(&mesh.normals, triangle, hit), ng) };
        Surface { p, p_error, ng, ns }
    }

    /// Interpolated texture coordinates; zero when the mesh has none.
    pub fn uv(&self, hit: &Hit, set: usize) -> Vec2 {
        match self.mesh_triangle(hit.object, hit.primitive) {
            Some((mesh, t)) if set < 2 && !mesh.uv[set].is_empty() => mix(&mesh.uv[set], t, hit),
            _ => Vec2::ZERO,
        }
    }

    /// Interpolated tangent with the sign of the bitangent in w; None without tangents.
    pub fn tangent(&self, hit: &Hit) -> Option<Vec4> {
        let (mesh, t) = self.mesh_triangle(hit.object, hit.primitive)?;
        (!mesh.tangents.is_empty()).then(|| {
            let [a, b, c] = t.map(|i| mesh.tangents[i as usize]);
            let xyz = a.truncate() * (1.0 - hit.u - hit.v) + b.truncate() * hit.u + c.truncate() * hit.v;
            xyz.extend(a.w)
        })
    }

    /// Interpolated vertex colour; white when the mesh has none.
    pub fn color(&self, hit: &Hit) -> Vec4 {
        match self.mesh_triangle(hit.object, hit.primitive) {
            Some((mesh, t)) if !mesh.colors.is_empty() => mix(&mesh.colors, t, hit),
            _ => Vec4::ONE,
        }
    }

    fn mesh_triangle(&self, object: u32, primitive: u32) -> Option<(&Mesh, [u32; 3])> {
        match self.objects.get(object as usize)? {
            Object::Mesh { mesh, .. } => {
                let mesh = &self.meshes[*mesh as usize];
                Some((mesh, *mesh.triangles.get(primitive as usize)?))
            }
            Object::Shape(_) => None,
        }
    }

    /// World-space corners of a triangle; zeros for a shape.
    pub fn corners(&self, object: u32, primitive: u32) -> [Vec3; 3] {
        self.mesh_triangle(object, primitive)
            .map_or([Vec3::ZERO; 3], |(mesh, t)| t.map(|i| mesh.positions[i as usize]))
    }

    /// Triangles of all meshes.
    pub fn triangle_count(&self) -> usize {
        self.object_of.len()
    }

    /// Objects added.
    pub fn object_count(&self) -> usize {
        self.objects.len()
    }

    /// Box around everything; None when there is nothing.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let boxes = self.tree.bounds().into_iter().chain(self.shapes.iter().map(|(_, shape)| shape.bounds()));
        boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// The traversal kernel in use.
    pub fn kernel(&self) -> Kernel {
        self.tree.kernel()
    }

    /// Bytes of tree and meshes.
    pub fn memory_bytes(&self) -> usize {
        self.tree.memory_bytes()
            + self.object_of.len() * 4
            + self.meshes.iter().map(Mesh::memory_bytes).sum::<usize>()
    }
}

/// Barycentric mixture of three entries.
fn mix<T: Copy + Mul<f32, Output = T> + Add<Output = T>>(values: &[T], triangle: [u32; 3], hit: &Hit) -> T {
    let [a, b, c] = triangle.map(|i| values[i as usize]);
    a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v
}

/// Interpolated normal made unit, in the hemisphere of `ng`; `ng` itself when degenerate.
fn shading_normal(interpolated: Vec3, ng: Vec3) -> Vec3 {
    let n = interpolated.normalize_or_zero();
    if n == Vec3::ZERO || !n.is_finite() {
        ng
    } else if n.dot(ng) < 0.0 {
        -n
    } else {
        n
    }
}
