//! Fresnel reflectance of smooth interfaces: the exact law for dielectrics, Schlick's *approximation* as specified by
//! glTF, and their combination as tinted by `KHR_materials_specular`.

use glam::Vec3;

/// (1 − c)⁵ for c = |w·m| in 0..1: the weight of F90 over F0 in Schlick's *approximation* [Schlick 1994].
pub fn schlick_weight(c: f32) -> f32 {
    let x = (1.0 - c).clamp(0.0, 1.0);
    let x2 = x * x;
    x2 * x2 * x
}

/// Reflectance at normal incidence ((η−1)/(η+1))², equal from both sides; 1 for η = 0 (`KHR_materials_ior`).
pub fn normal_reflectance(eta: f32) -> f32 {
    let r = (eta - 1.0) / (eta + 1.0);
    r * r
}

/// Unpolarised reflectance of a dielectric interface. `c` is the cosine on the near side (0..1), `eta` the far index
/// over the near index (> 0). 1 under total internal reflection.
pub fn dielectric(c: f32, eta: f32) -> f32 {
    far_cosine(c, eta).map_or(1.0, |ct| dielectric_between(c, ct, eta))
}

/// As [`dielectric`] with the cosines on both sides given: r_s = (c − η cₜ)/(c + η cₜ), r_p = (η c − cₜ)/(η c + cₜ), F
/// = (r_s² + r_p²)/2. Well conditioned at every angle and the same from both sides.
pub fn dielectric_between(c: f32, ct: f32, eta: f32) -> f32 {
    let (g, e) = (eta * ct, eta * c);
    if c + g <= 0.0 || e + ct <= 0.0 {
        return 1.0;
    }
    let (s, p) = ((c - g) / (c + g), (e - ct) / (e + ct));
    0.5 * (s * s + p * p)
}

/// Snell's law for cosines: √((η−1)(η+1) + c²)/η; `None` under total internal reflection. The product keeps its
/// precision near η = 1 and does not overflow for η < 1e9.
pub fn far_cosine(c: f32, eta: f32) -> Option<f32> {
    if eta == 1.0 {
        return Some(c);
    }
    let g2 = (eta - 1.0) * (eta + 1.0) + c * c;
    (g2 > 0.0).then(|| g2.sqrt() / eta)
}

/// Direction refracted at `m` (wo·m = c > 0), with cosine `ct` on the far side: wi = (c/η − cₜ) m − wo/η.
pub fn refract(wo: Vec3, m: Vec3, c: f32, ct: f32, eta: f32) -> Vec3 {
    (m * (c / eta - ct) - wo / eta).normalize()
}

/// Schlick's F0 + (F90 − F0)(1 − c)⁵: reflectance of metals and of opaque dielectrics in glTF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schlick {
    /// Reflectance along the normal.
    pub f0: Vec3,
    /// Reflectance at grazing incidence.
    pub f90: f32,
}

impl Schlick {
    /// F at c = |w·m|.
    pub fn at(self, c: f32) -> Vec3 {
        self.f0 + (Vec3::splat(self.f90) - self.f0) * schlick_weight(c)
    }
}

/// Interface of a clear dielectric. What is not reflected is transmitted, so both lobes use this reflectance.
///
/// The exact F is scaled to the range from the F0 to the F90 of `specular`: F0 + (F90 − F0)(F − r0)/(1 − r0), which is
/// F itself for untinted dielectrics. A thin wall reflects at both faces: 2F/(1+F), the sum of all internal reflections
/// in the slab. (Taken literally, `KHR_materials_transmission` counts the first face only.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    tint: Schlick,
    /// Reflectance along the normal before tinting.
    r0: f32,
    /// Index on the far side over that on the near side; 0 if only Schlick's law applies (glTF's `ior` 0).
    pub eta: f32,
    /// Whether this is a thin wall with two faces.
    pub thin: bool,
}

impl Interface {
    /// `eta` is the far index over the near index as seen from `wo`, 0 for glTF's special case.
    pub fn new(tint: Schlick, eta: f32, thin: bool) -> Self {
        if (eta - 1.0).abs() < 1e-4 {
            // Matched indices: there is no interface. Refraction would divide by η − 1.
            return Self { tint: Schlick { f0: Vec3::ZERO, f90: 0.0 }, r0: 0.0, eta: 1.0, thin };
        }
        Self { tint, r0: normal_reflectance(eta), eta, thin }
    }

    /// The same interface seen from the side of the lower index.
    pub fn from_thinner(&self) -> Self {
        let eta = if self.eta > 0.0 { self.eta.max(1.0 / self.eta) } else { self.eta };
        Self { eta, ..*self }
    }

    /// Whether transmitted light keeps its direction: thin walls, matched indices, and unknown indices.
    pub fn keeps_direction(&self) -> bool {
        self.thin || self.eta == 1.0 || self.eta == 0.0
    }

    /// Whether roughness blurs the transmitted light.
    pub fn blurs(&self) -> bool {
        self.thin || !self.keeps_direction()
    }

    /// (η_i/η_o)² of transmitted light: 1 if light keeps its direction.
    pub fn eta_squared(&self) -> f32 {
        if self.keeps_direction() { 1.0 } else { self.eta * self.eta }
    }

    /// Direction transmitted through a smooth interface; `None` under total internal reflection.
    pub fn through(&self, wo: Vec3) -> Option<Vec3> {
        if self.keeps_direction() {
            return Some(-wo);
        }
        far_cosine(wo.z, self.eta).map(|ct| refract(wo, Vec3::Z, wo.z, ct, self.eta))
    }

    /// Whether any light is reflected at any angle.
    pub fn reflects(&self) -> bool {
        self.tint.f90 > 0.0 || (self.eta > 0.0 && self.eta < 1.0)
    }

    /// Reflectance at c = wo·m on the near side, per channel.
    pub fn reflectance(&self, c: f32) -> Vec3 {
        if self.eta == 0.0 {
            return self.faces(self.tint.at(c));
        }
        match far_cosine(c, self.eta) {
            Some(ct) => self.reflectance_between(c, ct),
            // Total internal reflection is complete, whatever the tint.
            None => Vec3::ONE,
        }
    }

    /// As [`Self::reflectance`] with the cosines on both sides given: symmetric in the two sides.
    pub fn reflectance_between(&self, c: f32, ct: f32) -> Vec3 {
        if self.eta == 0.0 {
            return self.reflectance(c);
        }
        let exact = dielectric_between(c, ct, self.eta);
        let s = (exact - self.r0) / (1.0 - self.r0);
        self.faces(
            (self.tint.f0 + (Vec3::splat(self.tint.f90) - self.tint.f0) * s).clamp(Vec3::ZERO, Vec3::ONE),
        )
    }

    /// Reflectance of all faces, given that of one.
    fn faces(&self, f: Vec3) -> Vec3 {
        if self.thin { f * 2.0 / (f + Vec3::ONE) } else { f }
    }

    /// Transmittance: 1 − the largest channel of the reflectance, grey as `KHR_materials_specular` requires, so that a
    /// tinted reflection does not tint the transmitted light with the complementary colour.
    pub fn transmittance(&self, c: f32) -> f32 {
        1.0 - self.reflectance(c).max_element()
    }
}
