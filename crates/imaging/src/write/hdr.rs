//! Encoding of Radiance RGBE files with run lengths [Ward 1991, "Real Pixels"; Radiance `color.c`].
//!
//! This is implemented here because the exponent is taken from the bits of the float (a logarithm differs between
//! machines) and mantissas are rounded to nearest (truncation would darken every image by half a step, 0.2–0.4 %).

use crate::Image;
use glam::Vec3;

/// Rows of these widths are run-length encoded; others are uncompressed, as the format requires.
const RUN_WIDTHS: std::ops::RangeInclusive<usize> = 8..=32_767;

/// Encodes an image. The caller has checked that the number of pixels matches the size.
pub(super) fn encode(picture: &Image) -> Vec<u8> {
    let (width, height) = (picture.width, picture.height);
    let mut out = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    for row in picture.pixels.chunks(width.max(1)) {
        let row: Vec<[u8; 4]> = row.iter().map(|p| rgbe(*p)).collect();
        if RUN_WIDTHS.contains(&width) {
            out.extend([2, 2, (width >> 8) as u8, (width & 255) as u8]);
            for i in 0..4 {
                let plane: Vec<u8> = row.iter().map(|p| p[i]).collect();
                runs(&plane, &mut out);
            }
        } else {
            out.extend(row.as_flattened());
        }
    }
    out
}

/// Mantissas and exponent: component ≈ m · 2^(e − 136), the largest m in 128..=255.
fn rgbe(colour: Vec3) -> [u8; 4] {
    const LARGEST: f32 = 255.0 / 256.0 * 1.701_411_8e38; // 255 · 2^(255 − 136)
    let c = colour.map(|v| if v > 0.0 { v.min(LARGEST) } else { 0.0 });
    let largest = c.x.max(c.y).max(c.z);
    if largest < f32::MIN_POSITIVE {
        return [0; 4]; // below 1.2e-38 the exponent would not fit into the byte
    }
    // largest = f · 2^k with f in [1, 2): k from the bits.
    let k = (largest.to_bits() >> 23) as i32 - 127;
    let mantissas =
        |k: i32| c.map(|v| (v as f64 * power_of_two(7 - k) + 0.5) as f32).to_array().map(|m| m as u32);
    let mut m = mantissas(k);
    let mut e = k;
    if m.iter().any(|&m| m > 255) {
        e += 1; // rounding carried into the next power of two
        m = mantissas(e);
    }
    [m[0] as u8, m[1] as u8, m[2] as u8, (e + 129) as u8]
}

/// 2^k for |k| ≤ 1000, exactly.
fn power_of_two(k: i32) -> f64 {
    f64::from_bits(((k + 1023) as u64) << 52)
}

/// Encodes runs of at least four equal bytes as (128 + length, byte), and other bytes as (length, bytes…).
fn runs(plane: &[u8], out: &mut Vec<u8>) {
    let run_at = |i: usize| plane[i..].iter().take(127).take_while(|&&b| b == plane[i]).count();
    let mut i = 0;
    while i < plane.len() {
        let run = run_at(i);
        if run >= 4 {
            out.extend([128 + run as u8, plane[i]]);
            i += run;
            continue;
        }
        let mut end = i + run;
        while end < plane.len() && end - i < 128 && run_at(end) < 4 {
            end += 1;
        }
        let end = end.min(i + 128);
        out.push((end - i) as u8);
        out.extend(&plane[i..end]);
        i = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode([r, g, b, e]: [u8; 4]) -> [f64; 3] {
        let unit = if e == 0 { 0.0 } else { power_of_two(e as i32 - 136) };
        [r, g, b].map(|m| m as f64 * unit)
    }

    #[test]
    fn largest_component_within_half_a_step() {
        for i in 0..20_000 {
            let v = libm::expf(i as f32 / 20_000.0 * 170.0 - 85.0);
            let code = rgbe(Vec3::new(v, 0.3 * v, 0.0));
            assert!(code[0] >= 128, "{v}: {code:?} is not normalised");
            let [r, g, b] = decode(code);
            let step = (v as f64) / 256.0 * 1.000_001;
            assert!((r - v as f64).abs() <= step && (g - 0.3 * v as f64).abs() <= step && b == 0.0, "{v}");
        }
    }

    #[test]
    fn odd_values_are_tamed() {
        assert_eq!(rgbe(Vec3::new(-1.0, f32::NAN, 0.0)), [0; 4]);
        assert_eq!(rgbe(Vec3::splat(f32::INFINITY)), [255; 4]);
        assert_eq!(rgbe(Vec3::splat(f32::MAX)), [255; 4]);
        assert_eq!(rgbe(Vec3::ONE), [128, 128, 128, 129]);
        assert_eq!(rgbe(Vec3::splat(0.999_999)), [128, 128, 128, 129]);
    }
}
