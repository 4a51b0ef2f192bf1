//! Detection of coincident surfaces of different opaque objects.
//!
//! Nearly all surfaces of a scene are opaque, so that a full search would compare every triangle with every other one.
//! Only the triangles of small meshes (walls, panels, boxes) are queries. Other triangles are included where they
//! overlap the bounding box and the plane of a query. The included triangles are sorted along a space-filling curve,
//! and the tree over that order is compared with itself. The number of steps is limited to what takes a tenth of the
//! time needed to build the BVHs; if that is not enough, no coincident surfaces are reported. Two coincident large
//! meshes are not found either.
use super::search::{Item, Search};
use super::{Coincident, NONE};
use crate::boxes::BoxTree;
use dapple_math::Aabb;
use dapple_math::offset::UNIT_ROUNDOFF;
use glam::{DVec3, UVec3, Vec3};
use std::cell::Cell;
use std::ops::Range;

/// Maximum number of steps: a constant, and a number per triangle of the scene, which together take about a tenth of
/// the time needed to build the BVHs. A test of corners counts as several steps, and a comparison of outlines as many.
const BUDGET: u64 = 1 << 19;
const PER_TRIANGLE: u64 = 6;
const ENTRY: u64 = 4;
const CORNERS: u64 = 8;
const OUTLINE: u64 = 64;
/// As in the early exit of the outline test: triangles wider than this many error bounds do not coincide if they cross
/// at an angle with a larger sine than `ANGLE`.
const WIDE: f32 = 2048.0;
const ANGLE: f32 = 1.01 / 64.0;
/// Maximum number of triangles per leaf.
const LEAF: usize = 4;
/// Objects with at most this many triangles are queries. The largest of these limits is used for which the number of
/// queries is at most `FREE` plus one in `SHARE` of all triangles.
const FEW: [usize; 6] = [64, 32, 16, 8, 4, 2];
const SHARE: usize = 16;
const FREE: usize = 4096;
/// The subtree contains several objects.
const MIXED: u32 = u32::MAX;

#[derive(Clone, Copy)]
struct Box32 {
    lo: Vec3,
    hi: Vec3,
}

impl Box32 {
    /// The padding of the boxes is much larger than the rounding to f32.
    fn new(bounds: Aabb) -> Self {
        Self { lo: bounds.lo.as_vec3(), hi: bounds.hi.as_vec3() }
    }

    fn union(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    fn meets(&self, other: &Self) -> bool {
        self.lo.cmple(other.hi).all() && other.lo.cmple(self.hi).all()
    }
}

/// A triangle to be compared.
#[derive(Clone, Copy)]
struct Entry {
    item: Item,
    bounds: Box32,
    normal: Vec3,
    /// Half the height over the longest side, and a bound of the error of points of the triangle.
    width: f32,
    within: f32,
}

impl Entry {
    fn new(search: &Search<'_>, item: Item, bounds: &Aabb) -> Self {
        let [a, b, c] = search.triangle(item).unwrap_or_default();
        let n = (b - a).cross(c - a);
        let within = search.within(item, bounds.largest().max_element());
        let width = 0.5 * n.length() / (bounds.hi - bounds.lo).length();
        let normal = n.normalize_or_zero().as_vec3();
        Self { item, bounds: Box32::new(*bounds), normal, width: width as f32, within: within as f32 }
    }

    /// Whether the two triangles cross at an angle and are wide enough not to coincide; the first test.
    fn crosses(&self, other: &Self) -> bool {
        let wide = self.width.min(other.width) > WIDE * self.within.max(other.within);
        wide && self.normal.cross(other.normal).length_squared() > ANGLE * ANGLE
    }
}

struct Node {
    bounds: Box32,
    items: Range<u32>,
    /// Index of the second child (the first child follows the node); 0 for a leaf.
    second: u32,
    /// The object of all triangles of the subtree, or `MIXED`.
    object: u32,
    /// All triangles of the subtree are known to coincide with another one.
    done: bool,
}

struct Pairs<'a, 'w> {
    queried: Vec<bool>,
    search: &'a mut Search<'w>,
    items: Vec<Entry>,
    found: Vec<bool>,
    nodes: Vec<Node>,
    budget: u64,
}

impl Search<'_> {
    /// Marks coincident triangles of two objects; `solid` is as in [`super::Accel::coincident`]. If the step limit is
    /// reached, none of them are marked, and rounding then decides which of two such surfaces is visible.
    pub(super) fn solids(&mut self, solid: impl Fn(u32) -> bool) {
        let boxes = self.standing(solid);
        if boxes.iter().filter(|b| b.is_finite()).count() < 2 {
            return;
        }
        let near = Queries::new(self, self.queried(&boxes));
        let most = BUDGET + PER_TRIANGLE * self.accel.triangles as u64;
        let items = self.crowded(&boxes, &near, most);
        let budget = most.saturating_sub(near.steps.get());
        if items.is_empty() || budget == 0 {
            return;
        }
        let before = self.result.clone();
        let (found, nodes) = (vec![false; items.len()], Vec::with_capacity(items.len() / 2 + 1));
        let mut pairs = Pairs { queried: near.queried, search: self, items, found, nodes, budget };
        let all = 0..pairs.items.len() as u32;
        pairs.build(all);
        pairs.within(0);
        if pairs.budget == 0 {
            self.result = before;
        }
    }

