//! Film: the mean and variance of the samples of every pixel, accumulated in f64.
//!
//! The estimate of a pixel is (1/N) Σ value·weight with N the number of samples (not the sum of weights), which is
//! unbiased for filters whose weights have mean 1. Pixels are addressed in coordinates of the full image.
//!
//! The samples of a pixel have consecutive indices and are summed as described in [`crate::sums`], so that films of
//! adjoining samples merge to the bits of one film with all samples.

use crate::sums::{PixelMoments, SampleSums, SumNode, total};
use dapple_math::{Image, PixelRect};
use glam::{DVec3, Vec3};
use std::fmt;
use std::ops::Range;

/// Moments of one node of every pixel, row by row; empty if no pixel has that node.
type Nodes = Vec<PixelMoments>;

/// A rectangle of pixels with the count, mean and variance of the samples of each. A pixel takes 8 bytes, and 48 more
/// for each bit that is set in the number of its samples, or in that of another pixel.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Film {
    rect: PixelRect,
    /// Index of the first sample of every pixel; empty if that is 0 everywhere.
    first: Vec<u64>,
    /// Number of samples of every pixel.
    count: Vec<u64>,
    /// By level: the last node of a pixel if its index is even, so that its other half has yet to come.
    open: Vec<Nodes>,
    /// By level: the node of a pixel whose index is odd and whose other half begins before the first sample.
    edge: Vec<Nodes>,
}

impl Film {
    /// Creates an empty film, in which all counts are zero. The first sample of each pixel has the index 0.
    pub fn new(rect: PixelRect) -> Self {
        Self { rect, first: vec![], count: vec![0; rect.area()], open: vec![], edge: vec![] }
    }

    /// Creates an empty film for a part of the samples: `first` is the index of the first sample of each pixel.
    pub fn starting_at(rect: PixelRect, first: impl Fn(u32, u32) -> u64) -> Self {
        let pixels = (rect.y0..rect.y1).flat_map(|y| (rect.x0..rect.x1).map(move |x| (x, y)));
        let first: Vec<u64> = pixels.map(|(x, y)| first(x, y)).collect();
        let is_late = first.iter().any(|first| *first > 0);
        Self { first: if is_late { first } else { vec![] }, ..Self::new(rect) }
    }

    /// Whether the film has the nodes of all its samples; a film that was read from a file may not.
    pub fn is_whole(&self) -> bool {
        let area = self.rect.area();
        let levels = self.open.iter().chain(&self.edge);
        let ends = |pixel: usize| self.first(pixel).checked_add(self.count[pixel]);
        let has = |(level, index): (u32, u64)| {
            let kept = if index & 1 == 0 { &self.open } else { &self.edge };
            kept.get(level as usize).is_some_and(|nodes| !nodes.is_empty())
        };
        self.count.len() == area
            && [0, area].contains(&self.first.len())
            && levels.map(Vec::len).all(|len| [0, area].contains(&len))
            && (0..area).all(|pixel| ends(pixel).is_some() && self.places(pixel).all(has))
    }

    /// Returns the rectangle of pixels that the film covers.
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    #[inline]
    fn index(&self, x: u32, y: u32) -> Option<usize> {
        let inside = self.rect.contains(x, y);
        inside.then(|| (y - self.rect.y0) as usize * self.rect.width() as usize + (x - self.rect.x0) as usize)
    }

    /// Adds the next sample of a pixel and returns whether it is finite. A non-finite sample is counted with value
    /// zero. `x, y` are coordinates in the full image; a sample of a pixel that the film does not cover is ignored.
    #[inline]
    pub fn add(&mut self, x: u32, y: u32, value: Vec3, weight: f32) -> bool {
        self.add_measured(x, y, value, weight).0
    }

    /// Like [`Film::add`]; also returns the squared difference of the sample and the one before it, summed over
    /// channels, if both together are a node of the tree, which is the case for every other sample; otherwise 0.
    #[inline]
    pub fn add_measured(&mut self, x: u32, y: u32, value: Vec3, weight: f32) -> (bool, f64) {
        let value = value.as_dvec3() * weight as f64;
        let finite = value.is_finite();
        let moments = PixelMoments::of(if finite { value } else { DVec3::ZERO });
        let squared = self.index(x, y).map(|pixel| self.push(pixel, 0, moments));
        (finite, squared.unwrap_or_default())
    }

