//! Vertices over lanes: surfaces, shading frames and materials of the hits whose data do not vary over a triangle.

use super::rows::{HOLDS, Hits, Paths, Vertices};
use crate::job::Job;
use crate::path::backward;
use crate::vertex::is_upright;
use dapple_geometry::Facets;
use dapple_materials::lanes::Palette;
use dapple_materials::{Lobe, Material};
use dapple_math::lanes::{Framex, Kernel, Mask, Real, Word};
use dapple_scene::AlphaMode;

/// In place of the material of objects that have none for all of their surface.
const VARIES: u32 = u32::MAX;

/// The materials of objects that do not vary.
pub(super) struct Materials {
    /// Per object: index into the palette.
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
        let lanes_scatter = |material: &&Material| !material.is_mirror();
        let objects = 0..scene.objects.len() as u32;
        let mut special: Vec<bool> = objects.map(|object| is_special(job, object)).collect();
        let mut materials = Vec::new();
        let mut index = |object: u32| {
            let material = scene.uniform_material(object).filter(lanes_scatter);
            let material = material.filter(|_| !special[object as usize]);
            material.map_or(VARIES, |material| {
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
    pub paths: &'a Paths,
    pub hits: &'a Hits,
    pub vertices: &'a mut Vertices,
}

impl Kernel for Surfaces<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(mut self) {
        self.vertices.odd = 0;
        for i in (0..self.paths.len).step_by(R::LANES) {
            self.step::<R>(i, R::Mask::first(self.paths.len - i));
        }
    }
}

impl Surfaces<'_> {
    #[inline(always)]
    fn step<R: Real>(&mut self, i: usize, within: R::Mask) {
        let (paths, hits, vertices) = (self.paths, self.hits, &mut *self.vertices);
        let (object, d) = (hits.object.load::<R::Word>(i), paths.d.load::<R>(i));
        let is_hit = object.ne(R::Word::splat(u32::MAX));
        let (wo, _) = backward(d);
        let (u, v) = (hits.u.load(i), hits.v.load(i));
        let at = self.facets.surfaces::<R>((object, hits.primitive.load(i)), u, v);
        let material = R::Word::gather(&self.materials.of_object, object);
        let is_plain = at.known & material.ne(R::Word::splat(VARIES)) & is_upright(at.ns, at.ng, wo);
        let holds = (paths.flags.load::<R::Word>(i) & R::Word::splat(HOLDS)).ne(R::Word::splat(0));
        let is_usual = paths.beta.load::<R>(i).is_finite() & !holds;
        let mut live = within & is_hit & is_plain & is_usual;
        if self.depth == 0 {
            live = live & !self.job.may_pass_first(hits.t.load(i), at.ng, d);
        }
        let is_lost = !is_hit & is_usual & R::Mask::splat(self.job.scene.environment.is_none());
        let (one, zero, row) = (R::Word::splat(1), R::Word::splat(0), R::Word::splat(i as u32));
        vertices.live.store(i, R::Word::select(live, one, zero));
        vertices.known.store(i, R::Word::select(at.known, one, zero));
        let odd = within & !live & !is_lost;
        vertices.odd += vertices.odd_rows.pack(vertices.odd, odd, row.wrapping_add(R::Word::lane_index()));
        let frame = Framex::from_z(at.ns);
        vertices.p.store(i, at.p);
        vertices.start.store(i, at.start);
        vertices.p_error.store(i, at.p_error);
        vertices.ng.store(i, at.ng);
        vertices.store_frame(i, &frame);
        vertices.materials.store(i, &self.materials.palette.gather::<R>(material));
    }
}
