//! A scene of one pixel whose value can be written down.

use dapple_integrator::Effect;
use dapple_integrator::camera::Lens;
use dapple_integrator::scene::Scene;

/// One closed-form scene, one pixel wide.
pub struct Form {
    /// E1 to E18.
    pub id: &'static str,
    /// What is seen.
    pub title: &'static str,
    /// Where the formula comes from.
    pub source: &'static str,
    pub(super) scene: Scene,
    pub(super) exact: f64,
    /// The integrals that are on.
    pub(super) effects: &'static [Effect],
    pub(super) max_bounces: u32,
    /// Most that n × n midpoints err, times n; only where the grid is the whole estimate.
    pub(super) grid: Option<f64>,
    /// Without any integral, or where the density is the integrand, points do not matter.
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

/// The scene's camera with a lens, lengths in world units.
pub(super) fn with_lens(mut scene: Scene, lens: Lens) -> Scene {
    let render = |length: f32| (f64::from(length) * scene.space.scale) as f32;
    let lens = Lens { radius: render(lens.radius), focus_distance: render(lens.focus_distance), ..lens };
    scene.cameras[0].camera.lens = Some(lens);
    scene
}
