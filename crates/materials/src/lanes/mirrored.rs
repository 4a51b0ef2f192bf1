//! Mirrors over lanes, perfect or with square blur.

use super::kind::{GRAZING, Kind, Sample};
use super::mirror::{SHARP_BLUR, SquareBlur};
use crate::lobe::{Lobe, Lobes};
use dapple_math::lanes::{Mask, Real, Vec2x, Vec3x, Word};
use glam::Vec3;

/// Surfaces that are mirrors alone: [`crate::Mirror`].
#[derive(Clone, Copy, Debug)]
pub struct Mirrored<R: Real> {
    /// Fraction of the light that is reflected.
    pub kr: Vec3x<R>,
    blurred: R::Mask,
    square: SquareBlur<R>,
}

impl<R: Real> Mirrored<R> {
    /// Builds mirrors that reflect `kr` over a square of side `blur`, for `wo` above the surface.
    #[inline(always)]
    pub fn new(kr: Vec3x<R>, blur: R, wo: Vec3x<R>) -> Self {
        let blurred = blur.ge(R::splat(SHARP_BLUR));
        Self { kr: kr.max(Vec3x::splat(Vec3::ZERO)), blurred, square: SquareBlur::new(wo, blur) }
    }

    /// Returns the mirrors without blur.
    #[inline(always)]
    pub fn sharp(self) -> Self {
        Self { blurred: R::Mask::splat(false), ..self }
    }
}

impl<R: Real> Kind<R> for Mirrored<R> {
    #[inline(always)]
    fn live(&self) -> R::Word {
        let (blurred, perfect) = (Lobes::of(Lobe::Mirror).splat(), Lobes::of(Lobe::DeltaReflection).splat());
        let lit = self.kr.max_element().gt(R::splat(0.0));
        R::Word::select(lit, R::Word::select(self.blurred, blurred, perfect), R::Word::splat(0))
    }

    #[inline(always)]
    fn eval(&self, _: Vec3x<R>, wi: Vec3x<R>, _: R::Word) -> (Vec3x<R>, R) {
        let (zero, pdf) = (R::splat(0.0), self.square.pdf(wi));
        let (none, lit) = (Vec3x::splat(Vec3::ZERO), pdf.gt(zero));
        if !lit.any() {
            return (none, zero);
        }
        (Vec3x::select(lit, self.kr * (pdf / wi.z), none), pdf)
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3x<R>, _: R, u: Vec2x<R>, asked: R::Word) -> Sample<R> {
        let one = R::splat(1.0);
        let wi = Vec3x::new(-wo.x, -wo.y, wo.z);
        let perfect = Sample { wi, weight: self.kr, pdf: one, lobe: asked, eta: one };
        if !self.blurred.any() {
            return perfect;
        }
        let wi = self.square.sample(u);
        let pdf = R::select(self.blurred, self.square.pdf(wi), one);
        let blurred = Sample { wi: Vec3x::select(self.blurred, wi, perfect.wi), pdf, ..perfect };
        blurred.only(!self.blurred | wi.z.ge(R::splat(GRAZING)))
    }
}
