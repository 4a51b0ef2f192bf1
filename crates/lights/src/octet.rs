//! Importance of eight clusters at once, in loops over arrays that the compiler vectorises. Every lane is computed
//! independently, so the results are bitwise identical on every machine.
use crate::cluster::Bounds;
use glam::Vec3;
use std::f64::consts::PI;

pub(crate) const LANES: usize = 8;

/// Bounds of eight clusters; unused lanes have intensity 0.
#[derive(Clone, Debug)]
pub(crate) struct Lanes {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    /// Radius of the bounding sphere of the box.
    radius: [f32; LANES],
    axis_x: [f32; LANES],
    axis_y: [f32; LANES],
    axis_z: [f32; LANES],
    /// Cosine of θ_o; −2 for all directions.
    cos_o: [f32; LANES],
    sin_o: [f32; LANES],
    cos_e: [f32; LANES],
    intensity: [f32; LANES],
    /// Mask that clears the sign of the cosine to the axis of two-sided clusters.
    sign_mask: [u32; LANES],
}

/// Minimum squared distance, which keeps the sum of eight weights finite. (Intensities are at most 2.)
const LEAST: f32 = 1e-36;

impl Lanes {
    pub const EMPTY: Self = Self {
        x: [0.0; LANES],
        y: [0.0; LANES],
        z: [0.0; LANES],
        radius: [0.0; LANES],
        axis_x: [0.0; LANES],
        axis_y: [0.0; LANES],
        axis_z: [0.0; LANES],
        cos_o: [-2.0; LANES],
        sin_o: [0.0; LANES],
        cos_e: [0.0; LANES],
        intensity: [0.0; LANES],
        sign_mask: [u32::MAX; LANES],
    };

    /// Stores a cluster; its intensity is in units of `unit`.
    pub fn set(&mut self, lane: usize, b: &Bounds, unit: f64) {
        let centre = b.centre();
        (self.x[lane], self.y[lane], self.z[lane]) = (centre.x, centre.y, centre.z);
        self.radius[lane] = b.radius() as f32;
        let axis = b.cone.axis.as_vec3();
        (self.axis_x[lane], self.axis_y[lane], self.axis_z[lane]) = (axis.x, axis.y, axis.z);
        // Widened by the rounding error of f32.
        let theta_o = b.cone.theta_o + 1e-6;
        let everywhere = theta_o >= PI;
        self.cos_o[lane] = if everywhere { -2.0 } else { libm::cos(theta_o) as f32 };
        self.sin_o[lane] = if everywhere { 0.0 } else { libm::sin(theta_o) as f32 };
        self.cos_e[lane] = libm::cos(b.cone.theta_e) as f32 - 1e-6;
        self.intensity[lane] = ((b.intensity / unit) as f32).max(f32::MIN_POSITIVE);
        self.sign_mask[lane] = if b.cone.two_sided { u32::MAX >> 1 } else { u32::MAX };
    }

    /// Weights I·cosθ'·cosθ'ᵢ/d² with θ' = max(0, θ − θ_o − θ_u) (0 beyond θ_e) at the lights, θ'ᵢ = max(0, θᵢ − θ_u)
    /// at the receiver (omitted if `n` is zero), θ_u the half-angle of the bounding sphere, and d² at least the square
    /// of its radius [Conty Estevez and Kulla 2018, §4.2]. Inside the bounding sphere both cosines are 1. If all
    /// weights are 0, the intensities are used instead. Only products, ratios and roots of coordinates occur: scaling
    /// the scene by a power of two scales the weights by one.
    #[inline]
    pub fn weigh(&self, p: Vec3, n: Vec3) -> Weights {
        let weights = if n == Vec3::ZERO { self.weights::<false>(p, n) } else { self.weights::<true>(p, n) };
        let sum = sum(&weights);
        let reached = sum > 0.0 && sum.is_finite();
        if reached { Weights { weights, sum, reached } } else { self.by_intensity() }
    }

    fn by_intensity(&self) -> Weights {
        Weights { weights: self.intensity, sum: sum(&self.intensity), reached: false }
    }

    #[inline]
    fn weights<const NORMAL: bool>(&self, p: Vec3, n: Vec3) -> [f32; LANES] {
        let mut weights = [0.0; LANES];
        // Indexing lets the compiler prove that nothing is out of bounds and vectorise over the lanes.
        #[allow(clippy::needless_range_loop)]
        for i in 0..LANES {
            let (x, y, z) = (self.x[i] - p.x, self.y[i] - p.y, self.z[i] - p.z);
            let d2 = larger(x * x + y * y + z * z, LEAST);
            let per_d = 1.0 / d2.sqrt();
            let u = Angle::from_sin(smaller(self.radius[i] * per_d, 1.0));
            let along = -(self.axis_x[i] * x + self.axis_y[i] * y + self.axis_z[i] * z) * per_d;
            let theta = Angle::from_cos(f32::from_bits(along.to_bits() & self.sign_mask[i]));
            let cone = Angle { cos: self.cos_o[i], sin: self.sin_o[i] };
            let rest = theta.minus(cone).minus(u).cos;
            let emitted = if rest >= self.cos_e[i] { larger(rest, 0.0) } else { 0.0 };
            let received = if NORMAL {
                larger(Angle::from_cos((n.x * x + n.y * y + n.z * z) * per_d).minus(u).cos, 0.0)
            } else {
                1.0
            };
            let r2 = self.radius[i] * self.radius[i];
            let cosines = if d2 <= r2 { 1.0 } else { emitted * received };
            weights[i] = self.intensity[i] * cosines / larger(d2, r2);
        }
        weights
    }
}

