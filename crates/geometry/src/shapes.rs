//! Exact spheres and disks: surfaces for every ray, not meshes.

use crate::offset::gamma;
use crate::{Hit, Ray, Surface};
use glam::Vec3;

/// All points at `radius` from `centre`; the front is outward.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    /// Centre.
    pub centre: Vec3,
    /// Radius, positive.
    pub radius: f32,
}

/// Flat disk facing `normal`.
#[derive(Clone, Copy, Debug)]
pub struct Disk {
    /// Centre.
    pub centre: Vec3,
    /// Unit normal of the front.
    pub normal: Vec3,
    /// Radius, positive.
    pub radius: f32,
}

/// One of the exact surfaces.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// A sphere.
    Sphere(Sphere),
    /// A disk.
    Disk(Disk),
}

impl Shape {
    /// Distances along the ray, near first; none below or at 0 within rounding.
    pub(crate) fn intersect(&self, ray: &Ray) -> [Option<f32>; 2] {
        match self {
            Self::Sphere(s) => s.intersect(ray),
            Self::Disk(d) => [d.intersect(ray), None],
        }
    }

    pub(crate) fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        match self {
            Self::Sphere(s) => s.surface(ray, hit.t),
            Self::Disk(d) => d.surface(ray, hit.t),
        }
    }

    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        let (c, r) = match self {
            Self::Sphere(s) => (s.centre, Vec3::splat(s.radius)),
            Self::Disk(d) => {
                (d.centre, (Vec3::ONE - d.normal * d.normal).max(Vec3::ZERO).map(f32::sqrt) * d.radius)
            }
        };
        (c - r, c + r)
    }
}

impl Sphere {
    /// Roots in f64, where the f32 inputs are exact: no cancellation at any distance or size that f32 can state
    /// [Haines, Günther, Akenine-Möller 2019 treat the f32 case].
    fn intersect(&self, ray: &Ray) -> [Option<f32>; 2] {
        let f = (ray.o - self.centre).as_dvec3();
        let f = if f.is_finite() { ray.o.as_dvec3() - self.centre.as_dvec3() } else { f };
        let d = ray.d.as_dvec3();
        let r = f64::from(self.radius);
        let (a, b) = (d.length_squared(), -f.dot(d));
        let closest = f + d * (b / a);
        let discriminant = r * r - closest.length_squared();
        if !(discriminant >= 0.0) || a == 0.0 {
            return [None, None];
        }
        let q = b + (a * discriminant).sqrt().copysign(b);
        let c = (f.length() - r) * (f.length() + r);
        let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (c / q, q / a) };
        let (near, far) = if t0 < t1 { (t0, t1) } else { (t1, t0) };
        let count = |t: f64| (t > 0.0 && (t as f32) > 0.0 && (t as f32) < ray.t_max).then_some(t as f32);
        [count(near), count(far)]
    }

    /// The hit point pulled back onto the sphere, with error γ5·|p − c| + u·|p| [pbrt-v4 §6.8.6].
    fn surface(&self, ray: &Ray, t: f32) -> Surface {
        let raw = ray.o.as_dvec3() + ray.d.as_dvec3() * f64::from(t) - self.centre.as_dvec3();
        let n = raw.normalize_or_zero();
        let n = if n == glam::DVec3::ZERO { glam::DVec3::Z } else { n };
        let p = (self.centre.as_dvec3() + n * f64::from(self.radius)).as_vec3();
        let p_error = p.abs() * gamma(2) + Vec3::splat(self.radius * gamma(2));
        let ng = n.as_vec3();
        Surface { p, p_error, ng, ns: ng }
    }
}

impl Disk {
    fn intersect(&self, ray: &Ray) -> Option<f32> {
        let (n, d) = (self.normal.as_dvec3(), ray.d.as_dvec3());
        let offset = self.centre.as_dvec3() - ray.o.as_dvec3();
        let t = n.dot(offset) / n.dot(d);
        let from_centre = d * t - offset;
        let inside = from_centre.length_squared() <= f64::from(self.radius) * f64::from(self.radius);
        (t > 0.0 && (t as f32) > 0.0 && (t as f32) < ray.t_max && inside).then_some(t as f32)
    }

    fn surface(&self, ray: &Ray, t: f32) -> Surface {
        let (c, n) = (self.centre.as_dvec3(), self.normal.as_dvec3());
        let raw = ray.o.as_dvec3() + ray.d.as_dvec3() * f64::from(t) - c;
        // Pulled back onto the plane, so that what is left is the rounding to f32.
        let p = (c + raw - n * n.dot(raw)).as_vec3();
        let p_error = p.abs() * gamma(2) + Vec3::splat(self.radius * gamma(2));
        Surface { p, p_error, ng: self.normal, ns: self.normal }
    }
}
