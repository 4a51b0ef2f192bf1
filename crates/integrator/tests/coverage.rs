//! Alpha and Cryptomatte: shares of samples, in both tracers, for all filters, lenses and alpha cutouts.

mod common;

use common::{matte, quad, run, seen, shadeless};
use dapple_imaging::{Layers, MetaValue};
use dapple_integrator::camera::{Aperture, Filter, Lens};
use dapple_integrator::{Aov, MethodKind, Outcome, Settings, render, replay};
use dapple_lights::Environment;
use dapple_materials::Material;
use dapple_sampling::SampleSet;
use dapple_scene::{AlphaMode, Scene, SceneBuilder, TexturedMaterial};
use glam::{DAffine3, DVec3, Vec3};
use std::collections::BTreeMap;
use std::ops::ControlFlow;

const SKY: Vec3 = Vec3::new(0.5, 1.0, 2.0);

const FILTERS: [Filter; 6] = [
    Filter::Box { radius: 0.5 },
    Filter::Box { radius: 1.5 },
    Filter::Tent,
    Filter::Gaussian,
    Filter::Mitchell,
    Filter::BlackmanHarris,
];

/// An upright square in front of the camera, which looks along -z from z = 4: its lower left corner and its side.
fn add(builder: &mut SceneBuilder, name: &str, (x, y, z): (f32, f32, f32), side: f32, of: TexturedMaterial) {
    let material = builder.material(of);
    let mesh = quad(Vec3::new(x, y, z), Vec3::X * side, Vec3::Y * side);
    builder.mesh(name, mesh, DAffine3::IDENTITY, material);
}

fn builder() -> SceneBuilder {
    let mut builder = seen(DVec3::new(0.1, 0.05, 4.0), DVec3::ZERO, 0.6);
    builder.environment(Environment::constant(SKY));
    builder
}

fn holes(alpha: f32, alpha_mode: AlphaMode) -> TexturedMaterial {
    TexturedMaterial { alpha, alpha_mode, double_sided: true, name: "holes".into(), ..matte(0.6, 0.0) }
}

/// A smooth transparent material.
fn pane() -> TexturedMaterial {
    let base = Material {
        base_color: Vec3::ONE,
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        thin: true,
        ..Material::default()
    };
    TexturedMaterial { base, name: "pane".into(), double_sided: true, ..TexturedMaterial::default() }
}

/// Reflecting, transmitting and occluding objects at several depths.
fn scene() -> Scene {
    let mut builder = builder();
    add(&mut builder, "back", (-0.7, -0.8, -1.0), 0.9, matte(0.8, 0.0));
    add(&mut builder, "veil", (-0.2, -0.4, 0.5), 0.7, holes(0.3, AlphaMode::Blend));
    add(&mut builder, "gone", (-1.0, 0.1, 0.4), 0.5, holes(0.3, AlphaMode::Mask { cutoff: 0.5 }));
    add(&mut builder, "pane", (0.2, 0.3, 0.2), 0.5, pane());
    add(&mut builder, "lamp", (-0.6, 0.4, 0.0), 0.2, shadeless(3.0));
    builder.build().unwrap()
}

fn methods() -> [Settings; 2] {
    let path = Settings { size: (20, 16), max_bounces: 3, ..Settings::default() }.with_spp(9);
    let mut tree = path.clone().with_method(MethodKind::Distribution);
    tree.plans.pixel = "3x3".parse().unwrap();
    tree.plans.lens = SampleSet::new(4, dapple_sampling::Pattern::Sobol);
    tree.plans.light = SampleSet::new(1, dapple_sampling::Pattern::Sobol);
    tree.plans.glossy = tree.plans.light;
    [path, tree]
}

fn channel<'a>(layers: &'a Layers, layer: &str, channel: &str) -> &'a [f32] {
    let layer = layers.layer(layer).unwrap_or_else(|| panic!("no layer {layer}"));
    &layer.channels.iter().find(|(name, _)| name == channel).unwrap().1
}

