//! The sum of lobes at one point seen from one direction, with value, density and sampling that agree.
//!
//! Built once per path vertex from plain numbers; lobes without weight do not exist (a bare Lambert surface has one
//! lobe and no table look-up). Either side of a surface may be hit: everything is turned so that `wo` is above it, and
//! only the index of refraction knows which side that was. Opaque matter therefore looks alike from both sides.
//!
//! With several lobes, one is chosen with probability proportional to its directional albedo (at least 5 % each) and
//! the weight is the sum of all lobes' f·cos over the mixture density: the balance heuristic over lobes.

use crate::albedo::Row;
use crate::diffuse::Diffuse;
use crate::fresnel::{Clear, Schlick, normal_reflectance};
use crate::microfacet::Ggx;
use crate::mirror::{SHARP_BLUR, SquareBlur, WIDEST_BLUR};
use crate::reflection::{Fresnel, Rough};
use crate::transmission::{Facet, Transmission};
use crate::{Lobe, Lobes, Material, Mirror};
use dapple_sampling::warp;
use glam::{Vec2, Vec3};

/// Every live lobe is chosen at least this often before normalising.
const LEAST_ODDS: f32 = 0.05;

/// Cosines below this count as in the surface, where no light goes: f32 products of two of them end here.
const GRAZING: f32 = 1e-18;

/// Ready to evaluate for one `wo`. Directions are unit, point away, local frame; wo.z may be negative (back side).
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    /// Turned so that z ≥ 0.
    wo: Vec3,
    /// −1 when turned over, else 1.
    side: f32,
    live: Lobes,
    body: Body,
}

/// What the surface is.
#[derive(Clone, Copy, Debug)]
enum Body {
    /// Seen edge-on.
    Nothing,
    Mirror {
        kr: Vec3,
        blur: Option<SquareBlur>,
    },
    Layers(Layers),
}

/// glTF's layers, each with the share it has in the mix.
#[derive(Clone, Copy, Debug)]
struct Layers {
    diffuse: Option<Diffuse>,
    reflection: Option<Fresnel>,
    transmission: Option<Transmission>,
    /// `None` = smooth.
    rough: Option<Rough>,
    /// Odds of diffuse, reflection, transmission; not normalised; meaningless with fewer than two lobes.
    odds: [f32; 3],
}

/// One sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Local frame, unit, pointing away.
    pub wi: Vec3,
    /// f·|cosθ_i| / pdf (mixture over the lobes asked for); never negative.
    pub weight: Vec3,
    /// Solid-angle density of the mixture; meaningless (1) for delta lobes.
    pub pdf: f32,
    /// The lobe that was chosen.
    pub lobe: Lobe,
    /// (η_i/η_o)², the inverse of the radiance scaling in `weight`, for roulette: 1 for reflection and thin walls.
    pub eta: f32,
}

impl Bsdf {
    /// `wo` local; `wo.z < 0` means the ray arrives at the back side. Parameters outside their ranges are clamped, and
    /// not-a-number counts as 0.
    pub fn new(material: &Material, wo: Vec3) -> Self {
        let side = if wo.z < 0.0 { -1.0 } else { 1.0 };
        let wo = Vec3::new(wo.x, wo.y, wo.z * side);
        let body = if wo.z < GRAZING || wo.is_nan() {
            Body::Nothing
        } else if let Some(mirror) = &material.mirror {
            Body::mirror(mirror, wo)
        } else {
            Body::Layers(Layers::new(material, wo, side))
        };
        Self { wo, side, live: body.live(), body }
    }

    /// BSDF value without cosine (1/sr), delta lobes excluded; zero for directions in the surface.
    pub fn f(&self, wi: Vec3, lobes: Lobes) -> Vec3 {
        self.eval(wi, lobes).0
    }

    /// Solid-angle density of `sample_f` for the same lobes; delta lobes count in the choice, not in the density.
    pub fn pdf(&self, wi: Vec3, lobes: Lobes) -> f32 {
        self.eval(wi, lobes).1
    }

