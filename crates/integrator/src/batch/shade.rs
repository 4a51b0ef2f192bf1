//! Third stage: direct light and scattering at vertices, over lanes.

use super::camera::Asked;
use super::lights::{Lights, Lit};
use super::points::{PointSet, Samples};
use super::rows::{COMPETES, Cuts, IS_SEEN, Paths, Shadows, Vertices};
use crate::Dimension;
use crate::bias_report::Truncation;
use crate::direct::light_weight;
use crate::job::Job;
use crate::normals::Tilt;
use crate::path::{backward, is_faint, roulette};
use crate::scatter::onward;
use crate::settings::ROULETTE_FROM;
use crate::vertex::Facing;
use dapple_lights::lanes::Receiver;
use dapple_materials::lanes::{self as bsdf, Bsdf, Lambert, Layers, Parameters, face, meets};
use dapple_materials::{Lobes, lanes::Kind};
use dapple_math::lanes::{Framex, Kernel, MAX_LANES, Mask, Real, Vec2x, Vec3x, Word};
use dapple_math::offset::offset_origins;
use dapple_sampling::lanes::Keyx;
use dapple_sampling::lanes::pattern::Index;
use glam::Vec3;

/// Scatters the paths at their vertices: `next` receives those that go on, `shadows` the light to be tested.
pub(super) struct Shading<'a> {
    pub job: &'a Job<'a>,
    pub lights: &'a Lights,
    pub depth: u32,
    pub set: PointSet,
    pub asked: &'a Asked,
    pub paths: &'a Paths,
    pub vertices: &'a Vertices,
    pub next: &'a mut Paths,
    pub shadows: &'a mut Shadows,
    pub cuts: &'a mut Cuts,
    /// Receives the rows that are scattered alone, because one of their rays passes over its facet.
    pub over: &'a mut Vec<u32>,
}

/// Vertices of one step.
#[derive(Clone, Copy)]
struct At<R: Real> {
    row: usize,
    active: R::Mask,
    samples: Samples<R>,
    p: Vec3x<R>,
    frame: Framex<R>,
    facing: Facing<R>,
    beta: Vec3x<R>,
    /// Normal for the choice of lights.
    n: Vec3x<R>,
    /// The tilts, and the lanes that have one.
    tilt: Option<(Tilt<R>, R::Mask)>,
}

/// Directions of light samples, as the BSDF sees them.
#[derive(Clone, Copy)]
struct Towards<R: Real> {
    local: Vec3x<R>,
    /// Density of the direction over that of the local one.
    density: R,
    /// The shading normal and the surface agree on reflection or transmission.
    agrees: R::Mask,
}

/// Directions in which paths go on.
#[derive(Clone, Copy)]
struct Away<R: Real> {
    wi: Vec3x<R>,
    pdf: R,
    exists: R::Mask,
}

/// What the BSDF makes of a light sample and of the numbers of a direction.
#[derive(Clone, Copy)]
struct Scattered<R: Real> {
    f: Vec3x<R>,
    pdf: R,
    sample: bsdf::Sample<R>,
    passes: R::Mask,
}

impl Kernel for Shading<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(mut self) {
        for i in (0..self.paths.len).step_by(R::LANES) {
            let within = R::Mask::first(self.paths.len - i);
            let active = within & self.vertices.live.load::<R::Word>(i).ne(R::Word::splat(0));
            if active.any() {
                self.step::<R>(i, active);
            }
        }
    }
}

