//! Ray forecast: predicts the number of rays per pixel before any ray is traced. The forecast is an upper bound, as if
//! every ray hit a surface with the most lobes in the scene.

use crate::distribution::light_plan;
use crate::effects::Effect;
use crate::job::Job;
use crate::settings::{MethodKind, Settings};
use dapple_camera::Camera;
use dapple_lights::Light;
use dapple_materials::{Lobe, Lobes};
use dapple_sampling::SampleSet;
use dapple_scene::Scene;

/// Predicted rays per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    /// Samples over pixel, lens and time; 1 for an effect that the scene does not have or the settings switch off.
    pub outer: [u32; 3],
    /// Rays by number of preceding scattering events, at most [`LISTED`] of them.
    pub rows: Vec<DepthRow>,
    /// Rays beyond that number of scattering events.
    pub deeper: f64,
}

/// Maximum depth with a row of its own.
pub const LISTED: u32 = 1000;

/// Rays that start after the same number of scattering events.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DepthRow {
    /// Rays that arrive at a surface.
    pub arriving: f64,
    /// Shadow rays from these surfaces.
    pub light: f64,
    /// Reflected rays, including specular ones.
    pub glossy: f64,
    /// Transmitted rays, including specular ones.
    pub refract: f64,
    /// Rays sampled over the hemisphere.
    pub diffuse: f64,
    /// Path tracer: the one ray that continues the path.
    pub path: f64,
}

impl Forecast {
    /// All rays of a pixel.
    pub fn total(&self) -> f64 {
        let camera = self.rows.first().map_or(0.0, |row| row.arriving);
        let listed: f64 = self.rows.iter().map(|r| r.light + r.glossy + r.refract + r.diffuse + r.path).sum();
        camera + listed + self.deeper
    }
}

const DIFFUSE: Lobes = Lobes::of(Lobe::Diffuse);

/// The effects that are present in the scene for this camera.
pub fn present(scene: &Scene, camera: &Camera) -> Vec<Effect> {
    let bounds = scene.lobe_bounds();
    let any = |lobes: Lobes| bounds.iter().any(|of| of.meets(lobes));
    let has = |effect: &Effect| match effect {
        Effect::Pixel => true,
        Effect::Lens => camera.lens.is_some_and(|lens| lens.radius > 0.0),
        Effect::Time => crate::places::moves(scene),
        Effect::Light => scene.lights.iter().any(|light| match light {
            Light::Environment(e) => e.is_sampled(),
            light if light.is_area() => true,
            _ => false,
        }),
        Effect::Glossy => any(Lobes::REFLECTION.without(Lobes::DELTA)),
        Effect::Refract => any(Lobes::TRANSMISSION.without(Lobes::DELTA)),
        Effect::Diffuse => any(DIFFUSE),
    };
    Effect::ALL.into_iter().map(|(effect, _)| effect).filter(has).collect()
}

/// As [`present`], for these settings: if diffuse lobes are not sampled, an environment is an integral of its own, with
/// the light's sample set, even if it is constant.
pub fn present_in(scene: &Scene, camera: &Camera, settings: &Settings) -> Vec<Effect> {
    let has = present(scene, camera);
    let sky = scene.environment.is_some() && settings.plans.is_off(Effect::Diffuse);
    let light = |effect| effect == Effect::Light && sky && has.contains(&Effect::Diffuse);
    let all = Effect::ALL.into_iter().map(|(effect, _)| effect);
    all.filter(|&effect| has.contains(&effect) || light(effect)).collect()
}

/// The forecast for these settings.
pub fn forecast(scene: &Scene, camera: &Camera, settings: &Settings) -> Forecast {
    let job = Job::new(scene, camera, settings);
    match settings.kind() {
        MethodKind::Path => of_paths(settings, scene),
        MethodKind::Distribution => of_trees(&job),
    }
}

fn of_paths(settings: &Settings, scene: &Scene) -> Forecast {
    let n = f64::from(settings.spp().unwrap_or(1));
    let aims = if scene.light_choice.is_some() { n } else { 0.0 };
    let bounces = settings.bounces();
    let rows = (0..=bounces.min(LISTED)).map(|depth| match depth {
        d if d == bounces => DepthRow { arriving: n, ..DepthRow::default() },
        _ => DepthRow { arriving: n, light: aims, path: n, ..DepthRow::default() },
    });
    let deeper = f64::from(bounces.saturating_sub(LISTED + 1)) * (aims + n);
    Forecast { outer: [settings.spp().unwrap_or(1), 1, 1], rows: rows.collect(), deeper }
}

