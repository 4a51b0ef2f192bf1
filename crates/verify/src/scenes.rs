//! Small scenes and measurements that several checks share.

use dapple_integrator::Dimension;
use dapple_integrator::geometry::Mesh;
use dapple_integrator::lights::Light;
use dapple_integrator::materials::Material;
use dapple_integrator::sampling::{Key, Moments, Pattern, point_2d};
use dapple_integrator::scene::{CameraPose, Scene, SceneBuilder, SceneError, TexturedMaterial};
use dapple_integrator::{Outcome, Settings, render};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use std::ops::ControlFlow;

/// A Lambertian material that emits `emission` from both sides.
pub(crate) fn matte(albedo: f32, emission: f32) -> TexturedMaterial {
    TexturedMaterial {
        emission: Vec3::splat(emission),
        double_sided: true,
        ..TexturedMaterial::lambert("matte", Vec3::splat(albedo))
    }
}

/// An unlit material of the given radiance.
pub(crate) fn shadeless(radiance: f32) -> TexturedMaterial {
    TexturedMaterial { unlit: true, ..matte(radiance, 0.0) }
}

/// A perfectly reflecting metal with the given α.
pub(crate) fn metal(alpha: f32) -> Material {
    Material { roughness: alpha.sqrt(), ..Material::default() }
}

/// A clear dielectric body of index `ior`.
pub(crate) fn glass(ior: f32, roughness: f32) -> Material {
    Material { metallic: 0.0, roughness, ior, transmission: 1.0, thin: false, ..Material::default() }
}

/// A material with constant parameters.
pub(crate) fn of(base: Material) -> TexturedMaterial {
    TexturedMaterial { name: "base".into(), base, ..TexturedMaterial::default() }
}

/// Parallelogram a, a + u, a + u + v, a + v, counter-clockwise seen from its front.
pub(crate) fn quad(a: Vec3, u: Vec3, v: Vec3) -> Mesh {
    Mesh {
        positions: vec![a, a + u, a + u + v, a + v],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// Closed cube of half side `r` with outward faces.
pub(crate) fn cube(r: f32, offset: Vec3) -> Mesh {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0;
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(|i| corner(i) * r + offset).collect(),
        triangles: quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect(),
        ..Mesh::default()
    }
}

/// Closed octasphere: an octahedron subdivided `level` times with outward faces and smooth normals.
pub(crate) fn ball(level: u32, r: f32, offset: Vec3) -> Mesh {
    let mut positions = vec![Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let mut triangles =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..level {
        let mut middles = std::collections::HashMap::new();
        let mut next = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |i: u32, j: u32| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    positions.push((positions[i as usize] + positions[j as usize]).normalize());
                    positions.len() as u32 - 1
                })
            };
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            next.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = next;
    }
    Mesh {
        normals: positions.clone(),
        positions: positions.iter().map(|p| *p * r + offset).collect(),
        triangles,
        ..Mesh::default()
    }
}

/// A scene builder with a camera at `from` looking at `at`, vertical field of view in radians.
pub(crate) fn seen(from: DVec3, at: DVec3, yfov: f64) -> SceneBuilder {
    let mut builder = SceneBuilder::new("check");
    let up = if (at - from).normalize().y.abs() > 0.9 { DVec3::Z } else { DVec3::Y };
    builder.camera("camera", CameraPose::look_at(from, at, up, yfov));
    builder
}

/// A scene builder with an orthographic camera at `from` looking along −z, of the given half height.
pub(crate) fn seen_in_parallel(from: DVec3, half_height: f32) -> SceneBuilder {
    let mut builder = SceneBuilder::new("check");
    let projection = dapple_integrator::camera::Projection::Orthographic { half_height };
    let transform = DAffine3 { matrix3: DMat3::IDENTITY, translation: from };
    builder.camera("camera", CameraPose { transform, projection, aspect: None, clip: None });
    builder
}

/// A white Lambertian floor at the origin facing +y, seen from above in a field of view so narrow that it is one point.
/// The radiance times π is the irradiance at the origin.
pub(crate) fn irradiance_meter() -> SceneBuilder {
    let mut builder = seen(DVec3::new(0.3, 0.8, 0.2), DVec3::ZERO, 1e-4);
    let white = builder.material(matte(1.0, 0.0));
    let floor = quad(Vec3::new(-0.05, 0.0, 0.05), Vec3::X * 0.1, Vec3::Z * -0.1);
    builder.mesh("floor", floor, DAffine3::IDENTITY, white);
    builder
}

/// Settings for a square image.
pub(crate) fn square(side: u32, spp: u32) -> Settings {
    Settings { size: (side, side), ..Settings::default() }.with_spp(spp)
}

/// Renders the scene from its first camera.
pub(crate) fn run(scene: &Scene, settings: &Settings) -> Outcome {
    render(scene, &scene.cameras[0].camera, settings, &|_| ControlFlow::Continue(()))
}

/// Builds and renders a scene as [`run`] does. Returns the moments of its pixels, each an independent estimate.
pub(crate) fn pixels(builder: SceneBuilder, settings: &Settings) -> Result<Moments, SceneError> {
    Ok(moments(&run(&builder.build()?, settings)))
}

/// Moments of the mean of the channels over pixels; NaN if there are bad samples.
pub(crate) fn moments(outcome: &Outcome) -> Moments {
    if outcome.stats.bad_sample_count > 0 {
        return [f64::NAN; 2].into_iter().collect();
    }
    outcome.film.mean().pixels.iter().map(|p| f64::from(p.element_sum()) / 3.0).collect()
}

/// Irradiance at `p` from one unoccluded light: moments over independent sets of `points` Sobol points.
pub(crate) fn irradiance(light: &Light, p: Vec3, n: Vec3, points: u32, sets: u64) -> Moments {
    let set = |seed: u64| {
        let key = Key::pixel(seed, 0, 0).at(0, Dimension::LightPoint);
        let sum: f64 = (0..points)
            .filter_map(|s| light.sample(p, point_2d(Pattern::Sobol, s, points, key), 0.0))
            .map(|s| f64::from(s.radiance.x) * f64::from(s.wi.dot(n).max(0.0)) / f64::from(s.pdf))
            .sum();
        sum / f64::from(points)
    };
    (0..sets).map(set).collect()
}
