//! The formulas over lanes: the same bits with every instruction set, on random and on special arguments.

use dapple_materials::lanes::{
    self, AlbedoRow, Bsdf, Columns, Ggx, Kind, Lambert, Layers, Mirrored, Parameters, Sample,
};
use dapple_materials::{Lobe, Lobes, Material};
use dapple_math::lanes::{Isa, Kernel, Real, Vec2x, Vec3x, Word, dispatch};
use dapple_testkit::Rng;
use glam::Vec3;

/// Rows per test; not a multiple of the number of lanes.
const ROWS: usize = 4099;
/// Places per row of results.
const RESULTS: usize = 40;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Body {
    Lambert,
    Opaque,
    Any,
    Sharp,
    Mirrored,
}

/// Arguments in columns.
struct Rows {
    columns: Columns,
    materials: Vec<Material>,
    wo: [Vec<f32>; 3],
    wi: [Vec<f32>; 3],
    /// uc, u, and the cosine of the energy loss.
    u: [Vec<f32>; 4],
    lobes: Vec<u32>,
}

/// Value, density, sample and properties of one kind of surface.
struct Evaluate<'a> {
    rows: &'a Rows,
    body: Body,
    out: &'a mut [[u32; RESULTS]],
}

/// Writes numbers and words of every lane to the rows from `i` on.
struct Writer<'a> {
    rows: &'a mut [[u32; RESULTS]],
    at: usize,
}

impl Writer<'_> {
    #[inline(always)]
    fn word<R: Real>(&mut self, word: R::Word) {
        let mut lanes = [0; 16];
        word.store(&mut lanes);
        for (row, bits) in self.rows.iter_mut().zip(lanes).take(R::LANES) {
            row[self.at] = bits;
        }
        self.at += 1;
    }

    /// Zeros and NaN of both signs count as equal.
    #[inline(always)]
    fn number<R: Real>(&mut self, x: R) {
        let x = x + R::splat(0.0);
        self.word::<R>(R::Word::select(x.eq(x), x.to_bits(), R::Word::splat(0x7fc0_0000)));
    }

    #[inline(always)]
    fn vector<R: Real>(&mut self, v: Vec3x<R>) {
        self.number(v.x);
        self.number(v.y);
        self.number(v.z);
    }

    #[inline(always)]
    fn sample<R: Real>(&mut self, sample: &Sample<R>) {
        let none = Vec3x::splat(Vec3::ZERO);
        self.vector(Vec3x::select(sample.exists(), sample.wi, none));
        self.vector(sample.weight);
        self.number(sample.pdf);
        self.word::<R>(sample.lobe);
        self.number(sample.eta);
    }

    #[inline(always)]
    fn bsdf<R: Real, K: Kind<R>>(&mut self, bsdf: &Bsdf<R, K>, rows: &Rows, i: usize) {
        let wi = load(&rows.wi, i);
        let [uc, x, y, _] = &rows.u;
        let u = Vec2x::load([&x[i..], &y[i..]]);
        for lobes in [R::Word::load(&rows.lobes[i..]), R::Word::splat(0xff)] {
            let (f, pdf) = bsdf.eval(wi, lobes);
            self.vector(f);
            self.number(pdf);
            self.sample(&bsdf.sample_f(R::load(&uc[i..]), u, lobes));
        }
        self.word::<R>(bsdf.lobes());
    }

    #[inline(always)]
    fn layers<R: Real>(&mut self, layers: &Layers<R>, wo: Vec3x<R>) {
        self.vector(layers.albedo(wo.z));
        self.vector(layers.straight(wo));
        self.vector(layers.straightened(wo.z));
    }
}

#[inline(always)]
fn load<R: Real>(columns: &[Vec<f32>; 3], i: usize) -> Vec3x<R> {
    Vec3x::load([&columns[0][i..], &columns[1][i..], &columns[2][i..]])
}

