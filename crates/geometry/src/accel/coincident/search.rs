//! The search for primitives that coincide with query primitives: every primitive traverses a tree over the bounding
//! boxes of the query primitives. These are called emitters here, because emitters were the first use.
//!
//! Memory grows only with the number of emitters. A primitive and an emitter that are both known to coincide with
//! something are not compared again, and subtrees of such emitters are not entered by such primitives, so that the cost
//! of many coincident surfaces is not quadratic. If the work would still exceed a bound, all primitives are reported as
//! coincident, which is slower to render but correct.
use super::outline::{Outline, Polygon, Shape as Form, are_apart};
use super::{Accel, Coincident, NONE, WHOLE};
use crate::Hit;
use crate::accel::objects::{Body, Object, Place};
use crate::shapes::Shape;
use dapple_math::Aabb;
use dapple_math::offset::gamma;
use dapple_math::{Frame, Ray};
use glam::{DVec3, Vec3};

/// Bounding boxes are padded by this fraction of their largest coordinate, which exceeds the error bounds of two
/// surfaces.
const PADDING: f64 = 1.0 / (1u64 << 20) as f64;
/// Maximum number of comparisons; a comparison of outlines counts as several.
const BUDGET: u64 = 1 << 26;
const OUTLINE: u64 = 32;
/// Maximum number of emitters per leaf.
const LEAF: usize = 4;

/// A primitive, a whole object (`primitive` = `WHOLE`), or a point (`object` = `POINT`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Item {
    pub object: u32,
    pub primitive: u32,
}

const POINT: u32 = u32::MAX;

impl Item {
    /// Whether the item may emit light somewhere; points and whole objects may.
    fn shines(self, shines: &dyn Fn(u32, u32) -> bool) -> bool {
        self.object == POINT || self.primitive == WHOLE || shines(self.object, self.primitive)
    }
}

/// A primitive that traverses the tree.
struct Visitor {
    item: Item,
    is_emitter: bool,
    /// Whether the item is a query primitive that emits no light.
    is_dull: bool,
    /// Its corners, if it is a triangle.
    own: Option<[DVec3; 3]>,
    bounds: Aabb,
}

struct Node {
    bounds: Aabb,
    /// Leaf: the range of its emitters. Inner node: empty; the first child follows the node, the second is at `second`.
    items: std::ops::Range<usize>,
    second: usize,
    /// The group of all emitters in the subtree, if they are in one group and none of them emits light.
    only: Option<u32>,
    /// Whether all emitters in the subtree are known to coincide with something.
    done: bool,
}

pub(super) struct Search<'a> {
    pub accel: &'a Accel,
    points: &'a [(DVec3, DVec3)],
    origin_error: DVec3,
    /// The group of each object.
    groups: Vec<Option<u32>>,
    emitters: Vec<(Item, Aabb)>,
    /// Whether each emitter is known to coincide with something.
    found: Vec<bool>,
    nodes: Vec<Node>,
    budget: u64,
    pub result: Coincident,
}

impl Accel {
    /// Finds the primitives that share a place with a query primitive, and the `points` (given as boxes in which they
    /// remain) that lie in a surface. `group` returns the group of each query object and None for other objects;
    /// `shines` returns whether a primitive emits light somewhere. Primitives of one group that emit no light are not
    /// compared with each other. Returns None when nothing coincides. `origin_error` is the bound per axis of the error
    /// that the coordinates had when they were loaded. Moving objects share a place with everything on their path.
    ///
    /// `solid` returns whether an object is opaque, has no holes and is not a query object. For these objects,
    /// triangles of two static meshes share a place if one of the meshes has few triangles (64, or fewer where such
    /// meshes make up more than a sixteenth of the scene), unless the front sides of the two face opposite directions,
    /// as those of a floor and an object standing on it do. If the search takes too many steps, none of these triangles
    /// are reported.
    pub fn coincident(
        &self,
        group: impl Fn(u32) -> Option<u32>,
        shines: impl Fn(u32, u32) -> bool,
        points: &[(DVec3, DVec3)],
        origin_error: Vec3,
        solid: impl Fn(u32) -> bool,
    ) -> Option<Box<Coincident>> {
        let mut search = Search::new(self, (group, &shines), points, origin_error);
        if !search.emitters.is_empty() {
            search.run(&shines);
        }
        search.solids(solid);
        let result = search.result;
        (!result.is_empty()).then(|| Box::new(result))
    }
}

