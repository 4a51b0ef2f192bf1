//! Small scenes and measurements shared by the tests of this crate.
#![allow(dead_code)]

pub mod maps;
pub mod moving;
pub mod tracers;

use dapple_geometry::Mesh;
use dapple_imaging::Image;
use dapple_integrator::camera::{Aperture, Camera, Lens, Projection};
use dapple_integrator::{Outcome, Settings, render};
use dapple_lights::Environment;
use dapple_materials::{Material, Mirror};
use dapple_sampling::Moments;
use dapple_scene::{CameraPose, Scene, SceneBuilder, TexturedMaterial};
use dapple_testkit::closed_form::inside_of_sphere;
use glam::{DAffine3, DVec2, DVec3, Vec3};
use std::ops::ControlFlow;

/// A Lambertian material that emits light.
pub fn matte(albedo: f32, emission: f32) -> TexturedMaterial {
    TexturedMaterial {
        name: format!("matte {albedo}"),
        base: Material {
            base_color: Vec3::splat(albedo),
            metallic: 0.0,
            specular: 0.0,
            ..Material::default()
        },
        emission: Vec3::splat(emission),
        ..TexturedMaterial::default()
    }
}

/// A smooth transparent material of this index and colour.
pub fn pane(ior: f32, thin: bool, color: Vec3) -> TexturedMaterial {
    let base = Material {
        base_color: color,
        metallic: 0.0,
        roughness: 0.0,
        ior,
        transmission: 1.0,
        thin,
        ..Material::default()
    };
    TexturedMaterial { base, ..TexturedMaterial::default() }
}

/// A metal of the given roughness.
pub fn metal(color: Vec3, roughness: f32) -> TexturedMaterial {
    TexturedMaterial {
        name: format!("metal {roughness}"),
        base: Material { base_color: color, roughness, ..Material::default() },
        ..TexturedMaterial::default()
    }
}

