//! Tests tone curves at points that follow from their specifications, and properties common to all curves.

use dapple_imaging::{Tone, color::srgb_to_linear};
use glam::{DVec3, Vec3};

fn linear(tone: Tone, c: Vec3) -> Vec3 {
    tone.apply(c).map(srgb_to_linear)
}

fn assert_close(a: Vec3, b: Vec3, tolerance: f32) {
    assert!((a - b).abs().max_element() <= tolerance, "{a} is not {b}");
}

#[test]
fn srgb_is_the_exact_curve_clipped() {
    let c = Tone::Srgb.apply(Vec3::new(0.18, 0.002, 7.0));
    assert_close(c, Vec3::new(0.461_356_1, 0.025_84, 1.0), 1e-6);
}

/// Properties from the specification: greys from 0.08 up to the start of the compression are reduced by exactly 0.04, a
/// colour whose lowest component is 0 is unchanged, the peak follows 1 − d²/(x + d − s), and hue is preserved where
/// nothing is desaturated.
#[test]
fn neutral_keeps_its_published_promises() {
    for v in [0.08, 0.3, 0.5, 0.79] {
        assert_close(linear(Tone::Neutral, Vec3::splat(v)), Vec3::splat(v - 0.04), 2e-6);
    }
    assert_close(linear(Tone::Neutral, Vec3::new(0.7, 0.2, 0.0)), Vec3::new(0.7, 0.2, 0.0), 2e-6);
    assert_close(linear(Tone::Neutral, Vec3::splat(0.04)), Vec3::splat(6.25 * 0.04 * 0.04), 2e-6);
    for v in [1.0f32, 4.0, 50.0] {
        let peak = v - 0.04;
        let expected = 1.0 - 0.24 * 0.24 / (peak + 0.24 - 0.76);
        assert_close(linear(Tone::Neutral, Vec3::splat(v)), Vec3::splat(expected), 3e-6);
    }
    let white = linear(Tone::Neutral, Vec3::new(60_000.0, 0.0, 0.0));
    assert!(white.min_element() > 0.999, "a hot red ends white, not {white}");
}

/// The rational function of the fit in f64. Its matrices preserve greys to 1e-5, so that a grey depends on the fit
/// alone.
#[test]
fn aces_greys_follow_the_fit() {
    for v in [0.01f64, 0.18, 1.0, 5.0] {
        let fit = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
        assert_close(linear(Tone::Aces, Vec3::splat(v as f32)), Vec3::splat((fit as f32).min(1.0)), 3e-5);
    }
    // The limit of the fit, 1/0.983729, is above 1, so that bright greys clip to white.
    assert_eq!(Tone::Aces.apply(Vec3::splat(1000.0)), Vec3::ONE);
}

/// A colour that is not grey, with the matrices of BakingLab's ACES.hlsl row by row in f64.
#[test]
fn aces_mixes_as_published() {
    let input = [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    let output =
        [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    let mul = |m: [[f64; 3]; 3], v: DVec3| DVec3::from_array(m.map(|row| DVec3::from_array(row).dot(v)));
    let fit = |v: f64| (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
    for c in [DVec3::new(0.4, 0.1, 0.05), DVec3::new(0.02, 0.3, 2.0)] {
        let expected = mul(output, mul(input, c).map(fit)).clamp(DVec3::ZERO, DVec3::ONE);
        assert_close(linear(Tone::Aces, c.as_vec3()), expected.as_vec3(), 3e-6);
    }
}

/// Wrensch's published steps in f64, and AgX's pivot, which Sobotka defines at ten of 16.5 stops from black and at half
/// of the output: middle grey 0.18 gives the code value 0.5 within a few times the error of the fit (root of 3.67e-6).
#[test]
fn agx_follows_the_published_steps() {
    assert_close(Tone::Agx.apply(Vec3::splat(0.18)), Vec3::splat(0.5), 4e-3);
    let columns = [
        DVec3::new(0.842479062253094, 0.0423282422610123, 0.0423756549057051),
        DVec3::new(0.0784335999999992, 0.878468636469772, 0.0784336),
        DVec3::new(0.0792237451477643, 0.0791661274605434, 0.879142973793104),
    ];
    let back = [
        DVec3::new(1.19687900512017, -0.0528968517574562, -0.0529716355144438),
        DVec3::new(-0.0980208811401368, 1.15190312990417, -0.0980434501171241),
        DVec3::new(-0.0990297440797205, -0.0989611768448433, 1.15107367264116),
    ];
    let mul = |m: [DVec3; 3], v: DVec3| m[0] * v.x + m[1] * v.y + m[2] * v.z;
    let sigmoid = |x: f64| {
        15.5 * x.powi(6) - 40.14 * x.powi(5) + 31.96 * x.powi(4) - 6.868 * x.powi(3)
            + 0.4298 * x * x
            + 0.1191 * x
            - 0.00232
    };
    for c in [DVec3::new(0.4, 0.1, 0.05), DVec3::new(0.02, 0.3, 2.0), DVec3::new(9.0, 1.0, 3.0)] {
        let log = mul(columns, c).map(|v| v.log2().clamp(-12.47393, 4.026069));
        let expected = mul(back, log.map(|ev| sigmoid((ev + 12.47393) / 16.499999)));
        let expected = expected.clamp(DVec3::ZERO, DVec3::ONE);
        assert_close(Tone::Agx.apply(c.as_vec3()), expected.as_vec3(), 1e-5);
    }
}

/// The curves are monotone for greys over 40 stops. The AgX fit, a polynomial, decreases by less than 1/255 in its toe
/// and shoulder.
#[test]
fn greys_rise() {
    for (tone, name) in Tone::ALL {
        let slack = if tone == Tone::Agx { 1.0 / 255.0 } else { 1e-6 };
        let mut highest: f32 = 0.0;
        for i in 0..=4000 {
            let v = tone.apply(Vec3::splat(libm::exp2f(i as f32 / 100.0 - 20.0)));
            assert!(v.min_element() >= highest - slack, "{name} falls at step {i}: {highest} to {v}");
            highest = highest.max(v.max_element());
        }
        assert!(highest > 0.98, "{name} never gets white: {highest}");
    }
}

#[test]
fn any_input_gives_a_code_value() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, -1.0, -0.0, 1e-45, 0.5];
    for (tone, name) in Tone::ALL {
        for r in odd {
            for g in odd {
                let v = tone.apply(Vec3::new(r, g, 0.25));
                assert!(v.min_element() >= 0.0 && v.max_element() <= 1.0, "{name} of {r}, {g}: {v}");
                assert!(!v.is_nan(), "{name} of {r}, {g}");
            }
        }
        let black = tone.apply(Vec3::ZERO);
        assert!(black.max_element() < 1.0 / 255.0, "{name}: black is {black}");
    }
}

#[test]
fn names_go_round() {
    for (tone, name) in Tone::ALL {
        assert_eq!(name.parse(), Ok(tone));
        assert_eq!(tone.to_string(), name);
    }
    let error = "filmic".parse::<Tone>().unwrap_err().to_string();
    assert_eq!(error, "unknown tone curve `filmic`; use srgb, agx, aces or neutral");
}
