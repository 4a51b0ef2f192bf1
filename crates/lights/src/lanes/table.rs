//! The lights of a scene as a table that lanes read, each lane its own light.
use super::disk::Disk;
use super::flat::{Flat, Record};
use super::others::{densities, sampled};
use super::point::{Point, Shone, Spot};
use super::receiver::{Hit, Receiver};
use super::rectangle::Rectangle;
use super::sample::Sample;
use super::sphere::Sphere;
use super::triangle::Triangle;
use crate::area::Prepared;
use crate::{Area, Environment, Light};
use dapple_math::lanes::{Mask, Real, Vec2x, Vec3x, Word};
use glam::Vec3;

/// What a record describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// A quad with right angles.
    Rectangle,
    /// A triangle of uniform emission.
    Triangle,
    /// A sphere.
    Sphere,
    /// A disk.
    Disk,
    /// A point light.
    Point,
    /// A spot light.
    Spot,
    /// A distant light.
    Distant,
    /// The environment.
    Environment,
    /// Any other light: moving or textured, or a skewed quad. Its lanes are computed one by one.
    Other,
}

/// Rows per light: those of its record, and one with radiance or intensity and the kind.
const ROWS: u32 = 5;

/// Records of the lights of a scene, by index.
#[derive(Clone, Debug)]
pub struct Table {
    rows: Vec<[f32; 4]>,
    /// The rows of the light, if there is only one.
    only: Option<[[f32; 4]; ROWS as usize]>,
    /// Index of the environment.
    environment: Option<usize>,
    /// Bit k is set if a light has kind k.
    kinds: u32,
}

impl Table {
    /// Computes the records of `lights`.
    pub fn new(lights: &[Light]) -> Self {
        let environment = lights.iter().position(|light| matches!(light, Light::Environment(_)));
        let rows = Vec::with_capacity(lights.len() * ROWS as usize);
        let mut this = Self { rows, only: None, environment, kinds: 0 };
        for light in lights {
            let (kind, record, emission) = described(light);
            this.kinds |= 1 << kind as u32;
            this.rows.extend(record);
            this.rows.push([emission.x, emission.y, emission.z, f32::from(kind as u8)]);
        }
        this.only = (&*this.rows).try_into().ok();
        this
    }

