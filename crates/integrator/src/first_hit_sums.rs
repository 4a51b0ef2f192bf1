//! First hits of camera rays, summed over the samples of each pixel, for the layers that show them. The sums are in fixed
//! point, so that no order or division of the samples changes them.

use crate::aov::Aov;
use crate::bias_report::{BiasReport, Truncation};
use crate::coverage::Coverage;
use crate::observer::PathObserver;
use crate::settings::Settings;
use crate::vertex::Vertex;
use dapple_math::{FixedSum, FixedVector};
use glam::Vec3;

/// Sums over the first hits of the camera rays of one sample, in render space.
#[derive(Clone, Default)]
pub(crate) struct FirstHit {
    rays: u32,
    hits: u32,
    albedo: Vec3,
    normal: Vec3,
    p: Vec3,
    /// Object index + 1 at the first ray; 0 where nothing is hit.
    object: u32,
    /// Object index + 1 at each further ray that hits a surface, if all objects are requested.
    further: Vec<u32>,
    asks_all: bool,
    hides_backdrop: bool,
    /// Bias events of all rays of the sample.
    pub bias: BiasReport,
}

impl FirstHit {
    /// An empty record for a new sample.
    pub fn of(settings: &Settings) -> Self {
        Self { hides_backdrop: settings.transparent, ..Self::default() }
    }

    /// Object index + 1 for each ray that hit a surface.
    fn objects(&self) -> impl Iterator<Item = u32> {
        std::iter::once(self.object).filter(|object| *object != 0).chain(self.further.iter().copied())
    }
}

impl PathObserver for FirstHit {
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
            if vertex.shading.unlit { vertex.shading.material.base_color() } else { vertex.bsdf.albedo() };
        self.normal += vertex.shading.frame.z * side;
        self.p += vertex.surface.p;
    }

    fn escaped(&mut self, depth: u32, _: Vec3, _: Vec3, _: Vec3) {
        self.rays += u32::from(depth == 0);
    }

    fn hides_backdrop(&self) -> bool {
        self.hides_backdrop
    }

    fn cut(&mut self, why: Truncation, beta: Vec3) {
        self.bias.cut(why, beta);
    }
}

/// Sums of first hits over the samples of each pixel; vectors that no requested layer needs are empty.
#[derive(Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct FirstHits {
    /// Samples that hit a surface, in shares of a sample.
    pub hits: Vec<FixedSum>,
    pub albedo: Vec<FixedVector>,
    pub normal: Vec<FixedVector>,
    pub p: Vec<FixedVector>,
    /// Object index + 1 at the first sample; 0 where nothing is hit.
    pub object: Vec<u32>,
    /// Share of the pixel's samples that hit a surface, and share of each object.
    pub coverage: Coverage,
    is_asked: bool,
}

impl FirstHits {
    pub fn new(pixels: usize, settings: &Settings) -> Self {
        let aovs = &settings.aovs;
        let asked = |by: &[Aov]| if aovs.iter().any(|aov| by.contains(aov)) { pixels } else { 0 };
        let place = asked(&[Aov::Position, Aov::Depth]);
        Self {
            hits: vec![FixedSum::default(); place],
            albedo: vec![FixedVector::default(); asked(&[Aov::Albedo])],
            normal: vec![FixedVector::default(); asked(&[Aov::Normal])],
            p: vec![FixedVector::default(); place],
            object: vec![0; asked(&[Aov::ObjectId, Aov::MaterialId])],
            coverage: Coverage::new(pixels, settings),
            is_asked: settings.transparent || aovs.iter().any(|aov| aov.needs_first_hit()),
        }
    }

    /// Whether both have sums of the same layers and pixels.
    pub fn is_like(&self, other: &Self) -> bool {
        let counts =
            |of: &Self| [of.hits.len(), of.albedo.len(), of.normal.len(), of.p.len(), of.object.len()];
        counts(self) == counts(other)
            && self.coverage.is_like(&other.coverage)
            && self.is_asked == other.is_asked
    }

