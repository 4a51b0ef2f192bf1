//! A tree of lights: choosing one of many in time that grows with the logarithm of their number
//! [Conty Estevez and Kulla 2018].
use crate::cluster::{Bounds, Cluster};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Binary tree; the first child follows its parent.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    /// Per item: the way to its leaf, one bit per level from the lowest, 1 = second child; and how many levels.
    trails: Vec<(u64, u8)>,
}

#[derive(Clone, Debug)]
struct Node {
    cluster: Cluster,
    /// Second child; of a leaf, the item with this bit set.
    link: u32,
}
const LEAF: u32 = 1 << 31;

/// From this depth on, nodes are split in equal halves: 32 + log2(2³¹) levels fit the trail.
const BALANCED_FROM: u32 = 32;
const BUCKETS: usize = 12;

impl Tree {
    /// Item i is the i-th of `items`. None when there are none, or 2³¹ and more.
    pub fn new(items: &[Bounds]) -> Option<Self> {
        if items.is_empty() || items.len() >= LEAF as usize {
            return None;
        }
        let spread = Spread::new();
        let mut order: Vec<u32> = (0..items.len() as u32).collect();
        let nodes = Vec::with_capacity(2 * items.len());
        let mut build = Build { items, spread, nodes, trails: vec![(0, 0); items.len()] };
        build.node(&mut order, 0, 0);
        Some(Self { nodes: build.nodes, trails: build.trails })
    }

    /// Importance of all of it, see [`Cluster::importance`].
    pub fn importance(&self, p: Vec3, n: Vec3) -> f64 {
        self.nodes[0].cluster.importance(p, n)
    }

    /// Item, its probability, and u stretched back to \[0,1).
    pub fn sample(&self, p: Vec3, n: Vec3, u: f64) -> (usize, f64, f64) {
        let (mut at, mut probability, mut u) = (0, 1.0, u);
        while self.nodes[at].link & LEAF == 0 {
            let first = self.first_probability(at, p, n);
            if u < first {
                (probability, u, at) = (probability * first, u / first, at + 1);
            } else {
                let second = 1.0 - first;
                (probability, u) = (probability * second, (u - first) / second);
                at = self.nodes[at].link as usize;
            }
            u = u.min(1.0 - f64::EPSILON);
        }
        ((self.nodes[at].link & !LEAF) as usize, probability, u)
    }

    /// The probability with which `sample` gives `item`: the same products in the same order.
    pub fn pmf(&self, p: Vec3, n: Vec3, item: usize) -> f64 {
        let (mut trail, levels) = self.trails[item];
        let (mut at, mut probability) = (0, 1.0);
        for _ in 0..levels {
            let first = self.first_probability(at, p, n);
            if trail & 1 == 0 {
                (probability, at) = (probability * first, at + 1);
            } else {
                (probability, at) = (probability * (1.0 - first), self.nodes[at].link as usize);
            }
            trail >>= 1;
        }
        probability
    }

    /// Of the first child: its share of the importance; of the intensity where neither counts.
    #[inline]
    fn first_probability(&self, at: usize, p: Vec3, n: Vec3) -> f64 {
        let (first, second) =
            (&self.nodes[at + 1].cluster, &self.nodes[self.nodes[at].link as usize].cluster);
        let (a, b) = (first.importance(p, n), second.importance(p, n));
        if a + b > 0.0 { a / (a + b) } else { first.intensity / (first.intensity + second.intensity) }
    }

    /// Levels below the root.
    #[cfg(test)]
    fn depth(&self) -> u32 {
        self.trails.iter().map(|t| t.1 as u32).max().unwrap_or(0)
    }
}

struct Build<'a> {
    items: &'a [Bounds],
    spread: Spread,
    nodes: Vec<Node>,
    trails: Vec<(u64, u8)>,
}

