//! What should the pictures be?

use crate::metrics::{self, Comparison, Scale, SizeMismatch};
use dapple_imaging::Image;
use dapple_integrator::camera::Camera;
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::Scene;
use dapple_integrator::{MethodKind, Progress, Settings, render};
use std::ops::ControlFlow;
use std::time::Duration;

/// Seeds of the two halves, for runs whose seeds count from 1; those of the runs count from far below.
const SEEDS: [u64; 2] = [0xffff_ffff_0000_0001, 0xffff_ffff_0000_0002];

/// A picture that others are held against.
#[derive(Clone, Debug)]
pub enum Reference {
    /// Taken as the truth.
    Exact(Image),
    /// Two independent renders of equal effort.
    Halves([Image; 2]),
}

impl Reference {
    /// Renders two halves by the path tracer with Sobol points, whatever the method of `settings`: what a picture
    /// should be depends on the scene, the view and the effects that are on. The first half takes half of `seconds`,
    /// but at least one sample, the second as many samples; both have seeds of their own, which follow from that of
    /// `settings`. Returns them with the samples per pixel of each; `None` when `stop` said so.
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
            // Not even one sample of every pixel in that time.
            (_, 0) => draw(first.with_time_limit(None).with_spp(1))?,
            whole => whole,
        };
        let (second, _) = draw(Settings { seed: two, ..half }.with_time_limit(None).with_spp(spp))?;
        Some((Self::Halves([first, second]), spp))
    }

    /// The best guess.
    pub fn picture(&self) -> Image {
        match self {
            Self::Exact(picture) => picture.clone(),
            Self::Halves([a, b]) => metrics::mean([a, b]),
        }
    }

    /// Mean squared error that the best guess still has; 0 where it is taken as exact.
    pub fn mse(&self) -> f64 {
        match self {
            Self::Exact(_) => 0.0,
            Self::Halves([a, b]) => metrics::halves_mse([a, b]).unwrap_or(f64::INFINITY),
        }
    }

    /// The same as relative RMSE.
    pub fn relative_rmse(&self) -> f64 {
        let mean = self.picture().mean();
        self.mse().sqrt() / f64::from((mean.x + mean.y + mean.z) / 3.0)
    }

    /// The error of a picture, without the reference's own where there are two halves.
    pub fn compare(&self, image: &Image) -> Result<Comparison, SizeMismatch> {
        match self {
            Self::Exact(picture) => metrics::compare(image, picture, &Scale::default()),
            Self::Halves([a, b]) => metrics::compare_halves(image, [a, b], &Scale::default()),
        }
    }
}
