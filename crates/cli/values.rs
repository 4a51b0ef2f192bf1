//! Parsers of option values, each with its error message.

use crate::aliases;
use dapple_integrator::camera::Shutter;
use dapple_integrator::imaging::Tone;
use dapple_integrator::imaging::write::PngDepth;
use dapple_integrator::math::PixelRect;
use dapple_integrator::sampling::sample_set::MAX_COUNT;
use dapple_integrator::{Aov, Effect, MethodKind};
use glam::Vec3;
use std::str::FromStr;
use std::time::Duration;

/// A duration of at least a nanosecond.
pub type Seconds = Duration;

/// Largest width and height of an image, in pixels.
const MAX_SIDE: u32 = 1 << 20;

/// An image size `WxH` in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    pub width: u32,
    pub height: u32,
}

impl FromStr for Size {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        let (w, h) = s.split_once(['x', 'X', '×']).ok_or("write it as WIDTHxHEIGHT, such as 640x480")?;
        let side = |t: &str| t.trim().parse::<u32>().map_err(|_| format!("'{t}' is not a number of pixels"));
        let (width, height) = (side(w)?, side(h)?);
        if width == 0 || height == 0 {
            return Err("width and height must be at least 1".into());
        }
        if width > MAX_SIDE || height > MAX_SIDE {
            return Err(format!("width and height must be at most {MAX_SIDE}"));
        }
        Ok(Self { width, height })
    }
}

/// A rectangle `X0,Y0,X1,Y1`, not empty; whether it lies within the image is checked once the size is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop(pub PixelRect);

impl FromStr for Crop {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        let [x0, y0, x1, y1] = numbers::<u32, 4>(s, "four whole numbers X0,Y0,X1,Y1, none negative")?;
        if x1 <= x0 || y1 <= y0 {
            return Err("it is empty: X1 must be greater than X0, and Y1 than Y0".into());
        }
        Ok(Self(PixelRect { x0, y0, x1, y1 }))
    }
}

/// Pixel coordinates `X,Y`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pixel(pub u32, pub u32);

impl FromStr for Pixel {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        numbers::<u32, 2>(s, "two whole numbers X,Y, none negative").map(|[x, y]| Self(x, y))
    }
}

/// A colour `R,G,B`, finite and not negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color(pub Vec3);

impl FromStr for Color {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        let expected = "three finite numbers R,G,B, none negative";
        let rgb = numbers::<f32, 3>(s, expected)?;
        if rgb.iter().all(|c| c.is_finite() && *c >= 0.0) {
            Ok(Self(Vec3::from_array(rgb)))
        } else {
            Err(format!("expected {expected}"))
        }
    }
}

/// Parses `N` numbers separated by commas.
fn numbers<T: FromStr + Copy + Default, const N: usize>(s: &str, expected: &str) -> Result<[T; N], String> {
    let mut all = [T::default(); N];
    let mut parts = s.split(',');
    for slot in &mut all {
        let part = parts.next().and_then(|p| p.trim().parse().ok());
        *slot = part.ok_or_else(|| format!("expected {expected}"))?;
    }
    if parts.next().is_some() { Err(format!("expected {expected}")) } else { Ok(all) }
}

/// Parses a finite number.
pub fn finite(s: &str) -> Result<f32, String> {
    s.trim().parse().ok().filter(|x: &f32| x.is_finite()).ok_or_else(|| "expected a finite number".into())
}

/// Parses a finite number in double precision.
pub fn finite64(s: &str) -> Result<f64, String> {
    s.trim().parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| "expected a finite number".into())
}

/// Parses a finite number, zero or more.
pub fn non_negative(s: &str) -> Result<f32, String> {
    finite(s).ok().filter(|x| *x >= 0.0).ok_or_else(|| "expected a finite number, zero or more".into())
}

/// Parses a finite number above zero.
pub fn positive(s: &str) -> Result<f32, String> {
    finite(s).ok().filter(|x| *x > 0.0).ok_or_else(|| "expected a finite number above zero".into())
}

