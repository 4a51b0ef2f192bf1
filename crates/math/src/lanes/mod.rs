//! Numbers of many lanes: formulas written once and computed for 1, 8 or 16 arguments at a time, with the same bits.
//!
//! - [`Real`], [`Word`], [`Mask`]: numbers, 32-bit integers and truth values, one per lane. `f32`, `u32` and `bool`
//!   implement them with one lane; AVX2 gives eight lanes and AVX-512 sixteen. [`Double`]: numbers in f64.
//! - [`Vec2x`], [`Vec3x`], [`Framex`]: vectors and orthonormal frames, with the arithmetic of glam and of
//!   [`Frame`](crate::Frame).
//! - [`sin_cos`], [`atan2`], [`acos`], [`exp`], [`ln`], [`powf`] and others: elementary functions without branches, with
//!   stated errors. Arguments outside of the domain of a formula are computed by `libm`, with any number of lanes.
//! - [`Isa`], [`Kernel`], [`dispatch()`]: the instruction sets, and how a computation over [`Real`] runs with one of them.

#[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
mod avx2;
#[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
mod avx2_double;
#[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
mod avx512;
#[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
mod avx512_double;
mod by_lane;
mod dispatch;
#[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
mod double;
mod exponential;
mod frame;
mod inverse;
mod isa;
mod logarithm;
mod mask;
#[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
mod packed;
mod polynomial;
mod power;
mod real;
mod scalar;
mod sealed;
mod trigonometric;
mod vec2;
mod vec3;

pub use dispatch::{Kernel, dispatch};
pub use exponential::{exp, exp2};
pub use frame::Framex;
pub(crate) use frame::LEAST_SINE_SQUARED;
pub use inverse::{acos, asin, atan2};
pub use isa::Isa;
pub use logarithm::{ln, log2};
pub use mask::Mask;
pub use power::powf;
pub use real::{Double, MAX_LANES, Real, Word};
pub use trigonometric::{cos, sin, sin_cos};
pub use vec2::Vec2x;
pub use vec3::Vec3x;
