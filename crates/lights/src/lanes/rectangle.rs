//! Rectangles, sampled by a map from the unit square that is smooth and uniform in solid angle [Ureña, Fajardo and King
//! 2013].
//!
//! In the frame of the rectangle the receiver is the origin and the rectangle is \[x0, x1\]×\[y0, y1\] at height h. The
//! strip from the plane x = 0 to x subtends the angle asin(n1·s) − asin(n0·s), with s = x/√(x² + h²) and the sines n0,
//! n1 of the angles to the edges y0 and y1. That angle is given, a, and s = sin a/√(n0² + n1² − 2·n0·n1·cos a) by the
//! law of cosines. Differences that would cancel are computed as quotients, so that the error of a point relative to
//! the rectangle stays close to that of its coordinates, at every size. All angles are sums of angles whose tangents
//! are known: they are multiplied as complex numbers, and one arctangent gives the solid angle.
use super::aimed::Aimed;
use super::flat::{Flat, How, LEAST, is_small};
use crate::polygon::Outline;
use dapple_math::lanes::{Mask, Real, Vec2x, Vec3x, atan2, sin_cos};

/// One rectangle per lane.
#[derive(Clone, Copy, Debug)]
pub struct Rectangle<R: Real>(pub Flat<R>);

/// A rectangle as the receiver sees it.
struct Seen<R: Real> {
    /// Coordinates of the corners along the edges.
    x: [R; 2],
    y: [R; 2],
    /// Height over the plane, positive in front, and its square.
    height: R,
    h2: R,
    /// Inverse distances of the corners (x0, y0) and (x0, y1).
    per: [R; 2],
    /// Half of the solid angle; arbitrary where it is small.
    half: R,
    is_small: R::Mask,
    /// Where f32 is accurate.
    accurate: R::Mask,
}

const SOLID_ANGLE: How = How { outline: Outline::Rectangle, by_area: false };
const AREA: How = How { outline: Outline::Rectangle, by_area: true };

impl<R: Real> Rectangle<R> {
    /// Samples points for receivers at `p` with `u` in \[0, 1)²: uniformly in solid angle if it is at least 10⁻³ sr,
    /// else uniformly in area. The density is 0 behind a one-sided rectangle and in its plane.
    #[inline(always)]
    pub fn sample(&self, p: Vec3x<R>, u: Vec2x<R>) -> Aimed<R> {
        let seen = self.seen(p);
        let by_area = seen.is_small;
        let (mut x, mut y) = (seen.spread(seen.x, u.x), seen.spread(seen.y, u.y));
        if !by_area.all() {
            x = R::select(by_area, x, seen.place_x(u.x));
            y = R::select(by_area, y, seen.place_y(x, u.y));
        }
        let fast = self.at(&seen, x, y, by_area);
        self.0.replaced(!seen.accurate, fast, p, u, SOLID_ANGLE).only_finite()
    }

    /// Solid-angle density of [`Rectangle::sample`] at `p`, for a point at `distance`.
    #[inline(always)]
    pub fn pdf(&self, p: Vec3x<R>, distance: R) -> R {
        let seen = self.seen(p);
        let fast = self.density(&seen, distance, seen.is_small);
        self.0.replaced_pdf(!seen.accurate, fast, p, distance, SOLID_ANGLE).min(R::splat(f32::MAX))
    }

    /// Samples points uniformly in area: corner + u.x·e1 + u.y·e2.
    #[inline(always)]
    pub fn sample_surface(&self, p: Vec3x<R>, u: Vec2x<R>) -> Aimed<R> {
        let seen = self.seen(p);
        let (x, y) = (seen.spread(seen.x, u.x), seen.spread(seen.y, u.y));
        let fast = self.at(&seen, x, y, R::Mask::splat(true));
        self.0.replaced(!seen.accurate, fast, p, u, AREA).only_finite()
    }

    /// Solid-angle density of [`Rectangle::sample_surface`] at `p`, for a point at `distance`.
    #[inline(always)]
    pub fn pdf_surface(&self, p: Vec3x<R>, distance: R) -> R {
        let seen = self.seen(p);
        let fast = self.density(&seen, distance, R::Mask::splat(true));
        self.0.replaced_pdf(!seen.accurate, fast, p, distance, AREA).min(R::splat(f32::MAX))
    }

