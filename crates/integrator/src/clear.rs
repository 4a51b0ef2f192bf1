//! Transparent surfaces that shadow rays pass straight through, and lights that only specular paths would reach.
//! Computed once per render.

use dapple_camera::{Camera, Projection};
use dapple_materials::{Lobe, Lobes};
use dapple_scene::{Scene, TexturedMaterial};
use glam::Vec3;

/// Whether some thin wall transmits light without changing its direction. `sharp`: lobes whose roughness is switched
/// off.
pub(crate) fn any_wall(scene: &Scene, sharp: Lobes) -> bool {
    let passes = |m: &TexturedMaterial| m.lobe_bounds().sharpened(sharp).contains(Lobe::DeltaTransmission);
    scene.used_materials().any(|m| m.is_thin() && passes(m))
}

/// Whether some body transmits light without changing its direction when entered from outside of all other bodies: its
/// index of refraction equals that of the outside, or is unknown.
pub(crate) fn any_body(scene: &Scene) -> bool {
    scene.used_materials().any(|m| m.transmits() && !m.is_thin() && m.keeps_direction())
}

/// The origin of all camera rays, if they share one origin and nothing moves.
pub(crate) fn media_start(scene: &Scene, camera: &Camera) -> Option<Vec3> {
    let is_pinhole = camera.lens.is_none_or(|lens| lens.radius == 0.0);
    let is_point = matches!(camera.projection, Projection::Perspective { .. });
    (is_pinhole && is_point && camera.motion.is_none() && !scene.accel.has_motion()).then_some(camera.origin)
}

/// Number of lights that rays cannot hit and whose light is reflected or refracted by specular surfaces: no strategy
/// samples that part of their light. `sharp`: lobes whose roughness is switched off.
pub(crate) fn unreachable(scene: &Scene, sharp: Lobes) -> u64 {
    if !scene.used_materials().any(|m| sends_on(m, sharp)) {
        return 0;
    }
    let shines = |i: usize| scene.lights[i].is_delta() && scene.lights[i].power(1.0) != Vec3::ZERO;
    (0..scene.lights.len()).filter(|&i| shines(i)).count() as u64
}

/// Whether surfaces of a material reflect or refract light specularly.
fn sends_on(m: &TexturedMaterial, sharp: Lobes) -> bool {
    let lobes = m.lobes_by_factors().sharpened(sharp);
    let bends = lobes.contains(Lobe::DeltaTransmission) && !m.keeps_direction();
    lobes.contains(Lobe::DeltaReflection) || bends
}
