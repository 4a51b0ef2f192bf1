//! Surfaces whose shading normals differ from their geometric normals.

use crate::document::{Document, emitter, metal, plastic};
use crate::effects::{facing, floor};
use crate::shape::Shape;
use dapple_imaging::Image;
use dapple_imaging::color::srgb_to_linear;
use glam::{DVec3, Vec3};
use serde_json::{Value, json};

/// Texels along each side of a stud.
const SIDE: usize = 16;

/// A normal map of one round stud, with slopes up to 56°. The writer encodes as sRGB, so the values are those whose
/// code values are the normals.
pub fn studs() -> Image {
    let texel = |i: usize| {
        let at = |i: usize| (2 * i + 1) as f64 / SIDE as f64 - 1.0;
        let (x, y) = (at(i % SIDE), -at(i / SIDE));
        let radius = (x * x + y * y).sqrt();
        // A ramp of slope 1.5 that begins and ends smoothly.
        let slope = if radius < 1.0 { 6.0 * radius * (1.0 - radius) } else { 0.0 };
        let n = DVec3::new(slope * x / radius, slope * y / radius, 1.0).normalize();
        let code = ((n + 1.0) * 127.5).round() / 255.0;
        code.as_vec3().to_array().map(srgb_to_linear).into()
    };
    Image { width: SIDE, height: SIDE, pixels: (0..SIDE * SIDE).map(texel).collect::<Vec<Vec3>>() }
}

/// Studded sheets of plastic, rough metal, polished metal and frosted glass under two lamps, and a coarsely tessellated
/// ball.
pub fn normal_maps(studs: &[u8]) -> Document {
    let mut doc = Document::default();
    let map = doc.nearest_texture(studs);
    let studded = |mut material: Value| {
        material["normalTexture"] = json!({ "index": map });
        material["doubleSided"] = json!(true);
        material
    };
    let plastic = doc.material(studded(plastic("plastic", [0.55, 0.2, 0.1], 0.4)));
    let mut ground = floor(6.0);
    ground.uvs = ground.positions.iter().map(|[x, _, z]| [*x, -*z]).collect();
    doc.object("ground", &ground, plastic);
    let mut frosted = metal("frosted glass", [0.9; 3], 0.35);
    frosted["pbrMetallicRoughness"]["metallicFactor"] = json!(0.0);
    frosted["extensions"] = json!({ "KHR_materials_transmission": { "transmissionFactor": 1.0 } });
    for (name, x, material) in [
        ("rough metal", -2.2, metal("rough metal", [0.9, 0.75, 0.5], 0.3)),
        ("polished metal", 0.0, metal("polished metal", [0.9; 3], 0.0)),
        ("frosted glass", 2.2, frosted),
    ] {
        let material = doc.material(studded(material));
        let corners = [[x - 1.0, 0.1], [x + 1.0, 0.1], [x + 1.0, 1.9], [x - 1.0, 1.9]];
        let mut sheet = Shape::quads(&[corners.map(|[x, y]| DVec3::new(x, y, -0.5))]);
        sheet.uvs = corners.map(|[x, y]| [1.5 * x, -1.5 * y]).to_vec();
        doc.object(name, &sheet, material);
    }
    let gold = doc.material(metal("gold", [0.95, 0.79, 0.53], 0.4));
    let ball = doc.object("ball", &Shape::sphere(0.5, 0), gold);
    doc.place(ball, DVec3::new(-0.9, 0.5, 1.1));
    let light = doc.material(emitter("light", [30.0, 28.0, 25.0]));
    for (name, at) in [("light", DVec3::new(-2.5, 4.0, 2.5)), ("light behind", DVec3::new(3.0, 3.0, -3.5))] {
        doc.object(name, &Shape::quads(&[facing(at, DVec3::new(0.0, 0.8, 0.0), 0.5, 0.5)]), light);
    }
    doc.camera(DVec3::new(0.4, 2.1, 6.2), DVec3::new(0.0, 0.8, 0.0), 36f64.to_radians(), 1.5);
    doc
}
