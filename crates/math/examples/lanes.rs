//! Evaluates the GGX distribution for many half vectors, with one lane and with the most lanes that this machine has.
//! `cargo run --release --example lanes -p dapple-math`

use dapple_math::lanes::{Isa, Kernel, Real, dispatch};
use std::f32::consts::PI;
use std::time::Instant;

/// D = α² / (π·((α² − 1)·cos²θ + 1)²) for the cosines of half vectors [Walter 2007, eq. 33].
struct Ggx<'a> {
    alpha: f32,
    cosines: &'a [f32],
    out: &'a mut [f32],
}

impl Kernel for Ggx<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let a2 = R::splat(self.alpha * self.alpha);
        for (cos, out) in self.cosines.chunks(R::LANES).zip(self.out.chunks_mut(R::LANES)) {
            let cos = R::load(cos);
            let t = (a2 - R::splat(1.0)) * (cos * cos) + R::splat(1.0);
            (a2 / (t * t * R::splat(PI))).store(out);
        }
    }
}

fn main() {
    let cosines: Vec<f32> = (0..4096).map(|i| i as f32 / 4096.0).collect();
    let mut sums = Vec::new();
    for isa in [Isa::Portable, Isa::fastest()] {
        let mut out = vec![0.0; cosines.len()];
        let start = Instant::now();
        for _ in 0..1000 {
            dispatch(isa, Ggx { alpha: 0.3, cosines: &cosines, out: &mut out });
        }
        let ns = start.elapsed().as_secs_f64() * 1e9 / (1000.0 * 4096.0);
        println!("{:9} {:2} lanes  {ns:.2} ns per value", isa.name(), isa.lanes());
        sums.push(out.iter().map(|&d| f64::from(d)).sum::<f64>());
    }
    assert_eq!(sums[0].to_bits(), sums[1].to_bits(), "all lanes give the same bits");
}
