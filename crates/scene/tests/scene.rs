//! Scenes built in code: shading, emission and opacity at hits, lights, and errors.
use dapple_camera::Projection;
use dapple_geometry::{Hit, Mesh, Opaque, Surface};
use dapple_imaging::{Interpolation, Sampler, Texture, read::Rgba8, texture::Encoding};
use dapple_lights::{AreaShape, Environment, Light, LightPoint};
use dapple_math::Ray;
use dapple_scene::{
    AlphaMode, CameraPose, Scene, SceneBuilder, TextureUse, TexturedMaterial, WorldPoint, builtin,
    builtin::NAMES,
};
use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};

/// Unit square facing +z; u to the right, v down.
fn square() -> Mesh {
    Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uv: [vec![Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO], Vec::new()],
        ..Mesh::default()
    }
}

fn texture(width: usize, texels: &[[u8; 4]], encoding: Encoding) -> Texture {
    let image = Rgba8 { width, height: texels.len() / width, texels: texels.to_vec() };
    Texture::new(image, encoding, Sampler { interpolation: Interpolation::Nearest, ..Sampler::default() })
}

/// A scene of one square with one material.
fn scene_of(material: TexturedMaterial, textures: Vec<Texture>, transform: DAffine3) -> Scene {
    scene_of_mesh(square(), material, textures, transform)
}

fn scene_of_mesh(
    mesh: Mesh,
    material: TexturedMaterial,
    textures: Vec<Texture>,
    transform: DAffine3,
) -> Scene {
    let mut b = SceneBuilder::new("test");
    textures.into_iter().for_each(|t| {
        b.texture(t);
    });
    let material = b.material(material);
    b.mesh("square", mesh, transform, material);
    b.build().unwrap()
}

/// The hit of a ray from `from` (world space) along `d`.
fn shoot(scene: &Scene, from: DVec3, d: Vec3) -> (Hit, Surface) {
    let ray = Ray::new(scene.space.to_render(WorldPoint(from)), d);
    let hit = scene.accel.intersect(&ray, 0.0, &Opaque).expect("a hit");
    (hit, scene.accel.surface(&ray, 0.0, &hit))
}

fn normal_mapped(texel: [u8; 4], transform: DAffine3) -> (Vec3, Vec3) {
    let map = TexturedMaterial { normal_texture: Some(TextureUse::new(0)), ..TexturedMaterial::default() };
    let scene = scene_of(map, vec![texture(1, &[texel], Encoding::Linear)], transform);
    let centre = transform.transform_point3(DVec3::new(0.4, 0.3, 0.0));
    let up = (transform.matrix3 * DVec3::Z).normalize();
    let (hit, surface) = shoot(&scene, centre + up, -up.as_vec3());
    let frame = scene.shading(&hit, &surface, 0.0).frame;
    let (x, y, z) = (frame.x, frame.y, frame.z);
    assert!(x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs()) < 1e-5 && (x.length() - 1.0).abs() < 1e-5);
    (frame.z, surface.ng)
}

#[test]
fn red_points_along_u_and_green_up_the_image() {
    let place = DAffine3::IDENTITY;
    let (n, _) = normal_mapped([204, 128, 230, 255], place);
    assert!((n - Vec3::new(0.6, 0.0, 0.8)).length() < 0.01, "{n}");
    let (n, _) = normal_mapped([128, 204, 230, 255], place);
    assert!((n - Vec3::new(0.0, 0.6, 0.8)).length() < 0.01, "{n}");
}

#[test]
fn mirrored_and_turned_objects_take_their_bumps_along() {
    for scale in [DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, -2.0, 1.0), DVec3::new(-3.0, -3.0, -3.0)] {
        let place = DAffine3::from_rotation_x(0.7) * DAffine3::from_scale(scale);
        for (texel, local) in [([204, 128, 230, 255], DVec3::X), ([128, 204, 230, 255], DVec3::Y)] {
            let (n, ng) = normal_mapped(texel, place);
            let along = (place.matrix3 * local).normalize().as_vec3();
            assert!((n.dot(along) - 0.6).abs() < 0.01, "{scale} {local}: {n}");
            assert!((n.dot(ng) - 0.8).abs() < 0.01, "{scale} {local}: {n}");
        }
    }
}

