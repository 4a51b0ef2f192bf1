//! Shading normals that deviate from the surface conserve energy: furnaces, comparison of strategies, and no light
//! leaks.

mod common;

use common::*;
use dapple_geometry::Mesh;
use dapple_imaging::{Encoding, Interpolation, Rgba8, Sampler, Texture, Wrap};
use dapple_integrator::Settings;
use dapple_integrator::settings::{MethodKind, Strategy};
use dapple_lights::Environment;
use dapple_materials::Material;
use dapple_sampling::Pattern;
use dapple_scene::{Scene, SceneBuilder, TextureUse, TexturedMaterial};
use glam::{DAffine3, DVec3, Vec2, Vec3};

/// The source of the floor's shading normals.
#[derive(Clone, Copy, Debug, PartialEq)]
enum By {
    Map,
    Vertices,
}

/// Unit vector, `tilt` from +y towards azimuth `azimuth` about it (from +x towards −z), degrees.
fn leaning(tilt: f32, azimuth: f32) -> Vec3 {
    let ((s, c), (sin, cos)) = (tilt.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
    Vec3::new(s * cos, c, -s * sin)
}

/// One texel: x along u, y along v, z the normal.
fn normal_map(n: Vec3) -> Texture {
    let byte = |x: f32| ((x * 0.5 + 0.5) * 255.0).round() as u8;
    let texel = [byte(n.x), byte(-n.z), byte(n.y), 255];
    // Not constant, so that it remains a texture.
    let image = Rgba8 { width: 2, height: 1, texels: vec![texel, [texel[0], texel[1], texel[2], 254]] };
    let sampler =
        Sampler { wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat, interpolation: Interpolation::Nearest };
    Texture::new(image, Encoding::Linear, sampler)
}

/// A floor of half side `half` about the origin whose shading normal is `n`.
fn add_floor(builder: &mut SceneBuilder, half: f32, material: TexturedMaterial, n: Vec3, by: By) {
    let mut floor = quad(Vec3::new(-half, 0.0, half), Vec3::X * (2.0 * half), Vec3::Z * (-2.0 * half));
    let mut material = material;
    match by {
        By::Map => {
            floor.uv = [vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y], Vec::new()];
            let map = builder.texture(normal_map(n));
            material.normal_texture = Some(TextureUse::new(map));
        }
        By::Vertices => floor.normals = vec![n; 4],
    }
    let material = builder.material(material);
    builder.mesh("floor", floor, DAffine3::IDENTITY, material);
}

/// A floor seen `view` degrees from its normal, from +x, in a white sky.
fn furnace(material: &TexturedMaterial, n: Vec3, by: By, view: f64) -> Scene {
    let (s, c) = view.to_radians().sin_cos();
    let to = DVec3::new(s, c, 0.0);
    let mut builder = seen_in_parallel(to * 3.0, -to, DVec3::Z, 0.02);
    add_floor(&mut builder, 1.0, material.clone(), n, by);
    builder.environment(Environment::constant(Vec3::ONE));
    builder.build().unwrap()
}

fn plastic() -> TexturedMaterial {
    let base = Material { metallic: 0.0, roughness: 0.3, ..Material::default() };
    TexturedMaterial { name: "plastic".into(), base, ..TexturedMaterial::default() }
}

fn pane(roughness: f32) -> TexturedMaterial {
    let base = Material { metallic: 0.0, roughness, transmission: 1.0, ..Material::default() };
    TexturedMaterial { name: format!("pane {roughness}"), base, ..TexturedMaterial::default() }
}

const METHODS: [MethodKind; 2] = [MethodKind::Path, MethodKind::Distribution];

