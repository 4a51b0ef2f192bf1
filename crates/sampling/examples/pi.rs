//! Estimates π as the area of a quarter disk with grid, random, stratified and Sobol points.
//! `cargo run --release --example pi -p dapple-sampling`

use dapple_sampling::{Key, Pattern, point_2d};
use std::f64::consts::PI;

const PATTERNS: [Pattern; 4] = [Pattern::Grid, Pattern::Random, Pattern::Stratified, Pattern::Sobol];

/// Returns the root mean square error over 32 keys.
fn error(pattern: Pattern, n: u32) -> f64 {
    let square = |seed| {
        let key = Key::pixel(seed, 0, 0).at(0, 0u32);
        let inside = (0..n).filter(|&s| point_2d(pattern, s, n, key).length_squared() < 1.0).count();
        (4.0 * inside as f64 / f64::from(n) - PI).powi(2)
    };
    ((0..32).map(square).sum::<f64>() / 32.0).sqrt()
}

fn main() {
    println!("{:>8} {:>12} {:>12} {:>12} {:>12}", "points", "grid", "random", "stratified", "sobol");
    for n in (2..=9).map(|i| 1u32 << (2 * i)) {
        let row: Vec<String> = PATTERNS.iter().map(|&p| format!("{:>12.2e}", error(p, n))).collect();
        println!("{n:>8} {}", row.join(" "));
    }
    println!("\nThe error of random points decreases as N^-1/2, of stratified and Sobol points as N^-3/4.");
}