    /// Memory use in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.rows)
    }

    /// Whether a light has this kind.
    #[inline(always)]
    fn has(&self, kind: Kind) -> bool {
        self.kinds >> kind as u32 & 1 == 1
    }

    #[inline(always)]
    fn environment<'a>(&self, lights: &'a [Light]) -> Option<&'a Environment> {
        match lights.get(self.environment?) {
            Some(Light::Environment(environment)) => Some(environment),
            _ => None,
        }
    }

    #[inline(always)]
    fn row<R: Real>(&self, index: R::Word, row: u32) -> [R; 4] {
        if let Some(rows) = &self.only {
            let [a, b, c, d] = rows[row as usize % ROWS as usize];
            return [R::splat(a), R::splat(b), R::splat(c), R::splat(d)];
        }
        let index = index.wrapping_mul(R::Word::splat(ROWS)).wrapping_add(R::Word::splat(row));
        R::gather_rows(&self.rows, index)
    }

    #[inline(always)]
    fn flat<R: Real>(&self, index: R::Word) -> Flat<R> {
        Flat::new([self.row(index, 0), self.row(index, 1), self.row(index, 2), self.row(index, 3)])
    }

    #[inline(always)]
    fn sphere<R: Real>(&self, index: R::Word) -> Sphere<R> {
        let [[x, y, z, radius], [two_sided, ..]] = [self.row::<R>(index, 0), self.row(index, 1)];
        Sphere { centre: Vec3x::new(x, y, z), radius, two_sided: two_sided.gt(R::splat(0.0)) }
    }

    /// Samples a direction from `p` towards light number `index` with `u` in \[0, 1)², as [`Light::sample`] does, for
    /// the lanes of `active`; the density of the others is 0. `lights` are those of which the table was built, and
    /// `time` is in seconds after the shutter opened.
    #[inline(always)]
    pub fn sample<R: Real>(
        &self,
        lights: &[Light],
        active: R::Mask,
        index: R::Word,
        from: Receiver<R>,
        u: Vec2x<R>,
    ) -> Sample<R> {
        let [x, y, z, kind] = self.row::<R>(index, 4);
        let (p, emission) = (from.p, Vec3x::new(x, y, z));
        let mut sample = Sample::none();
        let of = Kinds { kind, active };
        if of.any(self, Kind::Rectangle) {
            let aimed = Rectangle(self.flat(index)).sample(p, u);
            let place = aimed.quad_barycentrics();
            sample = Sample::select(of.mask(Kind::Rectangle), Sample::area(aimed, place, emission), sample);
        }
        let zero = R::splat(0.0);
        if of.any(self, Kind::Triangle) {
            let aimed = Triangle(self.flat(index)).sample(p, u);
            let place = [zero, aimed.s, aimed.t];
            sample = Sample::select(of.mask(Kind::Triangle), Sample::area(aimed, place, emission), sample);
        }
        if of.any(self, Kind::Sphere) {
            let aimed = self.sphere(index).sample(p, u);
            sample = Sample::select(of.mask(Kind::Sphere), Sample::area(aimed, [zero; 3], emission), sample);
        }
        if of.any(self, Kind::Disk) {
            let aimed = Disk(self.flat(index)).sample(p, u);
            sample = Sample::select(of.mask(Kind::Disk), Sample::area(aimed, [zero; 3], emission), sample);
        }
        sample = self.delta(of, index, p, emission, sample);
        if let (true, Some(environment)) = (of.any(self, Kind::Environment), self.environment(lights)) {
            sample = Sample::select(of.mask(Kind::Environment), environment.sample_lanes(u), sample);
        }
        let other = of.mask(Kind::Other);
        if self.has(Kind::Other) && other.any() {
            sample = sampled(lights, other, index, from, u, sample);
        }
        sample
    }

    /// Replaces the lanes of lights without extent.
    #[inline(always)]
    fn delta<R: Real>(
        &self,
        of: Kinds<R>,
        index: R::Word,
        p: Vec3x<R>,
        emission: Vec3x<R>,
        mut sample: Sample<R>,
    ) -> Sample<R> {
        if of.any(self, Kind::Point) {
            let shone = self.point(index, emission).sample(p);
            sample = Sample::select(of.mask(Kind::Point), Sample::delta(shone), sample);
        }
        if of.any(self, Kind::Spot) {
            let point = self.point(index, emission);
            let [[x, y, z, inner], [outer, ..]] = [self.row::<R>(index, 1), self.row(index, 2)];
            let shone = Spot { point, axis: Vec3x::new(x, y, z), inner, outer }.sample(p);
            sample = Sample::select(of.mask(Kind::Spot), Sample::delta(shone), sample);
        }
        if of.any(self, Kind::Distant) {
            let [x, y, z, _] = self.row::<R>(index, 0);
            let (wi, distance) = (Vec3x::new(x, y, z), R::splat(f32::INFINITY));
            let shone = Shone { wi, distance, irradiance: emission, reaches: R::Mask::splat(true) };
            sample = Sample::select(of.mask(Kind::Distant), Sample::delta(shone), sample);
        }
        sample
    }

    #[inline(always)]
    fn point<R: Real>(&self, index: R::Word, intensity: Vec3x<R>) -> Point<R> {
        let [x, y, z, range] = self.row::<R>(index, 0);
        Point { p: Vec3x::new(x, y, z), intensity, range }
    }

    /// Solid-angle density with which [`Table::sample`] samples the unit direction `wi`, which hits light number
    /// `index` at `distance` with the normal `n`, as [`Light::pdf`] gives it. Lanes outside of `active` are 0.
    #[inline(always)]
    pub fn pdf<R: Real>(
        &self,
        lights: &[Light],
        active: R::Mask,
        index: R::Word,
        from: Receiver<R>,
        hit: Hit<R>,
    ) -> R {
        let [.., kind] = self.row::<R>(index, 4);
        let of = Kinds { kind, active };
        let (p, distance, mut pdf) = (from.p, hit.distance, R::splat(0.0));
        if of.any(self, Kind::Rectangle) {
            let here = Rectangle(self.flat(index)).pdf(p, distance);
            pdf = R::select(of.mask(Kind::Rectangle), here, pdf);
        }
        if of.any(self, Kind::Triangle) {
            let here = Triangle(self.flat(index)).pdf(p, distance);
            pdf = R::select(of.mask(Kind::Triangle), here, pdf);
        }
        if of.any(self, Kind::Sphere) {
            pdf = R::select(of.mask(Kind::Sphere), self.sphere(index).pdf(p), pdf);
        }
        if of.any(self, Kind::Disk) {
            pdf = R::select(of.mask(Kind::Disk), Disk(self.flat(index)).pdf(p, distance), pdf);
        }
        if let (true, Some(environment)) = (of.any(self, Kind::Environment), self.environment(lights)) {
            pdf = R::select(of.mask(Kind::Environment), environment.pdf_lanes(hit.wi), pdf);
        }
        let other = of.mask(Kind::Other);
        if self.has(Kind::Other) && other.any() {
            pdf = densities(lights, other, index, from, hit, pdf);
        }
        pdf
    }
}

