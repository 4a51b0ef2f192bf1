//! Key-framed quantities with the three interpolations of glTF \[glTF 2.0, app. C\], evaluated in f64.
//!
//! The value before the first key is that of the first key, and the value after the last key is that of the last.
//! Rotations are unit quaternions. LINEAR interpolates them along the short arc between adjacent keys, so that a
//! rotation by more than 180° needs several keys; CUBICSPLINE interpolates the four components and normalizes the
//! result.
use glam::{DQuat, DVec3};
use std::fmt;
use std::ops::{Add, Mul};

/// Interpolation between keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The value of the preceding key.
    Step,
    /// Linear interpolation, for rotations along the short arc.
    Linear,
    /// Hermite spline. Each key has an in-tangent, a value and an out-tangent.
    CubicSpline,
}

/// Types that can be key-framed: translations and scales ([`DVec3`]) and rotations ([`DQuat`]).
pub trait Value: Copy + PartialEq + fmt::Debug + Add<Output = Self> + Mul<f64, Output = Self> {
    /// The zero tangent.
    const ZERO: Self;
    /// Interpolates from `self` at s = 0 to `other` at s = 1.
    fn between(self, other: Self, s: f64) -> Self;
    /// Normalizes a rotation to a unit quaternion; one without a direction becomes the identity. Translations and
    /// scales are returned unchanged.
    fn normalized(self) -> Self;
    /// Returns whether no component is infinite or NaN.
    fn is_finite(self) -> bool;
}

impl Value for DVec3 {
    const ZERO: Self = DVec3::ZERO;
    fn between(self, other: Self, s: f64) -> Self {
        self * (1.0 - s) + other * s
    }
    fn normalized(self) -> Self {
        self
    }
    fn is_finite(self) -> bool {
        DVec3::is_finite(self)
    }
}

impl Value for DQuat {
    const ZERO: Self = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    /// Slerp along the short arc with weights sin(a(1 − s))/sin a and ± sin(as)/sin a, where a = acos|q₀·q₁| is
    /// computed from the half chords (a = 2 atan2(|q₀ ∓ q₁|, |q₀ ± q₁|)), which keeps the precision of small angles.
    fn between(self, other: Self, s: f64) -> Self {
        let other = if self.dot(other) < 0.0 { -other } else { other };
        let a = 2.0 * libm::atan2(norm(self + other * -1.0), norm(self + other));
        // Below this angle, sine and angle agree to the last bit, and the quotient of sines could be 0/0.
        if a < 1e-8 {
            return (self * (1.0 - s) + other * s).normalized();
        }
        (self * (libm::sin(a * (1.0 - s)) / libm::sin(a)) + other * (libm::sin(a * s) / libm::sin(a)))
            .normalized()
    }
    fn normalized(self) -> Self {
        let length = norm(self);
        if length > 0.0 && length.is_finite() { self * (1.0 / length) } else { DQuat::IDENTITY }
    }
    fn is_finite(self) -> bool {
        DQuat::is_finite(self)
    }
}

fn norm(q: DQuat) -> f64 {
    q.dot(q).sqrt()
}

/// Reasons why keys do not form a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackError {
    /// There are no keys.
    Empty,
    /// The number of values does not match the number of keys (three values per key for CUBICSPLINE).
    Length,
    /// A time is not finite or not greater than the preceding one. Contains the index of the first such key.
    Times(usize),
    /// A value is not finite. Contains its index.
    Value(usize),
}

impl fmt::Display for TrackError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "no keys"),
            Self::Length => write!(f, "number of values does not match the number of keys"),
            Self::Times(i) => write!(f, "time of key {i} is not finite or not after the key before"),
            Self::Value(i) => write!(f, "value {i} is not finite"),
        }
    }
}

impl std::error::Error for TrackError {}

/// A quantity given at keys, with times in seconds.
#[derive(Clone, Debug, PartialEq)]
pub struct Track<T> {
    times: Vec<f64>,
    values: Vec<T>,
    interpolation: Interpolation,
}

impl<T: Value> Track<T> {
    /// Creates a track from keys in increasing order of time, with three values per key (in-tangent, value,
    /// out-tangent) for CUBICSPLINE and one otherwise. Fails as described at [`TrackError`].
    pub fn new(times: Vec<f64>, values: Vec<T>, interpolation: Interpolation) -> Result<Self, TrackError> {
        let cubic = interpolation == Interpolation::CubicSpline;
        if times.is_empty() {
            return Err(TrackError::Empty);
        }
        if values.len() != times.len() * if cubic { 3 } else { 1 } {
            return Err(TrackError::Length);
        }
        let bad = (0..times.len()).find(|&i| !times[i].is_finite() || (i > 0 && times[i] <= times[i - 1]));
        if let Some(i) = bad {
            return Err(TrackError::Times(i));
        }
        if let Some(i) = values.iter().position(|v| !v.is_finite()) {
            return Err(TrackError::Value(i));
        }
        let values = if cubic { values } else { values.into_iter().map(T::normalized).collect() };
        Ok(Self { times, values, interpolation })
    }