#[test]
fn mapped_normals_stay_above_the_surface() {
    for texel in [[255, 128, 128, 255], [255, 255, 0, 255], [128, 128, 0, 255], [128, 128, 128, 255], [0; 4]]
    {
        let (n, ng) = normal_mapped(texel, DAffine3::IDENTITY);
        assert!(n.is_finite() && (n.length() - 1.0).abs() < 1e-5 && n.dot(ng) > 0.0, "{texel:?}: {n}");
    }
}

#[test]
fn textures_and_vertex_colours_multiply_the_factors() {
    let mut material = TexturedMaterial {
        base_color_texture: Some(TextureUse::new(0)),
        metallic_roughness_texture: Some(TextureUse::new(1)),
        ..TexturedMaterial::default()
    };
    material.base.base_color = Vec3::new(0.5, 1.0, 1.0);
    material.base.metallic = 0.5;
    let textures = vec![
        texture(1, &[[255, 188, 0, 255]], Encoding::Srgb),
        texture(1, &[[9, 51, 102, 9]], Encoding::Linear),
    ];
    let mesh = Mesh { colors: vec![Vec4::new(0.5, 0.5, 0.5, 1.0); 4], ..square() };
    let scene = scene_of_mesh(mesh, material, textures, DAffine3::IDENTITY);
    let (hit, surface) = shoot(&scene, DVec3::new(0.3, 0.6, 1.0), Vec3::NEG_Z);
    let m = scene.shading(&hit, &surface, 0.0).material;
    assert!((m.base_color - Vec3::new(0.25, 0.25, 0.0)).length() < 0.003, "{}", m.base_color);
    assert!((m.metallic - 0.2).abs() < 1e-6 && (m.roughness - 0.2).abs() < 1e-6);
}

#[test]
fn emission_leaves_the_front_unless_double_sided() {
    for (double_sided, unlit, back) in [(false, false, 0.0), (true, false, 3.0), (false, true, 1.0)] {
        let lamp =
            TexturedMaterial { double_sided, unlit, ..TexturedMaterial::emitter("", Vec3::splat(3.0)) };
        let lamp = TexturedMaterial { base: Default::default(), ..lamp };
        let scene = scene_of(lamp, vec![], DAffine3::IDENTITY);
        let (hit, surface) = shoot(&scene, DVec3::new(0.3, 0.6, 1.0), Vec3::NEG_Z);
        let front = if unlit { 1.0 } else { 3.0 };
        assert_eq!(scene.emission(&hit, &surface, Vec3::Z), Vec3::splat(front));
        let (hit, surface) = shoot(&scene, DVec3::new(0.3, 0.6, -1.0), Vec3::Z);
        assert_eq!(scene.emission(&hit, &surface, Vec3::NEG_Z), Vec3::splat(back));
        assert_eq!(scene.light_of(&hit).is_some(), !unlit);
        assert_eq!(scene.lights.len(), usize::from(!unlit), "one quad; an unlit scene needs no light");
        assert!(scene.warnings.is_empty());
    }
}

#[test]
fn lights_know_their_surfaces_and_surfaces_their_light() {
    let mut b = SceneBuilder::new("test");
    let dark = b.material(TexturedMaterial::default());
    let lamp = b.material(TexturedMaterial::emitter("lamp", Vec3::ONE));
    b.mesh("dark", square(), DAffine3::from_translation(DVec3::Z * -1.0), dark);
    let kite = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 2.0, 0.0)],
        ..square()
    };
    b.mesh("kite", kite, DAffine3::from_translation(DVec3::X * 3.0), lamp);
    b.sphere("ball", DVec3::new(-3.0, 0.0, 0.0), 0.5, lamp);
    b.disk("disk", DVec3::new(-6.0, 0.0, 0.0), DVec3::Z * 2.0, 0.5, lamp);
    b.mesh("square", square(), DAffine3::IDENTITY, lamp);
    b.point_light(DVec3::Y, Vec3::ONE, f64::INFINITY);
    let scene = b.build().unwrap();
    let kinds = scene.lights.iter().map(|l| match l {
        Light::Area(a) => match a.shape {
            AreaShape::Triangle(_) => "triangle",
            AreaShape::Quad { .. } => "quad",
            AreaShape::Sphere { .. } => "sphere",
            AreaShape::Disk { .. } => "disk",
        },
        _ => "other",
    });
    assert_eq!(kinds.collect::<Vec<_>>(), ["triangle", "triangle", "sphere", "disk", "quad", "other"]);
    let light = |object, primitive| scene.light_of(&Hit { t: 1.0, u: 0.2, v: 0.2, primitive, object });
    assert_eq!([light(0, 0), light(0, 1)], [None, None]);
    assert_eq!([light(1, 0), light(1, 1)], [Some(0), Some(1)]);
    assert_eq!([light(2, 0), light(3, 0)], [Some(2), Some(3)]);
    assert_eq!([light(4, 0), light(4, 1)], [Some(4), Some(4)], "two triangles, one quad");
    let first: Vec<u32> = scene.objects.iter().map(|o| o.first_light).collect();
    assert_eq!(first, [u32::MAX, 0, 2, 3, 4]);
}

