//! Complete renders in one call.

use super::outcome::{Outcome, Progress};
use super::renderer::{Advance, Renderer};
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

/// Observes a render in progress, see [`Renderer::run`].
pub trait Watcher {
    /// Receives a snapshot. `Break` ends the render; such a render counts as finished, not as stopped.
    fn look(&mut self, at: &Snapshot<'_>) -> ControlFlow<()>;

    /// Sample count of an additional snapshot, rounded up to whole rounds, if one is wanted.
    fn next(&self) -> Option<u32> {
        None
    }

    /// Called after each complete pass, that is about once per second, and after the snapshot if there is one: a
    /// render that is resumed from this state receives the later snapshots only. Its time counts as rendering.
    fn between(&mut self, _: &Renderer<'_>) {}
}

impl Renderer<'_> {
    /// Renders until all samples are taken, time is up, or `progress` or `watcher` ends the render. `watcher` receives
    /// snapshots at increasing sample counts: at n, n/2, n/4, … of the n samples requested (rounded down), or at 1, 2,
    /// 4, … if only time limits the render, and where [`Watcher::next`] requests one; for the distribution tracer only
    /// after whole rounds. Snapshots change no bit of the image, and their time does not count as rendering.
    pub fn run(
        &mut self,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
        watcher: &mut dyn Watcher,
    ) -> Advance {
        let (start, round) = (self.settings().sample_range().start, self.settings().round());
        while !self.is_complete() {
            let spp = self.spp();
            let regular = snapshot::next(self.settings(), spp);
            let asked = watcher.next().and_then(|n| n.checked_next_multiple_of(round));
            let stop_at = asked.filter(|n| *n > spp && *n < regular).unwrap_or(regular);
            let until = start.saturating_add(stop_at);
            let why = self.advance_between(until, progress, &mut |at| {
                if at.spp() < stop_at {
                    watcher.between(at);
                }
            });
            if self.spp() < stop_at {
                return why;
            }
            let at = Snapshot { between: stop_at != regular, ..self.snapshot() };
            let is_enough = watcher.look(&at).is_break();
            watcher.between(self);
            if is_enough {
                return why;
            }
        }
        Advance::Reached
    }
}

/// As [`render`], with the snapshots of [`Renderer::run`]; [`Snapshot::also_at`] requests additional ones.
pub fn render_watched(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    look: &mut Look<'_>,
) -> Outcome {
    let mut renderer = Renderer::unchecked(scene, camera, settings);
    let why = renderer.run(progress, &mut Looking { look, asked: None });
    renderer.finish_as(why)
}

/// A function that receives snapshots.
struct Looking<'a, 'b> {
    look: &'a mut Look<'b>,
    asked: Option<u32>,
}

impl Watcher for Looking<'_, '_> {
    fn look(&mut self, at: &Snapshot<'_>) -> ControlFlow<()> {
        at.asked.set(self.asked);
        let flow = (self.look)(at);
        self.asked = at.asked.get();
        flow
    }

    fn next(&self) -> Option<u32> {
        self.asked
    }
}
