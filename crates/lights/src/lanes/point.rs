//! Point and spot lights.
use super::columns::{Columns, lane, lanes_of, stored, three};
use crate::falloff::{falloff, window};
use dapple_math::lanes::{Mask, Real, Vec3x};

/// One point light per lane.
#[derive(Clone, Copy, Debug)]
pub struct Point<R> {
    /// Position.
    pub p: Vec3x<R>,
    /// Intensity in W·sr⁻¹ per channel.
    pub intensity: Vec3x<R>,
    /// Distance in render units at which the light ends; infinite for none.
    pub range: R,
}

/// One spot light per lane.
#[derive(Clone, Copy, Debug)]
pub struct Spot<R> {
    /// Position and intensity inside the inner cone.
    pub point: Point<R>,
    /// Unit direction in which the light emits.
    pub axis: Vec3x<R>,
    /// 1 − cosine of the angle at which the fall-off begins.
    pub inner: R,
    /// 1 − cosine of the angle at which the light ends.
    pub outer: R,
}

/// One direction towards a light without extent per lane.
#[derive(Clone, Copy, Debug)]
pub struct Shone<R: Real> {
    /// Unit direction towards the light.
    pub wi: Vec3x<R>,
    /// Distance in render units.
    pub distance: R,
    /// Irradiance on a surface that faces the light.
    pub irradiance: Vec3x<R>,
    /// Whether the light reaches the receiver: not at the light itself, out of range, or where f32 cannot represent the
    /// value.
    pub reaches: R::Mask,
}

/// 1 − cosine of 2.5°: the fall-off of narrower spots is computed in f64.
const NARROW: f32 = 1.0 / 1024.0;

impl<R: Real> Point<R> {
    /// Returns the irradiance I/d² at `p`, times the window clamp(1 − (d/range)⁴, 0, 1) that KHR_lights_punctual
    /// recommends.
    #[inline(always)]
    pub fn sample(&self, p: Vec3x<R>) -> Shone<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let v = self.p - p;
        let d2 = v.length_squared();
        let distance = d2.sqrt();
        let r = distance / self.range;
        let r2 = r * r;
        let mut share = (one - r2 * r2).max(zero) / d2;
        // Towards the end of the range the difference cancels.
        let cancels = r.gt(R::splat(0.5));
        if cancels.any() {
            let [mut column, range] = stored([share, self.range]);
            share_lanes(cancels.bitmask(), &mut column, [&three(p), &three(self.p)], &range);
            share = R::load(&column);
        }
        let irradiance = self.intensity * share;
        let reaches = d2.gt(zero) & irradiance.is_finite() & is_lit(irradiance);
        Shone { wi: v / distance, distance, irradiance, reaches }
    }
}

/// Irradiance per intensity, in f64.
#[cold]
#[inline(never)]
fn share_lanes(mask: u32, column: &mut [f32], [p, from]: [&Columns<3>; 2], range: &[f32]) {
    for i in lanes_of(mask) {
        let d2 = (lane(from, i).as_dvec3() - lane(p, i).as_dvec3()).length_squared();
        column[i] = (window(d2.sqrt() / f64::from(range[i])) / d2) as f32;
    }
}

#[inline(always)]
fn is_lit<R: Real>(v: Vec3x<R>) -> R::Mask {
    let zero = R::splat(0.0);
    v.x.ne(zero) | v.y.ne(zero) | v.z.ne(zero)
}

impl<R: Real> Spot<R> {
    /// Returns the irradiance at `p`, as [`Point::sample`] times the fall-off.
    #[inline(always)]
    pub fn sample(&self, p: Vec3x<R>) -> Shone<R> {
        let shone = self.point.sample(p);
        let irradiance = shone.irradiance * self.falloff(shone.wi, p);
        Shone { irradiance, reaches: shone.reaches & is_lit(irradiance), ..shone }
    }

    /// The fall-off as [`crate::Spot::falloff`] has it, towards a receiver at `p` in the direction −`wi`.
    #[inline(always)]
    fn falloff(&self, wi: Vec3x<R>, p: Vec3x<R>) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let height = R::splat(0.5) * (wi + self.axis).length_squared();
        let a = (self.outer - height) / (self.outer - self.inner);
        let inside = R::select(height.lt(self.outer), a * a, zero);
        let falloff = R::select(height.le(self.inner), one, inside);
        let narrow = !self.outer.ge(R::splat(NARROW));
        if !narrow.any() {
            return falloff;
        }
        let [mut column, inner, outer] = stored([falloff, self.inner, self.outer]);
        let (from, axis) = (three(self.point.p), three(self.axis));
        falloff_lanes(narrow.bitmask(), &mut column, [&three(p), &from, &axis], [&inner, &outer]);
        R::load(&column)
    }
}

#[cold]
#[inline(never)]
fn falloff_lanes(
    mask: u32,
    column: &mut [f32],
    [p, from, axis]: [&Columns<3>; 3],
    [inner, outer]: [&[f32]; 2],
) {
    for i in lanes_of(mask) {
        let d = lane(p, i).as_dvec3() - lane(from, i).as_dvec3();
        let (inner, outer) = (inner[i].into(), outer[i].into());
        column[i] = falloff(d.normalize(), lane(axis, i).as_dvec3(), inner, outer) as f32;
    }
}
