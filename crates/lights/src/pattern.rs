//! Sampling of textured emission on a triangle: a tree of congruent quarters bounds the emission, and points are
//! sampled in proportion to emission times solid angle.
//!
//! A triangle is divided into four congruent ones. Parts in which the emission still varies are divided again, the
//! largest differences first. A leaf without emission is never sampled; in every other leaf the density is at least a
//! quarter of the largest emission there, so no sample weight exceeds four times the mean. During the descent a part is
//! selected by its share of the emission times its solid angle, as long as the divided part has a solid angle of at
//! least `WIDE`; below that its quarters have nearly the same solid angle per area, and the share of the emission alone
//! is used.
pub use crate::part::Part;
use crate::polygon::Facet;
use crate::{Aiming, Area, AreaShape, LightSample};
use glam::{DVec2, Vec2, Vec3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::Arc;

/// Bounds and estimated mean of the emission in a part, in any unit.
#[derive(Clone, Copy, Debug)]
pub struct Emitted {
    /// Lower bound over the part.
    pub low: f64,
    /// Upper bound over the part; 0 if the part is known to be dark.
    pub high: f64,
    /// Approximate mean over the part.
    pub mean: f64,
    /// Whether the part is too small to be divided.
    pub is_fine: bool,
}

impl Emitted {
    /// Variation, relative to the upper bound, up to which the emission counts as uniform.
    const EVEN: f64 = 0.25;

    fn is_even(&self) -> bool {
        self.high - self.low <= Self::EVEN * self.high
    }

    /// Density in a leaf: at least a quarter of the largest emission.
    fn weight(&self) -> f64 {
        self.mean.clamp(0.25 * (self.low + self.high), self.high)
    }
}

/// Relative variance of the emission over the surface up to which uniform sampling is kept: sampling a pattern takes a
/// third longer where nothing else takes time, and has to reduce the variance by more than that.
pub const WORTH: f64 = 0.3;

/// Solid angle in sr from which the quarters of a part are weighted by their solid angles.
const WIDE: f64 = 1.0 / 32.0;

/// Share of the emission that may still be uncertain when subdivision stops.
const CERTAIN: f64 = 0.02;

/// Emission over a triangle as a sampling density.
#[derive(Clone, Debug)]
pub struct Pattern {
    nodes: Vec<Node>,
    /// Barycentric coordinates of the centroid of the emission.
    middle: Vec2,
}

/// A divided part: the share of the emission and the node of each quarter.
#[derive(Clone, Debug)]
struct Node {
    shares: [f32; 4],
    below: [u32; 4],
}
const LEAF: u32 = u32::MAX;

impl Pattern {
    /// Builds the tree. `bound` returns the bounds of the emission in a part and is called for at most `budget` parts.
    /// `middle` is the centroid of the emission in barycentric coordinates, at which the whole emission is placed when
    /// the light is treated as one point. Returns None where uniform sampling serves as well: where nothing emits, or
    /// the emission varies little. Also returns the mean of the density over the triangle, in the unit of `bound`: 0
    /// only where nothing emits.
    pub fn new(budget: usize, middle: Vec2, mut bound: impl FnMut(&Part) -> Emitted) -> (Option<Self>, f64) {
        let mut parts = vec![BuildPart::new(Part::WHOLE, bound(&Part::WHOLE))];
        let mut open = BinaryHeap::from_iter(parts[0].candidate(0));
        let (mut uncertain, mut all) = (parts[0].difference(), parts[0].emission());
        while parts.len() + 4 <= budget && uncertain > CERTAIN * all {
            let Some(Candidate { index, .. }) = open.pop() else { break };
            let first = parts.len();
            parts[index].quarters = Some(first);
            (uncertain, all) = (uncertain - parts[index].difference(), all - parts[index].emission());
            for which in 0..4 {
                let part = parts[index].part.quarter(which);
                let child = BuildPart::new(part, bound(&part));
                (uncertain, all) = (uncertain + child.difference(), all + child.emission());
                open.extend(child.candidate(first + which));
                parts.push(child);
            }
        }
        let squares: f64 = parts.iter().filter(|p| p.quarters.is_none()).map(BuildPart::square).sum();
        let sums = sums(&parts);
        let worth = sums[0] > 0.0 && sums[0].is_finite() && squares > (1.0 + WORTH) * sums[0] * sums[0];
        (worth.then(|| Self { nodes: nodes(&parts, &sums), middle }), sums[0])
    }

    /// Pattern of the triangle with corners 1 and 2 exchanged.
    pub(crate) fn mirrored(&self) -> Self {
        let swapped = |[a, b, c, d]: [f32; 4]| [a, c, b, d];
        let links = |[a, b, c, d]: [u32; 4]| [a, c, b, d];
        let nodes = self.nodes.iter().map(|n| Node { shares: swapped(n.shares), below: links(n.below) });
        Self { nodes: nodes.collect(), middle: Vec2::new(self.middle.y, self.middle.x) }
    }

    /// Memory use in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of::<Self>() + self.nodes.capacity() * size_of::<Node>()
    }

    /// Descends to a leaf; `choose` selects one of four quarters by their weights. Returns the leaf and its
    /// probability.
    fn descend(
        &self,
        whole: &Facet,
        by_angle: bool,
        mut choose: impl FnMut(&Part, &[f64; 4], f64) -> usize,
    ) -> (Part, f64) {
        let (mut part, mut probability, mut at) = (Part::WHOLE, 1.0, 0);
        let mut is_wide = by_angle && whole.omega() >= WIDE;
        loop {
            let node = &self.nodes[at as usize];
            let mut weights = node.shares.map(f64::from);
            let mut omegas = [0.0; 4];
            if is_wide {
                omegas = [0, 1, 2, 3].map(|i| whole.part(&part.quarter(i)).omega());
                let seen: [f64; 4] = std::array::from_fn(|i| weights[i] * omegas[i]);
                weights = if seen.iter().sum::<f64>() > 0.0 { seen } else { weights };
            }
            let sum = weights.iter().sum();
            let which = choose(&part, &weights, sum);
            probability *= weights[which] / sum;
            part = part.quarter(which);
            is_wide = is_wide && omegas[which] >= WIDE;
            at = node.below[which];
            if at == LEAF {
                return (part, probability);
            }
        }
    }
}

