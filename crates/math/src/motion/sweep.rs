//! Bounding boxes of moving objects over a time interval, conservative for any number of turns.
//!
//! The interval is split at the keys and, where something rotates, into steps of at most 1/16 of half a turn. Over a
//! step every link maps a box to a box. Scales and translations use the ranges of their values. A rotation along one
//! arc uses the union of the boxes at its two ends, padded by the sagitta r(1 − cos(Δθ/2)) of the arc over its chord.
use super::links::Motion;
use super::node::{Channel, Link, Trs};
use super::pose::transformed;
use super::track::{Interpolation, Track, Value};
use crate::Aabb;
use glam::{DAffine3, DQuat, DVec3};
use std::f64::consts::PI;

/// Maximum number of steps. Beyond it, steps are longer and the bounds are looser, but still conservative.
const MAX_STEPS: usize = 4096;
/// Largest rotation angle per step, in radians.
const ARC: f64 = PI / 16.0;
/// Steps per segment of a rotation spline.
const SPLINE_STEPS: usize = 32;

impl Motion {
    /// Returns the corners of a render-space box that contains the object-space box from `lo` to `hi` at all times from
    /// `open` to `close` (seconds after the shutter opens).
    pub fn bounds(&self, lo: DVec3, hi: DVec3, open: f64, close: f64) -> (DVec3, DVec3) {
        let swept = self.bounds_within(Aabb::new(lo, hi), open, close);
        (swept.lo, swept.hi)
    }

    /// Returns the number of steps that [`Motion::bounds`] splits the interval into, which determines its cost.
    pub fn step_count(&self, open: f64, close: f64) -> usize {
        self.steps(self.offset + open, self.offset + close).len() - 1
    }

    /// Returns the render-space box that contains the object-space box `local` at all times from `open` to `close`
    /// (seconds after the shutter opens).
    pub fn bounds_within(&self, local: Aabb, open: f64, close: f64) -> Aabb {
        let times = self.steps(self.offset + open, self.offset + close);
        let over = |t: &[f64]| self.links.iter().rev().fold(local, |b, link| link.bounds(b, t[0], t[1]));
        times.windows(2).map(over).fold(Aabb::EMPTY, Aabb::union)
    }

    /// Returns the absolute times that separate the steps, including both ends.
    fn steps(&self, open: f64, close: f64) -> Vec<f64> {
        let mut times = vec![open, close];
        for link in &self.links {
            if let Link::Moving(trs) = link {
                trs.cut(open, close, &mut times);
            }
            if times.len() > MAX_STEPS {
                let step = (close - open) / MAX_STEPS as f64;
                return (0..=MAX_STEPS).map(|i| (open + step * i as f64).min(close)).chain([close]).collect();
            }
        }
        times.sort_unstable_by(f64::total_cmp);
        times.dedup();
        if times.len() == 1 { vec![open, open] } else { times }
    }
}

impl Link {
    fn bounds(&self, b: Aabb, open: f64, close: f64) -> Aabb {
        match self {
            Self::Still(still) => transformed(&still.0, b),
            Self::Moving(trs) => trs.bounds(b, open, close),
        }
    }
}

impl Trs {
    fn cut(&self, open: f64, close: f64, times: &mut Vec<f64>) {
        fn keys<T: Value>(channel: &Channel<T>, open: f64, close: f64, times: &mut Vec<f64>) {
            if let Channel::Track(track) = channel {
                let keys = track.keys_within(open, close);
                times.extend_from_slice(&keys[..keys.len().min(MAX_STEPS + 1)]);
            }
        }
        keys(&self.translation, open, close, times);
        keys(&self.rotation, open, close, times);
        keys(&self.scale, open, close, times);
        if let Channel::Track(track) = &self.rotation
            && times.len() <= MAX_STEPS
        {
            times.extend(track.arcs(open, close));
        }
    }

    fn bounds(&self, b: Aabb, open: f64, close: f64) -> Aabb {
        let (s_lo, s_hi) = self.scale.range(open, close);
        let products = [b.lo * s_lo, b.lo * s_hi, b.hi * s_lo, b.hi * s_hi];
        let scaled = products.iter().fold(Aabb::EMPTY, |a, &p| a.union(Aabb::new(p, p)));
        let turned = self.rotation.turn(scaled, open, close);
        let (t_lo, t_hi) = self.translation.range(open, close);
        Aabb::new(turned.lo + t_lo, turned.hi + t_hi)
    }
}