impl Shading<'_> {
    #[inline(always)]
    fn step<R: Real>(&mut self, row: usize, active: R::Mask) {
        let (paths, vertices) = (self.paths, self.vertices);
        let key = Keyx::from_words([paths.key[0].load(row), paths.key[1].load(row)]);
        let samples = Samples { set: self.set, key, s: Index::new(paths.s.load(row)) };
        let along = paths.d.load(row);
        let [x, y, z] = &vertices.frame;
        let frame = Framex { x: x.load(row), y: y.load(row), z: z.load(row) };
        let (wo, _) = backward::<R>(along);
        let facing = Facing { ng: vertices.ng.load(row), ns: frame.z, wo };
        let material = vertices.materials.load::<R>(row);
        let transmits = material.has_transmission();
        let mut n = facing.seen_normal();
        let tilt = match vertices.tilts.any {
            true => Some(vertices.tilts.load::<R>(row)),
            false => None,
        };
        if let Some((tilt, tilted)) = &tilt {
            n = Vec3x::select(*tilted, tilt.horizon, n);
        }
        let n = Vec3x::select(transmits, Vec3x::splat(Vec3::ZERO), n);
        let (p, beta) = (vertices.p.load(row), paths.beta.load(row));
        let mut at = At { row, active, samples, p, frame, facing, beta, n, tilt };
        let lit = self.lit(&at);
        let towards = at.towards(lit.sample.wi);
        let scattered = self.scattered(&at, &material, towards.local);
        let away = at.away(along, &scattered);
        let f_cos = self.received(&lit, &towards, &scattered);
        let reached = active & lit.sample.pdf.gt(R::splat(0.0)) & towards.agrees & differs(f_cos);
        let over = at.over((lit.sample.wi, reached), (away.wi, active & away.exists));
        if over.any() {
            at.active = active & !over;
            note_rows(self.over, row, over.bitmask());
        }
        self.light(&at, &lit, f_cos, reached & at.active);
        self.go_on(&at, &away, &scattered);
    }

    /// A light sample per lane.
    #[inline(always)]
    fn lit<R: Real>(&self, at: &At<R>) -> Lit<R> {
        let (scene, needs, zero) = (self.job.scene, self.job.needs, R::splat(0.0));
        let Some(sampler) = scene.light_choice.as_ref().filter(|_| needs.next_event) else {
            return Lit::none();
        };
        let uc = match needs.light_choice {
            true => at.samples.point_1d(self.depth, Dimension::Light),
            false => zero,
        };
        let u = match needs.light_point {
            true => at.samples.point_2d(self.depth, Dimension::LightPoint),
            false => Vec2x::new(zero, zero),
        };
        let receiver = Receiver { p: at.p, time: self.time(at.row) };
        self.lights.sample((scene, sampler), at.active, (receiver, at.n), (uc, u))
    }

    #[inline(always)]
    fn time<R: Real>(&self, row: usize) -> R {
        if self.job.needs.time { self.asked.time.gather(self.paths.place.load(row)) } else { R::splat(0.0) }
    }

    /// The BSDF towards the light, and a direction that it scatters to.
    #[inline(always)]
    fn scattered<R: Real>(&self, at: &At<R>, material: &Parameters<R>, local: Vec3x<R>) -> Scattered<R> {
        let (needs, zero) = (self.job.needs, R::splat(0.0));
        let uc = if needs.lobe { at.samples.point_1d(self.depth, Dimension::Lobe) } else { zero };
        let u = match needs.direction {
            true => at.samples.point_2d(self.depth, Dimension::Direction),
            false => Vec2x::new(zero, zero),
        };
        let (wo, side) = face(at.frame.to_local(at.facing.wo));
        if (material.is_lambert() | !at.active).all() {
            return Scattered::by(&Bsdf::new((wo, side), Lambert::new(material)), local, uc, u);
        }
        let mut losing_as = None;
        if let Some((tilt, tilted)) = &at.tilt {
            let mapped = *tilted & tilt.is_mapped;
            if (mapped & at.active).any() {
                losing_as = Some(R::select(mapped, tilt.unmapped, wo.z));
            }
        }
        if !(material.is_transmissive() & at.active).any() {
            let layers = Layers::opaque(material, wo, losing_as);
            return Scattered::by(&Bsdf::new((wo, side), layers), local, uc, u);
        }
        Scattered::by(&Bsdf::new((wo, side), Layers::new(material, wo, side, losing_as)), local, uc, u)
    }

    /// f·cosθ of the light samples, weighted against BSDF sampling.
    #[inline(always)]
    fn received<R: Real>(&self, lit: &Lit<R>, towards: &Towards<R>, scattered: &Scattered<R>) -> Vec3x<R> {
        let pdf = scattered.pdf * towards.density;
        let weight = light_weight(self.job.settings.strategy, lit.sample.delta, lit.pdf, pdf);
        scattered.f * (towards.local.z.abs() * towards.density) * weight
    }

    /// Adds the shadow rays of the light samples that carry light.
    #[inline(always)]
    fn light<R: Real>(&mut self, at: &At<R>, lit: &Lit<R>, f_cos: Vec3x<R>, reached: R::Mask) {
        let (wi, vertices) = (lit.sample.wi, self.vertices);
        if !reached.any() {
            return;
        }
        let radiance = self.lights.radiance(self.job.scene, reached, lit, self.time(at.row));
        let value = f_cos * radiance / lit.pdf;
        let reached = reached & differs(value);
        let is_nan = value.x.ne(value.x) | value.y.ne(value.y) | value.z.ne(value.z);
        let (start, error) = (vertices.start.load(at.row), vertices.p_error.load(at.row));
        let o = offset_origins(start, error, at.facing.ng, wi);
        let (d, t_max) = lit.sample.shadow_ray(o);
        let shadows = &mut *self.shadows;
        let i = shadows.len;
        shadows.o.pack(i, reached, o);
        shadows.d.pack(i, reached, d);
        shadows.t_max.pack(i, reached, R::select(is_nan, R::splat(-1.0), t_max));
        shadows.light.pack(i, reached, at.beta * value);
        let row = R::Word::splat(at.row as u32).wrapping_add(R::Word::lane_index());
        shadows.row.pack(i, reached, row);
        shadows.len += shadows.place.pack(i, reached, self.paths.place.load::<R::Word>(at.row));
    }

    /// Adds the paths that go on.
    #[inline(always)]
    fn go_on<R: Real>(&mut self, at: &At<R>, away: &Away<R>, scattered: &Scattered<R>) {
        let (sample, vertices, row, wi) = (&scattered.sample, self.vertices, at.row, away.wi);
        let go = at.active & away.exists;
        let mut beta = at.beta * sample.weight;
        let eta = self.paths.eta.load::<R>(row) * sample.eta;
        let faint = go & is_faint(beta);
        if faint.any() {
            self.cut(faint, row, beta);
        }
        let mut go = go & !faint;
        if self.depth >= ROULETTE_FROM && self.job.roulette {
            let u = at.samples.point_1d(self.depth, Dimension::Roulette);
            let (left, survives) = roulette(beta, eta, u);
            (beta, go) = (left, go & survives);
        }
        let (start, error) = (vertices.start.load(row), vertices.p_error.load(row));
        let o = offset_origins(start, error, at.facing.ng, wi);
        let is_delta = meets(sample.lobe, Lobes::DELTA);
        let (seen, competes) = (R::Word::splat(IS_SEEN), R::Word::splat(COMPETES));
        let flags = self.paths.flags.load::<R::Word>(row) & seen;
        let (next, paths) = (&mut *self.next, self.paths);
        let i = next.len;
        next.o.pack(i, go, o);
        next.d.pack(i, go, wi);
        next.beta.pack(i, go, beta);
        next.eta.pack(i, go, eta);
        next.p.pack(i, go, at.p);
        next.n.pack(i, go, at.n);
        next.pdf.pack(i, go, away.pdf);
        next.t_max.pack(i, go, R::splat(f32::INFINITY));
        next.flags.pack(i, go, R::Word::select(is_delta, flags, competes));
        next.key[0].pack(i, go, paths.key[0].load::<R::Word>(row));
        next.key[1].pack(i, go, paths.key[1].load::<R::Word>(row));
        next.s.pack(i, go, paths.s.load::<R::Word>(row));
        next.len += next.place.pack(i, go, paths.place.load::<R::Word>(row));
    }

    /// Notes the truncation of faint paths.
    #[inline(always)]
    fn cut<R: Real>(&mut self, mask: R::Mask, row: usize, beta: Vec3x<R>) {
        let mut columns = [[0.0; MAX_LANES]; 3];
        let [x, y, z] = &mut columns;
        beta.store([x, y, z]);
        note_cuts(self.cuts, mask.bitmask(), self.paths, row, &columns);
    }
}

