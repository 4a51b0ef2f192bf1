//! Pixel filters and their importance sampling.
//!
//! Filters are sampled instead of splatted: the film point is warped so that its density is the filter [Ernst 2006].
//! Every pixel then has its own independent samples, and a constant image stays constant. Filters with negative lobes
//! (Mitchell) are sampled by |f| with the weight sign(f)·∫|f|, whose mean is 1. All filters are separable.
use dapple_sampling::warp;
use glam::Vec2;
use std::{fmt, str::FromStr, sync::LazyLock};

/// The pixel filters, with radii in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// Constant on a square of half side `radius`. A radius of 0.5 is the pixel itself.
    Box {
        /// Half side in pixels, > 0.
        radius: f32,
    },
    /// Tent with a linear falloff, radius 1.
    Tent,
    /// Gaussian with σ = 0.5 minus its value at the radius 1.5.
    Gaussian,
    /// Mitchell–Netravali with B = C = ⅓, radius 2. It is negative beyond 8/7.
    Mitchell,
    /// Four-term Blackman–Harris window, radius 1.5.
    BlackmanHarris,
}

impl Default for Filter {
    fn default() -> Self {
        Self::Box { radius: 0.5 }
    }
}

impl Filter {
    /// Samples the filter by `u` in \[0,1)² and returns the offset from the pixel's centre in pixels and the weight of
    /// the sample. The weight is 1 unless the filter has negative lobes, and its mean is always 1. The offset is
    /// monotone in each coordinate, so that strata of `u` stay strata. For `Box { radius: 0.5 }` it is u − ½ exactly.
    #[inline]
    pub fn sample(&self, u: Vec2) -> (Vec2, f32) {
        match *self {
            Self::Box { radius } => ((u + u - Vec2::ONE) * radius, 1.0),
            Self::Tent => (Vec2::new(warp::tent(u.x, 1.0), warp::tent(u.y, 1.0)), 1.0),
            Self::Gaussian => GAUSSIAN.sample_2d(u),
            Self::Mitchell => MITCHELL.sample_2d(u),
            Self::BlackmanHarris => BLACKMAN_HARRIS.sample_2d(u),
        }
    }

    /// Returns half the side, in pixels, of the square outside of which the filter is zero.
    pub fn radius(&self) -> f32 {
        match *self {
            Self::Box { radius } => radius,
            Self::Tent => 1.0,
            Self::Gaussian | Self::BlackmanHarris => 1.5,
            Self::Mitchell => 2.0,
        }
    }
}

static GAUSSIAN: LazyLock<Axis> = LazyLock::new(|| Axis::new(1.5, gaussian));
static MITCHELL: LazyLock<Axis> = LazyLock::new(|| Axis::new(2.0, mitchell));
static BLACKMAN_HARRIS: LazyLock<Axis> = LazyLock::new(|| Axis::new(1.5, blackman_harris));

/// e^(−x²/2σ²) − e^(−r²/2σ²) with σ = 0.5, r = 1.5, for 0 ≤ x ≤ r.
fn gaussian(x: f64) -> f64 {
    libm::exp(-2.0 * x * x) - libm::exp(-4.5)
}
/// The filter of [Mitchell and Netravali 1988] with B = C = ⅓, for 0 ≤ x ≤ 2. The outer piece is −7/18·(x − 2)²(x −
/// 8/7).
fn mitchell(x: f64) -> f64 {
    if x < 1.0 {
        ((7.0 * x - 12.0) * x * x + 16.0 / 3.0) / 6.0
    } else {
        -7.0 / 18.0 * (x - 2.0) * (x - 2.0) * (x - 8.0 / 7.0)
    }
}
/// The four-term −92 dB window of [Harris 1978] over ±1.5, for 0 ≤ x ≤ 1.5.
fn blackman_harris(x: f64) -> f64 {
    let t = std::f64::consts::PI * x / 1.5;
    0.35875 + 0.48829 * libm::cos(t) + 0.14128 * libm::cos(2.0 * t) + 0.01168 * libm::cos(3.0 * t)
}

/// Number of cells of one half axis: 7·64, so that Mitchell's junction at 1 and its zero at 8/7 are at knots.
const CELLS: usize = 448;

/// Inverse of the cumulative |f| of one axis of an even filter, from a table in f64.
///
/// *Approximation*: |f| is interpolated linearly between knots. The applied filter differs from the named one by less
/// than 2e-5 of its peak. Its integral is exact, so that a constant image is unbiased.
struct Axis {
    radius: f64,
    /// |f| at the knots i·radius/CELLS, scaled so that the half axis integrates to 1.
    density: Vec<f64>,
    /// Integral of `density` from 0 to each knot; the last is 1.
    cdf: Vec<f64>,
    /// First cell in which f is negative.
    negative_from: usize,
    /// ∫|f| / ∫f of the interpolated filter.
    norm: f64,
}

