//! Materials that vary over a surface: their textures are looked up one by one, their shading frames are computed over
//! lanes.

use super::rows::Hits;
use dapple_materials::lanes::Columns;
use dapple_math::lanes::{Framex, MAX_LANES, Mask, Real, Vec3x};
use dapple_scene::{MappedNormal, Scene};
use glam::Vec3;

/// What the textures of some lanes say, apart from the parameters of the materials.
#[derive(Default)]
pub(super) struct Looked {
    /// Tangents, with the sign of the bitangent, in the lanes of `has_tangent`.
    tangent: [[f32; MAX_LANES]; 4],
    has_tangent: u32,
    /// Normals of normal maps in tangent space, in the lanes of `has_normal`.
    normal: [[f32; MAX_LANES]; 3],
    has_normal: u32,
    /// The lanes that emit light towards the viewer.
    lit: u32,
}

impl Looked {
    /// Looks up the hits in the lanes of `mask` from row `i` on, and sets the parameters of their materials. `front`:
    /// the lanes that are seen from the front.
    #[inline(never)]
    pub fn up(
        scene: &Scene,
        (mask, front): (u32, u32),
        (i, time): (usize, impl Fn(usize) -> f32),
        hits: &Hits,
        materials: &mut Columns,
    ) -> Self {
        let mut looked = Self::default();
        for lane in (0..MAX_LANES).filter(|lane| mask >> lane & 1 == 1) {
            let Some(hit) = hits.get(i + lane) else { continue };
            let texels = scene.texels(&hit, time(i + lane));
            materials.set(i + lane, &texels.material);
            if let Some(t) = texels.tangent {
                looked.has_tangent |= 1 << lane;
                looked.tangent.iter_mut().zip(t.to_array()).for_each(|(column, x)| column[lane] = x);
            }
            if let Some(n) = texels.normal {
                looked.has_normal |= 1 << lane;
                looked.normal.iter_mut().zip(n.to_array()).for_each(|(column, x)| column[lane] = x);
            }
            let emits = front >> lane & 1 == 1 || scene.is_double_sided(hit.object);
            if emits && texels.emission != Vec3::ZERO {
                looked.lit |= 1 << lane;
            }
        }
        looked
    }

    /// The lanes that emit light.
    #[inline(always)]
    pub fn lit<R: Real>(&self) -> R::Mask {
        R::Mask::from_bitmask(self.lit)
    }

    /// The shading frames of surfaces with interpolated normals `ns` and geometric normals `ng`.
    #[inline(always)]
    pub fn frames<R: Real>(&self, ns: Vec3x<R>, ng: Vec3x<R>) -> Framex<R> {
        let plain = Framex::from_z(ns);
        if self.has_tangent == 0 {
            return plain;
        }
        let ([tx, ty, tz, sign], [x, y, z]) = (&self.tangent, &self.normal);
        let mapped = MappedNormal {
            tangent: Vec3x::load([tx, ty, tz]),
            sign: R::load(sign),
            normal: Vec3x::load([x, y, z]),
            is_sound: R::Mask::from_bitmask(self.has_normal),
        };
        let frame = mapped.frame(ns, ng);
        Framex::select(R::Mask::from_bitmask(self.has_tangent), frame, plain)
    }
}