impl Build<'_> {
    /// Adds the node over `order` and all below it; gives its bounds.
    fn node(&mut self, order: &mut [u32], trail: u64, depth: u32) -> Bounds {
        let at = self.nodes.len();
        if let [item] = *order {
            let bounds = self.items[item as usize];
            self.trails[item as usize] = (trail, depth as u8);
            self.nodes.push(Node { cluster: Cluster::from(&bounds), link: item | LEAF });
            return bounds;
        }
        let middle = self.split(order, depth);
        let (left, right) = order.split_at_mut(middle);
        // Filled in when the children are known.
        self.nodes.push(Node { cluster: Cluster::from(&self.items[left[0] as usize]), link: 0 });
        let first = self.node(left, trail, depth + 1);
        let link = self.nodes.len() as u32;
        let second = self.node(right, trail | 1 << depth, depth + 1);
        let bounds = first.union(&second);
        self.nodes[at] = Node { cluster: Cluster::from(&bounds), link };
        bounds
    }

    /// Orders the items so that those before the returned place form one child; neither child is empty.
    fn split(&self, order: &mut [u32], depth: u32) -> usize {
        let half = order.len() / 2;
        let centre = |i: u32| self.items[i as usize].centre();
        let mut low = Vec3::INFINITY;
        let mut high = Vec3::NEG_INFINITY;
        for &i in order.iter() {
            low = low.min(centre(i));
            high = high.max(centre(i));
        }
        let extent = high - low;
        if order.len() > 2
            && depth < BALANCED_FROM
            && let Some((axis, border)) = self.cheapest(order, low, extent)
        {
            let middle = partition(order, |i| bucket(centre(i)[axis], low[axis], extent[axis]) < border);
            if middle > 0 && middle < order.len() {
                return middle;
            }
        }
        let axis = (0..3).fold(0, |best, axis| if extent[axis] > extent[best] { axis } else { best });
        // Ties by number, so that the order is total.
        order.select_nth_unstable_by(half, |a, b| {
            centre(*a)[axis].total_cmp(&centre(*b)[axis]).then(a.cmp(b))
        });
        half
    }

    /// Axis and bucket border of least surface-area-orientation cost: intensity · size · spread of directions of both
    /// sides, times the box' longest side over its side along the axis.
    fn cheapest(&self, order: &[u32], low: Vec3, extent: Vec3) -> Option<(usize, usize)> {
        let mut best: Option<(f64, usize, usize)> = None;
        for axis in (0..3).filter(|&a| extent[a] > 0.0) {
            let mut buckets = [Pile::EMPTY; BUCKETS];
            for &i in order {
                let item = &self.items[i as usize];
                buckets[bucket(item.centre()[axis], low[axis], extent[axis])].add(item);
            }
            let mut above = [0.0; BUCKETS];
            let mut pile = Pile::EMPTY;
            for b in (1..BUCKETS).rev() {
                pile.join(&buckets[b]);
                above[b] = pile.cost(&self.spread);
            }
            let shape = extent.max_element() as f64 / extent[axis] as f64;
            let mut below = Pile::EMPTY;
            for b in 1..BUCKETS {
                below.join(&buckets[b - 1]);
                let cost = shape * (below.cost(&self.spread) + above[b]);
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, axis, b));
                }
            }
        }
        best.map(|(_, axis, border)| (axis, border))
    }
}

/// Moves the items for which `keep` holds to the front, others behind; gives how many it holds for.
fn partition(order: &mut [u32], keep: impl Fn(u32) -> bool) -> usize {
    let mut front = 0;
    for i in 0..order.len() {
        if keep(order[i]) {
            order.swap(front, i);
            front += 1;
        }
    }
    front
}

fn bucket(x: f32, low: f32, extent: f32) -> usize {
    (((x - low) / extent * BUCKETS as f32) as usize).min(BUCKETS - 1)
}

/// What the cost of a set of lights needs, gathered in one pass.
#[derive(Clone, Copy)]
struct Pile {
    low: Vec3,
    high: Vec3,
    /// Sum of the items' mean directions.
    direction: DVec3,
    count: f64,
    intensity: f64,
}
impl Pile {
    const EMPTY: Self = Self {
        low: Vec3::INFINITY,
        high: Vec3::NEG_INFINITY,
        direction: DVec3::ZERO,
        count: 0.0,
        intensity: 0.0,
    };

