//! Which light to aim at.
//!
//! Lights are chosen by the irradiance they could send to the receiver (see [`crate::Light`] for units): a few one by one,
//! many by a tree. Nothing here knows what stands in the way, so a share of the choices is even over all lights: a dim
//! light in view is found even if a bright one hides.
use crate::Light;
use crate::cluster::{Bounds, mean};
use crate::lanes::{LANES, Weights};
use crate::tree::Tree;
use dapple_sampling::{Key, discrete::Choice};
use glam::Vec3;

/// Share of choices that is even over all lights: among few (each weighed alone), and among many.
const EVEN_FEW: f64 = 1.0 / 8.0;
const EVEN_MANY: f64 = 1.0 / 16.0;

/// None of its pmfs is 0 for a light that can contribute.
#[derive(Clone, Debug)]
pub struct LightSampler {
    /// The lights that can be chosen, by their number in the scene: first those without place, then the others.
    lights: Vec<u32>,
    /// Place in `lights` by number in the scene; `NEVER` for those that are not chosen.
    places: Vec<u32>,
    far: Vec<Far>,
    near: Option<Tree>,
    /// Share of the power that comes from `far`.
    far_power: f64,
    /// Share of choices that is even over all lights.
    even: f64,
}
const NEVER: u32 = u32::MAX;

/// A light without place: irradiance on a facing surface, and where from unless from everywhere.
#[derive(Clone, Copy, Debug)]
struct Far {
    irradiance: f64,
    towards: Option<Vec3>,
}

impl LightSampler {
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
        let even = if bounds.len() <= LANES { EVEN_FEW } else { EVEN_MANY };
        let near = Tree::new(&bounds);
        let mut places = vec![NEVER; lights.len()];
        numbers.iter().enumerate().for_each(|(place, &light)| places[light as usize] = place as u32);
        let far_power = if power[0] > 0.0 { power[0] / (power[0] + power[1]) } else { 0.0 };
        (!numbers.is_empty()).then_some(Self { lights: numbers, places, far, near, far_power, even })
    }

    /// Chooses for a receiver at `p` with normal `n` on the side that light is received from (zero = no normal: any
    /// side), by `uc` in \[0,1). `u` of the choice is `uc` stretched back to \[0,1).
    pub fn sample(&self, p: Vec3, n: Vec3, uc: f32) -> Option<Choice> {
        let uc = refined(uc, p);
        let (count, even) = (self.lights.len(), self.even);
        let here = self.here(p, n);
        let (place, aimed, u) = if uc < even {
            let x = uc / even * count as f64;
            let place = (x as usize).min(count - 1);
            (place, self.aimed_pmf(&here, p, n, place), x - place as f64)
        } else {
            self.aim(&here, p, n, ((uc - even) / (1.0 - even)).min(1.0 - f64::EPSILON))
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
                let aimed = self.aimed_pmf(&self.here(p, n), p, n, place as usize);
                (self.even / self.lights.len() as f64 + (1.0 - self.even) * aimed) as f32
            }
        }
    }

    /// Whether `light` (its number in the scene) is ever chosen.
    pub fn contains(&self, light: usize) -> bool {
        self.places.get(light).is_some_and(|&place| place != NEVER)
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let near = self.near.as_ref().map_or(0, Tree::memory_bytes);
        size_of_val(&*self.lights) + size_of_val(&*self.places) + size_of_val(&*self.far) + near
    }

    /// What choosing and its probability share: the importance of the lights without place, their probability, and the
    /// weights at the root of the tree. With few lights the share goes by importance, which is then that of each light;
    /// with many half by importance and half by power, because the importance of a whole tree is a poor guess for a
    /// receiver inside it.
    fn here(&self, p: Vec3, n: Vec3) -> Here {
        let Some(tree) = &self.near else {
            return Here { far: self.far_importance(n), share: 1.0, root: None };
        };
        let root = tree.root(p, n);
        if self.far.is_empty() {
            return Here { far: 0.0, share: 0.0, root: Some(root) };
        }
        let (far, near) = (self.far_importance(n), tree.importance(&root));
        let here = if far + near > 0.0 { far / (far + near) } else { self.far_power };
        let few = self.even == EVEN_FEW;
        Here { far, share: if few { here } else { 0.5 * (here + self.far_power) }, root: Some(root) }
    }

    fn far_importance(&self, n: Vec3) -> f64 {
        self.far.iter().map(|f| f.importance(n)).sum()
    }

    /// Place, probability and u stretched back, by importance.
    fn aim(&self, here: &Here, p: Vec3, n: Vec3, u: f64) -> (usize, f64, f64) {
        match (&self.near, &here.root) {
            (Some(tree), Some(root)) if u >= here.share => {
                let u = ((u - here.share) / (1.0 - here.share)).min(1.0 - f64::EPSILON);
                let (item, probability, u) = tree.sample(root, p, n, u);
                (self.far.len() + item, (1.0 - here.share) * probability, u)
            }
            _ => {
                let (place, probability, u) = self.aim_far(here.far, n, u / here.share);
                (place, here.share * probability, u)
            }
        }
    }

    /// One of the lights without place: number, probability and u stretched back.
    fn aim_far(&self, sum: f64, n: Vec3, u: f64) -> (usize, f64, f64) {
        let (mut low, mut last) = (0.0, (0, 0.0, 0.0));
        for (i, far) in self.far.iter().enumerate() {
            let p = probability(far.importance(n), sum, self.far.len());
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

    /// Probability with which `aim` gives a place.
    fn aimed_pmf(&self, here: &Here, p: Vec3, n: Vec3, place: usize) -> f64 {
        if let Some(far) = self.far.get(place) {
            return here.share * probability(far.importance(n), here.far, self.far.len());
        }
        match (&self.near, &here.root) {
            (Some(tree), Some(root)) => (1.0 - here.share) * tree.pmf(root, p, n, place - self.far.len()),
            _ => 0.0,
        }
    }
}

/// See [`LightSampler::here`].
struct Here {
    far: f64,
    share: f64,
    root: Option<Weights>,
}

/// With many lights the 24 bits of `uc` would be used up on the way down: below them come bits of a hash of `uc` and `p`.
/// Order is kept.
fn refined(uc: f32, p: Vec3) -> f64 {
    const STEPS: f64 = (1 << 24) as f64;
    let u = (uc as f64).clamp(0.0, 1.0 - 1.0 / STEPS);
    let words = [uc, p.x, p.y, p.z].map(|x| x.to_bits() as u64);
    let bits = Key::hash(words).bits();
    ((u * STEPS).floor() + (bits >> 24) as f64 / (1u64 << 40) as f64) / STEPS
}

impl Far {
    fn of(light: &Light) -> Option<Self> {
        let far = match light {
            Light::Distant(l) => Self { irradiance: mean(l.irradiance), towards: Some(l.towards) },
            Light::Environment(l) if l.is_sampled() => {
                Self { irradiance: mean(l.mean()) * std::f64::consts::PI, towards: None }
            }
            Light::Moving(l) => Self { irradiance: mean(l.distant_irradiance()?), towards: None },
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