#[test]
fn textured_lights_tell_their_mean_and_every_point() {
    // The left half emits 1, the right half is black; the opacity is 0.2 everywhere.
    let lamp = TexturedMaterial {
        emissive_texture: Some(TextureUse::new(0)),
        base_color_texture: Some(TextureUse::new(1)),
        alpha_mode: AlphaMode::Blend,
        ..TexturedMaterial::emitter("lamp", Vec3::splat(8.0))
    };
    let textures = vec![
        texture(2, &[[255; 4], [0, 0, 0, 255]], Encoding::Srgb),
        texture(1, &[[255, 255, 255, 51]], Encoding::Srgb),
    ];
    let scene = scene_of(lamp, textures, DAffine3::IDENTITY);
    assert_eq!(scene.lights.len(), 2, "textured pairs are not combined to quads");
    let mean = |i: usize| match &scene.lights[i] {
        Light::Patterned(a) => a.area.radiance.x,
        Light::Area(a) => a.radiance.x,
        _ => panic!(),
    };
    // Triangle 0 has a quarter of its area in the left half, triangle 1 three quarters; opacity 0.2.
    assert!((mean(0) - 8.0 * 0.25 * 0.2).abs() < 1e-5, "{}", mean(0));
    assert!((mean(1) - 8.0 * 0.75 * 0.2).abs() < 1e-5, "{}", mean(1));
    let at = |light: u32, u: f32, v: f32| {
        let point = LightPoint { p: Vec3::ZERO, p_error: Vec3::ZERO, n: Vec3::Z, triangle: 0, u, v };
        scene.light_radiance(light, &point, Vec3::splat(77.0), 0.0).x
    };
    assert!((at(0, 0.1, 0.1) - 1.6).abs() < 1e-5, "near corner 0: left");
    assert_eq!(at(0, 0.8, 0.1), 0.0);
    // Emission at a hit excludes opacity, which the intersection has accounted for.
    let (hit, surface) = shoot(&scene, DVec3::new(0.2, 0.1, 1.0), Vec3::NEG_Z);
    assert!((scene.emission(&hit, &surface, Vec3::Z).x - 8.0).abs() < 1e-5);
    assert!((scene.opacity(&hit) - 0.2).abs() < 1e-6);
}

#[test]
fn black_texture_means_no_light() {
    let lamp = TexturedMaterial {
        emissive_texture: Some(TextureUse::new(0)),
        ..TexturedMaterial::emitter("lamp", Vec3::splat(8.0))
    };
    let scene = scene_of(lamp, vec![texture(1, &[[0; 4]], Encoding::Srgb)], DAffine3::IDENTITY);
    assert!(matches!(scene.lights[..], [Light::Environment(_)]));
    assert_eq!(scene.light_of(&Hit { t: 1.0, u: 0.0, v: 0.0, primitive: 1, object: 0 }), None);
    assert!(scene.warnings[0].0.contains("studio environment"));
}

