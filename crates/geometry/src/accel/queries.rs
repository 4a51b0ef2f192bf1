//! The world, and what can be asked of it: what a ray hits, and what is there.

use super::objects::{Body, Object};
use super::second::SecondLevel;
use crate::bvh::{HitFilter, Kernel, Opaque, Tree, TriangleHit};
use crate::{Hit, Surface};
use dapple_math::Ray;
use glam::{DAffine3, Vec2, Vec3, Vec4};

/// Everything rays can hit.
#[derive(Debug)]
pub struct Accel {
    pub(super) tree: Tree,
    /// Object of each triangle of the flat tree.
    pub(super) object_of: Vec<u32>,
    pub(super) objects: Vec<Object>,
    pub(super) second: Option<Box<SecondLevel>>,
    pub(super) shutter: (f32, f32),
    pub(super) triangles: usize,
    pub(super) kernel: Kernel,
}

/// Turns the flat tree's triangle ids into objects for the filter.
struct Flat<'a, F> {
    accel: &'a Accel,
    filter: &'a F,
}

impl<F: HitFilter<Hit>> HitFilter<TriangleHit> for Flat<'_, F> {
    const OPAQUE: bool = F::OPAQUE;
    fn accept(&self, hit: &TriangleHit) -> bool {
        self.filter.accept(&self.accel.flat_hit(hit))
    }
}

impl Accel {
    /// The nearest hit that counts, 0 < t < t_max. `time` in seconds within the shutter (held to it).
    #[inline]
    pub fn intersect<F: HitFilter<Hit>>(&self, ray: &Ray, time: f32, filter: &F) -> Option<Hit> {
        let flat = self.tree.intersect(ray, &Flat { accel: self, filter }).map(|hit| self.flat_hit(&hit));
        match self.second() {
            None => flat,
            Some(second) => second.intersect(&self.objects, ray, self.held(time), filter, flat),
        }
    }

    /// Whether anything that counts lies at 0 < t < t_max.
    #[inline]
    pub fn occluded<F: HitFilter<Hit>>(&self, ray: &Ray, time: f32, filter: &F) -> bool {
        self.tree.occluded(ray, &Flat { accel: self, filter })
            || self
                .second()
                .is_some_and(|second| second.occluded(&self.objects, ray, self.held(time), filter))
    }

    /// What is beside the flat tree.
    #[inline]
    fn second(&self) -> Option<&SecondLevel> {
        self.second.as_deref().filter(|_| cfg!(not(without = "second_level")))
    }

    #[inline]
    fn flat_hit(&self, hit: &TriangleHit) -> Hit {
        let object = self.object_of[hit.triangle as usize];
        let primitive = hit.triangle - self.objects[object as usize].first;
        Hit { t: hit.t, u: hit.u, v: hit.v, primitive, object }
    }

    /// `time` held to the shutter the world was built for, for which its boxes are good.
    pub(super) fn held(&self, time: f32) -> f64 {
        // Not `clamp`: NaN becomes the opening.
        f64::from(time.max(self.shutter.0).min(self.shutter.1))
    }

    /// Position, error bound and normals of a hit: on triangles from barycentrics, on shapes put back onto the
    /// surface, never o + t·d.
    pub fn surface(&self, ray: &Ray, time: f32, hit: &Hit) -> Surface {
        let mut surface = match self.objects.get(hit.object as usize) {
            Some(object) => object.surface(ray, self.held(time), hit),
            None => Surface { p: ray.o, start: ray.o, p_error: Vec3::ZERO, ng: Vec3::Z, ns: Vec3::Z },
        };
        if surface.start != surface.p && self.is_clear(&surface, time) {
            surface.start = surface.p;
        }
        surface
    }

    /// Whether nothing stands about the edge from which a start was moved, on either side: not at a diagonal of a flat
    /// quad, at a free edge, or outside of a convex one. Asked from the start across the position, as far again beyond.
    #[cold]
    fn is_clear(&self, surface: &Surface, time: f32) -> bool {
        [surface.ng, -surface.ng].into_iter().all(|up| {
            let o = surface.origin_towards(up);
            let at = dapple_math::offset::offset_origin(surface.p, surface.p_error, surface.ng, up);
            let across = Ray { o, d: at - o, t_max: 2.0 };
            across.d == Vec3::ZERO || !self.occluded(&across, time, &Opaque)
        })
    }

    /// From a hit to the smooth surface that the normals of its triangle's corners span above it, on the side that `up`
    /// points to; zero where they span none, and on shapes. An *approximation* of the surface that the triangles stand
    /// for [Hanika 2021].
    pub fn lift(&self, hit: &Hit, up: Vec3, time: f32) -> Vec3 {
        let object = self.objects.get(hit.object as usize);
        object.map_or(Vec3::ZERO, |object| object.lift(hit, up, self.held(time)))
    }

    /// Interpolated texture coordinates; zero when the mesh has none. Shapes have their own.
    pub fn uv(&self, hit: &Hit, set: usize) -> Vec2 {
        match self.body(hit.object) {
            Some(Body::Mesh(mesh)) => mesh.uv_at(set, hit.primitive, hit.u, hit.v),
            Some(Body::Shape(shape)) => shape.uv(hit.u, hit.v),
            None => Vec2::ZERO,
        }
    }

    /// Surface coordinates ([`Hit::u`] and [`Hit::v`]) of the place on a shape nearest to `p` at a time; None for a mesh.
    pub fn coordinates_at(&self, object: u32, p: Vec3, time: f32) -> Option<Vec2> {
        self.objects.get(object as usize)?.coordinates_at(p, self.held(time))
    }

