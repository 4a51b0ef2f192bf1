//! Which variant of the sample loop a render runs: one table, chosen once per render.

use crate::clear::{self, media_start};
use crate::custom::{Integrator, SampleContext};
use crate::distribution::pixel_point;
use crate::effects::{Combine, Effect};
use crate::first_hit::{self, Backfaces};
use crate::medium::{Media, MediumStack};
use crate::needs::Needs;
use crate::path::{self, Follow};
use crate::places::Integrals;
use crate::sample::Sample;
use crate::settings::{MethodKind, Settings};
use crate::tile::FirstHit;
use crate::visibility::{Cutout, Solid, Visibility};
use dapple_camera::{Aperture, Camera, Lens};
use dapple_lights::Aiming;
use dapple_materials::{Lobe, Lobes};
use dapple_scene::Scene;
use glam::Vec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What is the same for all samples of a render.
pub(crate) struct Job<'a> {
    pub scene: &'a Scene,
    /// Without its lens when that is off, without clipping planes that clip nothing, and with the whole frame in the picture.
    pub camera: Camera,
    pub settings: &'a Settings,
    /// Random decisions of the path tracer.
    pub needs: Needs,
    /// Points of the distribution tracer's integrals.
    pub integrals: Integrals,
    /// Lobes whose blur is off.
    pub sharp: Lobes,
    /// Lobes by which a path goes on.
    pub followed: Lobes,
    /// How the path tracer aims at area lights.
    pub aiming: Aiming,
    /// Points drawn anew, to see what they matter: all within a point of the pixel, the lens or the time; or those of
    /// one integral at the first hit.
    pub again: Option<Effect>,
    /// Scattering events that are followed.
    pub bounces: u32,
    /// Once set, samples under way end as soon as they can, and what they are is not to be kept.
    pub stop: Arc<AtomicBool>,
    /// Takes the place of the settings' method.
    pub custom: Option<&'a dyn Integrator>,
    /// How far along a camera ray the near plane can be at most, in lengths of its direction; 0 where nothing is clipped.
    pub near_most: f32,
    /// Camera rays pass some back faces.
    pub hides_backs: bool,
    /// What fills the scene's bodies.
    pub media: Media<'a>,
    /// Shadow rays that start outside of all bodies pass some surfaces.
    pub clear_ways: bool,
    /// Among them boundaries of bodies.
    pub clear_bodies: bool,
    /// Shadow rays pass nothing, and nothing absorbs on their way.
    pub plain_shadows: bool,
}

impl<'a> Job<'a> {
    pub fn new(scene: &'a Scene, camera: &Camera, settings: &'a Settings) -> Self {
        let off = |effect| settings.plans.is_off(effect);
        let mut camera = camera.clone().fitted(settings.size);
        camera.clip = first_hit::needed_clip(scene, &camera);
        camera.lens = camera.lens.filter(|lens| lens.radius > 0.0 && !off(Effect::Lens));
        if settings.general {
            // A lens of radius 0 is a pinhole to the last bit.
            camera.lens.get_or_insert(Lens { aperture: Aperture::Disk, radius: 0.0, focus_distance: 1.0 });
        }
        let mut sharp = Lobes::NONE;
        if off(Effect::Glossy) {
            sharp = sharp.with(Lobe::GlossyReflection).with(Lobe::Mirror);
        }
        if off(Effect::Refract) {
            sharp = sharp.with(Lobe::GlossyTransmission);
        }
        let clear_bodies = settings.transparent_shadows || clear::any_body(scene);
        let clear_ways = clear_bodies || clear::any_wall(scene, off(Effect::Refract));
        let media = Media::new(scene, media_start(scene, &camera));
        let unfollowed = if off(Effect::Diffuse) { Lobes::of(Lobe::Diffuse) } else { Lobes::NONE };
        Self {
            needs: Needs::new(scene, &camera, settings),
            integrals: Integrals::new(scene, &camera, settings),
            bounces: settings.bounces(),
            scene,
            settings,
            sharp,
            followed: Lobes::ALL.without(unfollowed),
            aiming: if off(Effect::Light) { Aiming::Centroid } else { Aiming::SolidAngle },
            again: None,
            near_most: first_hit::farthest_near(&camera, settings.size),
            hides_backs: first_hit::hides_backs(scene, settings.backfaces),
            plain_shadows: media.is_empty() && !clear_ways,
            media,
            clear_ways,
            clear_bodies,
            camera,
            stop: Arc::default(),
            custom: None,
        }
    }

    /// Whether samples under way are to end.
    #[inline(always)]
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Whether a shadow ray within `stack` may pass an object's surface.
    pub fn may_pass(&self, object: u32, stack: &MediumStack) -> bool {
        let material = self.scene.material(object);
        material.transmits() && (material.base.thin || self.clear_bodies || !stack.is_empty())
    }

    /// Whether back faces of single-sided materials are there for no ray.
    pub fn is_culled(&self) -> bool {
        self.settings.backfaces == Backfaces::Culled
    }

    /// Whether rays ask surfaces for holes.
    pub fn asks_alpha(&self) -> bool {
        cfg!(not(without = "alpha")) && (self.scene.has_alpha() || self.is_culled() || self.settings.general)
    }

    /// Whether no ray meets media, clear surfaces that shadow rays pass, or several surfaces in one place.
    pub fn is_plain(&self) -> bool {
        self.plain_shadows && self.scene.shared_places.is_none() && !self.settings.general
    }

    pub fn is_paired(&self) -> bool {
        self.integrals.combine == Combine::Paired
    }

    pub fn lights_are_points(&self) -> bool {
        self.aiming == Aiming::Centroid
    }

