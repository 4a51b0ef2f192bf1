//! Visibility of camera rays: nothing in front of the near plane, and no back faces of single-sided opaque materials.
//!
//! A camera ray extends from the lens to the first surface that does not transmit it straight through. It remains a
//! camera ray through holes (alpha), through boundaries that are hidden inside a body, and through transparent surfaces
//! that do not refract it, most notably thin panes: a window shows what would be visible without it. Reflected,
//! refracted and scattered rays are not camera rays. They hit both sides of every surface, as light does.
//!
//! Rays are first traced without these exceptions. Only if the first surface is one to pass, the ray is traced again
//! past all such surfaces; and only if a surface lies in front of the near plane, or the camera is inside a body, the
//! ray origin is moved to the near plane. Images in which nothing is passed therefore stay the same to the bit.

use crate::culling::{Backfaces, hides_back, hides_backs};
use crate::job::Job;
use crate::medium::MediumStack;
use crate::shared_place;
use crate::trace_context::TraceContext;
use crate::visibility::{Query, Visibility};
use dapple_camera::Camera;
use dapple_geometry::{Hit, HitFilter, Surface};
use dapple_math::Ray;
use dapple_math::lanes::{Mask, Real, Vec3x};
use dapple_sampling::Key;
use dapple_scene::Scene;
use glam::Vec2;

/// Whether a camera ray along the direction of `ray` passes a hit because it is on a back face that is not shown.
fn is_passed(scene: &Scene, hit: &Hit, ray: &Ray, time: f32) -> bool {
    hides_back(scene.material(hit.object)) && scene.accel.is_from_behind(hit, ray.d, time)
}

/// The ray from its near plane on, where `near` is the ray parameter of the plane.
pub(crate) fn beyond(ray: &Ray, near: f32) -> Ray {
    if near <= 0.0 {
        return *ray;
    }
    let o = ray.o.as_dvec3() + ray.d.as_dvec3() * f64::from(near);
    Ray { o: o.as_vec3(), d: ray.d, t_max: ray.t_max - near }
}

/// The ray from its near plane on, the bodies around its new origin, and the length of the skipped part.
#[cold]
#[inline(never)]
pub(crate) fn start(job: &Job<'_>, ray: &Ray, time: f32) -> (Ray, MediumStack, f32) {
    let near = job.near(ray, time);
    let ray = beyond(ray, near);
    (ray, job.media.around(job.scene, ray.o, time), near * ray.d.length())
}

impl Job<'_> {
    /// Ray parameter of the near plane along a camera ray; 0 where nothing is clipped.
    #[cold]
    #[inline(never)]
    pub fn near(&self, ray: &Ray, time: f32) -> f32 {
        if self.camera.motion.is_some() { self.camera.at(time).near(ray) } else { self.camera.near(ray) }
    }

    /// Whether the ray parameter `t` of a camera ray lies in front of its near plane; `near` is an upper bound for the
    /// plane.
    #[inline(always)]
    pub fn clips(&self, t: f32, near: f32, ray: &Ray, time: f32) -> bool {
        cfg!(not(without = "view")) && t < near && t < self.near(ray, time)
    }

    /// Whether a camera ray continues past its first hit.
    #[inline(always)]
    pub fn passes(&self, ray: &Ray, (hit, surface): (&Hit, &Surface), near: f32, time: f32) -> bool {
        let from_behind =
            || self.hides_backs && surface.ng.dot(ray.d) > 0.0 && self.is_passed(hit, ray, time);
        cfg!(not(without = "view")) && (self.clips(hit.t, near, ray, time) || from_behind())
    }

    /// Whether [`Job::passes`] has to be asked about first hits at `t` of rays of direction `d`.
    #[inline(always)]
    pub fn may_pass_first<R: Real>(&self, t: R, ng: Vec3x<R>, d: Vec3x<R>) -> R::Mask {
        let from_behind = R::Mask::splat(self.hides_backs) & ng.dot(d).gt(R::splat(0.0));
        t.lt(R::splat(self.near_most)) | from_behind
    }

    #[inline(never)]
    fn is_passed(&self, hit: &Hit, ray: &Ray, time: f32) -> bool {
        is_passed(self.scene, hit, ray, time)
    }
}

