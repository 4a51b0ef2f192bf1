//! Prints the time of the elementary functions per argument, for `libm` and for the lanes of each instruction set.
//! `cargo run --release --example lane_functions -p dapple-math`

use dapple_math::lanes::{self, Isa, Kernel, Real, dispatch};
use std::time::Instant;

const N: usize = 4096;

/// Declares a kernel that applies a function of one or two numbers to columns.
macro_rules! kernel {
    ($name:ident, |$x:ident, $y:ident| $value:expr) => {
        struct $name<'a>(&'a [[f32; N]; 2], &'a mut [f32; N]);

        impl Kernel for $name<'_> {
            type Output = ();
            #[inline(always)]
            fn run<R: Real>(self) {
                for i in (0..N).step_by(R::LANES) {
                    let ($x, $y) = (R::load(&self.0[0][i..]), R::load(&self.0[1][i..]));
                    ($value).store(&mut self.1[i..]);
                }
            }
        }
    };
}

kernel!(SinCos, |x, y| {
    let (sin, cos) = lanes::sin_cos(x + y);
    sin + cos
});
kernel!(Exp, |x, y| lanes::exp(x + y));
kernel!(Exp2, |x, y| lanes::exp2(x + y));
kernel!(Ln, |x, y| lanes::ln(x + y));
kernel!(Log2, |x, y| lanes::log2(x + y));
kernel!(Atan2, |x, y| lanes::atan2(x, y));
kernel!(Acos, |x, y| lanes::acos(x * y));
kernel!(Powf, |x, y| lanes::powf(x, y));

/// Nanoseconds per argument, the best of several runs.
fn time(mut run: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..20 {
        let start = Instant::now();
        for _ in 0..10 {
            run();
        }
        best = best.min(start.elapsed().as_secs_f64() * 1e9 / (10 * N) as f64);
    }
    best
}

fn main() {
    let column = |seed: usize| std::array::from_fn(|i| ((i * seed) % 8191) as f32 / 8192.0);
    let columns = [column(3571), column(2927)];
    let mut out = [0.0; N];
    print!("{:8}{:>9}", "ns", "libm");
    Isa::available().iter().rev().for_each(|isa| print!("{:>9}", isa.name()));
    println!();
    macro_rules! row {
        ($name:ident, $f:expr) => {
            let f: fn(f32, f32) -> f32 = $f;
            print!("{:8}", stringify!($name));
            let scalar = time(|| {
                for i in 0..N {
                    out[i] = f(columns[0][i], columns[1][i]);
                }
            });
            print!("{scalar:9.2}");
            for isa in Isa::available().into_iter().rev() {
                print!("{:9.2}", time(|| dispatch(isa, $name(&columns, &mut out))));
            }
            println!();
        };
    }
    row!(SinCos, |x, y| {
        let (sin, cos) = libm::sincosf(x + y);
        sin + cos
    });
    row!(Exp, |x, y| libm::expf(x + y));
    row!(Exp2, |x, y| libm::exp2f(x + y));
    row!(Ln, |x, y| libm::logf(x + y));
    row!(Log2, |x, y| libm::log2f(x + y));
    row!(Atan2, libm::atan2f);
    row!(Acos, |x, y| libm::acosf(x * y));
    row!(Powf, libm::powf);
}
