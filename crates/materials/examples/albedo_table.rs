//! Writes `src/albedo_table.rs`: `cargo run --release --example albedo_table -p dapple-materials > crates/materials/src/albedo_table.rs`
//!
//! Directional albedo of the GGX reflection lobe with Schlick's Fresnel term splits into two numbers per (μ, α):
//! E = F0·C + (F90 − F0)·B, where with m from the visible normals of wo
//!   C = ∫ G2/G1 D_v(m) dm,  B = ∫ (1 − wo·m)⁵ G2/G1 D_v(m) dm.
//! Both are integrated in f64 by the midpoint rule over the sphere cap of [Dupuy & Benyoub 2023]. The nodes are then
//! raised until the bilinear interpolant lies above the integral on a finer lattice, so that a diffuse base that
//! takes what the coat leaves, 1 − E, can never make more light than comes in.

use libm::{cos, sqrt};

/// Nodes per axis: μ = (i/31)², roughness = j/31 (α = roughness²).
const N: usize = 32;
/// Lattice points per cell and axis at which the bound is enforced.
const FINE: usize = 4;
/// Midpoints per axis of the integral.
const Q: usize = 192;

fn node(k: f64) -> f64 {
    k / (N - 1) as f64
}

/// (C, B) at one point.
fn integrate(mu: f64, alpha: f64) -> [f64; 2] {
    if alpha == 0.0 {
        return [1.0, (1.0 - mu).powi(5)];
    }
    let wo = [sqrt(1.0 - mu * mu), 0.0, mu];
    let length = sqrt(alpha * alpha * wo[0] * wo[0] + mu * mu);
    let w = [alpha * wo[0] / length, 0.0, mu / length];
    let mut sum = [0.0; 2];
    for j in 0..Q {
        let z = (1.0 - (j as f64 + 0.5) / Q as f64) * (1.0 + w[2]) - w[2];
        let s = sqrt((1.0 - z * z).max(0.0));
        for i in 0..Q {
            // Symmetric in φ: half the circle is enough.
            let phi = std::f64::consts::PI * (i as f64 + 0.5) / Q as f64;
            let h = [s * cos(phi) + w[0], s * sqrt(1.0 - cos(phi) * cos(phi)), z + w[2]];
            let m = [alpha * h[0], alpha * h[1], h[2].max(0.0)];
            let r = sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
            let c = (wo[0] * m[0] + wo[2] * m[2]) / r;
            let wi = [2.0 * c * m[0] / r - wo[0], 2.0 * c * m[1] / r, 2.0 * c * m[2] / r - mu];
            if wi[2] <= 0.0 {
                continue;
            }
            let ti = sqrt(alpha * alpha * (wi[0] * wi[0] + wi[1] * wi[1]) + wi[2] * wi[2]);
            let ratio = wi[2] * (mu + length) / (length * wi[2] + ti * mu);
            sum[0] += ratio;
            sum[1] += ratio * (1.0 - c).max(0.0).powi(5);
        }
    }
    sum.map(|x| x / (Q * Q) as f64)
}

fn main() {
    let fine = (N - 1) * FINE + 1;
    let at = |k: usize| node(k as f64 / FINE as f64);
    let truth: Vec<Vec<[f64; 2]>> =
        (0..fine).map(|j| (0..fine).map(|i| integrate(at(i) * at(i), at(j) * at(j))).collect()).collect();
    let mut table: Vec<Vec<[f64; 2]>> =
        (0..N).map(|j| (0..N).map(|i| truth[j * FINE][i * FINE]).collect()).collect();
    let mut raised = [0.0f64; 2];
    for channel in 0..2 {
        // Cell row 0 holds only α < 1e-3, where the lobe is a mirror and row 0 is used alone.
        for j in 1..N - 1 {
            for i in 0..N - 1 {
                let lift = shortfall(&truth, &table, i, j, channel);
                raised[channel] = raised[channel].max(lift);
                for (y, x) in [(j, i), (j, i + 1), (j + 1, i), (j + 1, i + 1)] {
                    table[y][x][channel] = (table[y][x][channel] + lift).min(1.0);
                }
            }
        }
    }
    // What the lattice and the midpoint rule may have missed.
    for row in &mut table {
        for v in row {
            *v = v.map(|x| (x + 1e-4).min(1.0));
        }
    }
    eprintln!("largest lift: C {:.5}, B {:.5}", raised[0], raised[1]);
    print(&table);
}

/// How far the interpolant lies below the integral in one cell.
fn shortfall(truth: &[Vec<[f64; 2]>], table: &[Vec<[f64; 2]>], i: usize, j: usize, channel: usize) -> f64 {
    let mu = |k: f64| node(k) * node(k);
    let mut lift = 0.0f64;
    for y in 0..=FINE {
        for x in 0..=FINE {
            let fx =
                (mu(i as f64 + x as f64 / FINE as f64) - mu(i as f64)) / (mu(i as f64 + 1.0) - mu(i as f64));
            let fy = y as f64 / FINE as f64;
            let t = |b: usize, a: usize| table[j + b][i + a][channel];
            let value = (1.0 - fy) * ((1.0 - fx) * t(0, 0) + fx * t(0, 1))
                + fy * ((1.0 - fx) * t(1, 0) + fx * t(1, 1));
            lift = lift.max(truth[j * FINE + y][i * FINE + x][channel] - value);
        }
    }
    lift
}

fn print(table: &[Vec<[f64; 2]>]) {
    println!("//! Written by `examples/albedo_table.rs`; see there for what the numbers are. Do not edit.");
    println!();
    println!("/// Nodes per axis: μ = (i/31)² along a row, roughness = j/31 down the rows.");
    println!("pub(crate) const N: usize = {N};");
    println!();
    println!("/// (C, B): E = F0·C + (F90 − F0)·B.");
    println!("#[rustfmt::skip]");
    println!("pub(crate) static TABLE: [[[f32; 2]; N]; N] = [");
    for row in table {
        println!("    [");
        for chunk in row.chunks(6) {
            let line: Vec<String> =
                chunk.iter().map(|v| format!("[{:.6}, {:.6}],", up(v[0]), up(v[1]))).collect();
            println!("        {}", line.join(" "));
        }
        println!("    ],");
    }
    println!("];");
    println!();
    println!(
        "/// 2∫(C, B) μ dμ of the interpolant, per row: exact, so that the coat's complement is normalised exactly."
    );
    println!("#[rustfmt::skip]");
    println!("pub(crate) static MEAN: [[f32; 2]; N] = [");
    for row in table {
        let mean = [0, 1].map(|channel| {
            (0..N - 1)
                .map(|i| {
                    let (a, b) =
                        (node(i as f64) * node(i as f64), node(i as f64 + 1.0) * node(i as f64 + 1.0));
                    let (fa, fb) = (up(row[i][channel]), up(row[i + 1][channel]));
                    (b - a) * (fa * (2.0 * a + b) + fb * (a + 2.0 * b)) / 3.0
                })
                .sum::<f64>()
        });
        println!("    [{:?}, {:?}],", mean[0] as f32, mean[1] as f32);
    }
    println!("];");
}

/// Rounded up to six decimals, as printed.
fn up(x: f64) -> f64 {
    ((x * 1e6).ceil() / 1e6).min(1.0)
}
