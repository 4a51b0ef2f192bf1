//! The acceleration structure and its queries: intersection, occlusion, and surface data of hits.

use super::facets::Facets;
use super::objects::{Body, Object};
use super::second::SecondLevel;
use crate::bvh::{HitFilter, Kernel, Opaque, Tree, TriangleHit};
use crate::{Hit, Rays, Surface};
use dapple_math::Ray;
use glam::{DAffine3, Vec2, Vec3, Vec4};

/// The acceleration structure over all objects of a scene.
#[derive(Debug)]
pub struct Accel {
    pub(super) tree: Tree,
    /// The object of each triangle of the flat tree.
    pub(super) object_of: Vec<u32>,
    pub(super) objects: Vec<Object>,
    pub(super) facets: Facets,
    pub(super) second: Option<Box<SecondLevel>>,
    pub(super) shutter: (f32, f32),
    pub(super) triangles: usize,
    pub(super) kernel: Kernel,
}

/// Converts triangle ids of the flat tree to object hits for the filter.
struct FlatFilter<'a, F> {
    accel: &'a Accel,
    filter: &'a F,
}

impl<F: HitFilter<Hit>> HitFilter<TriangleHit> for FlatFilter<'_, F> {
    const OPAQUE: bool = F::OPAQUE;
    fn accept(&self, hit: &TriangleHit) -> bool {
        self.filter.accept(&self.accel.flat_hit(hit))
    }
}

impl Accel {
    /// The nearest hit with 0 < t < t_max that the filter accepts. `time` is in seconds and is clamped to the shutter
    /// interval.
    #[inline]
    pub fn intersect<F: HitFilter<Hit>>(&self, ray: &Ray, time: f32, filter: &F) -> Option<Hit> {
        let flat =
            self.tree.intersect(ray, &FlatFilter { accel: self, filter }).map(|hit| self.flat_hit(&hit));
        match self.second() {
            None => flat,
            Some(second) => second.intersect(&self.objects, ray, self.clamped(time), filter, flat),
        }
    }

    /// Whether the filter accepts any hit with 0 < t < t_max.
    #[inline]
    pub fn occluded<F: HitFilter<Hit>>(&self, ray: &Ray, time: f32, filter: &F) -> bool {
        self.tree.occluded(ray, &FlatFilter { accel: self, filter })
            || self
                .second()
                .is_some_and(|second| second.occluded(&self.objects, ray, self.clamped(time), filter))
    }

    /// Calls `found` with the index and the nearest hit of each ray, as [`Accel::intersect`] finds it with opaque
    /// surfaces, in any order. Many rays at a time take less time than one by one. `time` returns the time of a ray.
    #[inline]
    pub fn intersect_each(
        &self,
        rays: &Rays,
        time: impl Fn(usize) -> f32,
        mut found: impl FnMut(usize, Option<Hit>),
    ) {
        if self.second().is_none() {
            return self.tree.intersect_each(rays, |i, hit| found(i, hit.map(|hit| self.flat_hit(&hit))));
        }
        for i in 0..rays.len() {
            found(i, self.intersect(&rays.ray(i), time(i), &Opaque));
        }
    }

    /// Calls `found` with the index of each ray and whether it is occluded, as [`Accel::occluded`] finds it with opaque
    /// surfaces, in any order.
    #[inline]
    pub fn occluded_each(
        &self,
        rays: &Rays,
        time: impl Fn(usize) -> f32,
        mut found: impl FnMut(usize, bool),
    ) {
        if self.second().is_none() {
            return self.tree.occluded_each(rays, found);
        }
        for i in 0..rays.len() {
            found(i, self.occluded(&rays.ray(i), time(i), &Opaque));
        }
    }

    /// The second level; None when all objects are in the flat tree.
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

    /// `time` clamped to the shutter interval, for which the bounding boxes are valid.
    pub(super) fn clamped(&self, time: f32) -> f64 {
        // `clamp` would keep NaN; this maps it to the opening of the shutter.
        f64::from(time.max(self.shutter.0).min(self.shutter.1))
    }

    /// Position, error bound and normals of a hit. The position is computed from barycentric coordinates on triangles,
    /// and projected onto the surface on shapes; it is never o + t·d.
    pub fn surface(&self, ray: &Ray, time: f32, hit: &Hit) -> Surface {
        self.surface_inline(ray, time, hit)
    }

