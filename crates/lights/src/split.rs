//! Binary splits of a set of lights: surface-area-orientation heuristic over buckets [Conty Estevez and Kulla 2018,
//! §4.1].
use crate::cluster::Bounds;
use glam::Vec3;
use std::f64::consts::PI;

const BUCKETS: usize = 12;

/// Compact copy of the bounds of one light, as the heuristic needs them.
#[derive(Clone, Copy)]
pub(crate) struct Item {
    low: Vec3,
    high: Vec3,
    /// Mean direction: the axis times (1 + cosθ_o)/2, which is the mean over a spherical cap of half-angle θ_o.
    direction: Vec3,
    intensity: f32,
    pub number: u32,
}

impl Item {
    pub fn new(b: &Bounds, number: u32, unit: f64) -> Self {
        let axis = b.cone.axis.as_vec3();
        // A two-sided surface has no preferred side: its axis is turned into one half space.
        let flip = b.cone.two_sided && axis.x + 2.0 * axis.y + 4.0 * axis.z < 0.0;
        let length = 0.5 * (1.0 + libm::cos(b.cone.theta_o.min(PI))) as f32;
        let direction = axis * if flip { -length } else { length };
        Self { low: b.low, high: b.high, direction, intensity: (b.intensity / unit) as f32, number }
    }

    /// Twice the centre of the bounding box.
    fn place(&self) -> Vec3 {
        self.low + self.high
    }
}

/// The heuristic with its precomputed table.
pub(crate) struct SplitHeuristic {
    /// M_Ω for θ_e = π/2, tabulated over the length R of the mean direction. *Approximation*: the axes are assumed to
    /// fill their cone uniformly, cosθ_o = 2R − 1; this affects the shape of the tree, not its probabilities.
    spread: [f32; Self::STEPS + 1],
}

impl SplitHeuristic {
    const STEPS: usize = 64;

    pub fn new() -> Self {
        let mut spread = [0.0; Self::STEPS + 1];
        for (i, m) in spread.iter_mut().enumerate() {
            *m = measure(libm::acos(2.0 * i as f64 / Self::STEPS as f64 - 1.0)) as f32;
        }
        Self { spread }
    }

    /// Intensity · size · spread of directions.
    pub fn cost(&self, items: &[Item]) -> f64 {
        let mut totals = Totals::EMPTY;
        items.iter().for_each(|item| totals.add(item));
        self.cost_of(&totals)
    }

    /// The size is the squared diagonal, which unlike the surface area is not 0 for lights in a row.
    fn cost_of(&self, totals: &Totals) -> f64 {
        if totals.count == 0.0 {
            return 0.0;
        }
        let r = (totals.direction.length() / totals.count).clamp(0.0, 1.0) * Self::STEPS as f32;
        let i = (r as usize).min(Self::STEPS - 1);
        let spread = self.spread[i] + (self.spread[i + 1] - self.spread[i]) * (r - i as f32);
        let size = (totals.high.as_dvec3() - totals.low.as_dvec3()).length_squared();
        totals.intensity as f64 * size * spread as f64
    }

    /// Partitions the items and returns the index of the first item of the second part; neither part is empty. The
    /// split is at the bucket border of least cost, or at the median if `balanced` or if no border separates the items.
    pub fn halve(&self, items: &mut [Item], balanced: bool) -> usize {
        let mut low = Vec3::INFINITY;
        let mut high = Vec3::NEG_INFINITY;
        for item in items.iter() {
            low = low.min(item.place());
            high = high.max(item.place());
        }
        let extent = high - low;
        if !balanced && let Some((axis, border)) = self.cheapest(items, low, extent) {
            let middle = partition(items, |i| bucket(i.place()[axis], low[axis], extent[axis]) < border);
            if middle > 0 && middle < items.len() {
                return middle;
            }
        }
        let axis = (0..3).fold(0, |best, axis| if extent[axis] > extent[best] { axis } else { best });
        let half = items.len() / 2;
        // Ties are broken by number, so that the order is total.
        let key =
            |a: &Item, b: &Item| a.place()[axis].total_cmp(&b.place()[axis]).then(a.number.cmp(&b.number));
        items.select_nth_unstable_by(half, key);
        half
    }

