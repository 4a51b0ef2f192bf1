//! glTF's mix of layers seen from one direction above the surface, each with its share:
//! metallic·metal + (1 − metallic)·(coat over mix(diffuse base, clear matter, transmission)).
//!
//! Which layer a sample follows: its directional albedo, mean of the channels, at least 5 % for each rough layer (smooth
//! ones weigh exactly what their share says). Rough clear matter is one choice, not two: a visible facet is drawn, and
//! that facet reflects with probability R/(R + T) of its own, so that total reflection inside rough glass wastes nothing.

use crate::albedo::Row;
use crate::bsdf::{BsdfSample, GRAZING};
use crate::diffuse::Diffuse;
use crate::fresnel::{Clear, Schlick, normal_reflectance};
use crate::microfacet::{Ggx, reflect};
use crate::reflection::{Fresnel, Rough};
use crate::transmission::{Facet, Transmission};
use crate::{Lobe, Lobes, Material};
use dapple_sampling::warp;
use glam::{Vec2, Vec3};

/// Every live rough lobe is chosen at least this often before normalising.
const LEAST_SHARE: f32 = 0.05;

/// A facet takes either way at least this often, so that q and 1 − q keep their digits.
const LEAST_TURN: f32 = 1e-3;

/// The largest f32 below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// The layers that exist.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layers {
    diffuse: Option<Diffuse>,
    reflection: Option<Fresnel>,
    transmission: Option<Transmission>,
    /// `None` = smooth.
    rough: Option<Rough>,
    /// Grey albedo of diffuse base, opaque reflection, clear reflection, transmission; unset with fewer than two lobes.
    grey: [f32; 4],
    /// For all live lobes.
    shares: Shares,
}

/// Probability of each choice; they add up to 1.
#[derive(Clone, Copy, Debug, Default)]
struct Shares {
    diffuse: f32,
    reflection: f32,
    transmission: f32,
    /// Facets of rough clear matter, which then reflect or transmit.
    facets: f32,
}

/// What a sample follows.
#[derive(Clone, Copy)]
enum Choice {
    Diffuse,
    Reflection,
    Transmission,
    Facets,
}

/// A direction on its side of the surface, the lobe, and the facet that sent it there.
type Direction = (Vec3, Lobe, Option<Facet>);

/// Into 0..1; not-a-number becomes 0.
fn unit(x: f32) -> f32 {
    if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) }
}

impl Layers {
    /// `wo` above the surface; `side` −1 when that is the back.
    pub fn new(material: &Material, wo: Vec3, side: f32) -> Self {
        let alpha = unit(material.roughness) * unit(material.roughness);
        let base = material.base_color.max(Vec3::ZERO);
        let metal = unit(material.metallic);
        let clear_share = (1.0 - metal) * unit(material.transmission);
        let opaque_share = (1.0 - metal) * (1.0 - unit(material.transmission));
        let coat = dielectric_schlick(material);

        let diffuse = diffuse_layer(base * opaque_share, &coat, alpha, wo.z);
        let clear = (clear_share > 0.0).then(|| clear_layer(material, coat, side));
        let opaque =
            Schlick { f0: base * metal + coat.f0 * opaque_share, f90: metal + coat.f90 * opaque_share };
        let reflects = opaque.f90 > 0.0 || clear.is_some_and(|clear| clear.reflects());
        let reflection =
            reflects.then_some(Fresnel { opaque, clear: clear.map(|clear| (clear, clear_share)) });
        let rough =
            Ggx::isotropic(alpha).filter(|_| reflects || clear.is_some()).map(|ggx| Rough::new(ggx, wo));
        let transmission = clear.filter(|_| base != Vec3::ZERO).map(|clear| Transmission {
            tint: base * clear_share,
            clear,
            rough: rough.filter(|_| clear.thin || !clear.goes_straight()),
        });
        let mut layers =
            Self { diffuse, reflection, transmission, rough, grey: [1.0; 4], shares: Shares::default() };
        layers.choose(wo.z);
        layers
    }