    #[inline(always)]
    fn seen(&self, p: Vec3x<R>) -> Seen<R> {
        let light = &self.0;
        let p0 = light.corner - p;
        let (x0, y0) = (p0.dot(light.e1) * light.per_e1, p0.dot(light.e2) * light.per_e2);
        let height = -p0.dot(light.n);
        let x = [x0, x0 + light.area * light.per_e2];
        let y = [y0, y0 + light.area * light.per_e1];
        let h2 = height * height;
        let largest = x[0].abs().max(x[1].abs()).max(y[0].abs().max(y[1].abs()));
        let (per, half, wide) = half_solid_angle(x, y, height.abs(), light.area);
        let is_small = is_small(half.sin, half.cos);
        let half = if is_small.all() { half.sin } else { atan2(half.sin, half.cos) };
        let accurate = Flat::accurate(height, largest) & wide;
        Seen { x, y, height, h2, per, half, is_small, accurate }
    }

    #[inline(always)]
    fn density(&self, seen: &Seen<R>, distance: R, by_area: R::Mask) -> R {
        let uniform = R::splat(0.5) / seen.half;
        let pdf = R::select(by_area, Flat::area_pdf(distance, seen.height, self.0.area), uniform);
        R::select(self.0.faces(seen.height), pdf, R::splat(0.0))
    }

    /// The sample at a point in the frame of the rectangle.
    #[inline(always)]
    fn at(&self, seen: &Seen<R>, x: R, y: R, by_area: R::Mask) -> Aimed<R> {
        let light = &self.0;
        let distance = (x * x + y * y + seen.h2).sqrt();
        let pdf = self.density(seen, distance, by_area);
        // Not computed from the coordinates: a receiver close to the light still gets all directions.
        let to = light.e1 * (x * light.per_e1) + light.e2 * (y * light.per_e2) - light.n * seen.height;
        let (s, t) = ((x - seen.x[0]) * light.per_e1, (y - seen.y[0]) * light.per_e2);
        let one = R::splat(1.0);
        light.at(s.min(one), t.min(one), to, distance, pdf)
    }
}

/// Half of the solid angle of the rectangle, as a complex number of any size, from two triangles [Van Oosterom and
/// Strackee 1983]; also the inverse distances of (x0, y0) and (x0, y1), and where no number below cancels. Half of an angle is that of the complex number 1 + a·b + b·c + c·a +
/// i·a·(b×c), with unit vectors to the corners; the product of both numbers has half of the sum.
#[inline(always)]
fn half_solid_angle<R: Real>(x: [R; 2], y: [R; 2], h: R, area: R) -> ([R; 2], Angle<R>, R::Mask) {
    let one = R::splat(1.0);
    let h2 = h * h;
    let (xx, yy) = ([x[0] * x[0], x[1] * x[1]], [y[0] * y[0] + h2, y[1] * y[1] + h2]);
    let (a, b) = (one / (xx[0] + yy[0]).sqrt(), one / (xx[1] + yy[0]).sqrt());
    let (c, d) = (one / (xx[1] + yy[1]).sqrt(), one / (xx[0] + yy[1]).sqrt());
    let (px, py) = (x[0] * x[1], y[0] * y[1]);
    let diagonal = a * c;
    let shared = one + (px + py + h2) * diagonal;
    let (ab, bc) = ((px + yy[0]) * (a * b), (py + h2 + xx[1]) * (b * c));
    let (cd, ad) = ((px + yy[1]) * (c * d), (py + h2 + xx[0]) * (a * d));
    let (first, second) = (shared + (ab + bc), shared + (cd + ad));
    let triple = h * (area * diagonal);
    let (f, g) = (triple * b, triple * d);
    let wide = (first.abs() + f).ge(R::splat(LEAST)) & (second.abs() + g).ge(R::splat(LEAST));
    ([a, d], Angle { cos: first * second - f * g, sin: f * second + g * first }, wide)
}

/// An angle by its cosine and sine; the product is that of the sum.
#[derive(Clone, Copy)]
struct Angle<R> {
    cos: R,
    sin: R,
}

