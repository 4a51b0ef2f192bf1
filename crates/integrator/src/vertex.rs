//! From a hit to a vertex of numbers: where, which way, what of, how much it emits.

use crate::kernel::Job;
use crate::medium::Boundary;
use crate::normals::{Tilt, leans};
use crate::terminator::over_the_facet;
use crate::visibility::Visibility;
use dapple_geometry::{Hit, Surface};
use dapple_materials::{Bsdf, BsdfSample, Lobes};
use dapple_math::{Frame, Ray};
use dapple_sampling::Key;
use dapple_scene::{Scene, Shading};
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
    /// Direction of the ray that came, of its length.
    along: Vec3,
    pub bsdf: Bsdf,
    /// The shading normal leans against the surface.
    tilt: Option<Tilt>,
}

impl Vertex {
    /// At a hit of `ray`, seen from `wo`, without the blur of the lobes that are switched off. `boundary`: the media on both
    /// sides, where the surface lies between two.
    pub fn new(
        job: &Job<'_>,
        (ray, wo): (&Ray, Vec3),
        hit: &Hit,
        surface: &Surface,
        (time, boundary): (f32, Option<&Boundary>),
    ) -> Self {
        let mut shading = job.scene.shading(hit, surface, time);
        if let Some(boundary) = boundary
            && let Some(ior) = boundary.ior(job.media.bodies, surface.ng.dot(wo) > 0.0)
        {
            shading.material.ior = ior;
        }
        let (frame, tilt) = if shading.frame.z == surface.ng {
            (shading.frame, None)
        } else if leans(shading.frame.z, surface.ng) {
            Tilt::new(job, &shading, (hit, surface), wo, time)
        } else {
            (facing_frame(&shading.frame, surface.ng, wo), None)
        };
        let unmapped = tilt.and_then(|tilt| tilt.unmapped);
        let mut bsdf = Bsdf::losing_as(&shading.material, frame.to_local(wo), unmapped);
        if !job.sharp.is_empty() {
            bsdf = bsdf.sharp(job.sharp);
        }
        Self { hit: *hit, surface: *surface, shading, frame, wo, along: ray.d, bsdf, tilt }
    }

    /// A ray on by one of `lobes`, unless it carries nothing or there is no way.
    pub fn scatter<V: Visibility>(
        &self,
        uc: f32,
        u: Vec2,
        lobes: Lobes,
        around: &Around<'_, V>,
    ) -> Option<Scattered> {
        let sample = self.bsdf.sample_f(uc, u, lobes)?;
        let passes = self.bsdf.passes(sample.wi);
        let wi = if passes { self.along } else { self.frame.to_world(sample.wi).normalize() };
        if sample.weight == Vec3::ZERO {
            return None;
        }
        match &self.tilt {
            Some(tilt) if !passes => self.scatter_tilted(tilt, sample, wi, around),
            _ if self.leaks(wi, sample.wi) => None,
            _ => Some(Scattered { sample, ray: Ray::new(self.surface.origin_towards(wi), wi) }),
        }
    }

    #[inline(never)]
    fn scatter_tilted<V: Visibility>(
        &self,
        tilt: &Tilt,
        mut sample: BsdfSample,
        w: Vec3,
        around: &Around<'_, V>,
    ) -> Option<Scattered> {
        let (wi, density) = tilt.leave(w, self.reflects(sample.wi))?;
        if !sample.lobe.is_delta() {
            sample.pdf *= density;
        }
        let o = self.origin(wi, around)?;
        Some(Scattered { sample, ray: Ray::new(o, wi) })
    }

    /// A direction of the local hemisphere, in the world and on the side `wo` is on, as reflected light leaves by it.
    pub fn outward(&self, local: Vec3) -> Vec3 {
        let side = if self.frame.z.dot(self.wo) < 0.0 { -1.0 } else { 1.0 };
        let w = self.frame.to_world(Vec3::new(local.x, local.y, local.z * side)).normalize();
        self.tilt.and_then(|tilt| tilt.leave(w, true)).map_or(w, |(wi, _)| wi)
    }