impl<'a> Search<'a> {
    fn new(
        accel: &'a Accel,
        (group, shines): (impl Fn(u32) -> Option<u32>, &dyn Fn(u32, u32) -> bool),
        points: &'a [(DVec3, DVec3)],
        origin_error: Vec3,
    ) -> Self {
        let result = Coincident {
            starts: vec![NONE; accel.objects.len()],
            bits: Vec::new(),
            points: vec![false; points.len()],
            thickness: 0.0,
            origin_error,
        };
        let origin_error = origin_error.as_dvec3();
        let groups: Vec<Option<u32>> = (0..accel.objects.len() as u32).map(group).collect();
        let mut search = Self {
            accel,
            points,
            origin_error,
            groups,
            emitters: Vec::new(),
            found: Vec::new(),
            nodes: Vec::new(),
            budget: BUDGET,
            result,
        };
        for object in 0..accel.objects.len() as u32 {
            let is_queried = search.groups[object as usize].is_some();
            let primitives = if is_queried { search.primitives(object) } else { 0..0 };
            primitives.for_each(|primitive| search.add(Item { object, primitive }));
        }
        (0..points.len() as u32).for_each(|i| search.add(Item { object: POINT, primitive: i }));
        search.found = vec![false; search.emitters.len()];
        let count = search.emitters.len();
        if count > 0 {
            search.split(0..count, shines);
        }
        search
    }

    fn add(&mut self, item: Item) {
        let bounds = self.bounds(item);
        if bounds.is_finite() {
            self.emitters.push((item, bounds));
        }
    }

    /// Writes the subtree over a range of the emitters, split into halves by count along the longest axis.
    fn split(&mut self, range: std::ops::Range<usize>, shines: &dyn Fn(u32, u32) -> bool) {
        let of = &mut self.emitters[range.clone()];
        let bounds = of.iter().fold(Aabb::EMPTY, |b, (_, c)| b.union(*c));
        let index = self.nodes.len();
        let leaf = of.len() <= LEAF;
        let items = if leaf { range.clone() } else { 0..0 };
        let group = |item: &Item| self.groups.get(item.object as usize).copied().flatten();
        let first = group(&of[0].0);
        let is_dull = leaf && of.iter().all(|(item, _)| group(item) == first && !item.shines(shines));
        let only = first.filter(|_| is_dull);
        self.nodes.push(Node { bounds, items, second: 0, only, done: false });
        if leaf {
            return;
        }
        let size = bounds.hi - bounds.lo;
        let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
        let middle = of.len() / 2;
        of.select_nth_unstable_by(middle, |(_, a), (_, b)| {
            (a.lo[axis] + a.hi[axis]).total_cmp(&(b.lo[axis] + b.hi[axis]))
        });
        self.split(range.start..range.start + middle, shines);
        let second = self.nodes.len();
        self.nodes[index].second = second;
        self.split(range.start + middle..range.end, shines);
        let (first, second) = (self.nodes[index + 1].only, self.nodes[second].only);
        self.nodes[index].only = first.filter(|_| first == second);
    }

    fn run(&mut self, shines: &dyn Fn(u32, u32) -> bool) {
        for object in 0..self.accel.objects.len() as u32 {
            let whole = self.object_bounds(object);
            if !(whole.is_finite() && self.is_near(0, &whole)) {
                continue;
            }
            let is_emitter = self.groups[object as usize].is_some();
            for primitive in self.primitives(object) {
                let item = Item { object, primitive };
                let mut is_found = self.result.contains(object, primitive);
                let (own, bounds) = (self.triangle(item), self.bounds(item));
                let is_dull = is_emitter && !item.shines(shines);
                self.visit(0, &Visitor { item, is_emitter, is_dull, own, bounds }, &mut is_found);
                if self.budget == 0 {
                    return self.mark_everything();
                }
            }
        }
    }

    /// Whether the box overlaps that of any emitter.
    fn is_near(&self, node: usize, bounds: &Aabb) -> bool {
        let at = &self.nodes[node];
        at.bounds.meets(bounds)
            && if at.second == 0 {
                self.emitters[at.items.clone()].iter().any(|(_, b)| b.meets(bounds))
            } else {
                self.is_near(node + 1, bounds) || self.is_near(at.second, bounds)
            }
    }

