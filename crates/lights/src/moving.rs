//! Where is a light that moves? Its shape in its own space, and the motion that takes it to render space at a time.
//!
//! Sampling and density put the light where it is at the time they are asked about, so both speak of the same shape.
use crate::cluster::Bounds;
use crate::oval::Oval;
use crate::{
    Aiming, Area, AreaShape, Distant, Light, LightPoint, LightSample, Pattern, Patterned, Point, Reached,
    Spot,
};
use dapple_math::Motion;
use dapple_math::motion::Pose;
use dapple_math::offset::gamma;
use glam::{DVec3, Vec2, Vec2Swizzles, Vec3};
use std::sync::Arc;

/// Motions that [`Motion::bounds`] cuts into more steps than this are bounded for a whole object at once.
const MANY_STEPS: usize = 64;

/// A light that changes its place while the shutter is open, for `seconds` from time 0 on.
#[derive(Clone, Debug)]
pub struct Moving {
    light: Still,
    motion: Arc<Motion>,
    seconds: f32,
    /// Box over the shutter.
    bounds: (DVec3, DVec3),
}

/// A light in its own space.
#[derive(Clone, Debug)]
enum Still {
    /// Strength and range in render units.
    Point(Point),
    Spot(Spot),
    Distant(Distant),
    Area(Area),
    /// With its pattern, and that of its mirror image.
    Patterned(Area, [Arc<Pattern>; 2]),
    /// A sphere or disk that does not stay round.
    Oval(Area),
}

impl Moving {
    /// A point light; its intensity and range are in render units already.
    pub fn point(light: Point, motion: Arc<Motion>, seconds: f32) -> Self {
        Self::new(Still::Point(light), motion, seconds, None)
    }

    /// A spot light; intensity and range in render units, place and axis in its own space.
    pub fn spot(light: Spot, motion: Arc<Motion>, seconds: f32) -> Self {
        Self::new(Still::Spot(light), motion, seconds, None)
    }

    /// A distant light whose direction turns.
    pub fn distant(light: Distant, motion: Arc<Motion>, seconds: f32) -> Self {
        Self::new(Still::Distant(light), motion, seconds, None)
    }

    /// An emitting surface in its own space; spheres and disks must stay round (see [`Motion`]). `whole` is a box that
    /// the object it belongs to stays in while the shutter is open; it stands for the light's own box where that would
    /// take long to work out.
    pub fn area(light: Area, motion: Arc<Motion>, seconds: f32, whole: Option<(DVec3, DVec3)>) -> Self {
        let whole = whole.filter(|_| motion.step_count(0.0, f64::from(seconds)) > MANY_STEPS);
        Self::new(Still::Area(light), motion, seconds, whole)
    }

    /// As [`Moving::area`], a triangle whose emission varies as `pattern` says.
    #[must_use]
    pub fn patterned(mut self, pattern: Arc<Pattern>) -> Self {
        if let Still::Area(area) = &self.light {
            let mirrored = Arc::new(pattern.mirrored());
            self.light = Still::Patterned(area.clone(), [pattern, mirrored]);
        }
        self
    }

    /// As [`Moving::area`], a sphere or disk that need not stay round.
    #[must_use]
    pub fn oval(mut self) -> Self {
        if let Still::Area(area) = &self.light {
            self.light = Still::Oval(area.clone());
        }
        self
    }

    /// The emitting surface in its own space; None for a light without surface.
    pub fn surface(&self) -> Option<&Area> {
        match &self.light {
            Still::Area(area) | Still::Patterned(area, _) | Still::Oval(area) => Some(area),
            _ => None,
        }
    }

    fn new(light: Still, motion: Arc<Motion>, seconds: f32, whole: Option<(DVec3, DVec3)>) -> Self {
        let (low, high) = match &light {
            Still::Point(l) => (l.p, l.p),
            Still::Spot(l) => (l.p, l.p),
            Still::Distant(_) => (Vec3::ZERO, Vec3::ZERO),
            Still::Area(l) | Still::Patterned(l, _) | Still::Oval(l) => l.shape.bounds(),
        };
        let swept = || motion.bounds(low.as_dvec3(), high.as_dvec3(), 0.0, f64::from(seconds));
        let bounds = whole.unwrap_or_else(swept);
        Self { light, motion, seconds, bounds }
    }