#[test]
fn opacity_of_masks_and_blends() {
    let with = |alpha: u8, alpha_mode: AlphaMode, vertex: f32| {
        let material = TexturedMaterial {
            alpha_mode,
            base_color_texture: Some(TextureUse::new(0)),
            ..TexturedMaterial::default()
        };
        let mesh = Mesh { colors: vec![Vec4::new(1.0, 1.0, 1.0, vertex); 4], ..square() };
        let textures = vec![texture(1, &[[255, 255, 255, alpha]], Encoding::Srgb)];
        let scene = scene_of_mesh(mesh, material, textures, DAffine3::IDENTITY);
        let opacity = scene.opacity(&Hit { t: 1.0, u: 0.2, v: 0.2, primitive: 0, object: 0 });
        (opacity, scene.has_alpha())
    };
    assert_eq!(with(0, AlphaMode::Opaque, 0.5), (1.0, false));
    assert_eq!(with(102, AlphaMode::Mask { cutoff: 0.5 }, 1.0), (0.0, true));
    assert_eq!(with(153, AlphaMode::Mask { cutoff: 0.5 }, 1.0), (1.0, true));
    assert_eq!(with(153, AlphaMode::Mask { cutoff: 0.5 }, 0.5), (0.0, true));
    let (blend, _) = with(102, AlphaMode::Blend, 0.5);
    assert!((blend - 0.2).abs() < 1e-6);
    // These are opaque everywhere: there are no alpha tests.
    assert_eq!(with(255, AlphaMode::Blend, 1.0), (1.0, false));
    assert_eq!(with(255, AlphaMode::Mask { cutoff: 0.9 }, 1.0), (1.0, false));
}

/// A scene with all quantities that depend on the unit of length, at scale `s`.
fn scaled(s: f64) -> Scene {
    let mut b = SceneBuilder::new("test");
    let mut glass =
        TexturedMaterial { sigma_a: Vec3::splat((0.5 / s) as f32), ..TexturedMaterial::default() };
    glass.base.transmission = 1.0;
    let glass = b.material(glass);
    b.mesh("square", square(), DAffine3::from_scale(DVec3::splat(s)), glass);
    b.sphere("ball", DVec3::new(0.0, 0.0, s), 0.25 * s, glass);
    let intensity = Vec3::splat((3.0 * s * s) as f32);
    b.point_light(DVec3::new(0.0, 2.0 * s, 0.0), intensity, 9.0 * s);
    b.spot_light(DVec3::new(0.0, 2.0 * s, s), DVec3::NEG_Y, intensity, f64::INFINITY, 0.1, 0.4);
    b.distant_light(DVec3::Y, Vec3::ONE);
    b.camera(
        "ortho",
        CameraPose {
            transform: DAffine3::from_translation(DVec3::new(0.0, 0.0, 5.0 * s)),
            projection: Projection::Orthographic { half_height: (1.5 * s) as f32 },
            aspect: None,
            clip: None,
        },
    );
    b.build().unwrap()
}

#[test]
fn render_space_does_not_know_the_unit() {
    let reference = scaled(1.0);
    for k in [-20, -1, 3, 20] {
        let scene = scaled(libm::ldexp(1.0, k));
        assert_eq!(scene.accel.corners(0, 1), reference.accel.corners(0, 1), "{k}");
        assert_eq!(format!("{:?}", scene.lights), format!("{:?}", reference.lights), "{k}");
        assert_eq!(format!("{:?}", scene.cameras), format!("{:?}", reference.cameras), "{k}");
        assert_eq!(scene.materials[0].sigma_a, reference.materials[0].sigma_a, "{k}");
    }
    let s = reference.space.scale as f32;
    assert_eq!(reference.materials[0].sigma_a.x, 0.5 / s);
    let Projection::Orthographic { half_height } = reference.cameras[0].camera.projection else { panic!() };
    assert_eq!(half_height, 1.5 * s);
    assert!(reference.survey.has_transmission && reference.survey.has_volume);
}

#[test]
fn environments() {
    let with = |environment: Option<Environment>| {
        let mut b = SceneBuilder::new("test");
        let m = b.material(TexturedMaterial::default());
        b.sphere("ball", DVec3::ZERO, 1.0, m);
        assert!(!b.has_environment());
        environment.into_iter().for_each(|e| b.environment(e));
        let scene = b.build().unwrap();
        (scene.environment, scene.lights.len(), scene.warnings.len())
    };
    assert_eq!(with(None), (Some(0), 1, 1), "white, with a warning");
    assert_eq!(with(Some(Environment::constant(Vec3::ONE))), (Some(0), 1, 0));
    assert_eq!(with(Some(Environment::constant(Vec3::ZERO))), (None, 0, 0), "intentionally dark");
}