    /// Surface coordinates on a shape for `u` in \[0, 1\]², even in area in its own space; zero for a mesh.
    pub fn even_coordinates(&self, object: u32, u: Vec2) -> Vec2 {
        match self.body(object) {
            Some(Body::Shape(shape)) => shape.even_coordinates(u),
            _ => Vec2::ZERO,
        }
    }

    /// Interpolated tangent with the sign of the bitangent in w; None without tangents. For an object that moves: when
    /// the shutter opens (see [`Accel::tangent_at`]).
    pub fn tangent(&self, hit: &Hit) -> Option<Vec4> {
        self.tangent_at(hit, self.shutter.0)
    }

    /// As [`Accel::tangent`], at a time.
    pub fn tangent_at(&self, hit: &Hit, time: f32) -> Option<Vec4> {
        self.objects.get(hit.object as usize)?.tangent(hit, self.held(time))
    }

    /// Interpolated vertex colour; white when the mesh has none.
    pub fn color(&self, hit: &Hit) -> Vec4 {
        match self.body(hit.object) {
            Some(Body::Mesh(mesh)) => mesh.color_at(hit.primitive, hit.u, hit.v),
            _ => Vec4::ONE,
        }
    }

    /// World-space corners of a triangle; zeros for a shape. For an object that moves: when the shutter opens (see
    /// [`Accel::corners_at`]).
    pub fn corners(&self, object: u32, primitive: u32) -> [Vec3; 3] {
        self.corners_at(object, primitive, self.shutter.0)
    }

    /// As [`Accel::corners`], at a time. In the order of the mesh: counter-clockwise from the front, but clockwise
    /// where [`Accel::placement`] mirrors.
    pub fn corners_at(&self, object: u32, primitive: u32, time: f32) -> [Vec3; 3] {
        let corners = |object: &Object| object.corners(primitive, self.held(time));
        self.objects.get(object as usize).map_or([Vec3::ZERO; 3], corners)
    }

    /// Corners of a triangle in the object's own space (which is the world's for what is flat); zeros for a shape.
    pub fn own_corners(&self, object: u32, primitive: u32) -> [Vec3; 3] {
        match self.body(object) {
            Some(Body::Mesh(mesh)) => mesh.corners(primitive),
            _ => [Vec3::ZERO; 3],
        }
    }

    /// Whether a ray along `d` comes to the triangle from behind, at a time; never for a shape.
    pub fn is_from_behind(&self, hit: &Hit, d: Vec3, time: f32) -> bool {
        let object = self.objects.get(hit.object as usize);
        object.is_some_and(|o| o.is_from_behind(hit.primitive, d, self.held(time)))
    }

    /// Transform from an object's own space to the world's at a time; None for what was put into the world as it is
    /// (there it is the identity).
    pub fn placement(&self, object: u32, time: f32) -> Option<DAffine3> {
        self.objects.get(object as usize)?.placement(self.held(time))
    }

    /// Whether an object moves while the shutter is open.
    pub fn is_moving(&self, object: u32) -> bool {
        self.objects.get(object as usize).is_some_and(Object::is_moving)
    }

    /// Whether anything moves while the shutter is open.
    pub fn has_motion(&self) -> bool {
        self.objects.iter().any(Object::is_moving)
    }

    fn body(&self, object: u32) -> Option<&Body> {
        self.objects.get(object as usize).map(|o| &o.body)
    }

    /// Triangles of all objects, as seen: a mesh counts once per instance.
    pub fn triangle_count(&self) -> usize {
        self.triangles
    }

    /// Triangles of one object; none of a shape.
    pub fn triangles_of(&self, object: u32) -> usize {
        match self.body(object) {
            Some(Body::Mesh(mesh)) => mesh.triangles.len(),
            _ => 0,
        }
    }

    /// Objects added.
    pub fn object_count(&self) -> usize {
        self.objects.len()
    }

    /// Box around everything, at all times of the shutter; None when there is nothing.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let second = self.second.as_ref().and_then(|s| s.bounds());
        self.tree.bounds().into_iter().chain(second).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// The traversal kernel in use.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// Pinned to one traversal kernel; hits stay the same to the last bit.
    pub fn with_kernel(mut self, kernel: Kernel) -> Self {
        self.tree = self.tree.with_kernel(kernel);
        self.kernel = self.tree.kernel();
        if let Some(second) = &mut self.second {
            second.pin(kernel);
        }
        self
    }

    /// Objects beside the flat tree: shapes, instances, what moves.
    pub fn second_level(&self) -> usize {
        self.second.as_ref().map_or(0, |second| second.len())
    }

    /// Bytes of trees and meshes; a shared mesh counts once.
    pub fn memory_bytes(&self) -> usize {
        let mut meshes: Vec<_> = self.objects.iter().filter_map(Object::mesh).collect();
        meshes.sort_unstable_by_key(|m| std::sync::Arc::as_ptr(m) as usize);
        meshes.dedup_by_key(|m| std::sync::Arc::as_ptr(m) as usize);
        self.tree.memory_bytes()
            + size_of_val(&*self.object_of)
            + size_of_val(&*self.objects)
            + meshes.iter().map(|m| m.memory_bytes()).sum::<usize>()
            + self.second.as_ref().map_or(0, |s| s.memory_bytes())
    }
}
