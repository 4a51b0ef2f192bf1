//! One scene for each effect of the distribution tracer, composed so that the effect dominates the image.

use crate::document::{Document, emitter, lambert, metal, mirror, plastic};
use crate::shape::Shape;
use glam::{DMat3, DVec3};
use serde_json::json;
use std::f64::consts::TAU;

/// Settings that glTF cannot express, by file.
pub const SIDECARS: [(&str, &str); 3] = [
    (
        "blurred_reflection.toml",
        "# An even sky, so that all there is to see is what is reflected.\nenv-color = [0.7, 0.75, 0.85]\n",
    ),
    (
        "depth_of_field.toml",
        "# The lights of a town, and a lens of six blades that is sharp on the third ball.\n\
         env = \"town.hdr\"\n\
         aperture-radius = 0.14\n\
         focus-distance = 5.9\n\
         aperture-shape = \"blades:6:15\"\n",
    ),
    (
        "all_effects.toml",
        "# A dim sky; sharp on the red ball; open for half of the animation's second.\n\
         env-color = [0.3, 0.36, 0.5]\n\
         aperture-radius = 0.06\n\
         focus-distance = 5.2\n\
         shutter = \"0:0.5\"\n",
    ),
];

/// A fence whose shadow is sharp at its foot and softens with distance, and boards at increasing heights.
pub fn soft_shadow() -> Document {
    let mut doc = Document::default();
    let ground = doc.material(lambert("ground", [0.72, 0.7, 0.66]));
    doc.object("ground", &floor(20.0), ground);
    let wood = doc.material(lambert("fence", [0.42, 0.2, 0.11]));
    for i in 0..7 {
        let x = 0.42 * (f64::from(i) - 3.0);
        let (low, high) = (DVec3::new(x - 0.06, 0.0, -1.26), DVec3::new(x + 0.06, 1.0, -1.14));
        doc.object(&format!("post {}", i + 1), &Shape::cuboid(low, high, false), wood);
    }
    for (i, (x, height, rgb)) in
        [(-1.45, 0.03, [0.1, 0.25, 0.5]), (0.0, 0.25, [0.55, 0.36, 0.06]), (1.45, 0.55, [0.12, 0.4, 0.16])]
            .into_iter()
            .enumerate()
    {
        let board = doc.material(lambert(&format!("board {}", i + 1), rgb));
        let (low, high) = (DVec3::new(x - 0.4, height, 0.5), DVec3::new(x + 0.4, height + 0.03, 1.0));
        doc.object(&format!("board {}", i + 1), &Shape::cuboid(low, high, false), board);
    }
    let light = doc.material(emitter("light", [52.0, 48.0, 42.0]));
    let lamp = facing(DVec3::new(-0.6, 5.0, -4.6), DVec3::new(0.0, 0.0, 0.3), 0.8, 0.8);
    doc.object("light", &Shape::quads(&[lamp]), light);
    doc.camera(DVec3::new(0.0, 3.6, 5.0), DVec3::new(0.0, 0.2, 0.3), 34f64.to_radians(), 1.5);
    doc
}

/// Upright panels on a checkerboard: metals of increasing roughness on the left, mirrors of increasing square blur on
/// the right. Objects near a panel are reflected sharply, distant ones are blurred: three balls at increasing distances
/// stand before each.
pub fn blurred_reflection(checker: &[u8]) -> Document {
    let mut doc = Document::default();
    checkered_floor(&mut doc, checker, 12.0);
    let panels = [
        metal("roughness 0.05", [0.9; 3], 0.05),
        metal("roughness 0.15", [0.9; 3], 0.15),
        metal("roughness 0.3", [0.9; 3], 0.3),
        metal("roughness 0.5", [0.9; 3], 0.5),
        mirror("blur 0", [0.9; 3], 0.0),
        mirror("blur 0.1", [0.9; 3], 0.1),
        mirror("blur 0.25", [0.9; 3], 0.25),
        mirror("blur 0.6", [0.9; 3], 0.6),
    ];
    let balls = [("red", [0.65, 0.04, 0.03]), ("yellow", [0.8, 0.45, 0.02]), ("blue", [0.03, 0.1, 0.55])]
        .map(|(name, rgb)| (name, doc.material(lambert(name, rgb))));
    for (i, panel) in panels.into_iter().enumerate() {
        let x = 0.9 * (i as f64 - 3.5) + if i < 4 { -0.1 } else { 0.1 };
        let of = panel["name"].as_str().unwrap_or_default().to_string();
        let panel = doc.material(panel);
        let (low, high) = (DVec3::new(x - 0.42, 0.0, -0.05), DVec3::new(x + 0.42, 1.9, 0.0));
        doc.object(&format!("panel of {of}"), &Shape::cuboid(low, high, false), panel);
        for (t, (name, ball)) in [-1.0, 0.0, 1.0].into_iter().zip(balls) {
            let at = DVec3::new(x + 0.22 * t, 0.13, 0.65 + 0.5 * t);
            doc.sphere(&format!("{name} ball before {of}"), at, 0.13, 2, ball);
        }
    }
    doc.camera(DVec3::new(0.0, 4.2, 8.0), DVec3::new(0.0, 0.75, 0.0), 24f64.to_radians(), 2.2);
    doc
}