    /// Makes the rough lobes asked for smooth.
    pub fn sharpen(&mut self, mu: f32, lobes: Lobes) {
        if lobes.contains(Lobe::GlossyReflection) {
            self.rough = None;
        }
        if let (Some(transmission), true) = (&mut self.transmission, lobes.contains(Lobe::GlossyTransmission))
        {
            transmission.rough = None;
        }
        self.choose(mu);
    }

    /// Lobes that carry weight.
    pub fn live(&self) -> Lobes {
        let mut live = Lobes::NONE;
        if self.diffuse.is_some() {
            live = live.with(Lobe::Diffuse);
        }
        if self.reflection.is_some() {
            live = live.with(self.reflection_lobe());
        }
        if let Some(transmission) = &self.transmission {
            live = live.with(transmission.lobe());
        }
        live
    }

    fn reflection_lobe(&self) -> Lobe {
        if self.rough.is_some() { Lobe::GlossyReflection } else { Lobe::DeltaReflection }
    }

    /// Directional albedo of diffuse base, opaque reflection, clear reflection, transmission.
    fn albedos(&self, mu: f32) -> [Vec3; 4] {
        let split = Row::new(self.rough.map_or(0.0, |rough| rough.ggx.ax)).at(mu);
        [
            self.diffuse.map_or(Vec3::ZERO, |d| d.albedo()),
            self.reflection.map_or(Vec3::ZERO, |r| r.opaque_albedo(split)),
            self.reflection.map_or(Vec3::ZERO, |r| r.clear_albedo(split, mu)),
            self.transmission.map_or(Vec3::ZERO, |t| t.albedo(split, mu)),
        ]
    }

    /// Sum of the layers' albedos.
    pub fn albedo(&self, mu: f32) -> Vec3 {
        self.albedos(mu).into_iter().sum()
    }

    fn choose(&mut self, mu: f32) {
        let live = self.live();
        // A lone lobe needs no estimate of its size.
        if live.0.count_ones() > 1 {
            self.grey = self.albedos(mu).map(|albedo| albedo.element_sum());
        }
        self.shares = self.shares_of(live);
    }

