//! What camera rays see: nothing before the near plane, and no back faces of single-sided opaque materials.
//!
//! A camera ray is the ray from the lens to the first surface that light does not go straight through. It stays one on its
//! way through holes (alpha), through boundaries that are hidden inside of a body, and through clear surfaces that do not
//! bend it, thin panes above all: what a window shows is what would be seen without it. Reflected, refracted and
//! scattered rays are not camera rays. They meet both sides of everything, as light does.
//!
//! Rays are traced as if nothing was to be passed. Only where the first surface is one to pass, the ray is traced again
//! past all such surfaces; and only where something lies before the near plane, or the camera stands within a body, it is
//! moved to start there. So pictures in which nothing is passed keep their bytes.

use crate::culling::{Backfaces, hides_back, hides_backs};
use crate::job::Job;
use crate::medium::MediumStack;
use crate::shared_place;
use crate::trace_context::TraceContext;
use crate::visibility::{Query, Visibility};
use dapple_camera::Camera;
use dapple_geometry::{Hit, HitFilter, Surface};
use dapple_math::Ray;
use dapple_sampling::Key;
use dapple_scene::Scene;
use glam::Vec2;

/// Whether a camera ray along the direction of `ray` passes a hit, for it is of a back face that is not shown.
fn is_passed(scene: &Scene, hit: &Hit, ray: &Ray, time: f32) -> bool {
    hides_back(scene.material(hit.object)) && scene.accel.is_from_behind(hit, ray.d, time)
}

/// The ray from its near plane on, which is `near` lengths of its direction away.
pub(crate) fn beyond(ray: &Ray, near: f32) -> Ray {
    if near <= 0.0 {
        return *ray;
    }
    let o = ray.o.as_dvec3() + ray.d.as_dvec3() * f64::from(near);
    Ray { o: o.as_vec3(), d: ray.d, t_max: ray.t_max - near }
}

/// The ray from its near plane on, the bodies around its start there, and how long the way before it is.
#[cold]
#[inline(never)]
pub(crate) fn start(job: &Job<'_>, ray: &Ray, time: f32) -> (Ray, MediumStack, f32) {
    let near = job.near(ray, time);
    let ray = beyond(ray, near);
    (ray, job.media.around(job.scene, ray.o, time), near * ray.d.length())
}

impl Job<'_> {
    /// How far along a camera ray its near plane lies, in lengths of its direction; 0 where nothing is clipped.
    #[cold]
    #[inline(never)]
    pub fn near(&self, ray: &Ray, time: f32) -> f32 {
        if self.camera.motion.is_some() { self.camera.at(time).near(ray) } else { self.camera.near(ray) }
    }

    /// Whether a place at `t` along a camera ray lies before its near plane, which is not farther than `near`.
    #[inline(always)]
    pub fn clips(&self, t: f32, near: f32, ray: &Ray, time: f32) -> bool {
        cfg!(not(without = "view")) && t < near && t < self.near(ray, time)
    }

    /// Whether a camera ray goes on behind what it met first.
    #[inline(always)]
    pub fn passes(&self, ray: &Ray, (hit, surface): (&Hit, &Surface), near: f32, time: f32) -> bool {
        let from_behind =
            || self.hides_backs && surface.ng.dot(ray.d) > 0.0 && self.is_passed(hit, ray, time);
        cfg!(not(without = "view")) && (self.clips(hit.t, near, ray, time) || from_behind())
    }

    #[inline(never)]
    fn is_passed(&self, hit: &Hit, ray: &Ray, time: f32) -> bool {
        is_passed(self.scene, hit, ray, time)
    }
}

/// What a camera ray sees, past all that it passes, in a scene without media: the hit, its surface, and its distance from
/// the lens. `first`: the distance of what it met first; `near`: that of the near plane at most.
#[cold]
#[inline(never)]
pub(crate) fn seen<V: Visibility>(
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
    /// The same for camera rays, which pass back faces.
    pub fn of_camera_ray(&self) -> TraceContext<'a, FromCamera<V>> {
        let visibility = FromCamera { inner: self.visibility, hides_backs: self.job.hides_backs };
        TraceContext { job: self.job, scene: self.scene, visibility, time: self.time, key: self.key }
    }
}

/// What stops a camera ray, of what stops others.
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

/// Of all surfaces, taken as solid, those that a camera ray does not pass.
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

/// The first surface that a camera ray sees, holes taken as solid.
pub(crate) fn solid(job: &Job<'_>, ray: &Ray, time: f32) -> Option<(Hit, Surface)> {
    let ray = &beyond(ray, job.near(ray, time));
    let (scene, hides_backs) = (job.scene, job.hides_backs);
    let hit = scene.accel.intersect(ray, time, &Shown { scene, ray, time, hides_backs })?;
    Some((hit, scene.accel.surface(ray, time, &hit)))
}

/// Distance along the view axis to what the middle of the picture shows when the shutter opens, in render units, holes
/// taken as solid; None where it shows nothing.
pub fn centre_depth(scene: &Scene, camera: &Camera, backfaces: Backfaces) -> Option<f32> {
    let (half, hides_backs) = (Vec2::splat(0.5), hides_backs(scene, backfaces));
    let ray = camera.ray((0, 0), half, (1, 1), half);
    let ray = &beyond(&ray, camera.near(&ray));
    let hit = scene.accel.intersect(ray, 0.0, &Shown { scene, ray, time: 0.0, hides_backs })?;
    Some((ray.at(hit.t) - camera.origin).dot(-camera.backward))
}
