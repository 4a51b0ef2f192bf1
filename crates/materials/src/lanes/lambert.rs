//! An uncoated diffuse base over lanes: the most common material, without any other data.

use super::kind::{GRAZING, Kind, Sample};
use super::parameters::Parameters;
use crate::lobe::{Lobe, Lobes};
use dapple_math::lanes::{Mask, Real, Vec2x, Vec3x, Word};
use dapple_sampling::lanes::warp::{hemisphere_cosine, hemisphere_cosine_pdf};
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// Surfaces that reflect light diffusely and not otherwise, f = ρ/π: `specular`, `metallic` and `transmission` are 0.
#[derive(Clone, Copy, Debug)]
pub struct Lambert<R> {
    /// Reflectance ρ.
    pub rho: Vec3x<R>,
}

impl<R: Real> Lambert<R> {
    /// Builds the surfaces from their base colours.
    #[inline(always)]
    pub fn new(parameters: &Parameters<R>) -> Self {
        Self { rho: parameters.base() }
    }
}

impl<R: Real> Kind<R> for Lambert<R> {
    #[inline(always)]
    fn live(&self) -> R::Word {
        let lit = self.rho.max_element().gt(R::splat(0.0));
        R::Word::select(lit, Lobes::of(Lobe::Diffuse).splat(), R::Word::splat(0))
    }

    #[inline(always)]
    fn eval(&self, _: Vec3x<R>, wi: Vec3x<R>, _: R::Word) -> (Vec3x<R>, R) {
        let (none, above) = (Vec3x::splat(Vec3::ZERO), wi.z.gt(R::splat(0.0)));
        if !above.any() {
            return (none, R::splat(0.0));
        }
        let f = self.rho * R::splat(FRAC_1_PI);
        (Vec3x::select(above, f, none), hemisphere_cosine_pdf(wi.z))
    }

    #[inline(always)]
    fn sample(&self, _: Vec3x<R>, _: R, u: Vec2x<R>, _: R::Word) -> Sample<R> {
        let wi = hemisphere_cosine(u);
        let lobe = Lobes::of(Lobe::Diffuse).splat();
        let sample =
            Sample { wi, weight: self.rho, pdf: hemisphere_cosine_pdf(wi.z), lobe, eta: R::splat(1.0) };
        sample.only(wi.z.ge(R::splat(GRAZING)))
    }
}
