//! Interface for custom integrators: the radiance of a camera ray, computed with the building blocks of the path
//! tracer.

use crate::Dimension;
use crate::direct::{DirectLighting, DirectSample, Sides};
use crate::emission::{self, MisContext};
use crate::job::Job;
use crate::medium::MediumStack;
use crate::sample::Sample;
use crate::settings::Strategy;
use crate::trace_context::TraceContext;
use crate::vertex::Vertex;
use crate::visibility::{Cutout, Visibility};
use dapple_geometry::{Hit, Surface};
use dapple_lights::{Aiming, LightSample};
use dapple_materials::{Bsdf, Lobes};
use dapple_math::{Frame, Ray};
use dapple_scene::Scene;
use glam::{Vec2, Vec3};
use std::cell::Cell;

/// Computes the radiance along a camera ray. [`crate::Renderer::with_integrator`] runs it over all pixels and samples.
///
/// Random numbers come from the context, keyed by decision, so that the image does not depend on threads, tiles or
/// passes. Media, coincident surfaces and transmissive shadows are limited to the built-in integrators: here every
/// surface is opaque to shadow rays except for its alpha.
pub trait Integrator: Sync {
    /// Radiance along `ray`, W·m⁻²·sr⁻¹ per channel of linear Rec. 709.
    fn radiance(&self, ray: &Ray, context: &SampleContext<'_>) -> Vec3;
}

/// One sample of one pixel: its random numbers and its ray queries.
pub struct SampleContext<'a> {
    job: &'a Job<'a>,
    sample: Sample,
    rays: Cell<u64>,
}

/// A ray intersection. Positions and directions are in render space.
#[derive(Clone, Copy)]
pub struct Intersection {
    vertex: Vertex,
}

impl Intersection {
    /// Object, primitive and barycentric coordinates.
    pub fn hit(&self) -> &Hit {
        &self.vertex.hit
    }

    /// Position with its error bound, and normals.
    pub fn surface(&self) -> &Surface {
        &self.vertex.surface
    }

    /// Unit direction towards the ray origin.
    pub fn wo(&self) -> Vec3 {
        self.vertex.wo
    }

    /// Shading frame; z is the shading normal.
    pub fn frame(&self) -> &Frame {
        &self.vertex.frame
    }

    /// Unit geometric normal, facing the incoming ray.
    pub fn facing_normal(&self) -> Vec3 {
        self.vertex.seen_normal()
    }

    /// The BSDF, in the shading frame.
    pub fn bsdf(&self) -> &Bsdf {
        &self.vertex.bsdf
    }

    /// BSDF value times |cosθ| towards `wi`, and the solid-angle density of sampling `wi`.
    pub fn f_cos_and_pdf(&self, wi: Vec3) -> (Vec3, f32) {
        self.vertex.f_cos_and_pdf(wi, Lobes::ALL)
    }

    /// A ray towards `direction` that starts outside the position's error box.
    pub fn ray(&self, direction: Vec3) -> Ray {
        Ray::new(self.vertex.surface.origin_towards(direction), direction)
    }
}

impl<'a> SampleContext<'a> {
    fn new(job: &'a Job<'a>, sample: Sample) -> Self {
        Self { job, sample, rays: Cell::new(0) }
    }

    fn rays(&self) -> u64 {
        self.rays.get()
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        self.job.scene
    }

    /// Seconds since the shutter opened.
    pub fn time(&self) -> f32 {
        self.sample.time
    }

    /// This sample's number in [0, 1) for a decision at a depth. Over the samples of a pixel, these numbers form one
    /// set of the pattern in the settings. Custom decisions use the numbers 128 to 255.
    pub fn point_1d(&self, depth: u32, decision: impl Into<u32>) -> f32 {
        self.sample.named_1d(depth, decision.into())
    }

    /// As [`point_1d`](Self::point_1d), in the unit square.
    pub fn point_2d(&self, depth: u32, decision: impl Into<u32>) -> Vec2 {
        self.sample.named_2d(depth, decision.into())
    }

