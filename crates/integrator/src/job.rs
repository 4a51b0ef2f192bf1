//! What is the same for all samples of a render: the scene and the settings, and what follows from them, worked out once.

use crate::clear::{self, media_start};
use crate::culling::{self, Backfaces};
use crate::dimensions_used::DimensionsUsed;
use crate::effects::{Combine, Effect};
use crate::medium::{Media, MediumStack};
use crate::places::Integrals;
use crate::settings::Settings;
use dapple_camera::{Aperture, Camera, Lens};
use dapple_lights::Aiming;
use dapple_materials::{BsdfSample, Lobe, Lobes};
use dapple_scene::Scene;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What is the same for all samples of a render.
pub(crate) struct Job<'a> {
    pub scene: &'a Scene,
    /// Without its lens when that is off, without clipping planes that clip nothing, and with the whole frame in the picture.
    pub camera: Camera,
    pub settings: &'a Settings,
    /// Random decisions of the path tracer.
    pub needs: DimensionsUsed,
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
        camera.clip = culling::needed_clip(scene, &camera);
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
        let clear_ways = clear_bodies || clear::any_wall(scene, sharp);
        let media = Media::new(scene, media_start(scene, &camera));
        let unfollowed = if off(Effect::Diffuse) { Lobes::of(Lobe::Diffuse) } else { Lobes::NONE };
        Self {
            needs: DimensionsUsed::new(scene, &camera, settings),
            integrals: Integrals::new(scene, &camera, settings),
            bounces: settings.bounces(),
            scene,
            settings,
            sharp,
            followed: Lobes::ALL.without(unfollowed),
            aiming: if off(Effect::Light) { Aiming::Centroid } else { Aiming::SolidAngle },
            again: None,
            near_most: culling::farthest_near(&camera, settings.size),
            hides_backs: culling::hides_backs(scene, settings.backfaces),
            plain_shadows: media.is_empty() && !clear_ways,
            media,
            clear_ways,
            clear_bodies,
            camera,
            stop: Arc::default(),
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
        material.transmits() && (material.is_thin() || self.clear_bodies || !stack.is_empty())
    }

    /// Whether a path that goes on like this takes the way that a shadow ray takes.
    pub fn is_shadow_way(&self, sample: &BsdfSample) -> bool {
        sample.lobe == Lobe::DeltaTransmission && (sample.eta == 1.0 || self.settings.transparent_shadows)
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