    /// The bounding boxes of static opaque meshes; empty for other objects.
    fn standing(&self, solid: impl Fn(u32) -> bool) -> Vec<Aabb> {
        let of = |o: u32| {
            let object = &self.accel.objects[o as usize];
            let stands = solid(o) && !object.is_moving() && object.mesh().is_some();
            if stands { self.object_bounds(o) } else { Aabb::EMPTY }
        };
        (0..self.accel.objects.len() as u32).map(of).collect()
    }

    /// The triangles to be compared, in an order in which neighbours are near each other in space.
    fn crowded(&self, boxes: &[Aabb], near: &Queries, most: u64) -> Vec<Entry> {
        let whole = boxes.iter().filter(|b| b.is_finite()).fold(Aabb::EMPTY, |a, b| a.union(*b));
        let (mut items, mut order) = (Vec::new(), Vec::new());
        for (object, bounds) in (0u32..).zip(boxes) {
            let is_queried = near.queried[object as usize];
            if !bounds.is_finite() || !(is_queried || near.meets(object, bounds)) {
                continue;
            }
            for item in self.primitives(object).map(|primitive| Item { object, primitive }) {
                let bounds = self.bounds(item);
                if near.steps.get() > most {
                    return Vec::new();
                }
                if bounds.is_finite() && (is_queried || near.meets(object, &bounds)) {
                    near.count_steps(ENTRY);
                    order.push(curve(&bounds, &whole) << 28 | items.len() as u64);
                    items.push(Entry::new(self, item, &bounds));
                }
            }
        }
        order.sort_unstable();
        order.into_iter().map(|i| items[(i & ((1 << 28) - 1)) as usize]).collect()
    }

    /// The query objects, whose triangles are compared with all others: those with few triangles, such as walls, panels
    /// and boxes, up to a cost that is small compared with building the BVHs.
    fn queried(&self, boxes: &[Aabb]) -> Vec<bool> {
        let count = |o: usize| self.accel.objects[o].mesh().map_or(0, |mesh| mesh.triangles.len());
        let total: usize = (0..boxes.len()).map(count).sum();
        let up_to = |most: usize| (0..boxes.len()).filter(move |&o| boxes[o].is_finite() && count(o) <= most);
        let most =
            FEW.into_iter().find(|&most| up_to(most).map(count).sum::<usize>() <= FREE + total / SHARE);
        let mut queried = vec![false; boxes.len()];
        up_to(most.unwrap_or(0)).for_each(|o| queried[o] = true);
        queried
    }
}

/// The triangles of the query objects.
struct Queries {
    tree: BoxTree,
    /// Per triangle: its object, its unit normal, and the signed distance of its plane from the origin.
    planes: Vec<(u32, DVec3, f64)>,
    queried: Vec<bool>,
    steps: Cell<u64>,
}

impl Queries {
    fn new(search: &Search<'_>, queried: Vec<bool>) -> Self {
        let (mut boxes, mut planes) = (Vec::new(), Vec::new());
        for object in (0..queried.len() as u32).filter(|&o| queried[o as usize]) {
            for item in search.primitives(object).map(|primitive| Item { object, primitive }) {
                let [a, b, c] = search.triangle(item).unwrap_or_default();
                let n = (b - a).cross(c - a).normalize_or_zero();
                boxes.push(search.bounds(item));
                planes.push((object, n, n.dot(a)));
            }
        }
        Self { tree: BoxTree::build(boxes), planes, queried, steps: Cell::new(0) }
    }

    fn count_steps(&self, steps: u64) {
        self.steps.set(self.steps.get() + steps);
    }

    /// Whether the padded box overlaps the box and the plane of a triangle of another object.
    fn meets(&self, object: u32, bounds: &Aabb) -> bool {
        let (middle, half) = (0.5 * (bounds.lo + bounds.hi), 0.5 * (bounds.hi - bounds.lo));
        let reach = 16.0 * f64::from(UNIT_ROUNDOFF) * bounds.largest().max_element();
        self.tree.meets(bounds, &|i| {
            self.count_steps(1);
            let (of, n, height) = self.planes[i as usize];
            of != object && (n.dot(middle) - height).abs() <= n.abs().dot(half) + 2.0 * reach
        })
    }
}

/// The position of a box on the Morton curve through `whole`, in 36 bits.
fn curve(bounds: &Aabb, whole: &Aabb) -> u64 {
    let size = (whole.hi - whole.lo).max(DVec3::splat(f64::MIN_POSITIVE));
    let at = (0.5 * (bounds.lo + bounds.hi) - whole.lo) / size * 4095.0;
    let UVec3 { x, y, z } = at.as_uvec3();
    spread(x) | spread(y) << 1 | spread(z) << 2
}

