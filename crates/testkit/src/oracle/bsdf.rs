//! BSDFs by their textbook formulas, in the local frame with wo.z > 0. Values do not contain the cosine.

use glam::DVec3;
use std::f64::consts::PI;

/// Returns the GGX distribution D(m) = α² / (π cos⁴θ (α² + tan²θ)²) [Walter 2007, eq. 33].
pub fn d(m: DVec3, alpha: f64) -> f64 {
    if m.z <= 0.0 {
        return 0.0;
    }
    let (tan2, a2) = ((m.x * m.x + m.y * m.y) / (m.z * m.z), alpha * alpha);
    a2 / (PI * m.z.powi(4) * (a2 + tan2).powi(2))
}

/// Returns Λ(w) = (−1 + √(1 + α² tan²θ)) / 2 [Heitz 2014, eq. 72], computed without cancellation.
pub fn lambda(w: DVec3, alpha: f64) -> f64 {
    let x = alpha * alpha * (w.x * w.x + w.y * w.y) / (w.z * w.z);
    0.5 * x / (1.0 + (1.0 + x).sqrt())
}

/// Returns the Smith masking function.
pub fn g1(w: DVec3, alpha: f64) -> f64 {
    1.0 / (1.0 + lambda(w, alpha))
}

/// Returns the height-correlated Smith masking-shadowing function [Heitz 2014, eq. 99].
pub fn g2(wo: DVec3, wi: DVec3, alpha: f64) -> f64 {
    1.0 / (1.0 + lambda(wo, alpha) + lambda(wi, alpha))
}

/// Returns the density of visible normals G1 D (wo·m)₊ / cosθ_o [Heitz 2014, eq. 16].
pub fn visible(wo: DVec3, m: DVec3, alpha: f64) -> f64 {
    g1(wo, alpha) * d(m, alpha) * wo.dot(m).max(0.0) / wo.z
}

/// Returns the unpolarized Fresnel reflectance with Snell's law. `eta` is the index of refraction of the far side
/// divided by that of the near side.
pub fn fresnel(c: f64, eta: f64) -> f64 {
    let squared = (eta - 1.0) * (eta + 1.0) + c * c;
    if squared <= 0.0 {
        return 1.0;
    }
    let ct = squared.sqrt() / eta;
    let (s, p) = ((c - eta * ct) / (c + eta * ct), (eta * c - ct) / (eta * c + ct));
    0.5 * (s * s + p * p)
}

/// Returns the Cook–Torrance BRDF with F = 1: D G2 / (4 cos cos).
pub fn reflection(wo: DVec3, wi: DVec3, alpha: f64) -> f64 {
    d((wo + wi).normalize(), alpha) * g2(wo, wi, alpha) / (4.0 * wo.z * wi.z)
}

/// Returns the half vector of refraction [Walter 2007, eq. 16] on the side of wo, or None if no facet connects the two
/// directions.
pub fn refracting(wo: DVec3, wi: DVec3, eta: f64) -> Option<DVec3> {
    let h = (wo + wi * eta).normalize();
    let m = if h.z < 0.0 { -h } else { h };
    (wo.dot(m) > 0.0 && wi.dot(m) < 0.0).then_some(m)
}

/// Returns the BTDF of Walter for radiance, with wi.z < 0:
/// |wo·m||wi·m| (1−F) D G2 η_o² / (|cos cos| (η_o wo·m + η_i wi·m)²) [Walter 2007, eq. 21, for radiance].
pub fn refraction(wo: DVec3, wi: DVec3, alpha: f64, eta: f64) -> f64 {
    let Some(m) = refracting(wo, wi, eta) else { return 0.0 };
    let (co, ci) = (wo.dot(m), -wi.dot(m));
    let t = 1.0 - fresnel(co, eta);
    co * ci * t * d(m, alpha) * g2(wo, DVec3::new(wi.x, wi.y, -wi.z), alpha)
        / (wo.z * -wi.z * (co - eta * ci).powi(2))
}

/// Returns the density of refraction at a visible facet: (1 − F) D_v η_i²|wi·m| / (η_o wo·m + η_i wi·m)²
/// [Walter 2007, eq. 17].
pub fn refraction_pdf(wo: DVec3, wi: DVec3, alpha: f64, eta: f64) -> f64 {
    let Some(m) = refracting(wo, wi, eta) else { return 0.0 };
    let (co, ci) = (wo.dot(m), -wi.dot(m));
    (1.0 - fresnel(co, eta)) * visible(wo, m, alpha) * eta * eta * ci / (co - eta * ci).powi(2)
}

/// Returns the density of reflection at a visible facet: F D_v / (4 wo·m).
pub fn reflection_pdf(wo: DVec3, wi: DVec3, alpha: f64, eta: f64) -> f64 {
    let m = (wo + wi).normalize();
    fresnel(wo.dot(m), eta) * visible(wo, m, alpha) / (4.0 * wo.dot(m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn visible_normals_are_all_of_them() {
        for (mu, alpha) in [(1.0f64, 0.5), (0.3, 0.2), (0.1, 1.0)] {
            let wo = DVec3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
            let sum = crate::quadrature::hemisphere(|m| visible(wo, m, alpha), 1e-7);
            assert!((sum - 1.0).abs() < 1e-5, "{mu} {alpha} {sum}");
        }
        assert!((fresnel(1.0, 1.5) - 0.04).abs() < 1e-15 && fresnel(0.2, 1.0 / 1.5) == 1.0);
    }
}
