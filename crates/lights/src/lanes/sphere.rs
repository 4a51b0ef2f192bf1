//! Spheres, sampled uniformly in the cone that they subtend.
use super::aimed::Aimed;
use super::columns::{Columns, lane, lanes_of, stored, three};
use crate::sphere;
use dapple_math::lanes::{Framex, MAX_LANES, Mask, Real, Vec2x, Vec3x, sin_cos};
use glam::Vec2;
use std::f32::consts::TAU;

/// One sphere per lane.
#[derive(Clone, Copy, Debug)]
pub struct Sphere<R: Real> {
    /// Centre.
    pub centre: Vec3x<R>,
    /// Radius.
    pub radius: R,
    /// Whether the inside emits as well.
    pub two_sided: R::Mask,
}

/// Receivers that are closer to the surface than this, relative to the largest of their distance to the centre and of
/// all coordinates, are computed in f64: d² − R² cancels, and a point may lie on the surface.
const CLOSE: f32 = 1.0 / 64.0;

/// Range of distances and radii for which no intermediate result leaves f32.
const RANGE: [f32; 2] = [f32::from_bits((127 - 40) << 23), f32::from_bits((127 + 40) << 23)];

/// Directions in which a receiver sees the sphere: the cone of 1 − cosθ ≤ `height` about `w`.
struct Cone<R: Real> {
    w: Vec3x<R>,
    /// Distance to the centre.
    d: R,
    /// d² − R².
    gap: R,
    /// 1 − cosθ_max; 2 for all directions.
    height: R,
    pdf: R,
    inside: R::Mask,
    /// Where f32 is accurate.
    accurate: R::Mask,
}

impl<R: Real> Sphere<R> {
    /// Samples directions for receivers at `p` with `u` in \[0, 1)²: uniformly in the cone that the sphere subtends,
    /// and over all directions from inside. The density is 0 inside of a one-sided sphere.
    #[inline(always)]
    pub fn sample(&self, p: Vec3x<R>, u: Vec2x<R>) -> Aimed<R> {
        let (cone, r) = (self.seen(p), self.radius);
        let (one, two) = (R::splat(1.0), R::splat(2.0));
        let v = u.x * cone.height;
        let (cos, sin) = (one - v, (v * (two - v)).max(R::splat(0.0)).sqrt());
        // β: angle between the direction and the normal at the intersection. From outside its sine squared is
        // u(2 − u·h)/(2 − h), and the square of its cosine does not cancel in this form.
        let turned = cone.d * sin / r;
        let outer = (one - u.x) * (two - cone.height * (one + u.x)) / (two - cone.height);
        let cos_beta = R::select(cone.inside, (one - turned) * (one + turned), outer);
        let cos_beta = cos_beta.max(R::splat(0.0)).sqrt();
        let sin_beta = turned.min(one);
        let reach = cone.d * cos + r * cos_beta;
        let distance = R::select(cone.inside, reach, cone.gap / reach);
        let across = R::select(cone.inside, cos_beta, -cos_beta);
        let along = across * cos - sin_beta * sin;
        let radial = distance * sin / r;
        let frame = Framex::from_z(cone.w);
        let (sin_phi, cos_phi) = sin_cos(u.y * R::splat(TAU));
        let side = frame.x * cos_phi + frame.y * sin_phi;
        let wi = (side * sin + cone.w * cos).normalize();
        let n = (side * radial + cone.w * along).normalize();
        let fast = self.at(wi, n, distance, cone.pdf);
        self.replaced(!cone.accurate, fast, p, u).only_finite()
    }

    /// Solid-angle density of [`Sphere::sample`] at `p` of any direction that hits the sphere.
    #[inline(always)]
    pub fn pdf(&self, p: Vec3x<R>) -> R {
        let cone = self.seen(p);
        let rare = !cone.accurate;
        let mut pdf = cone.pdf;
        if rare.any() {
            let [mut column] = stored([pdf]);
            pdf_lanes(rare.bitmask(), &mut column, &self.columns(), &three(p));
            pdf = R::load(&column);
        }
        pdf.min(R::splat(f32::MAX))
    }

