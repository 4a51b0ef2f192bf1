//! The sum of lobes at one point seen from one direction, with value, density and sampling that agree.
//!
//! Built once per path vertex from plain numbers; lobes without weight do not exist (a bare Lambert surface has one
//! lobe and no table look-up). Either side of a surface may be hit: everything is turned so that `wo` is above it, and
//! only the index of refraction knows which side that was. Opaque matter therefore looks alike from both sides.
//!
//! With several lobes, one is chosen by its share of the light, and the weight is the sum of all lobes' f·cos over the
//! mixture density: the balance heuristic over lobes (see `choice`).

use crate::layers::Layers;
use crate::mirror::{SHARP_BLUR, SquareBlur, WIDEST_BLUR};
use crate::sample::{BsdfSample, GRAZING};
use crate::{Lobe, Lobes, Material, Mirror};
use dapple_sampling::warp;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

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
    /// A bare diffuse base of this reflectance: most of most scenes, so it carries nothing else about.
    Lambert(Vec3),
    Mirror {
        kr: Vec3,
        blur: Option<SquareBlur>,
    },
    Layers(Layers),
}

impl Bsdf {
    /// `wo` local; `wo.z < 0` means the ray arrives at the back side. Parameters outside their ranges are clamped, and
    /// not-a-number counts as 0.
    pub fn new(material: &Material, wo: Vec3) -> Self {
        Self::losing_as(material, wo, None)
    }

    /// As [`Self::new`], about a shading normal that leans: what single scattering loses between the facets of a rough
    /// surface is what it loses at cosine `mu`, that of `wo` to the normal without the lean, so that a normal map neither
    /// takes light nor gives any. Fresnel's terms are those at the shading normal.
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
            Body::Lambert(rho) if wi.z > 0.0 => (*rho * FRAC_1_PI, warp::hemisphere_cosine_pdf(wi.z)),
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
            Body::Lambert(rho) => sample_lambert(*rho, u),
            Body::Mirror { kr, blur } => sample_mirror(self.wo, *kr, blur.as_ref(), u),
            Body::Layers(layers) => layers.sample(self.wo, uc, u, asked),
        }?;
        sample.wi = self.turn(sample.wi);
        Some(sample)
    }

    /// Whether light that leaves towards `wi` goes on as it came, to the last bit.
    pub fn passes(&self, wi: Vec3) -> bool {
        self.turn(wi) == -self.wo
    }

    /// What of the light from straight behind a smooth surface passes it towards `wo` without being bent: at a thin wall and
    /// where the indices of both sides are equal. Zero elsewhere.
    pub fn straight(&self) -> Vec3 {
        match &self.body {
            Body::Layers(layers) => layers.straight(self.wo),
            _ => Vec3::ZERO,
        }
    }

    /// As [`Self::straight`], where light is bent: what of it is not reflected, as if it went straight on. *Approximation*:
    /// the angle counts on the side of the lower index, so that there is no total internal reflection.
    pub fn straightened(&self) -> Vec3 {
        match &self.body {
            Body::Layers(layers) => layers.straightened(self.wo.z),
            _ => Vec3::ZERO,
        }
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

    /// The ideal limit of the rough lobes asked for: reflection and refraction at a smooth surface with F at the
    /// macroscopic angle, a mirror without blur. What a ray tracer without that integral shows.
    pub fn sharp(mut self, lobes: Lobes) -> Self {
        match &mut self.body {
            Body::Mirror { blur, .. } if lobes.contains(Lobe::Mirror) => *blur = None,
            Body::Layers(layers) => layers.sharpen(self.wo.z, lobes),
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
