//! Shading normals that deviate from the geometric normal, without loss of energy.
//!
//! A normal map or interpolated vertex normals rotate the hemisphere of the BSDF relative to that of the surface: some
//! directions of reflection about the shading normal point into the surface, some directions of transmission point out
//! of it. This module maps the outgoing and the incoming directions of the BSDF so that this does not happen; both maps
//! are the identity where the directions are consistent.
//!
//! **Outgoing directions**: [`Tilt::fold`] rotates directions about the axis that both horizons share (that of the
//! shading normal, and that of the surface), by an angle that depends only on their elevation ε about that axis,
//! measured from the surface's horizon on the side to which the normal leans. With the tilt θ and δ = ε + θ, the
//! elevation over the horizon of the shading normal,
//!
//! ψ = δ/3 + δ²/(9θ) for δ < 3θ, else ψ = ε
//!
//! maps the shading normal's hemisphere into the surface's, continuously and with a continuous derivative. A rotation
//! about a fixed axis by a function of the angle changes solid angles by dψ/dδ alone, so density and value are those of
//! the BSDF times dδ/dψ, exactly: the directional albedo is that of the BSDF, for every lobe, and delta lobes remain
//! delta lobes. As cosine lobes vanish at their own horizon, the light that a diffuse surface reflects along the
//! surface goes to zero continuously: there is no hard terminator. Transmission is folded by the same map on the other
//! side, w → −fold(−w). For θ > 60° the range of 3θ would exceed the hemisphere, and is π.
//!
//! **View direction**: [`facing`] rotates a normal that leans away from the viewer back towards `wo`, so that the
//! cosine stays above a bound that decreases with the viewer's elevation over the surface; normals well in view stay
//! unchanged.
//!
//! **Energy loss**: single scattering between the facets of a rough surface loses light, by an amount that depends on
//! the angle. About a mapped normal the loss is that of the surface without the map
//! ([`dapple_materials::Bsdf::losing_as`]).
//!
//! These maps are deterministic: light samples, BSDF samples and their densities use the same function. It is not
//! reciprocal, like every BSDF about a tilted normal that conserves energy [Veach 1997, §5.3]; `docs/stability.md` has
//! figures. The microfacet model of [Schüßler et al. 2017] is reciprocal, but light that hits its facets twice is
//! reflected twice: metals darken with the map, and its analytic form loses the light of further reflections.

use crate::job::Job;
use crate::terminator;
use dapple_geometry::{Hit, Surface};
use dapple_math::lanes::{Framex, Mask, Real, Vec2x, Vec3x, atan2, sin_cos};
use dapple_math::{Frame, offset::gamma};
use dapple_scene::Shading;
use glam::Vec3;
use std::f32::consts::PI;

/// Lower bound of the cosine between normal and viewer, as a share of the viewer's cosine over the surface where that
/// is small.
const LEAST_SHARE: f32 = 0.75;
/// Viewer cosine at which this bound saturates.
const SATURATION: f32 = 0.25;

/// Tilted shading normals, one per lane, each for one `wo`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tilt<R: Real> {
    /// Unit normal, on the side of `wo`, of the plane that separates reflected light (above) from transmitted light
    /// (below).
    pub horizon: Vec3x<R>,
    /// Unit vector in that plane, towards which the shading normal leans.
    pub lean: Vec3x<R>,
    /// Angle between horizon and shading normal, 0..π/2.
    pub angle: R,
    /// Components along `lean` and `horizon` of a normal of the plane in which the folded range ends.
    pub end: Vec2x<R>,
    /// The horizon is that of the smooth surface that a facet approximates, and reflected light may pass over the
    /// facet.
    pub is_over: R::Mask,
    /// Where there is a normal map.
    pub is_mapped: R::Mask,
    /// Cosine of the view angle without the normal map; of no meaning where there is none.
    pub unmapped: R,
}

/// Whether a unit normal differs from the geometric one by more than the rounding of interpolated f32 normals.
#[inline(always)]
pub(crate) fn leans<R: Real>(n: Vec3x<R>, ng: Vec3x<R>) -> R::Mask {
    (n - ng).abs().max_element().gt(R::splat(gamma(8)))
}

