//! A stopped render ends within a sample, and its result is that of the completed rounds.

mod common;

use common::run;
use dapple_integrator::math::PixelRect;
use dapple_integrator::sampling::{Pattern, SampleSet};
use dapple_integrator::{
    Aov, MethodKind, Outcome, Progress, SampleSets, Settings, render, render_pixels_until,
};
use dapple_scene::Scene;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

fn cornell() -> Scene {
    dapple_scene::builtin::builtin("cornell").unwrap().build().unwrap()
}

fn stopped(scene: &Scene, settings: &Settings, enough: impl Fn(&Progress) -> bool + Sync) -> Outcome {
    render(scene, &scene.cameras[0].camera, settings, &|progress| match enough(&progress) {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    })
}

/// The minimum and maximum sample counts of the pixels.
fn counts(outcome: &Outcome) -> [u64; 2] {
    let rect = outcome.film.rect();
    let all = (rect.y0..rect.y1).flat_map(|y| (rect.x0..rect.x1).map(move |x| (x, y)));
    all.fold([u64::MAX, 0], |[low, high], (x, y)| {
        let n = outcome.film.count(x, y);
        [low.min(n), high.max(n)]
    })
}

/// A pixel sample that would take hours: a request to stop takes effect within it.
fn endless() -> Settings {
    let many = SampleSet::new(1 << 20, Pattern::Random);
    let plans = SampleSets {
        pixel: SampleSet::new(1, Pattern::Grid),
        light: many,
        diffuse: many,
        ..SampleSets::default()
    };
    let aovs = vec![Aov::Depth];
    // All of its rays meet the walls: a ray that leaves the scene would be a finished sample.
    let crop = Some(PixelRect { x0: 3, y0: 3, x1: 6, y1: 6 });
    Settings { size: (8, 8), crop, plans, aovs, ..Settings::default() }
        .with_method(MethodKind::Distribution)
        .with_distribution(|d| d.secondary = 1000)
}

#[test]
fn a_request_is_heard_within_a_sample() {
    let scene = cornell();
    for threads in [1, 2] {
        let settings = endless().with_threads(threads);
        let start = Instant::now();
        let outcome = stopped(&scene, &settings, |p| p.elapsed > Duration::from_millis(100));
        // A tenth of a second, plus the delay of a busy machine.
        assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
        let stats = &outcome.stats;
        assert_eq!((stats.spp, stats.stopped, stats.timed_out), (0, true, false));
        assert_eq!(counts(&outcome), [0, 0]);
        let names: Vec<&str> = outcome.layers.layers.iter().map(|layer| layer.name.as_str()).collect();
        assert_eq!(names, ["", "depth", "samples"]);
    }
}

#[test]
fn time_is_up_within_a_sample() {
    let settings = endless().with_time_limit(Duration::from_millis(100));
    let start = Instant::now();
    let outcome = run(&cornell(), &settings);
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
    assert_eq!((outcome.stats.spp, outcome.stats.stopped, outcome.stats.timed_out), (0, false, true));
}

/// After n rounds, an interrupted render is the image of n rounds, bit for bit, and so are its layers and counts.
#[test]
fn whole_rounds_are_kept_to_the_bit() {
    let scene = cornell();
    let path = Settings {
        size: (40, 24),
        pattern: Pattern::Random,
        aovs: vec![Aov::Normal, Aov::Depth, Aov::ObjectId, Aov::Removed, Aov::Variance],
        max_bounces: 3,
        ..Settings::default()
    }
    .with_spp(1_000_000);
    for threads in [1, 2] {
        let settings = path.clone().with_threads(threads);
        // Between passes, and at some time within a pass.
        let found = stopped(&scene, &settings, |p| p.spp >= 5 && p.elapsed > Duration::from_millis(70));
        let spp = found.stats.spp;
        assert!(found.stats.stopped && (5..1_000_000).contains(&spp));
        assert_eq!(counts(&found), [u64::from(spp); 2]);
        let whole = run(&scene, &settings.with_spp(spp));
        assert_eq!(found.film, whole.film);
        assert_eq!((found.stats.rays, found.stats.bias), (whole.stats.rays, whole.stats.bias));
        assert_eq!(found.layers.layers.len(), whole.layers.layers.len());
        for (a, b) in found.layers.layers.iter().zip(&whole.layers.layers) {
            let bits = |l: &dapple_imaging::Layer| -> Vec<u32> {
                l.channels.iter().flat_map(|c| c.1.iter().map(|v| v.to_bits())).collect()
            };
            assert!(a.name == b.name && bits(a) == bits(b), "{}", a.name);
        }
    }
}