impl<R: Real> Angle<R> {
    #[inline(always)]
    fn times(self, b: Self) -> Self {
        Self { cos: self.cos * b.cos - self.sin * b.sin, sin: self.sin * b.cos + self.cos * b.sin }
    }

    #[inline(always)]
    fn mirrored(self) -> Self {
        Self { sin: -self.sin, ..self }
    }
}

/// Half of an angle of less than π/2.
#[inline(always)]
fn halved<R: Real>(cos: R, sin: R) -> Angle<R> {
    let half = R::splat(0.5);
    let cos = (half + half * cos).sqrt();
    Angle { cos, sin: half * sin / cos }
}

/// y1·d1 − y0·d0, where d0² = base + y1², d1² = base + y0² and y0 ≤ y1. Of equal signs it is the difference of the squares, which is
/// base·(y1² − y0²), divided by the sum.
#[inline(always)]
fn difference<R: Real>(y: [R; 2], d: [R; 2], base: R) -> R {
    let (low, high) = (y[0] * d[0], y[1] * d[1]);
    let apart = (y[0] * y[1]).le(R::splat(0.0));
    let over = R::select(apart, R::splat(1.0), high + low);
    R::select(apart, high - low, base * (y[1] - y[0]) * (y[0] + y[1])) / over
}

impl<R: Real> Seen<R> {
    #[inline(always)]
    fn spread(&self, [from, to]: [R; 2], u: R) -> R {
        from + (to - from) * u
    }

    /// The x below which the share `u` of the solid angle lies.
    #[inline(always)]
    fn place_x(&self, u: R) -> R {
        let ([x0, _], [y0, y1], h2) = (self.x, self.y, self.h2);
        let (h, half) = (self.height.abs(), R::splat(0.5));
        // Half of the angles to the edges, of their difference and of their sum. The sine of the difference does not
        // cancel in this form.
        let (r0, r1) = ((h2 + y0 * y0).sqrt(), (h2 + y1 * y1).sqrt());
        let per_r = R::splat(1.0) / (r0 * r1);
        let (low, high) = (halved(h * r1 * per_r, y0 * r1 * per_r), halved(h * r0 * per_r, y1 * r0 * per_r));
        let between = high.times(low.mirrored());
        let between = Angle { sin: half * (h * (y1 - y0) * per_r) / between.cos, ..between };
        let sum = high.times(low);
        // Half of the strip from 0 to x0: the difference of two angles of tangents x0·y/(h·d).
        let base = x0 * x0 + h2;
        let (d0, d1) = ((base + y0 * y0) * self.per[0], (base + y1 * y1) * self.per[1]);
        let per = per_r / base.sqrt();
        let (c0, c1) = (h * r1 * per, h * r0 * per);
        let (s0, s1) = (x0 * r1 * per, x0 * r0 * per);
        let start = halved(c1 * d1, s1 * y1).times(halved(c0 * d0, s0 * y0).mirrored());
        let sin = h * x0 * difference(self.y, [d1, d0], base) * (per_r / base);
        let start = Angle { sin: half * sin / start.cos, ..start };
        // Half of the strip to x.
        let (sin, cos) = sin_cos(u * self.half);
        let a = start.times(Angle { cos, sin });
        // sin² a/(n0² + n1² − 2·n0·n1·cos a) = x²/(x² + h²), solved for x, with differences of cosines as products.
        let (rest, over) = (between.times(a.mirrored()).sin, between.times(a).sin);
        let (sum, difference) = (sum.times(a).cos, sum.times(a.mirrored()).cos);
        let rest = (rest * over) * (sum * difference);
        let x = h * (a.sin * a.cos) / rest.max(R::splat(1e-30)).sqrt();
        x.max(x0).min(self.x[1])
    }

    /// The y below which the share `u` of the line at `x` lies, as seen from the receiver.
    #[inline(always)]
    fn place_y(&self, x: R, u: R) -> R {
        let ([y0, y1], one) = (self.y, R::splat(1.0));
        let d2 = x * x + self.h2;
        let (low, high) = (y0 / (d2 + y0 * y0).sqrt(), y1 / (d2 + y1 * y1).sqrt());
        let v = low + u * (high - low);
        let y = v * (d2 / ((one - v) * (one + v)).max(R::splat(1e-30))).sqrt();
        y.max(y0).min(y1)
    }
}