impl Tilt<f32> {
    /// The tilt of the shading normal at a hit seen from `wo`, and the frame about that normal, facing the viewer.
    /// `None` for edge-on views, where no light is scattered.
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
        let normals = (surface.ng.into(), surface.ns.into());
        let turned = Turned::<f32>::new(&shading.frame.into(), normals, wo.into(), true);
        let is_over = turned.may_pass_over(job, normals, shading.material.has_transmission())
            && terminator::lift(&job.scene.accel, (hit, surface), turned.up.into(), time).is_some();
        (turned.frame.into(), Some(turned.tilt(wo.into(), is_over)))
    }
}

/// Leaning shading normals, turned towards the viewer where they lean away, per lane.
#[derive(Clone, Copy)]
pub(crate) struct Turned<R: Real> {
    /// Frame about the shading normal.
    pub frame: Framex<R>,
    /// Geometric normal on the side of the viewer.
    pub up: Vec3x<R>,
    /// Shading normal on the side of the viewer.
    n: Vec3x<R>,
    /// Interpolated normal on the side of the viewer, before it is turned and after.
    round: Vec3x<R>,
    flat: Vec3x<R>,
}

impl<R: Real> Turned<R> {
    /// Turns the frames `given` of surfaces with the normals `ng` and `ns`, seen from `wo`. `is_mapped`: the frames may
    /// be about other normals than `ns`.
    #[inline(always)]
    pub fn new(given: &Framex<R>, (ng, ns): (Vec3x<R>, Vec3x<R>), wo: Vec3x<R>, is_mapped: bool) -> Self {
        let (one, side) = (R::splat(1.0), R::splat(1.0).copysign(ng.dot(wo)));
        let (up, round, leaning) = (ng * side, ns * side, given.z * side);
        let n = facing(leaning, wo, up);
        let moved = differs(n, leaning);
        let frame = match moved.any() {
            true => Framex::select(moved, Framex::from_z_tangent(n * side, given.x, one), *given),
            false => *given,
        };
        let flat = if is_mapped { facing(round, wo, up) } else { n };
        Self { frame, up, n, round, flat }
    }

    /// Whether reflected light may pass over the facet, if the normals of its corners span a surface above it.
    #[inline(always)]
    pub fn may_pass_over(
        &self,
        job: &Job<'_>,
        (ng, ns): (Vec3x<R>, Vec3x<R>),
        transmits: R::Mask,
    ) -> R::Mask {
        let is_above = self.n.dot(self.round).gt(R::splat(0.0));
        R::Mask::splat(job.settings.soft_terminator) & !transmits & leans(ns, ng) & is_above
    }

    /// The tilts; in the lanes of `is_over`, reflected light may pass over the facet.
    #[inline(always)]
    pub fn tilt(&self, wo: Vec3x<R>, is_over: R::Mask) -> Tilt<R> {
        let tilt = Tilt::between(self.n, Vec3x::select(is_over, self.round, self.up));
        Tilt { is_over, is_mapped: differs(self.flat, self.n), unmapped: self.flat.dot(wo), ..tilt }
    }
}

#[inline(always)]
fn differs<R: Real>(a: Vec3x<R>, b: Vec3x<R>) -> R::Mask {
    a.x.ne(b.x) | a.y.ne(b.y) | a.z.ne(b.z)
}

impl<R: Real> Tilt<R> {
    /// The tilt of the normals `n` against `horizon`, both unit vectors less than a right angle apart, of surfaces
    /// without a map, over whose facets no light passes.
    #[inline(always)]
    pub fn between(n: Vec3x<R>, horizon: Vec3x<R>) -> Self {
        let (cos, across) = (n.dot(horizon), n.cross(horizon).length());
        let lean = n - horizon * cos;
        let length = lean.length();
        let leans = is_unit_of(length) & across.gt(R::splat(gamma(8)));
        let lean = lean / length;
        // Orthogonalised twice, because the first subtraction cancels.
        let lean = (lean - horizon * lean.dot(horizon)).normalize();
        let angle = atan2(across, cos);
        let (sin, cos) = sin_cos(range(angle) - angle);
        let (zero, no) = (R::splat(0.0), R::Mask::splat(false));
        Self {
            horizon,
            lean: Vec3x::select(leans, lean, Vec3x::splat(Vec3::ZERO)),
            angle: R::select(leans, angle, zero),
            end: Vec2x::new(R::select(leans, sin, zero), R::select(leans, -cos, zero)),
            is_over: no,
            is_mapped: no,
            unmapped: zero,
        }
    }

