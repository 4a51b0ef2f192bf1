//! A small binary BVH over any number of boxes, including none, for the shapes, instances and moving objects of the
//! second level.
//!
//! The slab test computes in f64 on f32 rays, widens the exit by 2γ₃ [Ize 2013] and discards the NaN of a ray that lies
//! in the plane of a face, so that no intersected box is missed. Each box is also tested individually, so that the set
//! of visited boxes does not depend on the structure of the tree.
use dapple_math::{Aabb, Ray};
use glam::DVec3;
use std::ops::ControlFlow;

/// A ray prepared for slab tests.
pub(crate) struct Slabs {
    o: DVec3,
    inverse: DVec3,
}

/// 1 + 2γ₃ in f64.
const WIDEN: f64 = 1.0 + 7.0 * f64::EPSILON;

impl Slabs {
    pub fn new(ray: &Ray) -> Self {
        Self { o: ray.o.as_dvec3(), inverse: ray.d.as_dvec3().recip() }
    }

    /// The distance at which the ray enters the box; None when it misses the box or enters it beyond `limit`.
    fn enter(&self, bounds: &Aabb, limit: f64) -> Option<f64> {
        let (mut near, mut far) = (0.0f64, f64::INFINITY);
        for k in 0..3 {
            let inverse = self.inverse[k];
            let (first, last) =
                if inverse < 0.0 { (bounds.hi[k], bounds.lo[k]) } else { (bounds.lo[k], bounds.hi[k]) };
            // `max` and `min` discard a NaN operand, which is 0·∞ for a ray in the plane of that face.
            near = near.max((first - self.o[k]) * inverse);
            far = far.min((last - self.o[k]) * inverse);
        }
        (near <= far * WIDEN && near <= limit * WIDEN).then_some(near)
    }
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    /// Inner node: index of the second child (the first child follows its parent). Leaf: first position in `order`.
    at: u32,
    /// Number of boxes in a leaf; 0 for an inner node.
    count: u32,
}

/// A BVH over boxes.
#[derive(Debug, Default)]
pub(crate) struct BoxTree {
    nodes: Vec<Node>,
    order: Vec<u32>,
    boxes: Vec<Aabb>,
}

/// Maximum number of boxes per leaf.
const LEAF: usize = 4;
/// Below this depth the boxes are split into halves by count, which keeps the depth below `STACK`.
const SAH_DEPTH: usize = 48;
const STACK: usize = 96;

impl BoxTree {
    /// Builds the tree over `boxes` by surface-area sweeps along the longest axis of the centroids. Empty boxes are
    /// never entered.
    pub fn build(boxes: Vec<Aabb>) -> Self {
        let mut order: Vec<u32> =
            (0..boxes.len() as u32).filter(|&i| boxes[i as usize].is_finite()).collect();
        let mut nodes = Vec::new();
        if !order.is_empty() {
            split(&mut nodes, &boxes, &mut order, 0, 0);
        }
        Self { nodes, order, boxes }
    }

    /// Calls `visit` with the index of every box that the ray enters before `limit`, nearer branches first. `visit` may
    /// lower the limit or end the traversal.
    pub fn traverse<B>(
        &self,
        ray: &Ray,
        limit: f64,
        mut visit: impl FnMut(u32, &mut f64) -> ControlFlow<B>,
    ) -> Option<B> {
        let slabs = Slabs::new(ray);
        let mut limit = limit;
        let root = self.nodes.first()?;
        let mut stack = [(0.0, 0u32); STACK];
        stack[0].0 = slabs.enter(&root.bounds, limit)?;
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (near, index) = stack[height];
            if near > limit * WIDEN {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count == 0 {
                let mut children = [index + 1, node.at].map(|c| (self.enter(&slabs, c, limit), c));
                if children[0].0 < children[1].0 {
                    children.swap(0, 1);
                }
                for (near, child) in children {
                    if let Some(near) = near {
                        stack[height] = (near, child);
                        height += 1;
                    }
                }
                continue;
            }
            for &i in &self.order[node.at as usize..(node.at + node.count) as usize] {
                if slabs.enter(&self.boxes[i as usize], limit).is_some()
                    && let ControlFlow::Break(b) = visit(i, &mut limit)
                {
                    return Some(b);
                }
            }
        }
        None
    }

