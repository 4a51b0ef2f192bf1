//! Messages of `--verbose`: describe the steps of a command in sentences.

use crate::output::Outputs;
use dapple_integrator::scene::Scene;
use dapple_integrator::{Effect, MethodKind, Settings};

/// Describes a scene that has been read and built.
pub fn scene(scene: &Scene, load_seconds: f64, build_seconds: f64) -> String {
    let Scene { survey, cameras, .. } = scene;
    let counts = [
        counted(survey.triangles, "triangle"),
        counted(survey.shapes, "exact sphere or disk"),
        counted(survey.objects, "object"),
        counted(survey.materials, "material"),
        counted(survey.textures, "texture"),
        counted(survey.lights, "light"),
        counted(cameras.len(), "camera"),
    ];
    format!(
        "The scene has {}. Reading it took {:.2} s, building its acceleration structures and light tables \
         {:.2} s; it uses {:.1} MB.",
        listed(&counts.into_iter().flatten().collect::<Vec<_>>()),
        load_seconds,
        build_seconds,
        scene.memory_bytes() as f64 / 1e6,
    )
}

/// Describes a render that is about to start.
pub fn render(settings: &Settings) -> String {
    let (width, height) = settings.size;
    let part = settings.crop.map_or(String::new(), |c| {
        format!(", of which {}x{} from ({}, {}) are rendered", c.width(), c.height(), c.x0, c.y0)
    });
    let threads =
        settings.limits.threads.map_or(String::new(), |n| format!(" on {}", counted_always(n, "thread")));
    format!(
        "Rendering {width}x{height} pixels{part}, {}; paths of up to {}; {} filter; seed {}{threads}{}.",
        estimator(settings),
        counted_always(settings.max_bounces as usize, "scattering event"),
        settings.filter,
        settings.seed,
        settings
            .limits
            .time
            .map_or(String::new(), |limit| format!("; for at most {} s", limit.as_secs_f64())),
    )
}

/// Describes the estimator of the integrals.
fn estimator(settings: &Settings) -> String {
    match settings.kind() {
        MethodKind::Path => {
            let roulette = if settings.roulette() { "with" } else { "without" };
            let spp = match settings.spp() {
                Some(n) => format!("{} per pixel", counted_always(n as usize, "sample")),
                None => "as many samples per pixel as time allows".into(),
            };
            let adaptive = if settings.adaptive() { ", adaptive" } else { "" };
            format!(
                "by the path tracer {roulette} Russian roulette: {spp}{adaptive}, in the {} pattern",
                settings.pattern
            )
        }
        MethodKind::Distribution => {
            let plans = Effect::ALL.map(|(effect, name)| format!("{name} {}", settings.plans.of(effect)));
            format!("by the distribution tracer: {} samples, {}", settings.combine(), plans.join(", "))
        }
    }
}

/// Describes the images that are about to be written.
pub fn writing(outputs: &Outputs) -> String {
    let paths: Vec<String> = outputs.paths().map(|path| path.display().to_string()).collect();
    format!("Writing {}.", listed(&paths))
}

/// Formats a count such as `3 lights`; none if it is zero.
fn counted(n: usize, what: &str) -> Option<String> {
    (n > 0).then(|| counted_always(n, what))
}

pub fn counted_always(n: usize, what: &str) -> String {
    let many = match what.split_once(' ') {
        Some(("exact", _)) => "exact spheres and disks".into(),
        _ => format!("{what}s"),
    };
    format!("{n} {}", if n == 1 { what } else { &many })
}

/// Joins items as `a, b and c`.
fn listed(items: &[String]) -> String {
    match items {
        [] => "nothing".into(),
        [one] => one.clone(),
        [all @ .., last] => format!("{} and {last}", all.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences() {
        let items =
            |n: usize| -> Vec<String> { ["a", "b", "c"][..n].iter().map(|s| s.to_string()).collect() };
        assert_eq!([0, 1, 2, 3].map(|n| listed(&items(n))), ["nothing", "a", "a and b", "a, b and c"]);
        assert_eq!(counted(0, "light"), None);
        assert_eq!(counted_always(1, "light"), "1 light");
        assert_eq!(counted_always(2, "exact sphere or disk"), "2 exact spheres and disks");
        let said = render(&Settings::default().with_time_limit(std::time::Duration::from_secs(3)));
        assert_eq!(
            said,
            "Rendering 512x512 pixels, by the path tracer with Russian roulette: 64 samples per pixel, in the \
             sobol pattern; paths of up to 16 scattering events; box filter; seed 0; for at most 3 s."
        );
    }
}
