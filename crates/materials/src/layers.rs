//! The layers of a glTF material for one direction above the surface, each with its share:
//! metallic·metal + (1 − metallic)·(coat over mix(diffuse base, clear dielectric, transmission)).

use crate::albedo::AlbedoRow;
use crate::choice::{Choice, Shares};
use crate::diffuse::Diffuse;
use crate::fresnel::{Interface, Schlick, normal_reflectance};
use crate::microfacet::{Ggx, reflect};
use crate::reflection::Rough;
use crate::sample::{BsdfSample, GRAZING};
use crate::transmission::{ClearLayer, Direction, MicrofacetCosines};
use crate::{Lobe, Lobes, Material};
use dapple_sampling::warp;
use glam::{Vec2, Vec3};

/// The layers with non-zero weight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layers {
    diffuse: Option<Diffuse>,
    /// Fresnel term of metal and opaque dielectric, weighted by their shares.
    opaque: Schlick,
    clear: Option<ClearLayer>,
    /// Microfacet distribution; `None` for smooth surfaces.
    rough: Option<Rough>,
    /// Lobes with non-zero weight; they also determine which layers are treated as smooth.
    live: Lobes,
    /// Albedo, summed over the channels, of diffuse base, opaque reflection, clear reflection and transmission; unset
    /// with fewer than two lobes.
    grey: [f32; 4],
    /// Selection probabilities for all live lobes.
    shares: Shares,
}

/// Clamps to 0..1; NaN becomes 0.
fn unit(x: f32) -> f32 {
    if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) }
}

impl Layers {
    /// Builds the layers for `wo` above the surface. `side` is −1 if that is the back side. `losing_as`: the cosine
    /// that determines the energy loss of single scattering, if it is not that of `wo`.
    pub fn new(material: &Material, wo: Vec3, side: f32, losing_as: Option<f32>) -> Self {
        let alpha = unit(material.roughness) * unit(material.roughness);
        let base = material.base_color.max(Vec3::ZERO);
        let metal = unit(material.metallic);
        let clear_share = (1.0 - metal) * unit(material.transmission);
        let opaque_share = (1.0 - metal) * (1.0 - unit(material.transmission));
        let coat = dielectric_schlick(material);
        let gain = losing_as.map_or(1.0, |mu| gain(alpha, wo.z, mu));

        let opaque =
            Schlick { f0: base * metal + coat.f0 * opaque_share, f90: metal + coat.f90 * opaque_share };
        let mut layers = Self {
            diffuse: diffuse_layer(base * opaque_share, &coat, alpha, wo.z, gain),
            opaque,
            clear: (clear_share > 0.0).then(|| clear_layer(material, coat, base, clear_share, side)),
            rough: None,
            live: Lobes::NONE,
            grey: [1.0; 4],
            shares: Shares::default(),
        };
        if opaque.f90 > 0.0 || layers.clear.is_some() {
            layers.rough = Ggx::isotropic(alpha).map(|ggx| Rough::new(ggx, wo).losing_as(gain));
        }
        layers.live = layers.lobes();
        layers.choose(wo.z);
        layers
    }

    /// Replaces the given rough lobes by smooth ones.
    pub fn sharpen(&mut self, mu: f32, lobes: Lobes) {
        self.live = self.live.sharpened(lobes);
        self.choose(mu);
    }

    /// Lobes with non-zero weight.
    pub fn live(&self) -> Lobes {
        self.live
    }

    fn lobes(&self) -> Lobes {
        let mut lobes = Lobes::NONE;
        if self.diffuse.is_some() {
            lobes = lobes.with(Lobe::Diffuse);
        }
        if self.opaque.f90 > 0.0 || self.clear.is_some_and(|clear| clear.interface.reflects()) {
            let rough = self.rough.is_some();
            lobes = lobes.with(if rough { Lobe::GlossyReflection } else { Lobe::DeltaReflection });
        }
        if let Some(clear) = self.clear.filter(|clear| clear.tint != Vec3::ZERO) {
            let rough = self.rough.is_some() && clear.interface.blurs();
            lobes = lobes.with(if rough { Lobe::GlossyTransmission } else { Lobe::DeltaTransmission });
        }
        lobes
    }

