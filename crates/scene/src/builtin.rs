//! Built-in scenes, such as `builtin:cornell`.
//!
//! The Cornell box is the physical one at Cornell University, with the corner coordinates published with its
//! measurements [Cornell 1998], in millimetres there and in metres here. Its measured spectra are replaced by the RGB
//! values that most renderers use [Bitterli 2016]: white (0.725, 0.71, 0.68), red (0.63, 0.065, 0.05), green (0.14,
//! 0.45, 0.091), light (17, 12, 4).
use crate::{CameraPose, SceneBuilder, TexturedMaterial};
use dapple_camera::Projection;
use dapple_geometry::Mesh;
use dapple_materials::Material;
use glam::{DAffine3, DMat3, DVec3, Vec3};

/// Creates a built-in scene; None for an unknown name.
pub fn builtin(name: &str) -> Option<SceneBuilder> {
    match name {
        "cornell" => Some(cornell()),
        "cornell-spheres" => Some(cornell_spheres()),
        "furnace" => Some(furnace()),
        _ => None,
    }
}

/// All names, each with a one-line description.
pub const NAMES: &[(&str, &str)] = &[
    ("cornell", "the Cornell box with its two blocks, as published"),
    ("cornell-spheres", "the Cornell box with a glass and a metal sphere instead of the blocks"),
    ("furnace", "inside a cube whose walls emit radiance 1 and reflect half: radiance 2 everywhere"),
];

const WHITE: Vec3 = Vec3::new(0.725, 0.71, 0.68);
const RED: Vec3 = Vec3::new(0.63, 0.065, 0.05);
const GREEN: Vec3 = Vec3::new(0.14, 0.45, 0.091);
const LIGHT: Vec3 = Vec3::new(17.0, 12.0, 4.0);

type Quad = [[f32; 3]; 4];

const FLOOR: Quad = [[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]];
const BACK: Quad = [[549.6, 0.0, 559.2], [0.0, 0.0, 559.2], [0.0, 548.8, 559.2], [556.0, 548.8, 559.2]];
const RIGHT: Quad = [[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2]];
const LEFT: Quad = [[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, 548.8, 559.2], [556.0, 548.8, 0.0]];
const CEILING: Quad = [[556.0, 548.8, 0.0], [556.0, 548.8, 559.2], [0.0, 548.8, 559.2], [0.0, 548.8, 0.0]];
const LAMP: Quad =
    [[343.0, 548.8, 227.0], [343.0, 548.8, 332.0], [213.0, 548.8, 332.0], [213.0, 548.8, 227.0]];
const SHORT: [Quad; 5] = [
    [[130.0, 165.0, 65.0], [82.0, 165.0, 225.0], [240.0, 165.0, 272.0], [290.0, 165.0, 114.0]],
    [[290.0, 0.0, 114.0], [290.0, 165.0, 114.0], [240.0, 165.0, 272.0], [240.0, 0.0, 272.0]],
    [[130.0, 0.0, 65.0], [130.0, 165.0, 65.0], [290.0, 165.0, 114.0], [290.0, 0.0, 114.0]],
    [[82.0, 0.0, 225.0], [82.0, 165.0, 225.0], [130.0, 165.0, 65.0], [130.0, 0.0, 65.0]],
    [[240.0, 0.0, 272.0], [240.0, 165.0, 272.0], [82.0, 165.0, 225.0], [82.0, 0.0, 225.0]],
];
const TALL: [Quad; 5] = [
    [[423.0, 330.0, 247.0], [265.0, 330.0, 296.0], [314.0, 330.0, 456.0], [472.0, 330.0, 406.0]],
    [[423.0, 0.0, 247.0], [423.0, 330.0, 247.0], [472.0, 330.0, 406.0], [472.0, 0.0, 406.0]],
    [[472.0, 0.0, 406.0], [472.0, 330.0, 406.0], [314.0, 330.0, 456.0], [314.0, 0.0, 456.0]],
    [[314.0, 0.0, 456.0], [314.0, 330.0, 456.0], [265.0, 330.0, 296.0], [265.0, 0.0, 296.0]],
    [[265.0, 0.0, 296.0], [265.0, 330.0, 296.0], [423.0, 330.0, 247.0], [423.0, 0.0, 247.0]],
];

const MILLIMETRES: f64 = 1e-3;

/// A mesh of two triangles per quad; corners are counter-clockwise seen from the front.
fn quads(corners: &[Quad]) -> Mesh {
    let positions = corners.iter().flatten().map(|&p| Vec3::from_array(p)).collect();
    let first = (0..corners.len() as u32).map(|q| 4 * q);
    let triangles = first.flat_map(|i| [[i, i + 1, i + 2], [i, i + 2, i + 3]]).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

/// The ceiling with a hole that the light fills exactly: a ring of eight triangles.
fn ceiling() -> Mesh {
    let positions = CEILING.iter().chain(&LAMP).map(|&p| Vec3::from_array(p)).collect();
    let ring = (0..4).flat_map(|i| {
        let next = (i + 1) % 4;
        [[i, next, 4 + next], [i, 4 + next, 4 + i]]
    });
    Mesh { positions, triangles: ring.collect(), ..Mesh::default() }
}

/// The empty box; also returns the index of its white material.
fn empty_box(name: &str) -> (SceneBuilder, u32) {
    let mut b = SceneBuilder::new(name);
    let white = b.material(TexturedMaterial::lambert("white", WHITE));
    let red = b.material(TexturedMaterial::lambert("red", RED));
    let green = b.material(TexturedMaterial::lambert("green", GREEN));
    let lamp = b.material(TexturedMaterial::emitter("light", LIGHT));
    b.mesh("floor", quads(&[FLOOR]), metres(), white);
    b.mesh("ceiling", ceiling(), metres(), white);
    b.mesh("back wall", quads(&[BACK]), metres(), white);
    b.mesh("right wall", quads(&[RIGHT]), metres(), green);
    b.mesh("left wall", quads(&[LEFT]), metres(), red);
    b.mesh("light", quads(&[LAMP]), metres(), lamp);
    // Focal length 35 mm behind a film of 25 mm × 25 mm, looking along +z.
    let turned = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, -1.0));
    b.camera(
        "camera",
        CameraPose {
            transform: DAffine3 {
                matrix3: turned,
                translation: DVec3::new(278.0, 273.0, -800.0) * MILLIMETRES,
            },
            projection: Projection::Perspective { tan_half: 0.025 / 2.0 / 0.035 },
            aspect: Some(1.0),
            clip: None,
        },
    );
    (b, white)
}

