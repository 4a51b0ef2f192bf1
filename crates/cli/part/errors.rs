//! The error estimate of merged parts: every part renders its own samples of some pixels with other seeds.

use crate::interrupt;
use crate::known::Known;
use crate::load::Loaded;
use dapple_analysis::estimate::{Replicates, Verdict, Way, replicated, unseen, within};
use dapple_integrator::camera::Camera;
use dapple_integrator::{Outcome, Peak, Settings, peak};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

/// What a part has for the error estimate of the whole.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Errors {
    /// Whether the variance within the pixels is the squared error.
    is_within: bool,
    /// Renders of some pixels with other seeds, for each rectangle of pixels.
    replicates: Vec<Replicates>,
    /// Upper bounds of the value of one sample.
    peak: Peak,
    /// Why the error cannot be estimated, if it cannot.
    unknown: Option<String>,
    /// Seconds spent on all of it.
    seconds: f64,
}

impl Errors {
    /// Renders some pixels again, drawn by the pilot samples.
    pub fn render(
        loaded: &Loaded,
        camera: &Camera,
        settings: &Settings,
        pilot: Option<Arc<Vec<f32>>>,
        samples: Range<u32>,
    ) -> Self {
        let (start, scene) = (Instant::now(), &loaded.scene);
        let mut errors = Self { peak: peak(scene, camera, settings), ..Self::default() };
        match Way::of(settings) {
            Way::Within => errors.is_within = true,
            Way::None => {
                errors.unknown =
                    Some("the error of these samples is not random: they are the same for every seed".into());
            }
            Way::Replicate => {
                // Without pilot samples the pixels are drawn evenly.
                let even = || Arc::new(vec![0.0; settings.rect().area()]);
                let within = pilot.unwrap_or_else(even);
                let what = (scene, camera, settings);
                match Replicates::render(what, &within, samples, &interrupt::asked) {
                    Some(found) => errors.replicates.push(found),
                    None => errors.unknown = Some("a part was stopped before it measured its error".into()),
                }
            }
        }
        errors.seconds = start.elapsed().as_secs_f64();
        errors
    }

    /// Encodes what a part keeps.
    pub fn encode(&self) -> Result<Vec<u8>, String> {
        postcard::to_stdvec(self).map_err(|e| e.to_string())
    }

    /// Decodes what a part keeps; nothing if it is damaged. A part of a build without error estimation has none.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        if bytes.is_empty() {
            let unknown = Some("a part was rendered by a program without error estimation".into());
            return Some(Self { unknown, ..Self::default() });
        }
        postcard::from_bytes(bytes).ok()
    }

    /// Adds those of another part.
    pub fn merge(&mut self, other: Self) {
        self.seconds += other.seconds;
        self.unknown = self.unknown.take().or(other.unknown);
        for found in other.replicates {
            let merged = self.replicates.iter_mut().find(|mine| mine.rect() == found.rect());
            match merged.map(|mine| mine.merge(&found)) {
                Some(true) => {}
                Some(false) => self.unknown = Some("the parts rendered different pixels again".into()),
                None => self.replicates.push(found),
            }
        }
    }
}

/// Returns the error of the merged image at a confidence level.
pub fn judged(errors: &Errors, outcome: &Outcome, confidence: f64) -> Known {
    let film = &outcome.film;
    let found = match (&errors.unknown, errors.is_within) {
        (Some(_), _) => None,
        (None, true) => within(film, confidence),
        (None, false) => replicated(&errors.replicates, film, confidence),
    };
    let judge = |found| Verdict::new(found, unseen(film, &outcome.tail, &errors.peak, confidence), None);
    let verdict = found.map(judge);
    let unknown = || {
        let too_few = "the parts have too few samples, or differ in their pixels, to estimate the error";
        errors.unknown.clone().unwrap_or_else(|| too_few.into())
    };
    Known {
        error: verdict.as_ref().map(|v| v.error),
        bound: verdict.as_ref().filter(|v| v.reliable).map(|v| v.bound),
        reliable: verdict.as_ref().is_some_and(|v| v.reliable),
        why: verdict.map_or_else(unknown, |v| v.why),
        seconds: errors.seconds,
    }
}