    /// BSDF value times |cosθ|, and the density of `sample_f` per solid angle. The value is zero where shading and
    /// geometric side disagree: no light leaks through the surface.
    #[inline(always)]
    pub fn f_cos_and_pdf(&self, wi: Vec3, lobes: Lobes) -> (Vec3, f32) {
        if let Some(tilt) = &self.tilt {
            return self.f_cos_and_pdf_tilted(tilt, wi, lobes);
        }
        let local = self.frame.to_local(wi);
        if self.leaks(wi, local) {
            return (Vec3::ZERO, 0.0);
        }
        let (f, pdf) = self.bsdf.eval(local, lobes);
        (f * local.z.abs(), pdf)
    }

    #[inline(never)]
    fn f_cos_and_pdf_tilted(&self, tilt: &Tilt, wi: Vec3, lobes: Lobes) -> (Vec3, f32) {
        let (w, density, reflects) = tilt.before(wi);
        let local = self.frame.to_local(w);
        if self.reflects(local) != reflects {
            return (Vec3::ZERO, 0.0);
        }
        let (f, pdf) = self.bsdf.eval(local, lobes);
        (f * (local.z.abs() * density), pdf * density)
    }

    /// Whether `wo` and a local direction are on the same side of the shading normal.
    fn reflects(&self, local: Vec3) -> bool {
        local.z * self.frame.z.dot(self.wo) > 0.0
    }

    /// Reflection must be reflection, and transmission transmission, for both the shading and the geometric normal. Where
    /// the two agree but for rounding, they differ in directions along the surface alone.
    fn leaks(&self, wi: Vec3, local: Vec3) -> bool {
        let reflects_geometrically = wi.dot(self.surface.ng) * self.wo.dot(self.surface.ng) > 0.0;
        self.reflects(local) != reflects_geometrically
    }

    /// Where a ray towards `wi` starts, unless there is no way: outside the position's error box, or above a facet that it
    /// passes over.
    #[inline(always)]
    pub fn origin<V: Visibility>(&self, wi: Vec3, around: &Around<'_, V>) -> Option<Vec3> {
        match &self.tilt {
            Some(tilt) if tilt.is_over && wi.dot(self.seen_normal()) <= 0.0 => over_the_facet(self, around),
            _ => Some(self.surface.origin_towards(wi)),
        }
    }

    /// Unit geometric normal on the side `wo` is on.
    pub fn seen_normal(&self) -> Vec3 {
        self.surface.ng * self.surface.ng.dot(self.wo).signum()
    }

    /// The normal a light-choice strategy may rely on: none when light can also come from behind.
    pub fn choice_normal(&self) -> Vec3 {
        if self.shading.material.transmission > 0.0 {
            Vec3::ZERO
        } else {
            self.tilt.map_or_else(|| self.seen_normal(), |tilt| tilt.horizon)
        }
    }
}

/// What is around a vertex, for rays that leave it.
#[derive(Clone, Copy)]
pub(crate) struct Around<'a, V> {
    pub job: &'a Job<'a>,
    pub scene: &'a Scene,
    pub visibility: V,
    /// Seconds within the shutter.
    pub time: f32,
    /// Of the alpha that a ray meets.
    pub key: Key,
}

impl<V: Visibility> Around<'_, V> {
    /// Whether anything is in the way of `ray`.
    pub fn blocked(&self, ray: &Ray) -> bool {
        self.visibility.blocked(self.scene, ray, self.time, self.key)
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
/// *Approximation*: where it differs from the geometric normal by rounding alone, it can face away from a viewer who sees the
/// surface edge-on; it is then tilted towards `wo` until it just faces it.
fn facing_frame(frame: &Frame, ng: Vec3, wo: Vec3) -> Frame {
    let side = ng.dot(wo);
    let cos = frame.z.dot(wo);
    if side * cos > 0.0 || side == 0.0 {
        return *frame;
    }
    let z = frame.z - wo * (cos - 1e-3 * side.signum());
    Frame::from_z_tangent(z.normalize_or(ng), frame.x, 1.0)
}
