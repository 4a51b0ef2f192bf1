//! Microfacet distribution of rough surfaces and its shadowing, over lanes: GGX (Trowbridge–Reitz) with the
//! height-correlated Smith shadowing of [Heitz 2014].
//!
//! Conventions: directions are in the local frame, with `wo`, `wi` at z ≥ 0 (transmission uses |z|, since Λ is even);
//! `alpha` = roughness². Shadowing is never divided by a cosine: with the *stretched length*
//! t(w) = √(αx²wx² + αy²wy² + wz²) = wz(1 + 2Λ(w)), G1 = 2wz/(wz + t) and
//! G2(wo,wi)/(4 wo.z wi.z) = 1/(2(t(wo)wi.z + t(wi)wo.z)), both finite down to and including grazing directions.
//! cosθ_m enters only through the components of m, never as 1 − cos².

use dapple_math::lanes::{Real, Vec2x, Vec3x, sin_cos};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Values of α below this are treated as smooth (a delta lobe). *Approximation*: at α = 1e-3 the lobe is 0.1° wide.
pub const SMOOTH_ALPHA: f32 = 1e-3;

/// A GGX surface. Both widths are at least [`SMOOTH_ALPHA`]; the lobes currently use equal ones.
#[derive(Clone, Copy, Debug)]
pub struct Ggx<R> {
    /// α along x.
    pub ax: R,
    /// α along y.
    pub ay: R,
}

impl<R: Real> Ggx<R> {
    /// Returns the isotropic distribution of width `alpha`, or of the smallest width if that is less.
    #[inline(always)]
    pub fn isotropic(alpha: R) -> Self {
        let alpha = alpha.max(R::splat(SMOOTH_ALPHA));
        Self { ax: alpha, ay: alpha }
    }

    /// Returns D(m) = 1 / (π αx αy ((mx/αx)² + (my/αy)² + mz²)²), the density of normals per solid angle about the unit
    /// normal `m`; 0 for m in or below the surface.
    #[inline(always)]
    pub fn d(self, m: Vec3x<R>) -> R {
        // With p = αx αy, the sum is e/p² and D = p (p/e)²/π: a single division.
        let p = self.ax * self.ay;
        let (x, y, z) = (m.x * self.ay, m.y * self.ax, m.z * p);
        let q = p / (x * x + y * y + z * z);
        R::select(m.z.gt(R::splat(0.0)), R::splat(FRAC_1_PI) * p * (q * q), R::splat(0.0))
    }

    /// Returns the stretched length t(w) = |wz|(1 + 2Λ(w)); positive for every unit w.
    #[inline(always)]
    pub fn t(self, w: Vec3x<R>) -> R {
        let (x, y) = (self.ax * w.x, self.ay * w.y);
        (x * x + y * y + w.z * w.z).sqrt()
    }

    /// Returns Smith's masking: the fraction of the normals facing `w` that is visible from it.
    #[inline(always)]
    pub fn g1(self, w: Vec3x<R>) -> R {
        let z = w.z.abs();
        R::splat(2.0) * z / (z + self.t(w))
    }

    /// Returns the density of the normals of [`Self::sample_cap`] with k = 1, per solid angle about `m`, given `cos` =
    /// wo·m: D_v(m) = D(m) G1(wo) (wo·m)₊ / wo.z.
    #[inline(always)]
    pub fn visible_pdf(self, wo: Vec3x<R>, m: Vec3x<R>, cos: R) -> R {
        R::splat(2.0) * self.d(m) * cos.max(R::splat(0.0)) / (wo.z + self.t(wo))
    }

    /// Returns the density of the *reflected* direction if m comes from [`Self::sample_cap`]: D(m) / (2(k wo.z +
    /// t(wo))).
    #[inline(always)]
    pub fn bounded_pdf(self, wo: Vec3x<R>, m: Vec3x<R>, k: R) -> R {
        self.d(m) / (R::splat(2.0) * (k * wo.z + self.t(wo)))
    }

    /// Returns the bound of the spherical cap: k = (1−a²)s²/(s² + a²wo.z²), s = 1 + |wo.xy|, a = min(αx, αy, 1)
    /// [Tokuyoshi & Eto 2024].
    #[inline(always)]
    pub fn cap_bound(self, wo: Vec3x<R>) -> R {
        let one = R::splat(1.0);
        let a = self.ax.min(self.ay).min(one);
        let s = one + (wo.x * wo.x + wo.y * wo.y).sqrt();
        let (a2, s2) = (a * a, s * s);
        (one - a2) * s2 / (s2 + a2 * wo.z * wo.z)
    }

    /// Samples a normal visible from `wo`, and whether it is representable (does not lie in the surface): a point that
    /// is uniform on the cap z ∈ (−k w.z, 1] about the stretched direction w, mapped back to the ellipsoid [Dupuy &
    /// Benyoub 2023]. `t` is t(wo). For k = 1 the density is [`Self::visible_pdf`]. For k = [`Self::cap_bound`] fewer
    /// reflected directions fall below the surface [Tokuyoshi & Eto 2024].
    #[inline(always)]
    pub fn sample_cap(self, wo: Vec3x<R>, t: R, u: Vec2x<R>, k: R) -> (Vec3x<R>, R::Mask) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let w = Vec3x::new(self.ax * wo.x, self.ay * wo.y, wo.z) * (one / t);
        let b = k * w.z;
        let z = (one - u.y) * (one + b) - b;
        let s = ((one - z) * (one + z)).max(zero).sqrt();
        let (sin, cos) = sin_cos(R::splat(TAU) * u.x);
        let h = Vec3x::new(s * cos + w.x, s * sin + w.y, (z + w.z).max(zero));
        let m = Vec3x::new(self.ax * h.x, self.ay * h.y, h.z);
        unit(m)
    }
}

/// Returns the vector divided by its length, and whether that is possible: the length is neither 0, infinite nor NaN.
#[inline(always)]
pub fn unit<R: Real>(v: Vec3x<R>) -> (Vec3x<R>, R::Mask) {
    let inverse = R::splat(1.0) / v.length();
    (v * inverse, inverse.is_finite() & inverse.gt(R::splat(0.0)))
}

/// Returns the unit direction of `wo` reflected about the normal `m`.
#[inline(always)]
pub fn reflect<R: Real>(wo: Vec3x<R>, m: Vec3x<R>) -> Vec3x<R> {
    (m * (R::splat(2.0) * wo.dot(m)) - wo).normalize()
}
