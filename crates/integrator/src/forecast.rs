//! How many rays will a pixel take? Worked out before the first one is traced: an upper bound, as if every ray met a
//! surface with the most lobes there are.

use crate::effects::{Effect, Plans};
use crate::kernel::Job;
use crate::kinds::{Kinds, Width};
use crate::settings::{Method, Settings};
use dapple_camera::Camera;
use dapple_lights::Light;
use dapple_sampling::Plan;
use dapple_scene::Scene;

/// Rays per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    /// Points over pixel, lens and time; 1 for what the scene does not have or the settings switch off.
    pub outer: [u32; 3],
    /// By scattering events so far.
    pub rows: Vec<Row>,
}

/// Rays that start after the same number of scattering events.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// Rays that arrive here and meet a surface.
    pub arriving: f64,
    /// Shadow rays from there.
    pub light: f64,
    /// Reflected rays, smooth ones included.
    pub glossy: f64,
    /// Transmitted rays, smooth ones included.
    pub refract: f64,
    /// Rays over the hemisphere.
    pub diffuse: f64,
    /// Path tracer: the one ray that goes on.
    pub path: f64,
}

impl Forecast {
    /// All rays of a pixel.
    pub fn total(&self) -> f64 {
        let camera = self.rows.first().map_or(0.0, |row| row.arriving);
        camera + self.rows.iter().map(|r| r.light + r.glossy + r.refract + r.diffuse + r.path).sum::<f64>()
    }
}

/// The effects that the scene, seen by this camera, has.
pub fn present(scene: &Scene, camera: &Camera) -> Vec<Effect> {
    let kinds = Kinds::used(scene);
    let has = |effect: &Effect| match effect {
        Effect::Pixel => true,
        Effect::Lens => camera.lens.is_some_and(|lens| lens.radius > 0.0),
        Effect::Time => crate::places::moves(scene),
        Effect::Light => scene.lights.iter().any(|light| match light {
            Light::Environment(e) => e.is_sampled(),
            light if light.is_area() => true,
            _ => false,
        }),
        Effect::Glossy => kinds.iter().any(|k| k.reflection == Width::Rough),
        Effect::Refract => kinds.iter().any(|k| k.transmission == Width::Rough),
        Effect::Diffuse => kinds.iter().any(|k| k.diffuse),
    };
    Effect::ALL.into_iter().map(|(effect, _)| effect).filter(has).collect()
}

/// The forecast for these settings.
pub fn forecast(scene: &Scene, camera: &Camera, settings: &Settings) -> Forecast {
    let job = Job::new(scene, camera, settings);
    match settings.method {
        Method::Path => of_paths(settings, scene),
        Method::Distribution => of_trees(&job),
    }
}

fn of_paths(settings: &Settings, scene: &Scene) -> Forecast {
    let n = f64::from(settings.spp.unwrap_or(1));
    let aims = if scene.light_choice.is_some() { n } else { 0.0 };
    let rows = (0..=settings.bounces()).map(|depth| match depth {
        d if d == settings.bounces() => Row { arriving: n, ..Row::default() },
        _ => Row { arriving: n, light: aims, path: n, ..Row::default() },
    });
    Forecast { outer: [settings.spp.unwrap_or(1), 1, 1], rows: rows.collect() }
}

fn of_trees(job: &Job<'_>) -> Forecast {
    let plans = &job.integrals.first;
    let pixel = plans.pixel.count().max(1);
    let inner = |plan: Plan| if job.is_paired() { 1 } else { plan.count().max(1) };
    let outer = [pixel, inner(plans.lens), inner(plans.time)];
    let kinds = Kinds::used(job.scene);
    let depths = job.settings.bounces();
    // The costliest material at every depth, found from the deepest.
    let mut below = 1.0;
    let mut costliest = Vec::new();
    for depth in (0..depths).rev() {
        let (row, cost) = kinds
            .iter()
            .map(|k| one_hit(job, k, depth))
            .map(|row| (row, 1.0 + row.light + (row.glossy + row.refract + row.diffuse) * below))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((Row::default(), 1.0));
        costliest.push(row);
        below = cost;
    }
    let mut arriving = outer.iter().map(|&n| f64::from(n)).product::<f64>();
    let mut rows = Vec::new();
    for row in costliest.iter().rev().chain([&Row::default()]) {
        if arriving == 0.0 {
            break;
        }
        rows.push(Row {
            arriving,
            light: arriving * row.light,
            glossy: arriving * row.glossy,
            refract: arriving * row.refract,
            diffuse: arriving * row.diffuse,
            path: 0.0,
        });
        arriving *= row.glossy + row.refract + row.diffuse;
    }
    Forecast { outer, rows }
}

/// Rays that leave one hit on a material.
fn one_hit(job: &Job<'_>, kinds: &Kinds, depth: u32) -> Row {
    let plans = job.integrals.at(depth);
    let count = |plan: Plan| f64::from(if job.is_paired() { plan.count().min(1) } else { plan.count() });
    let lobe = |kind, effect| match kind {
        Width::Absent => 0.0,
        Width::Rough if !plans.is_off(effect) => count(plans.of(effect)),
        Width::Smooth | Width::Rough => 1.0,
    };
    let receives = kinds.diffuse
        || (kinds.reflection == Width::Rough && !plans.is_off(Effect::Glossy))
        || (kinds.transmission == Width::Rough && !plans.is_off(Effect::Refract));
    Row {
        arriving: 1.0,
        light: if receives { shadow_rays(job.scene, plans, kinds.diffuse, count) } else { 0.0 },
        glossy: lobe(kinds.reflection, Effect::Glossy),
        refract: lobe(kinds.transmission, Effect::Refract),
        diffuse: if kinds.diffuse { count(plans.diffuse) } else { 0.0 },
        path: 0.0,
    }
}

fn shadow_rays(scene: &Scene, plans: &Plans, diffuse: bool, count: impl Fn(Plan) -> f64) -> f64 {
    let lights = scene.lights.iter().map(|light| count(crate::distribution::light_plan(light, plans)));
    let sky = diffuse && plans.is_off(Effect::Diffuse) && scene.environment.is_some();
    lights.sum::<f64>() + f64::from(u8::from(sky))
}
