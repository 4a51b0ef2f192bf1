//! Transparent media: nested solids, and panes with lights behind them.

use crate::document::{Document, emitter, glass, lambert, metal};
use crate::shape::Shape;
use glam::DVec3;
use serde_json::{Value, json};

/// Settings that glTF cannot express, by file.
pub const SIDECARS: [(&str, &str); 1] =
    [("nested_media.toml", "# An even sky around the table.\nenv-color = [0.8, 0.9, 1.0]\n")];

/// A solid of this index of refraction that attenuates white light to `rgb` after one metre.
fn matter(name: &str, ior: f64, rgb: [f64; 3], priority: f64) -> Value {
    let mut material = glass(name);
    let extensions = &mut material["extensions"];
    extensions["KHR_materials_ior"]["ior"] = json!(ior);
    extensions["KHR_materials_volume"]["attenuationColor"] = json!(rgb);
    extensions["KHR_materials_volume"]["attenuationDistance"] = json!(1.0);
    material["extras"] = json!({ "dapple": { "priority": priority } });
    material
}

/// A thin wall of this index of refraction and colour.
fn pane(name: &str, ior: f64, rgb: [f64; 3]) -> Value {
    json!({
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [rgb[0], rgb[1], rgb[2], 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.0,
        },
        "doubleSided": true,
        "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 1.0 },
            "KHR_materials_ior": { "ior": ior },
        },
    })
}

fn ground(doc: &mut Document) {
    let grey = doc.material(lambert("ground", [0.6, 0.58, 0.55]));
    let corners = [[-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0], [-9.0, 0.0, -9.0]];
    doc.object("ground", &Shape::quads(&[corners.map(DVec3::from_array)]), grey);
}

fn block(doc: &mut Document, name: &str, low: [f64; 3], high: [f64; 3], material: usize) {
    doc.object(name, &Shape::cuboid(DVec3::from_array(low), DVec3::from_array(high), false), material);
}

/// A block of amber with a glass ball, a bubble and a metal bead inside; an overlapping block of ice with higher
/// priority; and two touching blocks.
pub fn nested_media() -> Document {
    let mut doc = Document::default();
    ground(&mut doc);
    let amber = doc.material(matter("amber", 1.2, [0.9, 0.6, 0.25], 0.0));
    let clear = doc.material(matter("glass", 1.5, [1.0; 3], 0.0));
    let bubble = doc.material(matter("air", 1.0, [1.0; 3], 2.0));
    let ice = doc.material(matter("ice", 1.31, [0.3, 0.7, 0.9], 1.0));
    let gold = doc.material(metal("gold", [0.95, 0.79, 0.53], 0.4));
    block(&mut doc, "amber", [-1.5, 0.05, -0.8], [0.8, 1.25, 0.6], amber);
    block(&mut doc, "ice", [0.3, 0.15, -0.5], [1.6, 0.9, 0.9], ice);
    block(&mut doc, "ice that touches", [0.5, 0.9, -0.4], [1.4, 1.3, 0.5], ice);
    doc.sphere("ball", DVec3::new(-0.9, 0.7, -0.1), 0.35, 3, clear);
    doc.sphere("bubble", DVec3::new(-0.05, 0.75, 0.2), 0.25, 3, bubble);
    doc.sphere("bead", DVec3::new(-0.4, 0.4, 0.2), 0.15, 3, gold);
    doc.camera(DVec3::new(0.3, 1.8, 5.0), DVec3::new(0.0, 0.6, 0.0), 30f64.to_radians(), 4.0 / 3.0);
    doc
}

/// A coloured window with a lamp and a sun behind it, two clear panes, and a block without refraction.
pub fn panes() -> Document {
    let mut doc = Document::default();
    ground(&mut doc);
    let colours = [[0.9, 0.2, 0.15], [0.95, 0.8, 0.2], [0.2, 0.35, 0.85]];
    for (i, rgb) in colours.into_iter().enumerate() {
        let of = doc.material(pane(&format!("pane {}", i + 1), 1.5, rgb));
        let x = -1.2 + 0.8 * i as f64;
        let corners = [[x, 0.2, -1.0], [x + 0.75, 0.2, -1.0], [x + 0.75, 2.4, -1.0], [x, 2.4, -1.0]];
        doc.object(&format!("pane {}", i + 1), &Shape::quads(&[corners.map(DVec3::from_array)]), of);
    }
    let clear = doc.material(pane("clear", 1.5, [1.0; 3]));
    for z in [0.2, 0.5] {
        let corners = [[1.4, 0.0, z], [2.6, 0.0, z], [2.6, 1.2, z], [1.4, 1.2, z]];
        doc.object("clear pane", &Shape::quads(&[corners.map(DVec3::from_array)]), clear);
    }
    let smoke = doc.material(matter("smoke", 1.0, [0.6, 0.5, 0.7], 0.0));
    block(&mut doc, "smoke", [-2.4, 0.02, 0.0], [-1.5, 0.9, 0.8], smoke);
    let white = doc.material(lambert("block", [0.7; 3]));
    block(&mut doc, "block", [-0.2, 0.0, 0.1], [0.3, 0.6, 0.6], white);
    let light = doc.material(emitter("light", [18.0, 16.0, 13.0]));
    let lamp = [[-0.4, 2.6, -2.4], [0.4, 2.6, -2.4], [0.4, 2.0, -2.8], [-0.4, 2.0, -2.8]];
    let mut lamp = Shape::quads(&[lamp.map(DVec3::from_array)]);
    lamp.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    doc.object("lamp", &lamp, light);
    doc.sun("sun", DVec3::new(-0.35, 1.0, -1.1), [2.4, 2.2, 1.9]);
    doc.camera(DVec3::new(0.2, 2.3, 5.5), DVec3::new(0.0, 0.7, -0.4), 36f64.to_radians(), 4.0 / 3.0);
    doc
}
