//! One light of any kind: sample towards it, density of a direction that reaches it.
use crate::{Aiming, Area, Distant, Environment, Moving, Patterned, Point, Spot};
use dapple_math::Ray;
use dapple_math::offset::{UNIT_ROUNDOFF, offset_origin};
use glam::{DVec3, Vec2, Vec3};

/// One light.
#[derive(Clone, Debug)]
pub enum Light {
    /// All directions from one point.
    Point(Point),
    /// A cone from one point.
    Spot(Spot),
    /// One direction.
    Distant(Distant),
    /// An emitting surface.
    Area(Area),
    /// An emitting triangle whose texture varies.
    Patterned(Box<Patterned>),
    /// Everything around the scene.
    Environment(Environment),
    /// Any of the others but the environment, on the way somewhere.
    Moving(Box<Moving>),
}

/// A place on an area light.
#[derive(Clone, Copy, Debug)]
pub struct LightPoint {
    /// Position.
    pub p: Vec3,
    /// Bound of |computed − exact| per axis.
    pub p_error: Vec3,
    /// Unit geometric normal of the front side.
    pub n: Vec3,
    /// Which triangle of the shape (see [`crate::AreaShape`]) and its barycentrics, for textured emission.
    pub triangle: u32,
    /// Barycentric of the triangle's corner 1.
    pub u: f32,
    /// Barycentric of the triangle's corner 2.
    pub v: f32,
}

/// One direction towards a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction towards the light.
    pub wi: Vec3,
    /// Solid-angle density at the receiver; 1 for delta lights.
    pub pdf: f32,
    /// Whether no other technique can find this light.
    pub delta: bool,
    /// Radiance along −wi (area: the light's mean; delta: intensity/d², i.e. irradiance on a facing surface).
    pub radiance: Vec3,
    /// Distance to the light; infinite for distant and environment.
    pub distance: f32,
    /// Only for area lights.
    pub point: Option<LightPoint>,
}

/// Where shadow rays end. From origin to target a direction is rounded by half an ulp per axis, so that its end lies up to
/// |n|·|d|·2⁻²⁴ before or behind the target, measured along the light's normal; by that, the light would shadow its own
/// samples where its coordinates, and with them its error box, are small against the distance. Covers it for all but the
/// last 4° to the light's plane.
const END: f32 = 1.0 - 16.0 * UNIT_ROUNDOFF;

impl LightSample {
    /// The shadow ray from `o`, an origin outside its surface's error box, to outside the light's error box. Its direction
    /// has the length of the way (of area lights), so that the light is at t = 1.
    #[inline(always)]
    pub fn shadow_ray(&self, o: Vec3) -> Ray {
        match &self.point {
            Some(point) => {
                let target = offset_origin(point.p, point.p_error, point.n, -self.wi);
                Ray { o, d: target - o, t_max: END }
            }
            None if self.distance.is_finite() => Ray { o, d: self.wi, t_max: self.distance },
            None => Ray::new(o, self.wi),
        }
    }
}

impl Light {
    /// A direction from `p` towards the light for `u` in \[0,1)², `time` seconds after the shutter opened.
    /// None when the light cannot reach `p` (behind a one-sided emitter, in its plane, density 0).
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

    /// Solid-angle density at `p` with which `sample` gives the direction `wi` (unit) that was seen to reach this light
    /// at distance `distance` with geometric normal `n` there, at the same `time`. 0 for delta lights.
    ///
    /// Area lights know their own shape: their density follows from `p` and `distance`, and `n` is not looked at.
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

    /// Total power in W per channel (distant and environment: through a disk of the scene's radius).
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

    /// Where a light without extent is at a time; None for the others.
    pub fn position(&self, time: f32) -> Option<Vec3> {
        match self {
            Self::Point(light) => Some(light.p),
            Self::Spot(light) => Some(light.p),
            Self::Moving(light) if light.is_delta() => light.at(time)?.position(time),
            _ => None,
        }
    }

    /// Box that a light without extent stays in while the shutter is open, flat if it stands still; None for the others.
    pub fn positions(&self) -> Option<(DVec3, DVec3)> {
        match self {
            Self::Moving(light) => self.position(0.0).map(|_| light.swept()),
            _ => self.position(0.0).map(|p| (p.as_dvec3(), p.as_dvec3())),
        }
    }

    /// Bytes held, the environment's own table left out.
    pub fn memory_bytes(&self) -> usize {
        let beside = match self {
            Self::Patterned(light) => size_of::<Patterned>() + light.pattern.memory_bytes(),
            Self::Moving(light) => light.memory_bytes(),
            _ => 0,
        };
        size_of::<Self>() + beside
    }

    /// Whether it sends nothing.
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

    /// Whether only `sample` can find this light, never a ray.
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Point(_) | Self::Spot(_) | Self::Distant(_) => true,
            Self::Area(_) | Self::Patterned(_) | Self::Environment(_) => false,
            Self::Moving(light) => light.is_delta(),
        }
    }
}
