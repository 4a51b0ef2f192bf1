//! Environment maps in latitude–longitude layout: look-ups and importance sampling, for any number of lanes.

use crate::lanes::Sample;
use crate::patch::Patch;
use dapple_math::lanes::{Double, Real, Vec2x, Vec3x, Word, atan2, sin_cos};
use dapple_sampling::Grid2d;
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// An environment map; see [`crate::environment`] for its layout.
#[derive(Debug)]
pub(crate) struct LatLong {
    width: usize,
    height: usize,
    /// Radiance with the intensity factor applied, and the luminance relative to the largest.
    texels: Vec<[f32; 4]>,
    /// Rotation as a shift of u, in turns, [0, 1).
    shift: f64,
    filtered: bool,
    rows: Rows,
    pub mean: Vec3,
    /// Sampling distribution; None if there is nothing to sample.
    pub table: Option<Grid2d>,
    pub compensated: bool,
}

/// The rows of texels.
#[derive(Clone, Debug)]
struct Rows {
    /// cosθ of the upper and of the lower border, from 1 to −1, each as the sum of two numbers.
    cos: Vec<[f32; 4]>,
    /// Solid angle: 2π(cosθ_r − cosθ_{r+1}) = 4π·sin(middle)·sin(half step).
    solid_angle: Vec<f64>,
    /// 1/(solid angle · number of rows).
    per_angle: Vec<f32>,
}

impl Rows {
    fn new(height: usize) -> Self {
        let step = PI / height as f64;
        let border = |r: usize| match r {
            0 => 1.0,
            r if r == height => -1.0,
            r => libm::cos(r as f64 * step),
        };
        let two = |x: f64| [x as f32, (x - f64::from(x as f32)) as f32];
        let angle = |r: usize| 4.0 * PI * libm::sin((r as f64 + 0.5) * step) * libm::sin(0.5 * step);
        let solid_angle: Vec<f64> = (0..height).map(angle).collect();
        let per_angle = solid_angle.iter().map(|angle| (1.0 / (angle * height as f64)) as f32).collect();
        let ends = |r| {
            let ([a, b], [c, d]) = (two(border(r)), two(border(r + 1)));
            [a, b, c, d]
        };
        Self { cos: (0..height).map(ends).collect(), solid_angle, per_angle }
    }
}

/// A place in the map: a texel, and the position in it in texels (x right, y down).
#[derive(Clone, Copy)]
struct Place<R: Real> {
    column: R::Word,
    row: R::Word,
    within: Vec2x<R>,
}

impl LatLong {
    /// The map of `pixels`, which has at least one, with a distribution of the radiance above the mean.
    pub fn new((width, height): (usize, usize), pixels: Vec<Vec3>, shift: f64, filtered: bool) -> Self {
        let brightest = pixels.iter().map(|p| luminance(p.as_dvec3())).fold(0.0, f64::max);
        let relative = |p: &Vec3| if brightest > 0.0 { luminance(p.as_dvec3()) / brightest } else { 0.0 };
        let texels = pixels.iter().map(|p| p.extend(relative(p) as f32).to_array()).collect();
        drop(pixels);
        let (rows, mean) = (Rows::new(height), Vec3::ZERO);
        let mut map =
            Self { width, height, texels, shift, filtered, rows, mean, table: None, compensated: true };
        map.mean = map.integrate();
        map.table = map.build_table(true);
        map
    }

    /// The same map with a distribution of all of its radiance.
    pub fn without_compensation(&self) -> Self {
        Self {
            texels: self.texels.clone(),
            rows: self.rows.clone(),
            table: self.build_table(false),
            compensated: false,
            ..*self
        }
    }

    /// Memory use in bytes.
    pub fn memory_bytes(&self) -> usize {
        let table = if self.table.is_some() { size_of::<f64>() } else { 0 };
        self.texels.len() * (size_of::<[f32; 4]>() + table)
    }