    /// Directional albedo of diffuse base, opaque reflection, clear reflection and transmission.
    fn albedos(&self, mu: f32) -> [Vec3; 4] {
        let split = AlbedoRow::new(self.rough.map_or(0.0, |rough| rough.ggx.ax)).at(mu);
        let split = split.times(self.rough.map_or(1.0, |rough| rough.gain()));
        let diffuse = self.diffuse_albedo();
        let opaque = self.opaque.f0 * split.c + (Vec3::splat(self.opaque.f90) - self.opaque.f0) * split.b;
        let [back, on] = self.clear.map_or([Vec3::ZERO; 2], |clear| clear.albedos(split.c, mu));
        [diffuse, opaque, back, on]
    }

    /// Directional albedo of the diffuse base.
    pub fn diffuse_albedo(&self) -> Vec3 {
        self.diffuse.map_or(Vec3::ZERO, |diffuse| diffuse.albedo())
    }

    /// The clear layer, if it has a smooth surface.
    fn smooth(&self) -> Option<&ClearLayer> {
        self.clear.as_ref().filter(|_| self.live.contains(Lobe::DeltaTransmission))
    }

    /// Transmission through a smooth surface that does not refract.
    pub fn straight(&self, wo: Vec3) -> Vec3 {
        self.smooth()
            .filter(|clear| clear.interface.keeps_direction())
            .map_or(Vec3::ZERO, |clear| clear.delta_weight(wo))
    }

    /// Transmission through a smooth surface with refraction ignored.
    pub fn straightened(&self, mu: f32) -> Vec3 {
        self.smooth()
            .map_or(Vec3::ZERO, |clear| clear.tint * clear.interface.from_thinner().transmittance(mu))
    }

    /// Sum of the albedos of the layers.
    pub fn albedo(&self, mu: f32) -> Vec3 {
        self.albedos(mu).into_iter().sum()
    }

    fn choose(&mut self, mu: f32) {
        // A single lobe needs no estimate of its albedo.
        if self.live.0.count_ones() > 1 {
            self.grey = self.albedos(mu).map(|albedo| albedo.element_sum());
        }
        self.shares = self.shares_of(self.live);
    }

    fn shares_of(&self, asked: Lobes) -> Shares {
        Shares::new(self.grey, asked, self.opaque.f90 > 0.0)
    }

    fn shares(&self, asked: Lobes) -> Shares {
        if asked == self.live { self.shares } else { self.shares_of(asked) }
    }

    /// Value and density of the given lobes. Delta lobes contribute nothing.
    pub fn eval(&self, wo: Vec3, wi: Vec3, asked: Lobes) -> (Vec3, f32) {
        self.eval_known(wo, wi, None, asked, &self.shares(asked))
    }

    /// As [`Self::eval`]. `known` holds the cosines of the facet if they are known more accurately than from wo and wi,
    /// so that F and 1 − F use the same facet and add up to 1 to the last digits.
    fn eval_known(
        &self,
        wo: Vec3,
        wi: Vec3,
        known: Option<MicrofacetCosines>,
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
        if let (Some(rough), true) = (&self.rough, asked.contains(Lobe::GlossyReflection)) {
            let (value, density, c) = rough.eval(wo, wi);
            let c = known.map_or(c, |facet| facet.o);
            f += self.opaque.at(c) * value;
            pdf += shares.reflection * density;
            if let Some(clear) = &self.clear {
                let reflectance = clear.interface.reflectance(c);
                f += reflectance * (clear.share * value);
                let ratio = rough.visible_ratio(wo, clear.interface.thin);
                pdf += shares.facets * clear.reflecting(reflectance) * density * ratio;
            }
        }
        (f, pdf)
    }

    fn eval_below(
        &self,
        wo: Vec3,
        wi: Vec3,
        known: Option<MicrofacetCosines>,
        asked: Lobes,
        shares: &Shares,
    ) -> (Vec3, f32) {
        let (Some(clear), Some(rough), true) =
            (&self.clear, &self.rough, asked.contains(Lobe::GlossyTransmission))
        else {
            return (Vec3::ZERO, 0.0);
        };
        let Some((value, density, reflectance)) = clear.eval(rough, wo, wi, known) else {
            return (Vec3::ZERO, 0.0);
        };
        let share = shares.transmission + shares.facets * (1.0 - clear.reflecting(reflectance));
        (clear.tint * ((1.0 - reflectance.max_element()) * value), share * density)
    }