    /// The light where it is at `time`; None when its transform leaves nothing of it then, and for what is not round.
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
            Still::Point(l) => Some((Light::Point(Point { p: point(l.p), ..*l }), None)),
            Still::Spot(l) => {
                let spot = Spot { p: point(l.p), axis: direction(l.axis)?, ..*l };
                Some((Light::Spot(spot), None))
            }
            Still::Distant(l) => {
                Some((Light::Distant(Distant { towards: direction(l.towards)?, ..*l }), None))
            }
            Still::Area(l) => {
                let pose = self.motion.pose_at(time)?;
                let shape = l.shape.posed(&pose);
                Some((Light::Area(Area { shape, ..*l }), Some(pose)))
            }
            Still::Patterned(l, patterns) => {
                let pose = self.motion.pose_at(time)?;
                let area = Area { shape: l.shape.posed(&pose), ..*l };
                let pattern = patterns[usize::from(pose.is_mirrored())].clone();
                Some((Light::Patterned(Box::new(Patterned { area, pattern })), Some(pose)))
            }
            Still::Oval(_) => None,
        }
    }

    /// As [`Light::sample_as`].
    pub(crate) fn sample_as(&self, aiming: Aiming, p: Vec3, u: Vec2, time: f32) -> Option<LightSample> {
        if let Still::Oval(area) = &self.light {
            let pose = self.motion.pose_at(time.into())?;
            let mut sample = Oval { area, pose: &pose }.sample_as(aiming, p, u)?;
            sample.point = sample.point.map(|point| own(&point, &pose, p));
            return Some(sample);
        }
        let (light, pose) = self.posed(time)?;
        let mut sample = light.sample_as(aiming, p, u, time)?;
        if let (Some(point), Some(pose)) = (&mut sample.point, pose) {
            *point = own(point, &pose, p);
        }
        Some(sample)
    }

    /// As [`Light::pdf_as`].
    pub(crate) fn pdf_as(&self, aiming: Aiming, p: Vec3, wi: Vec3, distance: f32, n: Vec3, time: f32) -> f32 {
        if let Still::Oval(area) = &self.light {
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

    /// As [`Light::power`], when the shutter opens.
    pub(crate) fn power(&self, scene_radius: f32) -> Vec3 {
        if let Still::Oval(area) = &self.light {
            let surface = self.motion.pose_at(0.0).map_or(0.0, |pose| Oval { area, pose: &pose }.surface());
            let sides = if area.two_sided { 2.0 } else { 1.0 };
            return area.radiance * (std::f64::consts::PI * sides * surface) as f32;
        }
        self.at(0.0).map_or(Vec3::ZERO, |light| light.power(scene_radius))
    }

    pub(crate) fn is_dark(&self) -> bool {
        Vec3::ZERO
            == match &self.light {
                Still::Point(l) => l.intensity,
                Still::Spot(l) => l.intensity,
                Still::Distant(l) => l.irradiance,
                Still::Area(l) | Still::Patterned(l, _) | Still::Oval(l) => l.radiance,
            }
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        let Still::Patterned(_, patterns) = &self.light else { return size_of::<Self>() };
        size_of::<Self>() + patterns.iter().map(|p| p.memory_bytes()).sum::<usize>()
    }

    pub(crate) fn is_delta(&self) -> bool {
        self.surface().is_none()
    }

    /// Box over the shutter.
    pub(crate) fn swept(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// Irradiance of a distant light, whose direction is taken to be any.
    pub(crate) fn distant_irradiance(&self) -> Option<Vec3> {
        if let Still::Distant(l) = &self.light { Some(l.irradiance) } else { None }
    }

    fn bounds_at(&self, time: f32) -> Option<Bounds> {
        let Still::Oval(area) = &self.light else { return Bounds::of(&self.at(time)?) };
        let pose = self.motion.pose_at(time.into())?;
        Bounds::of_oval(area, &Oval { area, pose: &pose })
    }

    /// Bounds that hold at every time: the box is swept, the cone kept only if nothing turns. *Approximation*: the
    /// intensity is the greatest of a few times; it shapes the choice, not the result.
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
            cone: if keeps { greatest.cone } else { crate::cluster::Cone::ALL },
            intensity: greatest.intensity,
        })
    }
}

impl AreaShape {
    /// The shape in render space, its front still in front: a mirror swaps two corners of a triangle, and the edges of a
    /// quad.
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

/// A sampled place as the surface has it: barycentrics in the order of its own corners, and an error bound that also
/// covers how rays from `from` see the moved surface (they are rounded in its own space).
fn own(point: &LightPoint, pose: &Pose, from: Vec3) -> LightPoint {
    let local = |p: Vec3| pose.to_object.transform_point3(p.as_dvec3()).abs();
    let seen = pose.error((local(from) + local(point.p)) * f64::from(gamma(4)));
    let rounding = (pose.to_world.translation.abs() + point.p.abs().as_dvec3()) * f64::from(gamma(4));
    let (u, v) = if pose.is_mirrored() { (point.v, point.u) } else { (point.u, point.v) };
    LightPoint { p_error: point.p_error + (seen + rounding).as_vec3(), u, v, ..*point }
}