    /// [`Self::f`] and [`Self::pdf`] at once.
    pub fn eval(&self, wi: Vec3, lobes: Lobes) -> (Vec3, f32) {
        let asked = self.live.and(lobes);
        let wi = self.turn(wi);
        if asked.without(Lobes::DELTA).is_empty() || wi.z.abs() < GRAZING {
            return (Vec3::ZERO, 0.0);
        }
        match &self.body {
            Body::Mirror { kr, blur: Some(blur) } if wi.z > 0.0 => {
                let pdf = blur.pdf(wi);
                (*kr * (pdf / wi.z), pdf)
            }
            Body::Layers(layers) => layers.eval(self.wo, wi, asked),
            _ => (Vec3::ZERO, 0.0),
        }
    }

    /// A direction for the lobes asked for; `None` when they carry nothing or the direction falls where light cannot go
    /// (the sample then counts as zero). `uc` chooses the lobe, `u` the direction.
    pub fn sample_f(&self, uc: f32, u: Vec2, lobes: Lobes) -> Option<BsdfSample> {
        let asked = self.live.and(lobes);
        if asked.is_empty() {
            return None;
        }
        let mut sample = match &self.body {
            Body::Nothing => None,
            Body::Mirror { kr, blur } => sample_mirror(self.wo, *kr, blur.as_ref(), u),
            Body::Layers(layers) => layers.sample(self.wo, uc, u, asked),
        }?;
        sample.wi = self.turn(sample.wi);
        Some(sample)
    }

    /// Lobes that carry weight.
    pub fn lobes(&self) -> Lobes {
        self.live
    }

    /// All delta: next-event estimation cannot help.
    pub fn is_delta(&self) -> bool {
        self.live.without(Lobes::DELTA).is_empty()
    }

    /// Directional albedo estimate, for lobe choice and AOVs; transmission without its radiance scaling.
    pub fn albedo(&self) -> Vec3 {
        match &self.body {
            Body::Nothing => Vec3::ZERO,
            Body::Mirror { kr, .. } => *kr,
            Body::Layers(layers) => layers.albedos(self.wo.z).into_iter().sum(),
        }
    }

    /// The ideal limit of the rough lobes asked for: reflection and refraction at a smooth surface with F at the
    /// macroscopic angle, a mirror without blur. What a ray tracer without that integral shows.
    pub fn sharp(mut self, lobes: Lobes) -> Self {
        match &mut self.body {
            Body::Mirror { blur, .. } if lobes.contains(Lobe::Mirror) => *blur = None,
            Body::Layers(layers) => {
                if lobes.contains(Lobe::GlossyReflection) {
                    layers.rough = None;
                }
                if let (Some(transmission), true) =
                    (&mut layers.transmission, lobes.contains(Lobe::GlossyTransmission))
                {
                    transmission.rough = None;
                }
            }
            _ => {}
        }
        self.live = self.body.live();
        self
    }

    /// To and from the frame in which `wo` is above the surface.
    fn turn(&self, w: Vec3) -> Vec3 {
        Vec3::new(w.x, w.y, w.z * self.side)
    }
}

impl Body {
    fn mirror(mirror: &Mirror, wo: Vec3) -> Self {
        let blur = (mirror.blur >= SHARP_BLUR).then(|| SquareBlur::new(wo, mirror.blur.min(WIDEST_BLUR)));
        Self::Mirror { kr: mirror.kr.max(Vec3::ZERO), blur }
    }

    fn live(&self) -> Lobes {
        match self {
            Self::Nothing => Lobes::NONE,
            Self::Mirror { kr, .. } if *kr == Vec3::ZERO => Lobes::NONE,
            Self::Mirror { blur: Some(_), .. } => Lobes::of(Lobe::Mirror),
            Self::Mirror { blur: None, .. } => Lobes::of(Lobe::DeltaReflection),
            Self::Layers(layers) => layers.live(),
        }
    }
}

fn sample_mirror(wo: Vec3, kr: Vec3, blur: Option<&SquareBlur>, u: Vec2) -> Option<BsdfSample> {
    let Some(blur) = blur else {
        let wi = Vec3::new(-wo.x, -wo.y, wo.z);
        return Some(BsdfSample { wi, weight: kr, pdf: 1.0, lobe: Lobe::DeltaReflection, eta: 1.0 });
    };
    let wi = blur.sample(u).filter(|wi| wi.z >= GRAZING)?;
    Some(BsdfSample { wi, weight: kr, pdf: blur.pdf(wi), lobe: Lobe::Mirror, eta: 1.0 })
}

/// Into 0..1; not-a-number becomes 0.
fn unit(x: f32) -> f32 {
    if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) }
}

