//! Coincident surfaces: which one is visible must not depend on rounding, on the order in the file or on the viewpoint.

use crate::document::{Document, emitter, lambert, metal};
use crate::shape::Shape;
use glam::DVec3;

/// The parallelogram in the plane of `[origin, u, v]` from (s, t) to (s + w, t + h), in lengths of u and v; its front
/// faces u × v.
fn on([origin, u, v]: [DVec3; 3], [s, t]: [f64; 2], [w, h]: [f64; 2]) -> [DVec3; 4] {
    [(s, t), (s + w, t), (s + w, t + h), (s, t + h)].map(|(s, t)| origin + u * s + v * t)
}

fn floor(doc: &mut Document) {
    let grey = doc.material(lambert("grey", [0.6; 3]));
    let ground = [DVec3::new(-2.0, 0.0, 1.5), DVec3::X * 4.0, DVec3::NEG_Z * 3.0];
    doc.object("floor", &Shape::quads(&[on(ground, [0.0; 2], [1.0; 2])]), grey);
    let wall = [DVec3::new(-2.0, 0.0, -1.5), DVec3::X * 4.0, DVec3::Y * 2.0];
    doc.object("wall", &Shape::quads(&[on(wall, [0.0; 2], [1.0; 2])]), grey);
}

fn camera(doc: &mut Document) {
    doc.camera(DVec3::new(0.0, 1.4, 5.0), DVec3::new(0.0, 0.8, 0.0), 32f64.to_radians(), 1.5);
}

/// Coincident lamps: panels with the same corners and with others, and two balls. Of each pair the first one, warm, is
/// visible and emits, and the second one, blue, does neither.
pub fn coincident() -> Document {
    let mut doc = Document::default();
    floor(&mut doc);
    let warm = doc.material(emitter("warm", [6.0, 4.0, 2.0]));
    let blue = doc.material(emitter("blue", [1.0, 3.0, 9.0]));
    let panel = [DVec3::new(-1.5, 0.5, -0.9), DVec3::new(0.7, 0.1, 0.3), DVec3::new(-0.1, 0.8, 0.2)];
    let corners = on(panel, [0.0; 2], [1.0; 2]);
    let [a, b, c, d] = corners;
    doc.object("panel", &Shape::quads(&[corners]), warm);
    doc.object("its copy", &Shape::quads(&[[b, c, d, a]]), blue);
    let part = on(panel, [0.25, 0.5], [0.5, 0.25]);
    doc.object("a part of it", &Shape::quads(&[part]), blue);
    let plate = [DVec3::new(0.5, 1.6, 0.4), DVec3::X * 0.9, DVec3::new(0.0, -0.2, -0.5)];
    doc.object("plate", &Shape::quads(&[on(plate, [0.0, 1.0], [1.0, -1.0])]), warm);
    doc.object("half beside it", &Shape::quads(&[on(plate, [0.5, 1.0], [1.0, -1.0])]), blue);
    for (name, material) in [("ball", warm), ("its copy", blue)] {
        doc.sphere(name, DVec3::new(0.1, 0.45, 0.3), 0.2, 2, material);
    }
    camera(&mut doc);
    doc
}

/// Lamps in the planes of a ceiling, of a tilted wall and of a plate of rough metal, which continue behind them.
pub fn coplanar() -> Document {
    let mut doc = Document::default();
    floor(&mut doc);
    let white = doc.material(lambert("white", [0.7; 3]));
    let steel = doc.material(metal("steel", [0.8, 0.8, 0.82], 0.3));
    let lamp = doc.material(emitter("lamp", [7.0, 6.5, 5.0]));
    let dim = doc.material(emitter("dim lamp", [1.2, 2.0, 1.4]));
    let ceiling = [DVec3::new(-2.0, 2.0, -1.5), DVec3::X * 4.0, DVec3::Z * 3.0];
    doc.object("ceiling", &Shape::quads(&[on(ceiling, [0.0; 2], [1.0; 2])]), white);
    doc.object("lamp in the ceiling", &Shape::quads(&[on(ceiling, [0.3, 0.4], [0.15, 0.2])]), lamp);
    let tilted = [DVec3::new(-1.9, 0.0, 0.3), DVec3::new(0.7, 0.0, -1.2), DVec3::new(-0.1, 1.7, -0.2)];
    doc.object("lamp in the tilted wall", &Shape::quads(&[on(tilted, [0.2, 0.35], [0.5, 0.4])]), dim);
    doc.object("tilted wall", &Shape::quads(&[on(tilted, [0.0; 2], [1.0; 2])]), white);
    let plate = [DVec3::new(0.1, 0.02, 1.0), DVec3::new(1.3, 0.0, 0.1), DVec3::new(0.0, 0.3, -1.4)];
    doc.object("plate", &Shape::quads(&[on(plate, [0.0; 2], [1.0; 2])]), steel);
    doc.object("lamp in the plate", &Shape::quads(&[on(plate, [0.6, 0.3], [0.2, 0.2])]), dim);
    camera(&mut doc);
    doc
}
