//! The layers of a glTF material over lanes, for one direction above the surface, each with its share:
//! metallic·metal + (1 − metallic)·(coat over mix(diffuse base, clear dielectric, transmission)).

use super::albedo::{AlbedoRow, DirectionalAlbedo};
use super::choice::Shares;
use super::diffuse::Diffuse;
use super::fresnel::{Interface, Schlick};
use super::microfacet::{Ggx, SMOOTH_ALPHA};
use super::parameters::{Parameters, clamped};
use super::reflection::Rough;
use super::transmission::{ClearLayer, sum};
use crate::lobe::{Lobe, Lobes, meets, sharpened};
use dapple_math::lanes::{Mask, Real, Vec3x, Word};
use glam::Vec3;

/// The layers of one material per lane, with what depends on `wo` alone.
#[derive(Clone, Copy, Debug)]
pub struct Layers<R: Real> {
    /// The diffuse base, black where there is none.
    pub(super) diffuse: Diffuse<R>,
    /// Fresnel term of metal and opaque dielectric, weighted by their shares.
    pub(super) opaque: Schlick<R>,
    /// The clear dielectric, whose share is 0 in lanes without one; `None` if no lane has one.
    pub(super) clear: Option<ClearLayer<R>>,
    /// The microfacets, of use in the lanes with rough lobes only; `None` if no lane has one.
    pub(super) rough: Option<Rough<R>>,
    /// Squared roughness.
    alpha: R,
    /// Factor of the reflection at rough surfaces.
    gain: R,
    /// Lobes with non-zero weight; they also determine which layers are treated as smooth.
    pub(super) live: R::Word,
    /// Albedo, summed over the channels, of diffuse base, opaque reflection, clear reflection and transmission; 1 with
    /// fewer than two lobes.
    grey: [R; 4],
    /// Selection probabilities for all live lobes.
    shares: Shares<R>,
}

impl<R: Real> Layers<R> {
    /// Builds the layers for `wo` above the surface. `side` is −1 where that is the back side. `losing_as`: the cosine
    /// that determines the energy loss of single scattering, if it is not that of `wo`.
    #[inline(always)]
    pub fn new(parameters: &Parameters<R>, wo: Vec3x<R>, side: R, losing_as: Option<R>) -> Self {
        let one = R::splat(1.0);
        let share = (one - clamped(parameters.metallic)) * clamped(parameters.transmission);
        let coat = parameters.dielectric();
        let clear = if share.gt(R::splat(0.0)).any() {
            Some(clear_layer(parameters, coat, share, side))
        } else {
            None
        };
        Self::with(parameters, coat, clear, wo, losing_as)
    }

    /// As [`Self::new`], for materials that transmit nothing, whose `transmission` is 0 or NaN, or which are metal.
    #[inline(always)]
    pub fn opaque(parameters: &Parameters<R>, wo: Vec3x<R>, losing_as: Option<R>) -> Self {
        Self::with(parameters, parameters.dielectric(), None, wo, losing_as)
    }

    #[inline(always)]
    fn with(
        parameters: &Parameters<R>,
        coat: Schlick<R>,
        clear: Option<ClearLayer<R>>,
        wo: Vec3x<R>,
        losing_as: Option<R>,
    ) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let (alpha, base, metal) = (parameters.alpha(), parameters.base(), clamped(parameters.metallic));
        let share = (one - metal) * (one - clamped(parameters.transmission));
        let opaque = Schlick { f0: base * metal + coat.f0 * share, f90: metal + coat.f90 * share };

