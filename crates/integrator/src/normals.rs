//! Shading normals that lean away from the surface, and lose no light by it.
//!
//! A normal map or interpolated vertex normals turn the hemisphere of the BSDF against that of the surface: part of what
//! is reflected about the shading normal points into the surface, part of what is transmitted points out of it. Here the
//! BSDF is seen and left through two maps, both the identity wherever nothing is wrong.
//!
//! **Leaving**: [`Tilt::fold`] turns directions about the axis that both horizons share (the shading normal's, and that of
//! the surface), by an angle that depends only on their elevation ε about that axis, measured from the surface's horizon
//! on the side to which the normal leans. With the tilt θ and δ = ε + θ, the elevation over the horizon of the
//! shading normal,
//!
//! ψ = δ/3 + δ²/(9θ) for δ < 3θ, else ψ = ε
//!
//! maps the shading normal's hemisphere into the surface's, continuously and with a continuous derivative. A turn about
//! a fixed axis by a function of the angle changes solid angles by dψ/dδ alone, so density and value are those of the BSDF
//! times dδ/dψ, exactly: the directional albedo is that of the BSDF, whatever the lobe, and delta lobes stay delta
//! lobes. As cosine lobes vanish at their own horizon, what a matte surface sends along the surface goes to zero
//! continuously: no hard terminator. Transmission is folded by the same map on the other side, w → −fold(−w).
//! For θ > 60° the range of 3θ would exceed the hemisphere, and is π.
//!
//! **Being seen**: [`facing`] turns a normal that leans away from the viewer back towards `wo`, so far that the cosine
//! stays above a bound that falls with the viewer's elevation over the surface; normals well in view stay as they are.
//!
//! Nothing here is random: light samples, BSDF samples and their densities see one and the same function. It is not
//! reciprocal, as no BSDF about a leaning normal is that stays one [Veach 1997, §5.3]; `docs/stability.md` has figures. The
//! microfacet model of [Schüßler et al. 2017] is, but light that meets its facets twice is reflected twice: a
//! metal darkens with the map, and its analytic form loses what meets them more often.

use crate::kernel::Job;
use crate::terminator;
use dapple_geometry::{Frame, Hit, Surface, offset::gamma};
use dapple_scene::Shading;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// The least cosine between normal and viewer is this share of the viewer's own over the surface, when that is small…
const LEAST_SHARE: f32 = 0.75;
/// …and saturates about this cosine.
const SATURATION: f32 = 0.25;

/// A shading normal that leans, as seen from one `wo`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tilt {
    /// Unit, on the side of `wo`: normal of the plane that reflected light leaves above and transmitted light below.
    pub horizon: Vec3,
    /// Unit and in that plane: to where the shading normal leans.
    lean: Vec3,
    /// Between horizon and shading normal, 0..π/2.
    angle: f32,
    /// Components along `lean` and `horizon` of a normal of the plane in which the folded range ends.
    end: Vec2,
    /// The horizon is that of the smooth surface a facet stands for, and reflected light may pass over the facet.
    pub is_over: bool,
}

/// Whether a unit normal differs from the geometric one by more than normals in f32, interpolated, are rounded by.
#[inline]
pub(crate) fn leans(n: Vec3, ng: Vec3) -> bool {
    n != ng && (n - ng).abs().max_element() > gamma(8)
}

impl Tilt {
    /// Of the shading normal at a hit seen from `wo`, and the frame about that normal, turned to the viewer. None edge-on,
    /// where no light goes.
    #[inline(never)]
    pub fn new(
        job: &Job<'_>,
        shading: &Shading,
        (hit, surface): (&Hit, &Surface),
        wo: Vec3,
        time: f32,
    ) -> (Frame, Option<Self>) {
        let height = surface.ng.dot(wo);
        if height == 0.0 || height.is_nan() {
            return (shading.frame, None);
        }
        let (side, up) = (height.signum(), surface.ng * height.signum());
        let given = shading.frame.z * side;
        let n = facing(given, wo, up);
        let frame =
            if n == given { shading.frame } else { Frame::from_z_tangent(n * side, shading.frame.x, 1.0) };
        let round = surface.ns * side;
        let is_over = job.settings.soft_terminator
            && shading.material.transmission == 0.0
            && surface.is_smooth()
            && n.dot(round) > 0.0
            && terminator::lift(&job.scene.world, (hit, surface), up, time).is_some();
        (frame, Some(Self::between(n, if is_over { round } else { up }, is_over)))
    }

