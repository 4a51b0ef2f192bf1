//! Closed-form scenes of one pixel.

use dapple_integrator::Effect;
use dapple_integrator::camera::Lens;
use dapple_integrator::scene::Scene;

/// One closed-form scene of one pixel.
pub struct Form {
    /// Id, E1 to E18.
    pub id: &'static str,
    /// Description of the scene.
    pub title: &'static str,
    /// Source of the formula.
    pub source: &'static str,
    pub(super) scene: Scene,
    pub(super) exact: f64,
    /// The enabled effects.
    pub(super) effects: &'static [Effect],
    pub(super) max_bounces: u32,
    /// Maximum error of n × n midpoints, times n; only if the grid is a complete estimate.
    pub(super) grid: Option<f64>,
    /// Whether the variance is zero, because there is no integral or the density is proportional to the integrand.
    pub(super) certain: bool,
}

impl Form {
    pub(super) fn new(
        id: &'static str,
        title: &'static str,
        scene: Scene,
        exact: f64,
        effects: &'static [Effect],
    ) -> Self {
        let source = "docs/science.md, \"Closed-form scenes\"";
        Self { id, title, source, scene, exact, effects, max_bounces: 1, grid: None, certain: false }
    }
}

/// The scene with a lens in its camera, lengths in world units.
pub(super) fn with_lens(mut scene: Scene, lens: Lens) -> Scene {
    let render = |length: f32| (f64::from(length) * scene.space.scale) as f32;
    let lens = Lens { radius: render(lens.radius), focus_distance: render(lens.focus_distance), ..lens };
    scene.cameras[0].camera.lens = Some(lens);
    scene
}
