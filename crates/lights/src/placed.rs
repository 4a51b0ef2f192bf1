//! Moving lights at one time: the light is transformed to render space and sampled there as a light at rest.
//!
//! Sampling and density use the pose of the light at the same given time, so that they agree on its shape.
use crate::cluster::{Bounds, Cone};
use crate::moving::LocalLight;
use crate::oval::Oval;
use crate::{
    Aiming, Area, AreaShape, Distant, Light, LightPoint, LightSample, Moving, Patterned, Point, Reached, Spot,
};
use dapple_math::motion::Pose;
use dapple_math::offset::gamma;
use glam::{Vec2, Vec2Swizzles, Vec3};

impl Moving {
    /// The light in its pose at `time`. None if its transform is degenerate at that time, and for ellipsoids and
    /// ellipses.
    pub fn at(&self, time: f32) -> Option<Light> {
        self.posed(time).map(|(light, _)| light)
    }

    fn posed(&self, time: f32) -> Option<(Light, Option<Pose>)> {
        let time = f64::from(time);
        let placed = || self.motion.at(time);
        let point = |p: Vec3| placed().transform_point3(p.as_dvec3()).as_vec3();
        let direction = |d: Vec3| {
            let d = placed().transform_vector3(d.as_dvec3()).try_normalize()?;
            Some(d.as_vec3()).filter(|d| d.is_finite())
        };
        match &self.light {
            LocalLight::Point(l) => Some((Light::Point(Point { p: point(l.p), ..*l }), None)),
            LocalLight::Spot(l) => {
                let spot = Spot { p: point(l.p), axis: direction(l.axis)?, ..*l };
                Some((Light::Spot(spot), None))
            }
            LocalLight::Distant(l) => {
                Some((Light::Distant(Distant { towards: direction(l.towards)?, ..*l }), None))
            }
            LocalLight::Area(l) => {
                let pose = self.motion.pose_at(time)?;
                let shape = l.shape.posed(&pose);
                Some((Light::Area(Area { shape, ..*l }), Some(pose)))
            }
            LocalLight::Patterned(l, patterns) => {
                let pose = self.motion.pose_at(time)?;
                let area = Area { shape: l.shape.posed(&pose), ..*l };
                let pattern = patterns[usize::from(pose.is_mirrored())].clone();
                Some((Light::Patterned(Box::new(Patterned { area, pattern })), Some(pose)))
            }
            LocalLight::Oval(_) => None,
        }
    }

    /// As [`Light::sample_as`].
    pub(crate) fn sample_as(&self, aiming: Aiming, p: Vec3, u: Vec2, time: f32) -> Option<LightSample> {
        if let LocalLight::Oval(area) = &self.light {
            let pose = self.motion.pose_at(time.into())?;
            let mut sample = Oval { area, pose: &pose }.sample_as(aiming, p, u)?;
            sample.point = sample.point.map(|point| surface_point(&point, &pose, p));
            return Some(sample);
        }
        let (light, pose) = self.posed(time)?;
        let mut sample = light.sample_as(aiming, p, u, time)?;
        if let (Some(point), Some(pose)) = (&mut sample.point, pose) {
            *point = surface_point(point, &pose, p);
        }
        Some(sample)
    }

    /// As [`Light::pdf_as`].
    pub(crate) fn pdf_as(&self, aiming: Aiming, p: Vec3, wi: Vec3, distance: f32, n: Vec3, time: f32) -> f32 {
        if let LocalLight::Oval(area) = &self.light {
            let pose = self.motion.pose_at(time.into());
            return pose.map_or(0.0, |pose| Oval { area, pose: &pose }.pdf_as(aiming, p, wi, distance));
        }
        self.at(time).map_or(0.0, |light| light.pdf_as(aiming, p, wi, distance, n, time))
    }

    /// As [`Light::pdf_at`].
    pub(crate) fn pdf_at(&self, aiming: Aiming, p: Vec3, reached: &Reached, time: f32) -> f32 {
        match self.posed(time) {
            Some((Light::Patterned(light), Some(pose))) => {
                let at = if pose.is_mirrored() { reached.at.yx() } else { reached.at };
                light.pdf_at(aiming, p, reached.distance, at)
            }
            Some((light, _)) => light.pdf_as(aiming, p, reached.wi, reached.distance, reached.n, time),
            None => self.pdf_as(aiming, p, reached.wi, reached.distance, reached.n, time),
        }
    }

