//! A white furnace for a few materials: the mean weight is an albedo.

use dapple_materials::{Bsdf, Lobes, Material};
use glam::{Vec2, Vec3};

/// Lobe by lobe on a grid of midpoints, so that choosing adds no noise.
fn albedo(material: &Material, wo: Vec3) -> f64 {
    let bsdf = Bsdf::new(material, wo);
    let n = 256;
    let mut sum = 0.0f64;
    for lobe in (0..8).map(|bit| Lobes(1 << bit)) {
        for k in 0..n * n {
            let u = Vec2::new(((k % n) as f32 + 0.5) / n as f32, ((k / n) as f32 + 0.5) / n as f32);
            if let Some(s) = bsdf.sample_f(0.5, u, lobe) {
                sum += f64::from(s.weight.x * s.eta);
            }
        }
    }
    sum / f64::from(n * n)
}

#[test]
fn white_things_stay_white() {
    let base = Material { metallic: 0.0, ..Material::default() };
    for mu in [1.0f32, 0.4, 0.05, -0.4] {
        let wo = Vec3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
        assert!((albedo(&Material { specular: 0.0, ..base }, wo) - 1.0).abs() < 1e-5);
        for roughness in [0.0, 0.2, 0.5, 1.0] {
            let plastic = albedo(&Material { roughness, ..base }, wo);
            let glass = albedo(&Material { roughness, transmission: 1.0, thin: false, ..base }, wo);
            let pane = albedo(&Material { roughness, transmission: 1.0, thin: true, ..base }, wo);
            println!("mu {mu} roughness {roughness}: plastic {plastic:.5} glass {glass:.5} pane {pane:.5}");
            assert!((0.99..1.005).contains(&plastic));
            assert!(glass < 1.005 && pane < 1.005);
            assert!(roughness > 0.0 || (glass - 1.0).abs() < 1e-5 && (pane - 1.0).abs() < 1e-5);
        }
    }
}
