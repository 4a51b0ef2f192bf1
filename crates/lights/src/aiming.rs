//! Which points of an area light are aimed at: those that even out its solid angle, its surface, or its one middle.
use crate::area::Aimed;
use crate::polygon::Facet;
use crate::{Area, AreaShape, Light, LightPoint, LightSample, disk, sphere};
use glam::{Vec2, Vec3};
use std::f64::consts::PI;

/// How the points of area lights are chosen. Other lights do not care.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Aiming {
    /// Evenly in solid angle where that pays ([`Light::sample`]): the least noise.
    #[default]
    SolidAngle,
    /// Evenly over the surface: equal u is the same point from everywhere, so that a fixed set of u makes the light a
    /// set of point lights [Cook 1984].
    Surface,
    /// All of the light's power from its centroid, as a point light: no soft shadow. Never met by a ray.
    Centroid,
}

/// Where a ray reached a light.
#[derive(Clone, Copy, Debug)]
pub struct Reached {
    /// Unit direction of the ray.
    pub wi: Vec3,
    /// How far it went; infinite for the environment.
    pub distance: f32,
    /// Geometric normal there.
    pub n: Vec3,
    /// Barycentrics of the hit, of corners 1 and 2 of the triangle; zero for anything else.
    pub at: Vec2,
}

impl Light {
    /// As [`Light::sample`], aimed as `aiming` says. The centroid's sample is delta: its radiance is the irradiance on a
    /// surface that faces it.
    pub fn sample_as(&self, aiming: Aiming, p: Vec3, u: Vec2, time: f32) -> Option<LightSample> {
        match (self, aiming) {
            (Self::Area(area), Aiming::Surface) => area.sample_surface(p, u),
            (Self::Area(area), Aiming::Centroid) => area.sample_centroid(p),
            (Self::Patterned(light), _) => light.sample_as(aiming, p, u),
            (Self::Moving(light), _) => light.sample_as(aiming, p, u, time),
            _ => self.sample(p, u, time),
        }
    }

    /// Solid-angle density at `p` of [`Light::sample_as`] for a direction `wi` that reaches the light at `distance`.
    pub fn pdf_as(&self, aiming: Aiming, p: Vec3, wi: Vec3, distance: f32, n: Vec3, time: f32) -> f32 {
        match (self, aiming) {
            (Self::Area(area), Aiming::Surface) => area.pdf_surface(p, wi, distance),
            (Self::Area(_), Aiming::Centroid) => 0.0,
            (Self::Patterned(light), _) => light.pdf(aiming, p, wi, distance),
            (Self::Moving(light), _) => light.pdf_as(aiming, p, wi, distance, n, time),
            _ => self.pdf(p, wi, distance, n, time),
        }
    }

    /// As [`Light::pdf_as`] where it is known which place of the surface is reached: `at`, the barycentrics of the hit.
    pub fn pdf_at(&self, aiming: Aiming, p: Vec3, reached: &Reached, time: f32) -> f32 {
        let &Reached { wi, distance, n, at } = reached;
        match self {
            Self::Patterned(light) => light.pdf_at(aiming, p, distance, at),
            Self::Moving(light) => light.pdf_at(aiming, p, reached, time),
            _ => self.pdf_as(aiming, p, wi, distance, n, time),
        }
    }
}

impl Area {
    /// Towards the point of the surface at `u` in \[0,1)², even in area: corner + u.x·e1 + u.y·e2 for a quad. None when
    /// it does not shine towards `p`.
    fn sample_surface(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let two_sided = self.two_sided;
        let aimed = match self.shape {
            AreaShape::Triangle([a, b, c]) => Facet::triangle(p, a, b, c).sample_surface(u, two_sided),
            AreaShape::Quad { corner, e1, e2 } => Facet::quad(p, corner, e1, e2).sample_surface(u, two_sided),
            AreaShape::Sphere { centre, radius } => sphere::sample_surface(p, centre, radius, two_sided, u),
            AreaShape::Disk { centre, normal, radius } => {
                disk::sample(p, centre, normal, radius, two_sided, u)
            }
        };
        self.sample_at(aimed?)
    }

    fn pdf_surface(&self, p: Vec3, wi: Vec3, distance: f32) -> f32 {
        let two_sided = self.two_sided;
        let pdf = match self.shape {
            AreaShape::Triangle([a, b, c]) => Facet::triangle(p, a, b, c).pdf_surface(distance, two_sided),
            AreaShape::Quad { corner, e1, e2 } => {
                Facet::quad(p, corner, e1, e2).pdf_surface(distance, two_sided)
            }
            AreaShape::Sphere { centre, radius } => {
                sphere::pdf_surface(p, centre, radius, two_sided, wi, distance)
            }
            AreaShape::Disk { centre, normal, radius } => {
                disk::pdf(p, centre, normal, radius, two_sided, distance)
            }
        };
        (pdf as f32).min(f32::MAX)
    }

