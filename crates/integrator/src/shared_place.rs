//! Which of the surfaces in one place is there?
//!
//! Hits of a ray that lie within each other's error bounds are one place: which of them is nearer is rounding. There the
//! side of an emitter that emits wins over any other surface, then what lets no light through, so that nothing shines
//! through the table that a glass stands on, then the boundaries of bodies (all of them: `interface::gather`) before thin
//! walls; among equals the lowest object, then the lowest primitive, so that of two walls in one place one is seen, without
//! speckle. Camera rays, rays that leave by a lobe and light samples all ask [`resolve`], so that light sampling and lobes
//! see the same lamp in the same place and weigh it once: lamps that lie in one another shine as one, and a lamp in the plane of a
//! ceiling shines like one just below it.
//!
//! Two opaque faces in one place whose fronts face opposite ways are not asked about: camera rays pass back faces
//! (`first_hit`), so that each side shows its own. Other rays meet either of the two, by rounding. All that stands on a floor
//! touches it in this way, and a question at every hit of the floor would cost more than it is worth.
//!
//! Only surfaces and lights that [`SharedPlaces`](dapple_scene::SharedPlaces) knows to share a place come here.

use crate::trace_context::TraceContext;
use crate::visibility::Visibility;
use dapple_geometry::{Hit, PlacePoint, Surface};
use dapple_lights::{LightPoint, LightSample};
use dapple_math::Ray;
use dapple_math::offset::gamma;
use dapple_scene::{Scene, SharedPlaces};
use glam::Vec3;
use std::cell::RefCell;

/// The scene's shared places, if it has any: the one question that other scenes are asked.
#[inline(always)]
pub(crate) fn of(scene: &Scene) -> Option<&SharedPlaces> {
    scene.shared_places.as_ref().filter(|_| cfg!(not(without = "coincident")))
}

/// At the nearest hit of a ray: makes it that of the surface which is there.
#[inline(never)]
pub(crate) fn resolve_shared<V: Visibility>(
    places: &SharedPlaces,
    ray: &Ray,
    (hit, surface): (&mut Hit, &mut Surface),
    context: &TraceContext<'_, V>,
) {
    if !places.contains(hit) {
        return;
    }
    let depth = places.surfaces.thickness() / surface.ng.dot(ray.d).abs();
    let end = (hit.t + depth).next_up().min(ray.t_max);
    // Nothing else stops the ray before `hit`, but by rounding.
    let hits = hits_between(0.0, &ray.until(end), context);
    let nearest = PlaceCandidate::new(places, ray, *hit, *surface, context);
    let others = hits.into_iter().filter(|other| places.contains(other));
    let winner = resolve(nearest, others.map(|hit| PlaceCandidate::of(places, ray, hit, context)));
    (*hit, *surface) = (winner.hit, winner.surface);
}

/// Whether a surface is a thin wall that may share its place.
pub(crate) fn is_wall(scene: &Scene, hit: &Hit) -> bool {
    let is_wall = |places: &SharedPlaces| places.contains(hit) && places.transmits(hit.object);
    scene.objects[hit.object as usize].body == u32::MAX && of(scene).is_some_and(is_wall)
}

/// Whether a thin wall is none, for a ray has just passed what is there in its place.
pub(crate) fn is_left_out(
    scene: &Scene,
    (last, passed): (Hit, Surface),
    (hit, surface): (Hit, Surface),
) -> bool {
    is_wall(scene, &hit)
        && of(scene).is_some_and(|all| all.contains(&last))
        && are_one_place(&passed, &surface)
}

/// Whether two hits of one ray lie within each other's error bounds, across the surfaces.
pub(crate) fn are_one_place(a: &Surface, b: &Surface) -> bool {
    let (between, error) = (b.p - a.p, a.p_error + b.p_error);
    [a.ng, b.ng].iter().all(|n| n.dot(between).abs() <= n.abs().dot(error))
}