fn alpha(outcome: &Outcome) -> &[f32] {
    channel(&outcome.layers, "", "A")
}

/// The image composited over the environment equals the image rendered with the environment: nothing else changes, and
/// no random number changes.
#[test]
fn over_the_environment_it_is_the_same_picture() {
    let mut scene = scene();
    let lenses = [None, Some(Lens { aperture: Aperture::Disk, radius: 0.05, focus_distance: 3.0 })];
    for lens in lenses {
        scene.cameras[0].camera.lens = lens;
        for settings in methods() {
            for filter in FILTERS {
                let is_signed = filter == Filter::Mitchell;
                let settings = Settings { filter, ..settings.clone() };
                let whole = run(&scene, &settings);
                let cut = run(&scene, &Settings { transparent: true, ..settings.clone() });
                assert!(whole.layers.layer("").unwrap().channels.len() == 3);
                let mut partial = 0;
                for (i, &a) in alpha(&cut).iter().enumerate() {
                    let (whole, cut) = (whole.film.mean().pixels[i], cut.film.mean().pixels[i]);
                    let over = cut + (1.0 - a) * SKY;
                    assert!((over - whole).abs().max_element() < 2e-5, "{i}: {over} {whole} {a}");
                    assert!(is_signed || (a > 0.0 && a <= 1.0) || (a == 0.0 && cut == Vec3::ZERO));
                    partial += u32::from(a > 0.0 && a < 1.0);
                }
                assert!(partial > 20, "{partial}");
            }
        }
    }
}

/// A surface that covers all of a pixel has alpha 1, whatever the signs of the filter weights; panes cover, masked
/// holes do not. With negative weights, holes show the same share of the sky as in the image.
#[test]
fn coverage_is_whole_inside_and_none_outside() {
    for settings in methods() {
        for filter in [Filter::default(), Filter::Mitchell] {
            let settings = Settings { transparent: true, filter, size: (9, 7), ..settings.clone() };
            for (what, of, expected) in [
                ("wall", matte(0.5, 0.0), 1.0),
                ("pane", pane(), 1.0),
                ("hole", holes(0.2, AlphaMode::Mask { cutoff: 0.5 }), 0.0),
            ] {
                let mut builder = builder();
                add(&mut builder, what, (-9.0, -9.0, 0.0), 18.0, of);
                let scene = builder.build().unwrap();
                let outcome = run(&scene, &settings);
                if what == "hole" && filter == Filter::Mitchell {
                    let sky = run(&scene, &Settings { transparent: false, ..settings.clone() });
                    for (a, p) in alpha(&outcome).iter().zip(&sky.film.mean().pixels) {
                        assert!(((1.0 - a) * SKY - *p).abs().max_element() < 1e-5, "{a} {p}");
                    }
                    continue;
                }
                assert!(alpha(&outcome).iter().all(|a| *a == expected), "{what}: {:?}", alpha(&outcome));
                let lit = outcome.film.mean().pixels.iter().all(|p| p.y > 0.1);
                assert!(what == "hole" || filter == Filter::Mitchell || lit, "{what} is dark");
            }
        }
    }
}

/// The coverage by a veil that transmits most of the samples is its alpha, within four standard errors.
#[test]
fn a_veil_covers_by_its_alpha() {
    for settings in methods() {
        let mut builder = builder();
        add(&mut builder, "veil", (-9.0, -9.0, 0.0), 18.0, holes(0.3, AlphaMode::Blend));
        let settings = Settings { transparent: true, size: (32, 32), ..settings };
        let outcome = run(&builder.build().unwrap(), &settings);
        let mean = alpha(&outcome).iter().map(|a| f64::from(*a)).sum::<f64>() / 1024.0;
        let error = (0.3f64 * 0.7 / (1024.0 * 9.0)).sqrt();
        assert!((mean - 0.3).abs() < 4.0 * error, "{mean}");
    }
}