    /// Bytes per pixel for these layers in a tile.
    pub fn bytes_per_pixel(settings: &Settings) -> usize {
        let one = Self::new(1, settings);
        let vectors = [&one.albedo, &one.normal, &one.p].map(|v| size_of_val(&**v));
        let coverage = one.coverage.bytes_of_a_pixel();
        size_of_val(&*one.hits) + vectors.iter().sum::<usize>() + size_of_val(&*one.object) + coverage
    }

    /// The record for a new sample, if any layer needs first hits.
    pub fn start(&self, settings: &Settings) -> FirstHit {
        if !self.is_asked {
            return FirstHit::default();
        }
        FirstHit { asks_all: self.coverage.asks_objects(), ..FirstHit::of(settings) }
    }

    /// Adds the record of a sample to a pixel, if any layer needs first hits.
    pub fn add(&mut self, pixel: usize, first: &FirstHit, index: u32, weight: f32) {
        if !self.is_asked {
            return;
        }
        let share = 1.0 / f64::from(first.rays.max(1));
        self.coverage.add(pixel, f64::from(weight), (first.hits, share), first.objects());
        if first.hits == 0 {
            return;
        }
        if let Some(hits) = self.hits.get_mut(pixel) {
            hits.add(f64::from(first.hits) * share);
        }
        let sums =
            [(&mut self.albedo, first.albedo), (&mut self.normal, first.normal), (&mut self.p, first.p)];
        for (sum, seen) in sums {
            if let Some(sum) = sum.get_mut(pixel) {
                sum.add(seen.as_dvec3() * share);
            }
        }
        if let Some(object) = self.object.get_mut(pixel).filter(|_| index == 0) {
            *object = first.object;
        }
    }

    /// Adds the sums of other samples of the same pixels.
    pub fn merge(&mut self, other: &Self) {
        self.hits.iter_mut().zip(&other.hits).for_each(|(sum, other)| sum.merge(other));
        let vectors =
            [(&mut self.albedo, &other.albedo), (&mut self.normal, &other.normal), (&mut self.p, &other.p)];
        for (sums, others) in vectors {
            sums.iter_mut().zip(others).for_each(|(sum, other)| sum.merge(other));
        }
        // At most one of them has the first sample.
        self.object.iter_mut().zip(&other.object).for_each(|(object, other)| *object = (*object).max(*other));
        self.coverage.merge(&other.coverage);
    }

    /// Empty sums of the same layers for another number of pixels.
    pub fn like(&self, pixels: usize) -> Self {
        let count = |is_empty: bool| if is_empty { 0 } else { pixels };
        let vectors = |of: &Vec<FixedVector>| vec![FixedVector::default(); count(of.is_empty())];
        Self {
            hits: vec![FixedSum::default(); count(self.hits.is_empty())],
            albedo: vectors(&self.albedo),
            normal: vectors(&self.normal),
            p: vectors(&self.p),
            object: vec![0; count(self.object.is_empty())],
            coverage: self.coverage.like(pixels),
            is_asked: self.is_asked,
        }
    }

    /// Whether the sums are those of `pixels` pixels.
    pub fn is_of(&self, pixels: usize) -> bool {
        let counts = [self.hits.len(), self.albedo.len(), self.normal.len(), self.p.len(), self.object.len()];
        counts.iter().all(|len| [0, pixels].contains(len))
            && self.hits.len() == self.p.len()
            && self.coverage.is_of(pixels)
    }

    /// Adds the sums of other samples: those of pixel `from` of `other` to pixel `to`.
    pub fn merge_pixel(&mut self, to: usize, other: &Self, from: usize) {
        if let (Some(sum), Some(other)) = (self.hits.get_mut(to), other.hits.get(from)) {
            sum.merge(other);
        }
        let vectors =
            [(&mut self.albedo, &other.albedo), (&mut self.normal, &other.normal), (&mut self.p, &other.p)];
        for (sums, others) in vectors {
            if let (Some(sum), Some(other)) = (sums.get_mut(to), others.get(from)) {
                sum.merge(other);
            }
        }
        if let (Some(object), Some(other)) = (self.object.get_mut(to), other.object.get(from)) {
            *object = (*object).max(*other);
        }
        self.coverage.merge_pixel(to, &other.coverage, from);
    }
}