    /// Whether `bounds` overlaps any box whose index satisfies `counts`.
    pub fn meets(&self, bounds: &Aabb, counts: &impl Fn(u32) -> bool) -> bool {
        !self.nodes.is_empty() && self.meets_below(0, bounds, counts)
    }

    fn meets_below(&self, index: usize, bounds: &Aabb, counts: &impl Fn(u32) -> bool) -> bool {
        let node = &self.nodes[index];
        if !node.bounds.meets(bounds) {
            return false;
        }
        if node.count == 0 {
            return self.meets_below(index + 1, bounds, counts)
                || self.meets_below(node.at as usize, bounds, counts);
        }
        let of = &self.order[node.at as usize..(node.at + node.count) as usize];
        of.iter().any(|&i| counts(i) && self.boxes[i as usize].meets(bounds))
    }

    fn enter(&self, slabs: &Slabs, node: u32, limit: f64) -> Option<f64> {
        slabs.enter(&self.nodes[node as usize].bounds, limit)
    }

    /// The bounding box of all boxes; None when there are none.
    pub fn bounds(&self) -> Option<Aabb> {
        self.nodes.first().map(|n| n.bounds)
    }

    /// The box with the given index.
    pub fn bounds_of(&self, index: usize) -> Option<Aabb> {
        self.boxes.get(index).copied()
    }

    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.order) + size_of_val(&*self.boxes)
    }
}

/// Writes the subtree over `order`; `first` is the position of its first box.
fn split(nodes: &mut Vec<Node>, boxes: &[Aabb], order: &mut [u32], first: usize, depth: usize) {
    let bounds = order.iter().fold(Aabb::EMPTY, |b, &i| b.union(boxes[i as usize]));
    let index = nodes.len();
    nodes.push(Node { bounds, at: first as u32, count: order.len() as u32 });
    if order.len() <= LEAF {
        return;
    }
    let axis = longest_axis(boxes, order);
    // Sorts by centroid and breaks ties by index, so that equal input gives an equal tree.
    let key = |i: u32| boxes[i as usize].centroid(axis);
    order.sort_unstable_by(|&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
    let middle = if depth < SAH_DEPTH { cheapest_split(boxes, order) } else { order.len() / 2 };
    let (left, right) = order.split_at_mut(middle);
    split(nodes, boxes, left, first, depth + 1);
    nodes[index].at = nodes.len() as u32;
    nodes[index].count = 0;
    split(nodes, boxes, right, first + middle, depth + 1);
}

fn longest_axis(boxes: &[Aabb], order: &[u32]) -> usize {
    let extent = |axis: usize| {
        let centroids = order.iter().map(|&i| boxes[i as usize].centroid(axis));
        let (lo, hi) = centroids.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c), h.max(c)));
        hi - lo
    };
    let e = [extent(0), extent(1), extent(2)];
    if e[0] >= e[1] && e[0] >= e[2] {
        0
    } else if e[1] >= e[2] {
        1
    } else {
        2
    }
}

