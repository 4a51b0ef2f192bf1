//! Area lights: emitting triangles, quads, spheres and disks.
//!
//! Triangles and quads are sampled uniformly in solid angle if theirs is at least `SMALL`, else uniformly in area (the
//! two densities are then nearly equal); spheres are sampled in the cone they subtend, and disks uniformly in area.
use crate::aimed::Aimed;
use crate::lanes::{Disk, Rectangle, Sphere, Triangle, disk, flat};
use crate::{LightPoint, LightSample, polygon::Facet, rectangle, sphere};
use glam::{Vec2, Vec3};
use std::f64::consts::PI;

/// A surface with uniform emission.
#[derive(Clone, Debug)]
pub struct Area {
    /// Shape and position.
    pub shape: AreaShape,
    /// Mean radiance, W·m⁻²·sr⁻¹.
    pub radiance: Vec3,
    /// Whether it emits from the back as well.
    pub two_sided: bool,
}

/// Shapes of area lights. The front is the side from which the corners are counter-clockwise, the outside of a sphere,
/// and the side of `normal`.
#[derive(Clone, Copy, Debug)]
pub enum AreaShape {
    /// A triangle by its corners. [`LightPoint::triangle`] is 0, with the corners in this order.
    Triangle([Vec3; 3]),
    /// A parallelogram by a corner and two edges; the front is the side to which e1×e2 points. With P0 = corner,
    /// P1 = corner + e1, P2 = corner + e1 + e2, P3 = corner + e2, triangle 0 is (P0, P1, P2) and triangle 1 is
    /// (P0, P2, P3).
    Quad {
        /// P0.
        corner: Vec3,
        /// P1 − P0.
        e1: Vec3,
        /// P3 − P0.
        e2: Vec3,
    },
    /// An exact sphere, without barycentric coordinates.
    Sphere {
        /// Centre.
        centre: Vec3,
        /// Radius.
        radius: f32,
    },
    /// An exact disk, without barycentric coordinates.
    Disk {
        /// Centre.
        centre: Vec3,
        /// Unit normal of the front.
        normal: Vec3,
        /// Radius.
        radius: f32,
    },
}

impl AreaShape {
    /// Surface area in square render units.
    pub fn area(&self) -> f64 {
        match *self {
            Self::Triangle([a, b, c]) => 0.5 * cross_length(b - a, c - a),
            Self::Quad { e1, e2, .. } => cross_length(e1, e2),
            Self::Sphere { radius, .. } => 4.0 * PI * radius as f64 * radius as f64,
            Self::Disk { radius, .. } => PI * radius as f64 * radius as f64,
        }
    }

    /// Bounding box.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        match *self {
            Self::Triangle([a, b, c]) => (a.min(b).min(c), a.max(b).max(c)),
            Self::Quad { corner, e1, e2 } => {
                let ends = [corner + e1, corner + e2, corner + e1 + e2];
                let low = ends.iter().fold(corner, |low, p| low.min(*p));
                (low, ends.iter().fold(corner, |high, p| high.max(*p)))
            }
            Self::Sphere { centre, radius } => (centre - radius, centre + radius),
            Self::Disk { centre, normal, radius } => {
                let extent = (Vec3::ONE - normal * normal).max(Vec3::ZERO);
                let extent = Vec3::new(extent.x.sqrt(), extent.y.sqrt(), extent.z.sqrt()) * radius;
                (centre - extent, centre + extent)
            }
        }
    }

    /// Area-weighted centroid, at which the light is placed when it is treated as one point.
    pub fn centroid(&self) -> Vec3 {
        match *self {
            Self::Triangle([a, b, c]) => ((a.as_dvec3() + b.as_dvec3() + c.as_dvec3()) / 3.0).as_vec3(),
            Self::Quad { corner, e1, e2 } => {
                (corner.as_dvec3() + (e1.as_dvec3() + e2.as_dvec3()) * 0.5).as_vec3()
            }
            Self::Sphere { centre, .. } | Self::Disk { centre, .. } => centre,
        }
    }
}

fn cross_length(e1: Vec3, e2: Vec3) -> f64 {
    e1.as_dvec3().cross(e2.as_dvec3()).length()
}

