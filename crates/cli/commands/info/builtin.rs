//! Facts of built-in scenes, which have no file: the contents of the built scene.

use dapple_integrator::lights::Light;
use dapple_integrator::scene::{Object, Scene};
use glam::Vec3;
use serde_json::{Value, json};

/// Returns the facts of a file, for a scene built in code.
pub fn facts(scene: &Scene) -> Value {
    let materials: Vec<&str> = scene.materials.iter().map(|m| &*m.name).collect();
    let emitting = scene.materials.iter().filter(|m| m.emission != Vec3::ZERO);
    let emissive = emitting.map(|m| {
        json!({ "name": &*m.name, "radiance": m.emission.to_array(), "textured": m.emissive_texture.is_some() })
    });
    let survey = &scene.survey;
    let objects = scene.objects.iter().enumerate().map(|(i, o)| object(i, o));
    json!({
        "nodes": survey.objects, "meshes": survey.objects - survey.shapes, "instances": survey.objects - survey.shapes,
        "triangles": survey.triangles, "stored_triangles": survey.triangles, "shapes": survey.shapes,
        "scenes": [], "variants": [], "animations": [], "objects": objects.collect::<Vec<_>>(),
        "materials": materials, "emissive": emissive.collect::<Vec<_>>(), "textures": [], "lights": lights(scene),
        "light_unit": null, "cameras": [], "skins": [], "morphs": [], "extensions": [],
    })
}

fn object(index: usize, object: &Object) -> Value {
    json!({ "node": index, "name": &*object.name, "instances": 1 })
}

/// Counts the lights of each kind; the radiance of emitting surfaces is listed with their materials.
fn lights(scene: &Scene) -> Vec<Value> {
    const KINDS: [&str; 6] = ["point", "spot", "directional", "area", "environment", "moving"];
    let count = |kind| scene.lights.iter().filter(|light| self::kind(light) == kind).count();
    let some = KINDS.into_iter().map(|kind| (kind, count(kind))).filter(|(_, count)| *count > 0);
    some.map(|(kind, count)| json!({ "kind": kind, "placed": count })).collect()
}

fn kind(light: &Light) -> &'static str {
    match light {
        Light::Point(_) => "point",
        Light::Spot(_) => "spot",
        Light::Moving(_) => "moving",
        Light::Distant(_) => "directional",
        Light::Area(_) | Light::Patterned(_) => "area",
        Light::Environment(_) => "environment",
    }
}