/// The hit of a camera ray past all surfaces that it passes, in a scene without media: the hit, its surface, and its
/// distance from the lens. `first`: ray parameter of the first hit; `near`: upper bound for that of the near plane.
#[cold]
#[inline(never)]
pub(crate) fn visible_hit<V: Visibility>(
    context: &TraceContext<'_, V>,
    ray: &Ray,
    (near, first): (f32, f32),
) -> Option<(Hit, Surface, f32)> {
    let moves = context.job.clips(first, near, ray, context.time);
    let near = if moves { context.job.near(ray, context.time) } else { 0.0 };
    let ray = beyond(ray, near);
    let context = &context.of_camera_ray();
    let scene = context.scene;
    let mut hit = context.visibility.intersect(scene, &ray, context.time, context.key)?;
    let mut surface = scene.accel.surface(&ray, context.time, &hit);
    if let Some(places) = shared_place::of(scene).filter(|_| !V::PLAIN) {
        shared_place::resolve_shared(places, &ray, (&mut hit, &mut surface), context);
    }
    Some((hit, surface, (near + hit.t) * ray.d.length()))
}

impl<'a, V: Visibility> TraceContext<'a, V> {
    /// The same context for camera rays, which pass back faces.
    pub fn of_camera_ray(&self) -> TraceContext<'a, FromCamera<V>> {
        let visibility = FromCamera { inner: self.visibility, hides_backs: self.job.hides_backs };
        TraceContext { job: self.job, scene: self.scene, visibility, time: self.time, key: self.key }
    }
}

/// Visibility for camera rays: what stops other rays, except for back faces.
#[derive(Clone, Copy)]
pub(crate) struct FromCamera<V> {
    inner: V,
    hides_backs: bool,
}

impl<V: Visibility> FromCamera<V> {
    fn meets(self, at: &Query<'_>, hit: &Hit) -> bool {
        !(self.hides_backs && is_passed(at.scene, hit, at.ray, at.time))
    }
}

impl<V: Visibility> Visibility for FromCamera<V> {
    const PLAIN: bool = V::PLAIN;
    const OPAQUE: bool = false;
    fn intersect(self, scene: &Scene, ray: &Ray, time: f32, key: Key) -> Option<Hit> {
        let at = Query { scene, ray, time, key };
        self.inner.closest_where(&at, &|hit: &Hit| self.meets(&at, hit))
    }
    fn occluded(self, scene: &Scene, ray: &Ray, time: f32, key: Key) -> bool {
        let at = Query { scene, ray, time, key };
        self.inner.blocked_where(&at, &|hit: &Hit| self.meets(&at, hit))
    }
    fn any(self, scene: &Scene, ray: &Ray, time: f32, key: Key, counts: &dyn Fn(&Hit) -> bool) -> bool {
        let at = Query { scene, ray, time, key };
        self.inner.any(scene, ray, time, key, &|hit: &Hit| self.meets(&at, hit) && counts(hit))
    }
    fn closest_where(self, at: &Query<'_>, counts: &impl Fn(&Hit) -> bool) -> Option<Hit> {
        self.inner.closest_where(at, &|hit: &Hit| self.meets(at, hit) && counts(hit))
    }
    fn blocked_where(self, at: &Query<'_>, counts: &impl Fn(&Hit) -> bool) -> bool {
        self.inner.blocked_where(at, &|hit: &Hit| self.meets(at, hit) && counts(hit))
    }
}

/// Accepts the surfaces that a camera ray does not pass, ignoring alpha.
struct Shown<'a> {
    scene: &'a Scene,
    ray: &'a Ray,
    time: f32,
    hides_backs: bool,
}

impl HitFilter<Hit> for Shown<'_> {
    const OPAQUE: bool = false;
    fn accept(&self, hit: &Hit) -> bool {
        !(self.hides_backs && is_passed(self.scene, hit, self.ray, self.time))
    }
}

/// The first surface that a camera ray shows, with alpha ignored.
pub(crate) fn solid(job: &Job<'_>, ray: &Ray, time: f32) -> Option<(Hit, Surface)> {
    let ray = &beyond(ray, job.near(ray, time));
    let (scene, hides_backs) = (job.scene, job.hides_backs);
    let hit = scene.accel.intersect(ray, time, &Shown { scene, ray, time, hides_backs })?;
    Some((hit, scene.accel.surface(ray, time, &hit)))
}

/// Distance along the view axis to the surface at the image centre when the shutter opens, in render-space units, with
/// alpha ignored; `None` where there is no surface.
pub fn centre_depth(scene: &Scene, camera: &Camera, backfaces: Backfaces) -> Option<f32> {
    let (half, hides_backs) = (Vec2::splat(0.5), hides_backs(scene, backfaces));
    let ray = camera.ray((0, 0), half, (1, 1), half);
    let ray = &beyond(&ray, camera.near(&ray));
    let hit = scene.accel.intersect(ray, 0.0, &Shown { scene, ray, time: 0.0, hides_backs })?;
    Some((ray.at(hit.t) - camera.origin).dot(-camera.backward))
}
