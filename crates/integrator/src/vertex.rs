//! From a hit to a vertex of numbers: where, which way, what of, how much it emits.

use dapple_geometry::{Frame, Hit, Ray, Surface, offset::offset_origin};
use dapple_materials::{Bsdf, Lobes};
use dapple_scene::{Scene, Shading};
use glam::Vec3;

/// A place where a path can scatter.
#[derive(Clone, Copy)]
pub(crate) struct Vertex {
    pub hit: Hit,
    pub surface: Surface,
    pub shading: Shading,
    pub frame: Frame,
    /// Unit, towards where the path came from.
    pub wo: Vec3,
    pub bsdf: Bsdf,
}

impl Vertex {
    pub fn new(scene: &Scene, ray: &Ray, hit: &Hit, surface: &Surface, wo: Vec3) -> Self {
        debug_assert!(ray.d.is_finite());
        let shading = scene.shading(hit, surface);
        let frame = facing_frame(&shading.frame, surface.ng, wo);
        let bsdf = Bsdf::new(&shading.material, frame.to_local(wo));
        Self { hit: *hit, surface: *surface, shading, frame, wo, bsdf }
    }

    /// BSDF value times |cosθ|, and the density of `sample_f` per solid angle. The value is zero where shading and
    /// geometric side disagree: no light leaks through the surface.
    pub fn f_cos_and_pdf(&self, wi: Vec3, lobes: Lobes) -> (Vec3, f32) {
        let local = self.frame.to_local(wi);
        if !self.sides_agree(wi, local) {
            return (Vec3::ZERO, 0.0);
        }
        let (f, pdf) = self.bsdf.eval(local, lobes);
        (f * local.z.abs(), pdf)
    }

    /// Reflection must be reflection, and transmission transmission, for both the shading and the geometric normal.
    pub fn sides_agree(&self, wi: Vec3, local: Vec3) -> bool {
        let reflects = local.z * self.frame.z.dot(self.wo) > 0.0;
        let reflects_geometrically = wi.dot(self.surface.ng) * self.wo.dot(self.surface.ng) > 0.0;
        reflects == reflects_geometrically
    }

    /// Where a ray towards `d` starts, outside the position's error box.
    pub fn origin(&self, d: Vec3) -> Vec3 {
        offset_origin(self.surface.p, self.surface.p_error, self.surface.ng, d)
    }

    /// The normal a light-choice strategy may rely on: none when light can also come from behind.
    pub fn choice_normal(&self) -> Vec3 {
        if self.shading.material.transmission > 0.0 {
            Vec3::ZERO
        } else {
            self.surface.ng * self.surface.ng.dot(self.wo).signum()
        }
    }
}

/// The shading frame, bent where needed so that `wo` is on the same side of it as of the surface.
///
/// *Approximation*: interpolated and mapped normals can turn away from a viewer who does see the surface; the normal
/// is then tilted towards `wo` until it just faces it, which keeps such pixels from going black.
fn facing_frame(frame: &Frame, ng: Vec3, wo: Vec3) -> Frame {
    let side = ng.dot(wo);
    let cos = frame.z.dot(wo);
    if side * cos > 0.0 || side == 0.0 {
        return *frame;
    }
    let z = frame.z - wo * (cos - 1e-3 * side.signum());
    Frame::from_z_tangent(z.normalize_or(ng), frame.x, 1.0)
}