    /// Compares a primitive with the emitters below a node.
    fn visit(&mut self, node: usize, visitor: &Visitor, is_found: &mut bool) {
        let Visitor { item, is_emitter, is_dull, own, bounds } = visitor;
        let item = *item;
        self.budget = self.budget.saturating_sub(1);
        let at = &self.nodes[node];
        if (*is_dull && at.only.is_some() && at.only == self.groups[item.object as usize])
            || (at.done && *is_found)
            || self.budget == 0
            || !at.bounds.meets(bounds)
        {
            return;
        }
        let (second, items) = (at.second, at.items.clone());
        if second != 0 {
            self.visit(node + 1, visitor, is_found);
            self.visit(second, visitor, is_found);
            self.nodes[node].done = self.nodes[node + 1].done && self.nodes[second].done;
            return;
        }
        for i in items.clone() {
            let (emitter, of_emitter) = self.emitters[i];
            // A pair of two emitters would be compared twice; one of the comparisons is skipped.
            let is_second =
                *is_emitter && (emitter.object, emitter.primitive) <= (item.object, item.primitive);
            if is_second || (self.found[i] && *is_found) || !of_emitter.meets(bounds) {
                continue;
            }
            let largest = bounds.largest().max_element();
            if own.as_ref().is_some_and(|own| self.are_apart((item, own), emitter, largest)) {
                continue;
            }
            self.budget = self.budget.saturating_sub(OUTLINE);
            if self.outline(item).meets(&self.outline(emitter)) {
                self.found[i] = true;
                self.mark(emitter);
                if emitter.object != POINT {
                    *is_found = true;
                    self.mark(item);
                }
            }
        }
        self.nodes[node].done = items.into_iter().all(|i| self.found[i]);
    }

    /// An early exit that identifies most neighbours in a mesh; the tolerance is below every error bound, `within`
    /// above.
    pub(super) fn are_apart(&self, (item, own): (Item, &[DVec3; 3]), emitter: Item, largest: f64) -> bool {
        let Some(other) = self.triangle(emitter) else { return false };
        let within = self.within(item, largest).max(self.within(emitter, largest));
        are_apart(own, &other, largest / (1u64 << 40) as f64, within)
    }

    /// An upper bound of the combined error of two points of a triangle, along a diagonal; `largest` is the largest
    /// coordinate of the triangle.
    pub(super) fn within(&self, item: Item, largest: f64) -> f64 {
        match self.accel.objects[item.object as usize].place {
            Place::World => 4.0 * (largest * f64::from(gamma(8)) + self.origin_error.max_element()),
            _ => f64::INFINITY,
        }
    }

    pub(super) fn triangle(&self, item: Item) -> Option<[DVec3; 3]> {
        let object = self.accel.objects.get(item.object as usize).filter(|_| item.primitive != WHOLE)?;
        object.mesh()?;
        Some(object.corners_exact(item.primitive, self.accel.shutter.0.into()))
    }

    pub(super) fn mark(&mut self, item: Item) {
        if item.object == POINT {
            self.result.points[item.primitive as usize] = true;
            return;
        }
        let error = self.outline(item).error.element_sum() as f32;
        // The error of two surfaces with a safety margin.
        self.result.thickness = self.result.thickness.max(2.5 * error);
        let start = &mut self.result.starts[item.object as usize];
        if item.primitive == WHOLE {
            *start = WHOLE;
        }
        if *start == NONE {
            *start = self.result.bits.len() as u32;
            let count = self.accel.objects[item.object as usize].mesh().map_or(1, |m| m.triangles.len());
            self.result.bits.resize(self.result.bits.len() + count.div_ceil(64), 0);
        }
        if *start != WHOLE {
            self.result.bits[*start as usize + (item.primitive / 64) as usize] |= 1 << (item.primitive % 64);
        }
    }

    /// Marks all primitives and points as coincident, because there are too many to compare.
    #[cold]
    fn mark_everything(&mut self) {
        self.result.starts.fill(WHOLE);
        self.result.points.fill(true);
        let reach = self.accel.bounds().map_or(0.0, |(lo, hi)| lo.abs().max(hi.abs()).max_element());
        self.result.thickness = reach * (8.0 * PADDING) as f32 + self.origin_error.element_sum() as f32;
    }

    pub(super) fn primitives(&self, object: u32) -> std::ops::Range<u32> {
        match self.accel.objects.get(object as usize) {
            None | Some(Object { place: Place::Nowhere(_), .. }) => 0..0,
            Some(object) if object.is_moving() => WHOLE..WHOLE + 1,
            Some(object) => 0..object.mesh().map_or(1, |mesh| mesh.triangles.len() as u32),
        }
    }