impl Axis {
    fn new(radius: f64, f: fn(f64) -> f64) -> Self {
        let h = radius / CELLS as f64;
        let knots: Vec<f64> = (0..=CELLS).map(|i| f(i as f64 * h)).collect();
        let centre = |i: usize| f((i as f64 + 0.5) * h);
        let negative_from = (0..CELLS).find(|&i| centre(i) < 0.0).unwrap_or(CELLS);
        let mut cdf = vec![0.0];
        let (mut sum, mut positive) = (0.0, 0.0);
        for i in 0..CELLS {
            sum += 0.5 * h * (knots[i].abs() + knots[i + 1].abs());
            cdf.push(sum);
            if i < negative_from {
                positive = sum;
            }
        }
        let density = knots.iter().map(|k| k.abs() / sum).collect();
        cdf.iter_mut().for_each(|c| *c /= sum);
        Self { radius, density, cdf, negative_from, norm: sum / (2.0 * positive - sum) }
    }

    /// Returns the offset for u in \[0,1) and the factor of the weight. The lower half of u mirrors the upper half.
    fn sample(&self, u: f32) -> (f64, f64) {
        let v = 2.0 * u as f64 - 1.0;
        let a = v.abs();
        let i = self.cdf.partition_point(|&c| c <= a).clamp(1, CELLS) - 1;
        let h = self.radius / CELLS as f64;
        let (f0, f1) = (self.density[i], self.density[i + 1]);
        // Solves f0·t + (f1 − f0)·t²/2 = r for t in [0,1] without cancellation.
        let r = (a - self.cdf[i]) / h;
        let root = (f0 * f0 + 2.0 * (f1 - f0) * r).max(0.0).sqrt();
        let t = if r > 0.0 { (2.0 * r / (f0 + root)).min(1.0) } else { 0.0 };
        let sign = if i < self.negative_from { 1.0 } else { -1.0 };
        ((i as f64 + t) * h * if v < 0.0 { -1.0 } else { 1.0 }, sign * self.norm)
    }

    fn sample_2d(&self, u: Vec2) -> (Vec2, f32) {
        let ((x, wx), (y, wy)) = (self.sample(u.x), self.sample(u.y));
        (Vec2::new(x as f32, y as f32), (wx * wy) as f32)
    }
}

/// Errors of parsing a filter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FilterError {
    /// There is no filter of that name.
    Unknown(String),
    /// The radius of the box is not a number in (0, 64].
    Radius(String),
}
impl fmt::Display for FilterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(s) => {
                write!(
                    f,
                    "unknown filter '{s}': use box[:radius], tent, gaussian, mitchell or blackman-harris"
                )
            }
            Self::Radius(s) => {
                write!(f, "invalid box radius '{s}': give pixels above 0 and up to 64, e.g. box:0.5")
            }
        }
    }
}
impl std::error::Error for FilterError {}

impl FromStr for Filter {
    type Err = FilterError;
    fn from_str(s: &str) -> Result<Self, FilterError> {
        Ok(match s {
            "box" => Self::default(),
            "tent" => Self::Tent,
            "gaussian" => Self::Gaussian,
            "mitchell" => Self::Mitchell,
            "blackman-harris" => Self::BlackmanHarris,
            _ => {
                let r = s.strip_prefix("box:").ok_or_else(|| FilterError::Unknown(s.to_owned()))?;
                let radius = r.parse().ok().filter(|&r: &f32| r > 0.0 && r <= 64.0);
                Self::Box { radius: radius.ok_or_else(|| FilterError::Radius(r.to_owned()))? }
            }
        })
    }
}
impl fmt::Display for Filter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Box { radius: 0.5 } => "box",
            Self::Box { radius } => return write!(f, "box:{radius}"),
            Self::Tent => "tent",
            Self::Gaussian => "gaussian",
            Self::Mitchell => "mitchell",
            Self::BlackmanHarris => "blackman-harris",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for s in ["box", "box:0.75", "tent", "gaussian", "mitchell", "blackman-harris"] {
            assert_eq!(s.parse::<Filter>().unwrap().to_string(), s);
        }
        assert_eq!("box:0".parse::<Filter>(), Err(FilterError::Radius("0".into())));
        assert_eq!("box:nan".parse::<Filter>(), Err(FilterError::Radius("nan".into())));
        assert_eq!("sinc".parse::<Filter>(), Err(FilterError::Unknown("sinc".into())));
    }

    #[test]
    fn the_default_box_is_u_minus_a_half() {
        for i in 0..1u32 << 12 {
            let u =
                Vec2::new((i << 12) as f32 / (1 << 24) as f32, ((1 << 24) - 1 - i) as f32 / (1 << 24) as f32);
            assert_eq!(Filter::default().sample(u), (u - 0.5, 1.0));
        }
    }

    #[test]
    fn mitchell_norm_is_the_closed_form() {
        // ∫|f| = 367/343 on one axis, ∫f = 1.
        assert!((MITCHELL.norm - 367.0 / 343.0).abs() < 1e-5, "{}", MITCHELL.norm);
        assert_eq!(MITCHELL.negative_from, CELLS * 4 / 7);
        assert_eq!((GAUSSIAN.norm, BLACKMAN_HARRIS.norm), (1.0, 1.0));
    }
}
