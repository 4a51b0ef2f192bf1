//! Material parameters over lanes, and their columns.

use super::fresnel::{Schlick, normal_reflectance};
use crate::Material;
use dapple_math::lanes::{Real, Vec3x, Word};
use glam::Vec3;

/// The parameters of one material per lane; their meaning is that of the fields of [`Material`].
#[derive(Clone, Copy, Debug)]
pub struct Parameters<R: Real> {
    /// Reflectance of the diffuse base and of metals along the normal, and tint of transmitted light.
    pub base_color: Vec3x<R>,
    /// Share of metal.
    pub metallic: R,
    /// Perceptual roughness.
    pub roughness: R,
    /// Index of refraction of the inside relative to the outside, or 0.
    pub ior: R,
    /// Strength of the dielectric reflection.
    pub specular: R,
    /// Tint of the dielectric reflection along the normal.
    pub specular_color: Vec3x<R>,
    /// Fraction of the light entering the dielectric that is transmitted.
    pub transmission: R,
    /// Whether the surface is an infinitely thin wall.
    pub thin: R::Mask,
}

impl From<&Material> for Parameters<f32> {
    fn from(material: &Material) -> Self {
        Self {
            base_color: material.base_color.into(),
            metallic: material.metallic,
            roughness: material.roughness,
            ior: material.ior,
            specular: material.specular,
            specular_color: material.specular_color.into(),
            transmission: material.transmission,
            thin: material.thin,
        }
    }
}

/// Clamps to 0..1; NaN becomes 0.
#[inline(always)]
pub fn clamped<R: Real>(x: R) -> R {
    x.max(R::splat(0.0)).min(R::splat(1.0))
}

impl<R: Real> Parameters<R> {
    /// Whether some light is transmitted, as [`Material::has_transmission`].
    #[inline(always)]
    pub fn has_transmission(&self) -> R::Mask {
        self.transmission.gt(R::splat(0.0))
    }

    /// Whether transmission is among the parameters of the surface, which [`Layers::opaque`](super::Layers::opaque)
    /// does not have.
    #[inline(always)]
    pub fn is_transmissive(&self) -> R::Mask {
        !self.transmission.eq(R::splat(0.0))
    }

    /// Whether the surface is a diffuse one without a coat, for which [`Lambert`](super::Lambert) suffices.
    #[inline(always)]
    pub fn is_lambert(&self) -> R::Mask {
        let zero = R::splat(0.0);
        self.specular.eq(zero) & self.metallic.eq(zero) & self.transmission.eq(zero)
    }

    /// Returns the base colour, with channels clamped to finite numbers from 0; NaN becomes 0.
    #[inline(always)]
    pub fn base(&self) -> Vec3x<R> {
        self.base_color.max(Vec3x::splat(Vec3::ZERO)).min(Vec3x::splat(Vec3::MAX))
    }

    /// Returns the Fresnel term of the dielectric, `KHR_materials_ior` and `_specular`: F0 = min(r0·colour,
    /// 1)·specular, F90 = specular.
    #[inline(always)]
    pub fn dielectric(&self) -> Schlick<R> {
        let specular = clamped(self.specular);
        let r0 = normal_reflectance(self.ior.max(R::splat(0.0)));
        let f0 = self.specular_color * r0;
        let f0 = Vec3x::new(clamped(f0.x), clamped(f0.y), clamped(f0.z)) * specular;
        Schlick { f0, f90: specular }
    }

    /// Returns α, the square of the roughness.
    #[inline(always)]
    pub fn alpha(&self) -> R {
        let roughness = clamped(self.roughness);
        roughness * roughness
    }
}

/// Number of columns of numbers.
const COLUMNS: usize = 11;

/// The parameters of many points, one column per number. A mirror's are not among them.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    numbers: [Vec<f32>; COLUMNS],
    thin: Vec<u32>,
}

impl Columns {
    /// Makes columns for `n` points with parameters of 0.
    pub fn new(n: usize) -> Self {
        Self { numbers: std::array::from_fn(|_| vec![0.0; n]), thin: vec![0; n] }
    }

    /// Sets the parameters of point `i`. A point beyond the columns is ignored.
    #[inline]
    pub fn set(&mut self, i: usize, material: &Material) {
        let Some(thin) = self.thin.get_mut(i) else { return };
        *thin = u32::from(material.thin);
        let (base, tint) = (material.base_color, material.specular_color);
        let numbers: [f32; COLUMNS] = [
            base.x,
            base.y,
            base.z,
            material.metallic,
            material.roughness,
            material.ior,
            material.specular,
            tint.x,
            tint.y,
            tint.z,
            material.transmission,
        ];
        for (column, x) in self.numbers.iter_mut().zip(numbers) {
            column[i] = x;
        }
    }

    /// Reads the parameters of point `i` and the following ones, one per lane. Beyond the columns they are 0.
    #[inline(always)]
    pub fn load<R: Real>(&self, i: usize) -> Parameters<R> {
        let [r, g, b, metallic, roughness, ior, specular, sr, sg, sb, transmission] = &self.numbers;
        Parameters {
            base_color: Vec3x::new(load(r, i), load(g, i), load(b, i)),
            metallic: load(metallic, i),
            roughness: load(roughness, i),
            ior: load(ior, i),
            specular: load(specular, i),
            specular_color: Vec3x::new(load(sr, i), load(sg, i), load(sb, i)),
            transmission: load(transmission, i),
            thin: R::Word::load(self.thin.get(i..).unwrap_or_default()).ne(R::Word::splat(0)),
        }
    }
}

#[inline(always)]
fn load<R: Real>(column: &[f32], i: usize) -> R {
    R::load(column.get(i..).unwrap_or_default())
}
