//! The second level of the acceleration structure, which contains shapes, instances and moving objects.

use super::objects::{Body, Object, Place};
use crate::boxes::BoxTree;
use crate::bvh::{HitFilter, Kernel, Tree, TriangleHit};
use crate::shapes::{Line, Shape};
use crate::{Hit, Mesh};
use dapple_math::Aabb;
use dapple_math::Ray;
use glam::{DVec3, Vec3};
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::sync::Arc;

#[derive(Debug)]
pub(super) struct SecondLevel {
    boxes: BoxTree,
    /// The object of each box.
    items: Vec<u32>,
    /// One tree per mesh, in object space.
    trees: Vec<Tree>,
}

/// Converts triangle hits of one tree to object hits for the filter.
struct OfObject<'a, F> {
    object: u32,
    filter: &'a F,
}

impl<F: HitFilter<Hit>> HitFilter<TriangleHit> for OfObject<'_, F> {
    const OPAQUE: bool = F::OPAQUE;
    fn accept(&self, hit: &TriangleHit) -> bool {
        self.filter.accept(&self.hit(hit))
    }
}

impl<F> OfObject<'_, F> {
    fn hit(&self, hit: &TriangleHit) -> Hit {
        Hit { t: hit.t, u: hit.u, v: hit.v, primitive: hit.triangle, object: self.object }
    }
}

impl SecondLevel {
    /// Builds the second level; None when all objects are in the flat tree.
    pub fn build(objects: &mut [Object], (open, close): (f32, f32), kernel: Kernel) -> Option<Self> {
        let (mut items, mut boxes, mut trees) = (Vec::new(), Vec::new(), Vec::new());
        // The key is the address of the mesh. The map is not iterated, so its order has no effect.
        let mut known = HashMap::new();
        for (id, object) in objects.iter_mut().enumerate() {
            let local = match (&object.body, &object.place) {
                (Body::Mesh(_), Place::World) | (_, Place::Nowhere(_)) => continue,
                (Body::Mesh(mesh), _) => {
                    object.tree = tree_of(mesh, &mut known, &mut trees, kernel);
                    bounds_of(&trees[object.tree as usize])
                }
                (Body::Shape(shape), _) => shape.bounds(),
            };
            if local.is_finite() {
                items.push(id as u32);
                boxes.push(swept(local, &object.place, f64::from(open), f64::from(close)));
            }
        }
        (!items.is_empty()).then(|| Self { boxes: BoxTree::build(boxes), items, trees })
    }

    /// The nearer of `best` and the nearest hit in the second level.
    #[inline(never)]
    pub fn intersect<F: HitFilter<Hit>>(
        &self,
        objects: &[Object],
        ray: &Ray,
        time: f64,
        filter: &F,
        mut best: Option<Hit>,
    ) -> Option<Hit> {
        let limit = best.map_or(ray.t_max, |b| b.t);
        self.boxes.traverse::<()>(ray, f64::from(limit), |item, limit| {
            let id = self.items[item as usize];
            // The ray includes equal distances, because at equal t the lower object is hit.
            let t_max = best.map_or(ray.t_max, |b| b.t.next_up().min(ray.t_max));
            let hit = self.hit_object(&objects[id as usize], id, &Ray { t_max, ..*ray }, time, filter);
            if let Some(hit) = hit
                && best.is_none_or(|b| hit.wins_over(&b))
            {
                *limit = f64::from(hit.t);
                best = Some(hit);
            }
            ControlFlow::Continue(())
        });
        best
    }