#[cold]
#[inline(never)]
fn note_rows(rows: &mut Vec<u32>, first: usize, mask: u32) {
    rows.extend((0..MAX_LANES as u32).filter(|i| mask >> i & 1 == 1).map(|i| first as u32 + i));
}

#[cold]
#[inline(never)]
fn note_cuts(cuts: &mut Cuts, mask: u32, paths: &Paths, row: usize, [x, y, z]: &[[f32; MAX_LANES]; 3]) {
    for i in (0..MAX_LANES).filter(|i| mask >> i & 1 == 1) {
        cuts.add(paths.place.get(row + i) as usize, Truncation::Faint, Vec3::new(x[i], y[i], z[i]));
    }
}

impl<R: Real> At<R> {
    #[inline(always)]
    fn towards(&self, wi: Vec3x<R>) -> Towards<R> {
        let one = R::splat(1.0);
        let Some((tilt, tilted)) = &self.tilt else {
            let local = self.frame.to_local(wi);
            return Towards { local, density: one, agrees: !self.facing.leaks(wi, local) };
        };
        let (w, density, reflects) = tilt.before(wi);
        let local = self.frame.to_local(Vec3x::select(*tilted, w, wi));
        let agrees = !(self.facing.reflects(local) ^ reflects);
        let agrees = (*tilted & agrees) | (!*tilted & !self.facing.leaks(wi, local));
        Towards { local, density: R::select(*tilted, density, one), agrees }
    }