impl Layers {
    /// glTF's mix: metallic·metal + (1 − metallic)·(coat over mix(diffuse, clear, transmission)).
    fn new(material: &Material, wo: Vec3, side: f32) -> Self {
        let alpha = unit(material.roughness) * unit(material.roughness);
        let base = material.base_color.max(Vec3::ZERO);
        let metal = unit(material.metallic);
        let clear_share = (1.0 - metal) * unit(material.transmission);
        let opaque_share = (1.0 - metal) * (1.0 - unit(material.transmission));
        let coat = dielectric_schlick(material);

        let diffuse = diffuse_layer(base * opaque_share, &coat, Row::new(alpha), wo.z);
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
        let mut layers = Self { diffuse, reflection, transmission, rough, odds: [1.0; 3] };
        if layers.live().0.count_ones() > 1 {
            layers.odds = layers.odds(wo.z);
        }
        layers
    }

    /// The lobe each layer is, in the order of `odds`.
    fn slots(&self) -> [Option<Lobe>; 3] {
        let reflection = if self.rough.is_some() { Lobe::GlossyReflection } else { Lobe::DeltaReflection };
        let transmission = |t: &Transmission| match t.rough {
            Some(_) => Lobe::GlossyTransmission,
            None => Lobe::DeltaTransmission,
        };
        [
            self.diffuse.map(|_| Lobe::Diffuse),
            self.reflection.as_ref().map(|_| reflection),
            self.transmission.as_ref().map(transmission),
        ]
    }

    fn live(&self) -> Lobes {
        self.slots().into_iter().flatten().fold(Lobes::NONE, Lobes::with)
    }

    /// Directional albedo of each layer.
    fn albedos(&self, mu: f32) -> [Vec3; 3] {
        let alpha = self.rough.map_or(0.0, |rough| rough.ggx.ax);
        let split = Row::new(alpha).at(mu);
        [
            self.diffuse.map_or(Vec3::ZERO, |d| d.albedo()),
            self.reflection.map_or(Vec3::ZERO, |r| r.albedo(split, alpha, mu)),
            self.transmission.map_or(Vec3::ZERO, |t| t.albedo(split, alpha, mu)),
        ]
    }

    /// Mean of the channels of each albedo, raised to the least share.
    fn odds(&self, mu: f32) -> [f32; 3] {
        let grey = self.albedos(mu).map(|albedo| albedo.element_sum());
        let least = (LEAST_ODDS * grey.iter().sum::<f32>()).max(f32::MIN_POSITIVE);
        grey.map(|x| x.max(least))
    }

    /// Odds of the lobes asked for, normalised; zero elsewhere.
    fn shares(&self, slots: [Option<Lobe>; 3], asked: Lobes) -> [f32; 3] {
        let mut odds = [0.0; 3];
        for (k, slot) in slots.into_iter().enumerate() {
            if slot.is_some_and(|lobe| asked.contains(lobe)) {
                odds[k] = self.odds[k];
            }
        }
        let sum: f32 = odds.iter().sum();
        // A lone lobe gets exactly 1: x/x.
        odds.map(|x| x / sum)
    }

    fn eval(&self, wo: Vec3, wi: Vec3, asked: Lobes) -> (Vec3, f32) {
        self.eval_shares(wo, wi, None, self.shares(self.slots(), asked))
    }

    /// Sum of the chosen lobes and of their densities times shares. Delta lobes add nothing. `facet` where it is known
    /// better than from wo and wi: so F and 1 − F see the same facet and add up to 1 to the last digits.
    fn eval_shares(&self, wo: Vec3, wi: Vec3, facet: Option<Facet>, shares: [f32; 3]) -> (Vec3, f32) {
        let (mut f, mut pdf) = (Vec3::ZERO, 0.0);
        if wi.z < 0.0 {
            if let (Some(transmission), true) = (&self.transmission, shares[2] > 0.0) {
                let (value, density) = transmission.eval(wo, wi, facet);
                return (value, shares[2] * density);
            }
            return (f, pdf);
        }
        if let (Some(diffuse), true) = (&self.diffuse, shares[0] > 0.0) {
            f += diffuse.f(wi.z);
            pdf += shares[0] * warp::hemisphere_cosine_pdf(wi.z);
        }
        if let (Some(fresnel), Some(rough), true) = (&self.reflection, &self.rough, shares[1] > 0.0) {
            let (value, density, c) = rough.eval(wo, wi);
            f += fresnel.at(facet.map_or(c, |facet| facet.o)) * value;
            pdf += shares[1] * density;
        }
        (f, pdf)
    }

