//! Scenes with published geometry and parameters.

use crate::document::{Document, emitter, glass, lambert, metal};
use crate::shape::Shape;
use glam::DVec3;

type Quad = [[f64; 3]; 4];

// Corners in millimetres [Cornell University Program of Computer Graphics, "Cornell Box Data", 1998].
const FLOOR: Quad = [[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]];
const BACK: Quad = [[549.6, 0.0, 559.2], [0.0, 0.0, 559.2], [0.0, 548.8, 559.2], [556.0, 548.8, 559.2]];
const RIGHT: Quad = [[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2]];
const LEFT: Quad = [[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, 548.8, 559.2], [556.0, 548.8, 0.0]];
const CEILING: Quad = [[556.0, 548.8, 0.0], [556.0, 548.8, 559.2], [0.0, 548.8, 559.2], [0.0, 548.8, 0.0]];
const LAMP: Quad =
    [[343.0, 548.8, 227.0], [343.0, 548.8, 332.0], [213.0, 548.8, 332.0], [213.0, 548.8, 227.0]];
/// Tops of the blocks; the sides extend vertically to the floor.
const SHORT: Quad =
    [[130.0, 165.0, 65.0], [82.0, 165.0, 225.0], [240.0, 165.0, 272.0], [290.0, 165.0, 114.0]];
const TALL: Quad =
    [[423.0, 330.0, 247.0], [265.0, 330.0, 296.0], [314.0, 330.0, 456.0], [472.0, 330.0, 406.0]];

/// The Cornell box with its two blocks.
pub fn cornell() -> Document {
    let (mut doc, white) = cornell_box();
    doc.object("short block", &block(SHORT), white);
    doc.object("tall block", &block(TALL), white);
    doc
}

/// The Cornell box with a metal and a glass sphere.
pub fn cornell_spheres() -> Document {
    let (mut doc, _) = cornell_box();
    let gold = doc.material(metal("metal", [0.95, 0.79, 0.53], 0.15));
    let clear = doc.material(glass("glass"));
    doc.sphere("metal sphere", millimetres([378.0, 120.0, 370.0]), 0.12, 3, gold);
    doc.sphere("glass sphere", millimetres([180.0, 100.0, 150.0]), 0.1, 3, clear);
    doc
}

/// Walls, light and camera. The measured spectra are replaced by the RGB values that most renderers use.
fn cornell_box() -> (Document, usize) {
    let mut doc = Document::default();
    let white = doc.material(lambert("white", [0.725, 0.71, 0.68]));
    let red = doc.material(lambert("red", [0.63, 0.065, 0.05]));
    let green = doc.material(lambert("green", [0.14, 0.45, 0.091]));
    let light = doc.material(emitter("light", [17.0, 12.0, 4.0]));
    for (name, quad, material) in [
        ("floor", FLOOR, white),
        ("back wall", BACK, white),
        ("right wall", RIGHT, green),
        ("left wall", LEFT, red),
    ] {
        doc.object(name, &Shape::quads(&[quad.map(millimetres)]), material);
    }
    doc.object("ceiling", &Shape::quads(&ceiling()), white);
    doc.object("light", &Shape::quads(&[LAMP.map(millimetres)]), light);
    // Focal length of 35 mm with a film of 25 mm × 25 mm.
    let yfov = 2.0 * libm::atan(0.0125 / 0.035);
    doc.camera(millimetres([278.0, 273.0, -800.0]), millimetres([278.0, 273.0, 0.0]), yfov, 1.0);
    (doc, white)
}

/// The ceiling around the opening for the light, as four quads.
fn ceiling() -> [[DVec3; 4]; 4] {
    std::array::from_fn(|i| {
        let next = (i + 1) % 4;
        [CEILING[i], CEILING[next], LAMP[next], LAMP[i]].map(millimetres)
    })
}

/// A block: its top and sides.
fn block(top: Quad) -> Shape {
    let down = |[x, _, z]: [f64; 3]| [x, 0.0, z];
    let mut faces = vec![top.map(millimetres)];
    for i in 0..4 {
        let (a, b) = (top[i], top[(i + 1) % 4]);
        faces.push([a, down(a), down(b), b].map(millimetres));
    }
    Shape::quads(&faces)
}

fn millimetres(p: [f64; 3]) -> DVec3 {
    DVec3::from_array(p) * 1e-3
}

/// Four plates of growing roughness under four lights of growing size and about equal power [Veach & Guibas 1995,
/// fig. 2; Veach 1997, fig. 9.2]; positions, radiances and roughness as in the version remade by Marschner that
/// renderers ship. The plates' colour and the lights' tints are ours.
pub fn veach_mis() -> Document {
    let mut doc = Document::default();
    let floor = doc.material(lambert("floor", [0.4; 3]));
    let quad = |corners: [[f64; 3]; 4]| Shape::quads(&[corners.map(DVec3::from_array)]);
    let (near, far, low, high) = (10.0, -10.0, -4.14615, 10.0);
    doc.object(
        "floor",
        &quad([[-10.0, low, far], [-10.0, low, near], [10.0, low, near], [10.0, low, far]]),
        floor,
    );
    doc.object(
        "wall",
        &quad([[-10.0, low, -2.0], [10.0, low, -2.0], [10.0, high, -2.0], [-10.0, high, -2.0]]),
        floor,
    );
    // Back edge (y, z), front edge (y, z), alpha.
    for (i, [yb, zb, yf, zf, alpha]) in [
        [-2.08375, -0.526323, -2.70651, 0.25609, 0.005],
        [-2.83856, 0.476536, -3.28825, 1.36972, 0.02],
        [-3.43378, 1.74564, -3.73096, 2.70046, 0.05],
        [-3.82069, 3.08221, -3.99615, 4.0667, 0.1],
    ]
    .into_iter()
    .enumerate()
    {
        let name = format!("plate {}", i + 1);
        let material = doc.material(metal(&name, [0.56, 0.57, 0.6], libm::sqrt(alpha)));
        doc.object(&name, &quad([[-4.0, yf, zf], [4.0, yf, zf], [4.0, yb, zb], [-4.0, yb, zb]]), material);
    }
    for (name, centre, radius, radiance, tint) in [
        ("fill light", [10.0, 10.0, 4.0], 0.5, 800.0, [1.0, 1.0, 1.0]),
        ("tiny light", [-3.75, 0.0, 0.0], 0.03333, 901.803, [1.0, 0.55, 0.4]),
        ("small light", [-1.25, 0.0, 0.0], 0.1, 100.0, [1.0, 0.9, 0.4]),
        ("middle light", [1.25, 0.0, 0.0], 0.3, 11.1111, [0.5, 1.0, 0.5]),
        ("large light", [3.75, 0.0, 0.0], 0.9, 1.23457, [0.45, 0.65, 1.0]),
    ] {
        let material = doc.material(emitter(name, tint.map(|t| t * radiance)));
        doc.sphere(name, DVec3::from_array(centre), radius, 2, material);
    }
    doc.camera(DVec3::new(0.0, 2.0, 15.0), DVec3::new(0.0, -2.0, 2.5), 28f64.to_radians(), 1.5);
    doc
}
