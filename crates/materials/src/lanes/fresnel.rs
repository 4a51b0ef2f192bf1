//! Fresnel reflectance over lanes: the exact law for dielectrics, Schlick's *approximation* as specified by glTF, and
//! their combination as tinted by `KHR_materials_specular`.

use dapple_math::lanes::{Mask, Real, Vec3x};

/// Returns (1 − c)⁵ for c = |w·m| in 0..1: the weight of F90 over F0 in Schlick's *approximation* [Schlick 1994].
#[inline(always)]
pub fn schlick_weight<R: Real>(c: R) -> R {
    let one = R::splat(1.0);
    let x = (one - c).max(R::splat(0.0)).min(one);
    let x2 = x * x;
    x2 * x2 * x
}

/// Returns the reflectance at normal incidence ((η−1)/(η+1))², equal from both sides; 1 for η = 0.
#[inline(always)]
pub fn normal_reflectance<R: Real>(eta: R) -> R {
    let r = (eta - R::splat(1.0)) / (eta + R::splat(1.0));
    r * r
}

/// Returns the unpolarised reflectance of a dielectric interface. `c` is the cosine on the near side (0..1), `eta` the
/// far index over the near index (> 0). It is 1 under total internal reflection.
#[inline(always)]
pub fn dielectric<R: Real>(c: R, eta: R) -> R {
    let (ct, passes) = far_cosine(c, eta);
    R::select(passes, dielectric_between(c, ct, eta), R::splat(1.0))
}

/// As [`dielectric`] with the cosines on both sides given: r_s = (c − η cₜ)/(c + η cₜ), r_p = (η c − cₜ)/(η c + cₜ), F
/// = (r_s² + r_p²)/2. Well conditioned at every angle and the same from both sides.
#[inline(always)]
pub fn dielectric_between<R: Real>(c: R, ct: R, eta: R) -> R {
    let (g, e) = (eta * ct, eta * c);
    let (sum_s, sum_p) = (c + g, e + ct);
    let (s, p) = ((c - g) / sum_s, (e - ct) / sum_p);
    let seen = sum_s.gt(R::splat(0.0)) & sum_p.gt(R::splat(0.0));
    R::select(seen, R::splat(0.5) * (s * s + p * p), R::splat(1.0))
}

/// Snell's law for cosines: √((η−1)(η+1) + c²)/η, and whether light passes. Under total internal reflection it does
/// not, and the cosine is 0. The product keeps its precision near η = 1 and does not overflow for η < 1e9.
#[inline(always)]
pub fn far_cosine<R: Real>(c: R, eta: R) -> (R, R::Mask) {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let (g2, equal) = ((eta - one) * (eta + one) + c * c, eta.eq(one));
    let passes = g2.gt(zero);
    let ct = R::select(passes, g2.sqrt() / eta, zero);
    (R::select(equal, c, ct), passes | equal)
}

/// Returns the direction refracted at `m` (wo·m = c > 0), with cosine `ct` on the far side: wi = (c/η − cₜ) m − wo/η.
#[inline(always)]
pub fn refract<R: Real>(wo: Vec3x<R>, m: Vec3x<R>, c: R, ct: R, eta: R) -> Vec3x<R> {
    let inverse = R::splat(1.0) / eta;
    (m * (c * inverse - ct) - wo * inverse).normalize()
}

/// Schlick's F0 + (F90 − F0)(1 − c)⁵: reflectance of metals and of opaque dielectrics in glTF.
#[derive(Clone, Copy, Debug)]
pub struct Schlick<R> {
    /// Reflectance along the normal.
    pub f0: Vec3x<R>,
    /// Reflectance at grazing incidence.
    pub f90: R,
}

impl<R: Real> Schlick<R> {
    /// Returns F at c = |w·m|.
    #[inline(always)]
    pub fn at(self, c: R) -> Vec3x<R> {
        self.mix(schlick_weight(c))
    }

    /// Returns F0 + (F90 − F0)·s.
    #[inline(always)]
    pub fn mix(self, s: R) -> Vec3x<R> {
        let f90 = Vec3x::new(self.f90, self.f90, self.f90);
        self.f0 + (f90 - self.f0) * s
    }
}

/// Interface of a clear dielectric. What is not reflected is transmitted, so both lobes use this reflectance.
///
/// The exact F is scaled to the range from the F0 to the F90 of `specular`: F0 + (F90 − F0)(F − r0)/(1 − r0), which is
/// F itself for untinted dielectrics. A thin wall reflects at both faces: 2F/(1+F), the sum of all internal reflections
/// in the slab. (Taken literally, `KHR_materials_transmission` counts the first face only.)
#[derive(Clone, Copy, Debug)]
pub struct Interface<R: Real> {
    tint: Schlick<R>,
    /// Reflectance along the normal before tinting.
    r0: R,
    /// Index on the far side over that on the near side; 0 if only Schlick's law applies (glTF's `ior` 0).
    pub eta: R,
    /// Whether this is a thin wall with two faces.
    pub thin: R::Mask,
}