    /// Index of the first sample of a pixel.
    #[inline]
    fn first(&self, pixel: usize) -> u64 {
        self.first.get(pixel).copied().unwrap_or_default()
    }

    /// Adds the node of `level` that begins with the next sample of `pixel`. Returns the squared difference of two
    /// samples that become a node.
    #[inline]
    fn push(&mut self, pixel: usize, mut level: u32, mut moments: PixelMoments) -> f64 {
        let (first, mut squared) = (self.first(pixel), 0.0);
        let mut index = (first + self.count[pixel]) >> level;
        self.count[pixel] += 1 << level;
        while index & 1 == 1 {
            if (index - 1) << level < first {
                node_of(&mut self.edge, level, self.count.len())[pixel] = moments;
                return squared;
            }
            moments = PixelMoments::pair(&self.open[level as usize][pixel], &moments, level);
            if level == 0 {
                squared = 2.0 * moments.m2.element_sum();
            }
            (level, index) = (level + 1, index >> 1);
        }
        node_of(&mut self.open, level, self.count.len())[pixel] = moments;
        squared
    }

    /// The level and the index of each node of a pixel, in order of their samples: from the first sample on always the
    /// largest node that begins there and is complete.
    fn places(&self, pixel: usize) -> impl Iterator<Item = (u32, u64)> {
        let first = self.first(pixel);
        let (mut start, end) = (first, first + self.count[pixel]);
        std::iter::from_fn(move || {
            let longest = end.checked_sub(start)?.checked_ilog2()?;
            let level = start.trailing_zeros().min(longest);
            let place = (level, start >> level);
            start += 1 << level;
            Some(place)
        })
    }

    /// Replaces `nodes` by those of a pixel, in order of their samples.
    fn nodes(&self, pixel: usize, nodes: &mut Vec<SumNode>) {
        nodes.clear();
        for (level, index) in self.places(pixel) {
            nodes.push(SumNode { level, index, moments: self.moments(pixel, (level, index)) });
        }
    }

    #[inline]
    fn moments(&self, pixel: usize, (level, index): (u32, u64)) -> PixelMoments {
        let kept = if index & 1 == 0 { &self.open } else { &self.edge };
        kept[level as usize][pixel]
    }

    /// Returns the sums of the samples of one pixel; empty outside of the film.
    pub fn sums_at(&self, x: u32, y: u32) -> SampleSums {
        let mut nodes = Vec::new();
        self.index(x, y).into_iter().for_each(|pixel| self.nodes(pixel, &mut nodes));
        SampleSums::of(nodes)
    }

    /// The moments of the samples of every pixel, with their number, row by row.
    fn totals(&self) -> impl Iterator<Item = (u64, PixelMoments)> {
        let mut nodes = Vec::new();
        (0..self.count.len()).map(move |pixel| {
            self.nodes(pixel, &mut nodes);
            total(&nodes)
        })
    }

    /// Replaces pixels of this film by those of a tile. Pixels of the tile outside this film are ignored.
    pub fn put(&mut self, tile: &Film) {
        let both = self.rect.intersection(&tile.rect);
        let (width, area) = (both.width() as usize, self.count.len());
        if !tile.first.is_empty() && self.first.is_empty() {
            self.first = vec![0; area];
        }
        for y in both.y0..both.y1 {
            let (Some(to), Some(from)) = (self.index(both.x0, y), tile.index(both.x0, y)) else { continue };
            let (to, from) = (to..to + width, from..from + width);
            self.count[to.clone()].copy_from_slice(&tile.count[from.clone()]);
            if tile.first.is_empty() {
                self.first.get_mut(to.clone()).into_iter().for_each(|first| first.fill(0));
            } else {
                self.first[to.clone()].copy_from_slice(&tile.first[from.clone()]);
            }
            for (mine, theirs) in [(&mut self.open, &tile.open), (&mut self.edge, &tile.edge)] {
                for (level, nodes) in theirs.iter().enumerate().filter(|(_, nodes)| !nodes.is_empty()) {
                    let mine = node_of(mine, level as u32, area);
                    mine[to.clone()].copy_from_slice(&nodes[from.clone()]);
                }
            }
        }
    }

    /// Adds the samples of `other`, a film of the same rectangle whose samples follow those of `self` or precede them
    /// in every pixel that has samples in both. The result has the bits of one film to which all samples were added.
    ///
    /// # Errors
    /// The rectangles differ, or the samples of a pixel do not adjoin; the film is unchanged. Samples of renders with
    /// different seeds have the same indices, and their films are not merged.
    pub fn merge(&mut self, other: &Film) -> Result<(), FilmMismatch> {
        self.merge_measured(other, |_| ())
    }

