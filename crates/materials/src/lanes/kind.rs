//! Kinds of surfaces, and the BSDF over lanes of one kind.

use crate::lobe::{Lobes, meets};
use dapple_math::lanes::{Mask, Real, Vec2x, Vec3x, Word};
use glam::Vec3;

/// Cosines below this count as in the surface, where no light is transported: the product of two of them reaches the
/// limit of f32.
pub(super) const GRAZING: f32 = 1e-18;

/// Sampled directions.
#[derive(Clone, Copy, Debug)]
pub struct Sample<R: Real> {
    /// Unit direction in the local frame, pointing away from the surface point. It has no meaning where there is no
    /// sample.
    pub wi: Vec3x<R>,
    /// f·|cosθ_i| / pdf (mixture over the given lobes); never negative, and 0 where there is no sample.
    pub weight: Vec3x<R>,
    /// Density of the mixture per solid angle; 1 for delta lobes, and 0 where there is no sample.
    pub pdf: R,
    /// The set of the sampled lobe alone, as the bits of [`Lobes`]; empty where there is no sample.
    pub lobe: R::Word,
    /// (η_i/η_o)², the inverse of the radiance scaling in `weight`, for Russian roulette: 1 for reflection and thin
    /// walls.
    pub eta: R,
}

impl<R: Real> Sample<R> {
    /// Returns no sample.
    #[inline(always)]
    pub fn none() -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let none = Vec3x::splat(Vec3::ZERO);
        Self { wi: none, weight: none, pdf: zero, lobe: R::Word::splat(0), eta: one }
    }

    /// Whether there is a sample: the lobes carry light, and light can travel in the sampled direction.
    #[inline(always)]
    pub fn exists(&self) -> R::Mask {
        self.lobe.ne(R::Word::splat(0))
    }

    /// Removes the samples outside of `mask`.
    #[inline(always)]
    pub fn only(self, mask: R::Mask) -> Self {
        let none = Self::none();
        if mask.all() {
            return self;
        }
        Self {
            wi: self.wi,
            weight: Vec3x::select(mask, self.weight, none.weight),
            pdf: R::select(mask, self.pdf, none.pdf),
            lobe: R::Word::select(mask, self.lobe, none.lobe),
            eta: R::select(mask, self.eta, none.eta),
        }
    }
}

/// One kind of surface, with what depends on the material and on `wo`. All directions are unit vectors in the local
/// frame, and `wo` is above the surface.
pub trait Kind<R: Real>: Copy {
    /// Returns the lobes with non-zero weight, as the bits of [`Lobes`].
    fn live(&self) -> R::Word;

    /// Returns the BSDF value without the cosine (1/sr) and the density per solid angle for the given live lobes. Delta
    /// lobes contribute nothing. `wi` does not lie in the surface.
    fn eval(&self, wo: Vec3x<R>, wi: Vec3x<R>, asked: R::Word) -> (Vec3x<R>, R);

    /// Samples a direction from the given live lobes: `uc` selects the lobe, `u` the direction.
    fn sample(&self, wo: Vec3x<R>, uc: R, u: Vec2x<R>, asked: R::Word) -> Sample<R>;
}

impl<R: Real, K: Kind<R>> Kind<R> for &K {
    #[inline(always)]
    fn live(&self) -> R::Word {
        (*self).live()
    }

    #[inline(always)]
    fn eval(&self, wo: Vec3x<R>, wi: Vec3x<R>, asked: R::Word) -> (Vec3x<R>, R) {
        (*self).eval(wo, wi, asked)
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3x<R>, uc: R, u: Vec2x<R>, asked: R::Word) -> Sample<R> {
        (*self).sample(wo, uc, u, asked)
    }
}

/// The BSDFs of surfaces of one kind, one per lane, for one outgoing direction each: [`crate::Bsdf`] over lanes.
///
/// Either side of a surface may be hit: directions are flipped so that `wo` is above it, and only the index of
/// refraction depends on the side.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<R: Real, K> {
    wo: Vec3x<R>,
    side: R,
    live: R::Word,
    kind: K,
}

