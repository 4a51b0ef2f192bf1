//! Paths that leave the scene: the environment, over lanes.

use super::rows::{COMPETES, Paths, Result, Rows};
use crate::emission::found_weight;
use crate::job::Job;
use crate::settings::Strategy;
use dapple_lights::lanes::probabilities;
use dapple_lights::{Environment, Light};
use dapple_math::lanes::{Kernel, MAX_LANES, Real, Word};
use glam::Vec3;

/// Adds the environment to the paths of some rows.
pub(super) struct Escapes<'a> {
    pub job: &'a Job<'a>,
    pub rows: &'a Rows,
    pub paths: &'a Paths,
    pub results: &'a mut [Result],
}

impl Kernel for Escapes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(mut self) {
        let scene = self.job.scene;
        let Some(index) = scene.environment.filter(|_| cfg!(not(without = "environment"))) else { return };
        let Light::Environment(environment) = &scene.lights[index as usize] else { return };
        for i in (0..self.rows.len).step_by(R::LANES) {
            self.step::<R>(i, (environment, index));
        }
    }
}

impl Escapes<'_> {
    #[inline(always)]
    fn step<R: Real>(&mut self, i: usize, (environment, index): (&Environment, u32)) {
        let (rows, paths) = (self.rows.row.load::<R::Word>(i), self.paths);
        let d = paths.d.gather::<R>(rows).normalize();
        let (radiance, pdf) = environment.radiance_and_pdf(d);
        let weight = self.weight::<R>(rows, index, pdf);
        let light = paths.beta.gather::<R>(rows) * (radiance * weight);
        let mut columns = [[0.0; MAX_LANES]; 3];
        let [x, y, z] = &mut columns;
        light.store([x, y, z]);
        self.add(i, R::LANES, &columns);
    }

    /// Adds the light of the lanes from row `i` of the list on.
    #[inline(never)]
    fn add(&mut self, i: usize, lanes: usize, [x, y, z]: &[[f32; MAX_LANES]; 3]) {
        let light = x.iter().zip(y).zip(z).map(|((x, y), z)| Vec3::new(*x, *y, *z));
        for (lane, light) in light.take(lanes.min(self.rows.len - i)).enumerate() {
            let place = self.paths.place.get(self.rows.row.get(i + lane) as usize) as usize;
            self.results[place].radiance += light;
        }
    }

    /// MIS weight of the environment: see [`crate::emission::escaped`].
    #[inline(always)]
    fn weight<R: Real>(&self, rows: R::Word, index: u32, pdf: R) -> R {
        let (paths, one) = (self.paths, R::splat(1.0));
        let Some(sampler) = &self.job.scene.light_choice else { return one };
        if self.job.settings.strategy == Strategy::BsdfOnly {
            return one;
        }
        let competes = (paths.flags.gather::<R::Word>(rows) & R::Word::splat(COMPETES)).ne(R::Word::splat(0));
        let (p, n) = (paths.p.gather::<R>(rows), paths.n.gather::<R>(rows));
        let pmf = probabilities::<R>(sampler, competes, p, n, R::Word::splat(index));
        let weight = found_weight(self.job.settings.strategy, paths.pdf.gather(rows), pmf * pdf);
        R::select(competes, weight, one)
    }
}