    fn sample(&self, wo: Vec3, uc: f32, u: Vec2, asked: Lobes) -> Option<BsdfSample> {
        let slots = self.slots();
        let shares = self.shares(slots, asked);
        let k = pick(shares, uc);
        let (lobe, share) = (slots[k]?, shares[k]);
        let (wi, facet) = self.direction(k, wo, u)?;
        let mut sample = BsdfSample { wi, weight: Vec3::ZERO, pdf: 1.0, lobe, eta: 1.0 };
        if let (2, Some(transmission)) = (k, &self.transmission) {
            sample.eta = transmission.eta_squared();
        }
        if lobe.is_delta() {
            sample.weight = self.delta_weight(k, wo) / share;
            return Some(sample);
        }
        let (f, pdf) = self.eval_shares(wo, wi, facet, shares);
        if !(pdf > 0.0 && pdf.is_finite()) {
            return None;
        }
        sample.pdf = pdf;
        sample.weight = match &self.diffuse {
            // Alone, the cosine cancels.
            Some(diffuse) if k == 0 && share == 1.0 => diffuse.weight(wi.z),
            _ => f * (wi.z.abs() / pdf),
        };
        Some(sample)
    }

    /// A direction of layer `k`, strictly on its side of the surface, and the facet that sent it there.
    fn direction(&self, k: usize, wo: Vec3, u: Vec2) -> Option<(Vec3, Option<Facet>)> {
        let (wi, facet) = match (k, &self.rough) {
            (0, _) => (warp::hemisphere_cosine(u), None),
            (1, None) => (Vec3::new(-wo.x, -wo.y, wo.z), None),
            (1, Some(rough)) => rough.sample(wo, u).map(|(wi, c)| (wi, Some(Facet { o: c, i: c })))?,
            _ => self.transmission.as_ref()?.sample(wo, u)?,
        };
        (wi.z.abs() >= GRAZING).then_some((wi, facet))
    }

    /// Weight of a smooth layer before dividing by its share.
    fn delta_weight(&self, k: usize, wo: Vec3) -> Vec3 {
        match (k, &self.reflection, &self.transmission) {
            (1, Some(fresnel), _) => fresnel.at(wo.z),
            (2, _, Some(transmission)) => transmission.delta_weight(wo),
            _ => Vec3::ZERO,
        }
    }
}

/// Index chosen by `uc` among shares that add up to 1; the last one with a share takes what rounding leaves.
fn pick(shares: [f32; 3], uc: f32) -> usize {
    let mut left = uc;
    let mut last = 0;
    for (k, share) in shares.into_iter().enumerate() {
        if share > 0.0 {
            last = k;
            if left < share {
                break;
            }
            left -= share;
        }
    }
    last
}

/// `KHR_materials_ior` and `_specular`: F0 = min(r0·colour, 1)·specular, F90 = specular.
fn dielectric_schlick(material: &Material) -> Schlick {
    let specular = unit(material.specular);
    let r0 = normal_reflectance(material.ior.max(0.0));
    let f0 = (material.specular_color * r0).clamp(Vec3::ZERO, Vec3::ONE) * specular;
    Schlick { f0, f90: specular }
}

/// Lambert under the opaque dielectric's coat; bare when there is no coat.
fn diffuse_layer(rho: Vec3, coat: &Schlick, row: Row, mu: f32) -> Option<Diffuse> {
    if rho == Vec3::ZERO {
        None
    } else if coat.f90 == 0.0 {
        Some(Diffuse::bare(rho))
    } else {
        Diffuse::coated(rho, row, coat.f0.max_element(), coat.f90, mu)
    }
}

/// The interface of clear matter as seen from the side of `wo`.
fn clear_layer(material: &Material, tint: Schlick, side: f32) -> Clear {
    // η² has to stay a number.
    let ior = if material.ior > 0.0 { material.ior.clamp(1e-6, 1e6) } else { 0.0 };
    let eta = if side < 0.0 && !material.thin && ior > 0.0 { 1.0 / ior } else { ior };
    Clear::new(tint, eta, material.thin)
}