/// The position at which splitting the sorted boxes minimises Σ area × count; never at either end.
fn cheapest_split(boxes: &[Aabb], order: &[u32]) -> usize {
    let mut cost = vec![0.0; order.len()];
    let mut sweep = Aabb::EMPTY;
    for n in 1..order.len() {
        sweep = sweep.union(boxes[order[n - 1] as usize]);
        cost[n] = sweep.half_area() * n as f64;
    }
    sweep = Aabb::EMPTY;
    for n in (1..order.len()).rev() {
        sweep = sweep.union(boxes[order[n] as usize]);
        cost[n] += sweep.half_area() * (order.len() - n) as f64;
    }
    (1..order.len()).min_by(|&a, &b| cost[a].total_cmp(&cost[b])).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    struct Noise(u64);
    impl Noise {
        fn next(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (self.0 >> 40) as f32 / 8_388_608.0 - 1.0
        }
        fn vec(&mut self) -> Vec3 {
            Vec3::new(self.next(), self.next(), self.next())
        }
    }

    fn visited(tree: &BoxTree, ray: &Ray) -> Vec<u32> {
        let mut found = Vec::new();
        let none = tree.traverse::<()>(ray, f64::INFINITY, |i, _| {
            found.push(i);
            ControlFlow::Continue(())
        });
        assert_eq!(none, None);
        found.sort_unstable();
        found
    }

    #[test]
    fn the_tree_visits_what_a_loop_would() {
        let mut noise = Noise(1);
        for n in [0, 1, 4, 5, 33, 500] {
            let boxes: Vec<Aabb> = (0..n)
                .map(|_| {
                    let (c, e) = (noise.vec().as_dvec3() * 10.0, noise.vec().abs().as_dvec3());
                    Aabb::new(c - e, c + e)
                })
                .collect();
            let tree = BoxTree::build(boxes.clone());
            for _ in 0..200 {
                let ray = Ray::new(noise.vec() * 12.0, noise.vec());
                let slabs = Slabs::new(&ray);
                let expected: Vec<u32> =
                    (0..n).filter(|&i| slabs.enter(&boxes[i as usize], f64::INFINITY).is_some()).collect();
                assert_eq!(visited(&tree, &ray), expected);
            }
        }
    }

    #[test]
    fn a_box_that_is_touched_is_entered() {
        let mut noise = Noise(2);
        for i in 0..200_000 {
            let scale = 10f32.powi(i % 13 - 6);
            let (a, b) = (noise.vec() * scale, noise.vec() * scale);
            let (mut lo, mut hi) = (a.min(b), a.max(b));
            if i % 3 == 0 {
                hi[i as usize % 3] = lo[i as usize % 3]; // a flat box
            }
            let s = (noise.vec() + Vec3::ONE) * 0.5;
            let inside = (lo + (hi - lo) * s).clamp(lo, hi);
            let mut d = noise.vec();
            if i % 5 == 0 {
                d[i as usize % 3] = 0.0;
            }
            // The ray passes exactly through `inside`: its origin is a multiple of d away, all computed in f64.
            let o = inside.as_dvec3() - d.as_dvec3() * (scale as f64 * 4.0);
            let slabs = Slabs { o, inverse: d.as_dvec3().recip() };
            let slack = 4.0 * f64::EPSILON * (o.abs().max_element() + scale as f64);
            (lo, hi) = (lo.min(inside), hi.max(inside));
            let bounds = Aabb::new(lo.as_dvec3(), hi.as_dvec3()).padded(slack);
            assert!(slabs.enter(&bounds, f64::INFINITY).is_some(), "{i} {lo} {hi} {o} {d}");
        }
    }

    #[test]
    fn many_equal_boxes_and_nested_boxes_end() {
        let one = Aabb::new(DVec3::splat(-1.0), DVec3::ONE);
        let tree = BoxTree::build(vec![one; 10_000]);
        assert_eq!(visited(&tree, &Ray::new(Vec3::splat(-3.0), Vec3::ONE)).len(), 10_000);
        let grown: Vec<Aabb> = (0..4000)
            .map(|i| {
                let r = DVec3::splat(libm::exp2(i as f64 * 0.25));
                Aabb::new(r * 0.5, r)
            })
            .collect();
        let tree = BoxTree::build(grown);
        assert_eq!(visited(&tree, &Ray::new(Vec3::splat(0.1), Vec3::ONE)).len(), 4000);
    }
}
