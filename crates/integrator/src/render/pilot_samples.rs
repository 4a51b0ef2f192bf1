//! Rendering the pilot samples alone, for parts of a render that do not begin with them.

use super::outcome::Progress;
use super::pilot::PilotResult;
use super::renderer::{Advance, Renderer};
use crate::settings::{Method, Settings, SettingsError};
use dapple_camera::Camera;
use dapple_scene::Scene;
use std::ops::ControlFlow;

/// Renders the pilot samples of a render with `settings`, of which any part may be requested; `None` once `progress`
/// stops it.
///
/// # Errors
/// If the settings are contradictory, or adaptive sampling is combined with a crop.
pub fn render_pilot(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Option<PilotResult>, SettingsError> {
    let Some(count) = settings.pilot_samples() else { return Ok(Some(PilotResult::default())) };
    let mut first = settings.clone();
    (first.aovs, first.limits.time) = (Vec::new(), None);
    match &mut first.method {
        Method::Path(path) => {
            path.of = Some(settings.block());
            path.samples = 0..count;
            path.allocation = None;
        }
        Method::Distribution(distribution) => distribution.samples = Some(0..count),
    }
    let mut renderer = Renderer::new(scene, camera, &first)?;
    let why = renderer.advance(count, progress);
    let found = renderer.pilot();
    Ok((why == Advance::Reached).then_some(found))
}
