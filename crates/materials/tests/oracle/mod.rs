//! Reference implementation of the lobes in f64, from the textbook formulas rather than from the rearranged ones of the
//! crate.
#![allow(dead_code)]

use dapple_testkit::quadrature;
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// GGX: D(m) = α² / (π cos⁴θ (α² + tan²θ)²) [Walter 2007, eq. 33].
pub fn d(m: DVec3, alpha: f64) -> f64 {
    if m.z <= 0.0 {
        return 0.0;
    }
    let tan2 = (m.x * m.x + m.y * m.y) / (m.z * m.z);
    let a2 = alpha * alpha;
    a2 / (PI * m.z.powi(4) * (a2 + tan2).powi(2))
}

/// Λ(w) = (−1 + √(1 + α² tan²θ)) / 2 [Heitz 2014, eq. 72].
pub fn lambda(w: DVec3, alpha: f64) -> f64 {
    let x = alpha * alpha * (w.x * w.x + w.y * w.y) / (w.z * w.z);
    0.5 * x / (1.0 + (1.0 + x).sqrt())
}

/// Height-correlated Smith shadowing of two directions [Heitz 2014, eq. 99].
pub fn g2(wo: DVec3, wi: DVec3, alpha: f64) -> f64 {
    1.0 / (1.0 + lambda(wo, alpha) + lambda(wi, alpha))
}

/// F0 + (F90 − F0)(1 − c)⁵.
pub fn schlick(f0: f64, f90: f64, c: f64) -> f64 {
    f0 + (f90 - f0) * (1.0 - c).powi(5)
}

/// Fresnel's equations with Snell's law.
pub fn fresnel(c: f64, eta: f64) -> f64 {
    let sin_t = (1.0 - c * c).sqrt() / eta;
    if sin_t >= 1.0 {
        return 1.0;
    }
    let ct = (1.0 - sin_t * sin_t).sqrt();
    let s = (c - eta * ct) / (c + eta * ct);
    let p = (eta * c - ct) / (eta * c + ct);
    0.5 * (s * s + p * p)
}

/// Cook–Torrance: F D G2 / (4 cos cos).
pub fn reflection(wo: DVec3, wi: DVec3, alpha: f64, f: impl Fn(f64) -> f64) -> f64 {
    let m = (wo + wi).normalize();
    f(wo.dot(m)) * d(m, alpha) * g2(wo, wi, alpha) / (4.0 * wo.z * wi.z)
}

/// Walter's refraction for radiance, wi.z < 0, eta = index at wi over index at wo:
/// |wo·m||wi·m| (1−F) D G2 η_o² / (|cos cos| (η_o wo·m + η_i wi·m)²) with the half vector of [Walter 2007, eq. 16].
pub fn refraction(wo: DVec3, wi: DVec3, alpha: f64, eta: f64, t: impl Fn(f64) -> f64) -> f64 {
    let h = -(wo + wi * eta);
    let m = if h.z < 0.0 { -h.normalize() } else { h.normalize() };
    let (co, ci) = (wo.dot(m), wi.dot(m));
    if co <= 0.0 || ci >= 0.0 {
        return 0.0;
    }
    let up = DVec3::new(wi.x, wi.y, -wi.z);
    co * -ci * t(co) * d(m, alpha) * g2(wo, up, alpha) / (wo.z * up.z * (co + eta * ci).powi(2))
}

/// ∫ g(m) D(m) mz dm over the hemisphere, with m sampled from D·mz.
pub fn over_normals(alpha: f64, tolerance: f64, mut g: impl FnMut(DVec3) -> f64) -> f64 {
    quadrature::rectangle(|u, v| g(normal(alpha, u, v)), [0.0, 0.0], [1.0, 1.0], tolerance)
}

/// As [`over_normals`] for a g with f32 noise: the result of 3000 regions, and an upper bound of its error.
pub fn over_normals_roughly(alpha: f64, mut g: impl FnMut(DVec3) -> f64) -> (f64, f64) {
    let integrand = |u, v| g(normal(alpha, u, v));
    let result = quadrature::adaptive_plane(integrand, [0.0, 0.0], [1.0, 1.0], 1e-5, 0.0, 3000);
    (result.value, result.error)
}

/// tanθ = α√(u/(1−u)), over half of the circle, since all integrands are mirror symmetric.
fn normal(alpha: f64, u: f64, v: f64) -> DVec3 {
    let tan = alpha * (u / (1.0 - u)).sqrt();
    let cos = 1.0 / (1.0 + tan * tan).sqrt();
    let phi = PI * v;
    DVec3::new(tan * cos * phi.cos(), tan * cos * phi.sin(), cos)
}

/// Directional albedo of the reflecting lobe, wo in the xz plane.
pub fn albedo(wo: DVec3, alpha: f64, tolerance: f64, f: impl Fn(f64) -> f64) -> f64 {
    over_normals(alpha, tolerance, |m| {
        let c = wo.dot(m);
        let wi = 2.0 * c * m - wo;
        if c <= 0.0 || wi.z <= 0.0 { 0.0 } else { f(c) * g2(wo, wi, alpha) * c / (wo.z * m.z) }
    })
}

/// Direction in the xz plane with cosine `mu`.
pub fn tilted(mu: f64) -> DVec3 {
    DVec3::new((1.0 - mu * mu).sqrt(), 0.0, mu)
}

/// As [`tilted`], rotated about z.
pub fn turned(mu: f64, phi: f64) -> DVec3 {
    let s = (1.0 - mu * mu).sqrt();
    DVec3::new(s * phi.cos(), s * phi.sin(), mu)
}

/// The nearest f32 direction.
pub fn f32(w: DVec3) -> Vec3 {
    w.as_vec3()
}

/// A random direction of the upper hemisphere from two numbers.
pub fn upper(u: f64, v: f64) -> DVec3 {
    turned(u, TAU * v)
}