/// Inserts two zeros between the 12 bits of `x`.
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x.min(4095));
    for (shift, mask) in [(16, 0x0f00_00ff), (8, 0x0f00_f00f), (4, 0xc30c_30c3), (2, 0x2_4924_9249)] {
        x = (x | x << shift) & mask;
    }
    x
}

impl Pairs<'_, '_> {
    fn build(&mut self, items: Range<u32>) -> (Box32, u32) {
        let index = self.nodes.len();
        let bounds = self.items[items.start as usize].bounds;
        self.nodes.push(Node { bounds, items: items.clone(), second: 0, object: MIXED, done: false });
        let joined =
            |(a, o): (Box32, u32), (b, p): (Box32, u32)| (a.union(b), if o == p { o } else { MIXED });
        let (bounds, object) = if items.len() <= LEAF {
            let of = &self.items[items.start as usize..items.end as usize];
            of.iter().map(|entry| (entry.bounds, entry.item.object)).reduce(joined).unwrap_or((bounds, MIXED))
        } else {
            let middle = items.start + items.len() as u32 / 2;
            let first = self.build(items.start..middle);
            self.nodes[index].second = self.nodes.len() as u32;
            joined(first, self.build(middle..items.end))
        };
        (self.nodes[index].bounds, self.nodes[index].object) = (bounds, object);
        (bounds, object)
    }

    /// Compares the triangles of a subtree with each other.
    fn within(&mut self, node: u32) {
        let at = &self.nodes[node as usize];
        if at.object != MIXED {
            return;
        }
        let (items, second) = (at.items.clone(), at.second);
        if second == 0 {
            for i in items.clone() {
                self.compare(i..i + 1, i + 1..items.end);
            }
        } else {
            self.within(node + 1);
            self.within(second);
            self.between(node + 1, second);
        }
        self.conclude(node);
    }

    /// Compares the triangles of one subtree with those of another.
    fn between(&mut self, a: u32, b: u32) {
        let (at, other) = (&self.nodes[a as usize], &self.nodes[b as usize]);
        self.budget = self.budget.saturating_sub(1);
        let is_one = at.object == other.object && at.object != MIXED;
        if self.budget == 0 || is_one || (at.done && other.done) || !at.bounds.meets(&other.bounds) {
            return;
        }
        match (at.second, other.second) {
            (0, 0) => self.compare(at.items.clone(), other.items.clone()),
            (second, of_other) if of_other == 0 || (second != 0 && at.items.len() >= other.items.len()) => {
                self.between(a + 1, b);
                self.between(second, b);
            }
            (_, second) => {
                self.between(a, b + 1);
                self.between(a, second);
            }
        }
        self.conclude(a);
        self.conclude(b);
    }

    fn conclude(&mut self, node: u32) {
        let at = &self.nodes[node as usize];
        let done = match at.second {
            0 => at.items.clone().all(|i| self.found[i as usize]),
            second => self.nodes[node as usize + 1].done && self.nodes[second as usize].done,
        };
        self.nodes[node as usize].done = done;
    }

    fn compare(&mut self, first: Range<u32>, second: Range<u32>) {
        for (i, j) in first.flat_map(|i| second.clone().map(move |j| (i as usize, j as usize))) {
            let (a, b) = (self.items[i], self.items[j]);
            let (first, second) = (a.item.object, b.item.object);
            let queried = self.queried[first as usize] || self.queried[second as usize];
            if !queried || first == second || (self.found[i] && self.found[j]) || !a.bounds.meets(&b.bounds) {
                continue;
            }
            self.budget = self.budget.saturating_sub(1);
            if !a.crosses(&b) && self.share_place(a, b.item) {
                (self.found[i], self.found[j]) = (true, true);
                self.search.mark(a.item);
                self.search.mark(b.item);
            }
        }
    }

    fn share_place(&mut self, Entry { item: a, bounds, .. }: Entry, b: Item) -> bool {
        let (Some(own), Some(other)) = (self.search.triangle(a), self.search.triangle(b)) else {
            return false;
        };
        self.budget = self.budget.saturating_sub(CORNERS);
        let largest = f64::from(bounds.lo.abs().max(bounds.hi.abs()).max_element());
        if self.search.are_apart((a, &own), b, largest) || self.are_back_to_back((a, &own), (b, &other)) {
            return false;
        }
        self.budget = self.budget.saturating_sub(OUTLINE);
        self.search.outline(a).meets(&self.search.outline(b))
    }

    /// Whether the front sides of two surfaces face opposite directions, as those of a floor and of an object standing
    /// on it do.
    fn are_back_to_back(&self, (a, own): (Item, &[DVec3; 3]), (b, other): (Item, &[DVec3; 3])) -> bool {
        let front = |item: Item, [p, q, r]: &[DVec3; 3]| {
            let n = (*q - *p).cross(*r - *p);
            if self.search.accel.objects[item.object as usize].is_mirrored() { -n } else { n }
        };
        front(a, own).dot(front(b, other)) < 0.0
    }
}

impl Coincident {
    /// Whether no primitive or point coincides with another surface.
    pub(super) fn is_empty(&self) -> bool {
        self.starts.iter().all(|start| *start == NONE) && !self.points.contains(&true)
    }
}
