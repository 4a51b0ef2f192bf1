//! Is what was added fit to be a scene? What is wrong, how large it is, and what can be made simpler.
use super::{Geometry, SceneBuilder};
use crate::{AlphaMode, SceneError, Space, TextureUse, TexturedMaterial, error::quoted, slots::SLOTS};
use dapple_geometry::bvh::Tree;
use glam::DVec3;
use std::collections::HashSet;

/// Most triangles a scene may have once every instance is placed: all may end in one tree.
const MAX_TRIANGLES: usize = Tree::MOST_TRIANGLES;
/// World coordinates beyond this are taken for errors; f64 arithmetic on them stays finite.
const FARTHEST: f64 = 1e300;

impl SceneBuilder {
    /// The first thing that is wrong.
    pub(super) fn check(&self) -> Result<(), SceneError> {
        for (i, m) in self.materials.iter().enumerate() {
            let place = || format!("material {i} '{}'", quoted(&m.name));
            if let Some(factor) = m.bad_factor() {
                return Err(self.invalid(place(), format!("{factor} must be finite and not negative")));
            }
            let bad = |t: &TextureUse| t.texture as usize >= self.textures.len() || t.uv_set > 1;
            if let Some(slot) = SLOTS.iter().find(|slot| (slot.of)(m).as_ref().is_some_and(bad)) {
                let what = "uses a texture or a set of coordinates that is not there";
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
            let what = format!("has {triangles} triangles; at most {MAX_TRIANGLES} fit");
            return Err(self.invalid("the scene", what));
        }
        Ok(())
    }

    /// World box of everything that can be hit, when the shutter opens: a thing that then flies off changes nothing about
    /// the space the rest is rendered in.
    pub(super) fn bounds(&self) -> Result<Option<(DVec3, DVec3)>, SceneError> {
        let mut all: Option<(DVec3, DVec3)> = None;
        for (i, placed) in self.placed.iter().enumerate() {
            let Some((min, max)) = placed.bounds(&self.exposure) else { continue };
            if !(min.min_element() >= -FARTHEST && max.max_element() <= FARTHEST) {
                let what = "is placed beyond every number dapple can work with";
                return Err(self.invalid(format!("object {i} '{}'", quoted(&placed.name)), what));
            }
            all = Some(all.map_or((min, max), |(a, b)| (a.min(min), b.max(max))));
        }
        Ok(all)
    }

    /// What hangs on a chain but stands still while the shutter is open becomes a thing that stands still.
    pub(super) fn settle(&mut self) {
        let exposure = self.exposure;
        for placed in &mut self.placed {
            if let Geometry::Moving { body, chain } = &placed.geometry
                && !exposure.is_moving(&exposure.motion(chain, &Space::IDENTITY))
            {
                placed.geometry = body.standing(&exposure.placement(chain));
            }
        }
    }

    /// Masks and blends that let nothing through become opaque: traversal need not ask.
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
