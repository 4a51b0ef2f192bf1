//! Reference images that errors are measured against.

use crate::metrics::{self, Comparison, Scale, SizeMismatch};
use dapple_imaging::Image;
use dapple_integrator::camera::Camera;
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::Scene;
use dapple_integrator::{MethodKind, Progress, Settings, render};
use std::ops::ControlFlow;
use std::time::Duration;

/// Seeds of the two halves for runs whose seeds start at 1; the seeds of runs are far smaller.
const SEEDS: [u64; 2] = [0xffff_ffff_0000_0001, 0xffff_ffff_0000_0002];

/// An image that others are compared with.
#[derive(Clone, Debug)]
pub enum Reference {
    /// One image, regarded as exact.
    Exact(Image),
    /// Two independent renders of equal sample count.
    Halves([Image; 2]),
}

impl Reference {
    /// Renders two halves with the path tracer and Sobol points, regardless of the method of `settings`, because the
    /// expected image depends only on the scene, the view and the enabled effects. The first half takes half of
    /// `seconds`, but at least one sample per pixel; the second takes as many samples. The seeds of both are derived
    /// from that of `settings`. Returns the halves and the samples per pixel of each; `None` if `stop` returned true.
    pub fn render(
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        seconds: f64,
        stop: &(dyn Fn(&Progress) -> bool + Sync),
    ) -> Option<(Self, u32)> {
        let half = Settings { pattern: Pattern::Sobol, ..settings.clone() }
            .with_method(MethodKind::Path)
            .with_time_limit(Duration::from_secs_f64(0.5 * seconds.max(1e-3)))
            .with_spp(None);
        let draw = |settings: Settings| {
            let outcome = render(scene, camera, &settings, &|p| match stop(&p) {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            });
            (!outcome.stats.stopped).then(|| (outcome.film.mean(), outcome.stats.spp))
        };
        let [one, two] = SEEDS.map(|seed| seed.wrapping_add(2 * settings.seed.saturating_sub(1)));
        let first = Settings { seed: one, ..half.clone() };
        let (first, spp) = match draw(first.clone())? {
            // Not even one sample per pixel was completed in that time.
            (_, 0) => draw(first.with_time_limit(None).with_spp(1))?,
            whole => whole,
        };
        let (second, _) = draw(Settings { seed: two, ..half }.with_time_limit(None).with_spp(spp))?;
        Some((Self::Halves([first, second]), spp))
    }

    /// The best estimate: the exact image, or the mean of both halves.
    pub fn picture(&self) -> Image {
        match self {
            Self::Exact(picture) => picture.clone(),
            Self::Halves([a, b]) => metrics::mean([a, b]),
        }
    }

    /// Mean squared error of the best estimate; 0 if it is regarded as exact.
    pub fn mse(&self) -> f64 {
        match self {
            Self::Exact(_) => 0.0,
            Self::Halves([a, b]) => metrics::halves_mse([a, b]).unwrap_or(f64::INFINITY),
        }
    }

    /// Relative RMSE of the best estimate.
    pub fn relative_rmse(&self) -> f64 {
        let mean = self.picture().mean();
        self.mse().sqrt() / f64::from((mean.x + mean.y + mean.z) / 3.0)
    }

    /// The error of an image, without that of the reference if there are two halves.
    ///
    /// # Errors
    /// The images differ in size.
    pub fn compare(&self, image: &Image) -> Result<Comparison, SizeMismatch> {
        match self {
            Self::Exact(picture) => metrics::compare(image, picture, &Scale::default()),
            Self::Halves([a, b]) => metrics::compare_halves(image, [a, b], &Scale::default()),
        }
    }
}
