//! Path vertices: position, shading frame and BSDF at a hit.

use crate::job::Job;
use crate::medium::Boundary;
use crate::normals::{Tilt, leans};
use dapple_geometry::{Hit, Surface};
use dapple_materials::{Bsdf, Lobes};
use dapple_math::lanes::{Real, Vec3x};
use dapple_math::{Frame, Ray};
use dapple_scene::Shading;
use glam::Vec3;

/// A point at which a path can scatter.
#[derive(Clone, Copy)]
pub(crate) struct Vertex {
    pub hit: Hit,
    pub surface: Surface,
    pub shading: Shading,
    pub frame: Frame,
    /// Unit direction towards the previous vertex.
    pub wo: Vec3,
    /// Direction of the incoming ray, not normalised.
    pub along: Vec3,
    pub bsdf: Bsdf,
    /// Tilt of the shading normal, if it deviates from the geometric normal.
    pub tilt: Option<Tilt<f32>>,
}

impl Vertex {
    /// The vertex at a hit of `ray`, seen from `wo`, without the roughness of lobes that are switched off. `boundary`:
    /// the media on both sides, if the surface separates two.
    #[inline(always)]
    pub fn new(
        job: &Job<'_>,
        (ray, wo): (&Ray, Vec3),
        (hit, surface): (&Hit, &Surface),
        (time, boundary): (f32, Option<&Boundary>),
    ) -> Self {
        let mut shading = job.scene.shading(hit, surface, time);
        if let Some(boundary) = boundary
            && let Some(ior) = boundary.ior(job.media.bodies, surface.ng.dot(wo) > 0.0)
        {
            shading.material.set_ior(ior);
        }
        let oriented = oriented(job, &shading, (hit, surface), wo, time);
        Self::of(job, (ray, wo), (hit, surface), shading, oriented)
    }

    /// The vertex with the shading data of its hit, and with its frame and tilt.
    #[inline(always)]
    pub fn of(
        job: &Job<'_>,
        (ray, wo): (&Ray, Vec3),
        (hit, surface): (&Hit, &Surface),
        shading: Shading,
        (frame, tilt): (Frame, Option<Tilt<f32>>),
    ) -> Self {
        let unmapped = tilt.filter(|tilt| tilt.is_mapped).map(|tilt| tilt.unmapped);
        let mut bsdf = Bsdf::losing_as(&shading.material, frame.to_local(wo), unmapped);
        if !job.sharp.is_empty() {
            bsdf = bsdf.sharp(job.sharp);
        }
        Self { hit: *hit, surface: *surface, shading, frame, wo, along: ray.d, bsdf, tilt }
    }

    /// The directions that decide about the sides of the surface.
    #[inline(always)]
    fn facing(&self) -> Facing<f32> {
        Facing { ng: self.surface.ng.into(), ns: self.frame.z.into(), wo: self.wo.into() }
    }

    /// Maps a direction of the local hemisphere to the world, on the side of `wo`, as for reflected light.
    pub fn outward(&self, local: Vec3) -> Vec3 {
        let side = if self.frame.z.dot(self.wo) < 0.0 { -1.0 } else { 1.0 };
        let w = self.frame.to_world(Vec3::new(local.x, local.y, local.z * side)).normalize();
        match self.tilt.map(|tilt| tilt.leave(w.into(), true)) {
            Some((wi, _, true)) => wi.into(),
            _ => w,
        }
    }

    /// BSDF value times |cosθ|, and the solid-angle density of `sample_f`. The value is zero where the shading and the
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
    fn f_cos_and_pdf_tilted(&self, tilt: &Tilt<f32>, wi: Vec3, lobes: Lobes) -> (Vec3, f32) {
        let (w, density, reflects) = tilt.before(wi.into());
        let local = self.frame.to_local(w.into());
        if self.reflects(local) != reflects {
            return (Vec3::ZERO, 0.0);
        }
        let (f, pdf) = self.bsdf.eval(local, lobes);
        (f * (local.z.abs() * density), pdf * density)
    }

    /// Whether `wo` and a local direction are on the same side of the shading normal.
    pub fn reflects(&self, local: Vec3) -> bool {
        self.facing().reflects(local.into())
    }

