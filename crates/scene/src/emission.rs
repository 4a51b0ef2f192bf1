//! Area lights: emitting surfaces and their radiance.
//!
//! Radiance = emissiveFactor × strength × texture, from the front side, and from both if double-sided. Every emitting
//! triangle, sphere and disk is a separate area light; two adjacent triangles that form a parallelogram of constant
//! radiance are one quad. A light stores the mean radiance of its surface, from which the probability of selecting it
//! is derived; the actual radiance of a sampled point is looked up there (`Scene::light_radiance`). Every surface that
//! emits anywhere is a light.
//!
//! Unlit (shadeless) surfaces are not lights: they are visible, but do not illuminate other surfaces.
use crate::emitter::Emitter;
use crate::form::{Form, Movement};
use crate::patterns::{Mean, Patterns};
use dapple_geometry::{Coincident, Hit};
use dapple_lights::{Area, AreaShape, Light, Moving};
use glam::Vec3;

/// Index that stands for no light.
pub(crate) const DARK: u32 = u32::MAX;

/// The area lights of a scene, and the map from surfaces to them.
#[derive(Clone, Debug, Default)]
pub(crate) struct AreaLights {
    pub lights: Vec<Light>,
    /// Object and first primitive of each light.
    pub sources: Vec<(u32, u32)>,
    /// Per object: index of its first primitive in `of_primitive`; `DARK` for objects that emit nothing.
    starts: Vec<u32>,
    of_primitive: Vec<u32>,
}

impl AreaLights {
    /// Adds the lights of the next object, whose index is `object`; objects must be added in order.
    pub fn add(
        &mut self,
        patterns: &mut Patterns<'_>,
        (object, material): (u32, u32),
        form: Form,
        movement: Option<&Movement>,
    ) {
        let emitter = &patterns.emitter(material);
        if !emitter.material.is_light() {
            return self.starts.push(DARK);
        }
        let before = self.lights.len();
        let start = self.of_primitive.len() as u32;
        let source = Source { emitter, object, material, movement };
        match form {
            Form::Triangles(count) => self.triangles(patterns, &source, count),
            Form::Sphere { centre, radius } => self.shape(&source, AreaShape::Sphere { centre, radius }),
            Form::Disk { centre, normal, radius } => {
                self.shape(&source, AreaShape::Disk { centre, normal, radius });
            }
        }
        let dark = self.lights.len() == before;
        self.starts.push(if dark { DARK } else { start });
    }

    /// The light to which the hit surface belongs.
    pub fn of(&self, hit: &Hit) -> Option<u32> {
        let start = self.starts[hit.object as usize];
        let light = if start == DARK { DARK } else { self.of_primitive[(start + hit.primitive) as usize] };
        (light != DARK).then_some(light)
    }

    /// Removes lights from the list; their surfaces then belong to no light.
    pub fn remove(&mut self, is_removed: &[bool]) {
        let kept = |i: u32| !is_removed.get(i as usize).copied().unwrap_or(false);
        let mut next = 0;
        let numbers: Vec<u32> = (0..self.lights.len() as u32)
            .map(|i| {
                next += u32::from(kept(i));
                if kept(i) { next - 1 } else { DARK }
            })
            .collect();
        let mut index = 0..self.lights.len() as u32;
        self.lights.retain(|_| index.next().is_some_and(kept));
        let mut index = 0..numbers.len() as u32;
        self.sources.retain(|_| index.next().is_some_and(kept));
        for light in self.of_primitive.iter_mut().filter(|light| **light != DARK) {
            *light = numbers[*light as usize];
        }
    }

    /// Whether a light's surface is among the coincident ones.
    pub fn is_on(&self, light: u32, surfaces: &Coincident) -> bool {
        let Some(&(object, first)) = self.sources.get(light as usize) else { return false };
        let start = self.starts[object as usize];
        let own = |primitive: &u32| {
            start != DARK && self.of_primitive.get((start + primitive) as usize) == Some(&light)
        };
        (first..).take_while(own).any(|primitive| surfaces.contains(object, primitive))
    }

    /// First light of an object; `DARK` if it has none.
    pub fn first(&self, object: u32, primitives: usize) -> u32 {
        match self.starts[object as usize] {
            DARK => DARK,
            start => *self.of_primitive[start as usize..][..primitives].iter().min().unwrap_or(&DARK),
        }
    }

    pub fn memory_bytes(&self) -> usize {
        self.lights.capacity() * size_of::<Light>()
            + self.sources.capacity() * size_of::<(u32, u32)>()
            + (self.starts.capacity() + self.of_primitive.capacity()) * 4
    }

    fn shape(&mut self, source: &Source<'_>, shape: AreaShape) {
        let light = self.push(source, 0, shape, source.emitter.mean_of_shape(source.object));
        self.of_primitive.push(light);
    }

    fn triangles(&mut self, patterns: &mut Patterns<'_>, source: &Source<'_>, count: usize) {
        let (emitter, object) = (source.emitter, source.object);
        let mut primitive = 0;
        while (primitive as usize) < count {
            let corners = source.corners(primitive);
            let (shape, covered) = if emitter.is_constant() && primitive as usize + 1 < count {
                parallelogram(corners, source.corners(primitive + 1))
                    .map_or((None, 1), |quad| (Some(quad), 2))
            } else {
                (None, 1)
            };
            let shape = shape.unwrap_or(AreaShape::Triangle(corners));
            let light = if emitter.is_constant() {
                self.push(source, primitive, shape, emitter.material.emission)
            } else {
                let Mean { radiance, middle, varies } =
                    patterns.mean(source.material, (object, primitive), count);
                let light = self.push(source, primitive, shape, radiance);
                if varies && light != DARK {
                    patterns.note(light, middle);
                }
                light
            };
            self.of_primitive.extend((0..covered).map(|_| light));
            primitive += covered;
        }
    }

