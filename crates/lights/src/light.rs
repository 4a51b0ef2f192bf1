//! The light types: sampling a direction towards a light, and the density of a direction that hits it.
use crate::{Aiming, Area, Distant, Environment, LightSample, Moving, Patterned, Point, Reached, Spot};
use glam::{DVec3, Vec2, Vec3};

/// A light of any type.
#[derive(Clone, Debug)]
pub enum Light {
    /// A point light.
    Point(Point),
    /// A spot light.
    Spot(Spot),
    /// A distant light.
    Distant(Distant),
    /// An emitting surface.
    Area(Area),
    /// An emitting triangle with textured emission.
    Patterned(Box<Patterned>),
    /// The environment of the scene.
    Environment(Environment),
    /// Any of the other types but the environment, in motion.
    Moving(Box<Moving>),
}

impl Light {
    /// Samples a direction from `p` towards the light with `u` in \[0,1)², `time` seconds after the shutter opened.
    /// None if the light cannot reach `p` (behind a one-sided emitter, in its plane, density 0).
    #[inline]
    pub fn sample(&self, p: Vec3, u: Vec2, time: f32) -> Option<LightSample> {
        match self {
            Self::Point(light) => light.sample(p),
            Self::Spot(light) => light.sample(p),
            Self::Distant(light) => Some(light.sample()),
            Self::Area(light) => light.sample(p, u),
            Self::Environment(light) => light.sample(u),
            Self::Patterned(light) => light.sample_as(Aiming::SolidAngle, p, u),
            Self::Moving(light) => light.sample_as(Aiming::SolidAngle, p, u, time),
        }
    }

    /// Solid-angle density at `p` with which `sample` returns the unit direction `wi`, which is known to hit this light
    /// at `distance` with geometric normal `n`, at the same `time`. 0 for delta lights.
    ///
    /// The density of area lights follows from their shape, `p` and `distance`; they ignore `n`.
    #[inline]
    pub fn pdf(&self, p: Vec3, wi: Vec3, distance: f32, n: Vec3, time: f32) -> f32 {
        match self {
            Self::Point(_) | Self::Spot(_) | Self::Distant(_) => 0.0,
            Self::Area(light) => light.pdf(p, distance),
            Self::Environment(light) => light.pdf(wi),
            Self::Patterned(light) => light.pdf(Aiming::SolidAngle, p, wi, distance),
            Self::Moving(light) => light.pdf_as(Aiming::SolidAngle, p, wi, distance, n, time),
        }
    }

    /// As [`Light::sample`], with the points of area lights selected according to `aiming`. The sample of the centroid
    /// is a delta sample: its radiance is the irradiance on a surface that faces it.
    pub fn sample_as(&self, aiming: Aiming, p: Vec3, u: Vec2, time: f32) -> Option<LightSample> {
        match (self, aiming) {
            (Self::Area(area), Aiming::Surface) => area.sample_surface(p, u),
            (Self::Area(area), Aiming::Centroid) => area.sample_centroid(p),
            (Self::Patterned(light), _) => light.sample_as(aiming, p, u),
            (Self::Moving(light), _) => light.sample_as(aiming, p, u, time),
            _ => self.sample(p, u, time),
        }
    }

    /// Solid-angle density at `p` of [`Light::sample_as`] for a direction `wi` that hits the light at `distance`.
    pub fn pdf_as(&self, aiming: Aiming, p: Vec3, wi: Vec3, distance: f32, n: Vec3, time: f32) -> f32 {
        match (self, aiming) {
            (Self::Area(area), Aiming::Surface) => area.pdf_surface(p, wi, distance),
            (Self::Area(_), Aiming::Centroid) => 0.0,
            (Self::Patterned(light), _) => light.pdf(aiming, p, wi, distance),
            (Self::Moving(light), _) => light.pdf_as(aiming, p, wi, distance, n, time),
            _ => self.pdf(p, wi, distance, n, time),
        }
    }

