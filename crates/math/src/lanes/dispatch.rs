//! Runs a kernel, written once over [`Real`], with the lanes of an instruction set.
#![allow(unsafe_code)]

#[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
use super::avx2::Avx2;
#[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
use super::avx512::Avx512;
use super::isa::Isa;
use super::real::Real;

/// A computation over lanes of any number, with its arguments as fields.
///
/// `run` and every function over `Real` that it calls have to be `#[inline(always)]`, and must not pass lanes through
/// closures: a function or closure that is not inlined is compiled without the instruction set, and each of its
/// operations becomes a call. `tools/kernel_calls.py` finds such calls.
pub trait Kernel {
    /// What the computation returns.
    type Output;

    /// Computes with lanes of type `R`.
    fn run<R: Real>(self) -> Self::Output;
}

/// Runs `kernel` with the lanes of `isa`, or with one lane if this machine does not support it. The choice takes a few
/// nanoseconds and the kernel is not inlined, so that a kernel should loop over many numbers.
///
/// ```
/// use dapple_math::lanes::{Isa, Kernel, Real, dispatch};
///
/// /// Replaces numbers by their square roots.
/// struct Roots<'a>(&'a mut [f32]);
///
/// impl Kernel for Roots<'_> {
///     type Output = ();
///     #[inline(always)]
///     fn run<R: Real>(self) {
///         for lanes in self.0.chunks_mut(R::LANES) {
///             R::load(lanes).sqrt().store(lanes);
///         }
///     }
/// }
///
/// let mut x = [4.0, 9.0, 2.25];
/// dispatch(Isa::fastest(), Roots(&mut x));
/// assert_eq!(x, [2.0, 3.0, 1.5]);
/// ```
#[inline]
pub fn dispatch<K: Kernel>(isa: Isa, kernel: K) -> K::Output {
    match isa {
        #[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
        // SAFETY: the machine has the instruction sets (`Isa::runs`).
        Isa::Avx512 if isa.runs() => unsafe { run_avx512(kernel) },
        #[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
        // SAFETY: as above.
        Isa::Avx2 if isa.runs() => unsafe { run_avx2(kernel) },
        _ => run_portable(kernel),
    }
}

#[inline(never)]
fn run_portable<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<f32>()
}

// The features below are those that `Isa::runs` tests. They include those of every instruction that the lanes use.

#[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
#[inline(never)]
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Avx2>()
}

#[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
#[inline(never)]
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt,avx512f,avx512bw,avx512dq,avx512vl,avx512cd")]
fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Avx512>()
}
