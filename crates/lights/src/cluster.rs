//! Bounds of a set of lights, from which the light tree computes importance.
//!
//! A cluster has a bounding box, a cone of axes, an angle of emission about each axis, and an intensity [Conty Estevez
//! and Kulla 2018]. The intensity is the mean over the channels of the maximum radiant intensity: I of a point light,
//! radiance·area of a surface. The importance is therefore an irradiance, comparable with that of distant lights.
use crate::oval::Oval;
use crate::{Area, AreaShape, Light};
use glam::{DVec3, Vec3};
use libm::{atan2, cos, sin};
use std::f64::consts::{FRAC_PI_2, PI};

/// Bound of the directions of emission: within θ_e of an axis that lies within θ_o of `axis`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    pub axis: DVec3,
    pub theta_o: f64,
    pub theta_e: f64,
    /// Whether it emits equally about −axis.
    pub two_sided: bool,
}

impl Cone {
    pub const ALL: Self = Self { axis: DVec3::Z, theta_o: PI, theta_e: FRAC_PI_2, two_sided: false };

    /// The smallest cone around both; all directions if only one of them is two-sided.
    fn union(&self, other: &Self) -> Self {
        let theta_e = self.theta_e.max(other.theta_e);
        let (mut a, mut b) = if self.theta_o >= other.theta_o { (*self, *other) } else { (*other, *self) };
        if a.theta_o >= PI || a.two_sided != b.two_sided {
            return Self { theta_e, ..Self::ALL };
        }
        if a.two_sided && a.axis.dot(b.axis) < 0.0 {
            b.axis = -b.axis;
        }
        a.theta_e = theta_e;
        let across = a.axis.cross(b.axis);
        let between = atan2(across.length(), a.axis.dot(b.axis));
        if between + b.theta_o <= a.theta_o {
            return a;
        }
        let theta_o = 0.5 * (a.theta_o + between + b.theta_o);
        let turn = across.cross(a.axis).try_normalize();
        let (Some(turn), true) = (turn, theta_o < PI) else { return Self { theta_e, ..Self::ALL } };
        let by = theta_o - a.theta_o;
        Self { axis: a.axis * cos(by) + turn * sin(by), theta_o, ..a }
    }
}

/// Bounds of a set of lights.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub low: Vec3,
    pub high: Vec3,
    pub cone: Cone,
    pub intensity: f64,
}

impl Bounds {
    /// Bounds of one light; None for infinite lights and for lights that emit nothing.
    pub fn of(light: &Light) -> Option<Self> {
        let all = Cone::ALL;
        let bounds = match light {
            Light::Point(l) => Self { low: l.p, high: l.p, cone: all, intensity: mean(l.intensity) },
            Light::Spot(l) => {
                let theta_o = l.outer_angle();
                let cone = Cone { axis: l.axis.as_dvec3(), theta_o, theta_e: 0.0, two_sided: false };
                Self { low: l.p, high: l.p, cone, intensity: mean(l.intensity) }
            }
            Light::Patterned(l) => return Self::of(&Light::Area(l.area.clone())),
            Light::Area(l) => {
                let ((low, high), axis) = (l.shape.bounds(), normal(&l.shape));
                let flat = |axis| Cone { axis, theta_o: 0.0, theta_e: FRAC_PI_2, two_sided: l.two_sided };
                // The projected area of a sphere is a quarter of its surface area from every direction.
                let shown = if axis.is_some() { 1.0 } else { 0.25 };
                let intensity = mean(l.radiance) * l.shape.area() * shown;
                Self { low, high, cone: axis.map_or(all, flat), intensity }
            }
            Light::Moving(l) if l.distant_irradiance().is_none() => return l.cluster(),
            Light::Distant(_) | Light::Environment(_) | Light::Moving(_) => return None,
        };
        (bounds.intensity > 0.0).then_some(bounds)
    }

    /// Bounds of an emitting sphere or disk under a non-uniform transform, without the box, which the caller computes
    /// from the motion.
    pub fn of_oval(area: &Area, oval: &Oval<'_>) -> Option<Self> {
        let axis = oval.normal();
        let flat = |axis| Cone { axis, theta_o: 0.0, theta_e: FRAC_PI_2, two_sided: area.two_sided };
        let shown = if axis.is_some() { 1.0 } else { 0.25 };
        let intensity = mean(area.radiance) * oval.surface() * shown;
        let bounds =
            Self { low: Vec3::ZERO, high: Vec3::ZERO, cone: axis.map_or(Cone::ALL, flat), intensity };
        (bounds.intensity > 0.0).then_some(bounds)
    }

    pub fn union(&self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            cone: self.cone.union(&other.cone),
            intensity: self.intensity + other.intensity,
        }
    }

    pub fn centre(&self) -> Vec3 {
        ((self.low.as_dvec3() + self.high.as_dvec3()) * 0.5).as_vec3()
    }

    /// Half of the diagonal of the bounding box.
    pub fn radius(&self) -> f64 {
        (self.high.as_dvec3() - self.low.as_dvec3()).length() * 0.5
    }
}

/// Normal of the front; None for shapes that emit in all directions.
fn normal(shape: &AreaShape) -> Option<DVec3> {
    let across = |e1: Vec3, e2: Vec3| e1.as_dvec3().cross(e2.as_dvec3()).try_normalize();
    match *shape {
        AreaShape::Triangle([a, b, c]) => across(b - a, c - a),
        AreaShape::Quad { e1, e2, .. } => across(e1, e2),
        AreaShape::Sphere { .. } => None,
        AreaShape::Disk { normal, .. } => Some(normal.as_dvec3()),
    }
}

/// Mean of the channels, which are weighted equally, as in the error of an image.
pub(crate) fn mean(rgb: Vec3) -> f64 {
    let rgb = rgb.as_dvec3();
    ((rgb.x + rgb.y + rgb.z) / 3.0).min(1e200)
}

#[cfg(test)]
mod tests {
    use super::*;
    use libm::acos;

    #[test]
    fn cones_hold_what_they_join() {
        let cone = |x: f64, z: f64, theta_o| Cone {
            axis: DVec3::new(x, 0.0, z).normalize(),
            theta_o,
            theta_e: FRAC_PI_2,
            two_sided: false,
        };
        let joined = cone(1.0, 1.0, 0.1).union(&cone(-1.0, 1.0, 0.2));
        assert!((joined.theta_o - 0.5 * (FRAC_PI_2 + 0.3)).abs() < 1e-12);
        for (x, theta) in [(1.0, 0.1), (-1.0, 0.2)] {
            let axis = DVec3::new(x, 0.0, 1.0).normalize();
            assert!(acos(joined.axis.dot(axis)) + theta <= joined.theta_o + 1e-9);
        }
        assert!(cone(0.0, 1.0, 0.0).union(&cone(0.0, -1.0, 0.0)).theta_o >= PI);
        let (a, b) = (cone(0.0, 1.0, 0.0), cone(0.0, -1.0, 0.0));
        let sheet = Cone { two_sided: true, ..a }.union(&Cone { two_sided: true, ..b });
        assert_eq!(sheet.theta_o, 0.0, "both sides of one surface");
    }
}