    /// As [`Accel::surface`], compiled into the caller, for loops over many hits.
    #[inline(always)]
    pub fn surface_inline(&self, ray: &Ray, time: f32, hit: &Hit) -> Surface {
        let mut surface = match self.objects.get(hit.object as usize) {
            Some(object) => object.surface(ray, self.clamped(time), hit),
            None => Surface { p: ray.o, start: ray.o, p_error: Vec3::ZERO, ng: Vec3::Z, ns: Vec3::Z },
        };
        if surface.start != surface.p && self.is_clear(&surface, time) {
            surface.start = surface.p;
        }
        surface
    }

    /// The records from which the surfaces of many hits are computed at a time; None if there are none, as for very large
    /// scenes.
    pub fn facets(&self) -> &Facets {
        &self.facets
    }

    /// Whether there is no geometry on either side of the edge from which the ray origin was moved, as at the diagonal
    /// of a flat quad, at a free edge, or on the outside of a convex edge. Tests occlusion from the moved origin
    /// through the position and as far again beyond it.
    #[cold]
    fn is_clear(&self, surface: &Surface, time: f32) -> bool {
        [surface.ng, -surface.ng].into_iter().all(|up| {
            let o = surface.origin_towards(up);
            let at = dapple_math::offset::offset_origin(surface.p, surface.p_error, surface.ng, up);
            let across = Ray { o, d: at - o, t_max: 2.0 };
            across.d == Vec3::ZERO || !self.occluded(&across, time, &Opaque)
        })
    }

    /// Offset from a hit to the smooth surface that the vertex normals of its triangle span above it, on the side of
    /// `up`. Zero where they span none, and on shapes. An *approximation* of the surface that the triangles represent
    /// [Hanika 2021].
    pub fn lift(&self, hit: &Hit, up: Vec3, time: f32) -> Vec3 {
        let object = self.objects.get(hit.object as usize);
        object.map_or(Vec3::ZERO, |object| object.lift(hit, up, self.clamped(time)))
    }

    /// Interpolated texture coordinates; zero when the mesh has none. Shapes have coordinates of their own.
    pub fn uv(&self, hit: &Hit, set: usize) -> Vec2 {
        match self.body(hit.object) {
            Some(Body::Mesh(mesh)) => mesh.uv_at(set, hit.primitive, hit.u, hit.v),
            Some(Body::Shape(shape)) => shape.uv(hit.u, hit.v),
            None => Vec2::ZERO,
        }
    }

    /// Surface coordinates ([`Hit::u`] and [`Hit::v`]) of the point of a shape that is nearest to `p` at the given
    /// time; None for a mesh.
    pub fn coordinates_at(&self, object: u32, p: Vec3, time: f32) -> Option<Vec2> {
        self.objects.get(object as usize)?.coordinates_at(p, self.clamped(time))
    }

    /// Maps `u` in \[0, 1\]² to surface coordinates on a shape, uniformly in area in its object space; zero for a mesh.
    pub fn even_coordinates(&self, object: u32, u: Vec2) -> Vec2 {
        match self.body(object) {
            Some(Body::Shape(shape)) => shape.even_coordinates(u),
            _ => Vec2::ZERO,
        }
    }

    /// Interpolated tangent with the sign of the bitangent in w; None without tangents. For a moving object, the
    /// tangent at shutter opening (see [`Accel::tangent_at`]).
    pub fn tangent(&self, hit: &Hit) -> Option<Vec4> {
        self.tangent_at(hit, self.shutter.0)
    }

    /// As [`Accel::tangent`], at the given time.
    pub fn tangent_at(&self, hit: &Hit, time: f32) -> Option<Vec4> {
        self.objects.get(hit.object as usize)?.tangent(hit, self.clamped(time))
    }

    /// Interpolated vertex colour; white when the mesh has none.
    pub fn color(&self, hit: &Hit) -> Vec4 {
        match self.body(hit.object) {
            Some(Body::Mesh(mesh)) => mesh.color_at(hit.primitive, hit.u, hit.v),
            _ => Vec4::ONE,
        }
    }

    /// Whether an object has vertex colours.
    pub fn has_colors(&self, object: u32) -> bool {
        matches!(self.body(object), Some(Body::Mesh(mesh)) if !mesh.colors.is_empty())
    }

