//! The thin lens: shape and sampling of the aperture, and the focus distance.
//!
//! On the command line, apertures are written as `disk`, `square` or `blades:N[:rotation]`, with the rotation in
//! degrees.
use dapple_math::lanes::{Real, Vec2x};
use dapple_sampling::lanes::warp;
use glam::Vec2;
use std::{fmt, str::FromStr};

/// Shape of the aperture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Aperture {
    /// A round aperture.
    #[default]
    Disk,
    /// A square aperture with sides along the camera's right and up axes.
    Square,
    /// A regular polygon, as formed by the blades of a diaphragm.
    Blades {
        /// Number of corners, at least 3.
        n: u32,
        /// Angle of the first corner, from right towards up, in radians.
        rotation: f32,
    },
}

/// A thin lens. Lengths are in render-space units, and the focus distance may be infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Shape of the aperture.
    pub aperture: Aperture,
    /// Radius of the disk, half side of the square or circumradius of the polygon; 0 is a pinhole.
    pub radius: f32,
    /// Distance of the plane in focus along the view axis, > 0.
    pub focus_distance: f32,
}

impl Lens {
    /// Samples a point of the aperture uniformly by `u` in \[0,1)², in render-space units relative to the lens centre
    /// (x right, y up).
    #[inline]
    pub fn point(&self, u: Vec2) -> Vec2 {
        self.point_lanes::<f32>(u.into()).into()
    }

    /// Samples a point of the aperture per lane, as [`Lens::point`] does.
    #[inline(always)]
    pub fn point_lanes<R: Real>(&self, u: Vec2x<R>) -> Vec2x<R> {
        let unit = match self.aperture {
            Aperture::Disk => warp::disk(u),
            Aperture::Square => warp::square(u),
            Aperture::Blades { n, rotation } => warp::polygon(u, n.max(3), rotation),
        };
        unit * R::splat(self.radius)
    }

    /// Returns the area of the aperture in square render-space units.
    pub fn area(&self) -> f64 {
        let r2 = self.radius as f64 * self.radius as f64;
        r2 * match self.aperture {
            Aperture::Disk => std::f64::consts::PI,
            Aperture::Square => 4.0,
            Aperture::Blades { n, .. } => {
                let n = n.max(3) as f64;
                0.5 * n * libm::sin(std::f64::consts::TAU / n)
            }
        }
    }

    /// Returns 1/focus, which is 0 for infinity. A focus of zero (rejected by the callers) acts as the smallest
    /// positive one.
    #[inline]
    pub(crate) fn inverse_focus(&self) -> f64 {
        1.0 / (self.focus_distance as f64).max(f32::MIN_POSITIVE as f64)
    }
}

/// Errors of parsing an aperture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ApertureError {
    /// There is no shape of that name.
    Unknown(String),
    /// The number of blades is missing, not an integer, or not in 3..=1000.
    Blades(String),
    /// The rotation is not a finite number of degrees.
    Rotation(String),
}
impl fmt::Display for ApertureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(s) => {
                write!(f, "unknown aperture '{s}': use disk, square or blades:N[:degrees], e.g. blades:6")
            }
            Self::Blades(s) => {
                write!(f, "invalid number of blades '{s}': give an integer from 3 to 1000, e.g. blades:6")
            }
            Self::Rotation(s) => write!(f, "invalid aperture rotation '{s}': give degrees, e.g. blades:6:15"),
        }
    }
}
impl std::error::Error for ApertureError {}

impl FromStr for Aperture {
    type Err = ApertureError;
    fn from_str(s: &str) -> Result<Self, ApertureError> {
        match s {
            "disk" => return Ok(Self::Disk),
            "square" => return Ok(Self::Square),
            _ => {}
        }
        let rest = s.strip_prefix("blades:").ok_or_else(|| ApertureError::Unknown(s.to_owned()))?;
        let (n, rotation) = rest.split_once(':').map_or((rest, None), |(n, r)| (n, Some(r)));
        let blades = n.parse().ok().filter(|n| (3..=1000).contains(n));
        let n = blades.ok_or_else(|| ApertureError::Blades(n.to_owned()))?;
        let rotation = rotation.map_or(Ok(0.0), degrees)?;
        Ok(Self::Blades { n, rotation })
    }
}

fn degrees(s: &str) -> Result<f32, ApertureError> {
    let degrees: Option<f64> = s.parse().ok();
    let radians = degrees.map(|d| d.to_radians() as f32).filter(|r| r.is_finite());
    radians.ok_or_else(|| ApertureError::Rotation(s.to_owned()))
}

impl fmt::Display for Aperture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Disk => f.write_str("disk"),
            Self::Square => f.write_str("square"),
            Self::Blades { n, rotation: 0.0 } => write!(f, "blades:{n}"),
            Self::Blades { n, rotation } => {
                // The short form if it parses to the same angle, otherwise all digits.
                let degrees = (rotation as f64).to_degrees();
                let short = degrees as f32;
                if short.to_string().parse::<f64>().is_ok_and(|d| d.to_radians() as f32 == rotation) {
                    write!(f, "blades:{n}:{short}")
                } else {
                    write!(f, "blades:{n}:{degrees}")
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for s in ["disk", "square", "blades:6", "blades:5:30", "blades:7:-12.5", "blades:9:33.333"] {
            let a: Aperture = s.parse().unwrap();
            assert_eq!(a.to_string(), s);
        }
        for i in 0..1000 {
            let a = Aperture::Blades { n: 5, rotation: 0.001 + i as f32 * 0.00617 };
            assert_eq!(a.to_string().parse(), Ok(a));
        }
    }

    #[test]
    fn nonsense_is_a_typed_error() {
        let parse = |s: &str| s.parse::<Aperture>().unwrap_err();
        assert_eq!(parse("round"), ApertureError::Unknown("round".into()));
        assert_eq!(parse("blades:2"), ApertureError::Blades("2".into()));
        assert_eq!(parse("blades:"), ApertureError::Blades(String::new()));
        assert_eq!(parse("blades:6:nan"), ApertureError::Rotation("nan".into()));
    }
}
