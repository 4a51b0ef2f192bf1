//! Generates `src/albedo_table.rs`:
//! `cargo run --release --example albedo_table -p dapple-materials > crates/materials/src/albedo_table.rs`
//!
//! The directional albedo of the GGX reflection lobe with Schlick's Fresnel term splits into two numbers per (μ, α):
//! E = F0·C + (F90 − F0)·B, where with m distributed as the visible normals of wo
//!   C = ∫ G2/G1 D_v(m) dm,  B = ∫ (1 − wo·m)⁵ G2/G1 D_v(m) dm.
//! Both are integrated in f64 over the spherical cap of [Dupuy & Benyoub 2023]. The nodes are then raised until the
//! bilinear interpolant is not below the integral on a finer lattice, so that a diffuse base that reflects the
//! remainder of the coat, 1 − E, can never add energy. The computation takes some minutes.

use dapple_testkit::quadrature::rectangle;
use libm::{cos, sin, sqrt};
use std::f64::consts::PI;

/// Number of nodes in μ = x⁴, x = i/63: where the lobe is narrow, its albedo changes within μ ≈ α.
const NX: usize = 64;
/// Number of nodes in roughness √α = r0 + (1 − r0) y², y = j/31.
const NY: usize = 32;
/// √1e-3: smoother surfaces are mirrors with C = 1 and B = (1 − μ)⁵.
const R0: f64 = 0.031_622_776_601_683_79;
/// Lattice points per cell and axis at which the bound is enforced.
const FINE: usize = 4;
/// Margin for the errors of the lattice and the quadrature.
const MARGIN: f64 = 2e-4;

fn mu(x: f64) -> f64 {
    (x / (NX - 1) as f64).powi(4)
}

fn alpha(y: f64) -> f64 {
    let y = y / (NY - 1) as f64;
    let r = R0 + (1.0 - R0) * y * y;
    r * r
}

/// (C, B) at one point, as an integral over the unit square from which the cap is sampled.
fn integrate(mu: f64, alpha: f64) -> [f64; 2] {
    let wo = [sqrt(1.0 - mu * mu), 0.0, mu];
    let length = sqrt(alpha * alpha * wo[0] * wo[0] + mu * mu);
    let w = [alpha * wo[0] / length, 0.0, mu / length];
    [0, 5].map(|power| {
        let ratio = |u: f64, v: f64| {
            // Symmetric in φ: half of the circle suffices.
            let phi = PI * u;
            let z = (1.0 - v) * (1.0 + w[2]) - w[2];
            let s = sqrt(((1.0 - z) * (1.0 + z)).max(0.0));
            let m = [alpha * (s * cos(phi) + w[0]), alpha * s * sin(phi), (z + w[2]).max(0.0)];
            let r = sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
            let c = (wo[0] * m[0] + wo[2] * m[2]) / r;
            let wi = [2.0 * c * m[0] / r - wo[0], 2.0 * c * m[1] / r, (2.0 * c * m[2] / r - mu).max(0.0)];
            let ti = sqrt(alpha * alpha * (wi[0] * wi[0] + wi[1] * wi[1]) + wi[2] * wi[2]);
            if wi[2] == 0.0 {
                return 0.0;
            }
            wi[2] * (mu + length) / (length * wi[2] + ti * mu) * (1.0 - c).max(0.0).powi(power)
        };
        rectangle(ratio, [0.0, 0.0], [1.0, 1.0], 1e-5)
    })
}

fn main() {
    let sub = |k: usize| k as f64 / FINE as f64;
    let row = |j: usize| (0..=(NX - 1) * FINE).map(|i| integrate(mu(sub(i)), alpha(sub(j)))).collect();
    let truth: Vec<Vec<[f64; 2]>> = (0..=(NY - 1) * FINE).map(row).collect();
    let mut table: Vec<Vec<[f64; 2]>> =
        (0..NY).map(|j| (0..NX).map(|i| truth[j * FINE][i * FINE]).collect()).collect();
    for channel in 0..2 {
        for (j, i) in (0..NY - 1).flat_map(|j| (0..NX - 1).map(move |i| (j, i))) {
            let lift = shortfall(&truth, &table, i, j, channel);
            for (y, x) in [(j, i), (j, i + 1), (j + 1, i), (j + 1, i + 1)] {
                table[y][x][channel] += lift;
            }
        }
    }
    for v in table.iter_mut().flatten() {
        *v = v.map(|x| ((x + MARGIN).min(1.0) * 1e6).ceil() / 1e6);
    }
    let above = [0, 1].map(|channel| {
        (0..NY - 1)
            .flat_map(|j| (0..NX - 1).map(move |i| (j, i)))
            .map(|(j, i)| -least(&truth, &table, i, j, channel, -1.0))
            .fold(0.0, f64::max)
    });
    eprintln!("the interpolant lies above the integral by at most: C {:.5}, B {:.5}", above[0], above[1]);
    print(&table);
}