    /// With s = R/d from outside, 1 − cosθ_max = s²/(1 + √(1 − s²)).
    #[inline(always)]
    fn seen(&self, p: Vec3x<R>) -> Cone<R> {
        let (zero, one, r) = (R::splat(0.0), R::splat(1.0), self.radius);
        let to = self.centre - p;
        let d = to.length();
        let gap = (d - r) * (d + r);
        let per = one / d;
        let inside = gap.lt(zero);
        let s = r * per;
        let outer = s * s / (one + gap.max(zero).sqrt() * per);
        let height = R::select(inside, R::splat(2.0), outer);
        let emits = !inside | self.two_sided;
        let pdf = R::select(emits, one / (R::splat(TAU) * height), zero);
        // On the wall of a distant sphere, or at its centre, everything is decided in f64.
        let largest = p.abs().max(self.centre.abs()).max_element() * R::splat(f32::EPSILON * 16.0);
        let away = (d - r).abs();
        let accurate = away.ge(d.max(r) * R::splat(CLOSE))
            & away.gt(largest)
            & d.ge(R::splat(RANGE[0]))
            & d.le(R::splat(RANGE[1]))
            & r.ge(R::splat(RANGE[0]))
            & r.le(R::splat(RANGE[1]));
        Cone { w: to * per, d, gap, height, pdf, inside, accurate }
    }

    #[inline(always)]
    fn at(&self, wi: Vec3x<R>, n: Vec3x<R>, distance: R, pdf: R) -> Aimed<R> {
        let offset = n * self.radius;
        let p_error = (self.centre.abs() + offset.abs()) * R::splat(4.0 * f32::EPSILON);
        let (s, t) = (R::splat(0.0), R::splat(0.0));
        Aimed { wi, distance, pdf, p: self.centre + offset, p_error, n, s, t }
    }

    /// Replaces the lanes of `mask` by samples computed in f64.
    #[inline(always)]
    fn replaced(&self, mask: R::Mask, fast: Aimed<R>, p: Vec3x<R>, u: Vec2x<R>) -> Aimed<R> {
        if !mask.any() {
            return fast;
        }
        let (wi, n) = (fast.wi, fast.n);
        let mut columns = stored([wi.x, wi.y, wi.z, n.x, n.y, n.z, fast.distance, fast.pdf]);
        sample_lanes(mask.bitmask(), &mut columns, &self.columns(), &three(p), &stored([u.x, u.y]));
        let [x, y, z, nx, ny, nz, distance, pdf] = columns;
        let (wi, n) = (Vec3x::load([&x, &y, &z]), Vec3x::load([&nx, &ny, &nz]));
        self.at(wi, n, R::load(&distance), R::load(&pdf))
    }

    #[inline(always)]
    fn columns(&self) -> LightColumns {
        let [radius] = stored([self.radius]);
        LightColumns { centre: three(self.centre), radius, two_sided: self.two_sided.bitmask() }
    }
}

struct LightColumns {
    centre: Columns<3>,
    radius: [f32; MAX_LANES],
    two_sided: u32,
}

#[cold]
#[inline(never)]
fn sample_lanes(mask: u32, columns: &mut Columns<8>, light: &LightColumns, p: &Columns<3>, u: &Columns<2>) {
    for i in lanes_of(mask) {
        let (centre, two_sided) = (lane(&light.centre, i), light.two_sided >> i & 1 == 1);
        let aimed =
            sphere::sample(lane(p, i), centre, light.radius[i], two_sided, Vec2::new(u[0][i], u[1][i]));
        columns[7][i] = 0.0;
        if let Some(aimed) = aimed {
            let (wi, n) = (aimed.wi, aimed.point.n);
            let values = [wi.x, wi.y, wi.z, n.x, n.y, n.z, aimed.distance, aimed.pdf];
            columns.iter_mut().zip(values).for_each(|(column, value)| column[i] = value);
        }
    }
}

#[cold]
#[inline(never)]
fn pdf_lanes(mask: u32, pdf: &mut [f32], light: &LightColumns, p: &Columns<3>) {
    for i in lanes_of(mask) {
        let (centre, two_sided) = (lane(&light.centre, i), light.two_sided >> i & 1 == 1);
        pdf[i] = sphere::pdf(lane(p, i), centre, light.radius[i], two_sided) as f32;
    }
}