/// Parallelogram a, a + u, a + u + v, a + v; counter-clockwise seen from its front.
pub fn quad(a: Vec3, u: Vec3, v: Vec3) -> Mesh {
    Mesh {
        positions: vec![a, a + u, a + u + v, a + v],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// Cube of half side 1, facing inward.
pub fn inward_cube() -> Mesh {
    let positions: Vec<Vec3> =
        (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0).collect();
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

/// A builder with a camera at `from` that looks at `at`; vertical field of view in radians.
pub fn seen(from: DVec3, at: DVec3, yfov: f64) -> SceneBuilder {
    let mut builder = SceneBuilder::new("test");
    let up = if (at - from).normalize().y.abs() > 0.9 { DVec3::Z } else { DVec3::Y };
    builder.camera("camera", CameraPose::look_at(from, at, up, yfov));
    builder
}

/// A white Lambertian floor at the origin facing +y, seen from above with a field of view so narrow that all rays hit
/// the same point. The radiance times π is the irradiance at the origin.
pub fn irradiance_meter() -> SceneBuilder {
    let mut builder = seen(DVec3::new(0.3, 0.8, 0.2), DVec3::ZERO, 1e-4);
    let white = builder.material(matte(1.0, 0.0));
    builder.mesh(
        "floor",
        quad(Vec3::new(-0.05, 0.0, 0.05), Vec3::X * 0.1, Vec3::Z * -0.1),
        DAffine3::IDENTITY,
        white,
    );
    builder
}

pub fn run(scene: &Scene, settings: &Settings) -> Outcome {
    render(scene, &scene.cameras[0].camera, settings, &|_| ControlFlow::Continue(()))
}

/// Mean over pixels and channels, and its standard error from the variance of the pixels (each an independent
/// estimate).
pub fn mean_and_error(outcome: &Outcome) -> (f64, f64) {
    let mean = outcome.film.mean();
    let moments: Moments = mean.pixels.iter().map(|p| f64::from(p.element_sum()) / 3.0).collect();
    (moments.mean, moments.standard_error())
}

/// Asserts a mean within 4 standard errors of `exact`, with a standard error of at most 0.2 %.
#[track_caller]
pub fn assert_close(what: &str, outcome: &Outcome, exact: f64) {
    let (mean, error) = mean_and_error(outcome);
    assert_eq!(outcome.stats.bad_sample_count, 0, "{what}");
    assert!(error <= 2e-3 * exact, "{what}: standard error {error} is too large to be conclusive");
    let floor = 2e-6 * exact;
    assert!((mean - exact).abs() <= 4.0 * error + floor, "{what}: {mean} ± {error}, exact {exact}");
}

/// A material that emits `color` from both sides and reflects nothing.
pub fn shadeless(color: f32) -> TexturedMaterial {
    TexturedMaterial { double_sided: true, ..matte(0.0, color) }
}

/// A mirror with a square blur of `blur` that loses no energy.
pub fn blurred_mirror(blur: f32) -> TexturedMaterial {
    TexturedMaterial {
        name: format!("mirror {blur}"),
        base: Material { mirror: Some(Mirror { kr: Vec3::ONE, blur }), ..Material::default() },
        ..TexturedMaterial::default()
    }
}

/// A builder with an orthographic camera at `from` along `d`, with the up vector `up`, that covers ± `half_height`; the
/// surroundings are black.
pub fn seen_in_parallel(from: DVec3, d: DVec3, up: DVec3, half_height: f64) -> SceneBuilder {
    let mut builder = SceneBuilder::new("test");
    let pose = CameraPose::look_at(from, from + d, up, 1.0);
    let projection = Projection::Orthographic { half_height: half_height as f32 };
    builder.camera("camera", CameraPose { projection, ..pose });
    builder.environment(Environment::constant(Vec3::ZERO));
    builder
}

/// The scene's camera with a lens, lengths in world units; the focus distance may be infinite.
pub fn with_lens(scene: &Scene, aperture: Aperture, radius: f64, focus: f64) -> Camera {
    let length = |l| scene.space.length_to_render(l);
    let lens = Lens { aperture, radius: length(radius), focus_distance: length(focus) };
    Camera { lens: Some(lens), ..scene.cameras[0].camera.clone() }
}

/// The half-plane n·(s, t) ≤ c of the plane origin + s·u + t·v, 20 units to each side; `n` is a unit vector.
pub fn half_plane(origin: Vec3, span: [Vec3; 2], n: DVec2, c: f64) -> Mesh {
    half_plane_up_to(20.0, origin, span, n, c)
}

/// As [`half_plane`], `reach` units to each side.
pub fn half_plane_up_to(reach: f32, origin: Vec3, [u, v]: [Vec3; 2], n: DVec2, c: f64) -> Mesh {
    let n = n.as_vec2();
    let (across, along) = (u * n.x + v * n.y, v * n.x - u * n.y);
    quad(origin + across * c as f32 - along * reach, across * -reach, along * (2.0 * reach))
}

/// A transparent material of this roughness with one surface, which reflects nothing. `ior` 1 is a thin wall.
pub fn clear(roughness: f32, ior: f32) -> TexturedMaterial {
    TexturedMaterial {
        name: format!("clear {roughness}"),
        base: Material {
            metallic: 0.0,
            specular: 0.0,
            transmission: 1.0,
            roughness,
            ior,
            thin: ior == 1.0,
            ..Material::default()
        },
        ..TexturedMaterial::default()
    }
}

/// A small rough surface at z = 0, seen along its normal from z = 0.5, and a disk at `z` that fills a cone of half
/// angle `theta` about the normal: above for reflection (the camera is between them), below for refraction.
pub fn under_a_cap(surface: TexturedMaterial, z: f64, theta: f64, disk: TexturedMaterial) -> Scene {
    let mut builder = seen_in_parallel(DVec3::Z * 0.5, DVec3::NEG_Z, DVec3::Y, 1e-5);
    let rough = builder.material(surface);
    let plane = quad(Vec3::new(-0.01, -0.01, 0.0), Vec3::X * 0.02, Vec3::Y * 0.02);
    builder.mesh("surface", plane, DAffine3::IDENTITY, rough);
    let white = builder.material(disk);
    builder.disk("cap", DVec3::Z * z, DVec3::Z * -z.signum(), z.abs() * theta.tan(), white);
    builder.build().unwrap()
}

/// The inside of a grey sphere of radius 1 about the origin with a point light of unit intensity at `light`; the camera
/// sees (0, 0, −1), with one more reflection. Also returns the exact radiance.
pub fn sphere_lit_from(light: DVec3) -> (Scene, f64) {
    let mut builder = seen_in_parallel(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1e-6);
    let grey = builder.material(matte(0.5, 0.0));
    builder.sphere("sphere", DVec3::ZERO, 1.0, grey);
    builder.point_light(light, Vec3::ONE, f64::INFINITY);
    let to = light + DVec3::Z;
    let exact = inside_of_sphere(0.5, 1.0, to.length(), to.normalize().z);
    (builder.build().unwrap(), exact)
}

/// A smooth body over a floor, a lamp of many triangles, and an environment map.
pub fn outdoors() -> Scene {
    let mut builder = seen(DVec3::new(0.0, 1.0, 5.0), DVec3::ZERO, 0.8);
    let sky = |i: usize| if i == 21 { Vec3::splat(60.0) } else { Vec3::new(0.2, 0.3, 0.1 * (i % 7) as f32) };
    let sky = Image { width: 16, height: 8, pixels: (0..128).map(sky).collect() };
    builder.environment(Environment::picture(sky, 0.3, 1.0, true).unwrap());
    let base = Material { roughness: 0.4, ..Material::default() };
    let metal = builder.material(TexturedMaterial { base, ..matte(0.6, 0.0) });
    let grey = builder.material(matte(0.6, 0.0));
    let lamp = builder.material(matte(0.0, 8.0));
    let corners = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let body = |r: f32, at: Vec3, normals: &[Vec3]| Mesh {
        positions: corners.iter().map(|p| *p * r + at).collect(),
        normals: normals.to_vec(),
        triangles: faces.to_vec(),
        ..Mesh::default()
    };
    builder.mesh("ball", body(1.0, Vec3::ZERO, &corners), DAffine3::IDENTITY, metal);
    builder.mesh("lamp", body(0.2, Vec3::new(1.5, 1.0, 0.5), &[]), DAffine3::IDENTITY, lamp);
    builder.mesh("floor", body(9.0, Vec3::new(0.0, -10.0, 0.0), &[]), DAffine3::IDENTITY, grey);
    builder.build().unwrap()
}
