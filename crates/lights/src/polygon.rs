//! Sampling of triangles and parallelograms.
use crate::aimed::{Aimed, SMALL, visible};
use crate::part::Part;
use crate::solid_angle::{Arm, Wedge, facing};
use crate::{LightPoint, rectangle};
use dapple_sampling::warp;
use glam::{DVec2, DVec3, Vec2, Vec3};

/// A triangle (P0, P0 + e1, P0 + e2) or a parallelogram with those edges, relative to a receiver; all in f64.
pub(crate) struct Facet {
    corner: DVec3,
    /// From the receiver to P0.
    p0: DVec3,
    e1: DVec3,
    e2: DVec3,
    /// −p0·(e1×e2), see [`facing`].
    facing: f64,
    outline: Outline,
}

/// The kind of a facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outline {
    Triangle,
    /// A parallelogram with right angles, up to [`rectangle::is_rectangle`].
    Rectangle,
    /// Any parallelogram.
    Skewed,
}

/// A sampled point of a facet, seen from the receiver.
pub(crate) struct Spot {
    /// Unit direction.
    pub wi: DVec3,
    pub distance: f64,
    /// Density per solid angle.
    pub pdf: f64,
    /// Coordinates along e1, e2.
    pub at: DVec2,
}

impl Facet {
    pub fn triangle(p: Vec3, a: Vec3, b: Vec3, c: Vec3) -> Self {
        let a = a.as_dvec3();
        Self::new(p, a, b.as_dvec3() - a, c.as_dvec3() - a, Outline::Triangle)
    }

    pub fn quad(p: Vec3, corner: Vec3, e1: Vec3, e2: Vec3) -> Self {
        Self::edges(p, corner, e1, e2, Outline::Skewed)
    }

    pub fn edges(p: Vec3, corner: Vec3, e1: Vec3, e2: Vec3, outline: Outline) -> Self {
        Self::new(p, corner.as_dvec3(), e1.as_dvec3(), e2.as_dvec3(), outline)
    }

    fn new(p: Vec3, corner: DVec3, e1: DVec3, e2: DVec3, outline: Outline) -> Self {
        let p0 = corner - p.as_dvec3();
        Self { corner, p0, e1, e2, facing: facing(p0, e1, e2), outline }
    }

    fn is_quad(&self) -> bool {
        self.outline != Outline::Triangle
    }

    /// The one or two triangles at P0: (P0, P0 + e1, P0 + e2), or (P0, P1, P2) and (P0, P2, P3). The latter share the
    /// side through P0, so the map from the unit square is continuous across the diagonal.
    fn wedges(&self) -> (Wedge, Option<Wedge>) {
        let arm = |v: DVec3| Arm::new(self.p0 + v);
        let (apex, one, three) = (arm(DVec3::ZERO), arm(self.e1), arm(self.e2));
        if !self.is_quad() {
            return (Wedge::new(self.facing, apex, one, three), None);
        }
        let two = arm(self.e1 + self.e2);
        (Wedge::new(self.facing, apex, one, two), Some(Wedge::new(self.facing, apex, two, three)))
    }

    /// A part of the triangle. It lies in the same plane, so the receiver sees the same side of it.
    pub fn part(&self, part: &Part) -> Self {
        let offset = self.e1 * part.corner.x + self.e2 * part.corner.y;
        Self {
            corner: self.corner + offset,
            p0: self.p0 + offset,
            e1: self.e1 * part.step,
            e2: self.e2 * part.step,
            facing: self.facing * part.area(),
            outline: self.outline,
        }
    }

    /// Solid angle that the shape subtends at the receiver.
    pub fn omega(&self) -> f64 {
        let (first, second) = self.wedges();
        first.omega + second.map_or(0.0, |w| w.omega)
    }

    /// Coordinates (along e1, e2) of the point that a direction hits.
    pub fn place(&self, wi: Vec3) -> Option<Vec2> {
        self.hit(wi.as_dvec3()).map(|(_, at)| at.as_vec2())
    }

    pub fn sample(&self, u: Vec2, two_sided: bool) -> Option<Aimed> {
        self.spot(u, two_sided).map(|spot| self.aimed(spot))
    }