    /// Axis and border of least cost: the cost of both sides, times the longest side of the box over its side along the
    /// axis.
    fn cheapest(&self, items: &[Item], low: Vec3, extent: Vec3) -> Option<(usize, usize)> {
        let mut buckets = [[Totals::EMPTY; BUCKETS]; 3];
        for item in items {
            for (axis, buckets) in buckets.iter_mut().enumerate() {
                buckets[bucket(item.place()[axis], low[axis], extent[axis])].add(item);
            }
        }
        let mut best: Option<(f64, usize, usize)> = None;
        for axis in (0..3).filter(|&a| extent[a] > 0.0) {
            let shape = extent.max_element() as f64 / extent[axis] as f64;
            for (border, cost) in (1..).zip(self.costs(&buckets[axis])) {
                let cost = shape * cost;
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, axis, border));
                }
            }
        }
        best.map(|(_, axis, border)| (axis, border))
    }

    /// Total cost of both sides for each border between buckets.
    fn costs(&self, buckets: &[Totals; BUCKETS]) -> [f64; BUCKETS - 1] {
        let mut costs = [0.0; BUCKETS - 1];
        let (mut below, mut above) = (Totals::EMPTY, Totals::EMPTY);
        for i in 0..BUCKETS - 1 {
            below.join(&buckets[i]);
            costs[i] += self.cost_of(&below);
            let j = BUCKETS - 2 - i;
            above.join(&buckets[j + 1]);
            costs[j] += self.cost_of(&above);
        }
        costs
    }
}

/// Moves the items for which `keep` holds to the front and the others behind them; returns how many it holds for.
fn partition(items: &mut [Item], keep: impl Fn(&Item) -> bool) -> usize {
    let mut front = 0;
    for i in 0..items.len() {
        if keep(&items[i]) {
            items.swap(front, i);
            front += 1;
        }
    }
    front
}

/// Bucket of a coordinate; 0 if the extent is 0.
fn bucket(x: f32, low: f32, extent: f32) -> usize {
    (((x - low) / extent * BUCKETS as f32) as usize).min(BUCKETS - 1)
}

/// Totals of a set of lights from which its cost follows, gathered in one pass.
#[derive(Clone, Copy)]
struct Totals {
    low: Vec3,
    high: Vec3,
    direction: Vec3,
    intensity: f32,
    count: f32,
}
impl Totals {
    const EMPTY: Self = Self {
        low: Vec3::INFINITY,
        high: Vec3::NEG_INFINITY,
        direction: Vec3::ZERO,
        intensity: 0.0,
        count: 0.0,
    };

    fn add(&mut self, item: &Item) {
        self.low = self.low.min(item.low);
        self.high = self.high.max(item.high);
        self.direction += item.direction;
        self.intensity += item.intensity;
        self.count += 1.0;
    }

    fn join(&mut self, other: &Self) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
        self.direction += other.direction;
        self.intensity += other.intensity;
        self.count += other.count;
    }
}

/// 2π(1 − cosθ_o) + (π/2)(2θ_w·sinθ_o − cos(θ_o − 2θ_w) − 2θ_o·sinθ_o + cosθ_o), θ_w = min(θ_o + π/2, π): the measure
/// of the directions of emission for θ_e = π/2.
fn measure(theta_o: f64) -> f64 {
    let (s, c) = (libm::sin(theta_o), libm::cos(theta_o));
    let w = (theta_o + 0.5 * PI).min(PI);
    2.0 * PI * (1.0 - c) + 0.5 * PI * (2.0 * w * s - libm::cos(theta_o - 2.0 * w) - 2.0 * theta_o * s + c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measure_of_one_direction_is_pi_and_of_all_is_the_sphere() {
        assert!((measure(0.0) - PI).abs() < 1e-12);
        assert!((measure(PI) - 4.0 * PI).abs() < 1e-12);
    }

    #[test]
    fn two_groups_are_parted() {
        let item = |i: u32| {
            let p = Vec3::new(if i.is_multiple_of(3) { 100.0 } else { 0.0 } + i as f32 * 0.01, 0.5, 0.0);
            Item { low: p, high: p, direction: Vec3::Z, intensity: 1.0, number: i }
        };
        let mut items: Vec<Item> = (0..60).map(item).collect();
        let middle = SplitHeuristic::new().halve(&mut items, false);
        assert!(middle == 20 || middle == 40);
        let side = |part: &[Item]| {
            part.iter().all(|i| i.number.is_multiple_of(3) == part[0].number.is_multiple_of(3))
        };
        assert!(side(&items[..middle]) && side(&items[middle..]));
    }
}