/// Returns `wo` flipped so that z ≥ 0, and −1 where it was flipped, else 1.
#[inline(always)]
pub fn face<R: Real>(wo: Vec3x<R>) -> (Vec3x<R>, R) {
    let side = R::select(wo.z.lt(R::splat(0.0)), R::splat(-1.0), R::splat(1.0));
    (Vec3x::new(wo.x, wo.y, wo.z * side), side)
}

/// Whether light can be scattered towards `wo` above the surface: it is neither in the surface nor NaN.
#[inline(always)]
pub fn is_seen<R: Real>(wo: Vec3x<R>) -> R::Mask {
    wo.z.ge(R::splat(GRAZING)) & wo.x.eq(wo.x) & wo.y.eq(wo.y)
}

impl<R: Real, K> Bsdf<R, K> {
    /// Returns the surface.
    #[inline(always)]
    pub fn kind(&self) -> &K {
        &self.kind
    }

    /// Returns the same directions and lobes with the surface given in another form.
    #[inline(always)]
    pub fn of<L>(&self, kind: L) -> Bsdf<R, L> {
        Bsdf { wo: self.wo, side: self.side, live: self.live, kind }
    }

    /// Returns `wo`, flipped so that it is above the surface, and −1 where it was flipped, else 1.
    #[inline(always)]
    pub fn face(&self) -> (Vec3x<R>, R) {
        (self.wo, self.side)
    }

    /// Returns the lobes with non-zero weight, as the bits of [`Lobes`].
    #[inline(always)]
    pub fn lobes(&self) -> R::Word {
        self.live
    }

    /// Converts a direction to and from the frame in which `wo` is above the surface.
    #[inline(always)]
    pub fn turn(&self, w: Vec3x<R>) -> Vec3x<R> {
        Vec3x::new(w.x, w.y, w.z * self.side)
    }
}

impl<R: Real, K> Bsdf<R, K> {
    /// Whether light that leaves towards `wi` continues in exactly the direction in which it arrived, to the last bit.
    #[inline(always)]
    pub fn passes(&self, wi: Vec3x<R>) -> R::Mask {
        let (turned, on) = (self.turn(wi), -self.wo);
        turned.x.eq(on.x) & turned.y.eq(on.y) & turned.z.eq(on.z)
    }
}

impl<R: Real, K: Kind<R>> Bsdf<R, K> {
    /// Builds the BSDFs of surfaces of a kind, given `wo` and its side from [`face`].
    #[inline(always)]
    pub fn new((wo, side): (Vec3x<R>, R), kind: K) -> Self {
        let live = R::Word::select(is_seen(wo), kind.live(), R::Word::splat(0));
        Self { wo, side, live, kind }
    }

    /// Returns the BSDF value without the cosine (1/sr), delta lobes excluded, and the solid-angle density of
    /// [`Self::sample_f`] for the same lobes. Both are 0 for directions in the surface.
    #[inline(always)]
    pub fn eval(&self, wi: Vec3x<R>, lobes: R::Word) -> (Vec3x<R>, R) {
        let (zero, none) = (R::splat(0.0), Vec3x::splat(Vec3::ZERO));
        let asked = self.live & lobes;
        let lit = meets(asked, Lobes::ALL.without(Lobes::DELTA)) & wi.z.abs().ge(R::splat(GRAZING));
        if !lit.any() {
            return (none, zero);
        }
        let (f, pdf) = self.kind.eval(self.wo, self.turn(wi), asked);
        (Vec3x::select(lit, f, none), R::select(lit, pdf, zero))
    }

    /// Samples directions from the given lobes: `uc` selects the lobe, `u` the direction.
    #[inline(always)]
    pub fn sample_f(&self, uc: R, u: Vec2x<R>, lobes: R::Word) -> Sample<R> {
        let asked = self.live & lobes;
        let lit = meets(asked, Lobes::ALL);
        if !lit.any() {
            return Sample::none();
        }
        let sample = self.kind.sample(self.wo, uc, u, asked);
        Sample { wi: self.turn(sample.wi), ..sample.only(lit) }
    }
}
