//! Which lights share their place with a surface?
//!
//! A lamp in the plane of a ceiling, lamps that lie in one another, a point light in a wall: found once, when the scene is
//! built. Scenes without any carry nothing, and ask nothing.
use crate::{Space, emission::AreaLights};
use dapple_geometry::{Coincident, Hit, World, offset::UNIT_ROUNDOFF};
use dapple_lights::Light;
use glam::{DVec3, Vec3};

/// Surfaces and lights that share a place.
#[derive(Clone, Debug)]
pub struct SharedPlaces {
    /// The surfaces.
    pub surfaces: Box<Coincident>,
    /// By light.
    lights: Vec<bool>,
    /// By object: whether its material says that it emits.
    emits: Vec<bool>,
}

impl SharedPlaces {
    /// `emits`: by object. `area`: the lights of surfaces, the first ones of `lights`. None when no light shares its place.
    pub(crate) fn find(
        world: &World,
        emits: Vec<bool>,
        (area, lights): (&AreaLights, &[Light]),
        space: &Space,
    ) -> Option<Self> {
        if cfg!(without = "coincident") {
            return None;
        }
        let (numbers, points): (Vec<usize>, Vec<(DVec3, DVec3)>) =
            lights.iter().enumerate().filter_map(|(i, light)| Some((i, light.positions()?))).unzip();
        let surfaces = world.coincident(|object| emits[object as usize], &points, origin_error(space))?;
        let mut shared: Vec<bool> = (0..lights.len() as u32).map(|i| area.is_on(i, &surfaces)).collect();
        for (number, light) in numbers.into_iter().enumerate() {
            shared[light] = surfaces.contains_point(number);
        }
        Some(Self { surfaces, lights: shared, emits })
    }

    /// Whether light `light` shares its place with a surface other than its own.
    pub fn contains_light(&self, light: u32) -> bool {
        self.lights.get(light as usize).copied().unwrap_or(false)
    }

    /// Whether the surface that was hit may share its place with an emitter.
    #[inline]
    pub fn contains(&self, hit: &Hit) -> bool {
        self.surfaces.contains(hit.object, hit.primitive)
    }

    /// Whether an object's material says that it emits, be it with the light left out of the scene.
    pub fn emits(&self, object: u32) -> bool {
        self.emits.get(object as usize).copied().unwrap_or(false)
    }

    /// Lights that share their place.
    pub fn light_count(&self) -> usize {
        self.lights.iter().filter(|shared| **shared).count()
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.surfaces.memory_bytes() + self.lights.len() + self.emits.len()
    }
}

/// What coordinates of the world were rounded by before they came here: files have them in f32, half an ulp of their
/// distance from the world's origin. The part that goes with render-space coordinates is in the surfaces' own bounds.
fn origin_error(space: &Space) -> Vec3 {
    ((space.centre.abs() * space.scale) * f64::from(UNIT_ROUNDOFF)).as_vec3()
}
