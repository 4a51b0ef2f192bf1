//! Snapshots of a render in progress do not change it.

use dapple_integrator::sampling::Pattern;
use dapple_integrator::{MethodKind, Settings, render, render_pixels, render_watched, scene};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

fn settings(pattern: Pattern, spp: u32) -> Settings {
    Settings { size: (20, 12), pattern, ..Settings::default() }.with_threads(2).with_spp(spp)
}

#[test]
fn no_bit_depends_on_looking() {
    let scene = scene::builtin::builtin("cornell").unwrap().build().unwrap();
    let camera = &scene.cameras[0].camera;
    for pattern in [Pattern::Sobol, Pattern::Stratified] {
        let settings = settings(pattern, 24);
        let plain = render(&scene, camera, &settings, &|_| ControlFlow::Continue(()));
        let mut seen = Vec::new();
        let watched = render_watched(&scene, camera, &settings, &|_| ControlFlow::Continue(()), &mut |at| {
            assert_eq!(at.film().count(3, 3), u64::from(at.spp));
            seen.push((at.spp, at.film(), at.rays(), at.seconds));
            ControlFlow::Continue(())
        });
        assert_eq!(plain.film, watched.film);
        assert_eq!(seen.iter().map(|s| s.0).collect::<Vec<_>>(), [1, 3, 6, 12, 24]);
        assert!(seen[4].1 == plain.film && seen[4].2 == plain.stats.rays);
        assert!(seen.windows(2).all(|w| w[0].3 < w[1].3));
    }
}

/// The first n samples of a longer Sobol or random sequence are those of n samples, from 16 on.
#[test]
fn sequences_can_be_looked_at() {
    let scene = scene::builtin::builtin("cornell").unwrap().build().unwrap();
    let camera = &scene.cameras[0].camera;
    for pattern in [Pattern::Sobol, Pattern::Random] {
        let mut at_16 = None;
        render_watched(&scene, camera, &settings(pattern, 64), &|_| ControlFlow::Continue(()), &mut |at| {
            if at.spp == 16 {
                at_16 = Some(at.film());
            }
            ControlFlow::Continue(())
        });
        let alone = render(&scene, camera, &settings(pattern, 16), &|_| ControlFlow::Continue(()));
        assert_eq!(at_16, Some(alone.film));
    }
}

/// Individually rendered pixels equal those of the image, for all patterns.
#[test]
fn pixels_alone() {
    let scene = scene::builtin::builtin("cornell").unwrap().build().unwrap();
    let camera = &scene.cameras[0].camera;
    let tree = settings(Pattern::Sobol, 1).with_method(MethodKind::Distribution);
    let paths = [Pattern::Sobol, Pattern::Stratified, Pattern::Random].map(|p| settings(p, 24));
    let adaptive = settings(Pattern::Sobol, 24).with_path(|p| p.adaptive = true);
    for settings in paths.into_iter().chain([tree, adaptive]) {
        let whole = render(&scene, camera, &settings, &|_| ControlFlow::Continue(()));
        let pixels = [(3, 2), (19, 11), (3, 2), (0, 7)];
        let allocation = whole.allocation.clone();
        let found = render_pixels(
            &scene,
            camera,
            &settings.with_path(|p| p.allocation = allocation),
            whole.stats.spp,
            &pixels,
        );
        assert_eq!(found, pixels.map(|(x, y)| whole.film.mean_at(x, y)));
        assert!(render_pixels(&scene, camera, &Settings::default(), 1, &[]).is_empty());
    }
}

/// A requested snapshot is taken between two doublings of the sample count.
#[test]
fn asked_looks() {
    let scene = scene::builtin::builtin("cornell").unwrap().build().unwrap();
    let camera = &scene.cameras[0].camera;
    let seen = |settings: &Settings, ask: &[(u32, u32)]| {
        let mut seen = Vec::new();
        render_watched(&scene, camera, settings, &|_| ControlFlow::Continue(()), &mut |at| {
            assert_eq!(at.film().count(3, 3), u64::from(at.spp));
            seen.push((at.spp, at.between));
            ask.iter().filter(|(n, _)| *n == at.spp).for_each(|(_, more)| at.also_at(*more));
            ControlFlow::Continue(())
        });
        seen
    };
    let found = seen(&settings(Pattern::Sobol, 32), &[(4, 21), (16, 20), (20, 5), (21, 27)]);
    let regular = |n: u32| (n, false);
    // At 16 another count was requested in place of 21, at 20 one that had passed.
    assert_eq!(
        found,
        [1, 2, 4, 8, 16].map(regular).into_iter().chain([(20, true), (32, false)]).collect::<Vec<_>>()
    );
    let time_limit = Some(Duration::from_secs(1000));
    let tree = settings(Pattern::Sobol, 1).with_method(MethodKind::Distribution).with_time_limit(time_limit);
    let mut counts = Vec::new();
    render_watched(&scene, camera, &tree, &|_| ControlFlow::Continue(()), &mut |at| {
        counts.push(at.spp);
        if at.spp == 32 {
            at.also_at(40);
        }
        if at.spp >= 48 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert_eq!(counts, [16, 32, 48]);
}

/// Ending a render from a snapshot is not an interruption, and snapshots take no render time.
#[test]
fn enough_is_enough() {
    let scene = scene::builtin::builtin("cornell").unwrap().build().unwrap();
    let camera = &scene.cameras[0].camera;
    let settings = settings(Pattern::Sobol, 1).with_spp(None);
    let (start, mut snapshots) = (Instant::now(), 0);
    let found = render_watched(&scene, camera, &settings, &|_| ControlFlow::Continue(()), &mut |at| {
        std::thread::sleep(Duration::from_millis(200));
        snapshots += 1;
        if at.spp >= 4 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert_eq!((found.stats.spp, found.stats.stopped), (4, false));
    let render = start.elapsed().as_secs_f64() - 0.2 * f64::from(snapshots);
    assert!(snapshots > 0 && found.stats.seconds <= render, "{} of {render}", found.stats.seconds);
}

/// The layer `removed` adds up to the bias report.
#[test]
fn what_is_removed_is_known_by_pixel() {
    use dapple_integrator::Aov;
    let scene = scene::builtin::builtin("cornell").unwrap().build().unwrap();
    let removing = Settings {
        clamp: Some(1.0),
        max_bounces: 2,
        aovs: vec![Aov::Removed],
        ..settings(Pattern::Sobol, 16)
    };
    let outcome = render(&scene, &scene.cameras[0].camera, &removing, &|_| ControlFlow::Continue(()));
    let layer = outcome.layers.layers.iter().find(|layer| layer.name == "removed").unwrap();
    let names: Vec<&str> = layer.channels.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["clamped", "depth", "faint", "not_finite"]);
    let sum = |k: usize| layer.channels[k].1.iter().map(|&x| f64::from(x) * 16.0).sum::<f64>();
    let bias = outcome.stats.bias;
    for (k, energy) in [(0, bias.clamped.energy), (1, bias.depth.energy)] {
        assert!(energy > 1.0 && (sum(k) / energy - 1.0).abs() < 1e-5, "{k}: {} of {energy}", sum(k));
    }
    assert_eq!((sum(2), sum(3), bias.lights_culled), (0.0, 0.0, 0));
}
