//! From a hit to a vertex of numbers: where, which way, what of, how much it emits.

use crate::kernel::Job;
use crate::terminator;
use dapple_geometry::{Frame, Hit, Ray, Surface, offset::offset_origin};
use dapple_materials::{Bsdf, BsdfSample, Lobes};
use dapple_scene::Shading;
use glam::{Vec2, Vec3};

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
    /// Shading and geometric normal differ, and the terminator between them is softened.
    soft: bool,
}

impl Vertex {
    /// At a hit seen from `wo`, without the blur of the lobes that are switched off.
    pub fn new(job: &Job<'_>, hit: &Hit, surface: &Surface, wo: Vec3, time: f32) -> Self {
        let shading = job.scene.shading(hit, surface, time);
        let frame = facing_frame(&shading.frame, surface.ng, wo);
        let mut bsdf = Bsdf::new(&shading.material, frame.to_local(wo));
        if !job.sharp.is_empty() {
            bsdf = bsdf.sharp(job.sharp);
        }
        let soft = frame.z != surface.ng && job.settings.soft_terminator;
        Self { hit: *hit, surface: *surface, shading, frame, wo, bsdf, soft }
    }

    /// What the softened terminator leaves of light reflected from `wi`.
    fn left(&self, wi: Vec3) -> f32 {
        if self.soft { terminator::left(wi, self.frame.z, self.surface.ng) } else { 1.0 }
    }

    /// A ray on by one of `lobes`, unless it carries nothing or shading and geometric side disagree.
    pub fn scatter(&self, uc: f32, u: Vec2, lobes: Lobes) -> Option<Scattered> {
        let mut sample = self.bsdf.sample_f(uc, u, lobes)?;
        let wi = self.frame.to_world(sample.wi).normalize();
        if !(sample.lobe.is_delta() || sample.lobe.is_transmission()) {
            sample.weight *= self.left(wi);
        }
        let carries = sample.weight != Vec3::ZERO && self.sides_agree(wi, sample.wi);
        carries.then(|| Scattered { sample, ray: Ray::new(self.origin(wi), wi) })
    }

    /// A direction of the local hemisphere, in the world and on the side `wo` is on.
    pub fn outward(&self, local: Vec3) -> Vec3 {
        let side = if self.frame.z.dot(self.wo) < 0.0 { -1.0 } else { 1.0 };
        self.frame.to_world(Vec3::new(local.x, local.y, local.z * side)).normalize()
    }

    /// BSDF value times |cosθ|, and the density of `sample_f` per solid angle. The value is zero where shading and
    /// geometric side disagree: no light leaks through the surface.
    #[inline(always)]
    pub fn f_cos_and_pdf(&self, wi: Vec3, lobes: Lobes) -> (Vec3, f32) {
        let local = self.frame.to_local(wi);
        if !self.sides_agree(wi, local) {
            return (Vec3::ZERO, 0.0);
        }
        let (f, pdf) = self.bsdf.eval(local, lobes);
        let reflects = local.z * self.frame.z.dot(self.wo) > 0.0;
        let left = if reflects { self.left(wi) } else { 1.0 };
        (f * (local.z.abs() * left), pdf)
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

/// A ray that leaves a vertex.
#[derive(Clone, Copy)]
pub(crate) struct Scattered {
    pub sample: BsdfSample,
    pub ray: Ray,
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