/// Whether something stands between `o` and a sampled point of a light: as `blocked` by the shadow ray `ray`, but that in
/// the light's own place the surface decides which is there.
#[inline(never)]
pub(crate) fn is_hidden<V: Visibility>(
    places: &SharedPlaces,
    (light, sample): (usize, &LightSample),
    o: Vec3,
    ray: &Ray,
    context: &TraceContext<'_, V>,
) -> bool {
    match Target::new(places, context.scene, light, sample, o, context.time) {
        None => context.occluded(ray),
        Some(target) => context.occluded(&target.way()) || !target.is_seen(context),
    }
}

/// The part of the shadow ray `ray` on which something may stand between `o` and a sampled point of a light, if in the
/// light's own place the light is there.
#[inline(never)]
pub(crate) fn way<V: Visibility>(
    places: &SharedPlaces,
    (light, sample): (usize, &LightSample),
    o: Vec3,
    ray: Ray,
    context: &TraceContext<'_, V>,
) -> Option<Ray> {
    match Target::new(places, context.scene, light, sample, o, context.time) {
        None => Some(ray),
        Some(target) => target.is_seen(context).then(|| target.way()),
    }
}

/// A surface that may be the one in a place.
#[derive(Clone, Copy)]
struct PlaceCandidate {
    hit: Hit,
    surface: Surface,
    point: PlacePoint,
    class: Class,
}

/// What surfaces in one place are to each other, the winner first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Class {
    Lit,
    Opaque,
    Body,
    Wall,
}

impl PlaceCandidate {
    fn of<V: Visibility>(places: &SharedPlaces, ray: &Ray, hit: Hit, context: &TraceContext<'_, V>) -> Self {
        Self::new(places, ray, hit, context.scene.accel.surface(ray, context.time, &hit), context)
    }

    fn new<V: Visibility>(
        places: &SharedPlaces,
        ray: &Ray,
        hit: Hit,
        surface: Surface,
        context: &TraceContext<'_, V>,
    ) -> Self {
        let scene = context.scene;
        let from_front = scene.is_double_sided(hit.object) || ray.d.dot(surface.ng) < 0.0;
        let point = places.surfaces.point(&scene.accel, &hit, &surface, context.time);
        let class = match hit.object {
            object if places.emits(object) && from_front => Class::Lit,
            object if !places.transmits(object) => Class::Opaque,
            object if scene.objects[object as usize].body != u32::MAX => Class::Body,
            _ => Class::Wall,
        };
        Self { hit, surface, point, class }
    }

    /// Order in which surfaces win.
    fn rank(&self) -> (Class, u32, u32) {
        (self.class, self.hit.object, self.hit.primitive)
    }

    fn wins_over(&self, other: &Self) -> bool {
        match (self.class, other.class) {
            // The boundaries of bodies are met in their order.
            (Class::Body, Class::Body) => self.hit.wins_over(&other.hit),
            _ => self.rank() < other.rank(),
        }
    }
}

/// The one among `nearest` and the `others` in its place that is there. Its error bound then covers all of them, so that
/// rays that leave it start outside all of them.
fn resolve(nearest: PlaceCandidate, others: impl Iterator<Item = PlaceCandidate>) -> PlaceCandidate {
    let (mut winner, mut error) = (nearest, None);
    for other in others {
        let is_same = (other.hit.object, other.hit.primitive) == (nearest.hit.object, nearest.hit.primitive);
        if is_same || !nearest.point.is_one_with(&other.point) {
            continue;
        }
        error = Some(error.unwrap_or(nearest.point.error()).max(other.point.error()));
        if other.wins_over(&winner) {
            winner = other;
        }
    }
    // A plane lies at most the sum of both errors away, and its points one of them on.
    winner.surface.p_error += error.map_or(Vec3::ZERO, |error| 2.0 * error);
    winner
}

/// Everything that stops the ray at `from` or later.
fn hits_between<V: Visibility>(from: f32, ray: &Ray, context: &TraceContext<'_, V>) -> Vec<Hit> {
    let hits = RefCell::new(Vec::new());
    let note = |hit: &Hit| {
        if hit.t >= from {
            hits.borrow_mut().push(*hit);
        }
        false
    };
    context.visibility.any(context.scene, ray, context.time, context.key, &note);
    hits.into_inner()
}

