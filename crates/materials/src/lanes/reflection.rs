//! Rough specular reflection over lanes, of metals, coats and clear dielectrics in one lobe: they share the roughness,
//! and every Fresnel law is linear in its share, so that a blend of materials is a blend of F.
//!
//! f = F(wo·m) D(m) G2(wo,wi) / (4 wo.z wi.z), m = normalise(wo + wi) [Walter 2007, eq. 20]. Scattering is single:
//! light that is reflected more than once between facets is lost (docs/science.md, "GGX").

use super::microfacet::Ggx;
use dapple_math::lanes::{Mask, Real, Vec2x, Vec3x};

/// A rough surface for one `wo`, with the values that depend on `wo` alone.
#[derive(Clone, Copy, Debug)]
pub struct Rough<R> {
    /// The distribution of normals.
    pub ggx: Ggx<R>,
    /// The stretched length t(wo), see [`Ggx::t`].
    pub t: R,
    /// Bound of the spherical cap.
    k: R,
    /// 1/(k wo.z + t(wo)).
    per_cap: R,
    /// Factor of every value: 1, or the ratio of the albedos without the Fresnel term that replaces the energy loss of
    /// single scattering by the loss at another angle.
    pub gain: R,
}

/// What a direction above a rough surface carries.
#[derive(Clone, Copy, Debug)]
pub struct Reflection<R> {
    /// D·G2/(4 cos cos), without the Fresnel term, times [`Rough::gain`].
    pub value: R,
    /// Density of the direction reflected at [`Rough::facet`] with `bounded`, per solid angle.
    pub pdf: R,
    /// The cosine wo·m.
    pub cos: R,
}

impl<R: Real> Rough<R> {
    /// Builds the surface for `wo` above it.
    #[inline(always)]
    pub fn new(ggx: Ggx<R>, wo: Vec3x<R>, gain: R) -> Self {
        let (t, k) = (ggx.t(wo), ggx.cap_bound(wo));
        Self { ggx, t, k, per_cap: R::splat(1.0) / (k * wo.z + t), gain }
    }

    /// Evaluates the reflection for `wi` above the surface.
    #[inline(always)]
    pub fn eval(&self, wo: Vec3x<R>, wi: Vec3x<R>) -> Reflection<R> {
        let (zero, one, half) = (R::splat(0.0), R::splat(1.0), R::splat(0.5));
        let h = wo + wi;
        let length = h.length();
        let seen = length.gt(zero);
        if !seen.any() {
            return Reflection { value: zero, pdf: zero, cos: zero };
        }
        let half_d = R::select(seen, half * self.ggx.d(h * (one / length)), zero);
        let value = self.gain * half_d / (self.t * wi.z + self.ggx.t(wi) * wo.z);
        // wo·m = |wo + wi|/2 for unit vectors: symmetric in wo and wi, and accurate at grazing angles.
        let cos = (half * length).min(one);
        Reflection { value: R::select(seen, value, zero), pdf: half_d * self.per_cap, cos }
    }

    /// Returns the density of reflected visible normals over that of bounded ones; 1 where `bounded`.
    #[inline(always)]
    pub fn visible_ratio(&self, wo: Vec3x<R>, bounded: R::Mask) -> R {
        let one = R::splat(1.0);
        R::select(bounded, one, one / (self.per_cap * (wo.z + self.t)))
    }

    /// Samples a visible normal, and whether there is one; where `bounded`, one that mostly reflects above the surface
    /// [Eto & Tokuyoshi 2023].
    #[inline(always)]
    pub fn facet(&self, wo: Vec3x<R>, u: Vec2x<R>, bounded: R::Mask) -> (Vec3x<R>, R::Mask) {
        self.ggx.sample_cap(wo, self.t, u, R::select(bounded, self.k, R::splat(1.0)))
    }
}