#[test]
fn replay_sees_no_backdrop() {
    let scene = scene();
    for settings in methods().map(|s| Settings { transparent: true, ..s }.with_spp(1)) {
        let (camera, pixel) = (&scene.cameras[0].camera, (19, 0));
        assert_eq!(replay(&scene, camera, &settings, pixel, 0).1, Vec3::ZERO);
        let shown = Settings { transparent: false, ..settings };
        assert_eq!(replay(&scene, camera, &shown, pixel, 0).1, SKY);
    }
}

/// The manifests of a file: for each matte by name, the id bits of each name.
fn manifests(layers: &Layers) -> BTreeMap<String, BTreeMap<String, u32>> {
    let texts: BTreeMap<&str, &str> = layers
        .metadata
        .iter()
        .map(|(key, value)| match value {
            MetaValue::Text(text) => (key.as_str(), text.as_str()),
            other => panic!("{key}: {other:?}"),
        })
        .collect();
    let names = texts.iter().filter(|(key, _)| key.starts_with("cryptomatte/") && key.ends_with("/name"));
    let manifest = |key: &str| {
        let about = |what: &str| texts[key.replace("/name", what).as_str()];
        assert_eq!((about("/hash"), about("/conversion")), ("MurmurHash3_32", "uint32_to_float32"));
        let inside = about("/manifest").strip_prefix('{').unwrap().strip_suffix('}').unwrap();
        let entry = |entry: &str| {
            let (name, id) = entry.split_once(':').unwrap();
            (name.trim_matches('"').to_string(), u32::from_str_radix(id.trim_matches('"'), 16).unwrap())
        };
        inside.split(',').filter(|e| !e.is_empty()).map(entry).collect()
    };
    names.map(|(key, name)| (name.to_string(), manifest(key))).collect()
}

/// Ids and coverages of a pixel, rank by rank.
fn ranks(layers: &Layers, name: &str, pixel: usize) -> Vec<(u32, f32)> {
    (0..3)
        .flat_map(|i| {
            let value = |c: &str| channel(layers, &format!("{name}{i:02}"), c)[pixel];
            [(value("R").to_bits(), value("G")), (value("B").to_bits(), value("A"))]
        })
        .collect()
}

/// The first hits of the samples of a pixel: shares of the objects and materials by name.
fn met(scene: &Scene, settings: &Settings, pixel: (u32, u32)) -> [BTreeMap<String, f64>; 2] {
    let camera = &scene.cameras[0].camera;
    let mut found = [BTreeMap::new(), BTreeMap::new()];
    let samples = settings.samples().unwrap();
    for sample in 0..samples {
        let (vertices, _) = replay(scene, camera, settings, pixel, sample);
        let first: Vec<_> = vertices.iter().filter(|v| v.depth == 0).collect();
        for vertex in first.iter().filter(|v| v.kind == "surface") {
            for (all, name) in found.iter_mut().zip([&vertex.object, &vertex.material]) {
                *all.entry(name.clone()).or_insert(0.0) += 1.0 / (f64::from(samples) * first.len() as f64);
            }
        }
    }
    found
}

/// Nine strips, finer than a pixel, in front of a wall; two of them have the same name.
fn strips() -> Scene {
    let mut builder = builder();
    let materials = [0.2, 0.5].map(|albedo| builder.material(matte(albedo, 0.0)));
    for i in 0..60 {
        let name = if i % 9 == 7 { "strip 3".into() } else { format!("strip {}", i % 9) };
        let mesh = quad(Vec3::new(-1.2 + 0.04 * i as f32, -0.5, 0.0), Vec3::X * 0.037, Vec3::Y);
        builder.mesh(name.as_str(), mesh, DAffine3::IDENTITY, materials[i % 2]);
    }
    builder.build().unwrap()
}

