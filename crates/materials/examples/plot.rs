//! Plots a BSDF in the plane of incidence: `cargo run --release --example plot -p dapple-materials -- [NAME]
//! [ROUGHNESS]
//! [DEGREES] [FILE.svg]`, NAME one of metal, plastic, glass, pane, matte. Without FILE it prints text to stdout.
//!
//! The curve is f·|cosθ_i| (the radiance under a light of unit irradiance) on a logarithmic radius; dots are samples.

use dapple_materials::{Bsdf, Lobes, Material};
use glam::{Vec2, Vec3};
use std::fmt::Write;

/// Decades of f·cos from the centre to the outer circle.
const DECADES: f32 = 4.0;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let text = |i: usize, default: &str| args.get(i).map_or(default.to_owned(), Clone::clone);
    let number = |i: usize, default: f32| args.get(i).and_then(|s| s.parse().ok()).unwrap_or(default);
    let (name, roughness, degrees) = (text(0, "glass"), number(1, 0.4), number(2, 40.0));
    let Some(material) = material(&name, roughness) else {
        eprintln!("unknown material '{name}' (expected metal, plastic, glass, pane or matte)");
        std::process::exit(2);
    };
    let bsdf = Bsdf::new(&material, in_plane(-degrees.to_radians()));
    match args.get(3) {
        None => print!("{}", ascii(&bsdf)),
        Some(file) => match std::fs::write(file, svg(&bsdf)) {
            Ok(()) => println!("{file}"),
            Err(error) => {
                eprintln!("{file}: {error}");
                std::process::exit(2);
            }
        },
    }
    println!("{name}, roughness {roughness}, seen from {degrees}°: albedo {:.3}", bsdf.albedo());
}

fn material(name: &str, roughness: f32) -> Option<Material> {
    let base = Material { roughness, metallic: 0.0, ..Material::default() };
    Some(match name {
        "metal" => Material { metallic: 1.0, ..base },
        "plastic" => base,
        "glass" => Material { transmission: 1.0, thin: false, ..base },
        "pane" => Material { transmission: 1.0, thin: true, ..base },
        "matte" => Material { specular: 0.0, ..base },
        _ => return None,
    })
}

/// Direction in the xz plane at `angle` from the normal.
fn in_plane(angle: f32) -> Vec3 {
    Vec3::new(libm::sinf(angle), 0.0, libm::cosf(angle))
}

/// Point of the curve at `angle`, inside the unit circle.
fn curve(bsdf: &Bsdf, angle: f32) -> Vec2 {
    let wi = in_plane(angle);
    let value = bsdf.f(wi, Lobes::ALL).max_element() * wi.z.abs();
    let radius = 1.0 + libm::log10f(value.max(1e-9) / 10.0) / DECADES;
    Vec2::new(wi.x, wi.z) * radius.clamp(0.0, 1.0)
}

fn ascii(bsdf: &Bsdf) -> String {
    const W: usize = 79;
    const H: usize = 39;
    let mut page = vec![vec![' '; W]; H];
    let mut put = |p: Vec2, c: char| {
        let x = (p.x * 0.5 + 0.5) * (W - 1) as f32;
        let y = (0.5 - p.y * 0.5) * (H - 1) as f32;
        page[(y.round() as usize).min(H - 1)][(x.round() as usize).min(W - 1)] = c;
    };
    for i in 0..W {
        put(Vec2::new(i as f32 / (W - 1) as f32 * 2.0 - 1.0, 0.0), '-');
    }
    for i in 0..1440 {
        put(curve(bsdf, (i as f32 * 0.25).to_radians()), '#');
    }
    for s in samples(bsdf, 64) {
        put(Vec2::new(s.x, s.z), '.');
    }
    let mut out = String::new();
    for row in page {
        let line: String = row.into_iter().collect();
        out.push_str(line.trim_end());
        out.push('\n');
    }
    out
}

fn svg(bsdf: &Bsdf) -> String {
    let point = |p: Vec2| format!("{:.2},{:.2}", 200.0 + 180.0 * p.x, 200.0 - 180.0 * p.y);
    let curve: Vec<String> = (0..2880).map(|i| point(curve(bsdf, (i as f32 * 0.125).to_radians()))).collect();
    let mut out = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 400 400\"><rect width=\"400\" height=\"400\" fill=\"white\"/>\n\
         <path d=\"M20,200H380\" stroke=\"gray\"/><circle cx=\"200\" cy=\"200\" r=\"180\" fill=\"none\" stroke=\"lightgray\"/>\n",
    );
    let _ = writeln!(
        out,
        "<polygon points=\"{}\" fill=\"gold\" stroke=\"black\" stroke-width=\"0.5\"/>",
        curve.join(" ")
    );
    for s in samples(bsdf, 256) {
        let p = point(Vec2::new(s.x, s.z));
        let (x, y) = p.split_once(',').unwrap_or_default();
        let _ = writeln!(out, "<circle cx=\"{x}\" cy=\"{y}\" r=\"1\" fill=\"crimson\"/>");
    }
    out + "</svg>\n"
}

/// `n` sampled directions, rotated into the xz plane about the normal.
fn samples(bsdf: &Bsdf, n: u32) -> Vec<Vec3> {
    let golden = |k: u32, step: f32| (k as f32 * step).fract();
    (0..n)
        .filter_map(|k| {
            bsdf.sample_f(golden(k, 0.437), Vec2::new(golden(k, 0.7549), golden(k, 0.5698)), Lobes::ALL)
        })
        .map(|s| {
            let across = (1.0 - s.wi.z * s.wi.z).max(0.0).sqrt();
            Vec3::new(if s.wi.x < 0.0 { -across } else { across }, 0.0, s.wi.z)
        })
        .collect()
}