/// Materials that reflect or transmit all incident light; those of roughness 0.1 all but 2 % towards 85°.
#[test]
fn a_furnace_keeps_its_light_at_every_tilt_view_and_azimuth() {
    let materials = [
        (metal(Vec3::ONE, 0.1), 0.98),
        (metal(Vec3::ONE, 0.0), 1.0 - 1e-5),
        (matte(1.0, 0.0), 1.0 - 1e-5),
        (plastic(), 0.98),
        (pane(0.0), 1.0 - 1e-5),
        (pane(0.1), 0.975),
    ];
    for (material, least) in &materials {
        for tilt in [20.0, 45.0, 60.0] {
            for azimuth in [0.0, 70.0, 135.0, 180.0] {
                for view in [0.0, 45.0, 75.0, 85.0] {
                    for (by, method) in
                        [(By::Map, METHODS[0]), (By::Map, METHODS[1]), (By::Vertices, METHODS[0])]
                    {
                        let scene = furnace(material, leaning(tilt, azimuth), by, view);
                        let settings = Settings { size: (3, 3), max_bounces: 4, ..Settings::default() }
                            .with_method(method)
                            .with_spp(64);
                        let (mean, error) = mean_and_error(&run(&scene, &settings));
                        let what =
                            format!("{} {tilt}° {azimuth}° from {view}° {by:?} {method:?}", material.name);
                        assert!(mean <= 1.0 + 1e-3 + 4.0 * error, "{what}: {mean} ± {error}");
                        assert!(mean >= least - 4.0 * error, "{what}: {mean} ± {error}");
                    }
                }
            }
        }
    }
}

/// Rough lobes lose by single scattering what they lose without the map, at every roughness.
#[test]
fn a_map_neither_takes_light_nor_gives_any() {
    let settings = Settings { size: (6, 6), max_bounces: 2, ..Settings::default() }.with_spp(384);
    let mean = |scene: &Scene| mean_and_error(&run(scene, &settings));
    for material in
        [metal(Vec3::ONE, 0.3), metal(Vec3::ONE, 0.6), metal(Vec3::ONE, 1.0), pane(0.4), plastic()]
    {
        for view in [0.0, 40.0, 70.0, 85.0] {
            let (unmapped, sigma) = mean(&furnace(&material, Vec3::Y, By::Vertices, view));
            for (tilt, azimuth) in [(30.0, 0.0), (30.0, 180.0), (60.0, 0.0), (60.0, 100.0), (60.0, 180.0)] {
                let (mapped, error) = mean(&furnace(&material, leaning(tilt, azimuth), By::Map, view));
                let (ratio, error) = (mapped / unmapped, (sigma + error) / unmapped);
                let what = format!("{} {tilt}° {azimuth}° from {view}°", material.name);
                // The albedo table is accurate to 0.25 %, for the coat over white to 0.5 %.
                assert!(
                    (0.994 - 4.0 * error..1.005 + 4.0 * error).contains(&ratio),
                    "{what}: {ratio} ± {error}"
                );
                assert!(error < 4e-3, "{what}: {error}");
            }
        }
    }
}

/// A metal of reflectance 0.9 is hit once, and reflects 0.9.
#[test]
fn no_light_is_reflected_twice() {
    for by in [By::Map, By::Vertices] {
        for tilt in [30.0, 50.0, 60.0] {
            let scene = furnace(&metal(Vec3::splat(0.9), 0.0), leaning(tilt, 0.0), by, 0.0);
            let settings = Settings { size: (3, 3), ..Settings::default() }.with_spp(16);
            let (mean, _) = mean_and_error(&run(&scene, &settings));
            // Schlick's F at an angle of 60° is 0.003 higher.
            assert!((0.8999..0.9035).contains(&mean), "{tilt} {by:?}: {mean}");
        }
    }
}

