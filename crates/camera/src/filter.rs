//! Pixel filters and their importance sampling.
//!
//! Filters are sampled instead of splatted: the film point is warped so that its density is the filter [Ernst 2006].
//! Every pixel then has its own independent samples, and a constant image stays constant. Filters with negative lobes
//! (Mitchell) are sampled by |f| with the weight sign(f)·∫|f|, whose mean is 1. All filters are separable.
use dapple_math::lanes::{Real, Vec2x, Word};
use dapple_sampling::Discrete;
use dapple_sampling::lanes::warp;
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
        let (offset, weight) = self.warp().sample::<f32>(u.into());
        (offset.into(), weight)
    }

    /// Returns the warp over lanes. It is made once, outside of the computation over lanes.
    #[inline]
    pub fn warp(&self) -> FilterWarp {
        FilterWarp(match *self {
            Self::Box { radius } => Shape::Box(radius),
            Self::Tent => Shape::Tent,
            Self::Gaussian => Shape::Table(&GAUSSIAN),
            Self::Mitchell => Shape::Table(&MITCHELL),
            Self::BlackmanHarris => Shape::Table(&BLACKMAN_HARRIS),
        })
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

/// The warp of a [`Filter`] over lanes.
#[derive(Clone, Copy)]
pub struct FilterWarp(Shape);

#[derive(Clone, Copy)]
enum Shape {
    Box(f32),
    Tent,
    Table(&'static Axis),
}

impl FilterWarp {
    /// Samples an offset from the pixel's centre and a weight per lane, as [`Filter::sample`] does.
    #[inline(always)]
    pub fn sample<R: Real>(&self, u: Vec2x<R>) -> (Vec2x<R>, R) {
        let one = R::splat(1.0);
        match self.0 {
            Shape::Box(radius) => (warp::square(u) * R::splat(radius), one),
            Shape::Tent => (Vec2x::new(warp::tent(u.x, one), warp::tent(u.y, one)), one),
            Shape::Table(axis) => {
                let ((x, a), (y, b)) = (axis.sample(u.x), axis.sample(u.y));
                (Vec2x::new(x, y), a * b)
            }
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

/// Inverse of the cumulative |f| of one axis of an even filter.
///
/// *Approximation*: |f| is interpolated linearly between knots. The applied filter differs from the named one by less
/// than 2e-5 of its peak. Its integral is exact, so that a constant image is unbiased.
struct Axis {
    radius: f32,
    /// Per cell the integral of |f| before it, in two parts, and |f| at both of its ends, for ∫|f| = 1 over the half axis
    /// and lengths in cells.
    rows: Vec<[f32; 4]>,
    /// The integrals of |f| over the cells. It is None for a filter that is zero everywhere, of which there is none.
    cells: Option<Discrete>,
    /// First cell in which f is negative.
    negative_from: u32,
    /// ∫|f| / ∫f of the interpolated filter.
    norm: f32,
}

impl Axis {
    fn new(radius: f64, f: fn(f64) -> f64) -> Self {
        let h = radius / CELLS as f64;
        let size: Vec<f64> = (0..=CELLS).map(|i| f(i as f64 * h).abs()).collect();
        let centre = |i: usize| f((i as f64 + 0.5) * h);
        let negative_from = (0..CELLS).find(|&i| centre(i) < 0.0).unwrap_or(CELLS);
        let cells: Vec<f64> = size.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
        let (sum, positive) = (cells.iter().sum::<f64>(), cells[..negative_from].iter().sum::<f64>());
        let mut before = 0.0;
        let mut row = |w: &[f64]| {
            let edge = before / sum;
            before += 0.5 * (w[0] + w[1]);
            let rest = edge - f64::from(edge as f32);
            [edge, rest, w[0] / sum, w[1] / sum].map(|x| x as f32)
        };
        Self {
            radius: radius as f32,
            rows: size.windows(2).map(&mut row).collect(),
            cells: Discrete::new(&cells),
            negative_from: negative_from as u32,
            norm: (sum / (2.0 * positive - sum)) as f32,
        }
    }

    /// Returns the offset for u in \[0,1) and the factor of the weight. The lower half of u mirrors the upper half.
    #[inline(always)]
    fn sample<R: Real>(&self, u: R) -> (R, R) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let v = u + u - one;
        let Some(cells) = &self.cells else { return (v, one) };
        let a = v.abs();
        let index = cells.index_lanes(a);
        let [edge, rest, f0, f1] = R::gather_rows(&self.rows, index);
        // Solves f0·t + (f1 − f0)·t²/2 = r for t in [0,1] without cancellation.
        let r = ((a - edge) - rest).max(zero);
        let r = r + r;
        let root = (f0 * f0 + (f1 - f0) * r).max(zero).sqrt();
        let t = R::select(r.gt(zero), (r / (f0 + root)).min(one), zero);
        let x = (index.int_to_real() + t) * R::splat(self.radius / CELLS as f32);
        let norm = R::splat(self.norm);
        let weight = R::select(index.lt(R::Word::splat(self.negative_from)), norm, -norm);
        (x.min(R::splat(self.radius)).copysign(v), weight)
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
        assert_eq!(MITCHELL.negative_from as usize, CELLS * 4 / 7);
        assert_eq!((GAUSSIAN.norm, BLACKMAN_HARRIS.norm), (1.0, 1.0));
    }
}