    /// Probabilities of the choices among the lobes asked for; all zero when those carry nothing.
    fn shares_of(&self, asked: Lobes) -> Shares {
        let [diffuse, opaque, clear, through] = self.grey;
        let (gloss, blur) = (self.rough.is_some(), self.transmission.is_some_and(|t| t.rough.is_some()));
        let reflects = self.reflection.is_some() && asked.contains(self.reflection_lobe());
        let transmits = self.transmission.is_some_and(|t| asked.contains(t.lobe()));
        let facets = reflects && transmits && gloss && blur;
        let mirrors = reflects && (!facets || self.reflection.is_some_and(|r| r.opaque.f90 > 0.0));

        // Chosen, rough, grey albedo.
        let slots = [
            (self.diffuse.is_some() && asked.contains(Lobe::Diffuse), true, diffuse),
            (mirrors, gloss, if facets { opaque } else { opaque + clear }),
            (transmits && !facets, blur, through),
            (facets, true, clear + through),
        ];
        let sum: f32 = slots.iter().map(|&(chosen, _, grey)| if chosen { grey } else { 0.0 }).sum();
        // The estimate may be zero where a rough lobe is not: refraction at the edge of total reflection.
        let least = if sum > 0.0 { LEAST_SHARE * sum } else { 1.0 };
        let raised = slots.map(|(chosen, rough, grey)| match (chosen, rough) {
            (false, _) => 0.0,
            (true, false) => grey,
            (true, true) => grey.max(least),
        });
        let sum: f32 = raised.iter().sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return Shares::default();
        }
        let [diffuse, reflection, transmission, facets] = raised.map(|part| part / sum);
        Shares { diffuse, reflection, transmission, facets }
    }

    fn shares(&self, asked: Lobes) -> Shares {
        if asked == self.live() { self.shares } else { self.shares_of(asked) }
    }

    /// Value and density of the lobes asked for. Delta lobes add nothing.
    pub fn eval(&self, wo: Vec3, wi: Vec3, asked: Lobes) -> (Vec3, f32) {
        self.eval_known(wo, wi, None, asked, &self.shares(asked))
    }

    /// As [`Self::eval`]; `known` is the facet where it is known better than from wo and wi: so F and 1 − F see the same
    /// facet and add up to 1 to the last digits.
    fn eval_known(
        &self,
        wo: Vec3,
        wi: Vec3,
        known: Option<Facet>,
        asked: Lobes,
        shares: &Shares,
    ) -> (Vec3, f32) {
        if wi.z < 0.0 {
            return self.eval_below(wo, wi, known, asked, shares);
        }
        let (mut f, mut pdf) = (Vec3::ZERO, 0.0);
        if let (Some(diffuse), true) = (&self.diffuse, asked.contains(Lobe::Diffuse)) {
            f += diffuse.f(wi.z);
            pdf += shares.diffuse * warp::hemisphere_cosine_pdf(wi.z);
        }
        if let (Some(fresnel), Some(rough), true) =
            (&self.reflection, &self.rough, asked.contains(Lobe::GlossyReflection))
        {
            let (value, density, c) = rough.eval(wo, wi);
            let c = known.map_or(c, |facet| facet.o);
            f += fresnel.opaque.at(c) * value;
            pdf += shares.reflection * density;
            if let Some((clear, share)) = &fresnel.clear {
                let reflectance = clear.reflectance(c);
                f += reflectance * (*share * value);
                pdf += shares.facets
                    * self.reflecting(reflectance)
                    * density
                    * rough.visible_ratio(wo, clear.thin);
            }
        }
        (f, pdf)
    }

    fn eval_below(
        &self,
        wo: Vec3,
        wi: Vec3,
        known: Option<Facet>,
        asked: Lobes,
        shares: &Shares,
    ) -> (Vec3, f32) {
        let Some(transmission) = self.transmission.as_ref().filter(|t| asked.contains(t.lobe())) else {
            return (Vec3::ZERO, 0.0);
        };
        let Some((value, density, reflectance)) = transmission.eval(wo, wi, known) else {
            return (Vec3::ZERO, 0.0);
        };
        let share = shares.transmission + shares.facets * (1.0 - self.reflecting(reflectance));
        (transmission.tint * ((1.0 - reflectance.max_element()) * value), share * density)
    }

    /// Probability that a facet of rough clear matter reflects: its share of what the facet sends anywhere; 1 under total
    /// internal reflection.
    fn reflecting(&self, reflectance: Vec3) -> f32 {
        let (Some(transmission), Some(Fresnel { clear: Some((_, share)), .. })) =
            (&self.transmission, &self.reflection)
        else {
            return 1.0;
        };
        let back = reflectance.element_sum() * *share;
        let on = transmission.tint.element_sum() * (1.0 - reflectance.max_element());
        if on > 0.0 { (back / (back + on)).clamp(LEAST_TURN, 1.0 - LEAST_TURN) } else { 1.0 }
    }

    /// A direction for the lobes asked for.
    pub fn sample(&self, wo: Vec3, uc: f32, u: Vec2, asked: Lobes) -> Option<BsdfSample> {
        let shares = self.shares(asked);
        let (choice, share, uc) = shares.pick(uc)?;
        let (wi, lobe, facet) = self.direction(choice, wo, uc, u)?;
        let eta = match &self.transmission {
            Some(transmission) if lobe.is_transmission() => transmission.eta_squared(),
            _ => 1.0,
        };
        if lobe.is_delta() {
            let weight = self.delta_weight(lobe, wo) / share;
            return Some(BsdfSample { wi, weight, pdf: 1.0, lobe, eta });
        }
        if wi.z.abs() < GRAZING {
            return None;
        }
        let (f, pdf) = self.eval_known(wo, wi, facet, asked, &shares);
        let weight = match &self.diffuse {
            // Alone, the cosine cancels.
            Some(diffuse) if lobe == Lobe::Diffuse && share == 1.0 => diffuse.weight(wi.z),
            _ => f * (wi.z.abs() / pdf),
        };
        (pdf > 0.0 && pdf.is_finite()).then_some(BsdfSample { wi, weight, pdf, lobe, eta })
    }

    /// Where the choice leads; `None` where light cannot go.
    fn direction(&self, choice: Choice, wo: Vec3, uc: f32, u: Vec2) -> Option<Direction> {
        match choice {
            Choice::Diffuse => Some((warp::hemisphere_cosine(u), Lobe::Diffuse, None)),
            Choice::Reflection => match &self.rough {
                None => Some((Vec3::new(-wo.x, -wo.y, wo.z), Lobe::DeltaReflection, None)),
                Some(rough) => {
                    let (wi, c) = rough.sample(wo, u)?;
                    Some((wi, Lobe::GlossyReflection, Some(Facet { o: c, i: c })))
                }
            },
            Choice::Transmission => {
                let transmission = self.transmission.as_ref()?;
                let (wi, facet) = transmission.sample(wo, u)?;
                Some((wi, transmission.lobe(), facet))
            }
            Choice::Facets => self.facet_direction(wo, uc, u),
        }
    }

    /// A facet of rough clear matter, which reflects or lets through.
    fn facet_direction(&self, wo: Vec3, uc: f32, u: Vec2) -> Option<Direction> {
        let (transmission, rough) = (self.transmission.as_ref()?, self.rough.as_ref()?);
        let clear = &transmission.clear;
        let m = if clear.thin { rough.bounded_facet(wo, u)? } else { rough.ggx.sample_visible(wo, u)? };
        let c = wo.dot(m);
        if uc >= self.reflecting(clear.reflectance(c)) {
            let (wi, facet) = transmission.leave(wo, m, c)?;
            return Some((wi, Lobe::GlossyTransmission, Some(facet)));
        }
        let wi = reflect(wo, m);
        (wi.z > 0.0).then_some((wi, Lobe::GlossyReflection, Some(Facet { o: c, i: c })))
    }

    /// Weight of a smooth layer before dividing by its share.
    fn delta_weight(&self, lobe: Lobe, wo: Vec3) -> Vec3 {
        match (&self.reflection, &self.transmission) {
            (_, Some(transmission)) if lobe.is_transmission() => transmission.delta_weight(wo),
            (Some(fresnel), _) => fresnel.at(wo.z),
            _ => Vec3::ZERO,
        }
    }
}

