//! The random decisions that a render uses. The others are not drawn; since numbers are keyed by name, this changes no
//! other number.

use crate::effects::Effect;
use crate::settings::{ROULETTE_FROM, Settings, Strategy};
use dapple_camera::Camera;
use dapple_lights::Light;
use dapple_materials::{Lobe, Lobes};
use dapple_scene::Scene;

/// Random decisions of the path tracer that are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DimensionsUsed {
    pub pixel: bool,
    pub lens: bool,
    pub time: bool,
    /// Some light can be sampled, and some surface has a lobe that is not a delta lobe.
    pub next_event: bool,
    pub light_choice: bool,
    pub light_point: bool,
    pub lobe: bool,
    pub direction: bool,
    pub roulette: bool,
}

impl DimensionsUsed {
    pub fn new(scene: &Scene, camera: &Camera, settings: &Settings) -> Self {
        if settings.general {
            return Self { pixel: !settings.plans.is_off(Effect::Pixel), ..Self::ALL };
        }
        let bounds = scene.lobe_bounds();
        let spreads = bounds.iter().any(|lobes| lobes.spreads());
        let off = |effect| settings.plans.is_off(effect);
        let scatters = settings.bounces() > 0;
        let aimed: Vec<&Light> = match scene.light_choice {
            Some(_) if scatters && spreads => {
                scene.lights.iter().filter(|light| is_aimed_at(light, settings.strategy)).collect()
            }
            _ => Vec::new(),
        };
        let has_points = |light: &&Light| match light {
            light if light.is_area() => !off(Effect::Light),
            light => !light.is_delta(),
        };
        Self {
            pixel: !off(Effect::Pixel),
            lens: camera.lens.is_some(),
            time: crate::places::moves(scene) && !off(Effect::Time),
            next_event: !aimed.is_empty(),
            light_choice: aimed.len() > 1,
            light_point: aimed.iter().any(has_points),
            lobe: scatters && bounds.iter().any(|lobes| are_several(*lobes)),
            direction: scatters && spreads,
            roulette: settings.roulette() && settings.bounces() > ROULETTE_FROM,
        }
    }

    const ALL: Self = Self {
        pixel: true,
        lens: true,
        time: true,
        next_event: true,
        light_choice: true,
        light_point: true,
        lobe: true,
        direction: true,
        roulette: true,
    };
}

/// Whether a material has several kinds of lobes; the smooth and the rough variant of a lobe never occur together.
fn are_several(lobes: Lobes) -> bool {
    let kinds = [Lobes::of(Lobe::Diffuse), Lobes::REFLECTION, Lobes::TRANSMISSION];
    kinds.iter().filter(|kind| lobes.meets(**kind)).count() > 1
}

/// Whether the light is sampled: it is not black, not an environment that BSDF sampling covers, and not excluded by the
/// strategy.
fn is_aimed_at(light: &Light, strategy: Strategy) -> bool {
    match light {
        light if strategy == Strategy::BsdfOnly && !light.is_delta() => false,
        Light::Environment(e) => e.is_sampled(),
        light => !light.is_dark(),
    }
}
