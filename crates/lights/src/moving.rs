//! Lights in motion: the light in its local space, its motion to render space, and a box that contains it at all times.
use crate::{Area, Distant, Pattern, Point, Spot};
use dapple_math::Motion;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Motions that [`Motion::bounds`] divides into more steps than this are bounded for a whole object at once.
const MANY_STEPS: usize = 64;

/// A light that moves while the shutter is open, from time 0 for `seconds`.
#[derive(Clone, Debug)]
pub struct Moving {
    pub(crate) light: LocalLight,
    pub(crate) motion: Arc<Motion>,
    pub(crate) seconds: f32,
    /// Bounding box over the exposure.
    pub(crate) bounds: (DVec3, DVec3),
}

/// A light in its local space.
#[derive(Clone, Debug)]
pub(crate) enum LocalLight {
    /// Intensity and range are in render units.
    Point(Point),
    Spot(Spot),
    Distant(Distant),
    Area(Area),
    /// A triangle with its pattern and the pattern of its mirror image.
    Patterned(Area, [Arc<Pattern>; 2]),
    /// A sphere or disk that becomes an ellipsoid or ellipse in render space.
    Oval(Area),
}

impl Moving {
    /// A point light; intensity and range are in render units already.
    pub fn point(light: Point, motion: Arc<Motion>, seconds: f32) -> Self {
        Self::new(LocalLight::Point(light), motion, seconds, None)
    }

    /// A spot light; intensity and range in render units, position and axis in its local space.
    pub fn spot(light: Spot, motion: Arc<Motion>, seconds: f32) -> Self {
        Self::new(LocalLight::Spot(light), motion, seconds, None)
    }

    /// A distant light whose direction rotates.
    pub fn distant(light: Distant, motion: Arc<Motion>, seconds: f32) -> Self {
        Self::new(LocalLight::Distant(light), motion, seconds, None)
    }

    /// An emitting surface in its local space; the motion must keep spheres and disks round (see [`Motion`]). `whole`
    /// is a box that contains the object of the light while the shutter is open; it replaces the box of the light
    /// itself where that would be expensive to compute.
    pub fn area(light: Area, motion: Arc<Motion>, seconds: f32, whole: Option<(DVec3, DVec3)>) -> Self {
        let whole = whole.filter(|_| motion.step_count(0.0, f64::from(seconds)) > MANY_STEPS);
        Self::new(LocalLight::Area(light), motion, seconds, whole)
    }

    /// As [`Moving::area`], for a triangle whose emission is sampled by `pattern`.
    #[must_use]
    pub fn patterned(mut self, pattern: Arc<Pattern>) -> Self {
        if let LocalLight::Area(area) = &self.light {
            let mirrored = Arc::new(pattern.mirrored());
            self.light = LocalLight::Patterned(area.clone(), [pattern, mirrored]);
        }
        self
    }

    /// As [`Moving::area`], for a sphere or disk that the motion need not keep round.
    #[must_use]
    pub fn oval(mut self) -> Self {
        if let LocalLight::Area(area) = &self.light {
            self.light = LocalLight::Oval(area.clone());
        }
        self
    }

    /// The emitting surface in its local space; None for a light without surface.
    pub fn surface(&self) -> Option<&Area> {
        match &self.light {
            LocalLight::Area(area) | LocalLight::Patterned(area, _) | LocalLight::Oval(area) => Some(area),
            _ => None,
        }
    }

    fn new(light: LocalLight, motion: Arc<Motion>, seconds: f32, whole: Option<(DVec3, DVec3)>) -> Self {
        let (low, high) = match &light {
            LocalLight::Point(l) => (l.p, l.p),
            LocalLight::Spot(l) => (l.p, l.p),
            LocalLight::Distant(_) => (Vec3::ZERO, Vec3::ZERO),
            LocalLight::Area(l) | LocalLight::Patterned(l, _) | LocalLight::Oval(l) => l.shape.bounds(),
        };
        let swept = || motion.bounds(low.as_dvec3(), high.as_dvec3(), 0.0, f64::from(seconds));
        let bounds = whole.unwrap_or_else(swept);
        Self { light, motion, seconds, bounds }
    }

    pub(crate) fn is_dark(&self) -> bool {
        Vec3::ZERO
            == match &self.light {
                LocalLight::Point(l) => l.intensity,
                LocalLight::Spot(l) => l.intensity,
                LocalLight::Distant(l) => l.irradiance,
                LocalLight::Area(l) | LocalLight::Patterned(l, _) | LocalLight::Oval(l) => l.radiance,
            }
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        let LocalLight::Patterned(_, patterns) = &self.light else { return size_of::<Self>() };
        size_of::<Self>() + patterns.iter().map(|p| p.memory_bytes()).sum::<usize>()
    }

    pub(crate) fn is_delta(&self) -> bool {
        self.surface().is_none()
    }

    /// Bounding box over the exposure.
    pub(crate) fn swept(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// Irradiance of a distant light, for which any direction is assumed.
    pub(crate) fn distant_irradiance(&self) -> Option<Vec3> {
        if let LocalLight::Distant(l) = &self.light { Some(l.irradiance) } else { None }
    }
}