/// A part during construction of the tree.
struct BuildPart {
    part: Part,
    emitted: Emitted,
    quarters: Option<usize>,
}

impl BuildPart {
    fn new(part: Part, emitted: Emitted) -> Self {
        Self { part, emitted, quarters: None }
    }

    /// Heap entry of a part that is to be divided, with its priority.
    fn candidate(&self, index: usize) -> Option<Candidate> {
        let difference = self.difference();
        (difference > 0.0).then_some(Candidate { difference, index })
    }

    /// Difference between the bounds of the emission times the area; 0 for a part that is not divided any further.
    fn difference(&self) -> f64 {
        let e = &self.emitted;
        if e.is_fine || e.is_even() { 0.0 } else { (e.high - e.low) * self.part.area() }
    }

    fn emission(&self) -> f64 {
        self.emitted.weight() * self.part.area()
    }

    fn square(&self) -> f64 {
        self.emitted.weight() * self.emitted.weight() * self.part.area()
    }
}

/// Ordered by difference; ties go to the lower index.
struct Candidate {
    difference: f64,
    index: usize,
}
impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.difference.total_cmp(&other.difference).then(other.index.cmp(&self.index))
    }
}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Candidate {}

/// Emission of every part: density times area, summed over its leaves. Quarters follow the part they divide.
fn sums(parts: &[BuildPart]) -> Vec<f64> {
    let mut sums = vec![0.0; parts.len()];
    for (i, part) in parts.iter().enumerate().rev() {
        sums[i] = match part.quarters {
            Some(first) => sums[first..first + 4].iter().sum(),
            None => part.emission(),
        };
    }
    sums
}

/// Nodes of the divided parts that emit, in order of creation, the whole triangle first.
fn nodes(parts: &[BuildPart], sums: &[f64]) -> Vec<Node> {
    let mut numbers = vec![LEAF; parts.len()];
    let mut count = 0;
    for (number, (part, sum)) in numbers.iter_mut().zip(parts.iter().zip(sums)) {
        if part.quarters.is_some() && *sum > 0.0 {
            *number = count;
            count += 1;
        }
    }
    // A positive share that underflows in f32 must not become zero.
    let share = |sum: f64, of: f64| {
        if sum > 0.0 { ((sum / of) as f32).max(f32::MIN_POSITIVE) } else { 0.0 }
    };
    let divided = parts.iter().zip(sums).filter_map(|(part, sum)| Some((part.quarters?, *sum)));
    divided
        .filter(|(_, sum)| *sum > 0.0)
        .map(|(first, of)| Node {
            shares: std::array::from_fn(|i| share(sums[first + i], of)),
            below: std::array::from_fn(|i| numbers[first + i]),
        })
        .collect()
}

/// A triangle with textured emission.
#[derive(Clone, Debug)]
pub struct Patterned {
    /// The triangle with its mean radiance.
    pub area: Area,
    /// Sampling density of the emission over the triangle.
    pub pattern: Arc<Pattern>,
}

impl Patterned {
    fn facet(&self, p: Vec3) -> Option<Facet> {
        let AreaShape::Triangle([a, b, c]) = self.area.shape else { return None };
        Some(Facet::triangle(p, a, b, c))
    }

    /// As [`crate::Light::sample_as`]. The centroid is the centroid of the emission.
    pub(crate) fn sample_as(&self, aiming: Aiming, p: Vec3, u: Vec2) -> Option<LightSample> {
        let (whole, two_sided) = (self.facet(p)?, self.area.two_sided);
        if aiming == Aiming::Centroid {
            return self.area.as_point(whole.middle(two_sided, self.pattern.middle)?);
        }
        let (mut u, by_angle) = (u.as_dvec2(), aiming == Aiming::SolidAngle);
        let (part, probability) =
            self.pattern.descend(&whole, by_angle, |_, weights, sum| pick(weights, sum, &mut u));
        let (leaf, u) = (whole.part(&part), u.as_vec2().min(Vec2::splat(1.0 - f32::EPSILON / 2.0)));
        let mut aimed = match by_angle {
            true => leaf.sample(u, two_sided),
            false => leaf.sample_surface(u, two_sided),
        }?;
        let at = part.corner + part.step * DVec2::new(aimed.point.u.into(), aimed.point.v.into());
        (aimed.point.u, aimed.point.v) = (at.x as f32, at.y as f32);
        aimed.pdf = (f64::from(aimed.pdf) * probability) as f32;
        self.area.sample_at(aimed)
    }