    fn add(&mut self, item: &Bounds) {
        self.low = self.low.min(item.low);
        self.high = self.high.max(item.high);
        let axis = item.cone.axis;
        // Both sides of a sheet count as one direction.
        let flip = item.cone.two_sided && axis.x + 2.0 * axis.y + 4.0 * axis.z < 0.0;
        // The mean of a cap of half-angle θ is (1 + cosθ)/2 long; most are single directions or the whole sphere.
        let length = match item.cone.theta_o {
            0.0 => 1.0,
            theta if theta >= PI => 0.0,
            theta => 0.5 * (1.0 + libm::cos(theta)),
        };
        self.direction += axis * if flip { -length } else { length };
        self.count += 1.0;
        self.intensity += item.intensity;
    }

    fn join(&mut self, other: &Self) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
        self.direction += other.direction;
        self.count += other.count;
        self.intensity += other.intensity;
    }

    /// Size = squared diagonal, which unlike the surface area is not 0 for lights in a row.
    fn cost(&self, spread: &Spread) -> f64 {
        if self.count == 0.0 {
            return 0.0;
        }
        let size = (self.high.as_dvec3() - self.low.as_dvec3()).length_squared();
        self.intensity * size * spread.at(self.direction.length() / self.count)
    }
}

/// The measure of emitted directions M_Ω for θ_e = π/2 by the length R of the mean direction.
/// *Approximation*: the axes are taken to fill their cone evenly, cosθ_o = 2R − 1; it shapes the tree, not its
/// probabilities.
struct Spread([f64; Self::STEPS + 1]);
impl Spread {
    const STEPS: usize = 64;

    fn new() -> Self {
        let mut table = [0.0; Self::STEPS + 1];
        for (i, m) in table.iter_mut().enumerate() {
            *m = measure(libm::acos(2.0 * i as f64 / Self::STEPS as f64 - 1.0));
        }
        Self(table)
    }

    fn at(&self, r: f64) -> f64 {
        let x = r.clamp(0.0, 1.0) * Self::STEPS as f64;
        let i = (x as usize).min(Self::STEPS - 1);
        self.0[i] + (self.0[i + 1] - self.0[i]) * (x - i as f64)
    }
}

/// 2π(1 − cosθ_o) + (π/2)(2θ_w·sinθ_o − cos(θ_o − 2θ_w) − 2θ_o·sinθ_o + cosθ_o), θ_w = min(θ_o + π/2, π).
/// [Conty Estevez and Kulla 2018, §4.1]
fn measure(theta_o: f64) -> f64 {
    let (s, c) = (libm::sin(theta_o), libm::cos(theta_o));
    let w = (theta_o + 0.5 * PI).min(PI);
    2.0 * PI * (1.0 - c) + 0.5 * PI * (2.0 * w * s - libm::cos(theta_o - 2.0 * w) - 2.0 * theta_o * s + c)
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
    fn measure_of_one_direction_is_pi_and_of_all_is_the_sphere() {
        assert!((measure(0.0) - PI).abs() < 1e-12);
        assert!((measure(PI) - 4.0 * PI).abs() < 1e-12);
    }

    #[test]
    fn hostile_sets_build_within_the_depth() {
        // Geometric spacing defeats buckets; equal places defeat any axis.
        let geometric: Vec<_> = (0..120).map(|i| point(libm::exp2f(-(i as f32)), 0.0, 1.0)).collect();
        let equal: Vec<_> = (0..1000).map(|_| point(1.0, 1.0, 1.0)).collect();
        for items in [geometric, equal] {
            let tree = Tree::new(&items).unwrap();
            assert!(tree.depth() <= 64, "{}", tree.depth());
            let sum: f64 = (0..items.len()).map(|i| tree.pmf(Vec3::Z, Vec3::ZERO, i)).sum();
            assert!((sum - 1.0).abs() < 1e-12);
        }
        assert!(Tree::new(&[]).is_none());
    }

    #[test]
    fn sample_and_pmf_are_the_same_number() {
        let items: Vec<_> =
            (0..200).map(|i| point((i % 17) as f32, (i / 17) as f32, 1.0 + (i % 3) as f32)).collect();
        let tree = Tree::new(&items).unwrap();
        let (p, n) = (Vec3::new(3.0, 4.0, 1.5), Vec3::new(0.0, 0.6, -0.8));
        for k in 0..5000 {
            let (item, probability, u) = tree.sample(p, n, (k as f64 + 0.5) / 5000.0);
            assert_eq!(probability.to_bits(), tree.pmf(p, n, item).to_bits());
            assert!((0.0..1.0).contains(&u));
        }
    }
}