fn metres() -> DAffine3 {
    DAffine3::from_scale(DVec3::splat(MILLIMETRES))
}

fn cornell() -> SceneBuilder {
    let (mut b, white) = empty_box("cornell");
    b.mesh("short block", quads(&SHORT), metres(), white);
    b.mesh("tall block", quads(&TALL), metres(), white);
    b
}

fn cornell_spheres() -> SceneBuilder {
    let (mut b, _) = empty_box("cornell-spheres");
    let glass =
        Material { metallic: 0.0, roughness: 0.0, transmission: 1.0, thin: false, ..Material::default() };
    let glass = b.material(TexturedMaterial { name: "glass".into(), base: glass, ..Default::default() });
    let metal = Material {
        base_color: Vec3::new(0.95, 0.79, 0.53),
        metallic: 1.0,
        roughness: 0.15,
        ..Material::default()
    };
    let metal = b.material(TexturedMaterial { name: "metal".into(), base: metal, ..Default::default() });
    b.sphere("glass sphere", DVec3::new(180.0, 100.0, 150.0) * MILLIMETRES, 100.0 * MILLIMETRES, glass);
    b.sphere("metal sphere", DVec3::new(378.0, 120.0, 370.0) * MILLIMETRES, 120.0 * MILLIMETRES, metal);
    b
}

/// A closed cube of side 2 about the origin, facing inwards: emission 1, albedo ½, so that the radiance along every ray
/// is 1 / (1 − ½) = 2 (docs/science.md, "Closed room").
fn furnace() -> SceneBuilder {
    let mut b = SceneBuilder::new("furnace");
    let wall =
        TexturedMaterial { emission: Vec3::ONE, ..TexturedMaterial::lambert("wall", Vec3::splat(0.5)) };
    let wall = b.material(wall);
    let positions = (0..8)
        .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32) * 2.0 - 1.0)
        .collect();
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]].map(inwards);
    let triangles = faces.into_iter().flatten().collect();
    b.mesh("cube", Mesh { positions, triangles, ..Mesh::default() }, DAffine3::IDENTITY, wall);
    let eye = DVec3::new(0.1, -0.2, 0.3);
    b.camera("camera", CameraPose::look_at(eye, eye - DVec3::new(0.2, 0.1, 1.0), DVec3::Y, 1.2));
    b
}

/// Two triangles, facing inwards, of a face given counter-clockwise seen from outside.
fn inwards([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    [[a, c, b], [a, d, c]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_known_and_no_other() {
        for (name, line) in NAMES {
            assert!(builtin(name).is_some(), "{name}");
            assert!(!line.is_empty());
        }
        assert!(builtin("").is_none() && builtin("Cornell").is_none());
    }

    #[test]
    fn the_box_faces_inwards() {
        let inside = Vec3::new(278.0, 273.0, 280.0);
        for quad in [FLOOR, BACK, RIGHT, LEFT, CEILING, LAMP] {
            let p = quad.map(Vec3::from_array);
            assert!((p[1] - p[0]).cross(p[2] - p[0]).dot(inside - p[0]) > 0.0, "{quad:?}");
        }
        for t in ceiling().triangles {
            let p = t.map(|i| ceiling().positions[i as usize]);
            assert!((p[1] - p[0]).cross(p[2] - p[0]).y < 0.0, "{t:?}");
        }
    }

    #[test]
    fn the_ceiling_and_its_lamp_cover_each_other_exactly() {
        let area = |mesh: &Mesh| -> f32 {
            let corners = mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize]));
            corners.map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
        };
        let whole = area(&quads(&[CEILING]));
        assert!((area(&ceiling()) + area(&quads(&[LAMP])) - whole).abs() < 1e-5 * whole);
    }

    #[test]
    fn blocks_face_outwards() {
        for block in [SHORT, TALL] {
            let all = block.as_flattened();
            let centre = all.iter().map(|&p| Vec3::from_array(p)).sum::<Vec3>() / all.len() as f32;
            for quad in block {
                let p = quad.map(Vec3::from_array);
                assert!((p[1] - p[0]).cross(p[2] - p[0]).dot(p[0] - centre) > 0.0, "{quad:?}");
            }
        }
    }

    #[test]
    fn the_furnace_faces_inwards() {
        for face in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
            for t in inwards(face) {
                let p = t.map(|i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5);
                assert!((p[1] - p[0]).cross(p[2] - p[0]).dot(-p[0]) > 0.0, "{face:?}");
            }
        }
    }
}
