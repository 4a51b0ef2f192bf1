//! Value, density and sampling of the layers over lanes.
//!
//! With several lobes, one is selected by its share of the light, and the weight is the sum of f·cos of all lobes over
//! the mixture density: the balance heuristic over lobes (see `choice`).

use super::choice::{Pick, Shares};
use super::kind::{GRAZING, Kind, Sample};
use super::layers::Layers;
use super::microfacet::reflect;
use super::reflection::Rough;
use super::transmission::FacetCosines;
use crate::lobe::{Lobe, Lobes, meets};
use dapple_math::lanes::{Mask, Real, Vec2x, Vec3x, Word};
use dapple_sampling::lanes::warp::{hemisphere_cosine, hemisphere_cosine_pdf};
use glam::Vec3;

/// Sampled directions, their lobes (the bits of one, or none where no light can travel), and the cosines of the facets
/// that scattered them, in the lanes of a mask.
#[derive(Clone, Copy)]
struct Direction<R: Real> {
    wi: Vec3x<R>,
    lobe: R::Word,
    known: Known<R>,
}

/// Cosines of facets in the lanes where they are known more accurately than from wo and wi, so that F and 1 − F use the
/// same facet and add up to 1 to the last digits.
type Known<R> = Option<(<R as Real>::Mask, FacetCosines<R>)>;

impl<R: Real> Kind<R> for Layers<R> {
    #[inline(always)]
    fn live(&self) -> R::Word {
        self.live
    }

    #[inline(always)]
    fn eval(&self, wo: Vec3x<R>, wi: Vec3x<R>, asked: R::Word) -> (Vec3x<R>, R) {
        self.eval_known(wo, wi, None, asked, &self.shares(asked))
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3x<R>, uc: R, u: Vec2x<R>, asked: R::Word) -> Sample<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let shares = self.shares(asked);
        let pick = shares.pick(uc, self.clear.is_some());
        let Direction { wi, lobe, known } = self.direction(&pick, wo, u, asked);
        if !meets(lobe, Lobes::ALL).any() {
            return Sample::none();
        }
        let mut eta = one;
        if let Some(clear) = &self.clear {
            eta = R::select(meets(lobe, Lobes::TRANSMISSION), clear.interface.eta_squared(), one);
        }
        let (mut weight, mut pdf) = (Vec3x::splat(Vec3::ZERO), zero);
        let spread = meets(lobe, Lobes::ALL.without(Lobes::DELTA)) & wi.z.abs().ge(R::splat(GRAZING));
        if spread.any() {
            let (f, density) = self.eval_known(wo, wi, known, asked, &shares);
            weight = f * (wi.z.abs() / density);
            // For the diffuse lobe alone the cosine cancels.
            let alone = meets(lobe, Lobes::of(Lobe::Diffuse)) & pick.share.eq(one);
            if alone.any() {
                weight = Vec3x::select(alone, self.diffuse.weight(wi.z), weight);
            }
            pdf = density;
        }
        let delta = meets(lobe, Lobes::DELTA);
        if delta.any() {
            weight = Vec3x::select(delta, self.delta_weight(lobe, wo) / pick.share, weight);
            pdf = R::select(delta, one, pdf);
        }
        let lit = delta | (spread & pdf.gt(zero) & pdf.is_finite());
        Sample { wi, weight, pdf, lobe, eta }.only(lit)
    }
}

impl<R: Real> Layers<R> {
    #[inline(always)]
    fn eval_known(
        &self,
        wo: Vec3x<R>,
        wi: Vec3x<R>,
        known: Known<R>,
        asked: R::Word,
        shares: &Shares<R>,
    ) -> (Vec3x<R>, R) {
        let (zero, none) = (R::splat(0.0), Vec3x::splat(Vec3::ZERO));
        let below = wi.z.lt(zero);
        if !below.any() {
            return self.eval_above(wo, wi, known, asked, shares);
        }
        let (mut f, mut pdf) = (none, zero);
        if !below.all() {
            let above = self.eval_above(wo, wi, known, asked, shares);
            (f, pdf) = (Vec3x::select(below, none, above.0), R::select(below, zero, above.1));
        }
        let through = below & meets(asked, Lobes::of(Lobe::GlossyTransmission));
        if !through.any() {
            return (f, pdf);
        }
        let other = self.eval_below(wo, wi, known, shares);
        (Vec3x::select(through, other.0, f), R::select(through, other.1, pdf))
    }

    #[inline(always)]
    fn eval_above(
        &self,
        wo: Vec3x<R>,
        wi: Vec3x<R>,
        known: Known<R>,
        asked: R::Word,
        shares: &Shares<R>,
    ) -> (Vec3x<R>, R) {
        let (zero, none) = (R::splat(0.0), Vec3x::splat(Vec3::ZERO));
        let (mut f, mut pdf) = (none, zero);
        let diffuse = meets(asked, Lobes::of(Lobe::Diffuse));
        if diffuse.any() {
            f = Vec3x::select(diffuse, self.diffuse.f(wi.z), none);
            pdf = R::select(diffuse, shares.diffuse * hemisphere_cosine_pdf(wi.z), zero);
        }
        let glossy = meets(asked, Lobes::of(Lobe::GlossyReflection));
        let Some(rough) = &self.rough else { return (f, pdf) };
        if !glossy.any() {
            return (f, pdf);
        }
        let lobe = rough.eval(wo, wi);
        let (value, density) = (R::select(glossy, lobe.value, zero), R::select(glossy, lobe.pdf, zero));
        let c = match known {
            Some((mask, facet)) => R::select(mask, facet.o, lobe.cos),
            None => lobe.cos,
        };
        f += self.opaque.at(c) * value;
        pdf += shares.reflection * density;
        if let Some(clear) = &self.clear {
            let reflectance = clear.interface.reflectance(c);
            f += reflectance * (clear.share * value);
            let ratio = rough.visible_ratio(wo, clear.interface.thin);
            pdf += shares.facets * clear.reflecting(reflectance) * density * ratio;
        }
        (f, pdf)
    }

