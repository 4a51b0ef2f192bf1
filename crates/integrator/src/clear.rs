//! Which surfaces let light go straight on, and which lights shine on what bends or mirrors it? Decided once per render.

use dapple_camera::{Camera, Projection};
use dapple_materials::{Lobe, Lobes};
use dapple_scene::{Scene, TexturedMaterial};
use glam::Vec3;

/// Whether some thin wall lets light go straight on. `sharp`: lobes whose blur is off.
pub(crate) fn any_wall(scene: &Scene, sharp: Lobes) -> bool {
    let passes = |m: &TexturedMaterial| m.lobe_bounds().sharpened(sharp).contains(Lobe::DeltaTransmission);
    scene.used_materials().any(|m| m.is_thin() && passes(m))
}

/// Whether some body does, met from outside of all others: its index is that of the outside, or not known.
pub(crate) fn any_body(scene: &Scene) -> bool {
    scene.used_materials().any(|m| m.transmits() && !m.is_thin() && m.keeps_direction())
}

/// Where all camera rays start, if they start in one place while nothing moves.
pub(crate) fn media_start(scene: &Scene, camera: &Camera) -> Option<Vec3> {
    let is_pinhole = camera.lens.is_none_or(|lens| lens.radius == 0.0);
    let is_point = matches!(camera.projection, Projection::Perspective { .. });
    (is_pinhole && is_point && camera.motion.is_none() && !scene.accel.has_motion()).then_some(camera.origin)
}

/// Lights that rays cannot hit and whose light mirrors and smooth refraction send on: that part of it nothing finds.
/// `sharp`: lobes whose blur is off.
pub(crate) fn unreachable(scene: &Scene, sharp: Lobes) -> u64 {
    if !scene.used_materials().any(|m| sends_on(m, sharp)) {
        return 0;
    }
    let shines = |i: usize| scene.lights[i].is_delta() && scene.lights[i].power(1.0) != Vec3::ZERO;
    (0..scene.lights.len()).filter(|&i| shines(i)).count() as u64
}

/// Whether surfaces of a material mirror light or bend it, without spreading it.
fn sends_on(m: &TexturedMaterial, sharp: Lobes) -> bool {
    let lobes = m.lobes_by_factors().sharpened(sharp);
    let bends = lobes.contains(Lobe::DeltaTransmission) && !m.keeps_direction();
    lobes.contains(Lobe::DeltaReflection) || bends
}