    /// Whether the shading and the geometric normal disagree on reflection or transmission. If the two normals agree up
    /// to rounding, this happens only for directions along the surface.
    pub fn leaks(&self, wi: Vec3, local: Vec3) -> bool {
        self.facing().leaks(wi.into(), local.into())
    }

    /// Unit geometric normal on the side of `wo`.
    pub fn seen_normal(&self) -> Vec3 {
        self.facing().seen_normal().into()
    }

    /// The normal for the light choice: zero if light can also arrive from behind.
    pub fn choice_normal(&self) -> Vec3 {
        if self.shading.material.has_transmission() {
            Vec3::ZERO
        } else {
            self.tilt.map_or_else(|| self.seen_normal(), |tilt| tilt.horizon.into())
        }
    }
}

/// Normals of a surface, and the direction from which it is seen, per lane.
#[derive(Clone, Copy)]
pub(crate) struct Facing<R> {
    /// Geometric normal.
    pub ng: Vec3x<R>,
    /// Shading normal.
    pub ns: Vec3x<R>,
    /// Unit direction towards the viewer.
    pub wo: Vec3x<R>,
}

impl<R: Real> Facing<R> {
    /// See [`Vertex::reflects`].
    #[inline(always)]
    pub fn reflects(&self, local: Vec3x<R>) -> R::Mask {
        (local.z * self.ns.dot(self.wo)).gt(R::splat(0.0))
    }

    /// See [`Vertex::leaks`].
    #[inline(always)]
    pub fn leaks(&self, wi: Vec3x<R>, local: Vec3x<R>) -> R::Mask {
        let reflects_geometrically = (wi.dot(self.ng) * self.wo.dot(self.ng)).gt(R::splat(0.0));
        self.reflects(local) ^ reflects_geometrically
    }

    /// See [`Vertex::seen_normal`].
    #[inline(always)]
    pub fn seen_normal(&self) -> Vec3x<R> {
        self.ng * R::splat(1.0).copysign(self.ng.dot(self.wo))
    }
}

/// The shading frame on the side of `wo`, and its tilt against the surface.
#[inline(always)]
pub(crate) fn oriented(
    job: &Job<'_>,
    shading: &Shading,
    (hit, surface): (&Hit, &Surface),
    wo: Vec3,
    time: f32,
) -> (Frame, Option<Tilt<f32>>) {
    if shading.frame.z == surface.ng {
        (shading.frame, None)
    } else if leans::<f32>(shading.frame.z.into(), surface.ng.into()) {
        Tilt::new(job, shading, (hit, surface), wo, time)
    } else {
        (facing_frame(&shading.frame, surface.ng, wo), None)
    }
}

/// Whether a frame about the shading normal `ns` is used as it is, seen from `wo`: the shading normal does not lean, and
/// it faces the viewer.
#[inline(always)]
pub(crate) fn is_upright<R: Real>(ns: Vec3x<R>, ng: Vec3x<R>, wo: Vec3x<R>) -> R::Mask {
    let is_flat = ns.x.eq(ng.x) & ns.y.eq(ng.y) & ns.z.eq(ng.z);
    is_flat | (!leans(ns, ng) & faces(ns, ng, wo))
}

/// Whether `wo` is on the same side of both normals.
#[inline(always)]
fn faces<R: Real>(ns: Vec3x<R>, ng: Vec3x<R>, wo: Vec3x<R>) -> R::Mask {
    let (zero, side) = (R::splat(0.0), ng.dot(wo));
    (side * ns.dot(wo)).gt(zero) | side.eq(zero)
}

/// The shading frame, rotated if needed so that `wo` is on the same side of it as of the surface.
///
/// *Approximation*: a shading normal that differs from the geometric normal only by rounding can face away from a
/// viewer who sees the surface edge-on; it is then tilted towards `wo` until it just faces it.
fn facing_frame(frame: &Frame, ng: Vec3, wo: Vec3) -> Frame {
    if faces::<f32>(frame.z.into(), ng.into(), wo.into()) {
        return *frame;
    }
    let (side, cos) = (ng.dot(wo), frame.z.dot(wo));
    let z = frame.z - wo * (cos - 1e-3 * side.signum());
    Frame::from_z_tangent(z.normalize_or(ng), frame.x, 1.0)
}
