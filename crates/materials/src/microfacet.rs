//! Microfacet distribution of rough surfaces and its shadowing: GGX (Trowbridge–Reitz) with the height-correlated Smith
//! shadowing of [Heitz 2014]. The formulas and their conventions are those of [`crate::lanes::Ggx`], for one direction.

use crate::lanes;
use glam::{Vec2, Vec3};

pub use crate::lanes::SMOOTH_ALPHA;

/// A GGX surface. Both widths are at least [`SMOOTH_ALPHA`]; the lobes currently use equal ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// α along x.
    pub ax: f32,
    /// α along y.
    pub ay: f32,
}

impl Ggx {
    /// The isotropic distribution of width `alpha`; `None` below [`SMOOTH_ALPHA`].
    pub fn isotropic(alpha: f32) -> Option<Self> {
        (alpha >= SMOOTH_ALPHA).then_some(Self { ax: alpha, ay: alpha })
    }

    fn lane(self) -> lanes::Ggx<f32> {
        lanes::Ggx { ax: self.ax, ay: self.ay }
    }

    /// D(m) = 1 / (π αx αy ((mx/αx)² + (my/αy)² + mz²)²), the density of normals per solid angle; 0 for m below the
    /// surface.
    pub fn d(self, m: Vec3) -> f32 {
        self.lane().d(m.into())
    }

    /// Stretched length t(w) = |wz|(1 + 2Λ(w)); positive for every unit w.
    pub fn t(self, w: Vec3) -> f32 {
        self.lane().t(w.into())
    }

    /// Smith masking: the fraction of the normals facing `w` that is visible from it.
    pub fn g1(self, w: Vec3) -> f32 {
        self.lane().g1(w.into())
    }

    /// Samples a normal visible from `wo`, with density D_v(m) = D(m) G1(wo) (wo·m)₊ / wo.z, by a cap of the sphere
    /// [Dupuy & Benyoub 2023]. `None` if the normal is not representable (lies in the surface).
    pub fn sample_visible(self, wo: Vec3, u: Vec2) -> Option<Vec3> {
        self.sample_bounded(wo, u, 1.0)
    }

    /// Density of [`Self::sample_visible`] per solid angle about `m`, given `cos` = wo·m.
    pub fn visible_pdf(self, wo: Vec3, m: Vec3, cos: f32) -> f32 {
        self.lane().visible_pdf(wo.into(), m.into(), cos)
    }

    /// As [`Self::sample_visible`], for reflection: the cap is bounded so that fewer reflected directions fall below
    /// the surface [Tokuyoshi & Eto 2024]. `k` is [`Self::cap_bound`] of `wo`.
    pub fn sample_bounded(self, wo: Vec3, u: Vec2, k: f32) -> Option<Vec3> {
        let (m, found) = self.lane().sample_cap(wo.into(), self.t(wo), u.into(), k);
        found.then_some(m.into())
    }

    /// Density of the *reflected* direction if m comes from [`Self::sample_bounded`]: D(m) / (2(k wo.z + t(wo))).
    pub fn bounded_pdf(self, wo: Vec3, m: Vec3, k: f32) -> f32 {
        self.lane().bounded_pdf(wo.into(), m.into(), k)
    }

    /// Bound of the spherical cap: k = (1−a²)s²/(s² + a²wo.z²), s = 1 + |wo.xy|, a = min(αx, αy, 1) [Tokuyoshi & Eto
    /// 2024].
    pub fn cap_bound(self, wo: Vec3) -> f32 {
        self.lane().cap_bound(wo.into())
    }
}

/// Unit direction of `wo` reflected about the normal `m`.
pub fn reflect(wo: Vec3, m: Vec3) -> Vec3 {
    lanes::reflect::<f32>(wo.into(), m.into()).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WO: Vec3 = Vec3::new(0.48, 0.36, 0.8);

    #[test]
    fn g1_is_one_over_one_plus_lambda() {
        let ggx = Ggx { ax: 0.3, ay: 0.7 };
        let tan2 = (0.3f32 * WO.x / WO.z).powi(2) + (0.7 * WO.y / WO.z).powi(2);
        let lambda = 0.5 * ((1.0 + tan2).sqrt() - 1.0);
        assert!((ggx.g1(WO) * (1.0 + lambda) - 1.0).abs() < 1e-6);
        assert!((ggx.t(WO) - WO.z * (1.0 + 2.0 * lambda)).abs() < 1e-6);
        assert_eq!(ggx.g1(-WO), ggx.g1(WO));
    }

    #[test]
    fn bounded_normals_are_visible_ones_at_k_one() {
        let ggx = Ggx { ax: 0.3, ay: 0.7 };
        let u = Vec2::new(0.3, 0.9);
        assert_eq!(ggx.sample_bounded(WO, u, 1.0), ggx.sample_visible(WO, u));
        let m = ggx.sample_visible(WO, u).expect("a normal");
        let cos = WO.dot(m);
        let reflected = ggx.visible_pdf(WO, m, cos) / (4.0 * cos);
        assert!((ggx.bounded_pdf(WO, m, 1.0) / reflected - 1.0).abs() < 1e-6);
        assert!(ggx.cap_bound(WO) < 1.0 && ggx.cap_bound(WO) > 0.0);
    }

    #[test]
    fn the_smoothest_rough_surface() {
        assert!(Ggx::isotropic(0.999e-3).is_none());
        let ggx = Ggx::isotropic(1e-3).expect("rough");
        assert!((ggx.d(Vec3::Z) * 1e-6 * std::f32::consts::PI - 1.0).abs() < 1e-5);
        assert_eq!(ggx.d(-Vec3::Z), 0.0);
    }
}
