//! Flat lights, one per lane: what depends on the light alone, and receivers close to its plane.
use super::aimed::Aimed;
use super::columns::{Columns, lane, lanes_of, stored, three};
use crate::aimed::SMALL;
use crate::polygon::{Facet, Outline};
use dapple_math::lanes::{Mask, Real, Vec2x, Vec3x};
use glam::{Vec2, Vec3};

/// A shape with everything that depends on it alone, as four rows of a table.
pub type Record = [[f32; 4]; 4];

/// A receiver is close to the plane of a light if its height over it, times this, is below its distance to a corner.
/// f32 then loses more than six bits of the height; such lanes are computed in f64.
const STEEP: f32 = 64.0;

/// Range of the distances to corners for which no intermediate result leaves f32.
const RANGE: [f32; 2] = [f32::from_bits((127 - 30) << 23), f32::from_bits((127 + 30) << 23)];

/// Least size of the complex number whose angle is half of the solid angle of a triangle: below it, where the receiver
/// is close to the line between two corners, sums of cosines cancel.
pub(super) const LEAST: f32 = 1.0 / 64.0;

/// One flat light per lane.
#[derive(Clone, Copy, Debug)]
pub struct Flat<R: Real> {
    /// First corner; of a disk, the centre.
    pub corner: Vec3x<R>,
    /// Edge along which the first coordinate runs.
    pub e1: Vec3x<R>,
    /// Edge along which the second coordinate runs.
    pub e2: Vec3x<R>,
    /// Unit normal of the front, e1×e2 divided by its length.
    pub n: Vec3x<R>,
    /// |e1×e2|: the area of the parallelogram.
    pub area: R,
    /// 1/|e1|.
    pub per_e1: R,
    /// 1/|e2|.
    pub per_e2: R,
    /// Whether the back emits as well.
    pub two_sided: R::Mask,
}

/// Computes in f64 what depends on a flat light alone.
pub(crate) fn flat(corner: Vec3, e1: Vec3, e2: Vec3, two_sided: bool) -> Flat<f32> {
    let (a, b) = (e1.as_dvec3(), e2.as_dvec3());
    let across = a.cross(b);
    let area = across.length();
    let n = (across / area).as_vec3();
    let (per_e1, per_e2) = ((1.0 / a.length()) as f32, (1.0 / b.length()) as f32);
    let (corner, e1, e2) = (corner.into(), e1.into(), e2.into());
    Flat { corner, e1, e2, n: n.into(), area: area as f32, per_e1, per_e2, two_sided }
}

/// Whether a light is sampled by area, because half of its solid angle, that of the complex number `cos` + i·`sin`, is
/// below half of [`SMALL`]. (The tangent of that is the number itself, to 10⁻⁷.)
#[inline(always)]
pub(super) fn is_small<R: Real>(sin: R, cos: R) -> R::Mask {
    sin.lt(cos * R::splat(0.5 * SMALL as f32))
}

impl Flat<f32> {
    /// The record of the light.
    pub(crate) fn record(&self) -> Record {
        let Self { corner: c, e1, e2, n, .. } = *self;
        [
            [c.x, c.y, c.z, self.area],
            [e1.x, e1.y, e1.z, self.per_e1],
            [e2.x, e2.y, e2.z, self.per_e2],
            [n.x, n.y, n.z, f32::from(self.two_sided)],
        ]
    }
}

impl<R: Real> Flat<R> {
    /// Builds the lights from the columns of their records.
    #[inline(always)]
    pub fn new(rows: [[R; 4]; 4]) -> Self {
        let [[cx, cy, cz, area], [ax, ay, az, per_e1], [bx, by, bz, per_e2], [nx, ny, nz, two_sided]] = rows;
        let (corner, e1, e2) = (Vec3x::new(cx, cy, cz), Vec3x::new(ax, ay, az), Vec3x::new(bx, by, bz));
        let two_sided = two_sided.gt(R::splat(0.0));
        Self { corner, e1, e2, n: Vec3x::new(nx, ny, nz), area, per_e1, per_e2, two_sided }
    }

    /// Whether a light emits towards a receiver at `height` over its plane, positive in front.
    #[inline(always)]
    pub(super) fn faces(&self, height: R) -> R::Mask {
        height.gt(R::splat(0.0)) | (self.two_sided & height.lt(R::splat(0.0)))
    }

    /// Where f32 is accurate, given the height over the plane and the largest distance to a corner or along an edge.
    #[inline(always)]
    pub(super) fn accurate(height: R, largest: R) -> R::Mask {
        (height.abs() * R::splat(STEEP)).ge(largest)
            & largest.ge(R::splat(RANGE[0]))
            & largest.le(R::splat(RANGE[1]))
    }

    /// Density per solid angle of uniform sampling in area at `distance`: distance²/(area·cosθ), with the cosine from
    /// the height over the plane; `area` is that of the shape.
    #[inline(always)]
    pub(super) fn area_pdf(distance: R, height: R, area: R) -> R {
        (distance / height.abs()) * (distance / area) * distance
    }

