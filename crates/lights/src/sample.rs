//! Light samples: a direction towards a light, the sampled point on it, and the shadow ray.
use dapple_math::Ray;
use dapple_math::offset::{UNIT_ROUNDOFF, offset_origin};
use glam::Vec3;

/// A point on an area light.
#[derive(Clone, Copy, Debug)]
pub struct LightPoint {
    /// Position.
    pub p: Vec3,
    /// Bound of the error of `p`, |computed − exact| per axis.
    pub p_error: Vec3,
    /// Unit geometric normal of the front side.
    pub n: Vec3,
    /// Index of the triangle of the shape (see [`crate::AreaShape`]), for textured emission.
    pub triangle: u32,
    /// Barycentric coordinate of corner 1 of the triangle.
    pub u: f32,
    /// Barycentric coordinate of corner 2 of the triangle.
    pub v: f32,
}

/// A sampled direction towards a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction towards the light.
    pub wi: Vec3,
    /// Solid-angle density at the receiver; 1 for delta lights.
    pub pdf: f32,
    /// Whether no other sampling technique can find this light.
    pub delta: bool,
    /// Radiance along −wi (area lights: the mean of the light; delta lights: intensity/d², i.e. irradiance on a facing
    /// surface).
    pub radiance: Vec3,
    /// Distance to the light; infinite for distant lights and the environment.
    pub distance: f32,
    /// The sampled point; only for area lights.
    pub point: Option<LightPoint>,
}

/// Parameter t at which shadow rays end. The direction from origin to target is rounded by half an ulp per axis, so
/// that its end lies up to |n|·|d|·2⁻²⁴ in front of or behind the target, measured along the normal of the light.
/// Without a margin the light would occlude its own samples where its coordinates, and with them its error box, are
/// small relative to the distance. This margin suffices for all directions but the last 4° to the plane of the light.
pub(crate) const END: f32 = 1.0 - 16.0 * UNIT_ROUNDOFF;

impl LightSample {
    /// The shadow ray from `o`, an origin outside the error box of its surface, to a point outside the error box of the
    /// light. For area lights its direction has the length of the segment, so that the light is at t = 1.
    #[inline(always)]
    pub fn shadow_ray(&self, o: Vec3) -> Ray {
        match &self.point {
            Some(point) => {
                let target = offset_origin(point.p, point.p_error, point.n, -self.wi);
                Ray { o, d: target - o, t_max: END }
            }
            None if self.distance.is_finite() => Ray { o, d: self.wi, t_max: self.distance },
            None => Ray::new(o, self.wi),
        }
    }
}
