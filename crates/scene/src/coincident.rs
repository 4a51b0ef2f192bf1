//! Coincident surfaces and lights, for which it matters which of them a ray hits first.
//!
//! Examples: an emitter in the plane of a ceiling, coinciding emitters, a point light in a wall, a glass on a table, a
//! panel in a wall. They are found once, when the scene is built; scenes without any store no data and do no tests.
use crate::{AlphaMode, Object, Space, TexturedMaterial, emission::AreaLights};
use dapple_geometry::{Accel, Coincident, Hit};
use dapple_lights::{Area, AreaShape, Light};
use dapple_math::offset::{UNIT_ROUNDOFF, gamma};
use glam::{DVec3, Vec3};

/// Coincident surfaces and lights.
#[derive(Clone, Debug)]
pub struct SharedPlaces {
    /// The coincident surfaces.
    pub surfaces: Box<Coincident>,
    /// Whether each light coincides with a surface other than its own.
    lights: Vec<bool>,
    kinds: Vec<Kind>,
}

/// Properties of an object that decide how coincident surfaces are treated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kind {
    /// Its material emits.
    pub emits: bool,
    /// Its material transmits light.
    pub transmits: bool,
    /// It neither emits nor transmits and is opaque. Decals with alpha are excluded: rounding decides which surface is
    /// hit.
    pub is_solid: bool,
}

impl Kind {
    pub fn new(material: &TexturedMaterial, emits: bool) -> Self {
        let transmits = material.transmits();
        let is_solid = !emits && !transmits && material.alpha_mode == AlphaMode::Opaque;
        Self { emits, transmits, is_solid }
    }
}

impl SharedPlaces {
    /// Finds the coincident surfaces and lights; None if there are none that matter. `kinds` is indexed by object;
    /// `punctual` are the lights that follow those of `area`. Touching boundaries of bodies do not count: rays cross
    /// all of them.
    pub(crate) fn find(
        accel: &Accel,
        (objects, kinds): (&[Object], Vec<Kind>),
        (area, punctual): (&AreaLights, &[Light]),
        space: &Space,
    ) -> Option<Self> {
        if cfg!(without = "coincident") {
            return None;
        }
        let (numbers, points): (Vec<usize>, Vec<(DVec3, DVec3)>) =
            punctual.iter().enumerate().filter_map(|(i, light)| Some((i, light.positions()?))).unzip();
        let shines =
            |object, primitive| area.of(&Hit { t: 0.0, u: 0.0, v: 0.0, primitive, object }).is_some();
        let group = |object: u32| match kinds[object as usize] {
            Kind { emits: false, transmits: false, .. } => None,
            Kind { transmits: true, .. } if objects[object as usize].body != u32::MAX => Some(BODIES),
            _ => Some(object),
        };
        let solid = |object: u32| kinds[object as usize].is_solid;
        let surfaces = accel.coincident(group, shines, &points, origin_error(space), solid)?;
        let count = area.lights.len();
        let mut shared: Vec<bool> = (0..count as u32).map(|i| area.is_on(i, &surfaces)).collect();
        shared.resize(count + punctual.len(), false);
        for (number, light) in numbers.into_iter().enumerate() {
            shared[count + light] = surfaces.contains_point(number);
        }
        Some(Self { surfaces, lights: shared, kinds })
    }

    /// Flags the lights that are invisible because an earlier one coincides with and covers them; `is_solid` tells
    /// whether an object has no holes. Moving lights, and lights covered only by several others together, are not
    /// detected: they are sampled without effect.
    pub(crate) fn hidden(
        &self,
        area: &AreaLights,
        is_solid: impl Fn(u32) -> bool,
        space: &Space,
    ) -> Vec<bool> {
        let mut hidden = vec![false; area.lights.len()];
        let (mut covers, mut budget): (Vec<&Area>, _) = (Vec::new(), COMPARISONS);
        for (i, light) in area.lights.iter().enumerate() {
            let Light::Area(light) = light else { continue };
            if !self.contains_light(i as u32) {
                continue;
            }
            budget = budget.saturating_sub(covers.len());
            hidden[i] =
                budget > 0 && covers.iter().any(|cover| is_covered(light, cover, origin_error(space)));
            if !hidden[i] && is_solid(area.sources[i].0) {
                covers.push(light);
            }
        }
        hidden
    }

    /// Removes lights from the list, as [`AreaLights::remove`] does.
    pub(crate) fn remove(&mut self, is_removed: &[bool]) {
        let mut index = 0..self.lights.len();
        self.lights.retain(|_| index.next().is_some_and(|i| !is_removed.get(i).copied().unwrap_or(false)));
    }

