//! The elementary functions over lanes: their errors against f64, their special values, and the same bits with every
//! instruction set.

use dapple_math::lanes::{self, Isa, Kernel, Real, dispatch};
use dapple_testkit::Rng;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

#[derive(Clone, Copy, PartialEq, Debug)]
enum Function {
    Sin,
    Cos,
    Asin,
    Acos,
    Exp,
    Exp2,
    Ln,
    Log2,
    Atan2,
    Powf,
}
use Function::*;

impl Function {
    fn exact(self, x: f64, y: f64) -> f64 {
        match self {
            Sin => libm::sin(x),
            Cos => libm::cos(x),
            Asin => libm::asin(x),
            Acos => libm::acos(x),
            Exp => libm::exp(x),
            Exp2 => libm::exp2(x),
            Ln => libm::log(x),
            Log2 => libm::log2(x),
            Atan2 => libm::atan2(x, y),
            Powf => libm::pow(x, y),
        }
    }
}

/// Writes f(x, y) to `out`.
struct Apply<'a> {
    f: Function,
    x: &'a [f32],
    y: &'a [f32],
    out: &'a mut [f32],
}

impl Kernel for Apply<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        for (i, out) in self.out.chunks_mut(R::LANES).enumerate() {
            let (x, y) = (R::load(&self.x[i * R::LANES..]), R::load(&self.y[i * R::LANES..]));
            let result = match self.f {
                Sin => lanes::sin(x),
                Cos => lanes::cos(x),
                Asin => lanes::asin(x),
                Acos => lanes::acos(x),
                Exp => lanes::exp(x),
                Exp2 => lanes::exp2(x),
                Ln => lanes::ln(x),
                Log2 => lanes::log2(x),
                Atan2 => lanes::atan2(x, y),
                Powf => lanes::powf(x, y),
            };
            result.store(out);
        }
    }
}

/// Results of `f` with one lane, after a comparison with those of all other instruction sets.
fn results(f: Function, x: &[f32], y: &[f32]) -> Vec<f32> {
    let run = |isa| {
        let mut out = vec![0.0; x.len()];
        dispatch(isa, Apply { f, x, y, out: &mut out });
        out
    };
    let portable = run(Isa::Portable);
    for isa in Isa::available() {
        for (i, (a, b)) in portable.iter().zip(run(isa)).enumerate() {
            let same = a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
            assert!(same, "{f:?}({:e}, {:e}): {a:e} portable, {b:e} {}", x[i], y[i], isa.name());
        }
    }
    portable
}

fn one(f: Function, x: f32, y: f32) -> f32 {
    results(f, &[x], &[y])[0]
}

/// Distance between neighbours in f32 at the magnitude of `x`.
fn ulp(x: f64) -> f64 {
    let (_, exponent) = libm::frexp(x);
    libm::ldexp(1.0, (exponent - 24).max(-149))
}

/// Largest errors over a set of arguments.
#[derive(Default)]
struct Errors {
    /// In units in the last place, and where.
    ulp: (f64, f32, f32),
    absolute: f64,
}

impl Errors {
    /// Compares results with f64. NaN and infinities have to be where they are in f64 rounded to f32.
    fn add(&mut self, f: Function, x: &[f32], y: &[f32]) {
        for (i, got) in results(f, x, y).into_iter().enumerate() {
            let exact = f.exact(f64::from(x[i]), f64::from(y[i]));
            let rounded = exact as f32;
            if !rounded.is_finite() || !got.is_finite() {
                let same = rounded == got || (rounded.is_nan() && got.is_nan());
                // Close to the end of the range either neighbour is right to within the stated error.
                let at_the_end = exact.abs() / f64::from(f32::MAX) - 1.0;
                let same = same || at_the_end.abs() < 4e-7;
                assert!(same, "{f:?}({:e}, {:e}) = {got:e}, exact {exact:e}", x[i], y[i]);
                continue;
            }
            let error = (f64::from(got) - exact).abs();
            self.absolute = self.absolute.max(error);
            // What the documentation allows powers beyond 1.25 ulp.
            let allowed = if f == Powf { (f64::from(y[i]).abs() / 12.0).min(22.75) } else { 0.0 };
            if error / ulp(exact) - allowed > self.ulp.0 {
                self.ulp = (error / ulp(exact) - allowed, x[i], y[i]);
            }
        }
    }

    /// Errors for every `step`-th bit pattern that `keep` accepts, and for random ones.
    fn of_sweep(f: Function, step: usize, keep: fn(f32) -> bool) -> Self {
        let mut this = Self::default();
        let mut rng = Rng::new(7);
        let all = (0..=u32::MAX).step_by(step).chain((0..200_000).map(|_| rng.bits() as u32));
        let mut x: Vec<f32> = Vec::with_capacity(1024);
        for bits in all {
            x.extend(Some(f32::from_bits(bits)).filter(|&x| keep(x)));
            if x.len() == 1024 {
                this.add(f, &x, &x);
                x.clear();
            }
        }
        this.add(f, &x, &x);
        this
    }