/// Parses a number of bytes: 4000000, 800k, 1.5G, 2GiB (powers of 1024), 2GB (powers of 1000).
pub fn bytes(s: &str) -> Result<u64, String> {
    let expected = || "expected a size such as 800M or 12G".to_string();
    let s = s.trim();
    let (number, unit) = s.split_at(s.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(s.len()));
    let number: f64 = number.trim().parse().map_err(|_| expected())?;
    let unit = unit.to_ascii_lowercase();
    let (letter, base) = match unit.as_str() {
        "" | "b" => ("", 1.0),
        unit => match (unit.strip_suffix("ib"), unit.strip_suffix('b')) {
            (Some(letter), _) => (letter, 1024.0_f64),
            (None, Some(letter)) => (letter, 1000.0),
            (None, None) => (unit, 1024.0),
        },
    };
    let power = ["", "k", "m", "g", "t"].iter().position(|known| *known == letter).ok_or_else(expected)?;
    let bytes = number * base.powi(power as i32);
    if bytes >= 1.0 && bytes.is_finite() { Ok(bytes as u64) } else { Err(expected()) }
}

/// Which rendering plan is used: `Smallest` omits what the scene does not need, `General` omits nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanKind {
    Smallest,
    General,
}

/// Parses `smallest` or `general`.
pub fn plan_kind(s: &str) -> Result<PlanKind, String> {
    match aliases::canonical(s, aliases::NONE).as_str() {
        "smallest" => Ok(PlanKind::Smallest),
        "general" => Ok(PlanKind::General),
        _ => Err("expected smallest or general".into()),
    }
}

/// Parses a focus distance: above zero; `inf` focuses at infinity.
pub fn focus(s: &str) -> Result<f32, String> {
    let said = "expected a distance above zero, or inf";
    s.trim().parse().ok().filter(|x: &f32| *x > 0.0).ok_or_else(|| said.into())
}

/// Parses a finite number above zero in double precision.
pub fn positive64(s: &str) -> Result<f64, String> {
    finite64(s).ok().filter(|x| *x > 0.0).ok_or_else(|| "expected a finite number above zero".into())
}

/// Parses a probability of at least one half and below one.
pub fn confidence(s: &str) -> Result<f64, String> {
    let said = || "expected a probability of at least 0.5 and below 1, such as 0.95".into();
    finite64(s).ok().filter(|p| (0.5..1.0).contains(p)).ok_or_else(said)
}

/// A limit `MEASURE=X`; the command checks that the measure exists.
#[derive(Clone, Debug, PartialEq)]
pub struct Threshold {
    pub measure: String,
    pub limit: f64,
}

impl FromStr for Threshold {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        let expected = || "expected MEASURE=X, such as relmse=1e-3".to_string();
        let (measure, limit) = s.split_once('=').ok_or_else(expected)?;
        let limit = finite64(limit).map_err(|_| expected())?;
        Ok(Self { measure: measure.trim().to_ascii_lowercase(), limit })
    }
}

/// Parses `OPEN:CLOSE` in seconds; equal times are an instant.
pub fn shutter(s: &str) -> Result<Shutter, String> {
    let expected = "expected two finite times in seconds, OPEN:CLOSE, such as 0:0.02";
    let (open, close) = s.split_once(':').ok_or(expected)?;
    let (Ok(open), Ok(close)) = (finite64(open), finite64(close)) else { return Err(expected.into()) };
    if close < open {
        return Err(format!("the shutter closes at {close} s, before it opens at {open} s"));
    }
    if !((close - open) as f32).is_finite() {
        return Err("the shutter interval is too long to be represented".into());
    }
    Ok(Shutter { open, close })
}

