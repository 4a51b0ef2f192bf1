//! Selection of one light for next-event estimation.
//!
//! A light is selected in proportion to an estimate of the irradiance that it could send to the receiver (see
//! [`crate::Light`] for units). Up to eight finite lights are weighted one by one, larger sets by a light tree.
//! Visibility is unknown here, so a fixed share of the selections is uniform over all lights: a dim visible light is
//! selected often enough even if a bright light is occluded.
use crate::Light;
use crate::cluster::{Bounds, mean};
use crate::descent::{Aim, Receivers, Rows};
use crate::octet::{LANES, Weights};
use crate::tree::Tree;
use dapple_math::lanes::{Double, Real, Vec3x, Word};
use dapple_sampling::discrete::Choice;
use glam::Vec3;

/// Share of selections that is uniform over all lights: for small sets (each light weighted alone), and for large sets.
const EVEN_FEW: f64 = 1.0 / 8.0;
const EVEN_MANY: f64 = 1.0 / 16.0;

/// Distribution over the lights of a scene. A light that can contribute never has probability 0.
#[derive(Clone, Debug)]
pub struct LightSampler {
    /// Scene indices of the lights that can be selected: first the infinite lights, then the finite ones.
    lights: Vec<u32>,
    /// Slot in `lights` by scene index; `NEVER` for lights that are never selected.
    slots: Vec<u32>,
    far: Vec<Far>,
    near: Option<Tree>,
    /// The tree for lanes, if there are no infinite lights.
    rows: Option<Rows>,
    /// Share of the total power that comes from `far`.
    far_power: f64,
    /// Share of selections that is uniform over all lights.
    even: f64,
}
const NEVER: u32 = u32::MAX;

/// More lights are selected one by one: their slots would not be exact in f32.
const MOST: usize = 1 << 24;

/// An infinite light: its irradiance on a facing surface, and its direction, or `None` if it arrives from all
/// directions.
#[derive(Clone, Copy, Debug)]
struct Far {
    irradiance: f64,
    towards: Option<Vec3>,
}

