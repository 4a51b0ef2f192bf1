//! Animated translations, rotations and scales: converts the file's samplers to tracks (glTF 2.0 appendix C).
//!
//! Outside its keys a track keeps its first or last value. If several of the selected animations move the same property
//! of a node, the first one is used.
use super::document::{Document, label};
use crate::SceneError;
use dapple_math::motion::{Interpolation, Track, TrackError, Value};
use glam::{DQuat, DVec3, DVec4};
use gltf::json::{
    self, Index,
    animation::{self, Property},
    validation::Checked,
};
use std::{collections::HashMap, sync::Arc};

/// The tracks of one node.
#[derive(Clone, Debug, Default)]
pub(super) struct Tracks {
    pub translation: Option<Arc<Track<DVec3>>>,
    pub rotation: Option<Arc<Track<DQuat>>>,
    pub scale: Option<Arc<Track<DVec3>>>,
}

impl Tracks {
    /// Whether the node is not animated.
    pub fn is_empty(&self) -> bool {
        self.translation.is_none() && self.rotation.is_none() && self.scale.is_none()
    }
}

/// The tracks of all nodes, by node index, from the selected animations, given by index.
pub(super) fn tracks(doc: &Document<'_>, chosen: &[usize]) -> Result<Vec<Tracks>, SceneError> {
    let mut nodes = vec![Tracks::default(); doc.root.nodes.len()];
    let mut read = Read::default();
    for &i in chosen {
        let animation = &doc.root.animations[i];
        let place = label("animation", i, animation.name.as_deref());
        let mut hidden = false;
        for channel in &animation.channels {
            doc.get(&doc.root.nodes, channel.target.node, "node", &place)?;
            let tracks = &mut nodes[channel.target.node.value()];
            let sampler = Sampler { doc, animation, index: channel.sampler, place: &place };
            hidden |= match channel.target.path {
                Checked::Valid(Property::Translation) => {
                    sampler.fill(&mut tracks.translation, &mut read.vectors, vector)?
                }
                Checked::Valid(Property::Rotation) => {
                    sampler.fill(&mut tracks.rotation, &mut read.rotations, rotation)?
                }
                Checked::Valid(Property::Scale) => {
                    sampler.fill(&mut tracks.scale, &mut read.vectors, vector)?
                }
                _ => false,
            };
        }
        if hidden {
            doc.warn(format!(
                "{place} moves properties that an earlier animation moves as well: there the earlier one is used"
            ));
        }
    }
    Ok(nodes)
}

/// Identity of a track: accessors of the times and the values, and the interpolation.
type Keys = (usize, usize, u8);

/// The tracks read so far, as many nodes may share one.
#[derive(Default)]
struct Read {
    vectors: HashMap<Keys, Arc<Track<DVec3>>>,
    rotations: HashMap<Keys, Arc<Track<DQuat>>>,
}

/// Times of the first and last key of each animation in seconds; (0, 0) without keys.
pub(super) fn spans(doc: &Document<'_>) -> Vec<Result<(f64, f64), SceneError>> {
    let mut inputs = HashMap::new();
    let animations = doc.root.animations.iter().enumerate();
    animations.map(|(i, a)| span(doc, a, &label("animation", i, a.name.as_deref()), &mut inputs)).collect()
}

/// Times of the first and last key of an animation. `inputs` caches those of accessors, which many samplers may share.
fn span(
    doc: &Document<'_>,
    animation: &json::Animation,
    place: &str,
    inputs: &mut HashMap<usize, (f64, f64)>,
) -> Result<(f64, f64), SceneError> {
    const NOTHING: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);
    let join = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
    let mut all = NOTHING;
    for sampler in &animation.samplers {
        let keys = match inputs.get(&sampler.input.value()) {
            Some(keys) => *keys,
            None => {
                let times: Vec<[f32; 1]> = doc.vectors(sampler.input, place)?;
                let times = times.into_iter().map(|[t]| f64::from(t)).filter(|t| t.is_finite());
                *inputs.entry(sampler.input.value()).or_insert(times.map(|t| (t, t)).fold(NOTHING, join))
            }
        };
        all = join(all, keys);
    }
    Ok(if all.0 <= all.1 { all } else { (0.0, 0.0) })
}

fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

fn rotation(v: [f32; 4]) -> DQuat {
    DQuat::from_vec4(DVec4::from_array(v.map(f64::from)))
}

/// A channel's sampler in the file.
struct Sampler<'a, 'o> {
    doc: &'a Document<'o>,
    animation: &'a json::Animation,
    index: Index<animation::Sampler>,
    place: &'a str,
}

impl Sampler<'_, '_> {
    /// Reads the track into `slot`; if an earlier animation has filled it, reads nothing and returns true.
    fn fill<const N: usize, T: Value>(
        &self,
        slot: &mut Option<Arc<Track<T>>>,
        read: &mut HashMap<Keys, Arc<Track<T>>>,
        value: fn([f32; N]) -> T,
    ) -> Result<bool, SceneError> {
        if slot.is_some() {
            return Ok(true);
        }
        let sampler = self.doc.get(&self.animation.samplers, self.index, "sampler", self.place)?;
        let interpolation = self.interpolation(sampler)?;
        let keys = (sampler.input.value(), sampler.output.value(), interpolation as u8);
        let track = match read.get(&keys) {
            Some(track) => track.clone(),
            None => {
                let track = Arc::new(self.track(sampler, interpolation, value)?);
                read.insert(keys, track.clone());
                track
            }
        };
        *slot = Some(track);
        Ok(false)
    }

    fn interpolation(&self, sampler: &animation::Sampler) -> Result<Interpolation, SceneError> {
        Ok(match sampler.interpolation {
            Checked::Valid(animation::Interpolation::Step) => Interpolation::Step,
            Checked::Valid(animation::Interpolation::Linear) => Interpolation::Linear,
            Checked::Valid(animation::Interpolation::CubicSpline) => Interpolation::CubicSpline,
            Checked::Invalid => return Err(self.doc.invalid(self.place, "has an unknown interpolation")),
        })
    }

    fn track<const N: usize, T: Value>(
        &self,
        sampler: &animation::Sampler,
        interpolation: Interpolation,
        value: fn([f32; N]) -> T,
    ) -> Result<Track<T>, SceneError> {
        let (doc, place) = (self.doc, self.place);
        let times: Vec<[f32; 1]> = doc.vectors(sampler.input, place)?;
        let values: Vec<[f32; N]> = doc.vectors(sampler.output, place)?;
        let (keys, count) = (times.len(), values.len());
        doc.keep(8 * keys as u64 + 32 * count as u64, place)?;
        let times = times.into_iter().map(|[t]| f64::from(t)).collect();
        let track = Track::new(times, values.into_iter().map(value).collect(), interpolation);
        track.map_err(|error| {
            doc.invalid(
                place,
                match error {
                    TrackError::Empty | TrackError::Length => {
                        format!("has {keys} keys and {count} values, which do not match")
                    }
                    TrackError::Times(_) => "has times that do not increase from key to key".into(),
                    TrackError::Value(_) => "has a value that is not a finite number".into(),
                },
            )
        })
    }
}