/// The floor under a large lamp; the image is the same with every strategy.
#[test]
fn light_and_bsdf_sampling_see_the_same_surface() {
    for (material, below) in [(metal(Vec3::ONE, 0.4), false), (plastic(), false), (pane(0.4), true)] {
        for (tilt, azimuth, by) in [(50.0, 30.0, By::Map), (60.0, 180.0, By::Map), (40.0, 80.0, By::Vertices)]
        {
            let to = DVec3::new(0.8, 0.6, 0.0);
            let mut builder = seen_in_parallel(to * 3.0, -to, DVec3::Z, 0.02);
            add_floor(&mut builder, 1.0, material.clone(), leaning(tilt, azimuth), by);
            let lamp = builder.material(matte(0.0, 1.0));
            let height = if below { -1.0 } else { 1.0 };
            for at in [DVec3::new(-2.0, 0.7 * height, 0.5), DVec3::new(2.0, 0.6 * height, -1.0)] {
                builder.sphere("lamp", at, 0.55, lamp);
            }
            let scene = builder.build().unwrap();
            let one = |strategy, method, seed| {
                let settings = Settings {
                    size: (8, 8),
                    max_bounces: 1,
                    pattern: Pattern::Random,
                    strategy,
                    seed,
                    ..Settings::default()
                }
                .with_method(method)
                .with_spp(256);
                mean_and_error(&run(&scene, &settings))
            };
            let (both, sigma) = one(Strategy::Both, MethodKind::Path, 1);
            assert!(both > 1e-3 && sigma < 0.04 * both, "{both} ± {sigma}");
            for (strategy, method, seed) in [
                (Strategy::LightOnly, MethodKind::Path, 2),
                (Strategy::BsdfOnly, MethodKind::Path, 3),
                (Strategy::Both, MethodKind::Distribution, 4),
            ] {
                let (other, error) = one(strategy, method, seed);
                let z = (other - both) / sigma.hypot(error);
                let what = format!("{} {tilt}° {azimuth}° {by:?} {strategy:?} {method:?}", material.name);
                assert!(z.abs() < 4.5, "{what}: {other} ± {error}, both {both} ± {sigma}");
            }
        }
    }
}

/// Opaque surfaces transmit no light, whatever their normals: lamps below, seen from above and from the side.
#[test]
fn nothing_leaks_through_an_opaque_surface() {
    for material in [metal(Vec3::ONE, 0.5), metal(Vec3::ONE, 0.0), plastic(), matte(1.0, 0.0)] {
        for (tilt, azimuth, by) in [(60.0, 0.0, By::Map), (85.0, 180.0, By::Map), (60.0, 0.0, By::Vertices)] {
            for view in [0.0f64, 60.0, 85.0] {
                let (s, c) = view.to_radians().sin_cos();
                let to = DVec3::new(s, c, 0.0);
                let mut builder = seen_in_parallel(to * 3.0, -to, DVec3::Z, 0.02);
                add_floor(&mut builder, 50.0, material.clone(), leaning(tilt, azimuth), by);
                let lamp = builder.material(TexturedMaterial { double_sided: true, ..matte(0.0, 1.0) });
                builder.disk("lamp", DVec3::Y * -2.0, DVec3::Y, 100.0, lamp);
                builder.point_light(DVec3::new(3.0, -1.0, 0.0), Vec3::splat(100.0), f64::INFINITY);
                let scene = builder.build().unwrap();
                for method in METHODS {
                    let settings = Settings { size: (4, 4), max_bounces: 2, ..Settings::default() }
                        .with_method(method)
                        .with_spp(64);
                    let (mean, _) = mean_and_error(&run(&scene, &settings));
                    assert_eq!(mean, 0.0, "{} {tilt}° {azimuth}° {view}° {by:?} {method:?}", material.name);
                }
            }
        }
    }
}

/// Vertex normals equal to the facet normal change no bit.
#[test]
fn normals_of_the_facet_keep_every_bit() {
    let render = |normals: bool, tilt: f32| {
        let mut builder = seen(DVec3::new(0.3, 2.0, 1.0), DVec3::ZERO, 0.5);
        let mut floor = quad(Vec3::new(-1.0, 0.0, 1.0), Vec3::X * 2.0, Vec3::Z * -2.0);
        if normals {
            floor.normals = vec![leaning(tilt, 20.0); 4];
        }
        let material = builder.material(plastic());
        builder.mesh("floor", floor, DAffine3::IDENTITY, material);
        builder.point_light(DVec3::new(1.0, 1.0, 0.0), Vec3::ONE, f64::INFINITY);
        builder.environment(Environment::constant(Vec3::ONE));
        let settings = Settings { size: (16, 16), ..Settings::default() }.with_spp(8);
        run(&builder.build().unwrap(), &settings).film.mean().pixels
    };
    assert_eq!(render(false, 0.0), render(true, 0.0));
    assert_ne!(render(false, 0.0), render(true, 1.0), "a tilt of 1° must change the image");
}