    /// Whether light `light` coincides with a surface other than its own.
    pub fn contains_light(&self, light: u32) -> bool {
        self.lights.get(light as usize).copied().unwrap_or(false)
    }

    /// Whether the surface that was hit may coincide with another one for which it matters.
    #[inline]
    pub fn contains(&self, hit: &Hit) -> bool {
        self.surfaces.contains(hit.object, hit.primitive)
    }

    /// Whether the material of an object emits, even if its light is not part of the scene.
    pub fn emits(&self, object: u32) -> bool {
        self.kinds.get(object as usize).is_some_and(|kind| kind.emits)
    }

    /// Whether the material of an object transmits light.
    pub fn transmits(&self, object: u32) -> bool {
        self.kinds.get(object as usize).is_some_and(|kind| kind.transmits)
    }

    /// Number of lights that coincide with a surface other than their own.
    pub fn light_count(&self) -> usize {
        self.lights.iter().filter(|shared| **shared).count()
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.surfaces.memory_bytes() + self.lights.len() + size_of_val(&*self.kinds)
    }
}

/// Group that contains all boundaries of bodies.
const BODIES: u32 = u32::MAX;

/// Maximum number of comparisons between lights.
const COMPARISONS: usize = 1 << 26;

/// Whether `light` lies completely within `cover`, which emits to every side to which `light` emits.
fn is_covered(light: &Area, cover: &Area, origin_error: Vec3) -> bool {
    let bound = |p: DVec3| (p.abs() * f64::from(gamma(7)) + origin_error.as_dvec3()) * 2.0;
    let same_side = |n: Vec3, m: Vec3| cover.two_sided || (!light.two_sided && n.dot(m) > 0.0);
    match (light.shape, cover.shape) {
        (AreaShape::Sphere { centre, radius }, AreaShape::Sphere { centre: c, radius: r }) => {
            let reach = bound(centre.as_dvec3().abs() + DVec3::splat(radius.into())).length();
            let apart = (centre.as_dvec3() - c.as_dvec3()).length() + f64::from(radius - r).abs();
            same_side(Vec3::Z, Vec3::Z) && apart <= reach
        }
        (AreaShape::Disk { centre, normal, radius }, AreaShape::Disk { centre: c, normal: n, radius: r }) => {
            let reach = bound(centre.as_dvec3().abs() + DVec3::splat(radius.into())).length();
            let apart = centre.as_dvec3() - c.as_dvec3();
            let tilt = f64::from(normal.cross(n).length() * radius);
            let in_plane = apart.dot(n.as_dvec3()).abs() + tilt <= reach;
            same_side(normal, n) && in_plane && apart.length() + f64::from(radius) <= f64::from(r) + reach
        }
        (light, cover) => match (corners(&light), corners(&cover)) {
            (Some(inner), Some(outer)) => {
                let (n, m) = (normal(&inner), normal(&outer));
                let is_inside = inner.iter().all(|q| is_on(&outer, m, *q, bound(*q)));
                same_side(n.as_vec3(), m.as_vec3()) && is_inside
            }
            _ => false,
        },
    }
}

/// Corners of a flat polygonal light, in order.
fn corners(shape: &AreaShape) -> Option<Vec<DVec3>> {
    match *shape {
        AreaShape::Triangle(corners) => Some(corners.map(Vec3::as_dvec3).to_vec()),
        AreaShape::Quad { corner, e1, e2 } => {
            let [p, a, b] = [corner, e1, e2].map(Vec3::as_dvec3);
            Some(vec![p, p + a, p + a + b, p + b])
        }
        _ => None,
    }
}

fn normal(corners: &[DVec3]) -> DVec3 {
    (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero()
}

/// Whether `q` lies on a convex polygon with unit normal `n`, within `bound` per axis.
fn is_on(polygon: &[DVec3], n: DVec3, q: DVec3, bound: DVec3) -> bool {
    let within = |axis: DVec3, distance: f64| distance <= axis.abs().dot(bound);
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let beside = |(a, b): (&DVec3, &DVec3)| {
        let outward = (*b - *a).cross(n).normalize_or_zero();
        within(outward, outward.dot(q - *a))
    };
    within(n, n.dot(q - polygon[0]).abs()) && edges.into_iter().all(beside)
}

/// Rounding error of world coordinates in the input, in render units: files store f32, so it is half an ulp of the
/// distance from the world's origin. The part proportional to render-space coordinates is in the surfaces' own bounds.
fn origin_error(space: &Space) -> Vec3 {
    ((space.centre.abs() * space.scale) * f64::from(UNIT_ROUNDOFF)).as_vec3()
}