        let rho = base * share;
        let (diffuse, reflects, transmits) = (is_lit(rho), reflects(&opaque, &clear), transmits(&clear));
        let several = (diffuse & reflects) | (diffuse & transmits) | (reflects & transmits);
        let coated = diffuse & coat.f90.gt(zero);
        let is_rough = alpha.ge(R::splat(SMOOTH_ALPHA));
        let (mut gain, mut row, mut split) =
            (one, AlbedoRow::smooth(), DirectionalAlbedo { c: one, b: zero });
        if (several | coated).any() || (losing_as.is_some() && is_rough.any()) {
            row = AlbedoRow::new(alpha);
            split = row.at(wo.z);
        }
        if let Some(mu) = losing_as {
            // Accurate to 0.25 %, like the table; 1 for smooth surfaces.
            gain = row.at(mu).c / split.c;
            split = split.times(gain);
        }
        let mut layers = Self {
            diffuse: Diffuse::new(rho, coated, row, (coat.f0.max_element(), coat.f90), split),
            opaque,
            clear,
            rough: None,
            alpha,
            gain,
            live: R::Word::splat(0),
            grey: [one; 4],
            shares: Shares { diffuse: zero, reflection: zero, transmission: zero, facets: zero },
        };
        if (is_rough & (reflects | transmits)).any() {
            layers.rough = Some(Rough::new(Ggx::isotropic(alpha), wo, gain));
        }
        layers.live = layers.lobes(is_rough);
        layers.choose(wo.z, split);
        layers
    }

    /// Returns the layers with the given rough lobes replaced by smooth ones, for the cosine `mu` of `wo`.
    #[inline(always)]
    pub fn sharp(mut self, mu: R, lobes: Lobes) -> Self {
        self.live = sharpened(self.live, lobes);
        self.choose(mu, self.split(mu));
        self
    }

    /// Lobes with non-zero weight.
    #[inline(always)]
    fn lobes(&self, is_rough: R::Mask) -> R::Word {
        let none = R::Word::splat(0);
        let diffuse = R::Word::select(is_lit(self.diffuse.albedo), bit(Lobe::Diffuse), none);
        let reflection = R::Word::select(is_rough, bit(Lobe::GlossyReflection), bit(Lobe::DeltaReflection));
        let reflection = R::Word::select(reflects(&self.opaque, &self.clear), reflection, none);
        let Some(clear) = &self.clear else { return diffuse | reflection };
        let blurs = is_rough & clear.interface.blurs();
        let through = R::Word::select(blurs, bit(Lobe::GlossyTransmission), bit(Lobe::DeltaTransmission));
        diffuse | reflection | R::Word::select(transmits(&self.clear), through, none)
    }

    /// The parts of the albedo of the reflection towards the cosine `mu`.
    #[inline(always)]
    fn split(&self, mu: R) -> DirectionalAlbedo<R> {
        AlbedoRow::new(self.alpha).at(mu).times(self.gain)
    }

    /// Directional albedo of diffuse base, opaque reflection, clear reflection and transmission.
    #[inline(always)]
    fn albedos(&self, mu: R, split: DirectionalAlbedo<R>) -> [Vec3x<R>; 4] {
        let Schlick { f0, f90 } = self.opaque;
        let opaque = f0 * split.c + (Vec3x::new(f90, f90, f90) - f0) * split.b;
        let none = Vec3x::splat(Vec3::ZERO);
        let [back, on] = match &self.clear {
            Some(clear) => clear.albedos(split.c, mu),
            None => [none; 2],
        };
        [self.diffuse.albedo, opaque, back, on]
    }

    /// Returns the directional albedo of the diffuse base.
    #[inline(always)]
    pub fn diffuse_albedo(&self) -> Vec3x<R> {
        self.diffuse.albedo
    }

    /// Returns the transmission through a smooth surface that does not refract, for `wo` above the surface; 0 elsewhere.
    #[inline(always)]
    pub fn straight(&self, wo: Vec3x<R>) -> Vec3x<R> {
        let none = Vec3x::splat(Vec3::ZERO);
        let Some(clear) = &self.clear else { return none };
        let smooth = meets(self.live, Lobes::of(Lobe::DeltaTransmission)) & clear.interface.keeps_direction();
        if !smooth.any() {
            return none;
        }
        Vec3x::select(smooth, clear.delta_weight(wo), none)
    }

    /// Returns the transmission through a smooth surface with refraction ignored, at the cosine `mu`; 0 elsewhere.
    #[inline(always)]
    pub fn straightened(&self, mu: R) -> Vec3x<R> {
        let none = Vec3x::splat(Vec3::ZERO);
        let Some(clear) = &self.clear else { return none };
        let smooth = meets(self.live, Lobes::of(Lobe::DeltaTransmission));
        if !smooth.any() {
            return none;
        }
        Vec3x::select(smooth, clear.tint * clear.interface.from_thinner().transmittance(mu), none)
    }

    /// Returns the sum of the albedos of the layers at the cosine `mu` of `wo`.
    #[inline(always)]
    pub fn albedo(&self, mu: R) -> Vec3x<R> {
        let [diffuse, opaque, back, on] = self.albedos(mu, self.split(mu));
        diffuse + opaque + back + on
    }

    #[inline(always)]
    fn choose(&mut self, mu: R, split: DirectionalAlbedo<R>) {
        // A single lobe needs no estimate of its albedo.
        let several = (self.live & self.live.wrapping_sub(R::Word::splat(1))).ne(R::Word::splat(0));
        if several.any() {
            let [a, b, c, d] = self.albedos(mu, split);
            self.grey = [grey(several, a), grey(several, b), grey(several, c), grey(several, d)];
        }
        self.shares = self.shares_of(self.live);
    }

    #[inline(always)]
    fn shares_of(&self, asked: R::Word) -> Shares<R> {
        Shares::new(self.grey, asked, self.opaque.f90.gt(R::splat(0.0)), self.clear.is_some())
    }

    /// Returns the selection probabilities for the given live lobes.
    #[inline(always)]
    pub(super) fn shares(&self, asked: R::Word) -> Shares<R> {
        if asked.eq(self.live).all() { self.shares } else { self.shares_of(asked) }
    }
}

