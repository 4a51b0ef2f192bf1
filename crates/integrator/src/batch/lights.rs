//! Lights over lanes: the table of a scene, and light samples with the radiance of the sampled points.

use dapple_lights::lanes::{Chosen, Receiver, Sample, Table};
use dapple_lights::{LightPoint, LightSampler};
use dapple_math::lanes::{MAX_LANES, Mask, Real, Vec2x, Vec3x, Word};
use dapple_scene::Scene;
use glam::Vec3;

/// The lights of a scene, prepared for lanes.
pub(super) struct Lights {
    table: Table,
    /// Per light, 1 if its radiance varies over its surface; empty if there is no such light.
    patterned: Vec<u32>,
}

/// Light samples with the densities of both choices, of a light and of a direction.
#[derive(Clone, Copy)]
pub(super) struct Lit<R: Real> {
    pub sample: Sample<R>,
    pub index: R::Word,
    /// Density of the sample; 0 where there is none.
    pub pdf: R,
}

impl<R: Real> Lit<R> {
    /// No sample in any lane.
    #[inline(always)]
    pub fn none() -> Self {
        Self { sample: Sample::none(), index: R::Word::splat(0), pdf: R::splat(0.0) }
    }
}

impl Lights {
    pub fn new(scene: &Scene) -> Self {
        let mut patterned: Vec<u32> =
            (0..scene.lights.len() as u32).map(|light| u32::from(scene.is_patterned(light))).collect();
        if patterned.iter().all(|is| *is == 0) {
            patterned.clear();
        }
        Self { table: Table::new(&scene.lights), patterned }
    }

    /// Samples one light, and a point on it, for receivers with normal `n`.
    #[inline(always)]
    pub fn sample<R: Real>(
        &self,
        (scene, sampler): (&Scene, &LightSampler),
        active: R::Mask,
        (receiver, n): (Receiver<R>, Vec3x<R>),
        (uc, u): (R, Vec2x<R>),
    ) -> Lit<R> {
        let Chosen { index, pmf, .. } = Chosen::new(sampler, active, receiver.p, n, uc);
        let sample = self.table.sample(&scene.lights, active, index, receiver, u);
        Lit { sample, index, pdf: sample.pdf * pmf }
    }

    /// Radiance of the samples in the lanes of `mask`.
    #[inline(always)]
    pub fn radiance<R: Real>(&self, scene: &Scene, mask: R::Mask, lit: &Lit<R>, time: R) -> Vec3x<R> {
        let sample = &lit.sample;
        if self.patterned.is_empty() {
            return sample.radiance;
        }
        let is_patterned = R::Word::gather(&self.patterned, lit.index).ne(R::Word::splat(0));
        let mask = mask & is_patterned & sample.has_point & !sample.delta;
        if mask.any() { looked_up(scene, mask, lit, time) } else { sample.radiance }
    }
}

/// A number per lane.
type Lanes = [f32; MAX_LANES];

#[inline(always)]
fn looked_up<R: Real>(scene: &Scene, mask: R::Mask, lit: &Lit<R>, time: R) -> Vec3x<R> {
    let s = &lit.sample;
    let mut index = [0; MAX_LANES];
    lit.index.store(&mut index);
    let numbers = [
        s.p.x,
        s.p.y,
        s.p.z,
        s.p_error.x,
        s.p_error.y,
        s.p_error.z,
        s.n.x,
        s.n.y,
        s.n.z,
        s.triangle,
        s.u,
        s.v,
        time,
    ];
    let (mut columns, mut radiance) = ([[0.0; MAX_LANES]; 13], [[0.0; MAX_LANES]; 3]);
    for k in 0..13 {
        numbers[k].store(&mut columns[k]);
    }
    let [r, g, b] = &mut radiance;
    s.radiance.store([r, g, b]);
    look_up(scene, mask.bitmask(), &index, &columns, &mut radiance);
    let [r, g, b] = &radiance;
    Vec3x::load([r, g, b])
}

/// Replaces the radiance in the lanes of `mask`, one by one.
#[inline(never)]
fn look_up(
    scene: &Scene,
    mask: u32,
    index: &[u32; MAX_LANES],
    columns: &[Lanes; 13],
    radiance: &mut [Lanes; 3],
) {
    for i in (0..MAX_LANES).filter(|i| mask >> i & 1 == 1) {
        let vector = |k: usize| Vec3::new(columns[k][i], columns[k + 1][i], columns[k + 2][i]);
        let (triangle, u, v) = (columns[9][i] as u32, columns[10][i], columns[11][i]);
        let point = LightPoint { p: vector(0), p_error: vector(3), n: vector(6), triangle, u, v };
        let mean = Vec3::new(radiance[0][i], radiance[1][i], radiance[2][i]);
        let at = scene.light_radiance(index[i], &point, mean, columns[12][i]);
        (radiance[0][i], radiance[1][i], radiance[2][i]) = (at.x, at.y, at.z);
    }
}
