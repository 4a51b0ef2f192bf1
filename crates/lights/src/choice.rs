//! Which light to aim at.
//!
//! Lights are chosen by the irradiance they could send to the receiver (see [`crate::Light`] for units): a few one by one,
//! many by a tree. Nothing here knows what stands in the way, so a share of the choices is even over all lights: a dim
//! light in view is found even if a bright one hides.
use crate::Light;
use crate::cluster::{Bounds, Cluster, mean};
use crate::tree::Tree;
use dapple_sampling::discrete::Choice;
use glam::Vec3;

/// Up to this many lights are weighed one by one.
const FEW: usize = 8;
/// Share of choices that is even over all lights: among few, and among many.
const EVEN_FEW: f64 = 1.0 / 8.0;
const EVEN_MANY: f64 = 1.0 / 16.0;

/// None of its pmfs is 0 for a light that can contribute.
#[derive(Clone, Debug)]
pub struct LightChoice {
    /// The lights that can be chosen, by their number in the scene: first those without place, then the others.
    lights: Vec<u32>,
    /// Place in `lights` by number in the scene; `NEVER` for those that are not chosen.
    places: Vec<u32>,
    far: Vec<Far>,
    near: Near,
    /// Share of the power that comes from `far`.
    far_power: f64,
}
const NEVER: u32 = u32::MAX;

/// A light without place: irradiance on a facing surface, and where from unless from everywhere.
#[derive(Clone, Copy, Debug)]
struct Far {
    irradiance: f64,
    towards: Option<Vec3>,
}

#[derive(Clone, Debug)]
enum Near {
    Few(Vec<Cluster>),
    Many(Tree),
}

impl LightChoice {
    /// `lights` in the order they are addressed by; lights that never need aiming at (constant environment) get pmf 0, and
    /// so do black ones. None when no light can be aimed at.
    pub fn new(lights: &[Light], scene_radius: f32) -> Option<Self> {
        let (mut numbers, mut far, mut power) = (Vec::new(), Vec::new(), [0.0; 2]);
        for (i, light) in lights.iter().enumerate() {
            if let Some(f) = Far::of(light) {
                numbers.push(i as u32);
                far.push(f);
                power[0] += mean(light.power(scene_radius));
            }
        }
        let mut bounds = Vec::new();
        for (i, light) in lights.iter().enumerate() {
            if let Some(b) = Bounds::of(light) {
                numbers.push(i as u32);
                bounds.push(b);
                power[1] += mean(light.power(scene_radius));
            }
        }
        let near = match Tree::new(&bounds) {
            Some(tree) if numbers.len() > FEW => Near::Many(tree),
            _ => Near::Few(bounds.iter().map(Cluster::from).collect()),
        };
        let mut places = vec![NEVER; lights.len()];
        numbers.iter().enumerate().for_each(|(place, &light)| places[light as usize] = place as u32);
        let far_power = if power[0] > 0.0 { power[0] / (power[0] + power[1]) } else { 0.0 };
        (!numbers.is_empty()).then_some(Self { lights: numbers, places, far, near, far_power })
    }

    /// Chooses for a receiver at `p` with normal `n` on the side that light is received from (zero = no normal: any
    /// side), by `uc` in \[0,1). `u` of the choice is `uc` stretched back to \[0,1).
    pub fn sample(&self, p: Vec3, n: Vec3, uc: f32) -> Option<Choice> {
        let uc = self.refined(uc, p);
        let count = self.lights.len();
        let even = self.even();
        let (place, aimed, u) = if uc < even {
            let x = uc / even * count as f64;
            let place = (x as usize).min(count - 1);
            (place, self.aimed_pmf(p, n, place), x - place as f64)
        } else {
            self.aim(p, n, ((uc - even) / (1.0 - even)).min(1.0 - f64::EPSILON))
        };
        let pmf = even / count as f64 + (1.0 - even) * aimed;
        let u = (u as f32).clamp(0.0, 1.0 - f32::EPSILON / 2.0);
        Some(Choice { index: self.lights[place] as usize, pmf: pmf as f32, u })
    }

    /// Probability with which `sample` chooses `light` (its number in the scene); the same bits.
    pub fn pmf(&self, p: Vec3, n: Vec3, light: usize) -> f32 {
        match self.places.get(light) {
            None | Some(&NEVER) => 0.0,
            Some(&place) => {
                let even = self.even();
                let aimed = self.aimed_pmf(p, n, place as usize);
                (even / self.lights.len() as f64 + (1.0 - even) * aimed) as f32
            }
        }
    }

    fn even(&self) -> f64 {
        if matches!(self.near, Near::Few(_)) { EVEN_FEW } else { EVEN_MANY }
    }