#[test]
fn cryptomatte_holds_exact_shares_of_the_samples() {
    for scene in [scene(), strips()] {
        for settings in methods() {
            let mut settings = Settings { aovs: vec![Aov::Cryptomatte], size: (7, 5), ..settings };
            if scene.objects.len() > 10 {
                // Enough samples to hit more than six strips.
                settings = settings.with_spp(36);
                settings.plans.pixel = "6x6".parse().unwrap();
            }
            let outcome = run(&scene, &settings);
            let manifests = manifests(&outcome.layers);
            let (mut full, mut seen) = (0, 0);
            for (x, y) in (0..5).flat_map(|y| (0..7).map(move |x| (x, y))) {
                for (met, name) in
                    met(&scene, &settings, (x, y)).iter().zip(["CryptoObject", "CryptoMaterial"])
                {
                    let ids = &manifests[name];
                    let ranks = ranks(&outcome.layers, name, (y * 7 + x) as usize);
                    assert!(ranks.windows(2).all(|pair| pair[0].1 >= pair[1].1), "{ranks:?}");
                    let mut shares: Vec<f64> = met.values().copied().collect();
                    shares.sort_by(|a, b| b.total_cmp(a));
                    for (rank, (id, coverage)) in ranks.iter().enumerate() {
                        let share = shares.get(rank).copied().unwrap_or(0.0);
                        assert!(
                            (f64::from(*coverage) - share).abs() < 1e-6,
                            "{name} {x},{y}: {ranks:?} {met:?}"
                        );
                        match ids.iter().find(|(_, known)| *known == id) {
                            Some((name, _)) => assert!((met[name] - share).abs() < 1e-6, "{name} at {x},{y}"),
                            None => assert_eq!((*id, *coverage), (0, 0.0)),
                        }
                    }
                    full += u32::from(shares.len() > 6);
                    seen += shares.len();
                }
            }
            assert!(seen > 10, "{seen}");
            assert!(full > 0 || scene.objects.len() < 10, "no pixel has more ids than ranks");
        }
    }
}

/// For a layer without transparent surfaces, the shares add up to alpha.
#[test]
fn shares_add_up_to_alpha_on_any_number_of_threads() {
    let scene = scene();
    for settings in methods() {
        let aovs = vec![Aov::Cryptomatte, Aov::ObjectId, Aov::MaterialId];
        let settings = Settings { transparent: true, aovs, filter: Filter::Tent, ..settings };
        let [one, three] = [1, 3].map(|n| run(&scene, &settings.clone().with_threads(n)));
        assert!(one.layers == three.layers);
        for (i, a) in alpha(&one).iter().enumerate() {
            for name in ["CryptoObject", "CryptoMaterial"] {
                let sum: f32 = ranks(&one.layers, name, i).iter().map(|rank| rank.1).sum();
                assert!((sum - a).abs() < 1e-6, "{name} {i}: {sum} {a}");
            }
        }
        let text = |key: &str| match one.layers.metadata.iter().find(|(name, _)| name == key) {
            Some((_, MetaValue::Text(text))) => text.clone(),
            _ => panic!("no {key}"),
        };
        assert_eq!(text("objectNames"), r#"{"back":[1],"lamp":[5],"pane":[4],"veil":[2]}"#);
        assert_eq!(text("materialNames"), r#"{"holes":[2],"matte 0":[5],"matte 0.8":[1],"pane":[4]}"#);
    }
}

/// If a render is stopped within a pass, the coverage is that of the samples that are kept.
#[test]
fn what_is_taken_back_covers_nothing() {
    let (scene, [path, _]) = (scene(), methods());
    let settings = Settings { transparent: true, aovs: vec![Aov::Cryptomatte], ..path };
    let none = render(&scene, &scene.cameras[0].camera, &settings, &|_| ControlFlow::Continue(()));
    let again = settings.clone().with_spp(None);
    let some = dapple_integrator::render_watched(
        &scene,
        &scene.cameras[0].camera,
        &again,
        &|_| ControlFlow::Continue(()),
        &mut |at| if at.spp >= 8 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) },
    );
    assert_eq!((none.stats.spp, some.stats.spp), (9, 8));
    let eight = run(&scene, &settings.with_spp(8));
    let exact = |a: &f32| (8.0 * a).fract() == 0.0;
    assert!(alpha(&some).iter().all(exact) && alpha(&eight).iter().all(exact));
}
