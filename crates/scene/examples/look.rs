//! Builds a scene in code and prints the surfaces that camera rays hit.
//! `cargo run --release --example look -p dapple-scene`

use dapple_geometry::Opaque;
use dapple_scene::{CameraPose, SceneBuilder, SceneError, TexturedMaterial};
use glam::{DVec3, Vec2, Vec3};

fn main() -> Result<(), SceneError> {
    let mut builder = SceneBuilder::new("lamp over a ball");
    let clay = builder.material(TexturedMaterial::lambert("clay", Vec3::new(0.6, 0.3, 0.2)));
    let lamp = builder.material(TexturedMaterial::emitter("lamp", Vec3::splat(10.0)));
    builder.sphere("ball", DVec3::ZERO, 1.0, clay);
    builder.disk("lamp", DVec3::new(0.0, 4.0, 0.0), DVec3::NEG_Y, 0.5, lamp);
    builder.camera("front", CameraPose::look_at(DVec3::new(0.0, 1.0, 6.0), DVec3::ZERO, DVec3::Y, 1.5));
    let scene = builder.build()?;
    println!("{} objects, {} lights", scene.survey.objects, scene.lights.len());
    for y in 0..24 {
        let ray = scene.cameras[0].camera.ray((0, y), Vec2::splat(0.5), (1, 24), Vec2::ZERO);
        let Some(hit) = scene.accel.intersect(&ray, 0.0, &Opaque) else { continue };
        let surface = scene.accel.surface(&ray, 0.0, &hit);
        let (object, shading) = (&scene.objects[hit.object as usize], scene.shading(&hit, &surface, 0.0));
        let radiance = scene.emission(&hit, &surface, -ray.d);
        println!("row {y:2}: {}, albedo {}, emits {radiance}", object.name, shading.material.base_color);
    }
    Ok(())
}
