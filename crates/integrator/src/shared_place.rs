//! Coincident surfaces: resolves which of several surfaces at the same position a ray hits.
//!
//! Hits of a ray that lie within each other's error bounds are treated as coincident: which of them is nearer is
//! determined by rounding. At such a position the emitting side of an emitter wins over any other surface, then opaque
//! surfaces, so that nothing shines through the table under a glass, then the boundaries of bodies (all of them:
//! `interface::gather`) before thin walls; among equals the lowest object, then the lowest primitive, so that of two
//! coincident walls one is visible, without speckle. Camera rays, rays from BSDF sampling and light samples all use
//! [`resolve`], so that light sampling and BSDF sampling find the same lamp at the same position and count it once:
//! coincident lamps shine as one, and a lamp in the plane of a ceiling shines like one just below it.
//!
//! Two coincident opaque faces with opposite front sides are not resolved: camera rays pass back faces (`first_hit`),
//! so that each side shows its own surface. Other rays hit either of the two, depending on rounding. Every object on a
//! floor touches it in this way, and a query at every hit of the floor would cost more than it gains.
//!
//! Only surfaces and lights that are listed in [`SharedPlaces`](dapple_scene::SharedPlaces) as coincident reach this
//! code.

use crate::trace_context::TraceContext;
use crate::visibility::Visibility;
use dapple_geometry::{Hit, PlacePoint, Surface};
use dapple_lights::{LightPoint, LightSample};
use dapple_math::Ray;
use dapple_math::offset::gamma;
use dapple_scene::{Scene, SharedPlaces};
use glam::Vec3;
use std::cell::RefCell;

/// The scene's coincident surfaces, if it has any: the only check in scenes without them.
#[inline(always)]
pub(crate) fn of(scene: &Scene) -> Option<&SharedPlaces> {
    scene.shared_places.as_ref().filter(|_| cfg!(not(without = "coincident")))
}

/// Replaces the nearest hit of a ray by the winning hit of the surfaces that coincide with it.
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
    // Except for rounding, nothing else stops the ray before `hit`.
    let hits = hits_between(0.0, &ray.until(end), context);
    let nearest = PlaceCandidate::new(places, ray, *hit, *surface, context);
    let others = hits.into_iter().filter(|other| places.contains(other));
    let winner = resolve(nearest, others.map(|hit| PlaceCandidate::of(places, ray, hit, context)));
    (*hit, *surface) = (winner.hit, winner.surface);
}

/// Whether a surface is a thin wall that may coincide with another surface.
pub(crate) fn is_wall(scene: &Scene, hit: &Hit) -> bool {
    let is_wall = |places: &SharedPlaces| places.contains(hit) && places.transmits(hit.object);
    scene.objects[hit.object as usize].body == u32::MAX && of(scene).is_some_and(is_wall)
}

/// Whether a thin wall is skipped because the ray has just passed a surface that coincides with it.
pub(crate) fn is_left_out(
    scene: &Scene,
    (last, passed): (Hit, Surface),
    (hit, surface): (Hit, Surface),
) -> bool {
    is_wall(scene, &hit)
        && of(scene).is_some_and(|all| all.contains(&last))
        && are_one_place(&passed, &surface)
}

/// Whether two hits of one ray lie within each other's error bounds, measured along the normals of the surfaces.
pub(crate) fn are_one_place(a: &Surface, b: &Surface) -> bool {
    let (between, error) = (b.p - a.p, a.p_error + b.p_error);
    [a.ng, b.ng].iter().all(|n| n.dot(between).abs() <= n.abs().dot(error))
}

/// Whether the segment between `o` and a sampled point of a light is occluded by the shadow ray `ray`, where surfaces
/// that coincide with the light are resolved.
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
        Some(target) => context.occluded(&target.segment()) || !target.is_seen(context),
    }
}

/// The part of the shadow ray `ray` between `o` and a sampled point of a light that surfaces may occlude; `None` if
/// another surface wins at the position of the light.
#[inline(never)]
pub(crate) fn segment_to_light<V: Visibility>(
    places: &SharedPlaces,
    (light, sample): (usize, &LightSample),
    o: Vec3,
    ray: Ray,
    context: &TraceContext<'_, V>,
) -> Option<Ray> {
    match Target::new(places, context.scene, light, sample, o, context.time) {
        None => Some(ray),
        Some(target) => target.is_seen(context).then(|| target.segment()),
    }
}

/// A surface at a shared position.
#[derive(Clone, Copy)]
struct PlaceCandidate {
    hit: Hit,
    surface: Surface,
    point: PlacePoint,
    class: Class,
}

/// Classes of coincident surfaces, the winner first.
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
            // The boundaries of bodies are crossed in their order.
            (Class::Body, Class::Body) => self.hit.wins_over(&other.hit),
            _ => self.rank() < other.rank(),
        }
    }
}

/// The winner among `nearest` and those of the `others` that coincide with it. Its error bound is extended to all of
/// them, so that rays that leave it start outside of all of them.
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
    // A plane lies at most the sum of both errors away, and its points one more error further.
    winner.surface.p_error += error.map_or(Vec3::ZERO, |error| 2.0 * error);
    winner
}

/// All hits of the ray from parameter `from` on.
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

/// A sample of a light that coincides with surfaces.
struct Target<'a> {
    places: &'a SharedPlaces,
    light: u32,
    kind: Kind<'a>,
    /// Segment from the receiver to the light, which is at t = 1.
    ray: Ray,
    /// Ray parameter from which on the ray is at or near the position of the light.
    from: f32,
}

enum Kind<'a> {
    Surface(&'a LightPoint),
    Point(Vec3),
}

/// Distance, relative to that of the light, within which surfaces are tested for containing a light without extent.
const NEAR: f32 = 1.0 / 32.0;

impl<'a> Target<'a> {
    /// The target of a sample seen from `o`; `None` if no surface coincides with its light.
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
        // Rounding may put the origin behind a light in the plane of the receiving surface.
        let (from, end) = if d.dot(sample.wi) > 0.0 { (1.0 - depth, 1.0 + depth) } else { (0.0, 0.0) };
        Some(Self { places, light: light as u32, kind, ray: Ray { o, d, t_max: end }, from: from.max(0.0) })
    }

    /// The segment up to the position of the light.
    fn segment(&self) -> Ray {
        self.ray.until(self.from)
    }

    /// Whether the light wins at the end of the segment.
    fn is_seen<V: Visibility>(&self, context: &TraceContext<'_, V>) -> bool {
        if self.ray.t_max <= 0.0 {
            return false;
        }
        match self.kind {
            Kind::Surface(point) => self.is_winner(point, context),
            Kind::Point(p) => !self.stands_behind(p, context),
        }
    }

    /// Whether the light lies behind a surface that does not contain it.
    fn stands_behind<V: Visibility>(&self, p: Vec3, context: &TraceContext<'_, V>) -> bool {
        let stands_before = |hit: &Hit| {
            hit.t >= self.from
                && !PlaceCandidate::of(self.places, &self.ray, *hit, context)
                    .point
                    .holds(p, p.abs() * gamma(4))
        };
        context.visibility.any(context.scene, &self.ray.until(1.0), context.time, context.key, &stands_before)
    }

    /// Whether the surface of the light wins among all surfaces at the sampled point. Where the ray misses that surface
    /// because of rounding, the sampled point replaces it.
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

    /// The sampled point as a point on its surface.
    fn point(&self, at: &LightPoint) -> PlacePoint {
        PlacePoint::new(at.p, at.n, at.p_error.max(at.p.abs() * gamma(7)), &self.places.surfaces)
    }
}