impl Channel<DVec3> {
    /// Returns the minimum and maximum per component from `open` to `close`.
    fn range(&self, open: f64, close: f64) -> (DVec3, DVec3) {
        let track = match self {
            Self::Constant(v) => return (*v, *v),
            Self::Track(track) => track,
        };
        let (a, b) = (track.at(open), track.at(close));
        let mut hull = (a.min(b), a.max(b));
        let mut add = |v: DVec3| hull = (hull.0.min(v), hull.1.max(v));
        if track.interpolation() == Interpolation::CubicSpline {
            track.segments(open, close).for_each(|(i, s0, s1)| {
                track.control_points(i, s0, s1).into_iter().for_each(&mut add);
            });
        } else {
            track.keys_within(open, close).iter().for_each(|&t| add(track.at(t)));
        }
        hull
    }
}

impl Channel<DQuat> {
    /// Returns a box that contains the rotating box `b` from `open` to `close`.
    fn turn(&self, b: Aabb, open: f64, close: f64) -> Aabb {
        let turned = |q: DQuat| transformed(&DAffine3::from_quat(q), b);
        let track = match self {
            Self::Constant(q) => return turned(q.normalized()),
            Self::Track(track) => track,
        };
        let r = b.reach();
        let ball = Aabb::new(DVec3::splat(-r), DVec3::splat(r));
        let over = |t: &[f64]| match track.deviation(t[0], t[1]) {
            Some(bulge) => turned(track.at(t[0])).union(turned(track.at(t[1]))).padded(r * bulge),
            None => ball,
        };
        track.arcs(open, close).windows(2).map(over).fold(Aabb::EMPTY, Aabb::union)
    }
}

impl Track<DQuat> {
    /// Returns the largest distance of a point at radius 1 from the chord between its positions at `open` and `close`,
    /// between which there is no key. It is None when the path cannot be bounded.
    fn deviation(&self, open: f64, close: f64) -> Option<f64> {
        let Some((i, s0, s1)) = self.segments(open, close).next() else { return Some(0.0) };
        match self.interpolation() {
            Interpolation::Step => Some(0.0),
            // Δθ/2 is the angle between the quaternions, whose cosine is their product.
            Interpolation::Linear => Some(1.0 - self.at(open).dot(self.at(close)).abs().min(1.0)),
            Interpolation::CubicSpline => {
                let c = self.control_points(i, s0, s1);
                let length = |q: DQuat| q.dot(q).sqrt();
                let apart = |a: DQuat, b: DQuat| length(a + b * -1.0);
                let speed = (0..3).map(|k| 3.0 * apart(c[k], c[k + 1])).fold(0.0, f64::max);
                let least = length(c[0]) - (1..4).map(|k| apart(c[0], c[k])).fold(0.0, f64::max);
                // The angular speed is at most 2|q̇|/|q|, and the nearer end is at most half of the step away.
                (least > 0.0).then(|| speed / least)
            }
        }
    }

    /// Returns the times that split the interval at the keys and into arcs of at most [`ARC`]. Both ends are included,
    /// so that there are at least two times.
    fn arcs(&self, open: f64, close: f64) -> Vec<f64> {
        let mut times = vec![open];
        for &end in self.keys_within(open, close).iter().chain([&close]) {
            let start = times[times.len() - 1];
            let pieces = self.pieces(start, end);
            times.extend((1..pieces).map(|k| start + (end - start) * k as f64 / pieces as f64));
            times.push(end);
        }
        times
    }

    fn pieces(&self, from: f64, to: f64) -> usize {
        match self.interpolation() {
            Interpolation::Step => 1,
            Interpolation::CubicSpline if to > from => SPLINE_STEPS,
            Interpolation::CubicSpline => 1,
            Interpolation::Linear => {
                let half = libm::acos(self.at(from).dot(self.at(to)).abs().min(1.0));
                libm::ceil(2.0 * half / ARC) as usize
            }
        }
    }
}