/// Parses `30s`, `500ms`, `5m` or `1h`; a number without a unit is in seconds. Above zero and below a century.
pub fn duration(s: &str) -> Result<Seconds, String> {
    let s = s.trim();
    let unit = s.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let scale = match unit.trim() {
        "" | "s" | "sec" | "seconds" => 1.0,
        "ms" => 1e-3,
        "m" | "min" | "minutes" => 60.0,
        "h" | "hours" => 3600.0,
        _ => return Err("expected a time such as 30s, 500ms, 5m or 1h".into()),
    };
    let number: f64 = s[..s.len() - unit.len()]
        .parse()
        .map_err(|_| "expected a time such as 30s, 500ms, 5m or 1h".to_string())?;
    let seconds = number * scale;
    if !(1e-9..=3.2e9).contains(&seconds) {
        return Err("expected a time of more than 0 and less than 100 years".into());
    }
    Ok(Duration::from_secs_f64(seconds))
}

/// A range of sample indices, BEGIN:END without END, or BEGIN:+N for N samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleRange {
    /// Index of the first sample.
    pub start: u32,
    /// One past the index of the last sample.
    pub end: u32,
}

impl std::str::FromStr for SampleRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = "expected BEGIN:END, the indices of the samples to render, such as 0:64 for the first 64; for the \
                     number of samples per pixel use --spp";
        let number = |s: &str| s.trim().parse::<u32>().map_err(|_| wrong.to_string());
        let (start, end) = text.split_once(':').ok_or(wrong)?;
        let start = number(start)?;
        let end = match end.trim().strip_prefix('+') {
            Some(count) => {
                start.checked_add(number(count)?).ok_or("the indices of samples are below 2^32 - 1")?
            }
            None => number(end)?,
        };
        match end {
            u32::MAX => Err("the indices of samples are below 2^32 - 1".into()),
            end if end <= start => {
                Err("there are no samples; END is not included and must be greater than BEGIN".into())
            }
            end => Ok(Self { start, end }),
        }
    }
}

impl std::fmt::Display for SampleRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.start, self.end)
    }
}

/// Parses an interval: as [`duration`], or 0 for never.
pub fn interval(s: &str) -> Result<Seconds, String> {
    if s.trim().trim_start_matches('0').trim_end_matches(['s', 'm', 'h']).is_empty() && s.contains('0') {
        return Ok(Duration::ZERO);
    }
    duration(s)
}

/// Layers selected by one word: a single layer, or `all`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layers(pub Vec<Aov>);

impl FromStr for Layers {
    type Err = <Aov as FromStr>::Err;

    fn from_str(s: &str) -> Result<Self, Self::Err> {
        match s {
            "all" => Ok(Self(Aov::ALL.iter().map(|(aov, _)| *aov).collect())),
            one => one.parse().map(|aov| Self(vec![aov])),
        }
    }
}

/// Parses a sample count of an effect, at least 1.
pub fn point_count(s: &str) -> Result<u32, String> {
    let count = s.trim().parse().ok().filter(|n| (1..=MAX_COUNT).contains(n));
    count.ok_or_else(|| format!("expected sample counts, each from 1 to {MAX_COUNT}"))
}

/// Parses `path` or `distribution`.
pub fn method(s: &str) -> Result<MethodKind, String> {
    match aliases::canonical(s, aliases::METHODS).as_str() {
        "path" => Ok(MethodKind::Path),
        "distribution" => Ok(MethodKind::Distribution),
        _ => Err("expected path or distribution".into()),
    }
}

/// Parses the name of an effect.
pub fn effect(s: &str) -> Result<Effect, String> {
    let names = || Effect::ALL.map(|(_, name)| name).join(", ");
    let meant = aliases::canonical(s, aliases::EFFECTS);
    let found = Effect::ALL.iter().find(|(_, name)| *name == meant);
    found.map(|(effect, _)| *effect).ok_or_else(|| format!("expected one of {}", names()))
}

/// Returns the name that [`method`] parses.
pub fn method_name(method: MethodKind) -> &'static str {
    match method {
        MethodKind::Path => "path",
        MethodKind::Distribution => "distribution",
    }
}

