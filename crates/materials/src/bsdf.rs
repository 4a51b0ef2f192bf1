//! The BSDF at one point for one outgoing direction: a sum of lobes with consistent value, density and sampling.
//!
//! A BSDF is built once per path vertex from plain numbers; lobes without weight are omitted (a plain Lambertian
//! surface has one lobe and no table lookup). Either side of a surface may be hit: all directions are flipped so that
//! `wo` is above it, and only the index of refraction depends on the side. Opaque materials therefore look alike from
//! both sides.

use crate::lanes::{self, Kind, Lambert, Layers, Mirrored, Parameters};
use crate::sample::BsdfSample;
use crate::{Lobe, Lobes, Material};
use dapple_math::lanes::{Vec2x, Vec3x};
use glam::{Vec2, Vec3};

/// A BSDF for one `wo`. Directions are unit vectors that point away, in the local frame; wo.z may be negative (back
/// side).
#[derive(Clone, Copy, Debug)]
pub struct Bsdf(lanes::Bsdf<f32, Surface>);

/// A surface of any kind.
#[derive(Clone, Copy, Debug)]
enum Surface {
    Lambert(Lambert<f32>),
    Mirror(Mirrored<f32>),
    Layers(Layers<f32>),
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
        let (wo, side) = lanes::face::<f32>(wo.into());
        let face = (wo, side);
        if !lanes::is_seen(wo) {
            // Seen edge-on; no light is scattered.
            return Self::of(face, Lambert { rho: Vec3::ZERO.into() }, Surface::Lambert);
        }
        if let Some(mirror) = &material.mirror {
            return Self::of(face, Mirrored::new(mirror.kr.into(), mirror.blur, wo), Surface::Mirror);
        }
        let parameters = Parameters::from(material);
        if parameters.is_lambert() {
            return Self::of(face, Lambert::new(&parameters), Surface::Lambert);
        }
        Self::of(face, Layers::new(&parameters, wo, side, mu), Surface::Layers)
    }

    #[inline(always)]
    fn of<K: Kind<f32>>(face: (Vec3x<f32>, f32), kind: K, surface: fn(K) -> Surface) -> Self {
        Self(lanes::Bsdf::new(face, kind).of(surface(kind)))
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
        let (wi, lobes) = (wi.into(), lobes.splat());
        let (f, pdf) = match self.0.kind() {
            Surface::Lambert(lambert) => self.0.of(lambert).eval(wi, lobes),
            Surface::Mirror(mirror) => self.0.of(mirror).eval(wi, lobes),
            Surface::Layers(layers) => eval_layers(&self.0, layers, wi, lobes),
        };
        (f.into(), pdf)
    }

    /// Samples a direction from the given lobes; `None` if they carry no light or if no light can travel in the sampled
    /// direction (the sample then counts as zero). `uc` selects the lobe, `u` the direction.
    pub fn sample_f(&self, uc: f32, u: Vec2, lobes: Lobes) -> Option<BsdfSample> {
        let (u, lobes) = (u.into(), lobes.splat());
        match self.0.kind() {
            Surface::Lambert(lambert) => BsdfSample::new(self.0.of(lambert).sample_f(uc, u, lobes)),
            Surface::Mirror(mirror) => BsdfSample::new(self.0.of(mirror).sample_f(uc, u, lobes)),
            Surface::Layers(layers) => sample_layers(&self.0, layers, uc, u, lobes),
        }
    }

    /// Whether light that leaves towards `wi` continues in exactly the direction in which it arrived, to the last bit.
    pub fn passes(&self, wi: Vec3) -> bool {
        self.0.passes(wi.into())
    }

    /// Unrefracted transmission of a smooth surface towards `wo`, from the opposite direction: at a thin wall and where
    /// the indices of both sides are equal. Zero elsewhere.
    pub fn straight(&self) -> Vec3 {
        match self.0.kind() {
            Surface::Layers(layers) => layers.straight(self.0.face().0).into(),
            _ => Vec3::ZERO,
        }
    }

    /// As [`Self::straight`], also where light is refracted: the fraction that is not reflected, as if it kept its
    /// direction. *Approximation*: the angle is taken on the side of the lower index, so that there is no total
    /// internal reflection.
    pub fn straightened(&self) -> Vec3 {
        match self.0.kind() {
            Surface::Layers(layers) => layers.straightened(self.0.face().0.z).into(),
            _ => Vec3::ZERO,
        }
    }

    /// Lobes with non-zero weight.
    pub fn lobes(&self) -> Lobes {
        Lobes(self.0.lobes() as u8)
    }

    /// Whether all lobes are delta lobes, for which next-event estimation is of no use.
    pub fn is_delta(&self) -> bool {
        self.lobes().without(Lobes::DELTA).is_empty()
    }

    /// Estimate of the directional albedo, for lobe selection and AOVs; transmission without its radiance scaling.
    pub fn albedo(&self) -> Vec3 {
        match self.0.kind() {
            Surface::Lambert(lambert) => lambert.rho.into(),
            Surface::Mirror(mirror) => mirror.kr.into(),
            Surface::Layers(layers) => layers.albedo(self.0.face().0.z).into(),
        }
    }

    /// Directional albedo of the diffuse lobe alone.
    pub fn diffuse_albedo(&self) -> Vec3 {
        match self.0.kind() {
            Surface::Lambert(lambert) => lambert.rho.into(),
            Surface::Layers(layers) => layers.diffuse_albedo().into(),
            Surface::Mirror(_) => Vec3::ZERO,
        }
    }

    /// The BSDF with the given rough lobes replaced by their ideal limit: reflection and refraction at a smooth surface
    /// with F at the macroscopic angle, a mirror without blur. A ray tracer without the integral over these lobes shows
    /// this limit.
    pub fn sharp(self, lobes: Lobes) -> Self {
        let face = self.0.face();
        match *self.0.kind() {
            Surface::Mirror(mirror) if lobes.contains(Lobe::Mirror) => {
                Self::of(face, mirror.sharp(), Surface::Mirror)
            }
            Surface::Layers(layers) => Self::of(face, layers.sharp(face.0.z, lobes), Surface::Layers),
            _ => self,
        }
    }
}

type Any = lanes::Bsdf<f32, Surface>;

/// In a function of its own, so that simple surfaces do not pay for its registers.
#[inline(never)]
fn eval_layers(bsdf: &Any, layers: &Layers<f32>, wi: Vec3x<f32>, lobes: u32) -> (Vec3x<f32>, f32) {
    bsdf.of(layers).eval(wi, lobes)
}

/// As [`eval_layers`].
#[inline(never)]
fn sample_layers(bsdf: &Any, layers: &Layers<f32>, uc: f32, u: Vec2x<f32>, lobes: u32) -> Option<BsdfSample> {
    BsdfSample::new(bsdf.of(layers).sample_f(uc, u, lobes))
}