    /// The direction in which light leaves that the BSDF scatters to `w`, on the side of `wo` or not, its density over
    /// that of `w`, and whether it exists: rounding can put the direction in the surface.
    #[inline(always)]
    pub fn leave(&self, w: Vec3x<R>, reflects: R::Mask) -> (Vec3x<R>, R, R::Mask) {
        let side = R::select(reflects, R::splat(1.0), R::splat(-1.0));
        let (out, density) = self.fold(w * side);
        (out * side, density, out.dot(self.horizon).gt(R::splat(0.0)))
    }

    /// The BSDF direction that leaves towards `wi`, the density of `wi` over its own, and whether it is a reflection.
    #[inline(always)]
    pub fn before(&self, wi: Vec3x<R>) -> (Vec3x<R>, R, R::Mask) {
        let reflects = wi.dot(self.horizon).gt(R::splat(0.0));
        let side = R::select(reflects, R::splat(1.0), R::splat(-1.0));
        let (w, density) = self.unfold(wi * side);
        (w * side, density, reflects)
    }

    /// Maps the shading normal's hemisphere into the surface's; also returns dδ/dψ.
    #[inline(always)]
    fn fold(&self, w: Vec3x<R>) -> (Vec3x<R>, R) {
        let (at, zero, one) = (self.in_plane(w), R::splat(0.0), R::splat(1.0));
        let stays = at.dot(self.end).le(zero);
        if stays.all() {
            return (w, one);
        }
        let elevation = atan2(at.y, at.x);
        let (a, b) = self.coefficients();
        let delta = (elevation + self.angle).max(zero);
        let turned = self.turned(w, at, delta * (a + b * delta) - elevation);
        (Vec3x::select(stays, w, turned), R::select(stays, one, one / (a + R::splat(2.0) * b * delta)))
    }

    /// The inverse of [`Self::fold`], with the same dδ/dψ.
    #[inline(always)]
    fn unfold(&self, w: Vec3x<R>) -> (Vec3x<R>, R) {
        let (at, one) = (self.in_plane(w), R::splat(1.0));
        let stays = at.dot(self.end).le(R::splat(0.0));
        if stays.all() {
            return (w, one);
        }
        let psi = atan2(at.y, at.x);
        let (a, b) = self.coefficients();
        let root = (a * a + R::splat(4.0) * b * psi).sqrt();
        let turned = self.turned(w, at, R::splat(2.0) * psi / (a + root) - self.angle - psi);
        (Vec3x::select(stays, w, turned), R::select(stays, one, one / root))
    }

    /// ψ = aδ + bδ² ends at δ = range with value range − θ and slope 1.
    #[inline(always)]
    fn coefficients(&self) -> (R, R) {
        let range = range(self.angle);
        (R::splat(1.0) - R::splat(2.0) * self.angle / range, self.angle / (range * range))
    }

    #[inline(always)]
    fn in_plane(&self, w: Vec3x<R>) -> Vec2x<R> {
        Vec2x::new(w.dot(self.lean), w.dot(self.horizon))
    }

    /// `w`, with components `at`, rotated by an angle about the axis of the tilt.
    #[inline(always)]
    fn turned(&self, w: Vec3x<R>, at: Vec2x<R>, angle: R) -> Vec3x<R> {
        let (sin, cos) = sin_cos(angle);
        let to = Vec2x::new(at.x * cos - at.y * sin, at.x * sin + at.y * cos);
        (w + self.lean * (to.x - at.x) + self.horizon * (to.y - at.y)).normalize()
    }
}

/// Whether a vector of this length can be divided by it.
#[inline(always)]
fn is_unit_of<R: Real>(length: R) -> R::Mask {
    let inverse = R::splat(1.0) / length;
    inverse.is_finite() & inverse.gt(R::splat(0.0))
}