    /// As [`Light::pdf_as`] if the hit point on the surface is known: `at`, its barycentric coordinates.
    pub fn pdf_at(&self, aiming: Aiming, p: Vec3, reached: &Reached, time: f32) -> f32 {
        let &Reached { wi, distance, n, at } = reached;
        match self {
            Self::Patterned(light) => light.pdf_at(aiming, p, distance, at),
            Self::Moving(light) => light.pdf_at(aiming, p, reached, time),
            _ => self.pdf_as(aiming, p, wi, distance, n, time),
        }
    }

    /// Total power in W per channel (distant lights and the environment: through a disk of the radius of the scene).
    pub fn power(&self, scene_radius: f32) -> Vec3 {
        let disk = std::f32::consts::PI * scene_radius * scene_radius;
        match self {
            Self::Point(light) => light.power(),
            Self::Spot(light) => light.power(),
            Self::Distant(light) => light.irradiance * disk,
            Self::Area(light) => light.power(),
            Self::Patterned(light) => light.area.power(),
            Self::Environment(light) => light.mean() * (4.0 * std::f32::consts::PI * disk),
            Self::Moving(light) => light.power(scene_radius),
        }
    }

    /// Position at `time` of a light without extent; None for the others.
    pub fn position(&self, time: f32) -> Option<Vec3> {
        match self {
            Self::Point(light) => Some(light.p),
            Self::Spot(light) => Some(light.p),
            Self::Moving(light) if light.is_delta() => light.at(time)?.position(time),
            _ => None,
        }
    }

    /// Box that contains a light without extent while the shutter is open, a single point if the light does not move;
    /// None for the others.
    pub fn positions(&self) -> Option<(DVec3, DVec3)> {
        match self {
            Self::Moving(light) => self.position(0.0).map(|_| light.swept()),
            _ => self.position(0.0).map(|p| (p.as_dvec3(), p.as_dvec3())),
        }
    }

    /// Memory use in bytes, without the table of the environment.
    pub fn memory_bytes(&self) -> usize {
        let beside = match self {
            Self::Patterned(light) => size_of::<Patterned>() + light.pattern.memory_bytes(),
            Self::Moving(light) => light.memory_bytes(),
            _ => 0,
        };
        size_of::<Self>() + beside
    }

    /// Whether it emits nothing.
    pub fn is_dark(&self) -> bool {
        match self {
            Self::Point(light) => light.intensity == Vec3::ZERO,
            Self::Spot(light) => light.intensity == Vec3::ZERO,
            Self::Distant(light) => light.irradiance == Vec3::ZERO,
            Self::Area(light) => light.radiance == Vec3::ZERO,
            Self::Patterned(light) => light.area.radiance == Vec3::ZERO,
            Self::Environment(light) => light.mean() == Vec3::ZERO,
            Self::Moving(light) => light.is_dark(),
        }
    }

    /// Whether this is an emitting surface.
    pub fn is_area(&self) -> bool {
        match self {
            Self::Area(_) | Self::Patterned(_) => true,
            Self::Moving(light) => !light.is_delta(),
            _ => false,
        }
    }

    /// Whether only `sample` can find this light, and no ray can hit it.
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Point(_) | Self::Spot(_) | Self::Distant(_) => true,
            Self::Area(_) | Self::Patterned(_) | Self::Environment(_) => false,
            Self::Moving(light) => light.is_delta(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AreaShape;

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

    /// Σ over midpoints of radiance·cos/pdf is the irradiance for either distribution of the points.
    fn irradiance(light: &Light, aiming: Aiming, n: u32) -> f64 {
        let mut sum = 0.0;
        for i in 0..n * n {
            let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            if let Some(s) = light.sample_as(aiming, Vec3::ZERO, u, 0.0) {
                sum += f64::from(s.radiance.x * s.wi.z.max(0.0) / s.pdf);
                let again = light.pdf_as(aiming, Vec3::ZERO, s.wi, s.distance, s.point.unwrap().n, 0.0);
                // At grazing angles the rounding error of the cosine dominates the density.
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