impl LightSampler {
    /// `lights` is ordered by scene index. Lights that are never sampled directly (constant environment) get pmf 0, and
    /// so do black ones. Returns None if no light can be sampled.
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
        let mut slots = vec![NEVER; lights.len()];
        numbers.iter().enumerate().for_each(|(slot, &light)| slots[light as usize] = slot as u32);
        let far_power = if power[0] > 0.0 { power[0] / (power[0] + power[1]) } else { 0.0 };
        let is_fit = far.is_empty() && (2..MOST).contains(&numbers.len());
        let rows = near.as_ref().filter(|_| is_fit).map(Rows::new);
        (!numbers.is_empty()).then_some(Self { lights: numbers, slots, far, near, rows, far_power, even })
    }

    /// Selects a light for a receiver at `p` with normal `n` on the side from which light is received (zero: no normal,
    /// any side), with `uc` in \[0,1). The field `u` of the result is `uc` rescaled to \[0,1).
    pub fn sample(&self, p: Vec3, n: Vec3, uc: f32) -> Option<Choice> {
        Some(self.chosen::<f32>(p, n, uc))
    }

    /// Probability with which `sample` selects `light` (its scene index); bitwise equal to the value in the sample.
    pub fn pmf(&self, p: Vec3, n: Vec3, light: usize) -> f32 {
        self.probability::<f32>(p, n, light)
    }

    /// Scene index of the light, if it is the only one.
    #[inline(always)]
    pub(crate) fn only(&self) -> Option<u32> {
        if let &[light] = &*self.lights { Some(light) } else { None }
    }

    /// As [`LightSampler::sample`]; `R` are the lanes over the children of a node.
    #[inline(always)]
    pub(crate) fn chosen<R: Real>(&self, p: Vec3, n: Vec3, uc: f32) -> Choice {
        if let &[light] = &*self.lights {
            return Choice { index: light as usize, pmf: 1.0, u: uc };
        }
        let uc = refined(uc, p);
        let (count, even) = (self.lights.len(), self.even);
        let receiver = self.receiver::<R>(p, n);
        let (slot, by_importance, u) = if uc < even {
            let x = uc / even * count as f64;
            let slot = (x as usize).min(count - 1);
            (slot, self.importance_pmf::<R>(&receiver, p, n, slot), x - slot as f64)
        } else {
            self.sample_importance::<R>(&receiver, p, n, ((uc - even) / (1.0 - even)).min(1.0 - f64::EPSILON))
        };
        let pmf = even / count as f64 + (1.0 - even) * by_importance;
        let u = (u as f32).clamp(0.0, 1.0 - f32::EPSILON / 2.0);
        Choice { index: self.lights[slot] as usize, pmf: pmf as f32, u }
    }

    /// As [`LightSampler::pmf`].
    #[inline(always)]
    pub(crate) fn probability<R: Real>(&self, p: Vec3, n: Vec3, light: usize) -> f32 {
        match self.slots.get(light) {
            None | Some(&NEVER) => 0.0,
            Some(_) if self.lights.len() == 1 => 1.0,
            Some(&slot) => {
                let by_importance = self.importance_pmf::<R>(&self.receiver::<R>(p, n), p, n, slot as usize);
                (self.even / self.lights.len() as f64 + (1.0 - self.even) * by_importance) as f32
            }
        }
    }

    /// [`LightSampler::chosen`] for a receiver per lane: the light, its probability, and u; `None` if lanes have to be
    /// computed one by one.
    #[inline(always)]
    pub(crate) fn chosen_lanes<R: Real>(
        &self,
        active: R::Mask,
        at: &Receivers<R>,
        uc: R,
    ) -> Option<(R::Word, R, R)> {
        let (rows, one) = (self.rows.as_ref()?, R::Double::splat(1.0));
        let (uc, even) = (refined_lanes(uc, at.p), R::Double::splat(self.even));
        let count = self.lights.len();
        let given = uc.lt(even);
        let x = uc / even * R::Double::splat(count as f64);
        let (near, last) = (x.to_real().to_int(), R::Word::splat(count as u32 - 1));
        // Rounding to f32 can reach the next whole number.
        let is_beyond = x.lt(R::Double::from_real(near.int_to_real()));
        let near = R::Word::select(is_beyond, near.wrapping_sub(R::Word::splat(1)), near);
        let item = R::Word::select(given & near.lt(last), near, last);
        let u = (uc - even) / (one - even);
        let most = R::Double::splat(1.0 - f64::EPSILON);
        let u = R::Double::select(u.lt(most), u, most);
        let found = rows.descend::<R>(active, at, &Aim { u, item, given });
        let u = R::Double::select(given, x - R::Double::from_real(item.int_to_real()), found.u).to_real();
        let u = u.max(R::splat(0.0)).min(R::splat(1.0 - f32::EPSILON / 2.0));
        let pmf = self.mixed_pmf::<R>(found.probability);
        Some((R::Word::gather(&self.lights, found.item), R::select(active, pmf, R::splat(0.0)), u))
    }

    /// [`LightSampler::probability`] for a receiver per lane.
    #[inline(always)]
    pub(crate) fn probability_lanes<R: Real>(
        &self,
        active: R::Mask,
        at: &Receivers<R>,
        light: R::Word,
    ) -> Option<R> {
        let rows = self.rows.as_ref()?;
        let slot = R::Word::gather(&self.slots, light);
        let has_slot = light.lt(R::Word::splat(self.slots.len() as u32));
        let active = active & has_slot & slot.ne(R::Word::splat(NEVER));
        let item = R::Word::select(active, slot, R::Word::splat(0));
        let aim = Aim { u: R::Double::splat(0.0), item, given: active };
        let pmf = self.mixed_pmf::<R>(rows.descend::<R>(active, at, &aim).probability);
        Some(R::select(active, pmf, R::splat(0.0)))
    }

    /// The probability of a light with the uniform share.
    #[inline(always)]
    fn mixed_pmf<R: Real>(&self, by_importance: R::Double) -> R {
        let uniform = R::Double::splat(self.even / self.lights.len() as f64);
        (uniform + R::Double::splat(1.0 - self.even) * by_importance).to_real()
    }

    /// Whether `light` (its scene index) is ever selected.
    pub fn contains(&self, light: usize) -> bool {
        self.slots.get(light).is_some_and(|&slot| slot != NEVER)
    }

    /// Memory use in bytes.
    pub fn memory_bytes(&self) -> usize {
        let near = self.near.as_ref().map_or(0, Tree::memory_bytes);
        let rows = self.rows.as_ref().map_or(0, Rows::memory_bytes);
        size_of_val(&*self.lights) + size_of_val(&*self.slots) + size_of_val(&*self.far) + near + rows
    }

    /// Values shared by `sample` and `pmf`: the importance of the infinite lights, their probability, and the weights
    /// at the root of the tree. With few lights the probability is proportional to importance, which is then the
    /// importance of each light; with many lights it is half by importance and half by power, because the importance of
    /// a whole tree is a poor estimate for a receiver inside its bounding box.
    #[inline(always)]
    fn receiver<R: Real>(&self, p: Vec3, n: Vec3) -> Receiver {
        let Some(tree) = &self.near else {
            return Receiver { far: self.far_importance(n), share: 1.0, root: None };
        };
        let root = tree.root::<R>(p, n);
        if self.far.is_empty() {
            return Receiver { far: 0.0, share: 0.0, root: Some(root) };
        }
        let (far, near) = (self.far_importance(n), tree.importance(&root));
        let by_importance = if far + near > 0.0 { far / (far + near) } else { self.far_power };
        let few = self.even == EVEN_FEW;
        let share = if few { by_importance } else { 0.5 * (by_importance + self.far_power) };
        Receiver { far, share, root: Some(root) }
    }

    fn far_importance(&self, n: Vec3) -> f64 {
        self.far.iter().map(|f| f.importance(n)).sum()
    }

    /// Selects by importance; returns the slot, its probability and the rescaled u.
    #[inline(always)]
    fn sample_importance<R: Real>(&self, receiver: &Receiver, p: Vec3, n: Vec3, u: f64) -> (usize, f64, f64) {
        match (&self.near, &receiver.root) {
            (Some(tree), Some(root)) if u >= receiver.share => {
                let u = ((u - receiver.share) / (1.0 - receiver.share)).min(1.0 - f64::EPSILON);
                let (item, probability, u) = tree.sample::<R>(root, p, n, u);
                (self.far.len() + item, (1.0 - receiver.share) * probability, u)
            }
            _ => {
                let (slot, probability, u) = self.sample_far(receiver.far, n, u / receiver.share);
                (slot, receiver.share * probability, u)
            }
        }
    }

    /// Selects one of the infinite lights; returns its slot, its probability and the rescaled u.
    fn sample_far(&self, sum: f64, n: Vec3, u: f64) -> (usize, f64, f64) {
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

    /// Probability with which `sample_importance` selects a slot.
    #[inline(always)]
    fn importance_pmf<R: Real>(&self, receiver: &Receiver, p: Vec3, n: Vec3, slot: usize) -> f64 {
        if let Some(far) = self.far.get(slot) {
            return receiver.share * probability(far.importance(n), receiver.far, self.far.len());
        }
        match (&self.near, &receiver.root) {
            (Some(tree), Some(root)) => {
                (1.0 - receiver.share) * tree.pmf::<R>(root, p, n, slot - self.far.len())
            }
            _ => 0.0,
        }
    }
}

