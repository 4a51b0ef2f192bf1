//! Importance of eight clusters at once, over lanes: a lane is a cluster, and all lanes have the same receiver. With one
//! lane the compiler vectorises the loop over the clusters.
use crate::cluster::Bounds;
use dapple_math::lanes::{Mask, Real, Vec3x, Word};
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
    /// The axis, reversed.
    axis_x: [f32; LANES],
    axis_y: [f32; LANES],
    axis_z: [f32; LANES],
    /// Cosine and sine of θ_o; both 0 for all directions.
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
        cos_o: [0.0; LANES],
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
        let axis = -b.cone.axis.as_vec3();
        (self.axis_x[lane], self.axis_y[lane], self.axis_z[lane]) = (axis.x, axis.y, axis.z);
        // Widened by the rounding error of f32.
        let theta_o = b.cone.theta_o + 1e-6;
        let everywhere = theta_o >= PI;
        self.cos_o[lane] = if everywhere { 0.0 } else { libm::cos(theta_o) as f32 };
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
    #[inline(always)]
    pub fn weigh<R: Real>(&self, p: Vec3, n: Vec3) -> Weights {
        let weights =
            if n == Vec3::ZERO { self.weights::<R, false>(p, n) } else { self.weights::<R, true>(p, n) };
        let weights = Weights::new(weights, true);
        let reached = weights.sum() > 0.0 && weights.sum().is_finite();
        if reached { weights } else { self.by_intensity() }
    }

    #[cold]
    #[inline(never)]
    fn by_intensity(&self) -> Weights {
        Weights::new(self.intensity, false)
    }

    #[inline(always)]
    fn weights<R: Real, const NORMAL: bool>(&self, p: Vec3, n: Vec3) -> [f32; LANES] {
        let (p, n) = (Vec3x::<R>::splat(p), Vec3x::splat(n));
        let mut weights = [0.0; LANES];
        for k in 0..LANES.div_ceil(R::LANES) {
            let i = k * R::LANES;
            self.from::<R>(i).weight::<NORMAL>(p, n, R::Mask::splat(true)).store(&mut weights[i..]);
        }
        weights
    }

    /// The clusters from number `i` on.
    #[inline(always)]
    fn from<R: Real>(&self, i: usize) -> Cluster<R> {
        Cluster {
            centre: Vec3x::new(at(&self.x, i), at(&self.y, i), at(&self.z, i)),
            radius: at(&self.radius, i),
            axis: Vec3x::new(at(&self.axis_x, i), at(&self.axis_y, i), at(&self.axis_z, i)),
            cos_o: at(&self.cos_o, i),
            sin_o: at(&self.sin_o, i),
            cos_e: at(&self.cos_e, i),
            intensity: at(&self.intensity, i),
            sign_mask: R::Word::load(&self.sign_mask[i..]),
        }
    }

    /// The rows of a cluster for [`Cluster::of_rows`].
    pub fn rows(&self, lane: usize) -> [[f32; 4]; 3] {
        let two_sided = if self.sign_mask[lane] == u32::MAX { 0.0 } else { 1.0 };
        [
            [self.x[lane], self.y[lane], self.z[lane], self.radius[lane]],
            [self.axis_x[lane], self.axis_y[lane], self.axis_z[lane], self.cos_o[lane]],
            [self.sin_o[lane], self.cos_e[lane], self.intensity[lane], two_sided],
        ]
    }
}

/// One cluster per lane, as [`Lanes`] holds them.
pub(crate) struct Cluster<R: Real> {
    centre: Vec3x<R>,
    radius: R,
    axis: Vec3x<R>,
    cos_o: R,
    sin_o: R,
    cos_e: R,
    pub intensity: R,
    sign_mask: R::Word,
}

impl<R: Real> Cluster<R> {
    #[inline(always)]
    pub fn of_rows([a, b, c]: [[R; 4]; 3]) -> Self {
        let two_sided = c[3].gt(R::splat(0.0));
        Self {
            centre: Vec3x::new(a[0], a[1], a[2]),
            radius: a[3],
            axis: Vec3x::new(b[0], b[1], b[2]),
            cos_o: b[3],
            sin_o: c[0],
            cos_e: c[1],
            intensity: c[2],
            sign_mask: R::Word::select(two_sided, R::Word::splat(u32::MAX >> 1), R::Word::splat(u32::MAX)),
        }
    }

