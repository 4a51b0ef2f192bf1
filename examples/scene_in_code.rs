//! Builds a scene in Rust without a file: a pyramid of balls in a sunbeam, rendered to `balls.png`.
//! `cargo run --release --example scene_in_code`
//!
//! All parts come from `dapple-integrator`, which re-exports them as modules.

use dapple_integrator::camera::Film;
use dapple_integrator::geometry::Mesh;
use dapple_integrator::imaging::{Tone, write};
use dapple_integrator::lights::Environment;
use dapple_integrator::materials::Material;
use dapple_integrator::scene::builder::CameraPose;
use dapple_integrator::scene::{Scene, SceneBuilder, SceneError, TexturedMaterial};
use dapple_integrator::{Progress, Settings, render};
use glam::{DAffine3, DVec3, Vec3};
use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = scene()?;
    let settings = Settings { size: (480, 320), ..Settings::default() }.with_spp(64);
    let outcome = render(&scene, &scene.cameras[0].camera, &settings, &|p: Progress| {
        eprint!("\r{:3.0} %", 100.0 * p.fraction);
        ControlFlow::Continue(())
    });
    let film: &Film = &outcome.film;
    write::png(Path::new("balls.png"), &film.mean(), Tone::Srgb, 0.0)?;
    eprintln!("\rballs.png: {:.1} M rays in {:.1} s", outcome.stats.rays as f64 / 1e6, outcome.stats.seconds);
    Ok(())
}

/// Builds the scene; lengths in metres, radiance in linear Rec.709.
fn scene() -> Result<Scene, SceneError> {
    let mut b = SceneBuilder::new("balls");
    let ground = b.material(TexturedMaterial::lambert("ground", Vec3::new(0.35, 0.33, 0.3)));
    b.mesh("ground", square(400.0), DAffine3::IDENTITY, ground);
    let step = 0.5 * 3f64.sqrt();
    for (i, (x, y, z)) in [(-0.5, 0.0, 0.0), (0.5, 0.0, 0.0), (0.0, 0.0, -step), (0.0, 0.8165, -step / 3.0)]
        .into_iter()
        .enumerate()
    {
        let ball = b.material(ball(i));
        b.sphere(format!("ball {i}"), DVec3::new(x, 0.5 + y, z), 0.5, ball);
    }
    b.environment(Environment::constant(Vec3::new(0.35, 0.45, 0.6)));
    b.distant_light(DVec3::new(0.6, 1.0, 0.5).normalize(), Vec3::new(2.0, 1.9, 1.6));
    let (eye, target) = (DVec3::new(1.0, 1.6, 4.2), DVec3::new(0.0, 0.65, -0.2));
    b.camera("camera", CameraPose::look_at(eye, target, DVec3::Y, 0.55));
    b.build()
}

/// Material of a ball: glass, gold, red plastic, rough copper.
fn ball(i: usize) -> TexturedMaterial {
    let metal =
        |base_color, roughness| Material { base_color, metallic: 1.0, roughness, ..Material::default() };
    let plastic = Material {
        base_color: Vec3::new(0.6, 0.06, 0.05),
        metallic: 0.0,
        roughness: 0.25,
        ..Material::default()
    };
    let glass =
        Material { metallic: 0.0, roughness: 0.0, transmission: 1.0, thin: false, ..Material::default() };
    let kinds = [
        ("glass", glass),
        ("gold", metal(Vec3::new(1.0, 0.77, 0.34), 0.1)),
        ("plastic", plastic),
        ("copper", metal(Vec3::new(0.95, 0.64, 0.54), 0.45)),
    ];
    let (name, base) = kinds[i % kinds.len()];
    TexturedMaterial { name: name.into(), base, ..TexturedMaterial::default() }
}

/// A square on the ground, facing up; `half` is half its side.
fn square(half: f32) -> Mesh {
    let corner = |x: f32, z: f32| Vec3::new(x * half, 0.0, z * half);
    let positions = vec![corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)];
    Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() }
}