    #[inline(always)]
    fn eval_below(&self, wo: Vec3x<R>, wi: Vec3x<R>, known: Known<R>, shares: &Shares<R>) -> (Vec3x<R>, R) {
        let (Some(clear), Some(rough)) = (&self.clear, &self.rough) else {
            return (Vec3x::splat(Vec3::ZERO), R::splat(0.0));
        };
        let one = R::splat(1.0);
        let (lobe, reflectance) = clear.eval(rough, wo, wi, known);
        let share = shares.transmission + shares.facets * (one - clear.reflecting(reflectance));
        (clear.tint * ((one - reflectance.max_element()) * lobe.value), share * lobe.pdf)
    }

    /// Samples the direction of the selected layer.
    #[inline(always)]
    fn direction(&self, pick: &Pick<R>, wo: Vec3x<R>, u: Vec2x<R>, asked: R::Word) -> Direction<R> {
        let none = R::Word::splat(0);
        let diffuse = pick.diffuse();
        let mirrors = pick.reflection() & meets(asked, Lobes::of(Lobe::DeltaReflection));
        let lobe = R::Word::select(mirrors, Lobes::of(Lobe::DeltaReflection).splat(), none);
        let mut to = Direction { wi: Vec3x::new(-wo.x, -wo.y, wo.z), lobe, known: None };
        if diffuse.any() {
            to.wi = Vec3x::select(diffuse, hemisphere_cosine(u), to.wi);
            to.lobe = R::Word::select(diffuse, Lobes::of(Lobe::Diffuse).splat(), to.lobe);
        }
        let mut by_facet = pick.reflection() & !mirrors;
        if let Some(clear) = &self.clear {
            let passes = pick.transmission() & meets(asked, Lobes::of(Lobe::DeltaTransmission));
            by_facet = by_facet | (pick.transmission() & !passes) | pick.facets();
            if passes.any() {
                let (wi, lit) = clear.interface.through(wo);
                to.wi = Vec3x::select(passes, wi, to.wi);
                to.lobe = R::Word::select(passes & lit, Lobes::of(Lobe::DeltaTransmission).splat(), to.lobe);
            }
        }
        match &self.rough {
            Some(rough) if by_facet.any() => self.by_facet(rough, pick, by_facet, wo, u, to),
            _ => to,
        }
    }

    /// Samples a facet in the lanes of `mask`, and reflects or transmits there.
    #[inline(always)]
    fn by_facet(
        &self,
        rough: &Rough<R>,
        pick: &Pick<R>,
        mask: R::Mask,
        wo: Vec3x<R>,
        u: Vec2x<R>,
        to: Direction<R>,
    ) -> Direction<R> {
        let none = R::Word::splat(0);
        let (mut turns, mut thin) = (pick.reflection(), R::Mask::splat(false));
        if let Some(clear) = &self.clear {
            thin = clear.interface.thin;
        }
        let (m, found) = rough.facet(wo, u, turns | thin);
        let c = wo.dot(m);
        let mut facet = FacetCosines { o: c, i: c };
        if let Some(clear) = &self.clear
            && pick.facets().any()
        {
            let q = clear.reflecting(clear.interface.reflectance(c));
            turns = turns | (pick.facets() & pick.rest.lt(q));
        }
        let mut wi = wo;
        if (turns | thin).any() {
            wi = reflect(wo, m);
        }
        let up = turns & wi.z.gt(R::splat(0.0));
        let mut lobe = R::Word::select(up, Lobes::of(Lobe::GlossyReflection).splat(), none);
        if let Some(clear) = &self.clear
            && (mask & !turns).any()
        {
            let (through, leaves, cosines) = clear.leave(wo, m, c, wi);
            facet = FacetCosines::select(turns, facet, cosines);
            wi = Vec3x::select(turns, wi, through);
            let down = !turns & leaves;
            lobe = R::Word::select(down, Lobes::of(Lobe::GlossyTransmission).splat(), lobe);
        }
        Direction {
            wi: Vec3x::select(mask, wi, to.wi),
            lobe: R::Word::select(mask, R::Word::select(found, lobe, none), to.lobe),
            known: Some((mask, facet)),
        }
    }

    /// Weight of a smooth layer before division by its selection probability.
    #[inline(always)]
    fn delta_weight(&self, lobe: R::Word, wo: Vec3x<R>) -> Vec3x<R> {
        let Some(clear) = &self.clear else { return self.opaque.at(wo.z) };
        let through = meets(lobe, Lobes::TRANSMISSION);
        let mut weight = Vec3x::splat(Vec3::ZERO);
        if !through.all() {
            weight = self.opaque.at(wo.z) + clear.interface.reflectance(wo.z) * clear.share;
        }
        if through.any() {
            weight = Vec3x::select(through, clear.delta_weight(wo), weight);
        }
        weight
    }
}