    fn push(&mut self, source: &Source<'_>, primitive: u32, shape: AreaShape, radiance: Vec3) -> u32 {
        if radiance == Vec3::ZERO {
            return DARK;
        }
        let area = Area { shape, radiance, two_sided: source.emitter.material.double_sided };
        self.lights.push(match source.movement {
            None => Light::Area(area),
            Some(m) => {
                let moving = Moving::area(area, m.motion.clone(), m.seconds, Some(m.whole));
                Light::Moving(Box::new(if m.stays_round { moving } else { moving.oval() }))
            }
        });
        self.sources.push((source.object, primitive));
        self.lights.len() as u32 - 1
    }
}

/// An emitting object.
struct Source<'a> {
    emitter: &'a Emitter<'a>,
    object: u32,
    material: u32,
    movement: Option<&'a Movement>,
}

impl Source<'_> {
    /// Corners of a triangle, in the object's own space if it moves.
    fn corners(&self, primitive: u32) -> [Vec3; 3] {
        match self.movement {
            None => self.emitter.accel.corners(self.object, primitive),
            Some(_) => self.emitter.accel.own_corners(self.object, primitive),
        }
    }
}

/// The parallelogram formed by two triangles with a shared edge and the same front side. The corners may deviate from
/// it by their own rounding only.
fn parallelogram(a: [Vec3; 3], b: [Vec3; 3]) -> Option<AreaShape> {
    for i in 0..3 {
        let (corner, next, before) = (a[i], a[(i + 1) % 3], a[(i + 2) % 3]);
        // `next`–`before` is the candidate for the shared edge, which `b` has in the opposite direction.
        for j in 0..3 {
            if b[j] == before && b[(j + 1) % 3] == next {
                let (e1, e2) = (next - corner, before - corner);
                let far = b[(j + 2) % 3];
                let miss = (far - next) - e2;
                let size = [corner, next, before, far].map(|p| p.abs().max_element());
                let rounding = size.into_iter().fold(0.0, f32::max) * (4.0 * f32::EPSILON);
                let small = 1e-3 * e1.abs().max_element().min(e2.abs().max_element());
                let fits = miss.abs().max_element();
                let is_one = fits <= rounding && fits <= small && is_flat(miss, [corner, next, before, far]);
                return is_one.then_some(AreaShape::Quad { corner, e1, e2 });
            }
        }
    }
    None
}

/// Whether the plane of a parallelogram passes through the surface's far corner within the error bound of points
/// sampled on it, which are rounded by half an ulp; otherwise the surface would occlude its own light. `miss` is the
/// vector from the far corner of the parallelogram to that of the surface. The far corner is the last one; `next` and
/// `before` are interchangeable.
fn is_flat(miss: Vec3, [corner, next, before, far]: [Vec3; 4]) -> bool {
    let n = (next - corner).as_dvec3().cross((before - corner).as_dvec3()).normalize_or_zero();
    let low = corner.min(next).min(before).min(far);
    let high = corner.max(next).max(before).max(far);
    // The smallest absolute coordinate per axis, 0 if the surface extends to both sides.
    let least = low.max(-high).max(Vec3::ZERO);
    let edges = (next - corner).abs() + (before - corner).abs();
    let bound = (least * 0.5 + edges) * f32::EPSILON;
    n.dot(miss.as_dvec3()).abs() <= n.abs().dot(bound.as_dvec3())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_split_square_is_one_quad_whatever_the_corner_order() {
        let p = [Vec3::ZERO, Vec3::X, Vec3::new(1.2, 1.0, 0.0), Vec3::new(0.2, 1.0, 0.0)];
        let rotate = |t: [Vec3; 3], k: usize| [t[k % 3], t[(k + 1) % 3], t[(k + 2) % 3]];
        for k in 0..9 {
            let quad = parallelogram(rotate([p[0], p[1], p[2]], k % 3), rotate([p[0], p[2], p[3]], k / 3));
            let Some(AreaShape::Quad { corner, e1, e2 }) = quad else { panic!("{k}") };
            assert_eq!(corner, p[1], "the corner opposite the shared edge");
            assert!(e1.cross(e2).z > 0.0, "same front side");
            assert!(((corner + e1 + e2) - p[3]).length() < 1e-6);
        }
    }

    /// The coordinates along the normal are near 0, where points of a quad have small error bounds.
    #[test]
    fn a_square_that_rounding_bends_out_of_its_plane_is_two_triangles() {
        let square = |far: f32| {
            let p =
                [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, z)| Vec3::new(x, 0.0, z) * 64.0);
            let q = Vec3::new(64.0, far, 64.0);
            parallelogram([p[0], p[1], p[3]], [p[1], q, p[3]])
        };
        assert!(square(0.0).is_some());
        assert!(square(1e-5).is_none() && square(-1e-5).is_none());
    }

    #[test]
    fn other_pairs_are_left_alone() {
        let p = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 1.01, 0.0)];
        assert!(parallelogram([p[0], p[1], p[2]], [p[0], p[2], p[3]]).is_none(), "not quite");
        assert!(parallelogram([p[0], p[1], p[2]], [p[2], p[0], Vec3::Y]).is_none(), "opposite fronts");
        let bent = Vec3::new(0.0, 1.0, 0.1);
        assert!(parallelogram([p[0], p[1], p[2]], [p[0], p[2], bent]).is_none(), "not flat");
    }
}
