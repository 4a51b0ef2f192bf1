//! Environment lights: a constant or an environment map in latitude–longitude layout, importance-sampled with MIS
//! compensation.
//!
//! World direction d maps to u = ½ + atan2(d.x, −d.z)/2π, v = acos(d.y)/π of the map, v from the top row: the centre of
//! the map is −Z and u grows towards +X. A texel is a constant patch unless filtering is enabled. `rotation` rotates
//! the environment about +Y by the right-hand rule: what was at −Z moves towards −X.
use crate::LightSample;
use crate::patch::Patch;
use dapple_math::Image;
use dapple_sampling::Grid2d;
use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::{PI, TAU};
use std::fmt;
use std::sync::Arc;

/// Incident radiance as a function of direction. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Environment(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Constant(Vec3),
    LatLong(Arc<LatLong>),
}

#[derive(Debug)]
struct LatLong {
    width: usize,
    height: usize,
    /// Radiance with the intensity factor applied.
    pixels: Vec<Vec3>,
    /// Rotation as a shift of u, in turns, [0, 1).
    shift: f64,
    filtered: bool,
    rows: Rows,
    mean: Vec3,
    /// Sampling distribution; None if there is nothing to sample.
    table: Option<Grid2d>,
    compensated: bool,
}

impl Environment {
    /// An environment with the same radiance in every direction. It is never sampled directly.
    pub fn constant(radiance: Vec3) -> Self {
        Self(Kind::Constant(radiance))
    }

    /// An environment map: u = ½ + atan2(d.x, −d.z)/2π, v = acos(d.y)/π from the top row. Texels are constant patches
    /// unless `filtered`, which interpolates bilinearly between texel centres, wraps at the seam, and clamps beyond the
    /// centres of the first and last row. `rotation` is in radians about +Y; `intensity` is a factor. A texel that is
    /// negative or not finite, before or after multiplication, is an error that names it. A map of one colour becomes
    /// [`Environment::constant`]; an empty one is black.
    pub fn picture(picture: Image, rotation: f32, intensity: f32, filtered: bool) -> Result<Self, BadTexel> {
        let Image { width, height, mut pixels } = picture;
        pixels.truncate(width.saturating_mul(height));
        for (i, pixel) in pixels.iter_mut().enumerate() {
            let value = *pixel;
            *pixel *= intensity;
            if !(pixel.is_finite() && pixel.min_element() >= 0.0) {
                return Err(BadTexel { x: i % width, y: i / width, value });
            }
        }
        let first = pixels.first().copied().unwrap_or(Vec3::ZERO);
        if pixels.len() < width.saturating_mul(height) || pixels.iter().all(|p| *p == first) {
            return Ok(Self::constant(first));
        }
        let turns = rotation as f64 / TAU;
        let shift = if turns.is_finite() { turns - turns.floor() } else { 0.0 };
        let rows = Rows::new(height);
        let mut map = LatLong {
            width,
            height,
            pixels,
            shift,
            filtered,
            rows,
            mean: first,
            table: None,
            compensated: true,
        };
        map.mean = map.integrate();
        map.table = map.build_table(true);
        Ok(Self(Kind::LatLong(Arc::new(map))))
    }

    /// The same environment, sampled in proportion to its full radiance, so that light sampling alone is an unbiased
    /// estimator. By default only the radiance above the mean is sampled, and the rest is left to BSDF sampling [Karlík
    /// 2019].
    pub fn without_compensation(self) -> Self {
        let Kind::LatLong(map) = &self.0 else { return self };
        let table = map.build_table(false);
        let rows = Rows::new(map.height);
        let pixels = map.pixels.clone();
        Self(Kind::LatLong(Arc::new(LatLong { pixels, rows, table, compensated: false, ..**map })))
    }

    /// Radiance from the unit direction `d`.
    #[inline]
    pub fn radiance(&self, d: Vec3) -> Vec3 {
        match &self.0 {
            Kind::Constant(radiance) => *radiance,
            Kind::LatLong(map) => map.radiance(d),
        }
    }

    /// Whether the radiance is the same in every direction.
    pub fn is_constant(&self) -> bool {
        matches!(self.0, Kind::Constant(_))
    }

