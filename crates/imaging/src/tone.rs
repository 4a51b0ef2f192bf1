//! From linear radiance to display values.

use crate::color::linear_to_srgb;
use glam::{Mat3, Vec3};
use std::fmt;
use std::str::FromStr;

/// A tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// Clip at 1.
    #[default]
    Srgb,
    /// AgX, base look (the polynomial fit by B. Wrensch of T. Sobotka's curve). *Approximation*: fit error below 1 %.
    Agx,
    /// ACES filmic (S. Hill's fit of RRT + ODT). *Approximation* of the full transform.
    Aces,
    /// Khronos PBR Neutral.
    Neutral,
}

impl Tone {
    /// All curves with their names.
    pub const ALL: [(Self, &'static str); 4] =
        [(Self::Srgb, "srgb"), (Self::Agx, "agx"), (Self::Aces, "aces"), (Self::Neutral, "neutral")];

    /// Display-referred sRGB-encoded value in [0,1]; what is not a number becomes 0.
    pub fn apply(self, linear: Vec3) -> Vec3 {
        let sane = linear.map(|c| if c.is_nan() { 0.0 } else { c.clamp(0.0, 1e30) });
        let encode = |c: Vec3| c.clamp(Vec3::ZERO, Vec3::ONE).map(linear_to_srgb);
        match self {
            Self::Srgb => encode(sane),
            Self::Agx => agx(sane),
            Self::Aces => encode(aces(sane)),
            Self::Neutral => encode(neutral(sane)),
        }
    }
}

/// [Wrensch 2023, "Minimal AgX"]: inset, log2 over 16.5 stops, sixth-order contrast fit, outset.
fn agx(c: Vec3) -> Vec3 {
    const INSET: Mat3 = Mat3::from_cols(
        Vec3::new(0.842_479_06, 0.042_328_242, 0.042_375_654),
        Vec3::new(0.078_433_6, 0.878_468_6, 0.078_433_6),
        Vec3::new(0.079_223_745, 0.079_166_13, 0.879_142_97),
    );
    const OUTSET: Mat3 = Mat3::from_cols(
        Vec3::new(1.196_879, -0.052_896_85, -0.052_971_635),
        Vec3::new(-0.098_020_88, 1.151_903_1, -0.098_043_45),
        Vec3::new(-0.099_029_74, -0.098_961_18, 1.151_073_7),
    );
    let stops = (INSET * c).map(|x| libm::log2f(x.max(1e-10)).clamp(-12.473_93, 4.026_069));
    let x = (stops + 12.473_93) / (4.026_069 + 12.473_93);
    let curve = |x: f32| {
        let (x2, x4) = (x * x, x * x * x * x);
        15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.002_32
    };
    (OUTSET * x.map(curve)).clamp(Vec3::ZERO, Vec3::ONE)
}

/// [Hill, in MJP's BakingLab]: sRGB to the curve's space, rational fit, and back.
fn aces(c: Vec3) -> Vec3 {
    const IN: Mat3 = Mat3::from_cols(
        Vec3::new(0.597_19, 0.076, 0.0284),
        Vec3::new(0.354_58, 0.908_34, 0.133_83),
        Vec3::new(0.048_23, 0.015_66, 0.837_77),
    );
    const OUT: Mat3 = Mat3::from_cols(
        Vec3::new(1.604_75, -0.102_08, -0.003_27),
        Vec3::new(-0.531_08, 1.108_13, -0.072_76),
        Vec3::new(-0.073_67, -0.006_05, 1.076_02),
    );
    let v = IN * c.min(Vec3::splat(1e6));
    OUT * ((v * (v + 0.024_578_6) - 0.000_090_537) / (v * (v * 0.983_729 + 0.432_951) + 0.238_081))
}

/// [Khronos PBR Neutral Tone Mapper specification].
fn neutral(c: Vec3) -> Vec3 {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let x = c.min_element();
    let offset = if x < 0.08 { x - 6.25 * x * x } else { 0.04 };
    let c = c - offset;
    let peak = c.max_element();
    if peak < START {
        return c;
    }
    let d = 1.0 - START;
    let new_peak = 1.0 - d * d / (peak + d - START);
    let g = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    (c * (new_peak / peak)).lerp(Vec3::splat(new_peak), g)
}

/// Not the name of a tone curve.
#[derive(Clone, Debug, thiserror::Error)]
#[error("'{0}' is no tone curve; choose srgb, agx, aces or neutral")]
pub struct UnknownTone(String);

impl FromStr for Tone {
    type Err = UnknownTone;
    fn from_str(s: &str) -> Result<Self, UnknownTone> {
        Self::ALL
            .iter()
            .find(|(_, name)| *name == s)
            .map(|(tone, _)| *tone)
            .ok_or_else(|| UnknownTone(s.into()))
    }
}

impl fmt::Display for Tone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(Self::ALL.iter().find(|(tone, _)| tone == self).map_or("", |(_, name)| name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_rise_and_stay_in_range() {
        for (tone, name) in Tone::ALL {
            let mut last = -1.0;
            for i in 0..200 {
                let v = tone.apply(Vec3::splat(1e-4 * 1.1f32.powi(i)));
                assert!(v.min_element() >= 0.0 && v.max_element() <= 1.0, "{name}");
                assert!(v.y >= last - 2e-3, "{name} falls at step {i}");
                last = v.y;
            }
            assert!(tone.apply(Vec3::NAN).is_finite() && tone.apply(Vec3::INFINITY).is_finite());
        }
    }

    #[test]
    fn published_points() {
        // Neutral: the offset takes exactly 0.04 off a base colour of 0.5; grey 0.18 clips nowhere in sRGB.
        let linear = |v: f32| crate::color::srgb_to_linear(v);
        assert!((linear(Tone::Neutral.apply(Vec3::splat(0.5)).x) - 0.46).abs() < 1e-4);
        assert!((linear(Tone::Srgb.apply(Vec3::splat(0.18)).x) - 0.18).abs() < 1e-5);
        // ACES (Hill): 1.0 maps to about 0.6 of display white after the exposure built into the fit.
        let one = linear(Tone::Aces.apply(Vec3::ONE).x);
        assert!((0.55..0.65).contains(&one), "{one}");
    }
}
