//! Animated translations, rotations and scales, evaluated at one time (glTF 2.0 appendix C).
//!
//! Outside its keys a track keeps its first or last value. When several animations of a file move the same property
//! of a node, the first one counts.
use super::document::{Document, label};
use crate::SceneError;
use glam::{DQuat, DVec3, DVec4};
use gltf::json::{
    self, Index,
    animation::{Interpolation, Property},
    validation::Checked,
};

/// One animated property: keys over time in seconds.
#[derive(Clone, Debug)]
pub(super) struct Track {
    times: Vec<f64>,
    /// One per key; three (in-tangent, value, out-tangent) for cubic splines. Vectors have w = 0.
    values: Vec<DVec4>,
    interpolation: Interpolation,
    /// Values are unit quaternions.
    rotates: bool,
}

/// The tracks of one node.
#[derive(Clone, Debug, Default)]
pub(super) struct Tracks {
    pub translation: Option<Track>,
    pub rotation: Option<Track>,
    pub scale: Option<Track>,
}

impl Track {
    /// Value at a time.
    fn at(&self, time: f64) -> DVec4 {
        let next = self.times.partition_point(|t| *t <= time);
        let value = if next == 0 {
            self.value(0)
        } else if next == self.times.len() {
            self.value(next - 1)
        } else {
            let span = self.times[next] - self.times[next - 1];
            self.between(next - 1, (time - self.times[next - 1]) / span, span)
        };
        if self.rotates { value.normalize_or(DVec4::W) } else { value }
    }

    fn value(&self, key: usize) -> DVec4 {
        let cubic = self.interpolation == Interpolation::CubicSpline;
        self.values[if cubic { 3 * key + 1 } else { key }]
    }

    /// Between a key and the next: `u` in [0, 1) of their distance `span` in seconds.
    fn between(&self, key: usize, u: f64, span: f64) -> DVec4 {
        let (a, b) = (self.value(key), self.value(key + 1));
        match self.interpolation {
            Interpolation::Step => a,
            Interpolation::Linear if self.rotates => slerp(a, b, u),
            Interpolation::Linear => a * (1.0 - u) + b * u,
            Interpolation::CubicSpline => {
                let (out_of_a, into_b) = (self.values[3 * key + 2] * span, self.values[3 * key + 3] * span);
                let (u2, u3) = (u * u, u * u * u);
                a * (2.0 * u3 - 3.0 * u2 + 1.0)
                    + out_of_a * (u3 - 2.0 * u2 + u)
                    + b * (3.0 * u2 - 2.0 * u3)
                    + into_b * (u3 - u2)
            }
        }
    }

    /// A translation or scale.
    pub fn vector(&self, time: f64) -> DVec3 {
        self.at(time).truncate()
    }

    /// A rotation.
    pub fn quaternion(&self, time: f64) -> DQuat {
        DQuat::from_vec4(self.at(time))
    }
}

/// Great arc between unit quaternions, the short way. The angle comes from atan2 of chord lengths, which is exact for
/// small and for nearly opposite rotations alike.
fn slerp(a: DVec4, b: DVec4, u: f64) -> DVec4 {
    let b = if a.dot(b) < 0.0 { -b } else { b };
    let angle = 2.0 * libm::atan2((a - b).length(), (a + b).length());
    let sin = libm::sin(angle);
    if sin < 1e-12 {
        return a * (1.0 - u) + b * u;
    }
    a * (libm::sin((1.0 - u) * angle) / sin) + b * (libm::sin(u * angle) / sin)
}

/// The tracks of all nodes, by node index.
pub(super) fn tracks(doc: &Document<'_>) -> Result<Vec<Tracks>, SceneError> {
    let mut nodes = vec![Tracks::default(); doc.root.nodes.len()];
    for (i, animation) in doc.root.animations.iter().enumerate() {
        let place = label("animation", i, animation.name.as_deref());
        let mut hidden = false;
        for channel in &animation.channels {
            doc.get(&doc.root.nodes, channel.target.node, "node", &place)?;
            let tracks = &mut nodes[channel.target.node.value()];
            let (slot, rotates) = match channel.target.path {
                Checked::Valid(Property::Translation) => (&mut tracks.translation, false),
                Checked::Valid(Property::Rotation) => (&mut tracks.rotation, true),
                Checked::Valid(Property::Scale) => (&mut tracks.scale, false),
                _ => continue,
            };
            if slot.is_some() {
                hidden = true;
                continue;
            }
            *slot = Some(track(doc, animation, channel.sampler, rotates, &place)?);
        }
        if hidden {
            doc.warn(format!("{place} moves what an earlier animation moves already; there it is left out"));
        }
    }
    Ok(nodes)
}