    pub fn has_no_interreflection(&self) -> bool {
        self.followed != Lobes::ALL
    }
}

/// Radiance and filter weight of sample `index` of pixel (x, y); fills `first` if the kernel watches the first hit, and
/// its ledger in any case.
pub(crate) type Kernel =
    fn(&Job<'_>, pixel: (u32, u32), index: u32, first: &mut FirstHit, rays: &mut u64) -> (Vec3, f32);

/// The smallest kernel that covers the job, and its name.
pub(crate) fn choose(job: &Job<'_>) -> (Kernel, &'static str) {
    if job.custom.is_some() {
        return (custom, "custom");
    }
    let alpha = job.asks_alpha();
    let watched = cfg!(not(without = "layers"))
        && (job.settings.general
            || job.settings.transparent
            || job.settings.aovs.iter().any(|aov| aov.needs_first_hit()));
    if job.is_plain() && !watched {
        return match (job.settings.kind(), alpha) {
            (MethodKind::Path, false) => (path_plain, "path"),
            (MethodKind::Path, true) => (path_plain_alpha, "path+alpha"),
            (MethodKind::Distribution, false) => (distribution_plain, "distribution"),
            (MethodKind::Distribution, true) => (distribution_plain_alpha, "distribution+alpha"),
        };
    }
    match (job.settings.kind(), alpha, watched) {
        (MethodKind::Path, false, false) => (path_solid, "path"),
        (MethodKind::Path, false, true) => (path_solid_watched, "path+first-hit"),
        (MethodKind::Path, true, false) => (path_alpha, "path+alpha"),
        (MethodKind::Path, true, true) => (path_alpha_watched, "path+alpha+first-hit"),
        (MethodKind::Distribution, false, false) => (distribution_solid, "distribution"),
        (MethodKind::Distribution, false, true) => (distribution_solid_watched, "distribution+first-hit"),
        (MethodKind::Distribution, true, false) => (distribution_alpha, "distribution+alpha"),
        (MethodKind::Distribution, true, true) => {
            (distribution_alpha_watched, "distribution+alpha+first-hit")
        }
    }
}

macro_rules! kernel {
    ($name:ident, $sample:ident, $visibility:expr, $first:ident, $follow:expr) => {
        fn $name(
            job: &Job<'_>,
            pixel: (u32, u32),
            index: u32,
            $first: &mut FirstHit,
            rays: &mut u64,
        ) -> (Vec3, f32) {
            $sample(job, $visibility(job), pixel, index, $follow, rays)
        }
    };
}

fn solid(_: &Job<'_>) -> Solid<false> {
    Solid
}

fn cutout<const PLAIN: bool>(job: &Job<'_>) -> Cutout<PLAIN> {
    Cutout { cull_backfaces: job.is_culled() }
}

fn plain(_: &Job<'_>) -> Solid<true> {
    Solid
}

kernel!(path_plain, path_sample, plain, first, &mut first.ledger);
kernel!(path_plain_alpha, path_sample, cutout::<true>, first, &mut first.ledger);
kernel!(distribution_plain, pixel_point, plain, first, &mut first.ledger);
kernel!(distribution_plain_alpha, pixel_point, cutout::<true>, first, &mut first.ledger);

kernel!(path_solid, path_sample, solid, first, &mut first.ledger);
kernel!(path_solid_watched, path_sample, solid, first, first);
kernel!(path_alpha, path_sample, cutout::<false>, first, &mut first.ledger);
kernel!(path_alpha_watched, path_sample, cutout::<false>, first, first);
kernel!(distribution_solid, pixel_point, solid, first, &mut first.ledger);
kernel!(distribution_solid_watched, pixel_point, solid, first, first);
kernel!(distribution_alpha, pixel_point, cutout::<false>, first, &mut first.ledger);
kernel!(distribution_alpha_watched, pixel_point, cutout::<false>, first, first);

/// One sample of the settings' method, with whoever follows it.
pub(crate) fn followed<F: Follow>(
    job: &Job<'_>,
    pixel: (u32, u32),
    index: u32,
    follow: &mut F,
    rays: &mut u64,
) -> (Vec3, f32) {
    match (job.settings.kind(), job.asks_alpha()) {
        (MethodKind::Path, false) => path_sample(job, solid(job), pixel, index, follow, rays),
        (MethodKind::Path, true) => path_sample(job, cutout::<false>(job), pixel, index, follow, rays),
        (MethodKind::Distribution, false) => pixel_point(job, solid(job), pixel, index, follow, rays),
        (MethodKind::Distribution, true) => {
            pixel_point(job, cutout::<false>(job), pixel, index, follow, rays)
        }
    }
}

/// One camera ray, whose radiance the caller's integrator says.
fn custom(job: &Job<'_>, pixel: (u32, u32), index: u32, _: &mut FirstHit, rays: &mut u64) -> (Vec3, f32) {
    let Some(integrator) = job.custom else { return (Vec3::ZERO, 1.0) };
    let sample = Sample::new(job.settings, pixel, index).timed(job);
    let (ray, weight) = sample.camera_ray(job, pixel);
    let context = SampleContext::new(job, sample);
    let radiance = integrator.radiance(&ray, &context);
    *rays += context.rays();
    (radiance, weight)
}

/// One path from pixel to radiance.
#[inline(always)]
fn path_sample<V: Visibility, F: Follow>(
    job: &Job<'_>,
    visibility: V,
    pixel: (u32, u32),
    index: u32,
    follow: &mut F,
    rays: &mut u64,
) -> (Vec3, f32) {
    let sample = Sample::new(job.settings, pixel, index).timed(job);
    let (ray, weight) = sample.camera_ray(job, pixel);
    (path::li(job, visibility, ray, &sample, follow, rays), weight)
}