impl<R: Real> Interface<R> {
    /// `eta` is the far index over the near index as seen from `wo`, 0 for glTF's special case.
    #[inline(always)]
    pub fn new(tint: Schlick<R>, eta: R, thin: R::Mask) -> Self {
        // Matched indices: there is no interface. Refraction would divide by η − 1.
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let matched = (eta - one).abs().lt(R::splat(1e-4));
        let none = Vec3x::new(zero, zero, zero);
        let tint =
            Schlick { f0: Vec3x::select(matched, none, tint.f0), f90: R::select(matched, zero, tint.f90) };
        let eta = R::select(matched, one, eta);
        Self { tint, r0: normal_reflectance(eta), eta, thin }
    }

    /// Returns the same interface seen from the side of the lower index.
    #[inline(always)]
    pub fn from_thinner(&self) -> Self {
        let known = self.eta.gt(R::splat(0.0));
        let eta = R::select(known, self.eta.max(R::splat(1.0) / self.eta), self.eta);
        Self { eta, ..*self }
    }

    /// Whether transmitted light keeps its direction: thin walls, matched indices, and unknown indices.
    #[inline(always)]
    pub fn keeps_direction(&self) -> R::Mask {
        self.thin | self.eta.eq(R::splat(1.0)) | self.eta.eq(R::splat(0.0))
    }

    /// Whether roughness blurs the transmitted light.
    #[inline(always)]
    pub fn blurs(&self) -> R::Mask {
        self.thin | !self.keeps_direction()
    }

    /// Returns (η_i/η_o)² of transmitted light: 1 if light keeps its direction.
    #[inline(always)]
    pub fn eta_squared(&self) -> R {
        R::select(self.keeps_direction(), R::splat(1.0), self.eta * self.eta)
    }

    /// Returns the direction transmitted through a smooth interface, and whether light passes: it does not under total
    /// internal reflection.
    #[inline(always)]
    pub fn through(&self, wo: Vec3x<R>) -> (Vec3x<R>, R::Mask) {
        let keeps = self.keeps_direction();
        if keeps.all() {
            return (-wo, keeps);
        }
        let (ct, passes) = far_cosine(wo.z, self.eta);
        // As `refract` at the normal z, where the terms of wo.z cancel.
        let inverse = R::splat(1.0) / self.eta;
        let bent = Vec3x::new(-wo.x * inverse, -wo.y * inverse, -ct).normalize();
        (Vec3x::select(keeps, -wo, bent), keeps | passes)
    }

    /// Whether any light is reflected at any angle.
    #[inline(always)]
    pub fn reflects(&self) -> R::Mask {
        let zero = R::splat(0.0);
        self.tint.f90.gt(zero) | (self.eta.gt(zero) & self.eta.lt(R::splat(1.0)))
    }

    /// Returns the reflectance at c = wo·m on the near side, per channel.
    #[inline(always)]
    pub fn reflectance(&self, c: R) -> Vec3x<R> {
        let (ct, passes) = far_cosine(c, self.eta);
        // Total internal reflection is complete, whatever the tint. An unknown index knows none.
        let total = !(passes | self.eta.eq(R::splat(0.0)));
        let all = Vec3x::splat(glam::Vec3::ONE);
        if total.all() {
            return all;
        }
        Vec3x::select(total, all, self.reflectance_between(c, ct))
    }

    /// As [`Self::reflectance`] with the cosines on both sides given: symmetric in the two sides.
    #[inline(always)]
    pub fn reflectance_between(&self, c: R, ct: R) -> Vec3x<R> {
        let exact = dielectric_between(c, ct, self.eta);
        let mut s = (exact - self.r0) / (R::splat(1.0) - self.r0);
        let unknown = self.eta.eq(R::splat(0.0));
        if unknown.any() {
            s = R::select(unknown, schlick_weight(c), s);
        }
        let (zero, one) = (R::splat(0.0), Vec3x::splat(glam::Vec3::ONE));
        let f = self.tint.mix(s).max(Vec3x::new(zero, zero, zero)).min(one);
        if !self.thin.any() {
            return f;
        }
        // Both faces.
        let two = f * R::splat(2.0);
        let sum = f + one;
        let slab = Vec3x::new(two.x / sum.x, two.y / sum.y, two.z / sum.z);
        Vec3x::select(self.thin, slab, f)
    }

    /// Returns the transmittance: 1 − the largest channel of the reflectance, grey as `KHR_materials_specular`
    /// requires, so that a tinted reflection does not tint the transmitted light with the complementary colour.
    #[inline(always)]
    pub fn transmittance(&self, c: R) -> R {
        R::splat(1.0) - self.reflectance(c).max_element()
    }
}
