//! Complete renders in one call.

use super::outcome::{Outcome, Progress};
use super::renderer::Renderer;
use super::snapshot::{self, Look, Snapshot};
use crate::settings::Settings;
use dapple_camera::Camera;
use dapple_scene::Scene;
use std::ops::ControlFlow;

/// Renders an image. `progress` may stop the render by returning `Break`; it is called about every 50 ms, on a separate
/// thread. The samples of an interrupted pass are discarded, unless it is the first. The settings are not validated;
/// use [`Settings::check`] beforehand.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Outcome {
    let mut renderer = Renderer::unchecked(scene, camera, settings);
    let why = renderer.advance(u32::MAX, progress);
    renderer.finish_as(why)
}

/// As [`render`], with snapshots at increasing sample counts: at n, n/2, n/4, … of the n samples requested (rounded
/// down), or at 1, 2, 4, … if only time limits the render, and where [`Snapshot::also_at`] requests one; for the
/// distribution tracer only after whole rounds. Snapshots change no bit of the image, and their time does not count as
/// rendering. `look` may end the render; such a render counts as finished, not as stopped.
pub fn render_watched(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    look: &mut Look<'_>,
) -> Outcome {
    let mut renderer = Renderer::unchecked(scene, camera, settings);
    let start = settings.sample_range().start;
    let mut asked = None;
    loop {
        let spp = renderer.spp();
        let regular = snapshot::next(settings, spp);
        let stop_at = asked.filter(|n| *n > spp && *n < regular).unwrap_or(regular);
        let why = renderer.advance(start.saturating_add(stop_at), progress);
        if renderer.spp() < stop_at {
            return renderer.finish_as(why);
        }
        let at = Snapshot { between: stop_at != regular, asked: asked.into(), ..renderer.snapshot() };
        let is_enough = look(&at).is_break();
        asked = at.asked.get().and_then(|n| n.checked_next_multiple_of(settings.round()));
        if is_enough || renderer.is_complete() {
            return renderer.finish_as(why);
        }
    }
}