    fn of_pairs(f: Function, n: usize, mut pair: impl FnMut(&mut Rng) -> (f32, f32)) -> Self {
        let mut this = Self::default();
        let mut rng = Rng::new(11);
        for _ in 0..n / 1000 {
            let (x, y): (Vec<f32>, Vec<f32>) = (0..1000).map(|_| pair(&mut rng)).unzip();
            this.add(f, &x, &y);
        }
        this
    }

    fn at_most(&self, f: Function, bound: f64) {
        let (error, x, y) = self.ulp;
        println!("{f:?}: {error:.3} ulp at ({x:e}, {y:e}), {:.2e} absolute", self.absolute);
        assert!(error <= bound, "{f:?}: {error} ulp at ({x:e}, {y:e}), at most {bound}");
    }
}

#[test]
fn sine_and_cosine() {
    for f in [Sin, Cos] {
        Errors::of_sweep(f, 257, |x| x.abs() <= 6.2831855).at_most(f, 0.8);
        let far = Errors::of_sweep(f, 257, |x| x.abs() <= 8192.0 && x.abs() > 6.0);
        println!("{f:?}: {:.3e} absolute below 8192", far.absolute);
        assert!(far.absolute <= 5e-8);
        // Beyond 8192 each lane is a call of libm.
        Errors::of_sweep(f, 65_537, |x| x.abs() >= 8190.0).at_most(f, 1.0);
    }
    for multiple in 0..5000 {
        let x = (f64::from(multiple) * std::f64::consts::FRAC_PI_2) as f32;
        let near: Vec<f32> =
            (0..64).map(|i| f32::from_bits(x.to_bits().saturating_add(i).saturating_sub(32))).collect();
        for f in [Sin, Cos] {
            let mut errors = Errors::default();
            errors.add(f, &near, &near);
            assert!(errors.absolute <= 5e-8, "{f:?} near {x}: {}", errors.absolute);
        }
    }
}

#[test]
fn sine_and_cosine_together_are_those_alone() {
    struct Both<'a>(&'a [f32], [&'a mut [f32]; 2]);
    impl Kernel for Both<'_> {
        type Output = ();
        #[inline(always)]
        fn run<R: Real>(self) {
            for i in (0..self.0.len()).step_by(R::LANES) {
                let (sin, cos) = lanes::sin_cos(R::load(&self.0[i..]));
                sin.store(&mut self.1[0][i..]);
                cos.store(&mut self.1[1][i..]);
            }
        }
    }
    let mut rng = Rng::new(3);
    let x: Vec<f32> = (0..10_000).map(|i| (rng.f32() - 0.5) * libm::exp2f((i % 30) as f32)).collect();
    for isa in Isa::available() {
        let (mut sin, mut cos) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        dispatch(isa, Both(&x, [&mut sin, &mut cos]));
        assert_eq!(sin, results(Sin, &x, &x));
        assert_eq!(cos, results(Cos, &x, &x));
    }
}

#[test]
fn arcsine_and_arccosine() {
    Errors::of_sweep(Asin, 257, |x| x.abs() <= 1.5).at_most(Asin, 1.2);
    Errors::of_sweep(Acos, 257, |x| x.abs() <= 1.5).at_most(Acos, 1.2);
    Errors::of_sweep(Acos, 9973, |_| true).at_most(Acos, 1.2);
    Errors::of_sweep(Asin, 9973, |_| true).at_most(Asin, 1.2);
}

#[test]
fn exponentials() {
    Errors::of_sweep(Exp, 257, |x| x.abs() <= 200.0).at_most(Exp, 1.0);
    Errors::of_sweep(Exp, 9973, |_| true).at_most(Exp, 1.0);
    Errors::of_sweep(Exp2, 257, |x| x.abs() <= 200.0).at_most(Exp2, 1.2);
    Errors::of_sweep(Exp2, 9973, |_| true).at_most(Exp2, 1.2);
    for n in -149i16..128 {
        assert_eq!(f64::from(one(Exp2, f32::from(n), 0.0)), libm::exp2(f64::from(n)));
    }
}

#[test]
fn logarithms() {
    Errors::of_sweep(Ln, 257, |_| true).at_most(Ln, 1.0);
    Errors::of_sweep(Log2, 257, |_| true).at_most(Log2, 1.0);
    for n in -149i16..128 {
        assert_eq!(one(Log2, libm::exp2(f64::from(n)) as f32, 0.0), f32::from(n));
    }
}