    /// Place of a direction. θ = atan2(√(x² + z²), y): acos(y) would lose half of the digits at the poles. Any
    /// direction, even NaN, gives a valid texel.
    #[inline(always)]
    fn locate<R: Real>(&self, d: Vec3x<R>) -> Place<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let angle = R::Double::from_real(atan2(d.x, -d.z));
        let turn = angle / R::Double::splat(TAU) + R::Double::splat(0.5 + self.shift);
        // From just below 0 to just above 2.
        let is_below = turn.lt(R::Double::splat(0.0));
        let whole = R::select(is_below, -one, R::select(turn.lt(R::Double::splat(1.0)), zero, one));
        let turn = turn - R::Double::from_real(whole);
        let theta = R::Double::from_real(atan2((d.x * d.x + d.z * d.z).sqrt(), d.y));
        let (column, x) = cell::<R>(turn * R::Double::splat(self.width as f64), self.width);
        let (row, y) = cell::<R>(theta * R::Double::splat(self.height as f64 / PI), self.height);
        Place { column, row, within: Vec2x::new(x, y) }
    }

    /// Radiance from the unit directions `d`.
    #[inline(always)]
    pub fn radiance<R: Real>(&self, d: Vec3x<R>) -> Vec3x<R> {
        self.radiance_at(&self.locate(d))
    }

    #[inline(always)]
    fn radiance_at<R: Real>(&self, at: &Place<R>) -> Vec3x<R> {
        if self.filtered { self.bilinear(at) } else { self.texel::<R>(at.column, at.row) }
    }

    /// Number of a texel in the map.
    #[inline(always)]
    fn number<R: Real>(&self, column: R::Word, row: R::Word) -> R::Word {
        row.wrapping_mul(R::Word::splat(self.width as u32)).wrapping_add(column)
    }

    #[inline(always)]
    fn texel<R: Real>(&self, column: R::Word, row: R::Word) -> Vec3x<R> {
        let [r, g, b, _] = R::gather_rows(&self.texels, self.number::<R>(column, row));
        Vec3x::new(r, g, b)
    }

    /// The columns on both sides of a column, around the map, and the rows, within the map.
    #[inline(always)]
    fn neighbours<R: Real>(&self, column: R::Word, row: R::Word) -> [[R::Word; 2]; 2] {
        let (zero, one) = (R::Word::splat(0), R::Word::splat(1));
        let (right, bottom) = (R::Word::splat(self.width as u32 - 1), R::Word::splat(self.height as u32 - 1));
        let left = R::Word::select(column.eq(zero), right, column.wrapping_sub(one));
        let next = R::Word::select(column.eq(right), zero, column.wrapping_add(one));
        let above = R::Word::select(row.eq(zero), zero, row.wrapping_sub(one));
        let below = R::Word::select(row.eq(bottom), bottom, row.wrapping_add(one));
        [[left, next], [above, below]]
    }

    /// Interpolates between the centres of the four texels around a place.
    #[inline(always)]
    fn bilinear<R: Real>(&self, at: &Place<R>) -> Vec3x<R> {
        let (half, Place { column, row, within }) = (R::splat(0.5), *at);
        let (is_left, is_upper) = (within.x.lt(half), within.y.lt(half));
        let [[left, right], [above, below]] = self.neighbours::<R>(column, row);
        let (c0, c1) = (R::Word::select(is_left, left, column), R::Word::select(is_left, column, right));
        let (r0, r1) = (R::Word::select(is_upper, above, row), R::Word::select(is_upper, row, below));
        let s = within.x + R::select(is_left, half, -half);
        let t = within.y + R::select(is_upper, half, -half);
        let top = lerp(self.texel(c0, r0), self.texel(c1, r0), s);
        let bottom = lerp(self.texel(c0, r1), self.texel(c1, r1), s);
        lerp(top, bottom, t)
    }

    /// Mean radiance of a cell: its texel, or with bilinear filtering the weighted mean of the nine texels around it,
    /// so that no cell with any light counts as dark.
    fn cell(&self, column: usize, row: usize) -> DVec3 {
        let texel = |column: usize, row: usize| {
            let [r, g, b, _] = self.texels[row * self.width + column];
            Vec3::new(r, g, b).as_dvec3()
        };
        if !self.filtered {
            return texel(column, row);
        }
        let columns = [(column + self.width - 1) % self.width, column, (column + 1) % self.width];
        let rows = [row.saturating_sub(1), row, (row + 1).min(self.height - 1)];
        let share = [0.125, 0.75, 0.125];
        let mut sum = DVec3::ZERO;
        for (r, sr) in rows.iter().zip(share) {
            for (c, sc) in columns.iter().zip(share) {
                sum += texel(*c, *r) * (sr * sc);
            }
        }
        sum
    }

    fn integrate(&self) -> Vec3 {
        let row = |r: usize| -> DVec3 {
            let sum: DVec3 = (0..self.width).map(|c| self.cell(c, r)).sum();
            sum * (self.rows.solid_angle[r] / self.width as f64)
        };
        ((0..self.height).map(row).sum::<DVec3>() / (4.0 * PI)).as_vec3()
    }

    /// Builds the distribution. The weight of a cell is its luminance (minus the mean luminance, if compensated,
    /// [Karlík 2019, §4]) times its solid angle. None if all weights are 0: everything is then left to BSDF sampling.
    fn build_table(&self, compensated: bool) -> Option<Grid2d> {
        let mean = if compensated { luminance(self.mean.as_dvec3()) } else { 0.0 };
        let mut weights = Vec::with_capacity(self.texels.len());
        for r in 0..self.height {
            let angle = self.rows.solid_angle[r];
            let weight = |c: usize| (luminance(self.cell(c, r)) - mean).max(0.0) * angle;
            weights.extend((0..self.width).map(weight));
        }
        Grid2d::new(self.width, self.height, &weights)
    }

    /// Probability of the cell divided by its solid angle.
    #[inline(always)]
    fn density<R: Real>(&self, table: &Grid2d, column: R::Word, row: R::Word) -> R {
        table.cell_pdf_lanes::<R>(column, row) * R::gather(&self.rows.per_angle, row)
    }

    /// Relative luminance of a cell and its neighbours.
    #[inline(always)]
    fn patch<R: Real>(&self, column: R::Word, row: R::Word) -> Patch<R> {
        let [[left, right], [above, below]] = self.neighbours::<R>(column, row);
        Patch([
            self.three::<R>([left, column, right], above),
            self.three::<R>([left, column, right], row),
            self.three::<R>([left, column, right], below),
        ])
    }

    /// Relative luminance of three texels of a row.
    #[inline(always)]
    fn three<R: Real>(&self, [a, b, c]: [R::Word; 3], row: R::Word) -> [R; 3] {
        [self.relative::<R>(a, row), self.relative::<R>(b, row), self.relative::<R>(c, row)]
    }

    #[inline(always)]
    fn relative<R: Real>(&self, column: R::Word, row: R::Word) -> R {
        let at = (self.number::<R>(column, row) << 2).wrapping_add(R::Word::splat(3));
        R::gather(self.texels.as_flattened(), at)
    }

    /// cosθ of the borders of a row.
    #[inline(always)]
    fn borders<R: Real>(&self, row: R::Word) -> [R::Double; 2] {
        let [a, b, c, d] = R::gather_rows(&self.rows.cos, row);
        let (top, bottom) = (R::Double::from_real(a), R::Double::from_real(c));
        [top + R::Double::from_real(b), bottom + R::Double::from_real(d)]
    }

    /// Solid-angle density of [`LatLong::sample`] at unit directions.
    #[inline(always)]
    pub fn pdf<R: Real>(&self, d: Vec3x<R>) -> R {
        self.pdf_at(&self.locate(d), d.y)
    }

    /// Radiance from unit directions, and the density of [`LatLong::sample`] there.
    #[inline(always)]
    pub fn radiance_and_pdf<R: Real>(&self, d: Vec3x<R>) -> (Vec3x<R>, R) {
        let at = self.locate(d);
        (self.radiance_at(&at), self.pdf_at(&at, d.y))
    }

    #[inline(always)]
    fn pdf_at<R: Real>(&self, at: &Place<R>, y: R) -> R {
        let Some(table) = &self.table else { return R::splat(0.0) };
        let pdf = self.density::<R>(table, at.column, at.row);
        if !self.filtered {
            return pdf;
        }
        let down = down::<R>(self.borders::<R>(at.row), y);
        pdf * self.patch::<R>(at.column, at.row).density(Vec2x::new(at.within.x, down))
    }

    /// Samples directions. Within the cell they are uniform in azimuth and cosθ, that is, in solid angle; with
    /// filtering they follow the luminance between the texels (in cosθ as if it were θ). Without filtering the radiance
    /// is that of the selected cell, even if the direction rounds into its neighbour.
    #[inline(always)]
    pub fn sample<R: Real>(&self, u: Vec2x<R>) -> Sample<R> {
        let Some(table) = &self.table else { return Sample::none() };
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let chosen = table.sample_lanes(u);
        let ([column, row], mut at) = (chosen.cell, chosen.within);
        let mut pdf = self.density::<R>(table, column, row);
        let mut patch = None;
        if self.filtered {
            let around = self.patch::<R>(column, row);
            at = around.sample(at);
            patch = Some(around);
        }
        let [top, bottom] = self.borders::<R>(row);
        let (unit, share) = (R::Double::splat(1.0), R::Double::from_real(at.y));
        let y = top * (unit - share) + bottom * share;
        let sin = ((unit - y) * (unit + y)).max(R::Double::splat(0.0)).sqrt().to_real();
        let x = R::Double::from_real(column.int_to_real()) + R::Double::from_real(at.x);
        let turn = x / R::Double::splat(self.width as f64) - R::Double::splat(0.5 + self.shift);
        let back = R::select(turn.lt(R::Double::splat(-0.5)), one, zero);
        let turn = turn + R::Double::from_real(back);
        let (s, c) = sin_cos((turn * R::Double::splat(TAU)).to_real());
        let wi = Vec3x::new(sin * s, y.to_real(), -(sin * c));
        let radiance = match patch {
            None => self.texel(column, row),
            Some(patch) => {
                // Position of the rounded direction, unless it rounds into a neighbour.
                let found = self.locate(wi);
                let is_same = found.column.eq(column) & found.row.eq(row);
                let x = R::select(is_same, found.within.x, at.x);
                let y = R::select(is_same, down::<R>([top, bottom], wi.y), at.y);
                pdf *= patch.density(Vec2x::new(x, y));
                self.bilinear(&found)
            }
        };
        let usable = pdf.gt(zero) & pdf.is_finite();
        let pdf = R::select(usable, pdf, zero);
        Sample { wi, pdf, radiance, distance: R::splat(f32::INFINITY), ..Sample::none() }
    }
}

