//! The BSDF at one point for one outgoing direction: a sum of lobes with consistent value, density and sampling.
//!
//! A BSDF is built once per path vertex from plain numbers; lobes without weight are omitted (a plain Lambertian
//! surface has one lobe and no table lookup). Either side of a surface may be hit: all directions are flipped so that
//! `wo` is above it, and only the index of refraction depends on the side. Opaque materials therefore look alike from
//! both sides.
//!
//! With several lobes, one is selected by its share of the light, and the weight is the sum of f·cos of all lobes over
//! the mixture density: the balance heuristic over lobes (see `choice`).

use crate::layers::Layers;
use crate::mirror::{SHARP_BLUR, SquareBlur, WIDEST_BLUR};
use crate::sample::{BsdfSample, GRAZING};
use crate::{Lobe, Lobes, Material, Mirror};
use dapple_sampling::warp;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// A BSDF for one `wo`. Directions are unit vectors that point away, in the local frame; wo.z may be negative (back
/// side).
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    /// Outgoing direction, flipped so that z ≥ 0.
    wo: Vec3,
    /// −1 if `wo` was flipped, else 1.
    side: f32,
    live: Lobes,
    body: Body,
}

/// Kind of the surface.
#[derive(Clone, Copy, Debug)]
enum Body {
    /// Seen edge-on; no light is scattered.
    Nothing,
    /// An uncoated diffuse base of this reflectance: the most common material, stored without any other data.
    Lambert(Vec3),
    Mirror {
        kr: Vec3,
        blur: Option<SquareBlur>,
    },
    Layers(Layers),
}

impl Bsdf {
    /// Builds the BSDF for the local direction `wo`; `wo.z < 0` means that the ray arrives at the back side. Parameters
    /// outside their ranges are clamped, and NaN counts as 0.
    pub fn new(material: &Material, wo: Vec3) -> Self {
        Self::losing_as(material, wo, None)
    }

    /// As [`Self::new`], for a perturbed shading normal: the energy loss of single scattering at a rough surface is
    /// that at cosine `mu`, the cosine of `wo` to the unperturbed normal, so that a normal map neither removes nor adds
    /// energy. The Fresnel terms are those at the shading normal.
    pub fn losing_as(material: &Material, wo: Vec3, mu: Option<f32>) -> Self {
        let side = if wo.z < 0.0 { -1.0 } else { 1.0 };
        let wo = Vec3::new(wo.x, wo.y, wo.z * side);
        let body = if wo.z < GRAZING || wo.is_nan() {
            Body::Nothing
        } else if let Some(mirror) = &material.mirror {
            Body::mirror(mirror, wo)
        } else if material.specular == 0.0 && material.metallic == 0.0 && material.transmission == 0.0 {
            Body::Lambert(material.base_color.max(Vec3::ZERO))
        } else {
            Body::Layers(Layers::new(material, wo, side, mu))
        };
        Self { wo, side, live: body.live(), body }
    }

    /// BSDF value without the cosine (1/sr), delta lobes excluded; zero for directions in the surface.
    pub fn f(&self, wi: Vec3, lobes: Lobes) -> Vec3 {
        self.eval(wi, lobes).0
    }