/// A shape with everything that depends on it alone.
pub(crate) enum Prepared {
    Triangle(Triangle<f32>),
    Rectangle(Rectangle<f32>),
    /// A parallelogram that is not a rectangle.
    Skewed {
        corner: Vec3,
        e1: Vec3,
        e2: Vec3,
    },
    Sphere(Sphere<f32>),
    Disk(Disk<f32>),
}

impl Prepared {
    #[inline(always)]
    pub fn of(area: &Area) -> Self {
        let two_sided = area.two_sided;
        match area.shape {
            AreaShape::Triangle([a, b, c]) => {
                Self::Triangle(Triangle(flat::flat(a, b - a, c - a, two_sided)))
            }
            AreaShape::Quad { corner, e1, e2 } if rectangle::is_rectangle(e1.as_dvec3(), e2.as_dvec3()) => {
                Self::Rectangle(Rectangle(flat::flat(corner, e1, e2, two_sided)))
            }
            AreaShape::Quad { corner, e1, e2 } => Self::Skewed { corner, e1, e2 },
            AreaShape::Sphere { centre, radius } => {
                Self::Sphere(Sphere { centre: centre.into(), radius, two_sided })
            }
            AreaShape::Disk { centre, normal, radius } => {
                Self::Disk(disk::disk(centre, normal, radius, two_sided))
            }
        }
    }
}

impl Area {
    /// Samples a direction towards the light with `u` in \[0,1)². None from behind a one-sided light and from the plane
    /// of a flat one.
    pub fn sample(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let (from, at) = (p.into(), u.into());
        let aimed = match Prepared::of(self) {
            Prepared::Triangle(light) => light.sample(from, at).triangle(),
            Prepared::Rectangle(light) => light.sample(from, at).quad(),
            Prepared::Skewed { corner, e1, e2 } => Facet::quad(p, corner, e1, e2).sample(u, self.two_sided),
            Prepared::Sphere(light) => light.sample(from, at).round(),
            Prepared::Disk(light) => light.sample(from, at).round(),
        };
        self.sample_at(aimed?)
    }

    /// Solid-angle density at `p` of a direction that hits the light at `distance`; 0 from behind and from its plane.
    /// Where the light is sampled by solid angle this is 1/Ω, else distance²/(area·cosθ_light), with the cosine taken
    /// from the distance of the plane: area·cosθ·distance is the same for every point of a flat light.
    pub fn pdf(&self, p: Vec3, distance: f32) -> f32 {
        match Prepared::of(self) {
            Prepared::Triangle(light) => light.pdf(p.into(), distance),
            Prepared::Rectangle(light) => light.pdf(p.into(), distance),
            Prepared::Skewed { corner, e1, e2 } => {
                let pdf = Facet::quad(p, corner, e1, e2).pdf(distance, self.two_sided);
                (pdf as f32).min(f32::MAX)
            }
            Prepared::Sphere(light) => light.pdf(p.into()),
            Prepared::Disk(light) => light.pdf(p.into(), distance),
        }
    }

    /// Samples the surface uniformly in area with `u` in \[0,1)²: corner + u.x·e1 + u.y·e2 for a quad. None if the
    /// point does not emit towards `p`.
    pub(crate) fn sample_surface(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let (from, at) = (p.into(), u.into());
        let aimed = match Prepared::of(self) {
            Prepared::Triangle(light) => light.sample_surface(from, at).triangle(),
            Prepared::Rectangle(light) => light.sample_surface(from, at).quad(),
            Prepared::Skewed { corner, e1, e2 } => {
                Facet::quad(p, corner, e1, e2).sample_surface(u, self.two_sided)
            }
            Prepared::Sphere(light) => {
                sphere::sample_surface(p, light.centre.into(), light.radius, light.two_sided, u)
            }
            Prepared::Disk(light) => light.sample(from, at).round(),
        };
        self.sample_at(aimed?)
    }