    /// A point uniform in solid angle if that is at least `SMALL`, else in area.
    pub fn spot(&self, u: Vec2, two_sided: bool) -> Option<Spot> {
        let facing = visible(self.facing, two_sided)?;
        let (first, second) = self.wedges();
        let omega = first.omega + second.map_or(0.0, |w| w.omega);
        if omega < SMALL {
            return Some(self.at(self.spread(u), facing));
        }
        if self.outline == Outline::Rectangle {
            let (to, at) = rectangle::sample(self.p0, self.e1, self.e2, omega, u.as_dvec2());
            let distance = to.length();
            let usable = distance > 0.0 && at.is_finite();
            return usable.then(|| Spot { wi: to / distance, distance, pdf: 1.0 / omega, at });
        }
        let x = u.x as f64 * omega;
        let (u, y) = (DVec2::new(x / first.omega, u.y as f64), u.y as f64);
        let wi = match second {
            Some(second) if x >= first.omega => {
                second.sample(DVec2::new((x - first.omega) / second.omega, y))
            }
            _ => first.sample(u),
        }?;
        let (distance, at) = self.hit(wi)?;
        Some(Spot { wi, distance, pdf: 1.0 / omega, at })
    }

    /// Samples uniformly in area.
    pub fn sample_surface(&self, u: Vec2, two_sided: bool) -> Option<Aimed> {
        self.spot_in_area(u, two_sided).map(|spot| self.aimed(spot))
    }

    /// A point uniform in area.
    pub fn spot_in_area(&self, u: Vec2, two_sided: bool) -> Option<Spot> {
        Some(self.at(self.spread(u), visible(self.facing, two_sided)?))
    }

    /// Solid-angle density of `sample_surface`.
    pub fn pdf_surface(&self, distance: f32, two_sided: bool) -> f64 {
        visible(self.facing, two_sided).map_or(0.0, |facing| self.area_pdf(distance as f64, facing))
    }

    /// The point `at` (along e1, e2), with the density of uniform sampling in area.
    pub fn middle(&self, two_sided: bool, at: Vec2) -> Option<Aimed> {
        Some(self.aimed(self.at(at.as_dvec2(), visible(self.facing, two_sided)?)))
    }

    /// Coordinates along e1, e2, uniform in area.
    fn spread(&self, u: Vec2) -> DVec2 {
        if self.is_quad() { u } else { warp::triangle(u) }.as_dvec2()
    }

    fn at(&self, at: DVec2, facing: f64) -> Spot {
        let to = self.p0 + self.e1 * at.x + self.e2 * at.y;
        let distance = to.length();
        Spot { wi: to / distance, distance, pdf: self.area_pdf(distance, facing), at }
    }

    /// Solid-angle density of `sample` for a point at `distance`.
    pub fn pdf(&self, distance: f32, two_sided: bool) -> f64 {
        let Some(facing) = visible(self.facing, two_sided) else { return 0.0 };
        let (first, second) = self.wedges();
        let omega = first.omega + second.map_or(0.0, |w| w.omega);
        if omega < SMALL { self.area_pdf(distance as f64, facing) } else { 1.0 / omega }
    }

    /// distance²/(area·cosθ), where area·cosθ·distance = `facing` (half of it for the triangle).
    fn area_pdf(&self, distance: f64, facing: f64) -> f64 {
        let share = if self.is_quad() { 1.0 } else { 2.0 };
        share * distance * distance * distance / facing
    }

    /// Distance and coordinates (along e1, e2) of the intersection with the plane, clamped to the shape against
    /// rounding.
    fn hit(&self, wi: DVec3) -> Option<(f64, DVec2)> {
        let n = self.e1.cross(self.e2);
        let distance = self.p0.dot(n) / wi.dot(n);
        let q = wi * distance - self.p0;
        let at = DVec2::new(q.cross(self.e2).dot(n), self.e1.cross(q).dot(n)) / n.length_squared();
        let at = at.clamp(DVec2::ZERO, DVec2::ONE);
        let over = at.x + at.y;
        let at = if self.is_quad() || over <= 1.0 { at } else { at / over };
        (distance > 0.0 && distance.is_finite() && at.is_finite()).then_some((distance, at))
    }

    fn aimed(&self, Spot { wi, distance, pdf, at }: Spot) -> Aimed {
        let p = (self.corner + self.e1 * at.x + self.e2 * at.y).as_vec3();
        // Rounded once, plus the rounding in the edges of a quad.
        let p_error = (p.abs() + self.e1.abs().as_vec3() + self.e2.abs().as_vec3()) * f32::EPSILON;
        let n = self.e1.cross(self.e2).normalize().as_vec3();
        let (triangle, u, v) = match self.is_quad() {
            false => (0, at.x, at.y),
            true if at.x >= at.y => (0, at.x - at.y, at.y),
            true => (1, at.x, at.y - at.x),
        };
        let point = LightPoint { p, p_error, n, triangle, u: u as f32, v: v as f32 };
        Aimed { wi: wi.as_vec3(), distance: distance as f32, pdf: pdf as f32, point }
    }
}
