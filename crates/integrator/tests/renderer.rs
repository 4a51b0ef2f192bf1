//! Stepwise rendering, snapshots, saving and resuming, and custom integrators.

use dapple_integrator::geometry::Surface;
use dapple_integrator::math::{Frame, PixelRect, Ray};
use dapple_integrator::sampling::{Pattern, SampleSet, warp};
use dapple_integrator::scene::{Scene, builtin};
use dapple_integrator::{
    Advance, Aov, Combine, Effect, Integrator, MethodKind, Outcome, Renderer, SampleContext, Settings,
    SettingsError, render,
};
use glam::Vec3;
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::Duration;

fn scene(name: &str) -> Scene {
    builtin::builtin(name).unwrap().build().unwrap()
}

fn go(_: dapple_integrator::Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn settings(method: MethodKind) -> Settings {
    let aovs = vec![Aov::Albedo, Aov::SampleCount];
    let mut settings = Settings { size: (20, 18), seed: 3, aovs, ..Settings::default() };
    settings.plans.pixel = SampleSet::new(4, Pattern::Stratified);
    settings.with_method(method).with_spp(24).with_distribution(|d| d.rounds = 0..6)
}

fn is_same(a: &Outcome, b: &Outcome) -> bool {
    a.film == b.film
        && a.layers == b.layers
        && a.tail.sorted() == b.tail.sorted()
        && (a.stats.rays, a.stats.samples, a.stats.bias) == (b.stats.rays, b.stats.samples, b.stats.bias)
}

#[test]
fn steps_and_states_change_no_bit() {
    let scene = scene("cornell");
    let camera = &scene.cameras[0].camera;
    let adaptive = settings(MethodKind::Path).with_path(|p| p.adaptive = true);
    let all = [settings(MethodKind::Path), settings(MethodKind::Distribution), adaptive];
    for (settings, threads) in all.iter().zip([1, 2, 2]) {
        let settings = settings.clone().with_threads(threads);
        let whole = render(&scene, camera, &settings, &go);
        for until in [1, 4, 7, 12, 17, 23] {
            let mut first = Renderer::new(&scene, camera, &settings).unwrap();
            assert_eq!(first.advance(until, &go), Advance::Reached);
            let state = first.state();
            let round = if settings.kind() == MethodKind::Path { 1 } else { 4 };
            assert_eq!([first.spp(), state.next_sample()], [until.next_multiple_of(round); 2]);
            drop(first);
            let other = settings.clone().with_threads(3 - threads);
            let mut second = Renderer::resume(&scene, camera, &other, state).unwrap();
            assert_eq!(second.advance(u32::MAX, &go), Advance::Reached);
            assert!(second.is_complete());
            assert!(is_same(&second.finish(), &whole), "{:?} from {until}", settings.kind());
        }
    }
}

/// To the bits of the whole, wherever the samples are divided, and so do the largest differences of neighbours.
#[test]
fn parts_of_the_samples_add_up() {
    let scene = scene("cornell");
    let camera = &scene.cameras[0].camera;
    for (method, cuts) in [(MethodKind::Path, [0, 7, 10, 24]), (MethodKind::Distribution, [0, 1, 4, 6])] {
        let whole = render(&scene, camera, &settings(method), &go);
        let part = |from: u32, to: u32| {
            let settings = settings(method)
                .with_path(|p| (p.samples, p.of) = (from..to, Some(24)))
                .with_distribution(|d| d.rounds = from..to);
            render(&scene, camera, &settings, &go)
        };
        let [first, second, third] = [0, 1, 2].map(|i| part(cuts[i], cuts[i + 1]));
        let (mut film, mut tail) = (third.film, third.tail);
        for part in [second, first] {
            film.merge_measured(&part.film, |squared| tail.add(squared)).unwrap();
            tail.merge(&part.tail);
        }
        assert_eq!(film, whole.film, "{method:?}");
        assert_eq!((film.mean(), film.variance()), (whole.film.mean(), whole.film.variance()));
        assert_eq!(tail.sorted(), whole.tail.sorted());
    }
}

#[test]
fn an_interrupted_render_goes_on() {
    let scene = scene("cornell");
    let camera = &scene.cameras[0].camera;
    let settings = settings(MethodKind::Path);
    let whole = render(&scene, camera, &settings, &go);
    let mut renderer = Renderer::new(&scene, camera, &settings).unwrap();
    // Stopped within the first pass, which leaves some pixels without samples.
    assert_eq!(renderer.advance(u32::MAX, &|_| ControlFlow::Break(())), Advance::Stopped);
    renderer.advance(9, &go);
    assert_eq!(renderer.advance(u32::MAX, &|_| ControlFlow::Break(())), Advance::Stopped);
    assert_eq!(renderer.advance(u32::MAX, &go), Advance::Reached);
    assert!(is_same(&renderer.finish(), &whole));
    let late = settings.with_time_limit(Duration::ZERO);
    let mut renderer = Renderer::new(&scene, camera, &late).unwrap();
    assert_eq!(renderer.advance(u32::MAX, &go), Advance::TimedOut);
}

#[test]
fn a_state_belongs_to_its_settings() {
    let scene = scene("cornell");
    let camera = &scene.cameras[0].camera;
    let settings = settings(MethodKind::Path);
    let mut renderer = Renderer::new(&scene, camera, &settings).unwrap();
    renderer.advance(3, &go);
    let resume = |settings: &Settings| Renderer::resume(&scene, camera, settings, renderer.state()).err();
    assert_eq!(resume(&settings.clone().with_threads(1)), None);
    // Sobol points are a sequence from sets of 16 on, so that the render may continue to the bits of a longer one.
    let longer = settings.clone().with_spp(100);
    let mut resumed = Renderer::resume(&scene, camera, &longer, renderer.state()).unwrap();
    resumed.advance(u32::MAX, &go);
    assert!(is_same(&resumed.finish(), &render(&scene, camera, &longer, &go)));
    assert_eq!(resume(&settings.clone().with_spp(8)), Some(SettingsError::OtherRender));
    assert_eq!(resume(&settings.clone().with_path(|p| (p.samples, p.of) = (0..100, Some(24)))), None);
    // A set of cells of another size has other points; one of the same specified size may continue.
    let cells = Settings { pattern: Pattern::Stratified, ..settings.clone() };
    let mut stratified = Renderer::new(&scene, camera, &cells).unwrap();
    stratified.advance(3, &go);
    let resume_cells =
        |settings: &Settings| Renderer::resume(&scene, camera, settings, stratified.state()).err();
    assert_eq!(resume_cells(&cells.clone().with_spp(100)), Some(SettingsError::OtherRender));
    assert_eq!(resume_cells(&cells.clone().with_path(|p| (p.samples, p.of) = (0..100, Some(24)))), None);
    for other in [
        Settings { seed: 4, ..settings.clone() },
        Settings { max_bounces: 3, ..settings.clone() },
        Settings { size: (20, 17), ..settings.clone() },
        settings.clone().with_path(|p| p.roulette = false),
        settings.clone().with_method(MethodKind::Distribution),
    ] {
        assert_eq!(resume(&other), Some(SettingsError::OtherRender));
    }
}

#[test]
fn settings_without_sense_are_refused() {
    let fine = Settings::default();
    assert_eq!(fine.check(), Ok(()));
    assert_eq!(Settings::distribution().check(), Ok(()));
    let adaptive = |pattern| Settings { pattern, ..fine.clone() }.with_path(|p| p.adaptive = true);
    let crop = PixelRect { x0: 500, y0: 0, x1: 600, y1: 10 };
    let paired = Settings::distribution().with_distribution(|d| d.combine = Combine::Paired);
    let mut uneven = paired.clone();
    uneven.plans.light = SampleSet::new(9, Pattern::Stratified);
    let inside = PixelRect { x1: 510, ..crop };
    for (settings, error) in [
        (Settings { size: (0, 4), ..fine.clone() }, SettingsError::Size(0, 4)),
        (Settings { crop: Some(crop), ..fine.clone() }, SettingsError::Crop(crop)),
        (fine.clone().with_spp(0), SettingsError::NoSamples(0, 0)),
        (adaptive(Pattern::Stratified), SettingsError::AdaptivePattern(Pattern::Stratified)),
        (Settings { crop: Some(inside), ..adaptive(Pattern::Sobol) }, SettingsError::AdaptiveCrop),
        (adaptive(Pattern::Sobol).with_path(|p| p.samples = 8..64), SettingsError::AdaptiveStart),
        (uneven, SettingsError::Paired { effect: Effect::Light, count: 9, pixel: 16 }),
        (Settings { clamp: Some(f32::NAN), ..fine.clone() }, SettingsError::Radiance("the clamp")),
        (Settings { ambient: Vec3::NEG_X, ..fine.clone() }, SettingsError::Radiance("the ambient radiance")),
    ] {
        assert_eq!(settings.check(), Err(error));
    }
}

/// The path tracer, reimplemented with the public interface.
struct Paths;

impl Integrator for Paths {
    fn radiance(&self, ray: &Ray, context: &SampleContext<'_>) -> Vec3 {
        let (mut ray, mut beta, mut sum) = (*ray, Vec3::ONE, Vec3::ZERO);
        for depth in 0..16 {
            let Some(at) = context.intersect(&ray, depth) else {
                return sum + beta * context.environment(ray.d);
            };
            if depth == 0 {
                sum += beta * context.emitted(&at);
            }
            sum += beta * context.direct_light(&at, depth);
            let Some((weight, next)) = context.scatter(&at, depth) else { return sum };
            (beta, ray) = (beta * weight, next);
        }
        sum
    }
}

/// The unoccluded share of the hemisphere: by rays, and by the visibility of a light far above.
struct Open;

impl Integrator for Open {
    fn radiance(&self, ray: &Ray, context: &SampleContext<'_>) -> Vec3 {
        let Some(at) = context.intersect(ray, 0) else { return Vec3::Y };
        let up =
            Frame::from_z(at.facing_normal()).to_world(warp::hemisphere_cosine(context.point_2d(0, 128u32)));
        let towards = at.ray(up);
        let open = !context.is_occluded(&towards, 0);
        // Another surface point on the same ray gives the same result.
        let between = context.intersect(&towards, 1).map(|there| *there.surface());
        let agrees = between.is_none_or(|to: Surface| !context.is_occluded_between(at.surface(), &to, 1));
        Vec3::new(f32::from(u8::from(open)), f32::from(u8::from(agrees)), 0.0)
    }
}

fn run(scene: &Scene, settings: &Settings, integrator: &dyn Integrator) -> Outcome {
    let camera = &scene.cameras[0].camera;
    let mut renderer = Renderer::with_integrator(scene, camera, settings, integrator).unwrap();
    renderer.advance(u32::MAX, &go);
    renderer.finish()
}

/// Within four standard errors of the built-in path tracer, and the same for any number of threads.
#[test]
fn an_integrator_of_public_parts_agrees_with_the_path_tracer() {
    let scene = scene("cornell");
    let settings = Settings { size: (12, 12), pattern: Pattern::Random, ..Settings::default() }
        .with_spp(2000)
        .with_path(|p| p.roulette = false);
    let ours = run(&scene, &settings, &Paths);
    let built_in = render(&scene, &scene.cameras[0].camera, &settings, &go);
    let mean = |outcome: &Outcome| f64::from(outcome.film.mean().mean().y);
    let error = |outcome: &Outcome| {
        let variance = outcome.film.variance();
        let sum: f64 = variance.pixels.iter().map(|v| f64::from(v.y)).sum();
        sum.sqrt() / variance.pixels.len() as f64
    };
    let (a, b) = (mean(&ours), mean(&built_in));
    let error = error(&ours).hypot(error(&built_in));
    assert!((a - b).abs() < 4.0 * error && error < 0.02 * b, "{a} {b} ± {error}");
    assert!(ours.stats.rays > 2 * ours.stats.samples);
    let again = run(&scene, &settings.with_threads(1), &Paths);
    assert!(again.film == ours.film);
}

#[test]
fn rays_between_points_leave_and_reach_their_surfaces() {
    let scene = scene("cornell");
    let settings = Settings { size: (32, 32), ..Settings::default() }.with_spp(16);
    let image = run(&scene, &settings, &Open).film.mean();
    // The segment between two points is unoccluded if one is the nearest surface from the other.
    let unseen: f32 = image.pixels.iter().map(|p| 16.0 * (1.0 - p.y)).sum();
    let open: f32 = image.pixels.iter().map(|p| p.x).sum();
    assert!(unseen == 0.0 && open > 0.0, "{unseen} of {}", 16 * image.pixels.len());
}

/// Remembers the direction of the last camera ray.
#[derive(Default)]
struct Directions(Mutex<Vec3>);

impl Integrator for Directions {
    fn radiance(&self, ray: &Ray, _: &SampleContext<'_>) -> Vec3 {
        *self.0.lock().unwrap() = ray.d;
        Vec3::ZERO
    }
}

/// The path tracer with an error: it panics at the camera ray of one direction.
struct Faulty(Vec3);

impl Integrator for Faulty {
    fn radiance(&self, ray: &Ray, context: &SampleContext<'_>) -> Vec3 {
        assert!(ray.d != self.0, "a fault of the test");
        Paths.radiance(ray, context)
    }
}

/// A panic costs the tile in which it happens, and nothing else.
#[test]
fn a_panic_costs_one_tile() {
    let scene = scene("cornell");
    let sound = settings(MethodKind::Path);
    let whole = run(&scene, &sound, &Paths);
    assert!(whole.stats.failures.is_empty());
    // The sixth sample of a pixel of the first tile.
    let crop = Some(PixelRect { x0: 8, y0: 9, x1: 9, y1: 10 });
    let single = Settings { crop, ..sound.clone() }.with_path(|p| (p.samples, p.of) = (5..6, Some(24)));
    let directions = Directions::default();
    run(&scene, &single, &directions);
    let faulty = Faulty(*directions.0.lock().unwrap());
    for threads in [1, 2] {
        let broken = run(&scene, &sound.clone().with_threads(threads), &faulty);
        let first = PixelRect { x0: 0, y0: 0, x1: 16, y1: 16 };
        assert_eq!(broken.stats.failures, [(first, "a fault of the test".to_string())]);
        for (x, y) in (0..18).flat_map(|y| (0..20).map(move |x| (x, y))) {
            let (sums, sound) = (broken.film.sums_at(x, y), whole.film.sums_at(x, y));
            assert_eq!(sums, if first.contains(x, y) { Default::default() } else { sound });
        }
    }
}