    /// Samples a direction from the given lobes.
    pub fn sample(&self, wo: Vec3, uc: f32, u: Vec2, asked: Lobes) -> Option<BsdfSample> {
        let shares = self.shares(asked);
        let (choice, share, uc) = shares.pick(uc)?;
        let (wi, lobe, facet) = self.direction(choice, wo, uc, u, asked)?;
        let eta = match &self.clear {
            Some(clear) if lobe.is_transmission() => clear.interface.eta_squared(),
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
            // For the diffuse lobe alone the cosine cancels.
            Some(diffuse) if lobe == Lobe::Diffuse && share == 1.0 => diffuse.weight(wi.z),
            _ => f * (wi.z.abs() / pdf),
        };
        (pdf > 0.0 && pdf.is_finite()).then_some(BsdfSample { wi, weight, pdf, lobe, eta })
    }

    /// Direction for the selected layer; `None` if no light can travel there.
    fn direction(&self, choice: Choice, wo: Vec3, uc: f32, u: Vec2, asked: Lobes) -> Option<Direction> {
        match choice {
            Choice::Diffuse => Some((warp::hemisphere_cosine(u), Lobe::Diffuse, None)),
            Choice::Reflection => {
                if asked.contains(Lobe::DeltaReflection) {
                    return Some((Vec3::new(-wo.x, -wo.y, wo.z), Lobe::DeltaReflection, None));
                }
                let m = self.rough.as_ref()?.bounded_facet(wo, u)?;
                reflected(wo, m)
            }
            Choice::Transmission => {
                let clear = self.clear.as_ref()?;
                if asked.contains(Lobe::DeltaTransmission) {
                    return Some((clear.interface.through(wo)?, Lobe::DeltaTransmission, None));
                }
                clear.leave(wo, clear.facet(self.rough.as_ref()?, wo, u)?)
            }
            Choice::Facets => {
                let clear = self.clear.as_ref()?;
                let m = clear.facet(self.rough.as_ref()?, wo, u)?;
                let turns = uc < clear.reflecting(clear.interface.reflectance(wo.dot(m)));
                if turns { reflected(wo, m) } else { clear.leave(wo, m) }
            }
        }
    }

    /// Weight of a smooth layer before division by its selection probability.
    fn delta_weight(&self, lobe: Lobe, wo: Vec3) -> Vec3 {
        match (&self.clear, lobe.is_transmission()) {
            (Some(clear), true) => clear.delta_weight(wo),
            (Some(clear), false) => self.opaque.at(wo.z) + clear.interface.reflectance(wo.z) * clear.share,
            (None, _) => self.opaque.at(wo.z),
        }
    }
}

/// `wo` reflected at a facet; `None` below the surface.
fn reflected(wo: Vec3, m: Vec3) -> Option<Direction> {
    let (wi, c) = (reflect(wo, m), wo.dot(m));
    (wi.z > 0.0).then_some((wi, Lobe::GlossyReflection, Some(MicrofacetCosines { o: c, i: c })))
}

/// `KHR_materials_ior` and `_specular`: F0 = min(r0·colour, 1)·specular, F90 = specular.
fn dielectric_schlick(material: &Material) -> Schlick {
    let specular = unit(material.specular);
    let r0 = normal_reflectance(material.ior.max(0.0));
    let f0 = (material.specular_color * r0).clamp(Vec3::ZERO, Vec3::ONE) * specular;
    Schlick { f0, f90: specular }
}

/// Albedo of the perfectly reflecting lobe at cosine `mu` relative to that at `seen`; 1 for smooth surfaces. Accurate
/// to 0.25 %, like the table.
fn gain(alpha: f32, seen: f32, mu: f32) -> f32 {
    let row = AlbedoRow::new(alpha);
    row.at(mu).c / row.at(seen).c
}

/// Lambertian base under the coat of the opaque dielectric; uncoated if there is no coat.
fn diffuse_layer(rho: Vec3, coat: &Schlick, alpha: f32, mu: f32, gain: f32) -> Option<Diffuse> {
    if rho == Vec3::ZERO {
        None
    } else if coat.f90 == 0.0 {
        Some(Diffuse::bare(rho))
    } else {
        Diffuse::coated(rho, AlbedoRow::new(alpha), (coat.f0.max_element(), coat.f90), mu, gain)
    }
}

/// The clear layer as seen from the side of `wo`.
fn clear_layer(material: &Material, tint: Schlick, base: Vec3, share: f32, side: f32) -> ClearLayer {
    // Clamped so that η² remains finite.
    let ior = if material.ior > 0.0 { material.ior.clamp(1e-6, 1e6) } else { 0.0 };
    let eta = if side < 0.0 && !material.thin && ior > 0.0 { 1.0 / ior } else { ior };
    ClearLayer { share, tint: base * share, interface: Interface::new(tint, eta, material.thin) }
}