fn of_trees(job: &Job<'_>) -> Forecast {
    let plans = &job.integrals.first;
    let pixel = plans.pixel.count().max(1);
    let inner = |plan: SampleSet| if job.is_paired() { 1 } else { plan.count().max(1) };
    let outer = [pixel, inner(plans.lens), inner(plans.time)];
    let bounds = job.scene.lobe_bounds();
    let depths = job.settings.bounces();
    // The costliest materials at every depth, computed from the deepest level up, for paths of only smooth surfaces,
    // where the environment has as many samples as at the first hit, and for all other paths.
    let deepest = subtree(job, &bounds, depths.saturating_sub(LISTED));
    let (mut smooth, mut other) = (deepest, deepest);
    let mut costliest = Vec::new();
    for depth in (0..depths.min(LISTED)).rev() {
        let [first, below] = job.integrals.skies_at(depth);
        let seen = |sky, smooth| Hit::costliest(job, &bounds, depth, sky, (smooth, other));
        let (hits, costs): (Vec<Hit>, Vec<f64>) =
            [seen(first, smooth), seen(below, other)].into_iter().unzip();
        costliest.push([hits[0], hits[1]]);
        (smooth, other) = (costs[0], costs[1]);
    }
    let mut arriving = [outer.iter().map(|&n| f64::from(n)).product::<f64>(), 0.0];
    let mut rows = Vec::new();
    for hits in costliest.iter().rev().chain([&[Hit::default(); 2]]) {
        if arriving == [0.0; 2] {
            break;
        }
        let sum = |of: fn(&DepthRow) -> f64| arriving[0] * of(&hits[0].row) + arriving[1] * of(&hits[1].row);
        rows.push(DepthRow {
            arriving: arriving[0] + arriving[1],
            light: sum(|row| row.light),
            glossy: sum(|row| row.glossy),
            refract: sum(|row| row.refract),
            diffuse: sum(|row| row.diffuse),
            path: 0.0,
        });
        let others = arriving[0] * (hits[0].rays() - hits[0].smooth) + arriving[1] * hits[1].rays();
        arriving = [arriving[0] * hits[0].smooth, others];
    }
    let last =
        rows.last().filter(|_| rows.len() > costliest.len()).map_or(0.0, |row: &DepthRow| row.arriving);
    let deeper = if deepest > 1.0 { last * (deepest - 1.0) } else { 0.0 };
    Forecast { outer, rows, deeper }
}

/// Rays that leave one hit.
#[derive(Clone, Copy, Default)]
struct Hit {
    row: DepthRow,
    /// Continuing rays from smooth lobes.
    smooth: f64,
}

impl Hit {
    /// The material with the highest cost, and that cost in rays; `below` is the cost of a ray that continues by a
    /// smooth lobe, and by another lobe.
    fn costliest(
        job: &Job<'_>,
        bounds: &[Lobes],
        depth: u32,
        sky: SampleSet,
        below: (f64, f64),
    ) -> (Self, f64) {
        let of = |&lobes| {
            let hit = Self { row: one_hit(job, lobes, depth, sky), smooth: smooth_lobes(job, lobes, depth) };
            let on = hit.smooth * below.0 + (hit.rays() - hit.smooth) * below.1;
            (hit, 1.0 + hit.row.light + if hit.rays() > 0.0 { on } else { 0.0 })
        };
        bounds.iter().map(of).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((Self::default(), 1.0))
    }

    /// The continuing rays.
    fn rays(&self) -> f64 {
        self.row.glossy + self.row.refract + self.row.diffuse
    }
}

/// Number of lobes with a single direction.
fn smooth_lobes(job: &Job<'_>, lobes: Lobes, depth: u32) -> f64 {
    let plans = job.integrals.at(depth);
    let one = |kind, effect| {
        let is_spread = lobes.and(kind).spreads() && !plans.is_off(effect);
        if lobes.meets(kind) && !is_spread { 1.0 } else { 0.0 }
    };
    one(Lobes::REFLECTION, Effect::Glossy) + one(Lobes::TRANSMISSION, Effect::Refract)
}

/// Upper bound of the rays in the subtree of a ray with `levels` remaining scattering events, itself included, as if
/// every surface sent on the maximum number of rays of every kind.
fn subtree(job: &Job<'_>, bounds: &[Lobes], levels: u32) -> f64 {
    let [first, _] = job.integrals.skies_at(1);
    let most = |of: fn(&DepthRow) -> f64| {
        bounds.iter().map(|&lobes| of(&one_hit(job, lobes, 1, first))).fold(0.0, f64::max)
    };
    let (light, next) = (most(|row| row.light), most(|row| row.glossy + row.refract + row.diffuse));
    let levels = f64::from(levels);
    let vertices = match next {
        1.0 => levels,
        next => (libm::pow(next, levels) - 1.0) / (next - 1.0),
    };
    1.0 + vertices * (light + next)
}

/// Rays that leave one hit on a material.
fn one_hit(job: &Job<'_>, lobes: Lobes, depth: u32, sky: SampleSet) -> DepthRow {
    let plans = job.integrals.at(depth);
    let count = |plan: SampleSet| f64::from(if job.is_paired() { plan.count().min(1) } else { plan.count() });
    let is_spread = |kind, effect| lobes.and(kind).spreads() && !plans.is_off(effect);
    let rays = |kind, effect| match lobes.meets(kind) {
        false => 0.0,
        true if is_spread(kind, effect) => count(plans.of(effect)),
        true => 1.0,
    };
    let is_diffuse = lobes.meets(DIFFUSE);
    let receives = is_diffuse
        || is_spread(Lobes::REFLECTION, Effect::Glossy)
        || is_spread(Lobes::TRANSMISSION, Effect::Refract);
    DepthRow {
        arriving: 1.0,
        light: if receives { shadow_rays(job, depth, sky, is_diffuse, count) } else { 0.0 },
        glossy: rays(Lobes::REFLECTION, Effect::Glossy),
        refract: rays(Lobes::TRANSMISSION, Effect::Refract),
        diffuse: if is_diffuse { count(plans.diffuse) } else { 0.0 },
        path: 0.0,
    }
}

fn shadow_rays(
    job: &Job<'_>,
    depth: u32,
    sky: SampleSet,
    diffuse: bool,
    count: impl Fn(SampleSet) -> f64,
) -> f64 {
    let (scene, plans) = (job.scene, job.integrals.at(depth));
    let lights = scene.lights.iter().map(|light| count(light_plan(light, plans, || sky)));
    let on_diffuse = diffuse && plans.is_off(Effect::Diffuse) && scene.environment.is_some();
    lights.sum::<f64>() + if on_diffuse { count(sky) } else { 0.0 }
}