/// Balls from near to far, in front of the lights of a town (`town.hdr`) that show the shape of the aperture.
pub fn depth_of_field() -> Document {
    let mut doc = Document::default();
    let table = doc.material(lambert("table", [0.3, 0.28, 0.27]));
    doc.object("table", &floor(60.0), table);
    for (i, rgb) in
        [[0.7, 0.08, 0.05], [0.75, 0.35, 0.03], [0.75, 0.65, 0.08], [0.1, 0.45, 0.12], [0.06, 0.18, 0.6]]
            .into_iter()
            .enumerate()
    {
        let paint = doc.material(plastic(&format!("paint {}", i + 1), rgb, 0.3));
        let t = i as f64 - 2.0;
        let at = DVec3::new(0.62 * t + 0.1 * t * t, 0.35, -1.5 * t - 0.12 * t * t);
        doc.sphere(&format!("ball {}", i + 1), at, 0.35, 3, paint);
    }
    let lamp = doc.material(emitter("lamp", [30.0, 28.0, 25.0]));
    let light = facing(DVec3::new(-3.0, 6.0, 3.0), DVec3::ZERO, 1.0, 1.0);
    doc.object("lamp", &Shape::quads(&[light]), lamp);
    doc.camera(DVec3::new(0.0, 1.5, 6.0), DVec3::new(0.0, 0.75, 0.0), 30f64.to_radians(), 1.6);
    doc
}

/// All five effects together: a checkerboard to the horizon, soft shadows, a blurred and a rough mirror, objects in
/// front of and behind the focal plane, a flying ball and a rotating hand.
pub fn all_effects(checker: &[u8]) -> Document {
    let mut doc = Document::default();
    checkered_floor(&mut doc, checker, 12.0);
    let steel = doc.material(metal("steel", [0.85, 0.86, 0.9], 0.3));
    let glass = doc.material(mirror("blurred mirror", [0.8, 0.82, 0.85], 0.15));
    for (name, x, panel) in [("rough metal", -1.3, steel), ("mirror", 1.3, glass)] {
        let (low, high) = (DVec3::new(x - 1.2, 0.0, -1.6), DVec3::new(x + 1.2, 1.5, -1.5));
        doc.object(name, &Shape::cuboid(low, high, false), panel);
    }
    let red = doc.material(plastic("red", [0.6, 0.05, 0.04], 0.3));
    let yellow = doc.material(plastic("yellow", [0.8, 0.5, 0.04], 0.3));
    let blue = doc.material(lambert("blue", [0.02, 0.13, 0.5]));
    let green = doc.material(plastic("green", [0.08, 0.4, 0.12], 0.2));
    doc.sphere("red ball", DVec3::new(-0.2, 0.4, 0.2), 0.4, 3, red);
    doc.sphere("green ball", DVec3::new(-1.0, 0.22, 2.2), 0.22, 3, green);
    let flying = doc.sphere("flying ball", DVec3::new(0.7, 0.7, 0.0), 0.28, 3, yellow);
    doc.track(flying, "translation", &[0.0, 1.0], &[[0.7, 0.6, 0.0], [2.3, 1.0, 0.2]]);
    let bar = Shape::cuboid(DVec3::new(0.0, -0.16, -0.04), DVec3::new(0.6, 0.16, 0.04), false);
    let hand = doc.object("hand", &bar, blue);
    doc.place(hand, DVec3::new(-1.35, 0.72, 0.1));
    // A third of a turn while the shutter is open.
    let turns: [[f64; 4]; 5] = std::array::from_fn(|i| {
        let (sin, cos) = libm::sincos(i as f64 * TAU / 12.0);
        [0.0, 0.0, sin, cos]
    });
    doc.track(hand, "rotation", &[0.0, 0.25, 0.5, 0.75, 1.0], &turns);
    let light = doc.material(emitter("light", [75.0, 70.0, 62.0]));
    let lamp = facing(DVec3::new(-1.2, 5.0, -3.2), DVec3::new(0.0, 0.0, 0.0), 0.8, 0.8);
    doc.object("light", &Shape::quads(&[lamp]), light);
    doc.camera(DVec3::new(0.3, 1.7, 5.2), DVec3::new(0.0, 0.55, 0.0), 34f64.to_radians(), 1.5);
    doc
}

/// A square in the plane y = 0.
pub fn floor(half: f64) -> Shape {
    let corners = [[-half, 0.0, half], [half, 0.0, half], [half, 0.0, -half], [-half, 0.0, -half]];
    Shape::quads(&[corners.map(DVec3::from_array)])
}

/// A checkered floor with squares of half a metre.
fn checkered_floor(doc: &mut Document, checker: &[u8], half: f64) -> usize {
    let texture = doc.nearest_texture(checker);
    let mut material = lambert("checker", [0.8; 3]);
    material["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
    let material = doc.material(material);
    let mut plane = floor(half);
    plane.uvs = plane.positions.iter().map(|[x, _, z]| [x + half, z + half]).collect();
    doc.object("floor", &plane, material)
}

/// A rectangle of half sides `u` and `v` about `centre` whose front faces `target`.
pub fn facing(centre: DVec3, target: DVec3, u: f64, v: f64) -> [DVec3; 4] {
    let n = (target - centre).normalize();
    let right = DVec3::Y.cross(n).normalize();
    let frame = DMat3::from_cols(right * u, n.cross(right) * v, n);
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| centre + frame * DVec3::new(x, y, 0.0))
}