    /// Returns the value at `time`. Outside the range of the keys it is the value of the nearest key.
    pub fn at(&self, time: f64) -> T {
        let last = self.times.len() - 1;
        // NaN counts as a time before the first key.
        if time.is_nan() || time <= self.times[0] {
            return self.key(0).normalized();
        }
        if time >= self.times[last] {
            return self.key(last).normalized();
        }
        let (i, s) = self.locate(time);
        match self.interpolation {
            Interpolation::Step => self.key(i),
            Interpolation::Linear => self.key(i).between(self.key(i + 1), s),
            Interpolation::CubicSpline => self.hermite(i, s).normalized(),
        }
    }

    /// Returns whether the value is constant over \[open, close\].
    pub fn is_constant_within(&self, open: f64, close: f64) -> bool {
        let (first, last) = self.keys_around(open, close);
        let still = |i: usize| {
            let resting = self.interpolation != Interpolation::CubicSpline
                || (self.values[3 * i] == T::ZERO && self.values[3 * i + 2] == T::ZERO);
            self.key(i) == self.key(first) && resting
        };
        let reached = match self.interpolation {
            // The last of these keys only has an effect when the interval reaches it.
            Interpolation::Step if last > first && self.times[last] > close => last - 1,
            _ => last,
        };
        first == reached || (first..=reached).all(still)
    }

    /// Returns the times of the keys strictly inside (open, close).
    pub fn keys_within(&self, open: f64, close: f64) -> &[f64] {
        let from = self.times.partition_point(|&t| t <= open);
        let to = self.times.partition_point(|&t| t < close);
        &self.times[from..to.max(from)]
    }

    /// Returns the indices of the first and last key that affect the values in \[open, close\].
    fn keys_around(&self, open: f64, close: f64) -> (usize, usize) {
        let last = self.times.len() - 1;
        let first = self.times.partition_point(|&t| t <= open).saturating_sub(1);
        let end = self.times.partition_point(|&t| t < close).min(last);
        // The value is constant before the first key and after the last key.
        (first, if close <= self.times[0] { 0 } else { end.max(first) })
    }

    /// Returns the Bézier control points, before normalization, of the part \[s0, s1\] of segment `i`. The curve stays
    /// in their convex hull.
    pub(super) fn control_points(&self, i: usize, s0: f64, s1: f64) -> [T; 4] {
        let third = (s1 - s0) / 3.0;
        let (a, b) = (self.hermite(i, s0), self.hermite(i, s1));
        [a, a + self.slope(i, s0) * third, b + self.slope(i, s1) * -third, b]
    }

