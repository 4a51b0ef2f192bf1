//! Tone curves, which map radiance to display values.
//!
//! Every curve maps linear Rec.709 (after exposure; 1 is diffuse white) to an sRGB code value in [0, 1], ready to be
//! rounded to 8 bits. The curves have exactly the coefficients published by their authors:
//! - `srgb`: clip, then the exact sRGB curve [IEC 61966-2-1]. The only one that `read::picture` inverts.
//! - `agx`: AgX base look by Troy Sobotka in the sixth-order fit by Benjamin Wrensch ("Minimal AgX Implementation",
//!   iolite-engine.com, 2023). *Approximation* of the sigmoid with a mean squared error of 3.7e-6 according to its
//!   author, which is less than one 8-bit step on average. Its output is the code value for a display of exponent 2.2,
//!   and is written unchanged.
//! - `aces`: the fit of RRT + sRGB ODT by Stephen Hill (BakingLab `ACES.hlsl`, MJP & D. Neubelt). *Approximation* of
//!   the ACES 1.0 output transform, without an additional exposure factor.
//! - `neutral`: Khronos PBR Neutral (specification in `KhronosGroup/ToneMapping`, 2024): base colours under grey light
//!   are reproduced unchanged, and only highlights are compressed.
//!
//! Transcendental functions use `libm`, so that the bytes of an image do not depend on the machine.

use crate::color::linear_to_srgb;
use glam::{Mat3, Vec3};
use std::fmt;
use std::str::FromStr;

/// A tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tone {
    /// Clip to [0, 1] and encode.
    #[default]
    Srgb,
    /// AgX base look.
    Agx,
    /// ACES filmic (Hill's fit).
    Aces,
    /// Khronos PBR Neutral.
    Neutral,
}

impl Tone {
    /// All curves with their names, in the order of the help texts.
    pub const ALL: [(Self, &'static str); 4] =
        [(Self::Srgb, "srgb"), (Self::Agx, "agx"), (Self::Aces, "aces"), (Self::Neutral, "neutral")];

    /// The name accepted by [`FromStr`].
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(tone, _)| *tone == self).map_or("", |(_, name)| name)
    }

    /// Maps a linear Rec.709 colour to a display-referred sRGB-encoded value in [0, 1]. The function is total: negative
    /// and NaN components count as 0, components above 65504 (the largest half) as 65504.
    pub fn apply(self, linear: Vec3) -> Vec3 {
        let c = linear.map(|v| if v > 0.0 { v.min(65504.0) } else { 0.0 });
        let encode = |c: Vec3| c.clamp(Vec3::ZERO, Vec3::ONE).map(linear_to_srgb);
        match self {
            Tone::Srgb => encode(c),
            Tone::Agx => agx(c).clamp(Vec3::ZERO, Vec3::ONE),
            Tone::Aces => encode(aces(c)),
            Tone::Neutral => encode(neutral(c)),
        }
    }
}

/// Inset, log2 from −12.47393 to 4.026069, sigmoid, outset [Wrensch 2023].
fn agx(c: Vec3) -> Vec3 {
    const INSET: Mat3 = Mat3::from_cols(
        Vec3::new(0.842_479_06, 0.042_328_242, 0.042_375_655),
        Vec3::new(0.078_433_6, 0.878_468_64, 0.078_433_6),
        Vec3::new(0.079_223_745, 0.079_166_13, 0.879_143),
    );
    const OUTSET: Mat3 = Mat3::from_cols(
        Vec3::new(1.196_879, -0.052_896_857, -0.052_971_635),
        Vec3::new(-0.098_020_88, 1.151_903_1, -0.098_043_45),
        Vec3::new(-0.099_029_74, -0.098_961_18, 1.151_073_7),
    );
    const MIN_EV: f32 = -12.473_93;
    const MAX_EV: f32 = 4.026_069;
    let log = (INSET * c).map(|v| libm::log2f(v.max(1e-10)).clamp(MIN_EV, MAX_EV));
    OUTSET * log.map(|ev| agx_sigmoid((ev - MIN_EV) / (MAX_EV - MIN_EV)))
}

/// Wrensch's sixth-order fit to the AgX base contrast, for x in [0, 1].
fn agx_sigmoid(x: f32) -> f32 {
    let (x2, x4) = (x * x, (x * x) * (x * x));
    15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.002_32
}

/// sRGB → ACEScg with RRT saturation, rational fit, ODT saturation → sRGB (linear) [Hill].
fn aces(c: Vec3) -> Vec3 {
    const INPUT: Mat3 = Mat3::from_cols(
        Vec3::new(0.597_19, 0.076_00, 0.028_40),
        Vec3::new(0.354_58, 0.908_34, 0.133_83),
        Vec3::new(0.048_23, 0.015_66, 0.837_77),
    );
    const OUTPUT: Mat3 = Mat3::from_cols(
        Vec3::new(1.604_75, -0.102_08, -0.003_27),
        Vec3::new(-0.531_08, 1.108_13, -0.072_76),
        Vec3::new(-0.073_67, -0.006_05, 1.076_02),
    );
    let fit =
        |v: f32| (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    OUTPUT * (INPUT * c).map(fit)
}

/// Subtracts the 4 % reflection of a dielectric, compresses the peak above 0.76 and desaturates compressed colours
/// [Khronos PBR Neutral].
fn neutral(c: Vec3) -> Vec3 {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let low = c.x.min(c.y).min(c.z);
    let c = c - if low < 0.08 { low - 6.25 * low * low } else { 0.04 };
    let peak = c.x.max(c.y).max(c.z);
    if peak < START {
        return c;
    }
    let d = 1.0 - START;
    let new_peak = 1.0 - d * d / (peak + d - START);
    let g = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    let c = c * (new_peak / peak);
    c + (Vec3::splat(new_peak) - c) * g
}

impl fmt::Display for Tone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The error for an unknown tone curve name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown tone curve `{0}`; use srgb, agx, aces or neutral")]
pub struct UnknownTone(pub String);

impl FromStr for Tone {
    type Err = UnknownTone;

    fn from_str(s: &str) -> Result<Self, UnknownTone> {
        let found = Self::ALL.iter().find(|(_, name)| *name == s);
        found.map(|(tone, _)| *tone).ok_or_else(|| UnknownTone(s.to_string()))
    }
}