/// A light sample of a light that shares its place.
struct Target<'a> {
    places: &'a SharedPlaces,
    light: u32,
    kind: Kind<'a>,
    /// From the receiver to the light; t = 1 is the light.
    ray: Ray,
    /// From here on the ray is in the light's place, or near it.
    from: f32,
}

enum Kind<'a> {
    Surface(&'a LightPoint),
    Point(Vec3),
}

/// How near to a light without extent surfaces are asked whether it lies in them, in parts of the distance.
const NEAR: f32 = 1.0 / 32.0;

impl<'a> Target<'a> {
    /// Of a sample seen from `o`; None when its light has its place to itself.
    fn new(
        places: &'a SharedPlaces,
        scene: &Scene,
        light: usize,
        sample: &'a LightSample,
        o: Vec3,
        time: f32,
    ) -> Option<Self> {
        if !places.contains_light(light as u32) {
            return None;
        }
        let (kind, p, depth) = match (&sample.point, scene.lights[light].position(time)) {
            (Some(point), _) => {
                let depth = places.surfaces.thickness() / point.n.dot(point.p - o).abs();
                (Kind::Surface(point), point.p, depth)
            }
            (None, Some(p)) => (Kind::Point(p), p, NEAR),
            (None, None) => return None,
        };
        let d = p - o;
        // Rounding may put the origin behind a light that its own surface lies on.
        let (from, end) = if d.dot(sample.wi) > 0.0 { (1.0 - depth, 1.0 + depth) } else { (0.0, 0.0) };
        Some(Self { places, light: light as u32, kind, ray: Ray { o, d, t_max: end }, from: from.max(0.0) })
    }

    /// The way to the light's place.
    fn way(&self) -> Ray {
        self.ray.until(self.from)
    }

    /// Whether the light is there at the end of the way.
    fn is_seen<V: Visibility>(&self, context: &TraceContext<'_, V>) -> bool {
        if self.ray.t_max <= 0.0 {
            return false;
        }
        match self.kind {
            Kind::Surface(point) => self.is_winner(point, context),
            Kind::Point(p) => !self.stands_behind(p, context),
        }
    }

    /// Whether the point stands behind a surface that it does not lie in.
    fn stands_behind<V: Visibility>(&self, p: Vec3, context: &TraceContext<'_, V>) -> bool {
        let stands_before = |hit: &Hit| {
            hit.t >= self.from
                && !PlaceCandidate::of(self.places, &self.ray, *hit, context)
                    .point
                    .holds(p, p.abs() * gamma(4))
        };
        context.visibility.any(context.scene, &self.ray.until(1.0), context.time, context.key, &stands_before)
    }

    /// Whether of all surfaces in the place of the sampled point that of its light is there. Where the ray passes its own
    /// surface by rounding, the point itself stands for it.
    fn is_winner<V: Visibility>(&self, at: &LightPoint, context: &TraceContext<'_, V>) -> bool {
        let mut hits = hits_between(self.from, &self.ray, context);
        hits.sort_unstable_by(|a, b| {
            a.t.total_cmp(&b.t).then((a.object, a.primitive).cmp(&(b.object, b.primitive)))
        });
        let is_own = |hit: &Hit| context.scene.light_of(hit) == Some(self.light);
        let of = |hit: &Hit| PlaceCandidate::of(self.places, &self.ray, *hit, context);
        let Some(nearest) = hits.first().map(of) else { return true };
        let own = hits.iter().find(|hit| is_own(hit));
        let target = own.map_or_else(|| self.point(at), |own| of(own).point);
        if !nearest.point.is_one_with(&target) {
            return nearest.hit.t >= 1.0;
        }
        let winner = resolve(nearest, hits[1..].iter().map(of));
        let source = context.scene.source_of(self.light);
        is_own(&winner.hit)
            || own.is_none()
                && source.is_some_and(|(object, first)| (Class::Lit, object, first) < winner.rank())
    }

    /// The sampled point as its surface would have it.
    fn point(&self, at: &LightPoint) -> PlacePoint {
        PlacePoint::new(at.p, at.n, at.p_error.max(at.p.abs() * gamma(7)), &self.places.surfaces)
    }
}