/// An angle in [0, π], represented by its cosine and sine.
#[derive(Clone, Copy)]
struct Angle {
    cos: f32,
    sin: f32,
}
impl Angle {
    #[inline(always)]
    fn from_cos(cos: f32) -> Self {
        let cos = smaller(cos, 1.0);
        Self { cos, sin: larger(1.0 - cos * cos, 0.0).sqrt() }
    }
    #[inline(always)]
    fn from_sin(sin: f32) -> Self {
        Self { cos: (1.0 - sin * sin).sqrt(), sin }
    }
    /// max(0, self − b).
    #[inline(always)]
    fn minus(self, b: Self) -> Self {
        let (cos, sin) = (self.cos * b.cos + self.sin * b.sin, self.sin * b.cos - self.cos * b.sin);
        let below = self.cos >= b.cos;
        Self { cos: if below { 1.0 } else { cos }, sin: if below { 0.0 } else { sin } }
    }
}

/// Like max and min, but one instruction each; return the second operand for NaN.
#[inline]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
#[inline]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

fn sum(weights: &[f32; LANES]) -> f64 {
    weights.iter().map(|w| *w as f64).sum()
}

/// Weights of eight lanes, not all 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    weights: [f32; LANES],
    sum: f64,
    /// Whether these are importances; otherwise they are intensities, because no lane reaches the receiver.
    reached: bool,
}

impl Weights {
    /// Estimate of the irradiance that all lanes could send, in the unit of their intensity.
    pub fn importance(&self) -> f64 {
        if self.reached { self.sum } else { 0.0 }
    }

    /// Probability of a lane.
    pub fn share(&self, lane: usize) -> f64 {
        self.weights[lane] as f64 / self.sum
    }

    /// Selects a lane: returns it, its probability as given by [`Weights::share`], and u rescaled to \[0,1).
    pub fn pick(&self, u: f64) -> (usize, f64, f64) {
        let target = u * self.sum;
        let (mut below, mut chosen, mut start) = (0.0, 0, 0.0);
        for (lane, w) in self.weights.iter().enumerate() {
            let w = *w as f64;
            if w > 0.0 {
                (chosen, start) = (lane, below);
                if target < below + w {
                    break;
                }
            }
            below += w;
        }
        let rest = (target - start) / self.weights[chosen] as f64;
        (chosen, self.share(chosen), rest.clamp(0.0, 1.0 - f64::EPSILON))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Area, AreaShape, Light, Point};

    fn lone(light: &Light) -> Lanes {
        let mut lanes = Lanes::EMPTY;
        lanes.set(3, &Bounds::of(light).unwrap(), 1.0);
        lanes
    }

    #[test]
    fn a_lone_point_is_inverse_square_and_cosine() {
        let p = Vec3::Z * 2.0;
        let lanes = lone(&Light::Point(Point { p, intensity: Vec3::splat(3.0), range: f32::INFINITY }));
        let weight = |p, n| lanes.weigh(p, n).weights[3];
        assert_eq!(weight(Vec3::ZERO, Vec3::ZERO), 0.75);
        assert!((weight(Vec3::ZERO, Vec3::new(0.6, 0.0, 0.8)) - 0.6).abs() < 1e-6);
        assert_eq!(weight(Vec3::ZERO, Vec3::NEG_Z), 3.0, "behind the receiver: the intensity");
        assert_eq!(lanes.weigh(Vec3::ZERO, Vec3::NEG_Z).importance(), 0.0);
        for p in [p, Vec3::splat(1e30), Vec3::NAN] {
            let weights = lanes.weigh(p, Vec3::Z);
            assert!(weights.sum > 0.0 && weights.sum.is_finite());
        }
    }

    #[test]
    fn importance_bounds_the_irradiance_of_flat_lights() {
        // I·cosθ'·cosθ'ᵢ/d² with clamped angles is never below the far-field value at the centre.
        let quad = AreaShape::Quad { corner: Vec3::new(-0.5, -0.5, 3.0), e1: Vec3::Y, e2: Vec3::X };
        let area = |two_sided| Area { shape: quad, radiance: Vec3::ONE, two_sided };
        let lanes = lone(&Light::Area(area(false)));
        for (p, n) in [(Vec3::ZERO, Vec3::Z), (Vec3::X * 3.0, Vec3::new(-0.6, 0.0, 0.8))] {
            let v = Vec3::Z * 3.0 - p;
            let far = (v.z / v.length()) * n.dot(v) / v.length() / v.length_squared();
            assert!(lanes.weigh(p, n).weights[3] >= far * (1.0 - 1e-5));
        }
        let behind = Vec3::Z * 9.0;
        assert_eq!(lanes.weights::<false>(behind, Vec3::ZERO), [0.0; LANES]);
        assert!(lone(&Light::Area(area(true))).weights::<false>(behind, Vec3::ZERO)[3] > 0.0);
    }

    #[test]
    fn picking_follows_the_shares() {
        let weights = [0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 5.0, 0.0];
        let weights = Weights { weights, sum: sum(&weights), reached: true };
        let mut counts = [0; LANES];
        for k in 0..8000 {
            let (lane, share, rest) = weights.pick((k as f64 + 0.5) / 8000.0);
            counts[lane] += 1;
            assert_eq!(share, weights.share(lane));
            assert!((0.0..1.0).contains(&rest));
        }
        assert_eq!(counts, [0, 1000, 0, 2000, 0, 0, 5000, 0]);
    }
}