impl Shares {
    /// The choice at `uc`, its share, and `uc` stretched over it; the last one takes what rounding leaves.
    fn pick(&self, uc: f32) -> Option<(Choice, f32, f32)> {
        let slots = [
            (Choice::Diffuse, self.diffuse),
            (Choice::Reflection, self.reflection),
            (Choice::Transmission, self.transmission),
            (Choice::Facets, self.facets),
        ];
        let (mut left, mut last) = (uc, None);
        for (choice, share) in slots {
            if share > 0.0 {
                last = Some((choice, share, (left / share).min(BELOW_ONE)));
                if left < share {
                    break;
                }
                left -= share;
            }
        }
        last
    }
}

/// `KHR_materials_ior` and `_specular`: F0 = min(r0·colour, 1)·specular, F90 = specular.
fn dielectric_schlick(material: &Material) -> Schlick {
    let specular = unit(material.specular);
    let r0 = normal_reflectance(material.ior.max(0.0));
    let f0 = (material.specular_color * r0).clamp(Vec3::ZERO, Vec3::ONE) * specular;
    Schlick { f0, f90: specular }
}

/// Lambert under the opaque dielectric's coat; bare when there is no coat.
fn diffuse_layer(rho: Vec3, coat: &Schlick, alpha: f32, mu: f32) -> Option<Diffuse> {
    if rho == Vec3::ZERO {
        None
    } else if coat.f90 == 0.0 {
        Some(Diffuse::bare(rho))
    } else {
        Diffuse::coated(rho, Row::new(alpha), coat.f0.max_element(), coat.f90, mu)
    }
}

/// The interface of clear matter as seen from the side of `wo`.
fn clear_layer(material: &Material, tint: Schlick, side: f32) -> Clear {
    // η² has to stay a number.
    let ior = if material.ior > 0.0 { material.ior.clamp(1e-6, 1e6) } else { 0.0 };
    let eta = if side < 0.0 && !material.thin && ior > 0.0 { 1.0 / ior } else { ior };
    Clear::new(tint, eta, material.thin)
}