impl Kernel for Evaluate<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let rows = self.rows;
        for i in (0..ROWS).step_by(R::LANES) {
            let parameters: Parameters<R> = rows.columns.load(i);
            let (wo, side) = lanes::face(load::<R>(&rows.wo, i));
            let mut writer = Writer { rows: &mut self.out[i..], at: 0 };
            match self.body {
                Body::Lambert => writer.bsdf(&Bsdf::new((wo, side), Lambert::new(&parameters)), rows, i),
                Body::Opaque => {
                    let layers = Layers::opaque(&parameters, wo, None);
                    writer.bsdf(&Bsdf::new((wo, side), layers), rows, i);
                    writer.layers(&layers, wo);
                }
                Body::Any => {
                    let layers = Layers::new(&parameters, wo, side, Some(R::load(&rows.u[3][i..])));
                    writer.bsdf(&Bsdf::new((wo, side), layers), rows, i);
                    writer.layers(&layers, wo);
                }
                Body::Sharp => {
                    let sharp = Lobes::of(Lobe::GlossyReflection);
                    let layers = Layers::new(&parameters, wo, side, None).sharp(wo.z, sharp);
                    writer.bsdf(&Bsdf::new((wo, side), layers), rows, i);
                    writer.layers(&layers, wo);
                }
                Body::Mirrored => {
                    let mirror = Mirrored::new(parameters.base_color, parameters.roughness, wo);
                    writer.bsdf(&Bsdf::new((wo, side), mirror), rows, i);
                }
            }
        }
    }
}

const ODD: [f32; 12] =
    [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e-40, 1e-4, 1.0, 1.0 + 1e-7, 1.5, 1e3, 1e30, 0.5];

/// Mostly plain numbers, sometimes special ones.
fn number(rng: &mut Rng, plain: [f32; 4]) -> f32 {
    match rng.below(8) {
        0 => ODD[rng.below(12) as usize],
        1..4 => rng.f32(),
        k => plain[k as usize & 3],
    }
}

fn material(rng: &mut Rng) -> Material {
    Material {
        base_color: Vec3::new(rng.f32(), number(rng, [0.0, 1.0, 0.5, 0.5]), rng.f32()),
        metallic: number(rng, [0.0, 0.0, 1.0, 1.0]),
        roughness: number(rng, [0.0, 0.3, 0.5, 1.0]),
        ior: number(rng, [1.5, 1.5, 1.0, 0.0]),
        specular: number(rng, [1.0, 1.0, 1.0, 0.0]),
        specular_color: Vec3::new(rng.f32(), 1.0, number(rng, [1.0; 4])),
        transmission: number(rng, [0.0, 0.0, 1.0, 1.0]),
        thin: rng.f32() < 0.5,
        ..Material::default()
    }
}

fn direction(rng: &mut Rng) -> Vec3 {
    let z = [1.0, -1.0, 0.0, 1e-20, 1e-3, -1e-6];
    match rng.below(16) {
        0 => Vec3::splat(f32::NAN),
        1 => Vec3::new(0.6, 0.8, z[rng.below(6) as usize]).normalize(),
        2 => Vec3::Z * z[rng.below(2) as usize],
        _ => rng.direction().as_vec3(),
    }
}

fn rows(seed: u64) -> Rows {
    let mut rng = Rng::new(seed);
    let materials: Vec<Material> = (0..ROWS).map(|_| material(&mut rng)).collect();
    let mut columns = Columns::new(ROWS);
    for (i, material) in materials.iter().enumerate() {
        columns.set(i, material);
    }
    let mut directions = || {
        let all: Vec<Vec3> = (0..ROWS).map(|_| direction(&mut rng)).collect();
        [0, 1, 2].map(|k| all.iter().map(|d| d[k]).collect::<Vec<f32>>())
    };
    let (wo, wi) = (directions(), directions());
    let top = 1.0 - f32::EPSILON / 2.0;
    let mut uniform =
        || (0..ROWS).map(|_| [0.0, top, 0.5, rng.f32(), rng.f32()][rng.below(5) as usize]).collect();
    let u = [uniform(), uniform(), uniform(), uniform()];
    let lobes = (0..ROWS).map(|_| [0xff, 0xff, rng.below(64)][rng.below(3) as usize]).collect();
    Rows { columns, materials, wo, wi, u, lobes }
}