/// The set of one lobe for every lane.
#[inline(always)]
fn bit<W: Word>(lobe: Lobe) -> W {
    Lobes::of(lobe).splat()
}

/// The sum of the channels in the lanes of `mask`, 1 in the others.
#[inline(always)]
fn grey<R: Real>(mask: R::Mask, albedo: Vec3x<R>) -> R {
    R::select(mask, sum(albedo), R::splat(1.0))
}

#[inline(always)]
fn is_lit<R: Real>(color: Vec3x<R>) -> R::Mask {
    color.max_element().gt(R::splat(0.0))
}

/// Whether any layer but the base reflects light at any angle.
#[inline(always)]
fn reflects<R: Real>(opaque: &Schlick<R>, clear: &Option<ClearLayer<R>>) -> R::Mask {
    let zero = R::splat(0.0);
    match clear {
        Some(clear) => opaque.f90.gt(zero) | (clear.share.gt(zero) & clear.interface.reflects()),
        None => opaque.f90.gt(zero),
    }
}

#[inline(always)]
fn transmits<R: Real>(clear: &Option<ClearLayer<R>>) -> R::Mask {
    match clear {
        Some(clear) => is_lit(clear.tint),
        None => R::Mask::splat(false),
    }
}

/// The clear layer as seen from the side of `wo`.
#[inline(always)]
fn clear_layer<R: Real>(parameters: &Parameters<R>, tint: Schlick<R>, share: R, side: R) -> ClearLayer<R> {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let known = parameters.ior.gt(zero);
    // Clamped so that η² remains finite.
    let ior = R::select(known, parameters.ior.max(R::splat(1e-6)).min(R::splat(1e6)), zero);
    let leaves = side.lt(zero) & known & !parameters.thin;
    let eta = R::select(leaves, one / ior, ior);
    let interface = Interface::new(tint, eta, parameters.thin);
    ClearLayer { share, tint: parameters.base() * share, interface }
}