/// Light at grazing angles on a diffuse surface decreases continuously to zero at its horizon.
#[test]
fn a_leaning_normal_has_no_hard_terminator() {
    let lit = |elevation: f64| {
        let mut builder = seen_in_parallel(DVec3::Y * 3.0, DVec3::NEG_Y, DVec3::Z, 0.01);
        add_floor(&mut builder, 0.1, matte(1.0, 0.0), leaning(40.0, 0.0), By::Map);
        let (s, c) = elevation.to_radians().sin_cos();
        builder.point_light(DVec3::new(c, s, 0.0) * 1e3, Vec3::splat(1e6), f64::INFINITY);
        let settings = Settings { size: (2, 2), max_bounces: 1, ..Settings::default() }.with_spp(4);
        mean_and_error(&run(&builder.build().unwrap(), &settings)).0 * std::f64::consts::PI
    };
    let mut last = 0.0;
    for k in 1..=90 {
        let here = lit(f64::from(k));
        assert!((here - last).abs() < 0.15, "steps at {k}°: {last} to {here}");
        last = here;
    }
    assert!(lit(0.01) < 0.002, "{}", lit(0.01));
    // cos 40° from straight above, as without the fold.
    assert!((lit(90.0) - f64::to_radians(40.0).cos()).abs() < 0.01, "{}", lit(90.0));
}

/// An octahedron whose vertex normals are tilted as well as interpolated, from outside and with reversed winding.
#[test]
fn a_body_with_smooth_normals_keeps_its_light() {
    let corners = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let triangles =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for inward in [false, true] {
        // Normals that deviate from those of the sphere by up to 25°.
        let lean = Vec3::new(0.3, -0.2, 0.25);
        let normals = corners.map(|n| (n + lean).normalize()).to_vec();
        let triangles =
            if inward { triangles.iter().map(|&[a, b, c]| [a, c, b]).collect() } else { triangles.clone() };
        let mesh = Mesh { positions: corners.to_vec(), normals, triangles, ..Mesh::default() };
        let glass =
            Material { metallic: 0.0, roughness: 0.0, transmission: 1.0, thin: false, ..Material::default() };
        let glass = TexturedMaterial { name: "glass".into(), base: glass, ..TexturedMaterial::default() };
        for (material, soft_terminator) in
            [(metal(Vec3::ONE, 0.1), false), (metal(Vec3::ONE, 0.1), true), (glass, true)]
        {
            let what = format!("{}, inward {inward}, soft {soft_terminator}", material.name);
            let mut builder = seen(DVec3::new(0.5, 1.0, 6.0), DVec3::ZERO, 0.4);
            let material = builder.material(material);
            builder.mesh("body", mesh.clone(), DAffine3::IDENTITY, material);
            builder.environment(Environment::constant(Vec3::ONE));
            let settings = Settings {
                size: (24, 24),
                max_bounces: 300,
                soft_terminator,
                // With reversed winding, the object is seen from behind.
                backfaces: dapple_integrator::Backfaces::Shown,
                ..Settings::default()
            }
            .with_spp(64)
            .with_path(|p| p.roulette = false);
            let pixels = run(&builder.build().unwrap(), &settings).film.mean().pixels;
            let (least, most) =
                pixels.iter().fold((1.0f32, 0.0f32), |(low, high), p| (low.min(p.x), high.max(p.x)));
            assert!(most <= 1.0 + 1e-4 && least > 0.98, "{what}: {least} to {most}");
        }
    }
}