    /// As [`Light::power`], at the time when the shutter opens.
    pub(crate) fn power(&self, scene_radius: f32) -> Vec3 {
        if let LocalLight::Oval(area) = &self.light {
            let surface = self.motion.pose_at(0.0).map_or(0.0, |pose| Oval { area, pose: &pose }.surface());
            let sides = if area.two_sided { 2.0 } else { 1.0 };
            return area.radiance * (std::f64::consts::PI * sides * surface) as f32;
        }
        self.at(0.0).map_or(Vec3::ZERO, |light| light.power(scene_radius))
    }

    fn bounds_at(&self, time: f32) -> Option<Bounds> {
        let LocalLight::Oval(area) = &self.light else { return Bounds::of(&self.at(time)?) };
        let pose = self.motion.pose_at(time.into())?;
        Bounds::of_oval(area, &Oval { area, pose: &pose })
    }

    /// Bounds that hold at every time: the box is swept, and the cone is kept only if no direction changes.
    /// *Approximation*: the intensity is the maximum of a few times; this affects the probabilities of selection, not
    /// the expected result.
    pub(crate) fn cluster(&self) -> Option<Bounds> {
        const TIMES: u32 = 8;
        let times = (0..=TIMES).map(|i| self.seconds * (i as f32 / TIMES as f32));
        let greatest = times
            .filter_map(|time| self.bounds_at(time))
            .reduce(|a, b| if b.intensity > a.intensity { b } else { a })?;
        let keeps = self.motion.keeps_directions_within(0.0, f64::from(self.seconds));
        let (low, high) = self.bounds;
        Some(Bounds {
            low: low.as_vec3(),
            high: high.as_vec3(),
            cone: if keeps { greatest.cone } else { Cone::ALL },
            intensity: greatest.intensity,
        })
    }
}

impl AreaShape {
    /// The shape in render space with its front preserved: a reflection exchanges two corners of a triangle, and the
    /// edges of a quad.
    fn posed(&self, pose: &Pose) -> Self {
        let point = |p: Vec3| pose.to_world.transform_point3(p.as_dvec3()).as_vec3();
        let vector = |v: Vec3| pose.to_world.transform_vector3(v.as_dvec3()).as_vec3();
        let m = &pose.to_world.matrix3;
        let size = (m.x_axis.length() + m.y_axis.length() + m.z_axis.length()) / 3.0;
        let scaled = |radius: f32| (f64::from(radius) * size) as f32;
        match *self {
            Self::Triangle([a, b, c]) if pose.is_mirrored() => Self::Triangle([a, c, b].map(point)),
            Self::Triangle(corners) => Self::Triangle(corners.map(point)),
            Self::Quad { corner, e1, e2 } => {
                let (e1, e2) = if pose.is_mirrored() { (e2, e1) } else { (e1, e2) };
                Self::Quad { corner: point(corner), e1: vector(e1), e2: vector(e2) }
            }
            Self::Sphere { centre, radius } => Self::Sphere { centre: point(centre), radius: scaled(radius) },
            Self::Disk { centre, normal, radius } => {
                let normal = pose.normals().apply(normal.as_dvec3()).as_vec3();
                Self::Disk { centre: point(centre), normal, radius: scaled(radius) }
            }
        }
    }
}

/// A sampled point in terms of the surface in motion: barycentric coordinates in the order of its own corners, and an
/// error bound that also covers the rounding of rays from `from`, which is done in the local space of the surface.
fn surface_point(point: &LightPoint, pose: &Pose, from: Vec3) -> LightPoint {
    let local = |p: Vec3| pose.to_object.transform_point3(p.as_dvec3()).abs();
    let seen = pose.error((local(from) + local(point.p)) * f64::from(gamma(4)));
    let rounding = (pose.to_world.translation.abs() + point.p.abs().as_dvec3()) * f64::from(gamma(4));
    let (u, v) = if pose.is_mirrored() { (point.v, point.u) } else { (point.u, point.v) };
    LightPoint { p_error: point.p_error + (seen + rounding).as_vec3(), u, v, ..*point }
}
