//! One direction towards a light, the place on it that was chosen, and the shadow ray between.
use dapple_math::Ray;
use dapple_math::offset::{UNIT_ROUNDOFF, offset_origin};
use glam::Vec3;

/// A place on an area light.
#[derive(Clone, Copy, Debug)]
pub struct LightPoint {
    /// Position.
    pub p: Vec3,
    /// Bound of |computed − exact| per axis.
    pub p_error: Vec3,
    /// Unit geometric normal of the front side.
    pub n: Vec3,
    /// Which triangle of the shape (see [`crate::AreaShape`]) and its barycentrics, for textured emission.
    pub triangle: u32,
    /// Barycentric of the triangle's corner 1.
    pub u: f32,
    /// Barycentric of the triangle's corner 2.
    pub v: f32,
}

/// One direction towards a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction towards the light.
    pub wi: Vec3,
    /// Solid-angle density at the receiver; 1 for delta lights.
    pub pdf: f32,
    /// Whether no other technique can find this light.
    pub delta: bool,
    /// Radiance along −wi (area: the light's mean; delta: intensity/d², i.e. irradiance on a facing surface).
    pub radiance: Vec3,
    /// Distance to the light; infinite for distant and environment.
    pub distance: f32,
    /// Only for area lights.
    pub point: Option<LightPoint>,
}

/// Where shadow rays end. From origin to target a direction is rounded by half an ulp per axis, so that its end lies up to
/// |n|·|d|·2⁻²⁴ before or behind the target, measured along the light's normal; by that, the light would shadow its own
/// samples where its coordinates, and with them its error box, are small against the distance. Covers it for all but the
/// last 4° to the light's plane.
const END: f32 = 1.0 - 16.0 * UNIT_ROUNDOFF;

impl LightSample {
    /// The shadow ray from `o`, an origin outside its surface's error box, to outside the light's error box. Its direction
    /// has the length of the way (of area lights), so that the light is at t = 1.
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