    #[inline(never)]
    pub fn occluded<F: HitFilter<Hit>>(&self, objects: &[Object], ray: &Ray, time: f64, filter: &F) -> bool {
        let visit = |item: u32, _: &mut f64| {
            let id = self.items[item as usize];
            match self.blocks(&objects[id as usize], id, ray, time, filter) {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        };
        self.boxes.traverse(ray, f64::from(ray.t_max), visit).is_some()
    }

    fn hit_object<F: HitFilter<Hit>>(
        &self,
        object: &Object,
        id: u32,
        ray: &Ray,
        time: f64,
        filter: &F,
    ) -> Option<Hit> {
        let line = object.line(ray, time)?;
        let of = OfObject { object: id, filter };
        match &object.body {
            Body::Shape(shape) => hit_shape(shape, id, &line, ray.t_max, filter),
            Body::Mesh(_) => {
                let tree = &self.trees[object.tree as usize];
                tree.intersect(&rounded(&line, ray.t_max)?, &of).map(|hit| of.hit(&hit))
            }
        }
    }

    fn blocks<F: HitFilter<Hit>>(&self, object: &Object, id: u32, ray: &Ray, time: f64, filter: &F) -> bool {
        let Some(line) = object.line(ray, time) else { return false };
        match &object.body {
            Body::Shape(shape) => hit_shape(shape, id, &line, ray.t_max, filter).is_some(),
            Body::Mesh(_) => {
                let tree = &self.trees[object.tree as usize];
                rounded(&line, ray.t_max)
                    .is_some_and(|ray| tree.occluded(&ray, &OfObject { object: id, filter }))
            }
        }
    }

    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        self.boxes.bounds().map(|b| (b.lo.as_vec3(), b.hi.as_vec3()))
    }

    /// The bounding box of an object over the shutter interval; None for an object that cannot be hit.
    pub fn bounds_of_object(&self, object: u32) -> Option<Aabb> {
        let item = self.items.binary_search(&object).ok()?;
        self.boxes.bounds_of(item)
    }

    /// The number of objects.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Selects one traversal kernel for every tree.
    pub fn pin(&mut self, kernel: Kernel) {
        let pinned = std::mem::take(&mut self.trees).into_iter().map(|tree| tree.with_kernel(kernel));
        self.trees = pinned.collect();
    }

    pub fn memory_bytes(&self) -> usize {
        let trees: usize = self.trees.iter().map(Tree::memory_bytes).sum();
        trees + self.boxes.memory_bytes() + size_of_val(&*self.items)
    }
}

/// The first intersection with a shape that the filter accepts.
fn hit_shape<F: HitFilter<Hit>>(
    shape: &Shape,
    object: u32,
    line: &Line,
    t_max: f32,
    filter: &F,
) -> Option<Hit> {
    let counts = |t: f32| {
        let c = shape.coordinates(line, t);
        let hit = Hit { t, u: c.x, v: c.y, primitive: 0, object };
        (F::OPAQUE || filter.accept(&hit)).then_some(hit)
    };
    shape.roots(line).into_iter().flatten().filter(|&t| t < t_max).find_map(counts)
}

/// The line as a ray in f32; None on overflow.
fn rounded(line: &Line, t_max: f32) -> Option<Ray> {
    let (o, d) = (line.o.as_vec3(), line.d.as_vec3());
    (o.is_finite() && d.is_finite()).then_some(Ray { o, d, t_max })
}

/// The tree over a mesh, built once per mesh.
fn tree_of(mesh: &Arc<Mesh>, known: &mut HashMap<usize, u32>, trees: &mut Vec<Tree>, kernel: Kernel) -> u32 {
    *known.entry(Arc::as_ptr(mesh) as usize).or_insert_with(|| {
        let corners: Vec<_> = (0..mesh.triangles.len() as u32).map(|t| mesh.corners(t)).collect();
        trees.push(Tree::build(&corners).with_kernel(kernel));
        trees.len() as u32 - 1
    })
}

fn bounds_of(tree: &Tree) -> Aabb {
    tree.bounds().map_or(Aabb::EMPTY, |(lo, hi)| Aabb::new(lo.as_dvec3(), hi.as_dvec3()))
}

/// The world-space bounding box of an object over the shutter interval. It is padded for the rounding of the ray's
/// transform to object space and back, a few f32 ulp of the largest coordinate. Coordinates beyond the range of f32 are
/// clamped to its largest number.
fn swept(local: Aabb, place: &Place, open: f64, close: f64) -> Aabb {
    let bounds = match place {
        Place::World | Place::Nowhere(_) => local,
        Place::Fixed(pose) => padded(pose.bounds(local)),
        Place::Moving(motion) => padded(motion.bounds_within(local, open, close)),
    };
    let most = DVec3::splat(f64::from(f32::MAX));
    Aabb::new(bounds.lo.clamp(-most, most), bounds.hi.clamp(-most, most))
}

fn padded(b: Aabb) -> Aabb {
    b.padded(b.largest().max_element() / f64::from(1u32 << 20))
}
