//! Sampling of spheres: uniform in the cone that a sphere subtends from outside, uniform over all directions from
//! inside.
use crate::LightPoint;
use crate::aimed::{Aimed, visible};
use dapple_math::Frame;
use dapple_sampling::warp;
use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::{PI, TAU};

/// Directions in which a receiver sees the sphere: the cone of 1 − cosθ ≤ `height` about `w`.
struct Cone {
    /// Unit direction towards the centre.
    w: DVec3,
    /// Distance to the centre.
    d: f64,
    /// d² − R², computed without cancellation.
    gap: f64,
    /// 1 − cosθ_max; 2 for all directions.
    height: f64,
    /// Whether the visible side is the far side of the sphere.
    from_inside: bool,
}

/// Cone that `p` sees; None from inside a one-sided sphere, which emits outward only. With s = R/d from outside,
/// 1 − cosθ_max = s²/(1 + √(1 − s²)), which is accurate at every size.
///
/// A two-sided sphere whose surface contains `p`, to within the rounding of the coordinates, is treated like the walls
/// of a room seen from one of them: the hemisphere towards the centre, far side. The result must not depend on the side
/// to which such a point was rounded: a point outside must not see the surface it lies on, and a point inside must see
/// all of the rest.
fn seen(p: Vec3, centre: Vec3, radius: f32, two_sided: bool) -> Option<Cone> {
    let f = centre.as_dvec3() - p.as_dvec3();
    let (d, r) = (f.length(), radius as f64);
    let gap = (d - r) * (d + r);
    let w = if d > 0.0 { f / d } else { DVec3::Z };
    let largest = p.abs().max(centre.abs()).max_element() as f64 + r;
    let on_wall = (d - r).abs() <= 8.0 * f32::EPSILON as f64 * largest;
    if two_sided && on_wall {
        return Some(Cone { w, d, gap, height: 1.0, from_inside: true });
    }
    if gap >= 0.0 {
        let s = r / d;
        let height = s * s / (1.0 + (gap.sqrt() / d));
        return Some(Cone { w, d, gap, height, from_inside: false });
    }
    two_sided.then_some(Cone { w, d, gap, height: 2.0, from_inside: true })
}

pub(crate) fn sample(p: Vec3, centre: Vec3, radius: f32, two_sided: bool, u: Vec2) -> Option<Aimed> {
    let cone = seen(p, centre, radius, two_sided)?;
    let r = radius as f64;
    let v = u.x as f64 * cone.height;
    let (cos, sin) = (1.0 - v, (v * (2.0 - v)).max(0.0).sqrt());
    // β: angle between the direction and the normal at the intersection.
    let sin_beta = (cone.d * sin / r).min(1.0);
    let cos_beta = (1.0 - sin_beta * sin_beta).sqrt();
    let (distance, along) = if cone.from_inside {
        (cone.d * cos + r * cos_beta, cos_beta * cos - sin_beta * sin)
    } else {
        (cone.gap / (cone.d * cos + r * cos_beta), -cos_beta * cos - sin_beta * sin)
    };
    let radial = distance * sin / r;
    let phi = TAU * u.y as f64;
    let frame = Frame::from_z(cone.w.as_vec3());
    let side = frame.x.as_dvec3() * libm::cos(phi) + frame.y.as_dvec3() * libm::sin(phi);
    let wi = (side * sin + cone.w * cos).normalize().as_vec3();
    let n = (side * radial + cone.w * along).normalize().as_vec3();
    let place = centre + n * radius;
    let p_error = (centre.abs() + (n * radius).abs()) * (4.0 * f32::EPSILON);
    let point = LightPoint { p: place, p_error, n, triangle: 0, u: 0.0, v: 0.0 };
    let usable = distance >= 0.0 && n.is_finite();
    usable.then(|| Aimed { wi, distance: distance as f32, pdf: density(&cone) as f32, point })
}

fn density(cone: &Cone) -> f64 {
    1.0 / (2.0 * PI * cone.height)
}

pub(crate) fn pdf(p: Vec3, centre: Vec3, radius: f32, two_sided: bool) -> f64 {
    seen(p, centre, radius, two_sided).map_or(0.0, |cone| density(&cone))
}

/// Samples a point uniformly on the whole surface. None if it faces away.
pub(crate) fn sample_surface(p: Vec3, centre: Vec3, radius: f32, two_sided: bool, u: Vec2) -> Option<Aimed> {
    let n = warp::sphere(u);
    let place = centre + n * radius;
    let to = place.as_dvec3() - p.as_dvec3();
    let distance = to.length();
    let wi = to / distance;
    let pdf = surface_density(-wi.dot(n.as_dvec3()), radius, two_sided, distance)?;
    let p_error = (centre.abs() + (n * radius).abs()) * (4.0 * f32::EPSILON);
    let point = LightPoint { p: place, p_error, n, triangle: 0, u: 0.0, v: 0.0 };
    Some(Aimed { wi: wi.as_vec3(), distance: distance as f32, pdf: pdf as f32, point })
}

/// Solid-angle density of `sample_surface` for the point at `distance` along `wi`.
pub(crate) fn pdf_surface(
    p: Vec3,
    centre: Vec3,
    radius: f32,
    two_sided: bool,
    wi: Vec3,
    distance: f32,
) -> f64 {
    let (wi, distance) = (wi.as_dvec3(), distance as f64);
    let n = (p.as_dvec3() + wi * distance - centre.as_dvec3()) / radius as f64;
    surface_density(-wi.dot(n), radius, two_sided, distance).unwrap_or(0.0)
}

/// distance²/(4πR²·cosθ)
fn surface_density(cos: f64, radius: f32, two_sided: bool, distance: f64) -> Option<f64> {
    let (cos, r) = (visible(cos, two_sided)?, radius as f64);
    Some(distance * distance / (4.0 * PI * r * r * cos))
}
