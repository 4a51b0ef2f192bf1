//! Evaluation of the emission of a material on a surface.
use crate::{AlphaMode, TextureUse, TexturedMaterial};
use dapple_geometry::{Accel, Hit};
use dapple_imaging::Texture;
use glam::{DVec3, Vec2, Vec3};

/// Data on which the emission of an object depends.
#[derive(Clone, Copy)]
pub(crate) struct Emitter<'a> {
    pub accel: &'a Accel,
    pub textures: &'a [Texture],
    pub material: &'a TexturedMaterial,
}

impl Emitter<'_> {
    /// Whether radiance × opacity is constant over the surface.
    pub fn is_constant(&self) -> bool {
        let m = self.material;
        m.emissive_texture.is_none() && m.alpha_mode == AlphaMode::Opaque
    }

    /// Radiance × opacity at a point: the expected radiance along a ray, as the surface is absent with probability
    /// 1 − opacity.
    pub fn radiance(&self, hit: &Hit) -> Vec3 {
        self.material.radiance(self.accel, self.textures, hit)
            * self.material.opacity(self.accel, self.textures, hit)
    }

    /// Mean over a sphere or disk at points of uniform area density, as many as there are texels up to a million
    /// (*approximation* for finer textures, as for triangles). If all points are black the light is kept, with the
    /// smallest positive radiance.
    pub fn mean_of_shape(&self, object: u32) -> Vec3 {
        if self.is_constant() {
            return self.material.emission;
        }
        let size = |t: &TextureUse| self.textures[t.texture as usize].size();
        let maps = [&self.material.emissive_texture, &self.material.base_color_texture];
        let (w, h) = maps.into_iter().flatten().map(size).fold((1, 1), |a, b| (a.0.max(b.0), a.1.max(b.1)));
        let (w, h) = (w.clamp(64, 1024), h.clamp(64, 1024));
        let mut sum = DVec3::ZERO;
        for i in 0..w * h {
            let (x, y) = (((i % w) as f32 + 0.5) / w as f32, ((i / w) as f32 + 0.5) / h as f32);
            let at = self.accel.even_coordinates(object, Vec2::new(x, y));
            sum += self.radiance(&Hit { t: 0.0, u: at.x, v: at.y, primitive: 0, object }).as_dvec3();
        }
        (sum / (w * h) as f64).as_vec3().max(Vec3::splat(f32::MIN_POSITIVE))
    }
}