    /// The nearest surface on `ray`; partial alpha is decided at random.
    pub fn intersect(&self, ray: &Ray, depth: u32) -> Option<Intersection> {
        self.rays.set(self.rays.get() + 1);
        let context = self.trace_context(depth, Dimension::Alpha);
        let scene = self.job.scene;
        let hit = context.visibility.intersect(scene, ray, self.sample.time, context.key)?;
        let surface = scene.accel.surface(ray, self.sample.time, &hit);
        let wo = -ray.d.normalize();
        let vertex = Vertex::new(self.job, (ray, wo), (&hit, &surface), (self.sample.time, None));
        Some(Intersection { vertex })
    }

    /// Whether `ray` is occluded before its end.
    pub fn is_occluded(&self, ray: &Ray, depth: u32) -> bool {
        self.rays.set(self.rays.get() + 1);
        self.trace_context(depth, Dimension::ShadowAlpha).occluded(ray)
    }

    /// Whether the segment between two surface points is occluded; both ends lie outside the error boxes of the points.
    pub fn is_occluded_between(&self, from: &Surface, to: &Surface, depth: u32) -> bool {
        self.is_occluded(&from.ray_to(to), depth)
    }

    /// Whether the segment between a surface point and a sampled point on a light is occluded.
    pub fn is_light_occluded(&self, from: &Surface, sample: &LightSample, depth: u32) -> bool {
        self.is_occluded(&sample.shadow_ray(from.origin_towards(sample.wi)), depth)
    }

    /// Radiance emitted by a surface along the incoming ray, towards its origin.
    pub fn emitted(&self, at: &Intersection) -> Vec3 {
        let (vertex, scene) = (&at.vertex, self.job.scene);
        emission::surface(
            scene,
            &vertex.hit,
            &vertex.surface,
            vertex.wo,
            0.0,
            &MisContext::CAMERA,
            Strategy::Both,
        )
    }

    /// Radiance of the environment from the direction `d`.
    pub fn environment(&self, d: Vec3) -> Vec3 {
        emission::escaped(self.job.scene, d.normalize(), &MisContext::CAMERA, Strategy::Both)
    }

    /// An unbiased estimate of the direct light scattered along `wo`: one light, one point on it, one shadow ray.
    pub fn direct_light(&self, at: &Intersection, depth: u32) -> Vec3 {
        let context = self.trace_context(depth, Dimension::ShadowAlpha);
        let media = Sides { near: &MediumStack::EMPTY, far: &MediumStack::EMPTY };
        let strategy = Strategy::LightOnly;
        let beam = DirectLighting {
            context,
            vertex: &at.vertex,
            media,
            strategy,
            reach: 0,
            lost: Cell::new(Vec3::ZERO),
        };
        let uc = self.point_1d(depth, Dimension::Light);
        let u = self.point_2d(depth, Dimension::LightPoint);
        let mut rays = 0;
        let aim = DirectSample { uc, u, aiming: Aiming::SolidAngle, followed: Lobes::ALL };
        let sum = beam.one(&aim, &mut rays);
        self.rays.set(self.rays.get() + rays);
        sum
    }

    /// Continues a path by BSDF sampling: the weight f·|cosθ|/pdf and the next ray. `None` where the path ends.
    pub fn scatter(&self, at: &Intersection, depth: u32) -> Option<(Vec3, Ray)> {
        let uc = self.point_1d(depth, Dimension::Lobe);
        let u = self.point_2d(depth, Dimension::Direction);
        let next =
            at.vertex.scatter(uc, u, Lobes::ALL, &self.trace_context(depth, Dimension::ShadowAlpha))?;
        Some((next.sample.weight, next.ray))
    }

    fn trace_context(&self, depth: u32, alpha: Dimension) -> TraceContext<'_, Cutout<true>> {
        let key = self.sample.key.at(depth, alpha).branch(self.sample.s);
        let visibility = Cutout { cull_backfaces: self.job.is_culled() };
        TraceContext { job: self.job, scene: self.job.scene, visibility, time: self.sample.time, key }
    }
}

/// One camera ray with the radiance computed by `integrator`, and the pixel filter weight.
pub(crate) fn sample(
    integrator: &dyn Integrator,
    job: &Job<'_>,
    pixel: (u32, u32),
    index: u32,
    rays: &mut u64,
) -> (Vec3, f32) {
    let sample = Sample::new(job.settings, pixel, index).timed(job);
    let (ray, weight) = sample.camera_ray(job, pixel);
    let context = SampleContext::new(job, sample);
    let radiance = integrator.radiance(&ray, &context);
    *rays += context.rays();
    (radiance, weight)
}