    pub(crate) fn pdf_surface(&self, p: Vec3, wi: Vec3, distance: f32) -> f32 {
        match Prepared::of(self) {
            Prepared::Triangle(light) => light.pdf_surface(p.into(), distance),
            Prepared::Rectangle(light) => light.pdf_surface(p.into(), distance),
            Prepared::Skewed { corner, e1, e2 } => {
                let pdf = Facet::quad(p, corner, e1, e2).pdf_surface(distance, self.two_sided);
                (pdf as f32).min(f32::MAX)
            }
            Prepared::Sphere(light) => {
                let centre = light.centre.into();
                let pdf = sphere::pdf_surface(p, centre, light.radius, light.two_sided, wi, distance);
                (pdf as f32).min(f32::MAX)
            }
            Prepared::Disk(light) => light.pdf(p.into(), distance),
        }
    }

    /// The whole light as one point. Flat lights keep their cosine; a sphere becomes a point light of intensity πR²L.
    pub(crate) fn sample_centroid(&self, p: Vec3) -> Option<LightSample> {
        let aimed = match self.shape {
            AreaShape::Triangle([a, b, c]) => {
                Facet::triangle(p, a, b, c).middle(self.two_sided, Vec2::splat(1.0 / 3.0))
            }
            AreaShape::Quad { corner, e1, e2 } => {
                Facet::quad(p, corner, e1, e2).middle(self.two_sided, Vec2::splat(0.5))
            }
            // The warp maps (½, ½) to the centre.
            AreaShape::Disk { centre, normal, radius } => {
                let disk = disk::disk(centre, normal, radius, self.two_sided);
                disk.sample(p.into(), Vec2::splat(0.5).into()).round()
            }
            AreaShape::Sphere { centre, radius } => return self.sample_middle_of_sphere(p, centre, radius),
        };
        self.as_point(aimed?)
    }

    /// A sphere as one point. The shadow ray ends where it enters the sphere, so that the sphere does not occlude
    /// itself.
    fn sample_middle_of_sphere(&self, p: Vec3, centre: Vec3, radius: f32) -> Option<LightSample> {
        let to = centre.as_dvec3() - p.as_dvec3();
        let d = to.length();
        let r = radius as f64;
        if d == 0.0 {
            return None;
        }
        let wi = (to / d).as_vec3();
        let p_error = (centre.abs() + Vec3::splat(radius)) * (4.0 * f32::EPSILON);
        let near = LightPoint { p: centre - wi * radius, p_error, n: -wi, triangle: 0, u: 0.0, v: 0.0 };
        Some(LightSample {
            wi,
            pdf: 1.0,
            delta: true,
            radiance: self.radiance * (PI * (r / d) * (r / d)) as f32,
            distance: d as f32,
            point: (d > r).then_some(near),
        })
    }

    pub(crate) fn sample_at(&self, aimed: Aimed) -> Option<LightSample> {
        let Aimed { wi, distance, pdf, point } = aimed;
        let usable = pdf > 0.0 && pdf.is_finite();
        usable.then_some(LightSample {
            wi,
            pdf,
            delta: false,
            radiance: self.radiance,
            distance,
            point: Some(point),
        })
    }

    /// Light sample with the power of a whole flat light at one point.
    pub(crate) fn as_point(&self, aimed: Aimed) -> Option<LightSample> {
        let sample = self.sample_at(aimed)?;
        Some(LightSample { radiance: sample.radiance / sample.pdf, pdf: 1.0, delta: true, ..sample })
    }

    /// Power in W per channel: π·area·radiance, twice that for two-sided lights.
    pub fn power(&self) -> Vec3 {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        self.radiance * (PI * sides * self.shape.area()) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_and_middles() {
        let triangle = AreaShape::Triangle([Vec3::ZERO, Vec3::X * 2.0, Vec3::Y]);
        let quad = AreaShape::Quad { corner: Vec3::ONE, e1: Vec3::X * 2.0, e2: Vec3::new(5.0, 3.0, 0.0) };
        assert_eq!((triangle.area(), quad.area()), (1.0, 6.0));
        assert_eq!(quad.centroid(), Vec3::new(4.5, 2.5, 1.0));
        let light = Area { shape: triangle, radiance: Vec3::ONE, two_sided: true };
        assert!((light.power().x as f64 - 2.0 * PI).abs() < 1e-6);
    }
}