    /// With many lights the 24 bits of `uc` would be used up on the way down: below them come bits of a hash of `uc` and
    /// `p`. Order is kept.
    fn refined(&self, uc: f32, p: Vec3) -> f64 {
        const STEPS: f64 = (1 << 24) as f64;
        let u = (uc as f64).clamp(0.0, 1.0 - 1.0 / STEPS);
        if matches!(self.near, Near::Few(_)) {
            return u;
        }
        let words = [uc, p.x, p.y, p.z].map(|x| x.to_bits() as u64);
        let bits = words.iter().fold(0, |h, w| mix(h ^ w));
        ((u * STEPS).floor() + (bits >> 24) as f64 / (1u64 << 40) as f64) / STEPS
    }

    /// Place, probability and u stretched back, by importance.
    fn aim(&self, p: Vec3, n: Vec3, u: f64) -> (usize, f64, f64) {
        match &self.near {
            Near::Few(clusters) => {
                let (weights, sum) = self.weigh(clusters, p, n);
                pick(&weights[..self.lights.len()], sum, u)
            }
            Near::Many(tree) => {
                let (share, sum) = self.far_share(tree, p, n);
                if u < share {
                    let weights: Vec<f64> = self.far.iter().map(|f| f.importance(n)).collect();
                    let (place, probability, u) = pick(&weights, sum, u / share);
                    return (place, probability * share, u);
                }
                let (item, probability, u) = tree.sample(p, n, (u - share) / (1.0 - share));
                (self.far.len() + item, probability * (1.0 - share), u)
            }
        }
    }

    /// Probability with which `aim` gives a place.
    fn aimed_pmf(&self, p: Vec3, n: Vec3, place: usize) -> f64 {
        match &self.near {
            Near::Few(clusters) => {
                let (weights, sum) = self.weigh(clusters, p, n);
                probability(weights[place], sum, self.lights.len())
            }
            Near::Many(tree) => {
                let (share, sum) = self.far_share(tree, p, n);
                match self.far.get(place) {
                    Some(far) => probability(far.importance(n), sum, self.far.len()) * share,
                    None => tree.pmf(p, n, place - self.far.len()) * (1.0 - share),
                }
            }
        }
    }

    /// Importance of each of a few lights, and the sum.
    fn weigh(&self, clusters: &[Cluster], p: Vec3, n: Vec3) -> ([f64; FEW], f64) {
        let mut weights = [0.0; FEW];
        let far = self.far.iter().map(|f| f.importance(n));
        let near = clusters.iter().map(|c| c.importance(p, n));
        weights.iter_mut().zip(far.chain(near)).for_each(|(w, importance)| *w = importance);
        (weights, weights.iter().sum())
    }

    /// Probability of the lights without place, and the sum of their importance: half by importance here, half by power,
    /// because the importance of a whole tree is a poor guess for a receiver inside it.
    fn far_share(&self, tree: &Tree, p: Vec3, n: Vec3) -> (f64, f64) {
        if self.far.is_empty() {
            return (0.0, 0.0);
        }
        let sum: f64 = self.far.iter().map(|f| f.importance(n)).sum();
        let near = tree.importance(p, n);
        let here = if sum + near > 0.0 { sum / (sum + near) } else { self.far_power };
        (0.5 * (here + self.far_power), sum)
    }
}

impl Far {
    fn of(light: &Light) -> Option<Self> {
        let far = match light {
            Light::Distant(l) => Self { irradiance: mean(l.irradiance), towards: Some(l.towards) },
            Light::Environment(l) if l.is_sampled() => {
                Self { irradiance: mean(l.mean()) * std::f64::consts::PI, towards: None }
            }
            _ => return None,
        };
        (far.irradiance > 0.0).then_some(far)
    }

    fn importance(&self, n: Vec3) -> f64 {
        match self.towards {
            Some(towards) if n != Vec3::ZERO => self.irradiance * n.dot(towards).max(0.0) as f64,
            _ => self.irradiance,
        }
    }
}

/// weight/sum; even where nothing has weight.
fn probability(weight: f64, sum: f64, count: usize) -> f64 {
    if sum > 0.0 { weight / sum } else { 1.0 / count as f64 }
}

/// One of a few by weight: place, probability and u stretched back.
fn pick(weights: &[f64], sum: f64, u: f64) -> (usize, f64, f64) {
    let (mut low, mut last) = (0.0, (0, 0.0, 0.0));
    for (i, &w) in weights.iter().enumerate() {
        let p = probability(w, sum, weights.len());
        if p > 0.0 {
            last = (i, p, ((u - low) / p).clamp(0.0, 1.0 - f64::EPSILON));
            if u < low + p {
                break;
            }
        }
        low += p;
    }
    last
}

/// Finaliser of splitmix64 [Steele 2014].
fn mix(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
