//! Compares the estimated irradiance below a square lamp with its closed form on the centre line.
//! `cargo run --release --example irradiance -p dapple-lights`

use dapple_lights::{Area, AreaShape, Light};
use glam::{Vec2, Vec3};

fn main() {
    let quad = AreaShape::Quad { corner: Vec3::new(-0.5, 1.0, -0.5), e1: Vec3::X, e2: Vec3::Z };
    let lamp = Light::Area(Area { shape: quad, radiance: Vec3::ONE, two_sided: false });
    // Lambert's formula: four times a corner rectangle of half the side, at distance h.
    let exact = |h: f64| {
        let slant = (h * h + 0.25).sqrt();
        4.0 * (0.5 / slant) * (0.5 / slant).atan()
    };
    for h in [0.25, 0.5, 1.0, 2.0, 4.0] {
        let p = Vec3::new(0.0, 1.0 - h, 0.0);
        let sum = (0..256).filter_map(|i| {
            let u = (Vec2::new((i % 16) as f32, (i / 16) as f32) + 0.5) / 16.0;
            let sample = lamp.sample(p, u, 0.0)?;
            Some(f64::from(sample.radiance.x * sample.wi.y / sample.pdf))
        });
        println!("h = {h:4}: {:.6}, exactly {:.6}", sum.sum::<f64>() / 256.0, exact(f64::from(h)));
    }
}
