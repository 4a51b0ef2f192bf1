//! Validation of the parts of a scene, its bounds, and simplifications.
use super::{Geometry, SceneBuilder};
use crate::{AlphaMode, SceneError, Space, TextureUse, TexturedMaterial, error::quoted, slots::SLOTS};
use dapple_geometry::bvh::Tree;
use glam::DVec3;
use std::collections::HashSet;

/// Maximum number of triangles of a scene, including all instances: all may be in a single tree.
const MAX_TRIANGLES: usize = Tree::MOST_TRIANGLES;
/// Larger world coordinates are treated as errors; f64 arithmetic on smaller ones stays finite.
const FARTHEST: f64 = 1e300;

impl SceneBuilder {
    /// Validates everything; returns the first error.
    pub(super) fn check(&self) -> Result<(), SceneError> {
        for (i, m) in self.materials.iter().enumerate() {
            let place = || format!("material {i} '{}'", quoted(&m.name));
            if let Some(factor) = m.bad_factor() {
                return Err(self.invalid(place(), format!("{factor} must be finite and not negative")));
            }
            let bad = |t: &TextureUse| t.texture as usize >= self.textures.len() || t.uv_set > 1;
            if let Some(slot) = SLOTS.iter().find(|slot| (slot.of)(m).as_ref().is_some_and(bad)) {
                let what = "uses a texture or a uv set that does not exist";
                return Err(self.invalid(place(), format!("{what}, for its {} texture", slot.label)));
            }
        }
        let mut triangles = 0_usize;
        let mut sound = HashSet::new();
        for (i, placed) in self.placed.iter().enumerate() {
            let fault = placed.fault(self.materials.len(), &mut sound);
            if let Some(what) = fault {
                return Err(self.invalid(format!("object {i} '{}'", quoted(&placed.name)), what));
            }
            triangles = triangles.saturating_add(placed.form().primitives());
        }
        if triangles > MAX_TRIANGLES {
            let what = format!("has {triangles} triangles; at most {MAX_TRIANGLES} are supported");
            return Err(self.invalid("the scene", what));
        }
        Ok(())
    }

    /// World-space bounding box of all objects when the shutter opens, from which render space is derived: later motion
    /// does not change the space in which the rest is rendered.
    pub(super) fn bounds(&self) -> Result<Option<(DVec3, DVec3)>, SceneError> {
        let mut all: Option<(DVec3, DVec3)> = None;
        for (i, placed) in self.placed.iter().enumerate() {
            let Some((min, max)) = placed.bounds(&self.exposure) else { continue };
            if !(min.min_element() >= -FARTHEST && max.max_element() <= FARTHEST) {
                let what = "is too far away: its coordinates are not finite or beyond 1e300";
                return Err(self.invalid(format!("object {i} '{}'", quoted(&placed.name)), what));
            }
            all = Some(all.map_or((min, max), |(a, b)| (a.min(min), b.max(max))));
        }
        Ok(all)
    }

    /// Converts objects on chains that do not move while the shutter is open to static objects.
    pub(super) fn make_static(&mut self) {
        let exposure = self.exposure;
        for placed in &mut self.placed {
            if let Geometry::Moving { body, chain } = &placed.geometry
                && !exposure.is_moving(&exposure.motion(chain, &Space::IDENTITY))
            {
                placed.geometry = body.placed(&exposure.placement(chain));
            }
        }
    }

    /// Changes the mode of Mask and Blend materials that are opaque everywhere to Opaque, which saves alpha tests.
    pub(super) fn simplify_alpha(&mut self) {
        let covers = |m: &TexturedMaterial| {
            let cutoff = match m.alpha_mode {
                AlphaMode::Opaque => return false,
                AlphaMode::Mask { cutoff } => cutoff,
                AlphaMode::Blend => 1.0,
            };
            let texture = m.base_color_texture.as_ref().map(|t| &self.textures[t.texture as usize]);
            m.alpha >= 1.0 && cutoff <= 1.0 && texture.is_none_or(|t| t.mean().w >= 1.0)
        };
        let mut solid: Vec<bool> = self.materials.iter().map(covers).collect();
        for placed in &self.placed {
            let solid = &mut solid[placed.material as usize];
            if let (true, Some(mesh)) = (*solid, placed.mesh()) {
                *solid = mesh.colors.iter().all(|c| c.w >= 1.0);
            }
        }
        for (material, _) in self.materials.iter_mut().zip(solid).filter(|(_, solid)| *solid) {
            material.alpha_mode = AlphaMode::Opaque;
        }
    }
}
