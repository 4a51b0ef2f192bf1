//! Vertices over lanes: surfaces, shading frames and materials of hits.

use super::camera::Asked;
use super::rows::{HOLDS, Hits, Paths, Vertices};
use super::textured::Looked;
use crate::job::Job;
use crate::normals::{Turned, leans};
use crate::path::backward;
use crate::vertex::is_upright;
use dapple_geometry::Facets;
use dapple_materials::Lobe;
use dapple_materials::lanes::Palette;
use dapple_math::lanes::{Framex, Kernel, Mask, Real, Word};
use dapple_scene::AlphaMode;

/// In place of the material of objects whose vertices are computed one by one.
const ALONE: u32 = u32::MAX;
/// In place of the material of objects whose materials vary over the surface.
const VARIES: u32 = u32::MAX - 1;

/// The materials of objects.
pub(super) struct Materials {
    /// Per object: index into the palette, [`VARIES`] or [`ALONE`].
    of_object: Vec<u32>,
    palette: Palette,
    /// Objects at which paths pass surfaces straight, enter bodies, or ask for alpha; empty if there are none.
    special: Vec<bool>,
    /// Camera rays start within bodies, or their first hits are recorded.
    pub first_is_special: bool,
}

impl Materials {
    /// `watched`: first hits are recorded.
    pub fn new(job: &Job<'_>, watched: bool) -> Self {
        let scene = job.scene;
        let objects = 0..scene.objects.len() as u32;
        let mut special: Vec<bool> = objects.map(|object| is_special(job, object)).collect();
        let mut materials = Vec::new();
        let mut index = |object: u32| {
            let of = scene.material(object);
            if special[object as usize] || of.unlit || of.is_mirror() {
                return ALONE;
            }
            if scene.has_varying_material(object) {
                return VARIES;
            }
            // What is left has one material, or emits light.
            scene.uniform_material(object).map_or(ALONE, |material| {
                materials.push(material);
                materials.len() as u32 - 1
            })
        };
        let of_object = (0..scene.objects.len() as u32).map(&mut index).collect();
        if !special.contains(&true) {
            special.clear();
        }
        let first_is_special = watched || !job.media.starts_outside();
        Self { of_object, palette: Palette::new(materials.into_iter()), special, first_is_special }
    }

    #[inline(always)]
    pub fn is_special(&self, object: u32) -> bool {
        self.special.get(object as usize).is_some_and(|is| *is)
    }
}

/// Whether hits of an object need more than the nearest opaque surface and the state in [`Paths`].
fn is_special(job: &Job<'_>, object: u32) -> bool {
    let material = job.scene.material(object);
    let passes = material.lobe_bounds().contains(Lobe::DeltaTransmission);
    let is_boundary = !job.media.is_empty() && job.scene.objects[object as usize].body != u32::MAX;
    let has_holes = material.alpha_mode != AlphaMode::Opaque || (job.is_culled() && !material.double_sided);
    passes || is_boundary || has_holes
}

/// Computes the vertices of the rows that lanes cover, and lists the other rows in which anything remains to be done.
pub(super) struct Surfaces<'a> {
    pub job: &'a Job<'a>,
    pub facets: &'a Facets,
    pub materials: &'a Materials,
    pub depth: u32,
    pub asked: &'a Asked,
    pub paths: &'a Paths,
    pub hits: &'a Hits,
    pub vertices: &'a mut Vertices,
}

impl Kernel for Surfaces<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(mut self) {
        (self.vertices.odd.len, self.vertices.escaped.len) = (0, 0);
        for i in (0..self.paths.len).step_by(R::LANES) {
            self.step::<R>(i, R::Mask::first(self.paths.len - i));
        }
    }
}

impl Surfaces<'_> {
    #[inline(always)]
    fn step<R: Real>(&mut self, i: usize, within: R::Mask) {
        let (job, paths, hits, vertices) = (self.job, self.paths, self.hits, &mut *self.vertices);
        let (object, d) = (hits.object.load::<R::Word>(i), paths.d.load::<R>(i));
        let is_hit = object.ne(R::Word::splat(u32::MAX));
        let (wo, _) = backward(d);
        let (u, v) = (hits.u.load(i), hits.v.load(i));
        let at = self.facets.surfaces::<R>((object, hits.primitive.load(i)), (u, v), wo);
        let index = R::Word::gather(&self.materials.of_object, object);
        let material = self.materials.palette.gather::<R>(index);
        let holds = (paths.flags.load::<R::Word>(i) & R::Word::splat(HOLDS)).ne(R::Word::splat(0));
        let is_usual = paths.beta.load::<R>(i).is_finite() & !holds;
        let is_lost = within & !is_hit & is_usual;
        if job.scene.environment.is_some() {
            vertices.escaped.pack::<R::Word>(i, is_lost);
        }
        // At the last depth, paths end one by one.
        let goes_on = R::Mask::splat(self.depth < job.bounces);
        let mut live = within & is_hit & at.known & is_usual & goes_on & index.ne(R::Word::splat(ALONE));
        if self.depth == 0 {
            live = live & !job.may_pass_first(hits.t.load(i), at.ng, d);
        }
        vertices.materials.store(i, &material);
        let plain = Framex::from_z(at.ns);
        let (mut frame, mut transmits) = (plain, material.has_transmission());
        let varies = live & index.eq(R::Word::splat(VARIES));
        let height = at.ng.dot(wo);
        if varies.any() {
            let front = height.gt(R::splat(0.0)).bitmask();
            let (asked, place) = (self.asked, &paths.place);
            let time = |i: usize| if job.needs.time { asked.time.get(place.get(i) as usize) } else { 0.0 };
            let what = (varies.bitmask(), front);
            let looked = Looked::up(job.scene, what, (i, time), hits, &mut vertices.materials);
            live = live & !looked.lit::<R>();
            frame = Framex::select(varies, looked.frames(at.ns, at.ng), frame);
            transmits = vertices.materials.load::<R>(i).has_transmission();
        }
        let leaning = leans(frame.z, at.ng) & height.abs().gt(R::splat(0.0));
        let live = live & (leaning | is_upright(frame.z, at.ng, wo));
        vertices.odd.pack::<R::Word>(i, within & !live & !is_lost);
        let (one, zero) = (R::Word::splat(1), R::Word::splat(0));
        vertices.live.store(i, R::Word::select(live, one, zero));
        vertices.known.store(i, R::Word::select(at.known, one, zero));
        match (leaning & live).any() {
            true => {
                let turned = Turned::new(&frame, (at.ng, at.ns), wo, varies.any());
                let is_lifted = at.lift.dot(turned.up).gt(turned.up.abs().dot(at.p_error));
                let is_over = is_lifted & turned.may_pass_over(job, (at.ng, at.ns), transmits);
                frame = Framex::select(leaning, turned.frame, frame);
                vertices.tilts.store(i, leaning, &turned.tilt(wo, is_over));
            }
            false => vertices.tilts.store_none::<R::Word>(i),
        }
        vertices.p.store(i, at.p);
        vertices.start.store(i, at.start);
        vertices.p_error.store(i, at.p_error);
        vertices.ng.store(i, at.ng);
        // Where paths go on one by one, this is the surface, whose normal the frame stands for.
        vertices.store_frame(i, &Framex::select(live, frame, plain));
    }
}