/// Range of elevations over the shading normal's horizon, about the axis, that are folded for a tilt of `angle`.
#[inline(always)]
fn range<R: Real>(angle: R) -> R {
    (R::splat(3.0) * angle).min(R::splat(PI))
}

/// The normal `n`, rotated towards `wo` where it leans away from it: the cosine p = n·wo becomes
///
/// p + (q − p)²/(4(q − p₀)) below the knee q, and p₀ beyond the minimum of that function,
///
/// with p₀ = 0.75 h/√(1 + 16h²) of the viewer's height h = up·wo, and q = min(2p₀, h). All are unit vectors, `up` on
/// the side of `wo`, `n` on that of `up`. *Approximation*: avoids black pixels, and the loss of light in grazing lobes.
#[inline(always)]
pub(crate) fn facing<R: Real>(n: Vec3x<R>, wo: Vec3x<R>, up: Vec3x<R>) -> Vec3x<R> {
    let (one, two) = (R::splat(1.0), R::splat(2.0));
    let (p, height) = (n.dot(wo), up.dot(wo));
    let rise = height / R::splat(SATURATION);
    let least = R::splat(LEAST_SHARE) * height / (one + rise * rise).sqrt();
    let knee = (two * least).min(height);
    let is_seen = p.ge(knee);
    if is_seen.all() {
        return n;
    }
    let (missing, room) = (knee - p, knee - least);
    let cos = R::select(missing.ge(two * room), least, p + missing * missing / (R::splat(4.0) * room));
    let across = n - wo * p;
    let length = across.length();
    let turned = (across / length * ((one - cos) * (one + cos)).sqrt() + wo * cos).normalize();
    Vec3x::select(is_seen, n, Vec3x::select(is_unit_of(length), turned, up))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_materials::{Bsdf, Lobes, Material};
    use dapple_testkit::chi_square::ChiSquare;
    use dapple_testkit::rng::Rng;
    use glam::{DVec3, Vec2};

    const UP: Vec3 = Vec3::Z;

    fn between(n: Vec3, horizon: Vec3) -> Tilt<f32> {
        Tilt::between(n.into(), horizon.into())
    }

    fn facing(n: Vec3, wo: Vec3, up: Vec3) -> Vec3 {
        super::facing::<f32>(n.into(), wo.into(), up.into()).into()
    }

    fn fold(tilt: &Tilt<f32>, w: Vec3) -> (Vec3, f32) {
        let (out, density) = tilt.fold(w.into());
        (out.into(), density)
    }

    fn unfold(tilt: &Tilt<f32>, w: Vec3) -> (Vec3, f32) {
        let (out, density) = tilt.unfold(w.into());
        (out.into(), density)
    }

    fn leave(tilt: &Tilt<f32>, w: Vec3, reflects: bool) -> Option<(Vec3, f32)> {
        let (out, density, exists) = tilt.leave(w.into(), reflects);
        exists.then_some((out.into(), density))
    }

    fn direction(elevation: f32, azimuth: f32) -> Vec3 {
        let (s, c) = libm::sincosf(elevation.to_radians());
        let (y, x) = libm::sincosf(azimuth.to_radians());
        Vec3::new(c * x, c * y, s)
    }

    fn tilted(angle: f32) -> (Vec3, Tilt<f32>) {
        let n = direction(90.0 - angle, 35.0);
        (n, between(n, UP))
    }

    fn on_sphere(rng: &mut Rng) -> Vec3 {
        let (z, phi) = (2.0 * rng.f32() - 1.0, std::f32::consts::TAU * rng.f32());
        let r = ((1.0 - z) * (1.0 + z)).sqrt();
        Vec3::new(r * libm::cosf(phi), r * libm::sinf(phi), z)
    }

    #[test]
    fn a_hemisphere_is_folded_into_the_other_and_back() {
        let mut rng = Rng::new(1);
        for angle in [1e-4, 0.5, 5.0, 20.0, 45.0, 60.0, 75.0, 89.0] {
            let (n, tilt) = tilted(angle);
            for _ in 0..20_000 {
                let w = on_sphere(&mut rng);
                let w = if w.dot(n) < 0.0 { -w } else { w };
                let (out, density) = fold(&tilt, w);
                assert!(out.z > -1e-6, "{angle}: {w} goes to {out}");
                assert!((out.length() - 1.0).abs() < 1e-6);
                // Close to the horizon of steep tilts ψ decreases as δ², and its inverse magnifies rounding.
                let (back, same) = unfold(&tilt, out);
                let slack = 2e-6 * density;
                assert!((back - w).length() < slack, "{angle}: {w}, {out}, {back}");
                assert!((same / density - 1.0).abs() < 10.0 * slack, "{angle}: {w} {density} {same}");
                if w.z > (2.0 * angle.to_radians()).sin() {
                    assert!(out == w || angle > 45.0, "well above the surface nothing moves");
                }
                let (leaving, reflects) = (leave(&tilt, -w, false), tilt.before((-out).into()).2);
                assert!(leaving.is_none_or(|(w, _)| w == -out && !reflects), "transmission alike");
            }
        }
    }

    #[test]
    fn the_density_is_that_of_the_area_of_the_image() {
        let mut rng = Rng::new(2);
        for angle in [2.0, 20.0, 50.0, 80.0] {
            let (n, tilt) = tilted(angle);
            for _ in 0..2000 {
                let w = on_sphere(&mut rng);
                if w.dot(n) < 0.05 {
                    continue;
                }
                let (a, b) = w.any_orthonormal_pair();
                let h = 2e-3;
                let at = |d: Vec3| fold(&tilt, (w + d).normalize()).0.as_dvec3();
                let (da, db) = (at(a * h) - at(a * -h), at(b * h) - at(b * -h));
                let area = da.cross(db).length() / f64::from(4.0 * h * h);
                let density = f64::from(fold(&tilt, w).1);
                assert!((area * density - 1.0).abs() < 0.02, "{angle}: {w} {area} {density}");
            }
        }
    }

    #[test]
    fn a_tilt_of_rounding_moves_nothing() {
        let tilt = between(Vec3::new(1e-7, 0.0, 1.0), UP);
        for w in [Vec3::X, Vec3::new(0.8, 0.6, 0.0), Vec3::new(1.0, 0.0, -1e-8)] {
            assert_eq!((fold(&tilt, w), unfold(&tilt, w)), ((w, 1.0), (w, 1.0)));
        }
    }

    #[test]
    fn a_normal_keeps_facing_the_viewer_and_one_in_view_stays() {
        for view in [0.01, 1.0, 5.0, 10.0, 45.0, 90.0] {
            let wo = direction(view, 0.0);
            let height = wo.z;
            assert_eq!(facing(UP, wo, UP), UP, "no lean, no turn");
            let least = LEAST_SHARE * height / (1.0 + 16.0 * height * height).sqrt();
            let (mut last, mut kept) = (None::<f32>, false);
            for k in 0..900 {
                let n = direction(k as f32 * 0.1 + 0.05, 180.0);
                let turned = facing(n, wo, UP);
                let cos = turned.dot(wo);
                assert!(cos > 0.999 * least - 1e-7 && turned.dot(UP) > 0.0, "{view} {k}: {cos}");
                assert!(last.is_none_or(|last| (cos - last).abs() < 0.004), "continuous: {view} {k}");
                kept |= turned == n;
                last = Some(cos);
            }
            assert!(kept || view <= 10.0);
        }
    }

    /// Value times cosine and density towards `wi`, as in [`crate::vertex`].
    fn eval(tilt: &Tilt<f32>, frame: &Frame, bsdf: &Bsdf, wi: Vec3) -> (Vec3, f32) {
        let (w, density, reflects) = tilt.before(wi.into());
        let local = frame.to_local(w.into());
        if (local.z > 0.0) != reflects {
            return (Vec3::ZERO, 0.0);
        }
        let (f, pdf) = bsdf.eval(local, Lobes::ALL);
        (f * (local.z.abs() * density), pdf * density)
    }

    fn materials() -> [Material; 4] {
        let metal = |roughness| Material { roughness, ..Material::default() };
        let plastic = Material { metallic: 0.0, roughness: 0.4, ..Material::default() };
        let glass = Material { transmission: 1.0, thin: false, ..plastic };
        [metal(0.3), metal(0.7), plastic, glass]
    }

    #[test]
    fn samples_follow_the_density_and_carry_the_value() {
        let cases = [(20.0, 60.0, 0.0), (50.0, 80.0, 100.0), (60.0, 20.0, 200.0), (85.0, 45.0, 215.0)];
        for material in materials() {
            for (angle, view, azimuth) in cases {
                let wo = direction(90.0 - view, azimuth);
                let n = facing(tilted(angle).0, wo, UP);
                let (tilt, frame) = (between(n, UP), Frame::from_z(n));
                let bsdf = Bsdf::new(&material, frame.to_local(wo));
                let mut worst = 0.0f32;
                let sample = |u: Vec2, uc: f32| {
                    let sample = bsdf.sample_f(uc, u, Lobes::ALL)?;
                    let (wi, density) = leave(&tilt, frame.to_world(sample.wi), sample.wi.z > 0.0)?;
                    let (f_cos, pdf) = eval(&tilt, &frame, &bsdf, wi);
                    // Above the limit of total reflection the density is dominated by rounding.
                    if sample.pdf > 1e-3 {
                        worst = worst.max((pdf / (sample.pdf * density) - 1.0).abs().min(1.0));
                        worst = worst.max((f_cos / pdf - sample.weight).abs().max_element());
                    }
                    Some(wi)
                };
                let test = ChiSquare { samples: 60_000, ..ChiSquare::family(16) };
                let outcome = test.sphere(sample, |wi| eval(&tilt, &frame, &bsdf, wi).1);
                assert!(outcome.passed(), "{material:?} {angle} {view} {azimuth}: {outcome}");
                assert!(worst < 0.02, "{material:?} {angle} {view} {azimuth}: off by {worst}");
            }
        }
    }

    /// Difference of f(a, b) and f(b, a), as means over pairs of directions, for the figures in `docs/stability.md`.
    #[test]
    fn reciprocity_is_lost_as_about_any_leaning_normal() {
        let mut rng = Rng::new(3);
        for material in &materials()[..3] {
            for angle in [0.01, 5.0, 20.0, 40.0, 60.0] {
                let (given, _) = tilted(angle);
                let f = |wo: Vec3, wi: Vec3, folds: bool| {
                    let n = if folds { facing(given, wo, UP) } else { given };
                    let (tilt, frame) = (between(n, UP), Frame::from_z(n));
                    let bsdf = Bsdf::new(material, frame.to_local(wo));
                    let f_cos = if folds {
                        eval(&tilt, &frame, &bsdf, wi).0
                    } else {
                        bsdf.f(frame.to_local(wi), Lobes::ALL) * frame.to_local(wi).z.max(0.0)
                    };
                    f64::from(f_cos.x / wi.z)
                };
                let mut sums = [[0.0f64; 2]; 2];
                for _ in 0..20_000 {
                    let (a, b) = (on_sphere(&mut rng).abs(), on_sphere(&mut rng).abs());
                    let (a, b) = (turn(a, &mut rng), turn(b, &mut rng));
                    // Weighted by the projected solid angle of both.
                    let weight = f64::from(a.z * b.z);
                    for (folds, sum) in [false, true].into_iter().zip(&mut sums) {
                        let (x, y) = (f(a, b, folds), f(b, a, folds));
                        sum[0] += weight * (x - y).abs();
                        sum[1] += weight * (x + y) * 0.5;
                    }
                }
                let [without, with] = sums.map(|[difference, mean]| difference / mean);
                println!(
                    "metallic {} roughness {} tilt {angle}: {without:.3} without the fold, {with:.3} with it",
                    material.metallic, material.roughness
                );
                assert!(with < 1.8 * without + 0.02, "{angle}: {with}, {without}");
            }
        }
    }

    fn turn(w: Vec3, rng: &mut Rng) -> Vec3 {
        let (s, c) = DVec3::new(0.0, 0.0, f64::from(rng.f32()) * std::f64::consts::TAU).z.sin_cos();
        let (s, c) = (s as f32, c as f32);
        Vec3::new(w.x * c - w.y * s, w.x * s + w.y * c, w.z)
    }
}