/// The share of the height of a row, linear in cosθ, above the height `y`.
#[inline(always)]
fn down<R: Real>([top, bottom]: [R::Double; 2], y: R) -> R {
    let down = ((top - R::Double::from_real(y)) / (top - bottom)).to_real();
    down.max(R::splat(0.0)).min(R::splat(1.0))
}

/// The whole part of a position on a line of `n` cells, which is at least 0 and at most n, and the rest.
#[inline(always)]
fn cell<R: Real>(at: R::Double, n: usize) -> (R::Word, R) {
    let (one, last) = (R::Word::splat(1), R::Word::splat(n as u32 - 1));
    let near = at.to_real().to_int();
    let near = R::Word::select(near.lt(last), near, last);
    // Rounding to f32 can reach the next whole number.
    let rest = (at - R::Double::from_real(near.int_to_real())).to_real();
    let is_beyond = rest.lt(R::splat(0.0)) & near.ne(R::Word::splat(0));
    let near = R::Word::select(is_beyond, near.wrapping_sub(one), near);
    (near, (at - R::Double::from_real(near.int_to_real())).to_real())
}

#[inline(always)]
fn lerp<R: Real>(a: Vec3x<R>, b: Vec3x<R>, t: R) -> Vec3x<R> {
    a + (b - a) * t
}

/// Rec.709 luminance.
fn luminance(c: DVec3) -> f64 {
    c.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}