#[test]
fn every_built_in_scene_builds() {
    for (name, _) in NAMES {
        let scene = builtin::builtin(name).unwrap().build().unwrap();
        assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
        assert!(!scene.lights.is_empty() && &*scene.cameras[0].name == "camera");
        assert!(scene.memory_bytes() > 0);
    }
    let furnace = builtin::builtin("furnace").unwrap().build().unwrap();
    assert_eq!(furnace.lights.len(), 6, "a quad per wall");
}

#[test]
fn an_empty_scene_is_a_scene() {
    let scene = SceneBuilder::new("nothing").build().unwrap();
    assert_eq!((scene.survey.objects, scene.environment), (0, Some(0)));
    assert!(scene.cameras[0].camera.origin.is_finite());
}

#[test]
fn mistakes_are_named() {
    type Change = fn(&mut SceneBuilder);
    let cases: [(&str, Change); 10] = [
        ("object 0 'm': uses material 7", |b| _ = b.mesh("m", square(), DAffine3::IDENTITY, 7)),
        ("object 0 'm': its transform", |b| _ = b.mesh("m", square(), DAffine3::from_scale(DVec3::NAN), 0)),
        ("object 0 's': its radius", |b| _ = b.sphere("s", DVec3::ZERO, 0.0, 0)),
        ("object 0 's': its radius", |b| _ = b.sphere("s", DVec3::NAN, 1.0, 0)),
        ("object 0 'd': its normal", |b| _ = b.disk("d", DVec3::ZERO, DVec3::ZERO, 1.0, 0)),
        ("light 0", |b| b.point_light(DVec3::ZERO, Vec3::splat(f32::NAN), 1.0)),
        ("light 0", |b| b.spot_light(DVec3::ZERO, DVec3::Y, Vec3::ONE, 1.0, 0.5, 0.1)),
        ("camera 0 'c'", |b| {
            let pose = CameraPose::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y, 1.0);
            b.camera("c", CameraPose { transform: DAffine3::from_scale(DVec3::ZERO), ..pose });
        }),
        ("material 1 'x': metallic, roughness", |b| {
            let mut m = TexturedMaterial { name: "x".into(), ..TexturedMaterial::default() };
            m.base.roughness = f32::NAN;
            b.material(m);
        }),
        ("material 1 '': uses a texture", |b| {
            let texture = Some(TextureUse::new(0));
            b.material(TexturedMaterial { emissive_texture: texture, ..TexturedMaterial::default() });
        }),
    ];
    for (expected, change) in cases {
        let mut b = SceneBuilder::new("test");
        b.material(TexturedMaterial::default());
        change(&mut b);
        let text = b.build().map(|_| ()).unwrap_err().to_string();
        assert!(text.starts_with("test: ") && text.contains(expected), "{expected}: {text}");
    }
}

/// A single emitting texel gives a light of exact power wherever it is, and so does a single opaque texel of a mask.
#[test]
fn one_texel_anywhere_is_a_light() {
    let n = 300;
    let scale = DAffine3::from_scale(DVec3::splat(2.0));
    let mut state = 1u64;
    for case in 0..60 {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let (x, y) = ((state >> 33) as usize % n, (state >> 48) as usize % n);
        let (mask, linear) = (case % 3 == 1, case % 3 == 2);
        let mut texels = vec![[0, 0, 0, if mask { 0 } else { 255 }]; n * n];
        texels[y * n + x] = [255; 4];
        let lamp = TexturedMaterial::emitter("lamp", Vec3::splat(0.01));
        let map = Some(TextureUse::new(0));
        let lamp = match mask {
            true => TexturedMaterial {
                base_color_texture: map,
                alpha_mode: AlphaMode::Mask { cutoff: 0.9 },
                ..lamp
            },
            false => TexturedMaterial { emissive_texture: map, ..lamp },
        };
        let interpolation = if linear { Interpolation::Linear } else { Interpolation::Nearest };
        let image = Rgba8 { width: n, height: n, texels };
        let lit = Texture::new(image, Encoding::Linear, Sampler { interpolation, ..Sampler::default() });
        let scene = scene_of(lamp, vec![lit], scale);
        let s = scene.space.scale;
        let power: f64 = scene.lights.iter().map(|l| f64::from(l.power(1.0).x)).sum();
        let exact = std::f64::consts::PI * 0.01 * (2.0 * s / n as f64).powi(2);
        let powers: Vec<f32> = scene.lights.iter().map(|l| l.power(1.0).x).collect();
        assert!((power / exact - 1.0).abs() < 1e-3, "case {case}, {x} {y}: {powers:?}, exact {exact}");
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    }
}

