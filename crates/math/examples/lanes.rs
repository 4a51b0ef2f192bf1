//! Samples half vectors of the GGX distribution with one lane, and with the fastest lanes of this machine.
//! `cargo run --release --example lanes -p dapple-math`

use dapple_math::lanes::{Isa, Kernel, Real, Vec3x, dispatch, sin_cos};
use std::f32::consts::TAU;
use std::time::Instant;

const N: usize = 4096;

/// Half vectors with density D(h)·cos θ, from uniform numbers in [0, 1) [Walter 2007, eqs. 35 and 36].
struct HalfVectors<'a> {
    alpha: f32,
    u: &'a [[f32; N]; 2],
    h: &'a mut [[f32; N]; 3],
}

impl Kernel for HalfVectors<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let (one, a2) = (R::splat(1.0), R::splat(self.alpha * self.alpha));
        let [x, y, z] = self.h;
        for i in (0..N).step_by(R::LANES) {
            let (u, v) = (R::load(&self.u[0][i..]), R::load(&self.u[1][i..]));
            let cos2 = (one - u) / (one + (a2 - one) * u);
            let (sin_phi, cos_phi) = sin_cos(v * R::splat(TAU));
            let sin = (one - cos2).max(R::splat(0.0)).sqrt();
            let h = Vec3x::new(sin * cos_phi, sin * sin_phi, cos2.sqrt());
            h.store([&mut x[i..], &mut y[i..], &mut z[i..]]);
        }
    }
}

fn main() {
    let u = [3571, 2927].map(|k| std::array::from_fn(|i| (i * k % 8191) as f32 / 8192.0));
    let results = [Isa::Portable, Isa::fastest()].map(|isa| {
        let mut h = [[0.0; N]; 3];
        dispatch(isa, HalfVectors { alpha: 0.3, u: &u, h: &mut h });
        let start = Instant::now();
        for _ in 0..1000 {
            dispatch(isa, HalfVectors { alpha: 0.3, u: &u, h: &mut h });
        }
        let ns = start.elapsed().as_secs_f64() * 1e9 / (1000 * N) as f64;
        println!("{:9} {:2} lanes  {ns:.2} ns per half vector", isa.name(), isa.lanes());
        h
    });
    assert_eq!(results[0], results[1], "all lanes give the same bits");
}