    /// World-space corners of a triangle; zeros for a shape. For a moving object, the corners at shutter opening (see
    /// [`Accel::corners_at`]).
    pub fn corners(&self, object: u32, primitive: u32) -> [Vec3; 3] {
        self.corners_at(object, primitive, self.shutter.0)
    }

    /// As [`Accel::corners`], at the given time. The order is that of the mesh: counter-clockwise from the front, but
    /// clockwise where [`Accel::placement`] mirrors.
    pub fn corners_at(&self, object: u32, primitive: u32, time: f32) -> [Vec3; 3] {
        let corners = |object: &Object| object.corners(primitive, self.clamped(time));
        self.objects.get(object as usize).map_or([Vec3::ZERO; 3], corners)
    }

    /// Object-space corners of a triangle (equal to world space in the flat tree); zeros for a shape.
    pub fn own_corners(&self, object: u32, primitive: u32) -> [Vec3; 3] {
        match self.body(object) {
            Some(Body::Mesh(mesh)) => mesh.corners(primitive),
            _ => [Vec3::ZERO; 3],
        }
    }

    /// Whether a ray with direction `d` reaches the triangle from its back side at the given time; always false for a
    /// shape.
    pub fn is_from_behind(&self, hit: &Hit, d: Vec3, time: f32) -> bool {
        let object = self.objects.get(hit.object as usize);
        object.is_some_and(|o| o.is_from_behind(hit.primitive, d, self.clamped(time)))
    }

    /// The transform from object space to world space at the given time; None for objects that were added in world
    /// space or flattened into it (their transform is the identity).
    pub fn placement(&self, object: u32, time: f32) -> Option<DAffine3> {
        self.objects.get(object as usize)?.placement(self.clamped(time))
    }

    /// Whether the object moves while the shutter is open.
    pub fn is_moving(&self, object: u32) -> bool {
        self.objects.get(object as usize).is_some_and(Object::is_moving)
    }

    /// Whether any object moves while the shutter is open.
    pub fn has_motion(&self) -> bool {
        self.objects.iter().any(Object::is_moving)
    }

    fn body(&self, object: u32) -> Option<&Body> {
        self.objects.get(object as usize).map(|o| &o.body)
    }

    /// The number of triangles of all objects; a shared mesh counts once per instance.
    pub fn triangle_count(&self) -> usize {
        self.triangles
    }

    /// The number of triangles of one object; 0 for a shape.
    pub fn triangles_of(&self, object: u32) -> usize {
        match self.body(object) {
            Some(Body::Mesh(mesh)) => mesh.triangles.len(),
            _ => 0,
        }
    }

    /// The number of objects.
    pub fn object_count(&self) -> usize {
        self.objects.len()
    }

    /// The bounding box of all objects over the whole shutter interval; None when there are none.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let second = self.second.as_ref().and_then(|s| s.bounds());
        self.tree.bounds().into_iter().chain(second).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// The traversal kernel in use.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// Selects one traversal kernel; hits are the same to the last bit.
    pub fn with_kernel(mut self, kernel: Kernel) -> Self {
        self.tree = self.tree.with_kernel(kernel);
        self.kernel = self.tree.kernel();
        if let Some(second) = &mut self.second {
            second.pin(kernel);
        }
        self
    }

    /// The number of objects in the second level: shapes, instances and moving objects.
    pub fn second_level(&self) -> usize {
        self.second.as_ref().map_or(0, |second| second.len())
    }

    /// Memory of trees and meshes in bytes; a shared mesh counts once.
    pub fn memory_bytes(&self) -> usize {
        let mut meshes: Vec<_> = self.objects.iter().filter_map(Object::mesh).collect();
        meshes.sort_unstable_by_key(|m| std::sync::Arc::as_ptr(m) as usize);
        meshes.dedup_by_key(|m| std::sync::Arc::as_ptr(m) as usize);
        self.tree.memory_bytes()
            + size_of_val(&*self.object_of)
            + size_of_val(&*self.objects)
            + self.facets.memory_bytes()
            + meshes.iter().map(|m| m.memory_bytes()).sum::<usize>()
            + self.second.as_ref().map_or(0, |s| s.memory_bytes())
    }
}