    /// The whole light as one point. Flat lights keep their cosine; a sphere becomes a point light of intensity πR²L.
    fn sample_centroid(&self, p: Vec3) -> Option<LightSample> {
        let aimed = match self.shape {
            AreaShape::Triangle([a, b, c]) => {
                Facet::triangle(p, a, b, c).middle(self.two_sided, Vec2::splat(1.0 / 3.0))
            }
            AreaShape::Quad { corner, e1, e2 } => {
                Facet::quad(p, corner, e1, e2).middle(self.two_sided, Vec2::splat(0.5))
            }
            // The warp takes (½, ½) to the centre.
            AreaShape::Disk { centre, normal, radius } => {
                disk::sample(p, centre, normal, radius, self.two_sided, Vec2::splat(0.5))
            }
            AreaShape::Sphere { centre, radius } => return self.sample_middle_of_sphere(p, centre, radius),
        };
        self.as_point(aimed?)
    }

    /// The shadow ray ends where it enters the sphere: its own surface does not block.
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
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shapes() -> [AreaShape; 4] {
        [
            AreaShape::Triangle([
                Vec3::new(-1.0, -1.0, 2.0),
                Vec3::new(0.0, 1.5, 2.0),
                Vec3::new(1.0, -1.0, 2.5),
            ]),
            AreaShape::Quad {
                corner: Vec3::new(-1.0, -1.0, 2.0),
                e1: Vec3::Y * 2.0,
                e2: Vec3::new(2.0, 0.0, 0.3),
            },
            AreaShape::Sphere { centre: Vec3::new(0.2, 0.1, 2.0), radius: 0.7 },
            AreaShape::Disk { centre: Vec3::new(0.2, 0.1, 2.0), normal: Vec3::NEG_Z, radius: 0.7 },
        ]
    }

    /// Σ over midpoints of radiance·cos/pdf is the irradiance, whichever way the points are spread.
    fn irradiance(light: &Light, aiming: Aiming, n: u32) -> f64 {
        let mut sum = 0.0;
        for i in 0..n * n {
            let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            if let Some(s) = light.sample_as(aiming, Vec3::ZERO, u, 0.0) {
                sum += f64::from(s.radiance.x * s.wi.z.max(0.0) / s.pdf);
                let again = light.pdf_as(aiming, Vec3::ZERO, s.wi, s.distance, s.point.unwrap().n, 0.0);
                // At grazing angles the density runs off with the rounding of the cosine.
                let close = (again / s.pdf - 1.0).abs() < 1e-3 + 1e-6 * s.pdf;
                assert!(close, "{again} {}", s.pdf);
            }
        }
        sum / f64::from(n * n)
    }

    #[test]
    fn surface_and_solid_angle_agree() {
        for shape in shapes() {
            let light = Light::Area(Area { shape, radiance: Vec3::ONE, two_sided: false });
            let (a, b) =
                (irradiance(&light, Aiming::SolidAngle, 400), irradiance(&light, Aiming::Surface, 400));
            assert!((a / b - 1.0).abs() < 3e-4 && a > 0.1, "{shape:?}: {a} {b}");
        }
    }

    /// From far away a light is a point: its centroid with its full power.
    #[test]
    fn far_lights_are_their_centroid() {
        for shape in shapes() {
            let light = Light::Area(Area { shape, radiance: Vec3::ONE, two_sided: false });
            let p = Vec3::new(0.0, 0.0, -3000.0);
            let point = light.sample_as(Aiming::Centroid, p, Vec2::ZERO, 0.0).unwrap();
            assert!(point.delta && light.pdf_as(Aiming::Centroid, p, point.wi, 1.0, Vec3::Z, 0.0) == 0.0);
            let n = 64;
            let mean: f32 = (0..n * n)
                .filter_map(|i| {
                    let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                    light.sample_as(Aiming::Surface, p, u, 0.0).map(|s| 1.0 / s.pdf)
                })
                .sum::<f32>()
                / (n * n) as f32;
            assert!((point.radiance.x / mean - 1.0).abs() < 2e-3, "{shape:?} {} {mean}", point.radiance.x);
        }
    }

    #[test]
    fn a_grid_is_the_same_points_from_everywhere() {
        for shape in shapes() {
            let light = Light::Area(Area { shape, radiance: Vec3::ONE, two_sided: true });
            let place = |p: Vec3| {
                light.sample_as(Aiming::Surface, p, Vec2::new(0.125, 0.375), 0.0).unwrap().point.unwrap().p
            };
            assert!((place(Vec3::ZERO) - place(Vec3::new(0.5, -0.3, 0.2))).length() < 1e-6);
        }
    }

    #[test]
    fn inside_a_sphere_its_middle_is_seen_unobstructed() {
        let shape = AreaShape::Sphere { centre: Vec3::ZERO, radius: 2.0 };
        let light = Light::Area(Area { shape, radiance: Vec3::ONE, two_sided: true });
        let s = light.sample_as(Aiming::Centroid, Vec3::X, Vec2::ZERO, 0.0).unwrap();
        assert!(s.point.is_none() && s.distance == 1.0);
        assert!(light.sample_as(Aiming::Centroid, Vec3::ZERO, Vec2::ZERO, 0.0).is_none());
    }
}