    #[inline(always)]
    fn away(&self, along: Vec3x<R>, scattered: &Scattered<R>) -> Away<R> {
        let sample = &scattered.sample;
        let wi = onward(&self.frame, scattered.passes, along, sample.wi);
        let exists = sample.exists() & differs(sample.weight);
        let stays = !self.facing.leaks(wi, sample.wi);
        let Some((tilt, tilted)) = &self.tilt else {
            return Away { wi, pdf: sample.pdf, exists: exists & stays };
        };
        let tilted = *tilted & !scattered.passes;
        let (turned, density, leaves) = tilt.leave(wi, self.facing.reflects(sample.wi));
        let is_delta = meets(sample.lobe, Lobes::DELTA);
        Away {
            wi: Vec3x::select(tilted, turned, wi),
            pdf: R::select(tilted & !is_delta, sample.pdf * density, sample.pdf),
            exists: exists & ((tilted & leaves) | (!tilted & stays)),
        }
    }

    /// Whether a ray along one of the directions in the lanes of its mask passes over the facet.
    #[inline(always)]
    fn over(&self, lit: (Vec3x<R>, R::Mask), away: (Vec3x<R>, R::Mask)) -> R::Mask {
        let Some((tilt, tilted)) = &self.tilt else { return R::Mask::splat(false) };
        let (up, zero) = (self.facing.seen_normal(), R::splat(0.0));
        let below = (lit.1 & lit.0.dot(up).le(zero)) | (away.1 & away.0.dot(up).le(zero));
        *tilted & tilt.is_over & below
    }
}

impl<R: Real> Scattered<R> {
    #[inline(always)]
    fn by<K: Kind<R>>(bsdf: &Bsdf<R, K>, local: Vec3x<R>, uc: R, u: Vec2x<R>) -> Self {
        let all = Lobes::ALL.splat();
        let (f, pdf) = bsdf.eval(local, all);
        let sample = bsdf.sample_f(uc, u, all);
        Self { f, pdf, sample, passes: bsdf.passes(sample.wi) }
    }
}

/// Whether a vector is not zero.
#[inline(always)]
fn differs<R: Real>(v: Vec3x<R>) -> R::Mask {
    let zero = R::splat(0.0);
    v.x.ne(zero) | v.y.ne(zero) | v.z.ne(zero)
}
