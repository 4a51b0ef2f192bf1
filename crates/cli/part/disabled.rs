//! Replacement of the error estimate of parts without the feature `report`: parts carry none.

use crate::known::Known;
use crate::load::Loaded;
use dapple_integrator::camera::Camera;
use dapple_integrator::{Outcome, Settings};
use std::ops::Range;
use std::sync::Arc;

/// What a part has for the error estimate: nothing.
#[derive(Clone, Default)]
pub struct Errors(Vec<u8>);

impl Errors {
    /// Renders nothing again.
    pub fn render(_: &Loaded, _: &Camera, _: &Settings, _: Option<Arc<Vec<f32>>>, _: Range<u32>) -> Self {
        Self::default()
    }

    /// Encodes what is kept.
    pub fn encode(&self) -> Result<Vec<u8>, String> {
        Ok(self.0.clone())
    }

    /// Keeps the bytes.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        Some(Self(bytes.to_vec()))
    }

    /// Drops what another part has.
    pub fn merge(&mut self, _: Self) {
        self.0.clear();
    }
}

/// Returns an unknown error.
pub fn judged(_: &Errors, _: &Outcome, _: f64) -> Known {
    Known {
        why: "this dapple was built without error estimation (feature report)".into(),
        ..Known::default()
    }
}