    /// Like [`Film::merge`]; calls `pair` with the squared difference of every two samples that are a node of the tree
    /// and were not in the same film, as [`Film::add_measured`] returns it.
    ///
    /// # Errors
    /// As for [`Film::merge`].
    pub fn merge_measured(&mut self, other: &Film, mut pair: impl FnMut(f64)) -> Result<(), FilmMismatch> {
        if self.rect != other.rect {
            return Err(FilmMismatch::Rect { ours: self.rect, theirs: other.rect });
        }
        if self.gap_before(other).is_none() {
            self.append(other, &mut pair);
        } else if let Some((ours, theirs)) = other.gap_before(self) {
            return Err(FilmMismatch::Samples { ours: theirs, theirs: ours });
        } else {
            let mut before = other.clone();
            before.append(self, &mut pair);
            *self = before;
        }
        Ok(())
    }

    /// The samples of the first pixel where those of `other` do not follow.
    fn gap_before(&self, other: &Film) -> Option<(Range<u64>, Range<u64>)> {
        let pixels = (0..self.count.len()).filter(|&pixel| self.count[pixel] > 0 && other.count[pixel] > 0);
        let mut ranges = pixels.map(|pixel| (self.range(pixel), other.range(pixel)));
        ranges.find(|(ours, theirs)| ours.end != theirs.start)
    }

    fn range(&self, pixel: usize) -> Range<u64> {
        let first = self.first(pixel);
        first..first + self.count[pixel]
    }

    /// Adds the samples of `other`, which follow those of `self`.
    fn append(&mut self, other: &Film, pair: &mut impl FnMut(f64)) {
        for pixel in (0..self.count.len()).filter(|pixel| other.count[*pixel] > 0) {
            if self.count[pixel] == 0 && self.first(pixel) != other.first(pixel) {
                self.first.resize(self.count.len(), 0);
                self.first[pixel] = other.first(pixel);
            }
            for place in other.places(pixel) {
                let squared = self.push(pixel, place.0, other.moments(pixel, place));
                if squared > 0.0 {
                    pair(squared);
                }
            }
        }
        self.trim();
    }

    /// Returns a film of all samples of `films`, which cover the same rectangle. Where the samples of a pixel adjoin, it
    /// has the bits of one film to which all of them were added; where some between them are missing, it has their
    /// number, mean and variance, but no longer their indices.
    ///
    /// # Errors
    /// The rectangles differ, or two films have a sample in common.
    pub fn united(films: &[Film]) -> Result<Self, FilmMismatch> {
        let rect = films.first().map_or(PixelRect { x0: 0, y0: 0, x1: 0, y1: 0 }, |film| film.rect);
        if let Some(other) = films.iter().find(|film| film.rect != rect) {
            return Err(FilmMismatch::Rect { ours: rect, theirs: other.rect });
        }
        let (mut all, mut nodes) = (Self::new(rect), Vec::new());
        all.first = vec![0; rect.area()];
        for pixel in 0..rect.area() {
            let mut sums = SampleSums::default();
            for film in films {
                film.nodes(pixel, &mut nodes);
                let part = SampleSums::of(std::mem::take(&mut nodes));
                let range = |sums: &SampleSums| sums.range().unwrap_or_default();
                sums.merge(&part)
                    .map_err(|_| FilmMismatch::Samples { ours: range(&sums), theirs: range(&part) })?;
            }
            all.restore(pixel, &sums);
        }
        all.trim();
        Ok(all)
    }

    /// Sets the samples of a pixel that has none.
    fn restore(&mut self, pixel: usize, sums: &SampleSums) {
        let (n, moments) = sums.finish();
        if let Some(range) = sums.range().filter(|range| range.end - range.start == n) {
            self.first[pixel] = range.start;
            for node in sums.nodes() {
                self.push(pixel, node.level, node.moments);
            }
            return;
        }
        // Nodes with the mean of all samples, of which the first has all squared deviations.
        let levels = (0..64).rev().filter(|level| n >> level & 1 == 1);
        let mut m2 = moments.m2;
        for level in levels {
            self.push(pixel, level, PixelMoments { m2: std::mem::take(&mut m2), ..moments });
        }
    }

