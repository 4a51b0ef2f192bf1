//! A tile of the film: the pixels one worker renders, with the layers asked for.

use crate::aov::Aov;
use crate::coverage::Coverage;
use crate::kernel::{Job, Kernel};
use crate::ledger::{Cut, Ledger};
use crate::path::Follow;
use crate::render::BadSample;
use crate::settings::Settings;
use crate::spread::Spread;
use crate::tail::Tail;
use crate::vertex::Vertex;
use dapple_camera::Film;
use dapple_math::PixelRect;
use glam::{DVec3, Vec3};

/// Side of a tile in pixels.
const SIDE: u32 = 16;

/// Most bad samples remembered by place per tile; all are counted.
const REMEMBERED: usize = 4;

/// What the first hits of a sample's camera rays saw, summed, in render space.
#[derive(Clone, Default)]
pub(crate) struct FirstHit {
    rays: u32,
    hits: u32,
    albedo: Vec3,
    normal: Vec3,
    p: Vec3,
    /// Object + 1 at the first ray; 0 = nothing.
    object: u32,
    /// Likewise at each further ray that met something, if all are asked for.
    further: Vec<u32>,
    asks_all: bool,
    hides_backdrop: bool,
    /// Of all rays.
    pub ledger: Ledger,
}

impl FirstHit {
    /// Of a sample of which nothing is known yet.
    pub fn of(settings: &Settings) -> Self {
        Self { hides_backdrop: settings.transparent, ..Self::default() }
    }

    /// Objects + 1 that the rays met, one for each.
    fn objects(&self) -> impl Iterator<Item = u32> {
        std::iter::once(self.object).filter(|object| *object != 0).chain(self.further.iter().copied())
    }
}

impl Follow for FirstHit {
    fn vertex(&mut self, depth: u32, vertex: &Vertex, _: Vec3, _: Vec3) {
        if depth > 0 {
            return;
        }
        let side = vertex.surface.ng.dot(vertex.wo).signum();
        if self.rays == 0 {
            self.object = vertex.hit.object + 1;
        } else if self.asks_all {
            self.further.push(vertex.hit.object + 1);
        }
        self.rays += 1;
        self.hits += 1;
        self.albedo +=
            if vertex.shading.unlit { vertex.shading.material.base_color } else { vertex.bsdf.albedo() };
        self.normal += vertex.shading.frame.z * side;
        self.p += vertex.surface.p;
    }

    fn escaped(&mut self, depth: u32, _: Vec3, _: Vec3, _: Vec3) {
        self.rays += u32::from(depth == 0);
    }

    fn hides_backdrop(&self) -> bool {
        self.hides_backdrop
    }

    fn cut(&mut self, why: Cut, beta: Vec3) {
        self.ledger.cut(why, beta);
    }
}

/// Sums of first hits over the samples of each pixel: those that the layers asked for are made of, the others empty.
#[derive(Clone, Default)]
pub(crate) struct FirstHits {
    /// Samples that hit something, in shares of a sample.
    pub hits: Vec<f64>,
    pub albedo: Vec<DVec3>,
    pub normal: Vec<DVec3>,
    pub p: Vec<DVec3>,
    /// Object + 1 at the first sample; 0 = nothing.
    pub object: Vec<u32>,
    /// Which part of the pixel's samples met something, and each of the objects.
    pub coverage: Coverage,
    is_asked: bool,
}

impl FirstHits {
    fn new(pixels: usize, settings: &Settings) -> Self {
        let aovs = &settings.aovs;
        let asked = |by: &[Aov]| if aovs.iter().any(|aov| by.contains(aov)) { pixels } else { 0 };
        let place = asked(&[Aov::Position, Aov::Depth]);
        Self {
            hits: vec![0.0; place],
            albedo: vec![DVec3::ZERO; asked(&[Aov::Albedo])],
            normal: vec![DVec3::ZERO; asked(&[Aov::Normal])],
            p: vec![DVec3::ZERO; place],
            object: vec![0; asked(&[Aov::ObjectId, Aov::MaterialId])],
            coverage: Coverage::new(pixels, settings),
            is_asked: settings.transparent || aovs.iter().any(|aov| aov.needs_first_hit()),
        }
    }

    /// What these layers take in a tile.
    pub fn bytes_per_pixel(settings: &Settings) -> usize {
        let one = Self::new(1, settings);
        let vectors = [&one.albedo, &one.normal, &one.p].map(|v| size_of_val(&**v));
        let coverage = one.coverage.bytes_of_a_pixel();
        size_of_val(&*one.hits) + vectors.iter().sum::<usize>() + size_of_val(&*one.object) + coverage
    }

    fn add(&mut self, pixel: usize, first: &FirstHit, index: u32, weight: f32) {
        let share = 1.0 / f64::from(first.rays.max(1));
        self.coverage.add(pixel, f64::from(weight), (first.hits, share), first.objects());
        if first.hits == 0 {
            return;
        }
        if let Some(hits) = self.hits.get_mut(pixel) {
            *hits += f64::from(first.hits) * share;
        }
        let sums =
            [(&mut self.albedo, first.albedo), (&mut self.normal, first.normal), (&mut self.p, first.p)];
        for (sum, seen) in sums {
            if let Some(sum) = sum.get_mut(pixel) {
                *sum += seen.as_dvec3() * share;
            }
        }
        if let Some(object) = self.object.get_mut(pixel).filter(|_| index == 0) {
            *object = first.object;
        }
    }
}

