//! Scattering at a path vertex: samples the BSDF and builds the next ray.

use crate::normals::Tilt;
use crate::terminator::over_the_facet;
use crate::trace_context::TraceContext;
use crate::vertex::Vertex;
use crate::visibility::Visibility;
use dapple_materials::{BsdfSample, Lobes};
use dapple_math::Ray;
use dapple_math::lanes::{Framex, Real, Vec3x};
use glam::{Vec2, Vec3};

/// A scattered ray with its BSDF sample.
#[derive(Clone, Copy)]
pub(crate) struct Scattered {
    pub sample: BsdfSample,
    pub ray: Ray,
}

impl Vertex {
    /// Samples one of `lobes`; `None` if the ray would carry nothing or leave on the wrong side of the surface.
    pub fn scatter<V: Visibility>(
        &self,
        uc: f32,
        u: Vec2,
        lobes: Lobes,
        context: &TraceContext<'_, V>,
    ) -> Option<Scattered> {
        let sample = self.bsdf.sample_f(uc, u, lobes)?;
        let passes = self.bsdf.passes(sample.wi);
        let wi = onward::<f32>(&self.frame.into(), passes, self.along.into(), sample.wi.into()).into();
        if sample.weight == Vec3::ZERO {
            return None;
        }
        match &self.tilt {
            Some(tilt) if !passes => self.scatter_tilted(tilt, sample, wi, context),
            _ if self.leaks(wi, sample.wi) => None,
            _ => Some(Scattered { sample, ray: Ray::new(self.surface.origin_towards(wi), wi) }),
        }
    }

    #[inline(never)]
    fn scatter_tilted<V: Visibility>(
        &self,
        tilt: &Tilt<f32>,
        mut sample: BsdfSample,
        w: Vec3,
        context: &TraceContext<'_, V>,
    ) -> Option<Scattered> {
        let (wi, density, exists) = tilt.leave(w.into(), self.reflects(sample.wi));
        let wi = wi.into();
        if !exists {
            return None;
        }
        if !sample.lobe.is_delta() {
            sample.pdf *= density;
        }
        let o = self.origin(wi, context)?;
        Some(Scattered { sample, ray: Ray::new(o, wi) })
    }

    /// Origin of a ray towards `wi`: outside the position's error box, or above a facet that the ray passes over;
    /// `None` if the segment to that point is occluded.
    #[inline(always)]
    pub fn origin<V: Visibility>(&self, wi: Vec3, context: &TraceContext<'_, V>) -> Option<Vec3> {
        match &self.tilt {
            Some(tilt) if tilt.is_over && wi.dot(self.seen_normal()) <= 0.0 => {
                let (at, up) = ((&self.hit, &self.surface), self.seen_normal());
                over_the_facet(&context.scene.accel, at, up, context.time, |way| context.occluded(way))
            }
            _ => Some(self.surface.origin_towards(wi)),
        }
    }
}

/// Directions in which light goes on that is scattered to `local`: exactly `along` where it passes the surface.
#[inline(always)]
pub(crate) fn onward<R: Real>(
    frame: &Framex<R>,
    passes: R::Mask,
    along: Vec3x<R>,
    local: Vec3x<R>,
) -> Vec3x<R> {
    Vec3x::select(passes, along, frame.to_world(local).normalize())
}
