//! Triangles, sampled uniformly in solid angle [Arvo 1995] [Peters 2021].
//!
//! All values follow from the inverse distances of the corners, the cosines between them, and the height over the
//! plane. The sampled direction is a sum of the vectors to the corners with weights that are not negative: they are
//! barycentric coordinates after division by their sum, so that no plane has to be intersected.
use super::aimed::Aimed;
use super::flat::{Flat, How, LEAST, is_small};
use crate::polygon::Outline;
use dapple_math::lanes::{Mask, Real, Vec2x, Vec3x, atan2, sin_cos};

/// One triangle per lane: first corner and the edges from it to the two others.
#[derive(Clone, Copy, Debug)]
pub struct Triangle<R: Real>(pub Flat<R>);

/// A triangle as the receiver sees it.
struct Seen<R: Real> {
    /// Vector to the first corner.
    p0: Vec3x<R>,
    /// Height over the plane, positive in front.
    height: R,
    /// Inverse distances of the corners.
    per: [R; 3],
    /// Cosines of the angles between corners 0 and 1, 1 and 2, 2 and 0.
    cos: [R; 3],
    /// Triple product of the unit vectors to the corners.
    triple: R,
    /// Half of the solid angle; arbitrary where it is small.
    half: R,
    is_small: R::Mask,
    /// Where f32 is accurate.
    accurate: R::Mask,
}

const SOLID_ANGLE: How = How { outline: Outline::Triangle, by_area: false };
const AREA: How = How { outline: Outline::Triangle, by_area: true };

impl<R: Real> Triangle<R> {
    /// Samples points for receivers at `p` with `u` in \[0, 1)²: uniformly in solid angle if it is at least 10⁻³ sr,
    /// else uniformly in area. The density is 0 behind a one-sided triangle and in its plane.
    #[inline(always)]
    pub fn sample(&self, p: Vec3x<R>, u: Vec2x<R>) -> Aimed<R> {
        let seen = self.seen(p);
        let (by_area, mut at) = (seen.is_small, spread(u));
        if !by_area.all() {
            at = Vec2x::select(by_area, at, seen.place(u));
        }
        let fast = self.at(&seen, at.x, at.y, by_area);
        self.0.replaced(!seen.accurate, fast, p, u, SOLID_ANGLE).only_finite()
    }

    /// Solid-angle density of [`Triangle::sample`] at `p`, for a point at `distance`.
    #[inline(always)]
    pub fn pdf(&self, p: Vec3x<R>, distance: R) -> R {
        let seen = self.seen(p);
        let fast = self.density(&seen, distance, seen.is_small);
        self.0.replaced_pdf(!seen.accurate, fast, p, distance, SOLID_ANGLE).min(R::splat(f32::MAX))
    }

    /// Samples points uniformly in area.
    #[inline(always)]
    pub fn sample_surface(&self, p: Vec3x<R>, u: Vec2x<R>) -> Aimed<R> {
        let (seen, at) = (self.seen(p), spread(u));
        let fast = self.at(&seen, at.x, at.y, R::Mask::splat(true));
        self.0.replaced(!seen.accurate, fast, p, u, AREA).only_finite()
    }

    /// Solid-angle density of [`Triangle::sample_surface`] at `p`, for a point at `distance`.
    #[inline(always)]
    pub fn pdf_surface(&self, p: Vec3x<R>, distance: R) -> R {
        let seen = self.seen(p);
        let fast = self.density(&seen, distance, R::Mask::splat(true));
        self.0.replaced_pdf(!seen.accurate, fast, p, distance, AREA).min(R::splat(f32::MAX))
    }

    #[inline(always)]
    fn seen(&self, p: Vec3x<R>) -> Seen<R> {
        let (light, one) = (&self.0, R::splat(1.0));
        let p0 = light.corner - p;
        let (p1, p2) = (p0 + light.e1, p0 + light.e2);
        let height = -p0.dot(light.n);
        let lengths = [p0.length(), p1.length(), p2.length()];
        let per = [one / lengths[0], one / lengths[1], one / lengths[2]];
        let cos =
            [p0.dot(p1) * (per[0] * per[1]), p1.dot(p2) * (per[1] * per[2]), p2.dot(p0) * (per[2] * per[0])];
        let triple = (height.abs() * per[0]) * (light.area * per[1] * per[2]);
        // Half of the solid angle [Van Oosterom and Strackee 1983].
        let rest = one + cos[0] + cos[1] + cos[2];
        let is_small = is_small(triple, rest);
        let half = if is_small.all() { triple } else { atan2(triple, rest) };
        let largest = lengths[0].max(lengths[1]).max(lengths[2]);
        let accurate = Flat::accurate(height, largest) & (rest.abs() + triple).ge(R::splat(LEAST));
        Seen { p0, height, per, cos, triple, half, is_small, accurate }
    }

    #[inline(always)]
    fn density(&self, seen: &Seen<R>, distance: R, by_area: R::Mask) -> R {
        let half = R::splat(0.5);
        let even = Flat::area_pdf(distance, seen.height, self.0.area * half);
        let pdf = R::select(by_area, even, half / seen.half);
        R::select(self.0.faces(seen.height), pdf, R::splat(0.0))
    }

    #[inline(always)]
    fn at(&self, seen: &Seen<R>, s: R, t: R, by_area: R::Mask) -> Aimed<R> {
        let to = seen.p0 + (self.0.e1 * s + self.0.e2 * t);
        let distance = to.length();
        self.0.at(s, t, to, distance, self.density(seen, distance, by_area))
    }
}

impl<R: Real> Seen<R> {
    /// Coordinates along the edges, uniform in solid angle: u.x moves the far side of the part from corner 1 to
    /// corner 2, u.y along it. With σ = u.x·Ω/2, the far point of the part of solid angle 2σ is the mirror image of
    /// corner 1 about (G0·cosσ − G1·sinσ)·c1 + G2·sinσ·c2 [Peters 2021]; the weights of c1 and c2 are kept, not the
    /// vectors.
    #[inline(always)]
    fn place(&self, u: Vec2x<R>) -> Vec2x<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let (sin, cos) = sin_cos(u.x * self.half);
        let [c01, c12, c20] = self.cos;
        let (a, b) = (self.triple * cos - (c12 + c20) * sin, (one + c01) * sin);
        let mirror = (a + b * c12) / (a * a + b * b + (a + a) * b * c12);
        let mirror = mirror + mirror;
        let (one_far, two_far) = ((mirror * a - one).max(zero), mirror * b);
        // Uniform in height above the tangent plane of the apex: 1 − cos = u.y·(1 − apex·far).
        let height = one - (one_far * c01 + two_far * c20);
        let w = u.y * height;
        let two = R::splat(2.0);
        let along = (u.y * (two - w) / (two - height)).max(zero).sqrt();
        let apex = ((one - w) - (one - height) * along).max(zero) * self.per[0];
        let (first, second) = (along * one_far * self.per[1], along * two_far * self.per[2]);
        let per = one / (apex + first + second);
        Vec2x::new(first * per, second * per)
    }
}

/// Coordinates along the edges, uniform in area, by folding the square [Heitz 2019].
#[inline(always)]
fn spread<R: Real>(u: Vec2x<R>) -> Vec2x<R> {
    let half = R::splat(0.5);
    let above = u.y.gt(u.x);
    let b = R::select(above, u.x, u.y) * half;
    Vec2x::new(R::select(above, b, u.x - b), R::select(above, u.y - b, b))
}