    /// The sample at the coordinates `s` and `t`, with the direction `to` (not normalised) and the distance given.
    #[inline(always)]
    pub(super) fn at(&self, s: R, t: R, to: Vec3x<R>, distance: R, pdf: R) -> Aimed<R> {
        let wi = to * (R::splat(1.0) / distance);
        let aimed = Aimed { wi, distance, pdf, p: self.corner, p_error: self.corner, n: self.n, s, t };
        self.placed(aimed)
    }

    /// Computes point and error bound from the coordinates. Four roundings along the edges, one of which is that of the
    /// edges themselves, and one of the sum.
    #[inline(always)]
    fn placed(&self, aimed: Aimed<R>) -> Aimed<R> {
        let eps = R::splat(f32::EPSILON);
        let p = self.corner + (self.e1 * aimed.s + self.e2 * aimed.t);
        let edges = self.e1.abs() + self.e2.abs();
        Aimed { p, p_error: (p.abs() + edges + edges) * eps, ..aimed }
    }

    /// Replaces the lanes of `mask` by samples computed in f64.
    #[inline(always)]
    pub(super) fn replaced(
        &self,
        mask: R::Mask,
        fast: Aimed<R>,
        p: Vec3x<R>,
        u: Vec2x<R>,
        how: How,
    ) -> Aimed<R> {
        if !mask.any() {
            return fast;
        }
        let mut columns = stored([fast.wi.x, fast.wi.y, fast.wi.z, fast.distance, fast.pdf, fast.s, fast.t]);
        let light = self.columns();
        sample_lanes(mask.bitmask(), &mut columns, &light, &three(p), &stored([u.x, u.y]), how);
        let [x, y, z, distance, pdf, s, t] = columns;
        let wi = Vec3x::load([&x, &y, &z]);
        let (distance, pdf) = (R::load(&distance), R::load(&pdf));
        self.placed(Aimed { wi, distance, pdf, s: R::load(&s), t: R::load(&t), ..fast })
    }

    /// Replaces the lanes of `mask` by densities computed in f64.
    #[inline(always)]
    pub(super) fn replaced_pdf(&self, mask: R::Mask, fast: R, p: Vec3x<R>, distance: R, how: How) -> R {
        if !mask.any() {
            return fast;
        }
        let [mut pdf, distance] = stored([fast, distance]);
        pdf_lanes(mask.bitmask(), &mut pdf, &self.columns(), &three(p), &distance, how);
        R::load(&pdf)
    }

    #[inline(always)]
    fn columns(&self) -> LightColumns {
        let Self { corner, e1, e2, two_sided, .. } = *self;
        LightColumns { corner: three(corner), e1: three(e1), e2: three(e2), two_sided: two_sided.bitmask() }
    }
}

/// How a shape is sampled.
#[derive(Clone, Copy)]
pub(super) struct How {
    pub outline: Outline,
    /// Uniformly in area instead of solid angle.
    pub by_area: bool,
}

struct LightColumns {
    corner: Columns<3>,
    e1: Columns<3>,
    e2: Columns<3>,
    two_sided: u32,
}

impl LightColumns {
    fn facet(&self, i: usize, p: &Columns<3>, outline: Outline) -> (Facet, bool) {
        let [corner, e1, e2] = [&self.corner, &self.e1, &self.e2].map(|columns| lane(columns, i));
        (Facet::edges(lane(p, i), corner, e1, e2, outline), self.two_sided >> i & 1 == 1)
    }
}

#[cold]
#[inline(never)]
fn sample_lanes(
    mask: u32,
    columns: &mut Columns<7>,
    light: &LightColumns,
    p: &Columns<3>,
    u: &Columns<2>,
    how: How,
) {
    for i in lanes_of(mask) {
        let (facet, two_sided) = light.facet(i, p, how.outline);
        let u = Vec2::new(u[0][i], u[1][i]);
        let spot = if how.by_area { facet.spot_in_area(u, two_sided) } else { facet.spot(u, two_sided) };
        columns[4][i] = 0.0;
        if let Some(spot) = spot {
            let (wi, at) = (spot.wi.as_vec3(), spot.at.as_vec2());
            let values = [wi.x, wi.y, wi.z, spot.distance as f32, spot.pdf as f32, at.x, at.y];
            columns.iter_mut().zip(values).for_each(|(column, value)| column[i] = value);
        }
    }
}

#[cold]
#[inline(never)]
fn pdf_lanes(mask: u32, pdf: &mut [f32], light: &LightColumns, p: &Columns<3>, distance: &[f32], how: How) {
    for i in lanes_of(mask) {
        let (facet, two_sided) = light.facet(i, p, how.outline);
        let exact = match how.by_area {
            true => facet.pdf_surface(distance[i], two_sided),
            false => facet.pdf(distance[i], two_sided),
        };
        pdf[i] = (exact as f32).min(f32::MAX);
    }
}
