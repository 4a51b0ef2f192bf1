//! Sampling of disks, uniform in area.
use crate::LightPoint;
use crate::aimed::{Aimed, visible};
use dapple_math::Frame;
use dapple_sampling::warp;
use glam::{Vec2, Vec3};
use std::f64::consts::PI;

pub(crate) fn sample(
    p: Vec3,
    centre: Vec3,
    normal: Vec3,
    radius: f32,
    two_sided: bool,
    u: Vec2,
) -> Option<Aimed> {
    let frame = Frame::from_z(normal);
    let at = warp::disk(u) * radius;
    let offset = frame.x * at.x + frame.y * at.y;
    let to = centre.as_dvec3() - p.as_dvec3() + offset.as_dvec3();
    let distance = to.length();
    let pdf = pdf(p, centre, normal, radius, two_sided, distance as f32) as f32;
    let place = centre + offset;
    let p_error = (centre.abs() + offset.abs()) * (4.0 * f32::EPSILON);
    let point = LightPoint { p: place, p_error, n: normal, triangle: 0, u: 0.0, v: 0.0 };
    (pdf > 0.0).then(|| Aimed { wi: (to / distance).as_vec3(), distance: distance as f32, pdf, point })
}

/// distance²/(πR²·cosθ) with cosθ = (height over the plane)/distance.
pub(crate) fn pdf(p: Vec3, centre: Vec3, normal: Vec3, radius: f32, two_sided: bool, distance: f32) -> f64 {
    let height = (p.as_dvec3() - centre.as_dvec3()).dot(normal.as_dvec3());
    let (d, r) = (distance as f64, radius as f64);
    visible(height, two_sided).map_or(0.0, |height| d * d * d / (PI * r * r * height))
}
