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

    /// Writes the parameters of point `i` and the following ones, one per lane, as far as the columns reach.
    #[inline(always)]
    pub fn store<R: Real>(&mut self, i: usize, of: &Parameters<R>) {
        let [r, g, b, metallic, roughness, ior, specular, sr, sg, sb, transmission] = &mut self.numbers;
        let (base, tint) = (of.base_color, of.specular_color);
        let (one, zero) = (R::Word::splat(1), R::Word::splat(0));
        store(r, i, base.x);
        store(g, i, base.y);
        store(b, i, base.z);
        store(metallic, i, of.metallic);
        store(roughness, i, of.roughness);
        store(ior, i, of.ior);
        store(specular, i, of.specular);
        store(sr, i, tint.x);
        store(sg, i, tint.y);
        store(sb, i, tint.z);
        store(transmission, i, of.transmission);
        R::Word::select(of.thin, one, zero).store(self.thin.get_mut(i..).unwrap_or_default());
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

#[inline(always)]
fn store<R: Real>(column: &mut [f32], i: usize, x: R) {
    x.store(column.get_mut(i..).unwrap_or_default());
}

/// The parameters of some materials, which points refer to by index. A mirror's are not among them.
#[derive(Clone, Debug, Default)]
pub struct Palette {
    /// Three rows per material.
    rows: Vec<[f32; 4]>,
}

impl Palette {
    /// Makes a palette of materials.
    pub fn new<'a>(materials: impl Iterator<Item = &'a Material>) -> Self {
        let rows = materials.flat_map(|material| {
            let (base, tint) = (material.base_color, material.specular_color);
            let thin = f32::from(u8::from(material.thin));
            [
                [base.x, base.y, base.z, material.metallic],
                [tint.x, tint.y, tint.z, material.specular],
                [material.roughness, material.ior, material.transmission, thin],
            ]
        });
        Self { rows: rows.collect() }
    }

    /// Reads the parameters of one material per lane. An index beyond the palette reads some material of it.
    #[inline(always)]
    pub fn gather<R: Real>(&self, index: R::Word) -> Parameters<R> {
        let row = (index << 1).wrapping_add(index);
        let [r, g, b, metallic] = R::gather_rows(&self.rows, row);
        let [sr, sg, sb, specular] = R::gather_rows(&self.rows, row.wrapping_add(R::Word::splat(1)));
        let [roughness, ior, transmission, thin] =
            R::gather_rows(&self.rows, row.wrapping_add(R::Word::splat(2)));
        Parameters {
            base_color: Vec3x::new(r, g, b),
            metallic,
            roughness,
            ior,
            specular,
            specular_color: Vec3x::new(sr, sg, sb),
            transmission,
            thin: thin.ne(R::splat(0.0)),
        }
    }
}
