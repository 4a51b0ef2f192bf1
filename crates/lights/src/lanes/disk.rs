//! Disks, sampled uniformly in area.
use super::aimed::Aimed;
use super::columns::{Columns, lane, lanes_of, stored, three};
use super::flat::Flat;
use crate::disk::Disk as Exact;
use dapple_math::Frame;
use dapple_math::lanes::{MAX_LANES, Mask, Real, Vec2x, Vec3x, sin_cos};
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// One disk per lane: its centre, and two orthogonal radii as edges.
#[derive(Clone, Copy, Debug)]
pub struct Disk<R: Real>(pub Flat<R>);

/// Computes what depends on a disk alone. Its normal is the given one.
#[inline(always)]
pub(crate) fn disk(centre: Vec3, normal: Vec3, radius: f32, two_sided: bool) -> Disk<f32> {
    let frame = Frame::from_z(normal);
    let (e1, e2) = ((frame.x * radius).into(), (frame.y * radius).into());
    let (area, per) = (radius * radius, 1.0 / radius);
    let (corner, n) = (centre.into(), normal.into());
    Disk(Flat { corner, e1, e2, n, area, per_e1: per, per_e2: per, two_sided })
}

impl<R: Real> Disk<R> {
    /// Samples points for receivers at `p` with `u` in \[0, 1)². The density is 0 behind a one-sided disk and in its
    /// plane.
    #[inline(always)]
    pub fn sample(&self, p: Vec3x<R>, u: Vec2x<R>) -> Aimed<R> {
        let light = &self.0;
        let at = concentric(u);
        let to_centre = light.corner - p;
        let height = -to_centre.dot(light.n);
        let to = to_centre + (light.e1 * at.x + light.e2 * at.y);
        let distance = to.length();
        let fast = light.at(at.x, at.y, to, distance, self.density(height, distance));
        self.replaced(!self.accurate(to_centre, height), fast, p).only_finite()
    }

    /// Solid-angle density of [`Disk::sample`] at `p`, for a point at `distance`.
    #[inline(always)]
    pub fn pdf(&self, p: Vec3x<R>, distance: R) -> R {
        let to_centre = self.0.corner - p;
        let height = -to_centre.dot(self.0.n);
        let mut pdf = self.density(height, distance);
        let rare = !self.accurate(to_centre, height);
        if rare.any() {
            let [mut column, distance] = stored([pdf, distance]);
            pdf_lanes(rare.bitmask(), &mut column, &self.columns(), &three(p), &distance);
            pdf = R::load(&column);
        }
        pdf.min(R::splat(f32::MAX))
    }

    #[inline(always)]
    fn accurate(&self, to_centre: Vec3x<R>, height: R) -> R::Mask {
        let radius = R::splat(1.0) / self.0.per_e1;
        Flat::accurate(height, to_centre.length().max(radius))
    }

    #[inline(always)]
    fn density(&self, height: R, distance: R) -> R {
        let pdf = Flat::area_pdf(distance, height, self.0.area * R::splat(PI));
        R::select(self.0.faces(height), pdf, R::splat(0.0))
    }

    /// Replaces directions and densities of the lanes of `mask` by values computed in f64 for the same points.
    #[inline(always)]
    fn replaced(&self, mask: R::Mask, fast: Aimed<R>, p: Vec3x<R>) -> Aimed<R> {
        if !mask.any() {
            return fast;
        }
        let wi = fast.wi;
        let mut columns = stored([wi.x, wi.y, wi.z, fast.distance, fast.pdf]);
        let offset = self.0.e1 * fast.s + self.0.e2 * fast.t;
        sample_lanes(mask.bitmask(), &mut columns, &self.columns(), &three(p), &three(offset));
        let [x, y, z, distance, pdf] = columns;
        let (distance, pdf) = (R::load(&distance), R::load(&pdf));
        Aimed { wi: Vec3x::load([&x, &y, &z]), distance, pdf, ..fast }
    }

    #[inline(always)]
    fn columns(&self) -> LightColumns {
        let [area] = stored([self.0.area]);
        let two_sided = self.0.two_sided.bitmask();
        LightColumns { centre: three(self.0.corner), normal: three(self.0.n), area, two_sided }
    }
}

/// Maps the unit square to the unit disk, concentric squares to circles [Shirley & Chiu 1997].
#[inline(always)]
fn concentric<R: Real>(u: Vec2x<R>) -> Vec2x<R> {
    let (one, zero, quarter) = (R::splat(1.0), R::splat(0.0), R::splat(FRAC_PI_4));
    let (x, y) = (u.x + u.x - one, u.y + u.y - one);
    let wide = x.abs().gt(y.abs());
    let (r, below) = (R::select(wide, x, y), R::select(wide, y, x));
    let angle = quarter * (below / R::select(r.eq(zero), one, r));
    let (sin, cos) = sin_cos(R::select(wide, angle, R::splat(FRAC_PI_2) - angle));
    Vec2x::new(r * cos, r * sin)
}

struct LightColumns {
    centre: Columns<3>,
    normal: Columns<3>,
    /// The square of the radius.
    area: [f32; MAX_LANES],
    two_sided: u32,
}

impl LightColumns {
    fn disk(&self, i: usize) -> Exact {
        let (centre, normal) = (lane(&self.centre, i), lane(&self.normal, i));
        let two_sided = self.two_sided >> i & 1 == 1;
        Exact { centre, normal, square: self.area[i].into(), two_sided }
    }
}

#[cold]
#[inline(never)]
fn sample_lanes(
    mask: u32,
    columns: &mut Columns<5>,
    light: &LightColumns,
    p: &Columns<3>,
    offset: &Columns<3>,
) {
    for i in lanes_of(mask) {
        let (wi, distance, pdf) = light.disk(i).aim(lane(p, i), lane(offset, i));
        let values = [wi.x, wi.y, wi.z, distance, pdf];
        columns.iter_mut().zip(values).for_each(|(column, value)| column[i] = value);
    }
}

#[cold]
#[inline(never)]
fn pdf_lanes(mask: u32, pdf: &mut [f32], light: &LightColumns, p: &Columns<3>, distance: &[f32]) {
    for i in lanes_of(mask) {
        pdf[i] = light.disk(i).pdf(lane(p, i), distance[i]);
    }
}