    /// Solid-angle density of `sample_f` for the same lobes; delta lobes count in the selection, not in the density.
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
            Body::Lambert(rho) if wi.z > 0.0 => (*rho * FRAC_1_PI, warp::hemisphere_cosine_pdf(wi.z)),
            Body::Layers(layers) => layers.eval(self.wo, wi, asked),
            _ => (Vec3::ZERO, 0.0),
        }
    }

    /// Samples a direction from the given lobes; `None` if they carry no light or if no light can travel in the sampled
    /// direction (the sample then counts as zero). `uc` selects the lobe, `u` the direction.
    pub fn sample_f(&self, uc: f32, u: Vec2, lobes: Lobes) -> Option<BsdfSample> {
        let asked = self.live.and(lobes);
        if asked.is_empty() {
            return None;
        }
        let mut sample = match &self.body {
            Body::Nothing => None,
            Body::Lambert(rho) => sample_lambert(*rho, u),
            Body::Mirror { kr, blur } => sample_mirror(self.wo, *kr, blur.as_ref(), u),
            Body::Layers(layers) => layers.sample(self.wo, uc, u, asked),
        }?;
        sample.wi = self.turn(sample.wi);
        Some(sample)
    }

    /// Whether light that leaves towards `wi` continues in exactly the direction in which it arrived, to the last bit.
    pub fn passes(&self, wi: Vec3) -> bool {
        self.turn(wi) == -self.wo
    }

    /// Unrefracted transmission of a smooth surface towards `wo`, from the opposite direction: at a thin wall and where
    /// the indices of both sides are equal. Zero elsewhere.
    pub fn straight(&self) -> Vec3 {
        match &self.body {
            Body::Layers(layers) => layers.straight(self.wo),
            _ => Vec3::ZERO,
        }
    }

    /// As [`Self::straight`], also where light is refracted: the fraction that is not reflected, as if it kept its
    /// direction. *Approximation*: the angle is taken on the side of the lower index, so that there is no total
    /// internal reflection.
    pub fn straightened(&self) -> Vec3 {
        match &self.body {
            Body::Layers(layers) => layers.straightened(self.wo.z),
            _ => Vec3::ZERO,
        }
    }

    /// Lobes with non-zero weight.
    pub fn lobes(&self) -> Lobes {
        self.live
    }

    /// Whether all lobes are delta lobes, for which next-event estimation is of no use.
    pub fn is_delta(&self) -> bool {
        self.live.without(Lobes::DELTA).is_empty()
    }

    /// Estimate of the directional albedo, for lobe selection and AOVs; transmission without its radiance scaling.
    pub fn albedo(&self) -> Vec3 {
        match &self.body {
            Body::Nothing => Vec3::ZERO,
            Body::Lambert(rho) => *rho,
            Body::Mirror { kr, .. } => *kr,
            Body::Layers(layers) => layers.albedo(self.wo.z),
        }
    }

    /// Directional albedo of the diffuse lobe alone.
    pub fn diffuse_albedo(&self) -> Vec3 {
        match &self.body {
            Body::Lambert(rho) => *rho,
            Body::Layers(layers) => layers.diffuse_albedo(),
            Body::Nothing | Body::Mirror { .. } => Vec3::ZERO,
        }
    }

    /// The BSDF with the given rough lobes replaced by their ideal limit: reflection and refraction at a smooth surface
    /// with F at the macroscopic angle, a mirror without blur. A ray tracer without the integral over these lobes shows
    /// this limit.
    pub fn sharp(mut self, lobes: Lobes) -> Self {
        match &mut self.body {
            Body::Mirror { blur, .. } if lobes.contains(Lobe::Mirror) => *blur = None,
            Body::Layers(layers) => layers.sharpen(self.wo.z, lobes),
            _ => {}
        }
        self.live = self.body.live();
        self
    }

    /// Converts a direction to and from the frame in which `wo` is above the surface.
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
            Self::Lambert(rho) if *rho == Vec3::ZERO => Lobes::NONE,
            Self::Lambert(_) => Lobes::of(Lobe::Diffuse),
            Self::Mirror { kr, .. } if *kr == Vec3::ZERO => Lobes::NONE,
            Self::Mirror { blur: Some(_), .. } => Lobes::of(Lobe::Mirror),
            Self::Mirror { blur: None, .. } => Lobes::of(Lobe::DeltaReflection),
            Self::Layers(layers) => layers.live(),
        }
    }
}

fn sample_lambert(rho: Vec3, u: Vec2) -> Option<BsdfSample> {
    let wi = warp::hemisphere_cosine(u);
    let pdf = warp::hemisphere_cosine_pdf(wi.z);
    (wi.z >= GRAZING).then_some(BsdfSample { wi, weight: rho, pdf, lobe: Lobe::Diffuse, eta: 1.0 })
}

fn sample_mirror(wo: Vec3, kr: Vec3, blur: Option<&SquareBlur>, u: Vec2) -> Option<BsdfSample> {
    let Some(blur) = blur else {
        let wi = Vec3::new(-wo.x, -wo.y, wo.z);
        return Some(BsdfSample { wi, weight: kr, pdf: 1.0, lobe: Lobe::DeltaReflection, eta: 1.0 });
    };
    let wi = blur.sample(u).filter(|wi| wi.z >= GRAZING)?;
    Some(BsdfSample { wi, weight: kr, pdf: blur.pdf(wi), lobe: Lobe::Mirror, eta: 1.0 })
}
