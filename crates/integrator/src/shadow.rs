//! Transmittance of shadow rays: opaque surfaces block them, smooth transparent surfaces attenuate them.
//!
//! A shadow ray is straight. Surfaces that do not refract light transmit it exactly: thin walls and boundaries between
//! equal indices, if they are smooth, and boundaries hidden inside a body of higher priority; absorption is accumulated
//! segment by segment. Where light is refracted the shadow ray ends, because the straight segment is not a light path;
//! with `Settings::transparent_shadows` it continues, an *approximation*: the light that is not reflected passes in a
//! straight line.
//!
//! Light that both light sampling and BSDF sampling can find along the same straight segment is weighted by MIS as
//! usual (`emission::MisContext` keeps the vertex at which the segment began). Surfaces are visited in the order of
//! `Hit::wins_over`, so that products do not depend on the traversal order.

use crate::interface::gather;
use crate::medium::MediumStack;
use crate::shared_place::{self, are_one_place};
use crate::trace_context::TraceContext;
use crate::vertex::Vertex;
use crate::visibility::{Query, Visibility};
use dapple_geometry::{Hit, Surface};
use dapple_math::Ray;
use glam::Vec3;
use std::cell::Cell;

/// Maximum number of transparent surfaces that a shadow ray passes; light through more surfaces is lost, and counted in
/// the bias report.
pub(crate) const MOST: u32 = 256;

/// Maximum number of hits per surface, on average: a ray through an edge or a corner hits several triangles of one
/// surface.
const SAME: u32 = 16;

/// Result of a shadow ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Passage {
    /// No light is transmitted.
    Blocked,
    /// The ray crosses more transparent surfaces than [`MOST`].
    Lost,
    Open(ShadowPath),
}

/// An unblocked segment to a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ShadowPath {
    pub transmittance: Vec3,
    /// Number of surfaces passed, each of which is a bounce of a path along the same segment.
    pub passed: u32,
    /// Light is refracted along the segment, so that no path follows it.
    pub bent: bool,
}

impl<V: Visibility> TraceContext<'_, V> {
    /// The transmittance along `ray` of a light at `distance`, for a ray that starts inside the bodies of `stack`.
    #[inline(always)]
    pub fn passage(&self, ray: &Ray, stack: &MediumStack, distance: f32) -> Passage {
        if !V::PLAIN && (self.job.clear_ways || !stack.is_empty()) {
            return self.through(ray, stack, distance);
        }
        if self.occluded(ray) {
            return Passage::Blocked;
        }
        Passage::Open(ShadowPath { transmittance: Vec3::ONE, passed: 0, bent: false })
    }

    #[inline(never)]
    fn through(&self, ray: &Ray, stack: &MediumStack, distance: f32) -> Passage {
        let at = Query { scene: self.scene, ray, time: self.time, key: self.key };
        let is_met = Cell::new(false);
        let stops = |hit: &Hit| {
            let may_pass = self.job.may_pass(hit.object, stack);
            is_met.set(is_met.get() || may_pass);
            !may_pass
        };
        if self.visibility.blocked_where(&at, &stops) {
            return Passage::Blocked;
        }
        if !is_met.get() {
            let transmittance = stack.transmittance(self.job.media.bodies, distance);
            return Passage::Open(ShadowPath { transmittance, passed: 0, bent: false });
        }
        self.visit_surfaces(&at, stack, distance)
    }

    /// Visits the surfaces in order. Where light is refracted, a bundle of rays spreads by the ratio of the indices:
    /// with segments sᵢ of index nᵢ from a light in index n₀ the irradiance is that of the distance n₀·Σ sᵢ/nᵢ (exact
    /// along the normals of the surfaces [Born & Wolf 1999, §4.4]).
    fn visit_surfaces(&self, at: &Query<'_>, stack: &MediumStack, distance: f32) -> Passage {
        let (scene, bodies, length) = (self.scene, self.job.media.bodies, at.ray.d.length());
        let mut way = ShadowPath { transmittance: Vec3::ONE, passed: 0, bent: false };
        let (mut stack, mut gone) = (*stack, 0.0);
        // Sum of the segment lengths, each over its index of refraction.
        let mut reduced = 0.0;
        let mut last: Option<(Hit, Surface)> = None;
        let mut crossings = 0;
        for _ in 0..SAME * (MOST + 1) {
            let beyond = |hit: &Hit| last.is_none_or(|(last, _)| last.wins_over(hit));
            let Some(mut hit) = self.visibility.closest_where(at, &beyond) else {
                way.transmittance *= stack.transmittance(bodies, distance - gone);
                if way.bent && distance < f32::INFINITY {
                    reduced += (distance - gone) / stack.ior(bodies);
                    way.transmittance *= (distance / (reduced * stack.ior(bodies))).powi(2);
                }
                return Passage::Open(way);
            };
            let mut surface = scene.accel.surface(at.ray, self.time, &hit);
            if last.is_some_and(|last| is_same_crossing(last, (hit, surface), at.ray.d)) {
                last = Some((hit, surface));
                continue;
            }
            if let Some(places) = shared_place::of(scene) {
                if let Some((_, passed)) =
                    last.filter(|last| shared_place::is_left_out(scene, *last, (hit, surface)))
                {
                    last = Some((hit, passed));
                    continue;
                }
                shared_place::resolve_shared(places, at.ray, (&mut hit, &mut surface), self);
            }
            crossings += 1;
            if crossings > MOST {
                break;
            }
            way.transmittance *= stack.transmittance(bodies, hit.t * length - gone);
            if self.job.settings.transparent_shadows {
                reduced += (hit.t * length - gone) / stack.ior(bodies);
            }
            gone = hit.t * length;
            let first = hit;
            let mut boundary = None;
            if scene.objects[hit.object as usize].body != u32::MAX && !bodies.is_empty() {
                let (met, end) = gather(self, at.ray, &hit, &mut surface, &stack);
                (boundary, hit) = (Some(met), end);
            }
            if boundary.is_none_or(|boundary| !boundary.is_hidden()) {
                let seen = (at.ray, -at.ray.d / length);
                let vertex = Vertex::new(self.job, seen, (&first, &surface), (self.time, boundary.as_ref()));
                if !self.pass(&vertex, &mut way) {
                    return Passage::Blocked;
                }
            }
            stack = boundary.map_or(stack, |boundary| boundary.after);
            last = Some((hit, surface));
        }
        Passage::Lost
    }

    /// Passes one surface; returns false if no light is transmitted.
    fn pass(&self, vertex: &Vertex, way: &mut ShadowPath) -> bool {
        let mut through = if vertex.shading.unlit { Vec3::ZERO } else { vertex.bsdf.straight() };
        if through == Vec3::ZERO && self.job.settings.transparent_shadows && !vertex.shading.unlit {
            through = vertex.bsdf.straightened();
            way.bent = true;
        }
        way.transmittance *= through;
        way.passed += 1;
        way.transmittance != Vec3::ZERO
    }
}

/// A ray through an edge hits both adjacent triangles: the same surface from the same side at the same position.
fn is_same_crossing((hit, surface): (Hit, Surface), (next, other): (Hit, Surface), d: Vec3) -> bool {
    let side = |of: &Surface| of.ng.dot(d) < 0.0;
    hit.object == next.object && side(&surface) == side(&other) && are_one_place(&surface, &other)
}
