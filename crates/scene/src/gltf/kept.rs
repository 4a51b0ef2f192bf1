//! Decoded images that are kept between readings of the same file, as for the frames of an animation.

use dapple_imaging::read::Texels;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Decoded images of one file. Clones share them. Readings of different files, or with different files beside the
/// scene, must not share one.
#[derive(Clone, Debug, Default)]
pub struct KeptImages(Arc<Mutex<Kept>>);

#[derive(Debug, Default)]
struct Kept {
    /// By the index of the image in the file, with the time that decoding took.
    images: HashMap<usize, (Texels, Duration)>,
    saved: Duration,
}

impl KeptImages {
    /// Total time for decoding that was saved so far.
    pub fn saved(&self) -> Duration {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).saved
    }

    /// The kept image, or the result of `decode`, which is then kept.
    pub(super) fn get<E>(
        &self,
        index: usize,
        decode: impl FnOnce() -> Result<Texels, E>,
    ) -> Result<Texels, E> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let kept = &mut *kept;
        if let Some((texels, took)) = kept.images.get(&index) {
            kept.saved += *took;
            return Ok(texels.clone());
        }
        let start = Instant::now();
        let texels = decode()?;
        kept.images.insert(index, (texels.clone(), start.elapsed()));
        Ok(texels)
    }
}