    /// Density per solid angle at `p` of [`Patterned::sample_as`] for the point `at` (barycentric coordinates) at
    /// `distance`.
    pub(crate) fn pdf_at(&self, aiming: Aiming, p: Vec3, distance: f32, at: Vec2) -> f32 {
        let Some(whole) = self.facet(p) else { return 0.0 };
        let (at, by_angle) = (at.as_dvec2(), aiming == Aiming::SolidAngle);
        if aiming == Aiming::Centroid {
            return 0.0;
        }
        let (part, probability) = self.pattern.descend(&whole, by_angle, |part, _, _| part.quarter_of(at));
        let leaf = whole.part(&part);
        let pdf = match by_angle {
            true => leaf.pdf(distance, self.area.two_sided),
            false => leaf.pdf_surface(distance, self.area.two_sided),
        };
        ((pdf * probability) as f32).min(f32::MAX)
    }

    /// Density of a direction, from which the point is computed: less accurate than [`Patterned::pdf_at`] if leaves are
    /// small.
    pub(crate) fn pdf(&self, aiming: Aiming, p: Vec3, wi: Vec3, distance: f32) -> f32 {
        let at = self.facet(p).and_then(|whole| whole.place(wi));
        at.map_or(0.0, |at| self.pdf_at(aiming, p, distance, at))
    }
}

/// Selects one of four by weight: the pair by u.x, the element of the pair by u.y, both rescaled to \[0, 1).
fn pick(weights: &[f64; 4], sum: f64, u: &mut DVec2) -> usize {
    let stretched = |u: &mut f64, first: f64, sum: f64| {
        let share = first / sum;
        let is_first = *u < share || first >= sum;
        let within = if is_first { *u / share } else { (*u - share) / (1.0 - share) };
        *u = within.clamp(0.0, 1.0 - f64::EPSILON);
        is_first
    };
    let (one, other) = if stretched(&mut u.x, weights[0] + weights[3], sum) { (0, 3) } else { (1, 2) };
    let pair = weights[one] + weights[other];
    if stretched(&mut u.y, weights[one], pair) { one } else { other }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Emission `lit` within `size` of `at` in either barycentric coordinate, `dim` elsewhere.
    fn spot(at: DVec2, size: f64, lit: f64, dim: f64) -> Option<Pattern> {
        let inside = |p: DVec2| (p - at).abs().max_element() <= size;
        Pattern::new(4000, Vec2::ZERO, |part| {
            let [a, b, c] = part.corners();
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            let touched = (low - at).max_element() <= size && (at - high).max_element() <= size;
            let covered = inside(low) && inside(high);
            let (low, high) = (if covered { lit } else { dim }, if touched { lit } else { dim });
            Emitted { low, high, mean: 0.5 * (low + high), is_fine: part.step.abs() < 1e-3 }
        })
        .0
    }

    #[test]
    fn quarters_tile_their_part() {
        let turned = Part::WHOLE.quarter(3).quarter(1);
        for part in [Part::WHOLE, Part::WHOLE.quarter(2), turned] {
            let all = [0, 1, 2, 3].map(|i| part.quarter(i));
            assert_eq!(all.iter().map(Part::area).sum::<f64>(), part.area());
            for (i, quarter) in all.iter().enumerate() {
                let [a, b, c] = quarter.corners();
                assert_eq!(part.quarter_of((a + b + c) / 3.0), i, "{part:?}");
            }
        }
    }

    #[test]
    fn even_and_dark_triangles_need_no_pattern() {
        assert!(spot(DVec2::splat(0.3), 0.01, 0.0, 0.0).is_none(), "dark");
        assert!(spot(DVec2::splat(0.3), 0.1, 1.0, 0.9).is_none(), "nearly even");
        assert!(spot(DVec2::splat(0.3), 0.1, 1.0, 0.0).is_some());
    }

    #[test]
    fn picks_have_their_weights_and_stretch_back() {
        let weights = [0.5, 0.0, 2.0, 1.5];
        let n = 400;
        let mut counts = [0; 4];
        for i in 0..n * n {
            let mut u = DVec2::new(f64::from(i % n) + 0.5, f64::from(i / n) + 0.5) / f64::from(n);
            counts[pick(&weights, 4.0, &mut u)] += 1;
            assert!(u.cmpge(DVec2::ZERO).all() && u.cmplt(DVec2::ONE).all());
        }
        for (count, weight) in counts.iter().zip(weights) {
            assert!((f64::from(*count) / f64::from(n * n) - weight / 4.0).abs() < 0.005);
        }
    }
}