    /// Frees the memory of nodes that no pixel has.
    pub fn trim(&mut self) {
        // If the first sample is 0, the nodes of a pixel are the bits of its count.
        let mut used = [self.count.iter().fold(0, |used, count| used | count), 0];
        if !self.first.is_empty() {
            used = [0; 2];
            let places = (0..self.count.len()).flat_map(|pixel| self.places(pixel));
            places.for_each(|(level, index)| used[(index & 1) as usize] |= 1 << level);
        }
        for (levels, used) in [&mut self.open, &mut self.edge].into_iter().zip(used) {
            levels.truncate(64 - used.leading_zeros() as usize);
            let unused = levels.iter_mut().enumerate().filter(|(level, _)| used >> level & 1 == 0);
            unused.for_each(|(_, nodes)| *nodes = Nodes::new());
        }
    }

    /// Returns the estimate (1/N) Σ value·weight of every pixel. Pixels without samples are black.
    pub fn mean(&self) -> Image {
        self.image(|(_, moments)| moments.mean.as_vec3())
    }

    /// Returns the variance of the mean per channel, Σ(x − mean)²/(n(n − 1)). It is infinite where n < 2. It is an
    /// estimate for independent samples; for stratified and Sobol points, whose error is smaller, it is too large.
    pub fn variance(&self) -> Image {
        self.image(|(n, moments)| moments.variance_of_mean(n).as_vec3())
    }

    /// Returns the squared deviations from the mean of their pixel, summed over channels, of those samples for which
    /// [`Film::add_measured`] returned no difference because their neighbour in the tree is missing.
    pub fn unpaired(&self) -> impl Iterator<Item = f64> {
        let mut nodes = Vec::new();
        (0..self.count.len()).filter(|pixel| self.count[*pixel] > 1).flat_map(move |pixel| {
            let is_single = |place: &(u32, u64)| place.0 == 0;
            let mut found = [0.0; 2];
            if self.places(pixel).any(|place| is_single(&place)) {
                self.nodes(pixel, &mut nodes);
                let mean = total(&nodes).1.mean;
                let singles = nodes.iter().filter(|node| node.level == 0);
                let squares = singles.map(|node| (node.moments.mean - mean).length_squared());
                found.iter_mut().zip(squares).for_each(|(found, square)| *found = square);
            }
            found.into_iter().filter(|square| *square > 0.0)
        })
    }

    /// Returns the number of samples of one pixel; 0 outside of the film.
    pub fn count(&self, x: u32, y: u32) -> u64 {
        self.index(x, y).map_or(0, |i| self.count[i])
    }

    /// Returns the number of samples of all pixels.
    pub fn samples(&self) -> u64 {
        self.count.iter().sum()
    }

    /// Returns the mean of one pixel in f64; zero outside of the film.
    pub fn mean_at(&self, x: u32, y: u32) -> DVec3 {
        self.sums_at(x, y).finish().1.mean
    }

    /// Returns the number of bytes of the film.
    pub fn bytes(&self) -> usize {
        let nodes = self.open.iter().chain(&self.edge).map(|nodes| size_of_val(&**nodes));
        size_of_val(&*self.first) + size_of_val(&*self.count) + nodes.sum::<usize>()
    }

    fn image(&self, f: impl Fn((u64, PixelMoments)) -> Vec3) -> Image {
        Image {
            width: self.rect.width() as usize,
            height: self.rect.height() as usize,
            pixels: self.totals().map(f).collect(),
        }
    }
}

/// The nodes of a level, which are created if there are none.
#[inline(always)]
fn node_of(levels: &mut Vec<Nodes>, level: u32, pixels: usize) -> &mut Nodes {
    if levels.get(level as usize).is_none_or(Vec::is_empty) {
        create(levels, level as usize, pixels);
    }
    &mut levels[level as usize]
}

#[cold]
fn create(levels: &mut Vec<Nodes>, level: usize, pixels: usize) {
    levels.resize(levels.len().max(level + 1), Nodes::new());
    levels[level] = vec![PixelMoments::default(); pixels];
}

/// Films are equal if they have the same samples and sums.
impl PartialEq for Film {
    fn eq(&self, other: &Self) -> bool {
        let (mut ours, mut theirs) = (Vec::new(), Vec::new());
        let is_same = |pixel: usize| {
            self.nodes(pixel, &mut ours);
            other.nodes(pixel, &mut theirs);
            ours == theirs
        };
        self.rect == other.rect && (0..self.count.len()).all(is_same)
    }
}

