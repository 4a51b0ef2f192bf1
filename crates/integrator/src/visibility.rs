//! Ray queries with alpha tests and back-face culling.
//!
//! The kernel is chosen once per render, either without alpha tests ([`Solid`]) or with alpha tests inside the
//! traversal loop ([`Cutout`]). A BLEND surface stops a ray with probability alpha, determined by a hash of the ray's
//! key and the triangle: passing through is not a bounce, does not increase the depth, and draws no number from another
//! dimension.

use dapple_geometry::{Hit, HitFilter, Opaque};
use dapple_math::Ray;
use dapple_sampling::Key;
use dapple_scene::Scene;
use glam::Vec3;

/// The ray queries, with or without alpha tests compiled in.
pub(crate) trait Visibility: Copy + Send + Sync {
    /// Media, transparent shadow rays and coincident surfaces are not handled, because the scene has none: see
    /// [`Job::is_plain`].
    ///
    /// [`Job::is_plain`]: crate::job::Job::is_plain
    const PLAIN: bool;
    /// Every surface stops every ray.
    const OPAQUE: bool;
    fn intersect(self, scene: &Scene, ray: &Ray, time: f32, key: Key) -> Option<Hit>;
    fn occluded(self, scene: &Scene, ray: &Ray, time: f32, key: Key) -> bool;
    /// Whether some surface that stops the ray `counts`. Tests all hits, in any order, until one counts.
    fn any(self, scene: &Scene, ray: &Ray, time: f32, key: Key, counts: &dyn Fn(&Hit) -> bool) -> bool;
    /// The nearest of the hits that `counts` accepts.
    fn closest_where(self, at: &Query<'_>, counts: &impl Fn(&Hit) -> bool) -> Option<Hit>;
    /// Whether `counts` accepts any hit.
    fn blocked_where(self, at: &Query<'_>, counts: &impl Fn(&Hit) -> bool) -> bool;
}

/// Accepts the hits that both the filter and `counts` accept.
struct Both<'a, F> {
    filter: F,
    counts: &'a dyn Fn(&Hit) -> bool,
}

impl<F: HitFilter<Hit>> HitFilter<Hit> for Both<'_, F> {
    const OPAQUE: bool = false;
    fn accept(&self, hit: &Hit) -> bool {
        self.filter.accept(hit) && (self.counts)(hit)
    }
}

/// A ray through a scene, for queries that count only some of the surfaces.
#[derive(Clone, Copy)]
pub(crate) struct Query<'a> {
    pub scene: &'a Scene,
    pub ray: &'a Ray,
    pub time: f32,
    pub key: Key,
}

/// Accepts the hits that both `counts` and `inner` accept.
struct Where<'a, I, F> {
    inner: I,
    counts: &'a F,
}

impl<I: HitFilter<Hit>, F: Fn(&Hit) -> bool> HitFilter<Hit> for Where<'_, I, F> {
    const OPAQUE: bool = false;
    fn accept(&self, hit: &Hit) -> bool {
        (self.counts)(hit) && (I::OPAQUE || self.inner.accept(hit))
    }
}

/// Every surface stops every ray.
#[derive(Clone, Copy)]
pub(crate) struct Solid<const PLAIN: bool>;

impl<const PLAIN: bool> Visibility for Solid<PLAIN> {
    const PLAIN: bool = PLAIN;
    const OPAQUE: bool = true;
    #[inline(always)]
    fn intersect(self, scene: &Scene, ray: &Ray, time: f32, _: Key) -> Option<Hit> {
        scene.accel.intersect(ray, time, &Opaque)
    }
    #[inline(always)]
    fn occluded(self, scene: &Scene, ray: &Ray, time: f32, _: Key) -> bool {
        scene.accel.occluded(ray, time, &Opaque)
    }
    #[inline(never)]
    fn any(self, scene: &Scene, ray: &Ray, time: f32, _: Key, counts: &dyn Fn(&Hit) -> bool) -> bool {
        scene.accel.occluded(ray, time, &Both { filter: Opaque, counts })
    }
    fn closest_where(self, at: &Query<'_>, counts: &impl Fn(&Hit) -> bool) -> Option<Hit> {
        at.scene.accel.intersect(at.ray, at.time, &Where { inner: Opaque, counts })
    }
    fn blocked_where(self, at: &Query<'_>, counts: &impl Fn(&Hit) -> bool) -> bool {
        at.scene.accel.occluded(at.ray, at.time, &Where { inner: Opaque, counts })
    }
}

/// Alpha MASK and BLEND, and back-face culling if requested.
#[derive(Clone, Copy)]
pub(crate) struct Cutout<const PLAIN: bool> {
    pub cull_backfaces: bool,
}

impl<const PLAIN: bool> Visibility for Cutout<PLAIN> {
    const PLAIN: bool = PLAIN;
    const OPAQUE: bool = false;
    fn intersect(self, scene: &Scene, ray: &Ray, time: f32, key: Key) -> Option<Hit> {
        scene.accel.intersect(ray, time, &self.filter(scene, ray, time, key))
    }
    fn occluded(self, scene: &Scene, ray: &Ray, time: f32, key: Key) -> bool {
        scene.accel.occluded(ray, time, &self.filter(scene, ray, time, key))
    }
    #[inline(never)]
    fn any(self, scene: &Scene, ray: &Ray, time: f32, key: Key, counts: &dyn Fn(&Hit) -> bool) -> bool {
        scene.accel.occluded(ray, time, &Both { filter: self.filter(scene, ray, time, key), counts })
    }
    fn closest_where(self, at: &Query<'_>, counts: &impl Fn(&Hit) -> bool) -> Option<Hit> {
        let inner = self.filter(at.scene, at.ray, at.time, at.key);
        at.scene.accel.intersect(at.ray, at.time, &Where { inner, counts })
    }
    fn blocked_where(self, at: &Query<'_>, counts: &impl Fn(&Hit) -> bool) -> bool {
        let inner = self.filter(at.scene, at.ray, at.time, at.key);
        at.scene.accel.occluded(at.ray, at.time, &Where { inner, counts })
    }
}

impl<const PLAIN: bool> Cutout<PLAIN> {
    fn filter<'a>(self, scene: &'a Scene, ray: &Ray, time: f32, key: Key) -> CutoutFilter<'a> {
        CutoutFilter { scene, d: ray.d, time, bits: key.bits(), cull_backfaces: self.cull_backfaces }
    }
}

struct CutoutFilter<'a> {
    scene: &'a Scene,
    d: Vec3,
    time: f32,
    bits: u64,
    cull_backfaces: bool,
}

impl HitFilter<Hit> for CutoutFilter<'_> {
    const OPAQUE: bool = false;
    fn accept(&self, hit: &Hit) -> bool {
        if self.cull_backfaces && !self.scene.is_double_sided(hit.object) && self.is_back(hit) {
            return false;
        }
        let opacity = self.scene.opacity(hit);
        opacity >= 1.0 || (opacity > 0.0 && unit_hash(self.bits, hit) < opacity)
    }
}

impl CutoutFilter<'_> {
    fn is_back(&self, hit: &Hit) -> bool {
        self.scene.accel.is_from_behind(hit, self.d, self.time)
    }
}

/// A number in [0, 1) computed from the ray's key and the primitive.
fn unit_hash(bits: u64, hit: &Hit) -> f32 {
    Key::hash([bits, (u64::from(hit.object) << 32) | u64::from(hit.primitive)]).unit()
}
