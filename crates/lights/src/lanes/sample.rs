//! Light samples over lanes.
use super::aimed::Aimed;
use super::point::Shone;
use crate::sample::END;
use dapple_math::lanes::{Mask, Real, Vec3x};
use dapple_math::offset::offset_origins;
use glam::Vec3;

/// One sampled direction towards a light per lane, as [`LightSample`](crate::LightSample) describes one.
#[derive(Clone, Copy, Debug)]
pub struct Sample<R: Real> {
    /// Unit direction towards the light.
    pub wi: Vec3x<R>,
    /// Solid-angle density at the receiver; 1 for delta lights, and 0 where there is no sample.
    pub pdf: R,
    /// Whether no other sampling technique can find this light.
    pub delta: R::Mask,
    /// Radiance along −wi, of delta lights the irradiance on a surface that faces them.
    pub radiance: Vec3x<R>,
    /// Distance to the light; infinite for distant lights and the environment.
    pub distance: R,
    /// Whether there is a sampled point; only for area lights.
    pub has_point: R::Mask,
    /// The sampled point.
    pub p: Vec3x<R>,
    /// Bound of the error of `p`, per axis.
    pub p_error: Vec3x<R>,
    /// Unit normal of the front at the point.
    pub n: Vec3x<R>,
    /// Index of the triangle of the shape, as a number.
    pub triangle: R,
    /// Barycentric coordinate of corner 1 of the triangle.
    pub u: R,
    /// Barycentric coordinate of corner 2 of the triangle.
    pub v: R,
}

impl<R: Real> Sample<R> {
    /// Returns no sample in any lane.
    #[inline(always)]
    pub fn none() -> Self {
        let (zero, none) = (Vec3x::splat(Vec3::ZERO), R::Mask::splat(false));
        let o = R::splat(0.0);
        Self {
            wi: zero,
            pdf: o,
            delta: none,
            radiance: zero,
            distance: o,
            has_point: none,
            p: zero,
            p_error: zero,
            n: zero,
            triangle: o,
            u: o,
            v: o,
        }
    }

    /// Samples of area lights with the given triangle and barycentric coordinates.
    #[inline(always)]
    pub(super) fn area(aimed: Aimed<R>, [triangle, u, v]: [R; 3], radiance: Vec3x<R>) -> Self {
        let Aimed { wi, distance, pdf, p, p_error, n, .. } = aimed;
        let (delta, has_point) = (R::Mask::splat(false), R::Mask::splat(true));
        Self { wi, pdf, delta, radiance, distance, has_point, p, p_error, n, triangle, u, v }
    }

    /// Samples of lights without extent.
    #[inline(always)]
    pub(super) fn delta(shone: Shone<R>) -> Self {
        Self {
            wi: shone.wi,
            pdf: R::select(shone.reaches, R::splat(1.0), R::splat(0.0)),
            delta: R::Mask::splat(true),
            radiance: shone.irradiance,
            distance: shone.distance,
            ..Self::none()
        }
    }

    /// Returns directions and ends of the shadow rays from `o`, as [`LightSample::shadow_ray`] does.
    ///
    /// [`LightSample::shadow_ray`]: crate::LightSample::shadow_ray
    #[inline(always)]
    pub fn shadow_ray(&self, o: Vec3x<R>) -> (Vec3x<R>, R) {
        let end = R::select(self.distance.is_finite(), self.distance, R::splat(f32::INFINITY));
        if !self.has_point.any() {
            return (self.wi, end);
        }
        let target = offset_origins(self.p, self.p_error, self.n, -self.wi);
        let d = Vec3x::select(self.has_point, target - o, self.wi);
        (d, R::select(self.has_point, R::splat(END), end))
    }

    /// Returns `yes` in the lanes of `mask` and `no` in the others.
    #[inline(always)]
    pub fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self {
            wi: Vec3x::select(mask, yes.wi, no.wi),
            pdf: R::select(mask, yes.pdf, no.pdf),
            delta: (mask & yes.delta) | (!mask & no.delta),
            radiance: Vec3x::select(mask, yes.radiance, no.radiance),
            distance: R::select(mask, yes.distance, no.distance),
            has_point: (mask & yes.has_point) | (!mask & no.has_point),
            p: Vec3x::select(mask, yes.p, no.p),
            p_error: Vec3x::select(mask, yes.p_error, no.p_error),
            n: Vec3x::select(mask, yes.n, no.n),
            triangle: R::select(mask, yes.triangle, no.triangle),
            u: R::select(mask, yes.u, no.u),
            v: R::select(mask, yes.v, no.v),
        }
    }
}