/// See [`LightSampler::receiver`].
struct Receiver {
    far: f64,
    share: f64,
    root: Option<Weights>,
}

/// Extends `uc` by 32 bits of a hash of `uc` and `p`: with many lights its 24 bits would be used up on the way down the
/// tree. The order of values is preserved.
#[inline(always)]
fn refined(uc: f32, p: Vec3) -> f64 {
    refined_lanes::<f32>(uc, p.into())
}

/// [`refined`] per lane.
#[inline(always)]
fn refined_lanes<R: Real>(uc: R, p: Vec3x<R>) -> R::Double {
    const STEPS: f32 = (1 << 24) as f32;
    let hash = mixed(uc.to_bits() ^ p.x.to_bits());
    let hash = mixed(mixed(hash ^ p.y.to_bits()) ^ p.z.to_bits());
    let u = uc.max(R::splat(0.0)).min(R::splat(1.0 - 1.0 / STEPS));
    let whole = R::Double::from_real((u * R::splat(STEPS)).floor());
    let upper = R::Double::from_real((hash >> 16).int_to_real());
    let lower = R::Double::from_real((hash & R::Word::splat(0xffff)).int_to_real());
    let rest = upper * R::Double::splat(1.0 / 65_536.0) + lower * R::Double::splat(1.0 / 4_294_967_296.0);
    (whole + rest) * R::Double::splat(1.0 / f64::from(STEPS))
}

/// A bijection of 32 bits of which every bit depends on all others, by two multiplications.
#[inline(always)]
fn mixed<W: Word>(x: W) -> W {
    let x = (x ^ (x >> 16)).wrapping_mul(W::splat(0x7feb_352d));
    let x = (x ^ (x >> 15)).wrapping_mul(W::splat(0x846c_a68b));
    x ^ (x >> 16)
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

/// weight/sum; uniform if all weights are zero.
fn probability(weight: f64, sum: f64, count: usize) -> f64 {
    if sum > 0.0 { weight / sum } else { 1.0 / count as f64 }
}