#[test]
fn arctangent() {
    let plain = |rng: &mut Rng| (rng.f32() * 4.0 - 2.0, rng.f32() * 4.0 - 2.0);
    Errors::of_pairs(Atan2, 4_000_000, plain).at_most(Atan2, 1.8);
    let any = |rng: &mut Rng| (f32::from_bits(rng.bits() as u32), f32::from_bits(rng.bits() as u32));
    Errors::of_pairs(Atan2, 1_000_000, any).at_most(Atan2, 1.8);
    let similar = |rng: &mut Rng| {
        let x = f32::from_bits(rng.bits() as u32);
        (x * (rng.f32() * 4.0 - 2.0), x)
    };
    Errors::of_pairs(Atan2, 2_000_000, similar).at_most(Atan2, 1.8);
    let slope = |rng: &mut Rng| (f32::from_bits(rng.bits() as u32), 1.0);
    Errors::of_pairs(Atan2, 1_000_000, slope).at_most(Atan2, 1.8);
}

#[test]
fn powers() {
    let positive = |rng: &mut Rng| f32::from_bits((rng.bits() as u32) & 0x7fff_ffff);
    let roots = |rng: &mut Rng| (positive(rng), rng.f32() * 8.0 - 4.0);
    Errors::of_pairs(Powf, 3_000_000, roots).at_most(Powf, 1.25);
    let unit = |rng: &mut Rng| (rng.f32(), rng.f32() * 4.0);
    Errors::of_pairs(Powf, 1_000_000, unit).at_most(Powf, 1.25);
    for scale in [16.0f32, 64.0, 256.0, 1024.0, 65_536.0] {
        // Bases whose powers reach the ends of the range of f32.
        let near_one = |rng: &mut Rng| {
            let y = (rng.f32() * 2.0 - 1.0) * scale;
            (libm::exp2f((rng.f32() * 300.0 - 150.0) / y.abs()), y)
        };
        Errors::of_pairs(Powf, 1_000_000, near_one).at_most(Powf, 1.25);
    }
    let any = |rng: &mut Rng| (positive(rng), f32::from_bits(rng.bits() as u32));
    Errors::of_pairs(Powf, 1_000_000, any).at_most(Powf, 1.25);
}

const SPECIAL: [f32; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -0.5,
    2.0,
    -2.0,
    3.0,
    1e-45,
    -1e-45,
    1e-38,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    FRAC_PI_2,
    PI,
    -FRAC_PI_4,
    8192.0,
    8192.001,
];

/// Special arguments: within one unit of f64, with the signs of zeros.
#[test]
fn special_values() {
    for f in [Sin, Cos, Asin, Acos, Exp, Exp2, Ln, Log2, Atan2, Powf] {
        for x in SPECIAL {
            let others = if matches!(f, Atan2 | Powf) { &SPECIAL[..] } else { &[0.0] };
            for &y in others {
                if f == Powf && x.is_sign_negative() {
                    continue;
                }
                let (got, exact) = (one(f, x, y), f.exact(f64::from(x), f64::from(y)) as f32);
                let close = (f64::from(got) - f64::from(exact)).abs() <= 1.5 * ulp(f64::from(exact));
                let same = (got.is_nan() && exact.is_nan()) || got == exact || close;
                let signs = got.is_nan() || got.is_sign_negative() == exact.is_sign_negative();
                // The value 1 of sin and cos near multiples of π is rounding.
                let tiny = matches!(f, Sin | Cos) && (got - exact).abs() <= 5e-8 && got.abs() > 0.0;
                assert!((same && signs) || tiny, "{f:?}({x:e}, {y:e}) = {got:e}, exact {exact:e}");
            }
        }
    }
    assert!(one(Powf, -2.0, 2.0).is_nan());
    assert_eq!(one(Powf, -0.0, -1.0), f32::INFINITY);
    assert_eq!(one(Powf, -0.0, 3.0).to_bits(), 0);
    assert_eq!((one(Exp, 0.0, 0.0), one(Cos, -0.0, 0.0), one(Ln, 1.0, 0.0).to_bits()), (1.0, 1.0, 0));
}

/// The results themselves are the same on every machine, in a build without the lanes of x86-64 too.
#[test]
fn results_are_pinned() {
    let mut rng = Rng::new(17);
    let x: Vec<f32> = (0..10_000).map(|_| f32::from_bits(rng.bits() as u32)).collect();
    let near: Vec<f32> = (0..10_000).map(|_| rng.f32() * 40.0 - 20.0).collect();
    let unit: Vec<f32> = (0..10_000).map(|_| rng.f32() * 2.0 - 1.0).collect();
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for f in [Sin, Cos, Asin, Acos, Exp, Exp2, Ln, Log2, Atan2, Powf] {
        for (x, y) in [(&x, &near), (&near, &unit), (&unit, &x)] {
            for result in results(f, x, y) {
                let bits = if result.is_nan() { f32::NAN.to_bits() } else { result.to_bits() };
                hash = (hash ^ u64::from(bits)).wrapping_mul(0x0100_0000_01b3);
            }
        }
    }
    assert_eq!(hash, 0x1173_f012_ed6a_003e, "{hash:#x}");
}