/// Amount by which the interpolant is below the integral in one cell; 0 if it is nowhere below.
fn shortfall(truth: &[Vec<[f64; 2]>], table: &[Vec<[f64; 2]>], i: usize, j: usize, channel: usize) -> f64 {
    least(truth, table, i, j, channel, 1.0).max(0.0)
}

/// Largest of sign·(integral − interpolant) in one cell, times sign.
fn least(
    truth: &[Vec<[f64; 2]>],
    table: &[Vec<[f64; 2]>],
    i: usize,
    j: usize,
    channel: usize,
    sign: f64,
) -> f64 {
    let r = |y: f64| sqrt(alpha(y));
    let mut most = f64::NEG_INFINITY;
    for (y, x) in (0..=FINE).flat_map(|y| (0..=FINE).map(move |x| (y, x))) {
        let (at_x, at_y) = (i as f64 + x as f64 / FINE as f64, j as f64 + y as f64 / FINE as f64);
        let fx = (mu(at_x) - mu(i as f64)) / (mu(i as f64 + 1.0) - mu(i as f64));
        let fy = (r(at_y) - r(j as f64)) / (r(j as f64 + 1.0) - r(j as f64));
        let t = |b: usize, a: usize| table[j + b][i + a][channel];
        let value =
            (1.0 - fy) * ((1.0 - fx) * t(0, 0) + fx * t(0, 1)) + fy * ((1.0 - fx) * t(1, 0) + fx * t(1, 1));
        most = most.max(sign * (truth[j * FINE + y][i * FINE + x][channel] - value));
    }
    sign * most
}

fn print(table: &[Vec<[f64; 2]>]) {
    println!("//! Generated by `examples/albedo_table.rs`, which documents the values. Do not edit.");
    println!();
    println!("/// Nodes along a row: μ = (i/63)⁴.");
    println!("pub(crate) const NX: usize = {NX};");
    println!("/// Rows: √α = r0 + (1 − r0)(j/31)², r0 = √1e-3.");
    println!("pub(crate) const NY: usize = {NY};");
    println!();
    println!("/// (C, B): E = F0·C + (F90 − F0)·B.");
    println!("#[rustfmt::skip]");
    println!("pub(crate) static TABLE: [[[f32; 2]; NX]; NY] = [");
    for row in table {
        println!("    [");
        for chunk in row.chunks(8) {
            let line: Vec<String> =
                chunk.iter().map(|v| format!("[{:?}, {:?}],", v[0] as f32, v[1] as f32)).collect();
            println!("        {}", line.join(" "));
        }
        println!("    ],");
    }
    println!("];");
    println!();
    println!(
        "/// 2∫(C, B) μ dμ of the interpolant, row by row: exact, so that the coat's complement is normalised exactly."
    );
    println!("#[rustfmt::skip]");
    println!("pub(crate) static MEAN: [[f32; 2]; NY] = [");
    for row in table {
        let mean = [0, 1].map(|channel| mean(row, channel) as f32);
        println!("    [{:?}, {:?}],", mean[0], mean[1]);
    }
    println!("];");
}

/// 2∫ f μ dμ of the piecewise linear f.
fn mean(row: &[[f64; 2]], channel: usize) -> f64 {
    let piece = |i: usize| {
        let (a, b) = (mu(i as f64), mu(i as f64 + 1.0));
        (b - a) * (row[i][channel] * (2.0 * a + b) + row[i + 1][channel] * (a + 2.0 * b)) / 3.0
    };
    (0..NX - 1).map(piece).sum()
}
