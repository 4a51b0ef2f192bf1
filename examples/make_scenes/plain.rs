//! Scenes for one purpose each.

use crate::document::{Document, lambert, metal, plastic};
use crate::shape::Shape;
use dapple_imaging::Image;
use glam::{DVec3, Vec3};
use serde_json::json;
use std::f64::consts::PI;

/// Settings that glTF cannot express, by file.
pub const SIDECARS: [(&str, &str); 3] = [
    ("environment.toml", "# The sky that lights the scene.\nenv = \"sky.hdr\"\n"),
    (
        "antialias.toml",
        "# An even sky, so that all there is to see is the pattern.\nenv-color = [1.0, 1.0, 1.0]\n",
    ),
    (
        "motion_blur.toml",
        "# One second: the ball rolls past, the blade turns by 240 degrees.\nshutter = \"0:1\"\n\
         # A little light from all sides.\nenv-color = [0.3, 0.36, 0.45]\n",
    ),
];

/// A closed room with objects in it; everything emits 1 and reflects half, so that every ray returns 1 + ½ + ¼ + … = 2
/// and nothing can be distinguished.
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

/// Two rows of balls under the sky: metal above plastic, from smooth on the left to rough.
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

/// A checkerboard of half a metre per square, out to a kilometre.
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

/// A ball that slides, a blade that turns by 240° and a static block, with their shadows, in front of a mirror.
pub fn motion_blur() -> Document {
    let mut doc = Document::default();
    let ground = doc.material(lambert("ground", [0.5; 3]));
    let corners = [[-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0], [-9.0, 0.0, -9.0]];
    doc.object("ground", &Shape::quads(&[corners.map(DVec3::from_array)]), ground);
    let mut mirror = metal("mirror", [0.85; 3], 0.0);
    mirror["extras"] = json!({ "dapple": { "mirror": { "kr": [0.85, 0.85, 0.85], "blur": 0.0 } } });
    let mirror = doc.material(mirror);
    let glass = [[-3.6, 0.2, -1.8], [3.6, 0.2, -1.8], [3.6, 3.0, -1.8], [-3.6, 3.0, -1.8]];
    doc.object("mirror", &Shape::quads(&[glass.map(DVec3::from_array)]), mirror);
    let red = doc.material(lambert("red", [0.7, 0.1, 0.06]));
    let ball = doc.sphere("ball", DVec3::new(-2.9, 0.5, 0.4), 0.5, 3, red);
    doc.track(ball, "translation", &[0.0, 1.0], &[[-2.9, 0.5, 0.4], [-1.6, 0.5, 0.4]]);
    let yellow = doc.material(plastic("yellow", [0.9, 0.6, 0.03], 0.3));
    let (low, high) = (DVec3::new(0.1, -0.24, -0.03), DVec3::new(1.0, 0.24, 0.03));
    let blade = doc.object("blade", &Shape::cuboid(low, high, false), yellow);
    doc.place(blade, DVec3::new(0.2, 1.3, 0.2));
    // From half past four, clockwise as seen by the camera, through 240 degrees: adjacent keys differ by at most 80.
    let turns = [0.0, 1.0, 2.0, 3.0].map(|i| {
        let (sin, cos) = libm::sincos((-30.0 - 80.0 * i) * PI / 360.0);
        [0.0, 0.0, sin, cos]
    });
    doc.track(blade, "rotation", &[0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0], &turns);
    let grey = doc.material(plastic("grey", [0.25, 0.26, 0.28], 0.5));
    let (low, high) = (DVec3::new(0.12, 0.0, 0.02), DVec3::new(0.28, 1.38, 0.12));
    doc.object("post", &Shape::cuboid(low, high, false), grey);
    let blue = doc.material(plastic("blue", [0.08, 0.17, 0.42], 0.25));
    let (low, high) = (DVec3::new(1.7, 0.0, 0.0), DVec3::new(2.5, 0.8, 0.8));
    doc.object("block", &Shape::cuboid(low, high, false), blue);
    doc.sun("sun", DVec3::new(0.45, 0.8, 0.55), [3.2, 3.0, 2.7]);
    doc.camera(DVec3::new(-0.4, 2.3, 6.4), DVec3::new(-0.1, 0.95, -0.2), 36f64.to_radians(), 1.6);
    doc
}

/// Two by two texels.
pub fn checker() -> Image {
    let (black, white) = (Vec3::splat(0.02), Vec3::splat(0.9));
    Image { width: 2, height: 2, pixels: vec![white, black, black, white] }
}