    /// Whether light sampling is of use (a constant environment is left to BSDF sampling).
    pub fn is_sampled(&self) -> bool {
        matches!(&self.0, Kind::LatLong(map) if map.table.is_some())
    }

    /// Whether only the radiance above the mean is sampled (see [`Environment::without_compensation`]).
    pub fn is_compensated(&self) -> bool {
        matches!(&self.0, Kind::LatLong(map) if map.compensated)
    }

    /// Mean radiance over the sphere: ∫L dω/4π. *Approximation* with filtering: solid angle is assumed to be uniform
    /// within a texel; the value only affects the probabilities of selection.
    pub fn mean(&self) -> Vec3 {
        match &self.0 {
            Kind::Constant(radiance) => *radiance,
            Kind::LatLong(map) => map.mean,
        }
    }

    /// Samples a direction with `u` in \[0,1)². None if there is nothing to sample.
    pub fn sample(&self, u: Vec2) -> Option<LightSample> {
        let Kind::LatLong(map) = &self.0 else { return None };
        map.sample(map.table.as_ref()?, u)
    }

    /// Solid-angle density of `sample` at the unit direction `wi`; 0 if there is nothing to sample.
    pub fn pdf(&self, wi: Vec3) -> f32 {
        let Kind::LatLong(map) = &self.0 else { return 0.0 };
        let Some(table) = &map.table else { return 0.0 };
        let (column, row, within) = map.locate(wi);
        map.density(table, column, row) * map.share(column, row, within.x.into(), wi.y.into())
    }

    /// Memory use in bytes of texels and tables.
    pub fn memory_bytes(&self) -> usize {
        let Kind::LatLong(map) = &self.0 else { return 0 };
        let table = if map.table.is_some() { size_of::<f64>() } else { 0 };
        map.pixels.len() * (size_of::<Vec3>() + table)
    }
}

/// cosθ of the borders between rows, and the solid angle of the rows.
#[derive(Debug)]
struct Rows {
    /// height + 1 values from 1 to −1.
    cos: Vec<f64>,
    /// 2π(cosθ_r − cosθ_{r+1}) = 4π·sin(middle)·sin(half step), per row.
    solid_angle: Vec<f64>,
}
impl Rows {
    fn new(height: usize) -> Self {
        let step = PI / height as f64;
        let border = |r: usize| match r {
            0 => 1.0,
            r if r == height => -1.0,
            r => libm::cos(r as f64 * step),
        };
        let angle = |r: usize| 4.0 * PI * libm::sin((r as f64 + 0.5) * step) * libm::sin(0.5 * step);
        Self { cos: (0..=height).map(border).collect(), solid_angle: (0..height).map(angle).collect() }
    }
}

impl LatLong {
    /// Column, row, and position in texels (x right, y down) of a direction. θ = atan2(√(x² + z²), y): acos(y) would
    /// lose half of the digits at the poles. Any direction, even NaN, gives a valid texel.
    #[inline]
    fn locate(&self, d: Vec3) -> (usize, usize, Vec2) {
        let turn = 0.5 + libm::atan2f(d.x, -d.z) as f64 / TAU + self.shift;
        let x = (turn - turn.floor()) * self.width as f64;
        let theta = libm::atan2f((d.x * d.x + d.z * d.z).sqrt(), d.y) as f64;
        let y = theta / PI * self.height as f64;
        let column = (x as usize).min(self.width - 1);
        let row = (y as usize).min(self.height - 1);
        (column, row, Vec2::new((x - column as f64) as f32, (y - row as f64) as f32))
    }

    #[inline]
    fn texel(&self, column: usize, row: usize) -> Vec3 {
        self.pixels[row * self.width + column]
    }

    #[inline]
    fn radiance(&self, d: Vec3) -> Vec3 {
        let (column, row, within) = self.locate(d);
        if self.filtered { self.bilinear(column, row, within) } else { self.texel(column, row) }
    }

    /// Interpolates between the centres of the four texels around a position.
    fn bilinear(&self, column: usize, row: usize, within: Vec2) -> Vec3 {
        let (c0, c1, s) = if within.x < 0.5 {
            ((column + self.width - 1) % self.width, column, within.x + 0.5)
        } else {
            (column, (column + 1) % self.width, within.x - 0.5)
        };
        let (r0, r1, t) = if within.y < 0.5 {
            (row.saturating_sub(1), row, within.y + 0.5)
        } else {
            (row, (row + 1).min(self.height - 1), within.y - 0.5)
        };
        let top = self.texel(c0, r0).lerp(self.texel(c1, r0), s);
        let bottom = self.texel(c0, r1).lerp(self.texel(c1, r1), s);
        top.lerp(bottom, t)
    }