    /// The bounding box of an item, padded by the largest distance at which another surface can share a place with it.
    pub(super) fn bounds(&self, item: Item) -> Aabb {
        let bounds = match (item.object, item.primitive) {
            (POINT, i) => {
                let (lo, hi) = self.points[i as usize];
                Aabb::new(lo, hi)
            }
            (object, WHOLE) => return self.object_bounds(object),
            (object, primitive) => self.primitive_bounds(&self.accel.objects[object as usize], primitive),
        };
        self.padded(bounds)
    }

    fn padded(&self, b: Aabb) -> Aabb {
        if b.is_finite() { b.padded(self.padding(b)) } else { b }
    }

    fn padding(&self, b: Aabb) -> f64 {
        b.largest().max_element() * (2.0 * PADDING) + self.origin_error.max_element()
    }

    fn primitive_bounds(&self, object: &Object, primitive: u32) -> Aabb {
        match (&object.body, &object.place) {
            (Body::Mesh(mesh), Place::World) => {
                let [a, b, c] = mesh.corners(primitive);
                Aabb::new(a.min(b).min(c).as_dvec3(), a.max(b).max(c).as_dvec3())
            }
            (Body::Mesh(_), _) => object
                .corners_exact(primitive, self.accel.shutter.0.into())
                .into_iter()
                .fold(Aabb::EMPTY, |b, p| b.union(Aabb::new(p, p))),
            (Body::Shape(shape), Place::Fixed(pose)) => pose.bounds(shape.bounds()),
            (Body::Shape(shape), _) => shape.bounds(),
        }
    }

    pub(super) fn object_bounds(&self, object: u32) -> Aabb {
        let of = &self.accel.objects[object as usize];
        let bounds = match (&of.body, &of.place) {
            (Body::Mesh(mesh), Place::World) => {
                let grown = |b: Aabb, p: &Vec3| b.union(Aabb::new(p.as_dvec3(), p.as_dvec3()));
                mesh.positions.iter().fold(Aabb::EMPTY, grown)
            }
            (Body::Shape(shape), Place::World) => shape.bounds(),
            _ => self.accel.second.as_ref().and_then(|s| s.bounds_of_object(object)).unwrap_or(Aabb::EMPTY),
        };
        self.padded(bounds)
    }

    pub(super) fn outline(&self, item: Item) -> Outline {
        let (shape, error) = match (item.object, item.primitive) {
            (POINT, i) => {
                let (lo, hi) = self.points[i as usize];
                let error = lo.abs().max(hi.abs()) * f64::from(gamma(4));
                (if lo == hi { Form::Point(lo) } else { Form::Box }, error)
            }
            (_, WHOLE) => (Form::Box, DVec3::splat(self.padding(self.bounds(item)))),
            (object, primitive) => self.surface_outline(object, primitive),
        };
        Outline { shape, error: error + self.origin_error }
    }

    /// The outline of a static primitive. On a triangle the error bound is largest at a corner.
    fn surface_outline(&self, id: u32, primitive: u32) -> (Form, DVec3) {
        let (object, time) = (&self.accel.objects[id as usize], self.accel.shutter.0);
        match (&object.body, &object.place) {
            (Body::Mesh(_), _) => {
                let corners = object.corners_exact(primitive, time.into());
                let n = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                let error = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(u, v)| {
                    let hit = Hit { t: 0.0, u, v, primitive, object: id };
                    object.surface(&Ray::new(Vec3::ZERO, Vec3::Z), time.into(), &hit).p_error.as_dvec3()
                });
                (
                    Form::Flat(Box::new(Polygon::new(&corners)), n.normalize_or_zero()),
                    error.into_iter().fold(DVec3::ZERO, DVec3::max),
                )
            }
            (Body::Shape(shape), Place::World) => (standing(shape), shape.coordinate_error()),
            (Body::Shape(_), _) => {
                let bounds = self.primitive_bounds(object, primitive);
                (Form::Box, DVec3::splat(self.padding(bounds)))
            }
        }
    }
}

fn standing(shape: &Shape) -> Form {
    match shape {
        Shape::Sphere(s) => Form::Sphere { centre: s.centre.as_dvec3(), radius: s.radius.into() },
        Shape::Disk(d) => {
            let frame = Frame::from_z(d.normal.normalize_or(Vec3::Z));
            let (x, y) = (frame.x.as_dvec3(), frame.y.as_dvec3());
            let outline = Polygon::around_disk(d.centre.as_dvec3(), x, y, d.radius.into());
            Form::Flat(Box::new(outline), frame.z.as_dvec3())
        }
    }
}
