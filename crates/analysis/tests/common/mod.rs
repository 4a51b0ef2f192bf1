//! A test image that is generated identically for the other implementations.

pub const W: usize = 48;
pub const H: usize = 32;

fn hash(i: usize) -> u32 {
    let i = (i as u32).wrapping_mul(2_654_435_761).wrapping_add(12_345);
    let i = (i ^ i >> 15).wrapping_mul(2_246_822_519);
    let i = (i ^ i >> 13).wrapping_mul(3_266_489_917);
    i ^ i >> 16
}

/// Code value of a channel: ramps and uniform fields in a checkerboard, with noise of kind `k` (none for 0).
pub fn code(x: usize, y: usize, c: usize, k: usize) -> u8 {
    let ramps = (x / 12 + y / 8).is_multiple_of(2);
    let base = if ramps { (x * 5 * (c + 1) + y * 3) % 256 } else { 128 + 40 * c };
    let noise = if k > 0 { (hash(((y * W + x) * 3 + c) * 4 + k) >> 24) as i64 % 64 - 32 } else { 0 };
    (base as i64 + noise).clamp(0, 255) as u8
}
