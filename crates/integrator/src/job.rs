//! Data shared by all samples of a render: the scene, the settings, and everything derived from them.

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

/// Data shared by all samples of a render.
pub(crate) struct Job<'a> {
    pub scene: &'a Scene,
    /// The camera without its lens if that is off, without clipping planes that clip nothing, and fitted to the image
    /// size.
    pub camera: Camera,
    pub settings: &'a Settings,
    /// Random decisions of the path tracer.
    pub needs: DimensionsUsed,
    /// Sample sets of the distribution tracer's integrals.
    pub integrals: Integrals,
    /// Lobes whose roughness is switched off.
    pub sharp: Lobes,
    /// Lobes that BSDF sampling continues a path with.
    pub followed: Lobes,
    /// How the path tracer samples area lights.
    pub aiming: Aiming,
    /// The effect whose points are drawn anew, for the analysis of variance: everything inside a point of the pixel,
    /// the lens or the time; or the points of one integral at the first hit.
    pub again: Option<Effect>,
    /// Maximum number of scattering events.
    pub bounces: u32,
    /// Whether paths are ended by Russian roulette.
    pub roulette: bool,
    /// Once set, samples in progress end as soon as they can, and their results must be discarded.
    pub stop: Arc<AtomicBool>,
    /// Upper bound of the ray parameter of the near plane along camera rays; 0 where nothing is clipped.
    pub near_most: f32,
    /// Camera rays pass some back faces.
    pub hides_backs: bool,
    /// Media of the scene's bodies.
    pub media: Media<'a>,
    /// Shadow rays that start outside of all bodies pass some surfaces.
    pub clear_ways: bool,
    /// Shadow rays that start outside of all bodies pass some boundaries of bodies.
    pub clear_bodies: bool,
    /// Shadow rays pass nothing, and no medium absorbs along them.
    pub plain_shadows: bool,
}

impl<'a> Job<'a> {
    pub fn new(scene: &'a Scene, camera: &Camera, settings: &'a Settings) -> Self {
        let off = |effect| settings.plans.is_off(effect);
        let mut camera = camera.clone().fitted(settings.size);
        camera.clip = culling::needed_clip(scene, &camera);
        camera.lens = camera.lens.filter(|lens| lens.radius > 0.0 && !off(Effect::Lens));
        if settings.general {
            // A lens of radius 0 is equivalent to a pinhole, bit for bit.
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
            roulette: settings.roulette(),
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

    /// Whether samples in progress must end.
    #[inline(always)]
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Whether a shadow ray within `stack` may pass an object's surface.
    pub fn may_pass(&self, object: u32, stack: &MediumStack) -> bool {
        let material = self.scene.material(object);
        material.transmits() && (material.is_thin() || self.clear_bodies || !stack.is_empty())
    }

    /// Whether a path that continues with this sample takes the same way as a shadow ray.
    pub fn is_shadow_way(&self, sample: &BsdfSample) -> bool {
        sample.lobe == Lobe::DeltaTransmission && (sample.eta == 1.0 || self.settings.transparent_shadows)
    }

    /// Whether back faces of single-sided materials are invisible to all rays.
    pub fn is_culled(&self) -> bool {
        self.settings.backfaces == Backfaces::Culled
    }

    /// Whether rays evaluate the alpha of surfaces.
    pub fn asks_alpha(&self) -> bool {
        cfg!(not(without = "alpha")) && (self.scene.has_alpha() || self.is_culled() || self.settings.general)
    }

    /// Whether the scene has no media, no transparent surfaces that shadow rays pass, and no coincident surfaces.
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