#[test]
fn time_leaves_whole_rounds() {
    let scene = cornell();
    let plans = SampleSets {
        pixel: SampleSet::new(3, Pattern::Stratified),
        light: SampleSet::new(2, Pattern::Random),
        ..SampleSets::default()
    };
    let time_limit = Some(Duration::from_millis(400));
    for method in [MethodKind::Path, MethodKind::Distribution] {
        for spp in [None, Some(1 << 30)] {
            let settings = Settings { size: (12, 8), plans, ..Settings::default() }
                .with_method(method)
                .with_time_limit(time_limit)
                .with_spp(spp);
            let start = Instant::now();
            let found = run(&scene, &settings);
            assert!(start.elapsed() < Duration::from_secs(10));
            let spp = found.stats.spp;
            assert!(spp > 0 && spp.is_multiple_of(settings.round()) && found.stats.timed_out);
            assert_eq!(counts(&found), [u64::from(spp); 2]);
        }
    }
    let enough = Settings { size: (4, 4), ..Settings::default() }
        .with_time_limit(Duration::from_secs(100))
        .with_spp(2);
    let found = run(&scene, &enough);
    assert_eq!((found.stats.spp, found.stats.timed_out, found.stats.stopped), (2, false, false));
}

/// If not even one round is complete, whole samples are kept, and their counts are a layer.
#[test]
fn the_first_round_keeps_what_it_has() {
    let scene = cornell();
    let settings = Settings { size: (512, 512), ..Settings::default() }.with_threads(1).with_spp(4);
    let found = stopped(&scene, &settings, |p| p.rays > 50_000);
    assert_eq!((found.stats.spp, found.stats.stopped), (0, true));
    assert_eq!(counts(&found), [0, 1]);
    let one = run(&scene, &Settings { pattern: Pattern::Random, ..settings.clone() }.with_spp(1));
    assert_eq!(counts(&one), [1, 1]);
    let layer = &found.layers.layers[1];
    let sum: f64 = layer.channels[0].1.iter().map(|n| f64::from(*n)).sum();
    assert_eq!((layer.name.as_str(), sum), ("samples", found.stats.samples as f64));
    // The pixels that have a sample have the correct one.
    let pattern = Pattern::Random;
    let found = stopped(&scene, &Settings { pattern, ..settings }, |p| p.rays > 50_000);
    let rect = found.film.rect();
    let all = (rect.y0..rect.y1).flat_map(|y| (rect.x0..rect.x1).map(move |x| (x, y)));
    for (x, y) in all.filter(|(x, y)| found.film.count(*x, *y) > 0) {
        assert_eq!(found.film.mean_at(x, y), one.film.mean_at(x, y));
    }
}

/// A render that is stopped before it begins has no samples, and the caller is asked from the start.
#[test]
fn pixels_alone_can_be_stopped() {
    let scene = cornell();
    let camera = &scene.cameras[0].camera;
    let settings = Settings { size: (8, 8), ..Settings::default() }.with_threads(2);
    let pixels = [(1, 2), (3, 4), (5, 6)];
    assert!(render_pixels_until(&scene, camera, &settings, 4, &pixels, &|| false).is_some());
    let start = Instant::now();
    let asked = AtomicU32::new(0);
    let stop = || asked.fetch_add(1, Ordering::Relaxed) > 1;
    assert_eq!(render_pixels_until(&scene, camera, &settings, u32::MAX, &pixels, &stop), None);
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
}
