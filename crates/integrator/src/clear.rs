//! Which surfaces let light go straight on, and which lights shine on what bends or mirrors it? Decided once per render.

use dapple_camera::{Camera, Projection};
use dapple_scene::{Scene, TexturedMaterial};
use glam::Vec3;

/// Indices that differ by less are equal (`dapple_materials`' own bound is half of this).
const EQUAL_INDICES: f32 = 2e-4;

fn used(scene: &Scene) -> impl Iterator<Item = &TexturedMaterial> {
    scene.objects.iter().map(|object| &scene.materials[object.material as usize])
}

/// Whether a rough material can be smooth somewhere.
fn can_be_smooth(m: &TexturedMaterial, all_are: bool) -> bool {
    all_are || m.base.roughness == 0.0 || m.metallic_roughness_texture.is_some()
}

/// Whether some thin wall lets light go straight on. `sharp`: rough transmission is taken as smooth.
pub(crate) fn any_wall(scene: &Scene, sharp: bool) -> bool {
    used(scene).any(|m| m.transmits() && m.base.thin && can_be_smooth(m, sharp))
}

/// Whether some body does, met from outside of all others: its index is that of the outside, or not known.
pub(crate) fn any_body(scene: &Scene) -> bool {
    let passes = |m: &TexturedMaterial| m.base.ior == 0.0 || (m.base.ior - 1.0).abs() < EQUAL_INDICES;
    used(scene).any(|m| m.transmits() && !m.base.thin && passes(m))
}

/// Where all camera rays start, if they start in one place while nothing moves.
pub(crate) fn media_start(scene: &Scene, camera: &Camera) -> Option<Vec3> {
    let is_pinhole = camera.lens.is_none_or(|lens| lens.radius == 0.0);
    let is_point = matches!(camera.projection, Projection::Perspective { .. });
    (is_pinhole && is_point && camera.motion.is_none() && !scene.world.has_motion()).then_some(camera.origin)
}

/// Lights that rays cannot hit and whose light mirrors and smooth refraction send on: that part of it nothing finds.
/// `sharp`: rough reflection or transmission is taken as smooth.
pub(crate) fn unreachable(scene: &Scene, sharp: bool) -> u64 {
    if !used(scene).any(|m| sends_on(m, sharp)) {
        return 0;
    }
    let shines = |i: usize| scene.lights[i].is_delta() && scene.lights[i].power(1.0) != Vec3::ZERO;
    (0..scene.lights.len()).filter(|&i| shines(i)).count() as u64
}

/// Whether surfaces of a material mirror light or bend it, without spreading it.
fn sends_on(m: &TexturedMaterial, sharp: bool) -> bool {
    let base = &m.base;
    if m.unlit {
        return false;
    }
    if let Some(mirror) = base.mirror {
        return mirror.kr != Vec3::ZERO && (mirror.blur == 0.0 || sharp);
    }
    if !(base.roughness == 0.0 || sharp) {
        return false;
    }
    let opaque = base.transmission < 1.0 || m.transmission_texture.is_some();
    let bends = m.transmits() && (base.ior - 1.0).abs() >= EQUAL_INDICES;
    base.metallic > 0.0 || (opaque && base.specular > 0.0) || (bends && (base.specular > 0.0 || !base.thin))
}