/// Pixels, their sums, and what went wrong among them.
#[derive(Clone)]
pub(crate) struct Tile {
    pub rect: PixelRect,
    /// Index of the next sample of every pixel.
    pub next: u32,
    /// What it was before the pass under way, if that is not the first.
    before: Option<Box<Tile>>,
    /// Of no pixels before the first pass: who is stopped then has not waited for memory.
    pub film: Film,
    pub first_hits: FirstHits,
    /// Of each pixel: what the ledger's entries removed, and samples that were not finite; empty unless asked for.
    pub removed: Vec<[f64; 4]>,
    pub rays: u64,
    /// Of each pixel, where samples are to go where the error is; else empty.
    pub pixel_rays: Vec<u64>,
    pub bad: Vec<BadSample>,
    pub bad_count: u64,
    pub ledger: Ledger,
    pub tail: Tail,
}

impl Tile {
    /// `rect` cut into tiles, row by row.
    pub fn cut(rect: PixelRect, settings: &Settings) -> Vec<Self> {
        let rows = (rect.y0..rect.y1).step_by(SIDE as usize);
        rows.flat_map(|y0| {
            (rect.x0..rect.x1).step_by(SIDE as usize).map(move |x0| {
                let part = PixelRect { x0, y0, x1: (x0 + SIDE).min(rect.x1), y1: (y0 + SIDE).min(rect.y1) };
                Self::new(part, settings)
            })
        })
        .collect()
    }

    fn new(rect: PixelRect, settings: &Settings) -> Self {
        let pixels = ((rect.x1 - rect.x0) * (rect.y1 - rect.y0)) as usize;
        let removed = if settings.aovs.contains(&Aov::Removed) { pixels } else { 0 };
        Self {
            rect,
            next: settings.sample_range().start,
            before: None,
            film: Film::new(PixelRect { x1: rect.x0, y1: rect.y0, ..rect }),
            first_hits: FirstHits::new(pixels, settings),
            removed: vec![[0.0; 4]; removed],
            rays: 0,
            pixel_rays: Vec::new(),
            bad: Vec::new(),
            bad_count: 0,
            ledger: Ledger::default(),
            tail: Tail::default(),
        }
    }

    /// Gets ready for a pass that may not be finished: to be taken back if it is a further one (`has_samples`). What an
    /// unfinished first pass has left is dropped.
    pub fn begin(&mut self, has_samples: bool, settings: &Settings) {
        if has_samples {
            self.before = Some(Box::new(self.clone()));
        } else {
            let pixel_rays = std::mem::take(&mut self.pixel_rays);
            *self = Self { pixel_rays: vec![0; pixel_rays.len()], ..Self::new(self.rect, settings) };
        }
    }

    /// All tiles have finished the pass.
    pub fn keep(&mut self) {
        self.before = None;
    }

    /// Not all tiles have finished the pass: what it added is taken back, unless it is the first.
    pub fn take_back(&mut self) {
        if let Some(before) = self.before.take() {
            *self = *before;
        }
    }

    /// Adds samples `from..to` of every pixel, or its share of them, until the job is stopped; returns how many.
    pub fn render(
        &mut self,
        job: &Job<'_>,
        kernel: Kernel,
        (from, to): (u32, u32),
        spread: Option<&Spread>,
    ) -> u64 {
        if self.film.rect() != self.rect {
            self.film = Film::new(self.rect);
        }
        let mut samples = 0;
        for y in self.rect.y0..self.rect.y1 {
            for x in self.rect.x0..self.rect.x1 {
                let count = |spp| spread.map_or(spp, |spread| spread.count(x, y, spp));
                let (from, to, rays) = (count(from), count(to), self.rays);
                for index in from..to {
                    if !self.sample(job, kernel, x, y, index) {
                        return samples;
                    }
                    samples += 1;
                }
                self.count_rays(x, y, self.rays - rays);
            }
        }
        self.next = to;
        samples
    }

    fn count_rays(&mut self, x: u32, y: u32, rays: u64) {
        if !self.pixel_rays.is_empty() {
            let pixel = (y - self.rect.y0) * self.rect.width() + (x - self.rect.x0);
            self.pixel_rays[pixel as usize] += rays;
        }
    }

    /// Adds a sample; false when the job was stopped before it was whole.
    fn sample(&mut self, job: &Job<'_>, kernel: Kernel, x: u32, y: u32, index: u32) -> bool {
        let mut first = FirstHit::default();
        if self.first_hits.is_asked {
            first.hides_backdrop = job.settings.transparent;
            first.asks_all = self.first_hits.coverage.asks_objects();
        }
        let (mut value, weight) = kernel(job, (x, y), index, &mut first, &mut self.rays);
        if job.is_stopped() {
            return false;
        }
        if !job.settings.picture {
            // Nobody sees it, and nothing is taken from it.
            (value, first.ledger) = (Vec3::ZERO, Ledger::default());
        }
        if let Some(most) = job.settings.clamp.filter(|_| cfg!(not(without = "clamp"))) {
            value = first.ledger.clamp(value, most);
        }
        if !first.ledger.is_clean() {
            self.ledger.merge(&first.ledger);
        }
        let (finite, deviation) = self.film.add_measured(x, y, value, weight);
        self.tail.add(deviation);
        if !finite {
            self.bad_count += 1;
            if self.bad.len() < REMEMBERED {
                self.bad.push(BadSample { x, y, sample: index });
            }
        }
        let pixel = ((y - self.rect.y0) * (self.rect.x1 - self.rect.x0) + (x - self.rect.x0)) as usize;
        if let Some(removed) = self.removed.get_mut(pixel) {
            let [clamped, depth, faint] = first.ledger.energies();
            let here = [clamped, depth, faint, f64::from(!finite)];
            *removed = std::array::from_fn(|k| removed[k] + here[k]);
        }
        if self.first_hits.is_asked {
            self.first_hits.add(pixel, &first, index, weight);
        }
        true
    }
}
