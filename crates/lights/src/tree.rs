//! Light tree with eight children per node: selects one of many lights in time logarithmic in their number [Conty
//! Estevez and Kulla 2018].
use crate::cluster::{Bounds, Cone};
use crate::octet::{LANES, Lanes, Weights};
use crate::split::{Item, SplitHeuristic};
use dapple_math::lanes::Real;
use glam::Vec3;

/// Nodes of up to eight children each; node 0 is the root.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    /// Per item: the path to its leaf, three bits per level from the lowest, and the number of levels.
    trails: Vec<(u64, u8)>,
    /// Unit of the intensities in the nodes, a power of two.
    unit: f64,
}

#[derive(Clone, Debug)]
struct Node {
    lanes: Lanes,
    /// Node index of each child; for a leaf, the item index with [`LEAF`] set.
    links: [u32; LANES],
}
/// The bit of links that are items.
pub(crate) const LEAF: u32 = 1 << 31;

/// Depth from which sets are divided into parts of equal size: 10 + log8(2³¹) levels fit the trail.
const BALANCED_FROM: u32 = 10;

impl Tree {
    /// Builds the tree; item i is the i-th of `items`. None for an empty set, or for 2³¹ items and more.
    pub fn new(items: &[Bounds]) -> Option<Self> {
        if items.is_empty() || items.len() >= LEAF as usize {
            return None;
        }
        // A power of two, so that dividing by the unit rounds nothing.
        let total: f64 = items.iter().map(|b| b.intensity).sum();
        let unit = libm::exp2(libm::floor(libm::log2(total)));
        let mut order: Vec<Item> = items.iter().zip(0..).map(|(b, i)| Item::new(b, i, unit)).collect();
        let trails = vec![(0, 0); items.len()];
        let mut build = Build { items, split: SplitHeuristic::new(), nodes: Vec::new(), trails, unit };
        build.node(&mut order, 0, 0);
        Some(Self { nodes: build.nodes, trails: build.trails, unit })
    }

    /// Weights of the children of the root for a receiver, an argument of the three functions below.
    #[inline(always)]
    pub fn root<R: Real>(&self, p: Vec3, n: Vec3) -> Weights {
        self.nodes[0].lanes.weigh::<R>(p, n)
    }

    /// Estimate of the irradiance that the whole tree could send.
    pub fn importance(&self, root: &Weights) -> f64 {
        root.importance() * self.unit
    }

    /// Selects an item: returns it, its probability, and u rescaled to \[0,1).
    #[inline(always)]
    pub fn sample<R: Real>(&self, root: &Weights, p: Vec3, n: Vec3, u: f64) -> (usize, f64, f64) {
        let (mut at, mut probability) = (0, 1.0);
        let (mut lane, mut share, mut u) = root.pick(u);
        loop {
            probability *= share;
            let link = self.nodes[at].links[lane % LANES];
            if link & LEAF != 0 {
                return ((link & !LEAF) as usize, probability, u);
            }
            at = link as usize;
            (lane, share, u) = self.nodes[at].lanes.weigh::<R>(p, n).pick(u);
        }
    }

    /// Probability with which `sample` selects `item`: the same products in the same order.
    #[inline(always)]
    pub fn pmf<R: Real>(&self, root: &Weights, p: Vec3, n: Vec3, item: usize) -> f64 {
        let (mut trail, levels) = self.trails[item];
        let (mut at, mut lane) = (0, (trail & 7) as usize);
        let mut probability = root.share(lane);
        for _ in 1..levels {
            at = self.nodes[at].links[lane] as usize;
            trail >>= 3;
            lane = (trail & 7) as usize;
            probability *= self.nodes[at].lanes.weigh::<R>(p, n).share(lane);
        }
        probability
    }

    /// Per node, its clusters and links.
    pub fn nodes(&self) -> impl Iterator<Item = (&Lanes, &[u32; LANES])> {
        self.nodes.iter().map(|node| (&node.lanes, &node.links))
    }

    /// Per item: the path to its leaf, three bits per level from the lowest.
    pub fn trails(&self) -> impl Iterator<Item = u64> {
        self.trails.iter().map(|(trail, _)| *trail)
    }

    /// Memory use in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.trails)
    }
}

struct Build<'a> {
    items: &'a [Bounds],
    split: SplitHeuristic,
    nodes: Vec<Node>,
    trails: Vec<(u64, u8)>,
    unit: f64,
}

