//! A light that moves: its shape in its own space, the motion that takes it to render space, and the box that it stays in.
use crate::{Area, Distant, Pattern, Point, Spot};
use dapple_math::Motion;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Motions that [`Motion::bounds`] cuts into more steps than this are bounded for a whole object at once.
const MANY_STEPS: usize = 64;

/// A light that changes its place while the shutter is open, for `seconds` from time 0 on.
#[derive(Clone, Debug)]
pub struct Moving {
    pub(crate) light: Still,
    pub(crate) motion: Arc<Motion>,
    pub(crate) seconds: f32,
    /// Box over the shutter.
    pub(crate) bounds: (DVec3, DVec3),
}

/// A light in its own space.
#[derive(Clone, Debug)]
pub(crate) enum Still {
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
}