    /// Mean radiance of a cell: its texel, or with bilinear filtering the weighted mean of the nine texels around it,
    /// so that no cell with any light counts as dark.
    fn cell(&self, column: usize, row: usize) -> DVec3 {
        if !self.filtered {
            return self.texel(column, row).as_dvec3();
        }
        let columns = [(column + self.width - 1) % self.width, column, (column + 1) % self.width];
        let rows = [row.saturating_sub(1), row, (row + 1).min(self.height - 1)];
        let share = [0.125, 0.75, 0.125];
        let mut sum = DVec3::ZERO;
        for (r, sr) in rows.iter().zip(share) {
            for (c, sc) in columns.iter().zip(share) {
                sum += self.texel(*c, *r).as_dvec3() * (sr * sc);
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
        let mut weights = Vec::with_capacity(self.pixels.len());
        for r in 0..self.height {
            let angle = self.rows.solid_angle[r];
            let weight = |c: usize| (luminance(self.cell(c, r)) - mean).max(0.0) * angle;
            weights.extend((0..self.width).map(weight));
        }
        Grid2d::new(self.width, self.height, &weights)
    }

    /// Probability of the cell divided by its solid angle.
    #[inline]
    fn density(&self, table: &Grid2d, column: usize, row: usize) -> f32 {
        let probability_times_cells = table.cell_pdf(column as u32, row as u32) as f64;
        (probability_times_cells / (self.height as f64 * self.rows.solid_angle[row])) as f32
    }

    /// Luminance of a cell and its neighbours.
    fn patch(&self, column: usize, row: usize) -> Patch {
        let columns = [(column + self.width - 1) % self.width, column, (column + 1) % self.width];
        let rows = [row.saturating_sub(1), row, (row + 1).min(self.height - 1)];
        Patch(rows.map(|r| columns.map(|c| luminance(self.texel(c, r).as_dvec3()))))
    }

    /// Density within a cell relative to the uniform density, at a distance in texels from its left border and a height
    /// cosθ.
    fn share(&self, column: usize, row: usize, x: f64, y: f64) -> f32 {
        if !self.filtered {
            return 1.0;
        }
        let (top, bottom) = (self.rows.cos[row], self.rows.cos[row + 1]);
        let down = ((top - y) / (top - bottom)).clamp(0.0, 1.0);
        self.patch(column, row).density((x, down)) as f32
    }

    /// Samples a direction. Within the cell it is uniform in azimuth and cosθ, that is, in solid angle; with filtering
    /// it follows the luminance between the texels (in cosθ as if it were θ). Without filtering the radiance is that of
    /// the selected cell, even if the direction rounds into its neighbour.
    fn sample(&self, table: &Grid2d, u: Vec2) -> Option<LightSample> {
        let chosen = table.sample(u);
        let (column, row) = (chosen.cell.0 as usize, chosen.cell.1 as usize);
        let mut at = (chosen.within.x as f64, chosen.within.y as f64);
        if self.filtered {
            at = self.patch(column, row).sample(at);
        }
        let (h, v) = at;
        let y = self.rows.cos[row] * (1.0 - v) + self.rows.cos[row + 1] * v;
        let sin = ((1.0 - y) * (1.0 + y)).max(0.0).sqrt();
        let phi = TAU * ((column as f64 + h) / self.width as f64 - 0.5 - self.shift);
        let wi = DVec3::new(sin * libm::sin(phi), y, -sin * libm::cos(phi)).as_vec3();
        let radiance = if self.filtered { self.radiance(wi) } else { self.texel(column, row) };
        let mut pdf = self.density(table, column, row);
        if self.filtered {
            // Position of the rounded direction, unless it rounds into a neighbour.
            let (c, r, within) = self.locate(wi);
            let (x, y) = if (c, r) == (column, row) { (within.x.into(), wi.y.into()) } else { (h, y) };
            pdf *= self.share(column, row, x, y);
        }
        let usable = pdf > 0.0 && pdf.is_finite();
        usable.then_some(LightSample {
            wi,
            pdf,
            delta: false,
            radiance,
            distance: f32::INFINITY,
            point: None,
        })
    }
}

/// Rec.709 luminance.
fn luminance(c: DVec3) -> f64 {
    c.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// An invalid texel of an environment map: negative, infinite or not a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BadTexel {
    /// Column from the left.
    pub x: usize,
    /// Row from the top.
    pub y: usize,
    /// Value of the texel in the image.
    pub value: Vec3,
}
impl fmt::Display for BadTexel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { x, y, value } = self;
        write!(
            f,
            "texel ({x}, {y}) of the environment is {value}: every texel must be finite and not negative, \
             also after multiplication by the intensity"
        )
    }
}
impl std::error::Error for BadTexel {}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: usize, height: usize, f: impl Fn(usize, usize) -> f32) -> Image {
        let pixels = (0..width * height).map(|i| Vec3::splat(f(i % width, i / width))).collect();
        Image { width, height, pixels }
    }

    #[test]
    fn directions_meet_the_texels_they_should() {
        let numbered = |rotation| {
            Environment::picture(picture(4, 2, |x, y| (y * 4 + x) as f32), rotation, 1.0, false).unwrap()
        };
        let env = numbered(0.0);
        let at = |env: &Environment, x: f32, y: f32, z: f32| env.radiance(Vec3::new(x, y, z).normalize()).x;
        assert_eq!(at(&env, 0.1, 0.1, -1.0), 2.0, "−Z is the centre, and +X is to its right");
        assert_eq!(at(&env, 1.0, 0.1, 0.1), 3.0);
        assert_eq!(at(&env, -1.0, -0.1, -0.1), 5.0);
        assert_eq!(at(&env, -0.1, 1.0, 0.1), 0.0);
        // A quarter turn: what was at −Z is now at −X.
        let turned = numbered(std::f32::consts::FRAC_PI_2);
        assert_eq!(at(&turned, -1.0, 0.1, -0.1), at(&env, 0.1, 0.1, -1.0));
        for pole in [Vec3::Y, Vec3::NEG_Y, Vec3::NAN] {
            assert!(env.radiance(pole).is_finite() && env.pdf(pole).is_finite());
        }
    }

    #[test]
    fn bad_texels_are_named() {
        for bad in [f32::NAN, f32::INFINITY, -1.0] {
            let p = picture(4, 3, |x, y| if (x, y) == (2, 1) { bad } else { 1.0 });
            let error = Environment::picture(p, 0.0, 1.0, false).unwrap_err();
            assert_eq!((error.x, error.y), (2, 1));
            assert!(error.to_string().contains("(2, 1)"));
        }
        assert!(Environment::picture(picture(2, 2, |_, _| 1e30), 0.0, 1e30, false).is_err());
    }

    #[test]
    fn one_colour_is_constant_and_empty_is_black() {
        let env = Environment::picture(picture(8, 4, |_, _| 3.0), 1.0, 2.0, false).unwrap();
        assert!(env.is_constant() && !env.is_sampled());
        assert_eq!((env.mean(), env.pdf(Vec3::Y)), (Vec3::splat(6.0), 0.0));
        assert!(env.sample(Vec2::splat(0.5)).is_none());
        let empty = Environment::picture(picture(0, 0, |_, _| 0.0), 0.0, 1.0, false).unwrap();
        assert_eq!(empty.radiance(Vec3::X), Vec3::ZERO);
    }

    #[test]
    fn filtering_meets_the_texels_at_their_centres_and_wraps() {
        let env = Environment::picture(picture(8, 4, |x, y| (x + 8 * y) as f32), 0.0, 1.0, true).unwrap();
        let Kind::LatLong(map) = &env.0 else { panic!("not an environment map") };
        assert_eq!(map.bilinear(3, 2, Vec2::splat(0.5)).x, 19.0);
        assert_eq!(map.bilinear(3, 2, Vec2::new(0.0, 0.5)).x, 18.5);
        assert_eq!(map.bilinear(0, 2, Vec2::new(0.0, 0.5)).x, 0.5 * (16.0 + 23.0));
        assert_eq!(map.bilinear(3, 0, Vec2::new(0.5, 0.0)).x, 3.0);
    }
}