/// The kind of the light of each lane.
#[derive(Clone, Copy)]
struct Kinds<R: Real> {
    kind: R,
    active: R::Mask,
}

impl<R: Real> Kinds<R> {
    #[inline(always)]
    fn mask(self, kind: Kind) -> R::Mask {
        self.active & self.kind.eq(R::splat(f32::from(kind as u8)))
    }

    #[inline(always)]
    fn any(self, table: &Table, kind: Kind) -> bool {
        table.has(kind) && self.mask(kind).any()
    }
}

/// Kind, record, and radiance, intensity or irradiance of a light.
fn described(light: &Light) -> (Kind, Record, Vec3) {
    let row = |v: Vec3x<f32>, w: f32| [v.x, v.y, v.z, w];
    let rest = [0.0; 4];
    match light {
        Light::Area(area) => described_area(area),
        Light::Point(l) => {
            let point = l.lanes();
            (Kind::Point, [row(point.p, point.range), rest, rest, rest], l.intensity)
        }
        Light::Spot(l) => {
            let Spot { point, axis, inner, outer } = l.lanes();
            let rows = [row(point.p, point.range), row(axis, inner), [outer, 0.0, 0.0, 0.0], rest];
            (Kind::Spot, rows, l.intensity)
        }
        Light::Distant(l) => (Kind::Distant, [row(l.towards.into(), 0.0), rest, rest, rest], l.irradiance),
        Light::Environment(_) => (Kind::Environment, [rest; 4], Vec3::ZERO),
        Light::Patterned(_) | Light::Moving(_) => (Kind::Other, [rest; 4], Vec3::ZERO),
    }
}

fn described_area(area: &Area) -> (Kind, Record, Vec3) {
    let (kind, record) = match Prepared::of(area) {
        Prepared::Rectangle(l) => (Kind::Rectangle, l.0.record()),
        Prepared::Triangle(l) => (Kind::Triangle, l.0.record()),
        Prepared::Disk(l) => (Kind::Disk, l.0.record()),
        Prepared::Sphere(l) => {
            let (c, two_sided) = (l.centre, f32::from(l.two_sided));
            (Kind::Sphere, [[c.x, c.y, c.z, l.radius], [two_sided, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4]])
        }
        Prepared::Skewed { .. } => (Kind::Other, [[0.0; 4]; 4]),
    };
    (kind, record, area.radiance)
}