/// The error of merging two films.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FilmMismatch {
    /// The films cover different rectangles.
    Rect {
        /// Rectangle of the film that is merged into.
        ours: PixelRect,
        /// Rectangle of the film that is merged from.
        theirs: PixelRect,
    },
    /// The samples of a pixel do not adjoin.
    Samples {
        /// Samples of the film that is merged into.
        ours: Range<u64>,
        /// Samples of the film that is merged from.
        theirs: Range<u64>,
    },
}
impl fmt::Display for FilmMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let show = |r: &PixelRect| format!("{},{},{},{}", r.x0, r.y0, r.x1, r.y1);
        match self {
            Self::Rect { ours, theirs } => {
                write!(f, "cannot merge films of pixels {} and {}", show(ours), show(theirs))
            }
            Self::Samples { ours, theirs } => write!(
                f,
                "cannot merge samples {}..{} and {}..{} of a pixel; one range must begin where the other ends",
                ours.start, ours.end, theirs.start, theirs.end
            ),
        }
    }
}
impl std::error::Error for FilmMismatch {}

#[cfg(test)]
mod tests {
    use super::*;

    const RECT: PixelRect = PixelRect { x0: 3, y0: 5, x1: 7, y1: 8 };

    #[test]
    fn mean_and_variance_of_a_few_numbers() {
        let mut film = Film::new(RECT);
        for x in [1.0, 2.0, 3.0, 4.0] {
            assert!(film.add(4, 6, Vec3::splat(x), 1.0));
        }
        let i = 4 + 1; // row 1, column 1 of a film that is four pixels wide
        assert_eq!(film.mean().pixels[i], Vec3::splat(2.5));
        assert!((film.variance().pixels[i].x - 5.0 / 12.0).abs() < 1e-7);
        assert_eq!(film.variance().pixels[0], Vec3::INFINITY);
        assert_eq!((film.count(4, 6), film.count(3, 5), film.count(99, 99)), (4, 0, 0));
        assert_eq!(film.samples(), 4);
    }

    #[test]
    fn a_bad_sample_counts_as_zero_and_is_told() {
        let mut film = Film::new(RECT);
        assert!(film.add(3, 5, Vec3::ONE, 1.0));
        for bad in [Vec3::NAN, Vec3::new(0.0, f32::INFINITY, 0.0)] {
            assert!(!film.add(3, 5, bad, 1.0));
        }
        assert!(!film.add(3, 5, Vec3::ONE, f32::NAN));
        assert_eq!(film.count(3, 5), 4);
        assert_eq!(film.mean().pixels[0], Vec3::splat(0.25));
    }

    /// Films in any order, with and without missing samples between them.
    #[test]
    fn films_unite_whether_samples_are_missing_or_not() {
        let value = |s: u64| Vec3::new(0.1 * s as f32, (s * s) as f32, 3.0);
        let part = |samples: Range<u64>| {
            let mut film = Film::starting_at(RECT, |_, _| samples.start);
            samples.for_each(|s| assert!(film.add(4, 6, value(s), 1.0)));
            film
        };
        let parts = [part(100..256), part(0..7), part(7..100)];
        let (united, whole) = (Film::united(&parts).unwrap(), part(0..256));
        assert_eq!(united, whole);
        assert_eq!((united.mean(), united.variance()), (whole.mean(), whole.variance()));
        let (gap, mut sums) = (Film::united(&parts[..2]).unwrap(), parts[0].sums_at(4, 6));
        sums.merge(&parts[1].sums_at(4, 6)).unwrap();
        assert_eq!(gap.sums_at(4, 6).finish(), sums.finish());
        assert_eq!((gap.count(4, 6), gap.count(3, 5)), (163, 0));
        assert!(gap.is_whole() && united.is_whole());
        assert!(Film::united(&[part(0..8), part(7..9)]).is_err());
    }

    #[test]
    fn tiles_go_where_they_belong() {
        let mut film = Film::new(RECT);
        let mut tile = Film::new(PixelRect { x0: 5, y0: 6, x1: 9, y1: 9 });
        tile.add(6, 7, Vec3::X, 1.0);
        tile.add(8, 8, Vec3::Y, 1.0);
        film.put(&tile);
        assert_eq!(film.mean_at(6, 7), DVec3::X);
        assert_eq!(film.mean().pixels.iter().filter(|p| **p != Vec3::ZERO).count(), 1);
        film.put(&Film::new(PixelRect { x0: 100, y0: 0, x1: 101, y1: 1 }));
    }
}
