//! A tree of lights: choosing one of many in time that grows with the logarithm of their number
//! [Conty Estevez and Kulla 2018], eight ways at a time.
use crate::cluster::{Bounds, Cone};
use crate::lanes::{LANES, Lanes, Weights};
use crate::split::{Item, SplitHeuristic};
use glam::Vec3;

/// Nodes of up to eight children each; node 0 is the root.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    /// Per item: the way to its leaf, three bits per level from the lowest; and how many levels.
    trails: Vec<(u64, u8)>,
    /// Intensity of the nodes is in this unit, a power of two.
    unit: f64,
}

#[derive(Clone, Debug)]
struct Node {
    lanes: Lanes,
    /// Node of each child; of a leaf, the item with [`LEAF`] set.
    links: [u32; LANES],
}
const LEAF: u32 = 1 << 31;

/// From this depth on, sets are cut into equal numbers: 10 + log8(2³¹) levels fit the trail.
const BALANCED_FROM: u32 = 10;

impl Tree {
    /// Item i is the i-th of `items`. None when there are none, or 2³¹ and more.
    pub fn new(items: &[Bounds]) -> Option<Self> {
        if items.is_empty() || items.len() >= LEAF as usize {
            return None;
        }
        // A power of two, so that the unit rounds nothing.
        let total: f64 = items.iter().map(|b| b.intensity).sum();
        let unit = libm::exp2(libm::floor(libm::log2(total)));
        let mut order: Vec<Item> = items.iter().zip(0..).map(|(b, i)| Item::new(b, i, unit)).collect();
        let trails = vec![(0, 0); items.len()];
        let mut build = Build { items, split: SplitHeuristic::new(), nodes: Vec::new(), trails, unit };
        build.node(&mut order, 0, 0);
        Some(Self { nodes: build.nodes, trails: build.trails, unit })
    }

    /// What the children of the root could send to a receiver, for the three functions below.
    pub fn root(&self, p: Vec3, n: Vec3) -> Weights {
        self.nodes[0].lanes.weigh(p, n)
    }

    /// Estimate of the irradiance all of it could send.
    pub fn importance(&self, root: &Weights) -> f64 {
        root.importance() * self.unit
    }

    /// Item, its probability, and u stretched back to \[0,1).
    pub fn sample(&self, root: &Weights, p: Vec3, n: Vec3, u: f64) -> (usize, f64, f64) {
        let (mut at, mut weights, mut probability, mut u) = (0, *root, 1.0, u);
        loop {
            let (lane, share, rest) = weights.pick(u);
            let link = self.nodes[at].links[lane];
            (probability, u) = (probability * share, rest);
            if link & LEAF != 0 {
                return ((link & !LEAF) as usize, probability, u);
            }
            at = link as usize;
            weights = self.nodes[at].lanes.weigh(p, n);
        }
    }

    /// The probability with which `sample` gives `item`: the same products in the same order.
    pub fn pmf(&self, root: &Weights, p: Vec3, n: Vec3, item: usize) -> f64 {
        let (mut trail, levels) = self.trails[item];
        let (mut at, mut weights, mut probability) = (0, *root, 1.0);
        for level in 1..=levels {
            let lane = (trail & 7) as usize;
            probability *= weights.share(lane);
            if level < levels {
                at = self.nodes[at].links[lane] as usize;
                weights = self.nodes[at].lanes.weigh(p, n);
            }
            trail >>= 3;
        }
        probability
    }

    /// Bytes held.
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
    /// Adds the node over `order` and all below it; gives its bounds.
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
        // A node always has items.
        all.unwrap_or(Bounds { low: Vec3::ZERO, high: Vec3::ZERO, cone: Cone::ALL, intensity: 0.0 })
    }

    /// Sizes of the up to eight parts into which the items are ordered: the part of greatest cost is halved until there
    /// are eight (of greatest number, when balanced).
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
        // Geometric spacing defeats buckets; equal places defeat any axis; intensities beyond f32 in one set.
        let geometric: Vec<_> = (0..120).map(|i| point(libm::exp2f(-(i as f32)), 0.0, 1.0)).collect();
        let equal: Vec<_> = (0..3000).map(|_| point(1.0, 1.0, 1.0)).collect();
        let steep: Vec<_> =
            (0..70).map(|i| point(i as f32, 0.0, libm::exp2f(125.0 - 3.5 * i as f32))).collect();
        for items in [geometric, equal, steep] {
            let tree = Tree::new(&items).unwrap();
            assert!(tree.trails.iter().all(|t| t.1 <= 21));
            let root = tree.root(Vec3::Z, Vec3::ZERO);
            let pmf = |i| tree.pmf(&root, Vec3::Z, Vec3::ZERO, i);
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
        let root = tree.root(p, n);
        for k in 0..5000 {
            let (item, probability, u) = tree.sample(&root, p, n, (k as f64 + 0.5) / 5000.0);
            assert_eq!(probability.to_bits(), tree.pmf(&root, p, n, item).to_bits());
            assert!((0.0..1.0).contains(&u));
        }
    }
}