/// Texels that are only partly inside the triangle, an opaque region smaller than a texel, and a fully transparent
/// mask.
#[test]
fn slivers_and_pinholes() {
    let spots = |lit: &dyn Fn(usize) -> bool, a: u8| {
        let texels: Vec<_> = (0..64).map(|i| if lit(i) { [255; 4] } else { [0, 0, 0, a] }).collect();
        texture(8, &texels, Encoding::Linear)
    };
    let lamp = |mask: bool| {
        let (map, lamp) = (Some(TextureUse::new(0)), TexturedMaterial::emitter("lamp", Vec3::ONE));
        match mask {
            true => TexturedMaterial {
                base_color_texture: map,
                alpha_mode: AlphaMode::Mask { cutoff: 0.97 },
                ..lamp
            },
            false => TexturedMaterial { emissive_texture: map, ..lamp },
        }
    };
    let one = |uv: [Vec2; 3]| Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 1, 2]],
        uv: [uv.to_vec(), Vec::new()],
        ..Mesh::default()
    };
    let half = |uv: [Vec2; 3], mask: bool, linear: bool, lit: &dyn Fn(usize) -> bool| {
        let image = spots(lit, if mask { 0 } else { 255 });
        let image = if linear {
            let texels = (0..64).map(|i| if lit(i) { [255; 4] } else { [0; 4] }).collect();
            Texture::new(Rgba8 { width: 8, height: 8, texels }, Encoding::Linear, Sampler::default())
        } else {
            image
        };
        scene_of_mesh(one(uv), lamp(mask), vec![image], DAffine3::IDENTITY)
    };
    let corner = [Vec2::ZERO, Vec2::X, Vec2::Y];
    // The triangle contains half of the texel on its diagonal.
    let scene = half(corner, false, false, &|i| i == 8 * 3 + 4);
    let power = f64::from(scene.lights[0].power(1.0).x) / scene.space.scale.powi(2);
    assert!((power / (std::f64::consts::PI * 0.5 / 64.0) - 1.0).abs() < 1e-4, "{power}");
    // An opaque spot of a bilinear mask: alpha is above the cutoff only close to a texel's centre.
    let scene = half(corner, true, true, &|i| i == 8 * 2 + 2);
    assert!(matches!(scene.lights[..], [Light::Patterned(_)]), "{:?}", scene.lights);
    // Fully transparent: there is no light to sample, but the material counts as an emitter.
    let scene = half(corner, true, false, &|_| false);
    assert!(scene.lights.is_empty() && scene.warnings.is_empty(), "{:?}", scene.warnings);
    // Degenerate and huge texture coordinates.
    for uv in [
        [Vec2::splat(0.3); 3],
        [Vec2::ZERO, Vec2::X, Vec2::X * 2.0],
        corner.map(|p| p * 1e6),
        corner.map(|p| p * 1e30),
    ] {
        let scene = half(uv, false, false, &|i| i % 2 == 0);
        assert!(scene.lights.len() <= 1 && scene.warnings.is_empty(), "{uv:?}");
    }
}

/// The mean of a texture that is repeated many times is that of the texture.
#[test]
fn repeats_do_not_alias() {
    for repeat in [64.0, 1000.0, 30_000.0] {
        let mesh = Mesh {
            uv: [[Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO].map(|uv| uv * repeat).to_vec(), Vec::new()],
            ..square()
        };
        let texels: Vec<_> = (0..64).map(|i| [if i == 27 { 255 } else { 0 }; 4]).collect();
        let lamp = TexturedMaterial {
            emissive_texture: Some(TextureUse::new(0)),
            ..TexturedMaterial::emitter("lamp", Vec3::ONE)
        };
        let scene =
            scene_of_mesh(mesh, lamp, vec![texture(8, &texels, Encoding::Linear)], DAffine3::IDENTITY);
        let power: f64 = scene.lights.iter().map(|l| f64::from(l.power(1.0).x)).sum();
        let share = power / scene.space.scale.powi(2) / std::f64::consts::PI * 64.0;
        let tolerance = if repeat < 500.0 { 1e-4 } else { 0.15 };
        assert!((share - 1.0).abs() < tolerance, "{repeat}: {share}");
    }
}