    /// Weights for receivers at `p` with normals `n` in the lanes of `has_normal`, where `NORMAL` allows for any: see
    /// [`Lanes::weigh`]. Angles at the light and at the receiver are held as their cosines and sines times the distance
    /// d, so that no length has to be divided by.
    #[inline(always)]
    pub fn weight<const NORMAL: bool>(&self, p: Vec3x<R>, n: Vec3x<R>, has_normal: R::Mask) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let Vec3x { x, y, z } = self.centre - p;
        let d2 = (x * x + y * y + z * z).max(R::splat(LEAST));
        let radius = self.radius;
        let r2 = radius * radius;
        let outside = r2.lt(d2);
        let cos_u = (d2 - r2).max(zero).sqrt();
        let along = self.axis.x * x + self.axis.y * y + self.axis.z * z;
        let cos = R::from_bits(along.to_bits() & self.sign_mask);
        let sin = (d2 - cos * cos).max(zero).sqrt();
        // θ − θ_o, then minus θ_u. Each is 0 instead of negative.
        let (cos_o, sin_o) = (self.cos_o, self.sin_o);
        let (cos, sin) = (cos * cos_o + sin * sin_o, sin * cos_o - cos * sin_o);
        let within = sin.le(zero) | cos_u.le(cos);
        let emitted = R::select(within, d2, cos * cos_u + sin * radius);
        let emits = (self.cos_e * d2).le(emitted);
        let emitted = R::select(emits, emitted.max(zero), zero);
        let per = one / d2.max(r2);
        let share = self.intensity * per;
        let mut cosines = emitted * per;
        if NORMAL {
            let cos = n.x * x + n.y * y + n.z * z;
            let sin = (d2 - cos * cos).max(zero).sqrt();
            let received = R::select(cos_u.le(cos), d2, (cos * cos_u + sin * radius).max(zero));
            cosines *= R::select(has_normal, received * per, one);
        }
        share * R::select(outside, cosines, one)
    }
}

/// Reads one lane per cluster from number `i` on.
#[inline(always)]
fn at<R: Real>(from: &[f32; LANES], i: usize) -> R {
    R::load(&from[i..])
}

/// Weights of eight lanes, not all 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    weights: [f32; LANES],
    /// 0, and the sums of the first one to eight weights.
    sums: [f64; LANES + 1],
    /// Whether these are importances; otherwise they are intensities, because no lane reaches the receiver.
    reached: bool,
}

impl Weights {
    #[inline(always)]
    fn new(weights: [f32; LANES], reached: bool) -> Self {
        let mut sums = [0.0; LANES + 1];
        for (i, w) in weights.iter().enumerate() {
            sums[i + 1] = sums[i] + f64::from(*w);
        }
        Self { weights, sums, reached }
    }

    #[inline(always)]
    fn sum(&self) -> f64 {
        self.sums[LANES]
    }

    /// Estimate of the irradiance that all lanes could send, in the unit of their intensity.
    #[inline(always)]
    pub fn importance(&self) -> f64 {
        if self.reached { self.sum() } else { 0.0 }
    }

    /// Probability of a lane.
    #[inline(always)]
    pub fn share(&self, lane: usize) -> f64 {
        f64::from(self.weights[lane % LANES]) / self.sum()
    }

    /// Selects a lane: returns it, its probability as given by [`Weights::share`], and u rescaled to \[0,1).
    #[inline(always)]
    pub fn pick(&self, u: f64) -> (usize, f64, f64) {
        let target = u * self.sum();
        // The last sum exceeds the target, and a lane of weight 0 ends where the one before it does.
        let mut chosen = 0;
        for end in &self.sums[1..LANES] {
            chosen += u32::from(*end <= target);
        }
        let chosen = chosen as usize % LANES;
        let rest = (target - self.sums[chosen]) / f64::from(self.weights[chosen]);
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
        let weight = |p, n| lanes.weigh::<f32>(p, n).weights[3];
        assert_eq!(weight(Vec3::ZERO, Vec3::ZERO), 0.75);
        assert!((weight(Vec3::ZERO, Vec3::new(0.6, 0.0, 0.8)) - 0.6).abs() < 1e-6);
        assert_eq!(weight(Vec3::ZERO, Vec3::NEG_Z), 3.0, "behind the receiver: the intensity");
        assert_eq!(lanes.weigh::<f32>(Vec3::ZERO, Vec3::NEG_Z).importance(), 0.0);
        for p in [p, Vec3::splat(1e30), Vec3::NAN] {
            let weights = lanes.weigh::<f32>(p, Vec3::Z);
            assert!(weights.sum() > 0.0 && weights.sum().is_finite());
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
            assert!(lanes.weigh::<f32>(p, n).weights[3] >= far * (1.0 - 1e-5));
        }
        let behind = Vec3::Z * 9.0;
        assert_eq!(lanes.weights::<f32, false>(behind, Vec3::ZERO), [0.0; LANES]);
        assert!(lone(&Light::Area(area(true))).weights::<f32, false>(behind, Vec3::ZERO)[3] > 0.0);
    }

    #[test]
    fn picking_follows_the_shares() {
        let weights = [0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 5.0, 0.0];
        let weights = Weights::new(weights, true);
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
