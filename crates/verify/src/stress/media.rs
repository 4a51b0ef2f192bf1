//! Stress case D19: nested, overlapping and touching bodies, a camera inside bodies, and lights behind panes.

use super::{Case, Check, Effort, Outcome};
use crate::scenes::{glass, irradiance_meter, matte, of, pixels, quad, seen_in_parallel, square};
use crate::tally::Tally;
use dapple_integrator::geometry::Mesh;
use dapple_integrator::lights::Environment;
use dapple_integrator::scene::{SceneBuilder, TexturedMaterial};
use dapple_integrator::{MethodKind, Settings};
use glam::{DAffine3, DVec3, Vec3};
use std::f64::consts::PI;

pub(super) const CASES: &[Case] = &[Case {
    id: "D19",
    title: "media within media, and lights behind panes",
    naive: "leaving an inner body leaves all bodies; the dominant one of two overlapping bodies depends on the order of hits; a pane of index 1 casts a shadow",
    source: "Schmidt & Budge 2002; docs/science.md, \"Nested bodies\"",
    check: Check::Run(nested),
}];

/// A closed block across the z axis.
fn block(r: f32, a: f32, b: f32) -> Mesh {
    let at = |i: u32| {
        Vec3::new(
            if i & 1 == 1 { r } else { -r },
            if i & 2 == 2 { r } else { -r },
            if i & 4 == 4 { b } else { a },
        )
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(at).collect(),
        triangles: quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect(),
        ..Mesh::default()
    }
}

/// Half size, start, end, absorption per unit length and priority of a block.
type Block = (f32, f32, f32, f32, f64);

/// A wall of radiance 1 seen along the z axis from `z` through blocks. `turned` rotates the blocks by a half turn, so
/// that they are passed from the other side.
fn through(z: f64, turned: bool, blocks: &[Block]) -> SceneBuilder {
    let mut builder = seen_in_parallel(DVec3::new(0.11, 0.07, z), 0.01);
    builder.environment(Environment::constant(Vec3::ZERO));
    let turn = if turned { DAffine3::from_rotation_y(PI) } else { DAffine3::IDENTITY };
    let wall = builder.material(matte(0.0, 1.0));
    builder.mesh(
        "wall",
        quad(Vec3::new(-50.0, -50.0, -20.0), Vec3::X * 100.0, Vec3::Y * 100.0),
        DAffine3::IDENTITY,
        wall,
    );
    for &(r, a, b, sigma, priority) in blocks {
        let filled = TexturedMaterial { sigma_a: Vec3::splat(sigma), priority, ..of(glass(1.0, 0.0)) };
        let filled = builder.material(filled);
        builder.mesh("block", block(r, a, b), turn, filled);
    }
    builder
}

fn nested(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let side = effort.of(2, 8, 32);
    let cases: [(&str, f64, &[Block], f64); 4] = [
        (
            "two clear bodies inside",
            10.0,
            &[(3.0, -1.5, 1.5, 1.0, 0.0), (2.0, -1.0, -0.5, 0.0, 0.0), (2.1, 0.5, 1.0, 0.0, 0.0)],
            2.0,
        ),
        (
            "bodies that touch",
            10.0,
            &[(3.0, -1.5, 0.0, 1.0, 0.0), (3.0, 0.0, 1.5, 2.0, 0.0), (2.0, 0.0, 1.0, 0.5, 0.0)],
            3.0,
        ),
        (
            "the higher priority of two that overlap",
            10.0,
            &[(3.0, -1.0, 0.5, 1.0, 1.0), (2.0, -0.5, 1.0, 3.0, 0.0)],
            3.0,
        ),
        ("a camera inside both", 0.0, &[(3.0, -1.5, 1.5, 1.0, 0.0), (2.0, -1.0, 1.0, 2.0, 0.0)], 2.5),
    ];
    for method in [MethodKind::Path, MethodKind::Distribution] {
        let settings = Settings { max_bounces: 64, ..square(side, 4) }
            .with_method(method)
            .with_path(|p| p.roulette = false);
        for (what, z, blocks, depth) in cases {
            for turned in [false, true] {
                let m = pixels(through(z, turned, blocks), &settings).unwrap_or_default();
                tally.within(format!("{what}, {method:?}, turned {turned}"), m.mean, (-depth).exp(), 1e-5);
            }
        }
        for thin in [true, false] {
            let m = pixels(lit(thin), &settings).unwrap_or_default();
            tally.within(format!("sun through panes, thin {thin}, {method:?}"), m.mean * PI, 1.0, 1e-5);
        }
    }
    tally.finish()
}

/// A floor lit by a distant light through panes of index 1.
fn lit(thin: bool) -> SceneBuilder {
    let mut builder = irradiance_meter();
    builder.environment(Environment::constant(Vec3::ZERO));
    let mut clear = glass(1.0, 0.0);
    clear.thin = thin;
    let clear = builder.material(of(clear));
    let turn = DAffine3::from_rotation_x(PI / 2.0);
    for y in [1.0, 1.2, 1.4] {
        builder.mesh("pane", block(30.0, -y - 0.1, -y), turn, clear);
    }
    builder.distant_light(DVec3::Y, Vec3::ONE);
    builder
}