#[test]
fn all_instruction_sets_give_the_same_bits() {
    for body in [Body::Lambert, Body::Opaque, Body::Any, Body::Sharp, Body::Mirrored] {
        let rows = rows(body as u64 + 1);
        let run = |isa| {
            let mut out = vec![[0; RESULTS]; ROWS];
            dispatch(isa, Evaluate { rows: &rows, body, out: &mut out });
            out
        };
        let portable = run(Isa::Portable);
        for isa in Isa::available() {
            for (i, (a, b)) in portable.iter().zip(run(isa)).enumerate() {
                let at = |c: &[Vec<f32>; 3]| Vec3::new(c[0][i], c[1][i], c[2][i]);
                assert_eq!(
                    a,
                    &b,
                    "{body:?}, {}, row {i}: {:?}, wo {}, wi {}",
                    isa.name(),
                    rows.materials[i],
                    at(&rows.wo),
                    at(&rows.wi)
                );
            }
        }
    }
}

/// The scalar BSDF is the instance of one lane, whatever the kind of its material.
#[test]
fn one_lane_is_the_scalar_bsdf() {
    let rows = rows(9);
    let mut out = vec![[0; RESULTS]; ROWS];
    dispatch(Isa::fastest(), Evaluate { rows: &rows, body: Body::Any, out: &mut out });
    for (i, row) in out.iter().enumerate() {
        let at = |c: &[Vec<f32>; 3]| Vec3::new(c[0][i], c[1][i], c[2][i]);
        let material = &rows.materials[i];
        let bsdf = dapple_materials::Bsdf::losing_as(material, at(&rows.wo), Some(rows.u[3][i]));
        let (f, pdf) = bsdf.eval(at(&rows.wi), Lobes::ALL);
        let values = [f.x, f.y, f.z, pdf].map(|x| (x + 0.0).to_bits());
        let expected = &row[13..17];
        assert!(values == expected, "{material:?}: {f} {pdf}");
        let sample = bsdf.sample_f(rows.u[0][i], glam::Vec2::new(rows.u[1][i], rows.u[2][i]), Lobes::ALL);
        assert_eq!(sample.map_or(0, |s| u32::from(Lobes::of(s.lobe).0)), row[24], "{material:?}: {sample:?}");
        assert_eq!(sample.map_or(0.0, |s| s.pdf).to_bits(), row[23], "{material:?}: {sample:?}");
    }
}

/// Ggx, its samples, and the albedo table.
struct Parts<'a> {
    rows: &'a Rows,
    out: &'a mut [[u32; RESULTS]],
}

impl Kernel for Parts<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        for i in (0..ROWS).step_by(R::LANES) {
            let mut writer = Writer { rows: &mut self.out[i..], at: 0 };
            let wo = load::<R>(&self.rows.wo, i);
            let [alpha, x, y, c] = &self.rows.u;
            let (alpha, c) = (R::load(&alpha[i..]), R::load(&c[i..]));
            let ggx = Ggx::isotropic(alpha);
            let u = Vec2x::load([&x[i..], &y[i..]]);
            let (m, found) = ggx.sample_cap(wo, ggx.t(wo), u, ggx.cap_bound(wo));
            writer.vector(m);
            writer.word::<R>(R::Word::select(found, R::Word::splat(1), R::Word::splat(0)));
            writer.number(ggx.d(m));
            writer.number(ggx.g1(wo));
            writer.number(ggx.visible_pdf(wo, m, c));
            writer.number(ggx.bounded_pdf(wo, m, ggx.cap_bound(wo)));
            let row = AlbedoRow::new(alpha);
            for part in [row.at(c), row.mean()] {
                writer.number(part.c);
                writer.number(part.b);
            }
            let eta = u.x * R::splat(3.0);
            writer.number(lanes::dielectric(c, eta));
            let (ct, passes) = lanes::far_cosine(c, eta);
            writer.number(R::select(passes, ct, R::splat(0.0)));
            writer.vector(lanes::refract(wo, m, c, ct, eta));
            writer.vector(lanes::reflect(wo, m));
        }
    }
}

#[test]
fn the_parts_have_the_same_bits() {
    let rows = rows(3);
    let run = |isa| {
        let mut out = vec![[0; RESULTS]; ROWS];
        dispatch(isa, Parts { rows: &rows, out: &mut out });
        out
    };
    let portable = run(Isa::Portable);
    for isa in Isa::available() {
        assert!(portable == run(isa), "{}", isa.name());
    }
}