/// Parses `8` or `16`.
pub fn png_depth(s: &str) -> Result<PngDepth, String> {
    match s {
        "8" => Ok(PngDepth::Eight),
        "16" => Ok(PngDepth::Sixteen),
        _ => Err("expected 8 or 16".into()),
    }
}

/// Parses `srgb`, `agx`, `aces` or `neutral`.
pub fn tone(s: &str) -> Result<Tone, String> {
    match aliases::canonical(s, aliases::TONES).as_str() {
        "srgb" => Ok(Tone::Srgb),
        "agx" => Ok(Tone::Agx),
        "aces" => Ok(Tone::Aces),
        "neutral" => Ok(Tone::Neutral),
        _ => Err("expected srgb, agx, aces or neutral".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_in_bytes() {
        let some = [
            ("4096", 4096),
            ("1k", 1024),
            ("1.5 M", 3 << 19),
            ("2GiB", 2 << 30),
            ("2GB", 2_000_000_000),
            ("1t", 1 << 40),
            ("7b", 7),
        ];
        for (text, size) in some {
            assert_eq!(bytes(text), Ok(size), "{text}");
        }
        for text in ["", "G", "-1G", "0", "nan", "1e400", "3 apples", "4GX"] {
            assert!(bytes(text).is_err(), "{text}");
        }
    }

    #[test]
    fn sizes_are_positive_and_bounded() {
        assert_eq!("640x480".parse(), Ok(Size { width: 640, height: 480 }));
        for bad in ["0x0", "0x4", "4x0", "4", "4x", "x4", "-4x4", "4x4x4", "9999999x1", "4.5x4"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
    }

    #[test]
    fn crops_hold_at_least_a_pixel() {
        assert_eq!("1,2,3,4".parse(), Ok(Crop(PixelRect { x0: 1, y0: 2, x1: 3, y1: 4 })));
        for bad in ["1,2,1,4", "1,2,0,4", "1,2,3", "1,2,3,4,5", "-1,0,3,4", "a,b,c,d", ""] {
            assert!(bad.parse::<Crop>().is_err(), "{bad}");
        }
    }

    #[test]
    fn shutters_open_before_they_close() {
        assert_eq!(shutter("-0.5:1.25"), Ok(Shutter { open: -0.5, close: 1.25 }));
        assert_eq!(shutter("2:2"), Ok(Shutter { open: 2.0, close: 2.0 }));
        for bad in
            ["", ":", "1", "1:", ":1", "1:0", "0:nan", "0:inf", "-inf:0", "a:b", "0:1:2", "-1e308:1e308"]
        {
            assert!(shutter(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn durations_have_units_and_ends() {
        assert_eq!(duration("30s"), Ok(Duration::from_secs(30)));
        assert_eq!(duration("30"), Ok(Duration::from_secs(30)));
        assert_eq!(duration("1.5m"), Ok(Duration::from_secs(90)));
        assert_eq!(duration("500ms"), Ok(Duration::from_millis(500)));
        for bad in ["0", "0s", "-1s", "s", "", "1d", "nan", "inf", "1e30s", "9999999999999h"] {
            assert!(duration(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn thresholds_have_a_name_and_a_number() {
        assert_eq!("relMSE=1e-3".parse(), Ok(Threshold { measure: "relmse".into(), limit: 1e-3 }));
        for bad in ["", "relmse", "relmse=", "relmse=x", "relmse=nan", "1e-3"] {
            assert!(bad.parse::<Threshold>().is_err(), "{bad}");
        }
    }

    #[test]
    fn colours_are_radiances() {
        assert_eq!("1,0.5,0".parse(), Ok(Color(Vec3::new(1.0, 0.5, 0.0))));
        for bad in ["1,1", "1,1,-1", "1,1,nan", "inf,1,1", "1,1,1,1", "red"] {
            assert!(bad.parse::<Color>().is_err(), "{bad}");
        }
    }

    #[test]
    fn names_round_trip() {
        for m in [MethodKind::Path, MethodKind::Distribution] {
            assert_eq!(method(method_name(m)), Ok(m));
        }
        assert!(method("rays").is_err());
    }
}
