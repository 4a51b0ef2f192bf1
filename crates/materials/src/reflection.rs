//! Rough specular reflection of metals, coats and clear dielectrics in one lobe: they share the roughness, and every
//! Fresnel law is linear in its share, so that a blend of materials is a blend of F.
//!
//! f = F(wo·m) D(m) G2(wo,wi) / (4 wo.z wi.z), m = normalise(wo + wi) [Walter 2007, eq. 20]. Scattering is single:
//! light that is reflected more than once between facets is lost (docs/science.md, "GGX").

use crate::microfacet::Ggx;
use glam::{Vec2, Vec3};

/// A rough surface for one `wo`, with the values that depend on `wo` alone.
#[derive(Clone, Copy, Debug)]
pub struct Rough {
    /// The distribution of normals.
    pub ggx: Ggx,
    /// t(wo).
    t: f32,
    /// Bound of the spherical cap.
    k: f32,
    /// Factor of every value; 1 unless set by [`Self::losing_as`].
    gain: f32,
}

impl Rough {
    /// Builds the surface for `wo` above it.
    pub fn new(ggx: Ggx, wo: Vec3) -> Self {
        Self { ggx, t: ggx.t(wo), k: ggx.cap_bound(wo), gain: 1.0 }
    }

    /// Replaces the energy loss of single scattering by the loss at another angle: every value is multiplied by `gain`,
    /// the ratio of the albedos without the Fresnel term.
    pub fn losing_as(self, gain: f32) -> Self {
        Self { gain, ..self }
    }

    /// Factor of every value.
    pub fn gain(&self) -> f32 {
        self.gain
    }

    /// The stretched length t(wo), see [`Ggx::t`].
    pub fn t(&self) -> f32 {
        self.t
    }

    /// Returns D·G2/(4 cos cos), the pdf of the direction reflected at [`Self::bounded_facet`], and c = wo·m, for wi
    /// above the surface.
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> (f32, f32, f32) {
        let h = wo + wi;
        let length = h.length();
        if length == 0.0 {
            return (0.0, 0.0, 0.0);
        }
        let half_d = 0.5 * self.ggx.d(h / length);
        let value = self.gain * half_d / (self.t * wi.z + self.ggx.t(wi) * wo.z);
        // wo·m = |wo + wi|/2 for unit vectors: symmetric in wo and wi, and accurate at grazing angles.
        (value, half_d / (self.k * wo.z + self.t), (0.5 * length).min(1.0))
    }

    /// Density of reflected visible normals over that of bounded ones; 1 if `bounded`.
    pub fn visible_ratio(&self, wo: Vec3, bounded: bool) -> f32 {
        if bounded { 1.0 } else { (self.k * wo.z + self.t) / (wo.z + self.t) }
    }

    /// Samples a visible normal that mostly reflects above the surface [Eto & Tokuyoshi 2023].
    pub fn bounded_facet(&self, wo: Vec3, u: Vec2) -> Option<Vec3> {
        self.ggx.sample_bounded(wo, u, self.k)
    }
}