    /// Returns the segments that overlap [open, close], each with its overlapping part \[s0, s1\].
    pub(super) fn segments(&self, open: f64, close: f64) -> impl Iterator<Item = (usize, f64, f64)> + '_ {
        let (first, last) = self.keys_around(open, close);
        (first..last).map(move |i| {
            let (t0, t1) = (self.times[i], self.times[i + 1]);
            let part = |t: f64| ((t - t0) / (t1 - t0)).clamp(0.0, 1.0);
            (i, part(open), part(close))
        })
    }

    /// Returns the values of the keys: three per key for CUBICSPLINE (in-tangent, value, out-tangent), otherwise one.
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// Returns the interpolation between keys.
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    fn locate(&self, time: f64) -> (usize, f64) {
        let i = self.times.partition_point(|&t| t <= time) - 1;
        (i, (time - self.times[i]) / (self.times[i + 1] - self.times[i]))
    }

    fn key(&self, i: usize) -> T {
        match self.interpolation {
            Interpolation::CubicSpline => self.values[3 * i + 1],
            _ => self.values[i],
        }
    }

    /// Evaluates (2s³ − 3s² + 1) vₖ + Δ(s³ − 2s² + s) bₖ + (3s² − 2s³) vₖ₊₁ + Δ(s³ − s²) aₖ₊₁, where Δ is the time
    /// between the keys \[glTF 2.0, app. C.5\].
    fn hermite(&self, i: usize, s: f64) -> T {
        let (s2, s3) = (s * s, s * s * s);
        self.blend(i, [2.0 * s3 - 3.0 * s2 + 1.0, s3 - 2.0 * s2 + s, 3.0 * s2 - 2.0 * s3, s3 - s2])
    }

    /// Returns the derivative of [`Track::hermite`] with respect to s.
    fn slope(&self, i: usize, s: f64) -> T {
        let s2 = s * s;
        self.blend(i, [6.0 * s2 - 6.0 * s, 3.0 * s2 - 4.0 * s + 1.0, 6.0 * s - 6.0 * s2, 3.0 * s2 - 2.0 * s])
    }

    fn blend(&self, i: usize, w: [f64; 4]) -> T {
        let dt = self.times[i + 1] - self.times[i];
        let (out, into) = (self.values[3 * i + 2], self.values[3 * i + 3]);
        self.key(i) * w[0] + out * (w[1] * dt) + self.key(i + 1) * w[2] + into * (w[3] * dt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn x(v: f64) -> DVec3 {
        DVec3::new(v, 0.0, 0.0)
    }

    #[test]
    fn step_linear_and_the_ends() {
        let track = |i| Track::new(vec![1.0, 2.0, 4.0], vec![x(0.0), x(10.0), x(-10.0)], i).unwrap();
        let step = track(Interpolation::Step);
        assert_eq!(
            [0.0, 1.0, 1.999, 2.0, 3.9, 4.0, 9.0].map(|t| step.at(t).x),
            [0.0, 0.0, 0.0, 10.0, 10.0, -10.0, -10.0]
        );
        let linear = track(Interpolation::Linear);
        assert_eq!(
            [0.0, 1.5, 2.0, 3.0, 4.0, f64::NAN].map(|t| linear.at(t).x),
            [0.0, 5.0, 10.0, 0.0, -10.0, 0.0]
        );
    }

    #[test]
    fn a_spline_reproduces_a_cubic() {
        let p = |t: f64| 2.0 * t * t * t - t * t + 3.0 * t - 4.0;
        let dp = |t: f64| 6.0 * t * t - 2.0 * t + 3.0;
        let times = vec![-1.0, 0.5, 3.0];
        let values = times.iter().flat_map(|&t| [x(dp(t)), x(p(t)), x(dp(t))]).collect();
        let track = Track::new(times, values, Interpolation::CubicSpline).unwrap();
        for i in 0..=40 {
            let t = -1.0 + 0.1 * i as f64;
            assert!((track.at(t).x - p(t)).abs() < 1e-12 * (1.0 + p(t).abs()), "{t}");
        }
    }

    #[test]
    fn rotations_take_the_short_arc_at_constant_speed() {
        let q = |deg: f64| {
            DQuat::from_xyzw(0.0, libm::sin(deg.to_radians() / 2.0), 0.0, libm::cos(deg.to_radians() / 2.0))
        };
        for (from, to, middle) in
            [(0.0, 90.0, 45.0), (10.0, -170.0 + 0.5, -79.75), (350.0, 370.0, 360.0), (0.0, 1e-7, 5e-8)]
        {
            // A quaternion and its negative are the same rotation, so the sign must have no effect.
            for sign in [1.0, -1.0] {
                let track =
                    Track::new(vec![0.0, 1.0], vec![q(from), q(to) * sign], Interpolation::Linear).unwrap();
                for s in [0.0, 0.25, 0.5, 1.0] {
                    let expected = q(from + (middle - from) * 2.0 * s);
                    assert!((track.at(s).dot(expected).abs() - 1.0).abs() < 1e-14, "{from} {to} {s}");
                }
            }
        }
    }

    #[test]
    fn spline_rotations_are_unit() {
        let z = DQuat::ZERO;
        let values = vec![z, DQuat::IDENTITY, z, z, DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0), z];
        let track = Track::new(vec![0.0, 1.0], values, Interpolation::CubicSpline).unwrap();
        for i in 0..=10 {
            assert!((norm(track.at(i as f64 / 10.0)) - 1.0).abs() < 1e-15);
        }
        assert!((track.at(0.5).z - 0.5f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn keys_that_are_no_track_are_named() {
        let new = |t: Vec<f64>, n: usize| Track::new(t, vec![x(0.0); n], Interpolation::Linear).err();
        assert_eq!(new(vec![], 0), Some(TrackError::Empty));
        assert_eq!(new(vec![0.0], 2), Some(TrackError::Length));
        assert_eq!(new(vec![0.0, 0.0], 2), Some(TrackError::Times(1)));
        assert_eq!(new(vec![f64::NAN], 1), Some(TrackError::Times(0)));
        assert_eq!(
            Track::new(vec![0.0], vec![DVec3::NAN], Interpolation::Step).err(),
            Some(TrackError::Value(0))
        );
    }

    #[test]
    fn constancy_is_about_the_interval() {
        let values = vec![x(1.0), x(1.0), x(2.0)];
        let linear = Track::new(vec![0.0, 1.0, 2.0], values.clone(), Interpolation::Linear).unwrap();
        assert!(linear.is_constant_within(-5.0, 1.0));
        assert!(!linear.is_constant_within(0.5, 1.5));
        assert!(!linear.is_constant_within(1.2, 1.3));
        assert!(linear.is_constant_within(2.0, 9.0));
        let step = Track::new(vec![0.0, 1.0, 2.0], values, Interpolation::Step).unwrap();
        assert!(step.is_constant_within(0.0, 1.99));
        assert!(!step.is_constant_within(0.0, 2.0));
        let single = Track::new(vec![3.0], vec![x(1.0)], Interpolation::Linear).unwrap();
        assert!(single.is_constant_within(0.0, 9.0));
    }
}
