//! Selects one of 1000 lights, samples it and computes the density again, with one lane and with those of this machine.
//! `cargo run --release --example light_lanes -p dapple-lights`

use dapple_lights::lanes::{Chosen, Hit, Receiver, Table};
use dapple_lights::{Area, AreaShape, Light, LightSampler, Point};
use dapple_math::lanes::{Isa, Kernel, Mask, Real, Vec2x, Vec3x, Word, dispatch};
use glam::Vec3;
use std::time::Instant;

const N: usize = 4096;

/// Sum of the weights of a light sample per receiver, over all receivers.
struct Direct<'a> {
    sampler: &'a LightSampler,
    table: &'a Table,
    lights: &'a [Light],
}

impl Kernel for Direct<'_> {
    type Output = (f64, f64);
    #[inline(always)]
    fn run<R: Real>(self) -> (f64, f64) {
        let Self { sampler, table, lights } = self;
        let (all, normal, mut sums) = (R::Mask::splat(true), Vec3x::splat(Vec3::Y), (0.0, 0.0));
        for i in (0..N).step_by(R::LANES) {
            // Numbers in [0, 1) by which receivers and samples are spread.
            let mut word = R::Word::lane_index().wrapping_add(R::Word::splat(i as u32));
            let mut u = [R::splat(0.0); 5];
            for u in &mut u {
                word = word
                    .wrapping_mul(R::Word::splat(747_796_405))
                    .wrapping_add(R::Word::splat(2_891_336_453));
                *u = word.unit();
            }
            let [x, z, uc, s, t] = u;
            let wide = R::splat(20.0);
            let from = Receiver { p: Vec3x::new(x * wide, R::splat(0.0), z * wide), time: R::splat(0.0) };
            let chosen = Chosen::<R>::new(sampler, all, from.p, normal, uc);
            let sample = table.sample::<R>(lights, all, chosen.index, from, Vec2x::new(s, t));
            let hit = Hit { wi: sample.wi, distance: sample.distance, n: sample.n };
            let again = table.pdf::<R>(lights, all, chosen.index, from, hit);
            let cos = sample.wi.y.max(R::splat(0.0));
            let value = sample.radiance.x * cos / (sample.pdf * chosen.pmf);
            let value = R::select(sample.pdf.gt(R::splat(0.0)), value, R::splat(0.0));
            let (mut values, mut densities) = ([0.0; 16], [0.0; 16]);
            value.store(&mut values);
            again.store(&mut densities);
            sums.0 += values.iter().map(|v| f64::from(*v)).sum::<f64>();
            sums.1 += densities.iter().map(|v| f64::from(*v)).sum::<f64>();
        }
        sums
    }
}

fn main() {
    let lights: Vec<Light> = (0..1000)
        .map(|i| {
            let p = Vec3::new((i % 37) as f32 * 0.5, 3.0 + (i % 3) as f32 * 0.2, (i / 37) as f32 * 0.6);
            let quad = AreaShape::Quad { corner: p, e1: Vec3::X * 0.2, e2: Vec3::Z * 0.2 };
            match i % 2 {
                0 => Light::Point(Point { p, intensity: Vec3::splat(0.1), range: f32::INFINITY }),
                _ => Light::Area(Area { shape: quad, radiance: Vec3::splat(2.0), two_sided: false }),
            }
        })
        .collect();
    let table = Table::new(&lights);
    let Some(sampler) = LightSampler::new(&lights, 20.0) else { return };
    for isa in [Isa::Portable, Isa::fastest()] {
        let start = Instant::now();
        let mut sums = (0.0, 0.0);
        for _ in 0..100 {
            sums = dispatch(isa, Direct { sampler: &sampler, table: &table, lights: &lights });
        }
        let ns = start.elapsed().as_secs_f64() * 1e9 / (100 * N) as f64;
        println!("{:9} {ns:6.0} ns per sample, irradiance {:.4}", isa.name(), sums.0 / N as f64);
    }
}