    /// Of the normal `n` against `horizon`, both unit, less than a right angle apart.
    fn between(n: Vec3, horizon: Vec3, is_over: bool) -> Self {
        let (cos, across) = (n.dot(horizon), n.cross(horizon).length());
        let lean = (n - horizon * cos).try_normalize();
        let (Some(lean), true) = (lean, across > gamma(8)) else {
            return Self { horizon, lean: Vec3::ZERO, angle: 0.0, end: Vec2::ZERO, is_over };
        };
        // Orthogonalised twice: the first subtraction cancels.
        let lean = (lean - horizon * lean.dot(horizon)).normalize();
        let angle = libm::atan2f(across, cos);
        let (sin, cos) = libm::sincosf(range(angle) - angle);
        Self { horizon, lean, angle, end: Vec2::new(sin, -cos), is_over }
    }

    /// Where light goes that the BSDF sends towards `w`, on the side of `wo` or not, and its density over that of `w`.
    /// None where rounding leaves it in the surface.
    pub fn leave(&self, w: Vec3, reflects: bool) -> Option<(Vec3, f32)> {
        let side = if reflects { 1.0 } else { -1.0 };
        let (out, density) = self.fold(w * side);
        (out.dot(self.horizon) > 0.0).then_some((out * side, density))
    }

    /// The direction that leaves towards `wi`, the density of `wi` over its own, and whether it is reflection.
    pub fn before(&self, wi: Vec3) -> (Vec3, f32, bool) {
        let reflects = wi.dot(self.horizon) > 0.0;
        let side = if reflects { 1.0 } else { -1.0 };
        let (w, density) = self.unfold(wi * side);
        (w * side, density, reflects)
    }

    /// From the shading normal's hemisphere into the surface's, and dδ/dψ.
    fn fold(&self, w: Vec3) -> (Vec3, f32) {
        let at = self.in_plane(w);
        if at.dot(self.end) <= 0.0 {
            return (w, 1.0);
        }
        let elevation = libm::atan2f(at.y, at.x);
        let (a, b) = self.coefficients();
        let delta = (elevation + self.angle).max(0.0);
        (self.turned(w, at, delta * (a + b * delta) - elevation), 1.0 / (a + 2.0 * b * delta))
    }

    /// The inverse of [`Self::fold`], and the same dδ/dψ.
    fn unfold(&self, w: Vec3) -> (Vec3, f32) {
        let at = self.in_plane(w);
        if at.dot(self.end) <= 0.0 {
            return (w, 1.0);
        }
        let psi = libm::atan2f(at.y, at.x);
        let (a, b) = self.coefficients();
        let root = (a * a + 4.0 * b * psi).sqrt();
        (self.turned(w, at, 2.0 * psi / (a + root) - self.angle - psi), 1.0 / root)
    }

    /// ψ = aδ + bδ² ends at δ = range with value range − θ and slope 1.
    fn coefficients(&self) -> (f32, f32) {
        let range = range(self.angle);
        (1.0 - 2.0 * self.angle / range, self.angle / (range * range))
    }

    fn in_plane(&self, w: Vec3) -> Vec2 {
        Vec2::new(w.dot(self.lean), w.dot(self.horizon))
    }

    /// `w`, with components `at`, turned by an angle about the axis of the tilt.
    fn turned(&self, w: Vec3, at: Vec2, angle: f32) -> Vec3 {
        let (sin, cos) = libm::sincosf(angle);
        let to = Vec2::new(at.x * cos - at.y * sin, at.x * sin + at.y * cos);
        (w + self.lean * (to.x - at.x) + self.horizon * (to.y - at.y)).normalize()
    }
}

/// Elevations over the shading normal's horizon, at the axis, that are folded at a tilt of `angle`.
fn range(angle: f32) -> f32 {
    (3.0 * angle).min(PI)
}

/// The normal `n`, turned towards `wo` where it leans away from it: the cosine p = n·wo becomes
///
/// p + (q − p)²/(4(q − p₀)) below the knee q, and p₀ where that has its minimum,
///
/// with p₀ = 0.75 h/√(1 + 16h²) of the viewer's height h = up·wo, and q = min(2p₀, h). All unit, `up` on the side of `wo`,
/// `n` on that of `up`. *Approximation*: keeps pixels from going black, and grazing lobes from losing
/// their light.
fn facing(n: Vec3, wo: Vec3, up: Vec3) -> Vec3 {
    let (p, height) = (n.dot(wo), up.dot(wo));
    let least = LEAST_SHARE * height / (1.0 + (height / SATURATION) * (height / SATURATION)).sqrt();
    let knee = (2.0 * least).min(height);
    if p >= knee {
        return n;
    }
    let (missing, room) = (knee - p, knee - least);
    let cos = if missing >= 2.0 * room { least } else { p + missing * missing / (4.0 * room) };
    match (n - wo * p).try_normalize() {
        Some(across) => (across * ((1.0 - cos) * (1.0 + cos)).sqrt() + wo * cos).normalize(),
        None => up,
    }
}
