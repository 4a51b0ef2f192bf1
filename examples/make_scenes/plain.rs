//! Scenes made for one purpose each.

use crate::document::{Document, lambert, metal, plastic};
use crate::shape::Shape;
use dapple_imaging::Picture;
use glam::{DVec3, Vec3};
use serde_json::json;

/// What glTF cannot say, by file.
pub const SIDECARS: [(&str, &str); 2] = [
    ("environment.toml", "# The sky that lights the scene.\nenv = \"sky.hdr\"\n"),
    (
        "antialias.toml",
        "# An even sky, so that all there is to see is the pattern.\nenv-color = [1.0, 1.0, 1.0]\n",
    ),
];

/// A closed room with things in it; everything emits 1 and reflects half, so that every ray brings
/// 1 + ½ + ¼ + … = 2 and nothing can be told apart.
pub fn furnace() -> Document {
    let mut doc = Document::default();
    let mut glowing = lambert("glowing", [0.5; 3]);
    glowing["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
    let glowing = doc.material(glowing);
    doc.object("room", &Shape::cuboid(DVec3::splat(-2.0), DVec3::splat(2.0), true), glowing);
    let (low, high) = (DVec3::new(-1.2, -2.0, -1.5), DVec3::new(-0.2, -0.6, -0.5));
    doc.object("block", &Shape::cuboid(low, high, false), glowing);
    doc.sphere("ball", DVec3::new(0.8, -1.3, -0.6), 0.7, 2, glowing);
    doc.camera(DVec3::new(0.0, 0.0, 1.9), DVec3::new(0.0, -0.6, -1.0), 60f64.to_radians(), 1.5);
    doc
}

/// Two rows of balls under the sky: metal above plastic, smooth to rough from the left.
pub fn environment() -> Document {
    let mut doc = Document::default();
    let ground = doc.material(lambert("ground", [0.32, 0.31, 0.3]));
    let corners = [[-60.0, 0.0, 60.0], [60.0, 0.0, 60.0], [60.0, 0.0, -60.0], [-60.0, 0.0, -60.0]];
    doc.object("ground", &Shape::quads(&[corners.map(DVec3::from_array)]), ground);
    for i in 0..5 {
        let roughness = f64::from(i) / 4.0;
        let x = 1.1 * (f64::from(i) - 2.0);
        let gold = doc.material(metal(&format!("metal {roughness}"), [0.95, 0.79, 0.53], roughness));
        let blue = doc.material(plastic(&format!("plastic {roughness}"), [0.08, 0.17, 0.42], roughness));
        doc.sphere(&format!("metal ball {}", i + 1), DVec3::new(x, 0.5, -0.9), 0.5, 3, gold);
        doc.sphere(&format!("plastic ball {}", i + 1), DVec3::new(x, 0.5, 0.9), 0.5, 3, blue);
    }
    doc.camera(DVec3::new(0.0, 3.4, 7.0), DVec3::new(0.0, 0.55, -0.3), 30f64.to_radians(), 1.6);
    doc
}

/// Half a metre per square, out to a kilometre.
pub fn antialias(checker: &[u8]) -> Document {
    let mut doc = Document::default();
    let texture = doc.nearest_texture(checker);
    let mut material = lambert("checker", [1.0; 3]);
    material["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
    let material = doc.material(material);
    let half = 1000.0;
    let corners = [[-half, 0.0, half], [half, 0.0, half], [half, 0.0, -half], [-half, 0.0, -half]];
    let mut plane = Shape::quads(&[corners.map(DVec3::from_array)]);
    // One repetition is two squares, a metre.
    plane.uvs = corners.iter().map(|[x, _, z]| [x + half, z + half]).collect();
    doc.object("plane", &plane, material);
    doc.camera(DVec3::new(0.2, 1.5, 0.0), DVec3::new(0.2, 1.2, -1.0), 50f64.to_radians(), 1.5);
    doc
}

/// Two by two texels.
pub fn checker() -> Picture {
    let (black, white) = (Vec3::splat(0.02), Vec3::splat(0.9));
    Picture { width: 2, height: 2, pixels: vec![white, black, black, white] }
}
