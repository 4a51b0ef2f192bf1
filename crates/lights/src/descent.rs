//! The light tree over lanes: every lane is a receiver of its own, at a node of its own.

use crate::octet::{Cluster, LANES};
use crate::tree::{LEAF, Tree};
use dapple_math::lanes::{Double, Mask, Real, Vec3x, Word};
use glam::Vec3;

/// The nodes of a tree in rows that lanes read.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    /// Three rows per cluster, eight clusters per node.
    clusters: Vec<[f32; 4]>,
    /// Eight links per node.
    links: Vec<u32>,
    /// The lower and the upper half of the path to each item.
    trails: Vec<u32>,
}

/// Receivers: positions and normals, one per lane.
#[derive(Clone, Copy)]
pub(crate) struct Receivers<R: Real> {
    pub p: Vec3x<R>,
    pub n: Vec3x<R>,
}

/// What a lane looks for: an item by a number `u`, or the probability of a given `item`.
#[derive(Clone, Copy)]
pub(crate) struct Aim<R: Real> {
    /// In \[0, 1), of no meaning in the lanes of `given`.
    pub u: R::Double,
    /// Of meaning in the lanes of `given` only.
    pub item: R::Word,
    pub given: R::Mask,
}

/// Items, the probabilities of selecting them, and the numbers they were selected by, rescaled to \[0, 1).
#[derive(Clone, Copy)]
pub(crate) struct Found<R: Real> {
    pub item: R::Word,
    pub probability: R::Double,
    pub u: R::Double,
}

impl Rows {
    pub fn new(tree: &Tree) -> Self {
        let (mut clusters, mut links) = (Vec::new(), Vec::new());
        for (lanes, of_node) in tree.nodes() {
            clusters.extend((0..LANES).flat_map(|lane| lanes.rows(lane)));
            links.extend(of_node);
        }
        let trails = tree.trails().flat_map(|trail| [trail as u32, (trail >> 32) as u32]).collect();
        Self { clusters, links, trails }
    }

    /// Memory use in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.clusters) + size_of_val(&*self.links) + size_of_val(&*self.trails)
    }

    /// Descends from the root to an item in the lanes of `active`, with the numbers of [`Tree::sample`] and
    /// [`Tree::pmf`].
    #[inline(always)]
    pub fn descend<R: Real>(&self, active: R::Mask, at: &Receivers<R>, aim: &Aim<R>) -> Found<R> {
        let (word, none) = (R::Word::splat(0), R::Double::splat(0.0));
        let twice = aim.item << 1;
        let mut trail = [R::Word::gather(&self.trails, twice), R::Word::splat(0)];
        trail[1] = R::Word::gather(&self.trails, twice.wrapping_add(R::Word::splat(1)));
        let (mut node, mut item, mut open) = (word, aim.item, active);
        let (mut probability, mut u) = (R::Double::splat(1.0), aim.u);
        let mut is_root = true;
        while open.any() {
            let mut weights = [R::splat(0.0); LANES];
            for (k, weight) in weights.iter_mut().enumerate() {
                *weight = self.cluster::<R>(is_root, node, k).weighted(at);
            }
            let mut sums = sums(&weights);
            let is_finite = sums[LANES].lt(R::Double::splat(f64::INFINITY));
            let unreached = open & !(none.lt(sums[LANES]) & is_finite);
            if unreached.any() {
                for (k, weight) in weights.iter_mut().enumerate() {
                    let intensity = self.cluster::<R>(is_root, node, k).intensity;
                    *weight = R::select(unreached, intensity, *weight);
                }
                sums = self::sums(&weights);
            }
            let total = sums[LANES];
            let target = u * total;
            let mut lane = R::Word::splat(LANES as u32 - 1);
            let (mut low, mut weight) = (sums[LANES - 1], weights[LANES - 1]);
            for k in (0..LANES - 1).rev() {
                let ends = target.lt(sums[k + 1]);
                lane = R::Word::select(ends, R::Word::splat(k as u32), lane);
                low = R::Double::select(ends, sums[k], low);
                weight = R::select(ends, weights[k], weight);
            }
            if (aim.given & open).any() {
                lane = R::Word::select(aim.given, trail[0] & R::Word::splat(LANES as u32 - 1), lane);
                for (k, of_lane) in weights.iter().enumerate() {
                    let is_it = aim.given & lane.eq(R::Word::splat(k as u32));
                    weight = R::select(is_it, *of_lane, weight);
                }
                trail[0] = trail[0] >> 3 | trail[1] << 29;
                trail[1] = trail[1] >> 3;
            }
            let weight = R::Double::from_real(weight);
            probability = R::Double::select(open, probability * (weight / total), probability);
            let rest = ((target - low) / weight).max(none);
            let most = R::Double::splat(1.0 - f64::EPSILON);
            u = R::Double::select(open, R::Double::select(rest.lt(most), rest, most), u);
            let link = R::Word::gather(&self.links, (node << 3).wrapping_add(lane));
            let is_leaf = (link & R::Word::splat(LEAF)).ne(word);
            item = R::Word::select(open & is_leaf, link & R::Word::splat(!LEAF), item);
            node = R::Word::select(open & !is_leaf, link, node);
            open = open & !is_leaf;
            is_root = false;
        }
        Found { item, probability, u }
    }

    /// Cluster `k` of the nodes.
    #[inline(always)]
    fn cluster<R: Real>(&self, is_root: bool, node: R::Word, k: usize) -> Cluster<R> {
        let at = |row: usize| 3 * k + row;
        if is_root {
            let [a, b, c] = [self.clusters[at(0)], self.clusters[at(1)], self.clusters[at(2)]];
            return Cluster::of_rows([splat(a), splat(b), splat(c)]);
        }
        let first = node.wrapping_mul(R::Word::splat(3 * LANES as u32));
        let at = [at(0) as u32, at(1) as u32, at(2) as u32];
        Cluster::of_rows([
            R::gather_rows(&self.clusters, first.wrapping_add(R::Word::splat(at[0]))),
            R::gather_rows(&self.clusters, first.wrapping_add(R::Word::splat(at[1]))),
            R::gather_rows(&self.clusters, first.wrapping_add(R::Word::splat(at[2]))),
        ])
    }
}

#[inline(always)]
fn splat<R: Real>([a, b, c, d]: [f32; 4]) -> [R; 4] {
    [R::splat(a), R::splat(b), R::splat(c), R::splat(d)]
}

/// 0, and the sums of the first one to eight weights.
#[inline(always)]
fn sums<R: Real>(weights: &[R; LANES]) -> [R::Double; LANES + 1] {
    let mut sums = [R::Double::splat(0.0); LANES + 1];
    for k in 0..LANES {
        sums[k + 1] = sums[k] + R::Double::from_real(weights[k]);
    }
    sums
}

impl<R: Real> Cluster<R> {
    #[inline(always)]
    fn weighted(&self, at: &Receivers<R>) -> R {
        let zero = Vec3x::splat(Vec3::ZERO);
        let has_normal = at.n.x.ne(zero.x) | at.n.y.ne(zero.y) | at.n.z.ne(zero.z);
        self.weight::<true>(at.p, at.n, has_normal)
    }
}
