//! Meshes, computed in f64. Front faces wind counter-clockwise.

use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A mesh; attributes are empty where a mesh has none.
#[derive(Clone, Default)]
pub struct Shape {
    pub positions: Vec<[f64; 3]>,
    pub normals: Vec<[f64; 3]>,
    pub uvs: Vec<[f64; 2]>,
    pub triangles: Vec<[u16; 3]>,
}

impl Shape {
    /// Flat quads, each of two triangles with separate corners.
    pub fn quads(corners: &[[DVec3; 4]]) -> Self {
        let positions = corners.iter().flatten().map(|p| p.to_array()).collect();
        let first = (0..corners.len() as u16).map(|q| 4 * q);
        let triangles = first.flat_map(|i| [[i, i + 1, i + 2], [i, i + 2, i + 3]]).collect();
        Self { positions, triangles, ..Self::default() }
    }

    /// An axis-aligned box; `inside` makes its faces point inwards.
    pub fn cuboid(low: DVec3, high: DVec3, inside: bool) -> Self {
        let at = |i: usize| {
            let pick = |bit: usize, axis: usize| if i >> bit & 1 == 1 { high[axis] } else { low[axis] };
            DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
        };
        let outwards = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let faces = outwards.map(|face| if inside { [face[3], face[2], face[1], face[0]] } else { face });
        Self::quads(&faces.map(|face| face.map(at)))
    }

    /// An icosahedron subdivided `detail` times, with smooth normals.
    pub fn sphere(radius: f64, detail: u32) -> Self {
        let (mut unit, mut triangles) = icosahedron();
        for _ in 0..detail {
            triangles = quartered(&mut unit, &triangles);
        }
        let normals: Vec<_> = unit.iter().map(|p| p.to_array()).collect();
        let positions = unit.iter().map(|p| (*p * radius).to_array()).collect();
        Self { positions, normals, triangles, uvs: Vec::new() }
    }

    /// Component-wise minimum and maximum of the positions, as stored.
    pub fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        let mut low = [f32::INFINITY; 3];
        let mut high = [f32::NEG_INFINITY; 3];
        for (axis, &x) in self.positions.iter().flat_map(|p| p.iter().enumerate()) {
            low[axis] = low[axis].min(x as f32);
            high[axis] = high[axis].max(x as f32);
        }
        (low, high)
    }
}

/// An icosahedron of two poles and two rings of five vertices, on the unit sphere.
fn icosahedron() -> (Vec<DVec3>, Vec<[u16; 3]>) {
    let latitude = libm::atan(0.5);
    let at = |latitude: f64, turn: f64| {
        let (sin, cos) = libm::sincos(latitude);
        let (s, c) = libm::sincos(turn * TAU);
        DVec3::new(cos * s, sin, cos * c)
    };
    let mut points = vec![at(FRAC_PI_2, 0.0)];
    points.extend((0..5).map(|i| at(latitude, f64::from(i) / 5.0)));
    points.extend((0..5).map(|i| at(-latitude, (f64::from(i) + 0.5) / 5.0)));
    points.push(at(-FRAC_PI_2, 0.0));
    let faces = (0..5).flat_map(|i| {
        let next = (i + 1) % 5;
        let (a, b, c, d) = (1 + i, 1 + next, 6 + i, 6 + next);
        [[0, a, b], [a, c, b], [b, c, d], [11, d, c]]
    });
    (points, faces.collect())
}

/// Subdivides each face into four and projects new vertices onto the unit sphere.
fn quartered(points: &mut Vec<DVec3>, triangles: &[[u16; 3]]) -> Vec<[u16; 3]> {
    let mut middles = BTreeMap::new();
    let mut middle = |points: &mut Vec<DVec3>, a: u16, b: u16| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            points.push((points[usize::from(a)] + points[usize::from(b)]).normalize());
            (points.len() - 1) as u16
        })
    };
    let mut quarters = Vec::with_capacity(4 * triangles.len());
    for &[a, b, c] in triangles {
        let (ab, bc, ca) = (middle(points, a, b), middle(points, b, c), middle(points, c, a));
        quarters.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    quarters
}