/// First and last key of each animation; (0, 0) without any.
pub(super) fn spans(doc: &Document<'_>) -> Result<Vec<(f64, f64)>, SceneError> {
    let mut spans = Vec::new();
    for (i, animation) in doc.root.animations.iter().enumerate() {
        let place = label("animation", i, animation.name.as_deref());
        let mut span: Option<(f64, f64)> = None;
        for sampler in &animation.samplers {
            let times: Vec<[f32; 1]> = doc.vectors(sampler.input, &place)?;
            for time in times.into_iter().map(|[t]| f64::from(t)).filter(|t| t.is_finite()) {
                span = Some(span.map_or((time, time), |(a, b)| (time.min(a), time.max(b))));
            }
        }
        spans.push(span.unwrap_or((0.0, 0.0)));
    }
    Ok(spans)
}

fn track(
    doc: &Document<'_>,
    animation: &json::Animation,
    sampler: Index<json::animation::Sampler>,
    rotates: bool,
    place: &str,
) -> Result<Track, SceneError> {
    let sampler = doc.get(&animation.samplers, sampler, "sampler", place)?;
    let Checked::Valid(interpolation) = sampler.interpolation else {
        return Err(doc.invalid(place, "has an unknown interpolation"));
    };
    let times: Vec<[f32; 1]> = doc.vectors(sampler.input, place)?;
    let times: Vec<f64> = times.into_iter().map(|[t]| f64::from(t)).collect();
    let values: Vec<DVec4> = if rotates {
        let all: Vec<[f32; 4]> = doc.vectors(sampler.output, place)?;
        all.into_iter().map(|v| DVec4::from_array(v.map(f64::from))).collect()
    } else {
        let all: Vec<[f32; 3]> = doc.vectors(sampler.output, place)?;
        all.into_iter().map(|v| DVec3::from_array(v.map(f64::from)).extend(0.0)).collect()
    };
    let expected = times.len() * if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    if times.is_empty() || values.len() != expected {
        let what = format!("has {} keys and {} values, which do not fit", times.len(), values.len());
        return Err(doc.invalid(place, what));
    }
    let sorted = times.is_sorted_by(|a, b| a < b);
    if !sorted || !times[0].is_finite() || !times[times.len() - 1].is_finite() {
        return Err(doc.invalid(place, "has times that do not increase from key to key"));
    }
    if values.iter().any(|v| !v.is_finite()) {
        return Err(doc.invalid(place, "has a value that is not a finite number"));
    }
    doc.keep(8 * times.len() as u64 + 32 * values.len() as u64, place)?;
    Ok(Track { times, values, interpolation, rotates })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(degrees: f64) -> DVec4 {
        let half = degrees.to_radians() / 2.0;
        DVec4::new(0.0, 0.0, libm::sin(half), libm::cos(half))
    }

    fn track(values: Vec<DVec4>, interpolation: Interpolation, rotates: bool) -> Track {
        let n = values.len() / if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        Track { times: (0..n).map(|i| 2.0 * i as f64).collect(), values, interpolation, rotates }
    }

    #[test]
    fn linear_and_step() {
        let values = vec![DVec4::ZERO, DVec4::X, DVec4::X * 3.0];
        let linear = track(values.clone(), Interpolation::Linear, false);
        for (time, x) in [(-1.0, 0.0), (0.0, 0.0), (1.0, 0.5), (2.0, 1.0), (3.0, 2.0), (4.0, 3.0), (9.0, 3.0)]
        {
            assert_eq!(linear.vector(time).x, x, "{time}");
        }
        let step = track(values, Interpolation::Step, false);
        for (time, x) in [(-1.0, 0.0), (1.9, 0.0), (2.0, 1.0), (3.9, 1.0), (4.0, 3.0)] {
            assert_eq!(step.vector(time).x, x, "{time}");
        }
    }

    #[test]
    fn rotations_turn_evenly_and_the_short_way() {
        for (to, sign) in [(90.0, 1.0), (1e-7, 1.0), (179.9, 1.0), (90.0, -1.0)] {
            let linear = track(vec![turn(0.0), turn(to) * sign], Interpolation::Linear, true);
            let quarter = linear.quaternion(0.5);
            let want = DQuat::from_vec4(turn(to / 4.0));
            assert!((quarter - want).length() < 1e-14 || (quarter + want).length() < 1e-14, "{to}");
        }
    }

    #[test]
    fn cubic_splines_have_the_given_ends_and_slopes() {
        let values =
            vec![DVec4::ZERO, DVec4::X, DVec4::X * 2.0, DVec4::X * -1.0, DVec4::X * 5.0, DVec4::ZERO];
        let cubic = track(values, Interpolation::CubicSpline, false);
        let slope = |t: f64| (cubic.vector(t + 1e-6).x - cubic.vector(t - 1e-6).x) / 2e-6;
        assert_eq!(cubic.vector(0.0).x, 1.0);
        assert_eq!(cubic.vector(2.0).x, 5.0);
        assert!((slope(2e-6) - 2.0).abs() < 1e-4);
        assert!((slope(2.0 - 2e-6) + 1.0).abs() < 1e-4);
    }
}