impl Build<'_> {
    /// Adds the node for `order` and all nodes below it; returns its bounds.
    fn node(&mut self, order: &mut [Item], trail: u64, depth: u32) -> Bounds {
        let at = self.nodes.len();
        self.nodes.push(Node { lanes: Lanes::EMPTY, links: [LEAF; LANES] });
        let cuts = self.cut(order, depth >= BALANCED_FROM);
        let mut rest = order;
        let mut all: Option<Bounds> = None;
        for (lane, count) in cuts.into_iter().enumerate() {
            let (part, behind) = rest.split_at_mut(count);
            rest = behind;
            let below = trail | (lane as u64) << (3 * depth);
            let (bounds, link) = match part {
                [item] => {
                    self.trails[item.number as usize] = (below, depth as u8 + 1);
                    (self.items[item.number as usize], item.number | LEAF)
                }
                _ => {
                    let link = self.nodes.len() as u32;
                    (self.node(part, below, depth + 1), link)
                }
            };
            self.nodes[at].lanes.set(lane, &bounds, self.unit);
            self.nodes[at].links[lane] = link;
            all = Some(all.map_or(bounds, |all| all.union(&bounds)));
        }
        // A node is never empty.
        all.unwrap_or(Bounds { low: Vec3::ZERO, high: Vec3::ZERO, cone: Cone::ALL, intensity: 0.0 })
    }

    /// Orders the items into at most eight parts and returns the sizes of these: the part of largest cost (of largest
    /// size, if `balanced`) is halved until there are eight.
    fn cut(&self, order: &mut [Item], balanced: bool) -> Vec<usize> {
        if order.len() <= LANES {
            return vec![1; order.len()];
        }
        let cost = |part: &[Item]| match part.len() {
            1 => -1.0,
            n if balanced => n as f64,
            _ => self.split.cost(part),
        };
        let mut parts = vec![(cost(order), order.len())];
        while parts.len() < LANES {
            let widest =
                (0..parts.len()).fold(0, |best, i| if parts[i].0 > parts[best].0 { i } else { best });
            let start: usize = parts[..widest].iter().map(|p| p.1).sum();
            let part = &mut order[start..start + parts[widest].1];
            let middle = self.split.halve(part, balanced);
            let (a, b) = part.split_at(middle);
            parts.splice(widest..=widest, [(cost(a), a.len()), (cost(b), b.len())]);
        }
        parts.into_iter().map(|p| p.1).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Light, Point};

    fn point(x: f32, y: f32, intensity: f32) -> Bounds {
        let p = Vec3::new(x, y, 0.0);
        let light = Light::Point(Point { p, intensity: Vec3::splat(intensity), range: f32::INFINITY });
        Bounds::of(&light).unwrap()
    }

    #[test]
    fn hostile_sets_build_within_the_trail() {
        // Geometric spacing defeats buckets; equal positions defeat any axis; intensities beyond the range of f32 in
        // one set.
        let geometric: Vec<_> = (0..120).map(|i| point(libm::exp2f(-(i as f32)), 0.0, 1.0)).collect();
        let equal: Vec<_> = (0..3000).map(|_| point(1.0, 1.0, 1.0)).collect();
        let steep: Vec<_> =
            (0..70).map(|i| point(i as f32, 0.0, libm::exp2f(125.0 - 3.5 * i as f32))).collect();
        for items in [geometric, equal, steep] {
            let tree = Tree::new(&items).unwrap();
            assert!(tree.trails.iter().all(|t| t.1 <= 21));
            let root = tree.root::<f32>(Vec3::Z, Vec3::ZERO);
            let pmf = |i| tree.pmf::<f32>(&root, Vec3::Z, Vec3::ZERO, i);
            let sum: f64 = (0..items.len()).map(pmf).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        }
        assert!(Tree::new(&[]).is_none());
    }

    #[test]
    fn sample_and_pmf_are_the_same_number() {
        let items: Vec<_> =
            (0..200).map(|i| point((i % 17) as f32, (i / 17) as f32, 1.0 + (i % 3) as f32)).collect();
        let tree = Tree::new(&items).unwrap();
        let (p, n) = (Vec3::new(3.0, 4.0, 1.5), Vec3::new(0.0, 0.6, -0.8));
        let root = tree.root::<f32>(p, n);
        for k in 0..5000 {
            let (item, probability, u) = tree.sample::<f32>(&root, p, n, (k as f64 + 0.5) / 5000.0);
            assert_eq!(probability.to_bits(), tree.pmf::<f32>(&root, p, n, item).to_bits());
            assert!((0.0..1.0).contains(&u));
        }
    }
}
