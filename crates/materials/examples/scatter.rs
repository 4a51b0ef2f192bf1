//! Scatters light at many points of one kind of surface with one lane, and with the fastest lanes of this machine.
//! `cargo run --release --example scatter -p dapple-materials`

use dapple_materials::Material;
use dapple_materials::lanes::{Bsdf, Columns, Kind, Lambert, Layers, Parameters, face};
use dapple_math::lanes::{Isa, Kernel, Real, Vec2x, Vec3x, Word, dispatch};
use glam::Vec3;
use std::time::Instant;

const N: usize = 1024;

/// Arguments and results of one vertex per place: the value towards a light, and a sampled direction with its weight.
struct Batch {
    columns: Columns,
    wo: [Vec<f32>; 3],
    light: [Vec<f32>; 3],
    u: [Vec<f32>; 3],
    value: [Vec<f32>; 3],
    wi: [Vec<f32>; 3],
    weight: [Vec<f32>; 3],
}

#[derive(Clone, Copy)]
enum Surface {
    Diffuse,
    Opaque,
    Clear,
}

struct Scatter<'a>(&'a mut Batch, Surface);

impl Kernel for Scatter<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        for i in (0..N).step_by(R::LANES) {
            let parameters: Parameters<R> = self.0.columns.load(i);
            let (wo, side) = face(load::<R>(&self.0.wo, i));
            match self.1 {
                Surface::Diffuse => scatter(self.0, i, &Bsdf::new((wo, side), Lambert::new(&parameters))),
                Surface::Opaque => {
                    scatter(self.0, i, &Bsdf::new((wo, side), Layers::opaque(&parameters, wo, None)));
                }
                Surface::Clear => {
                    scatter(self.0, i, &Bsdf::new((wo, side), Layers::new(&parameters, wo, side, None)));
                }
            }
        }
    }
}

#[inline(always)]
fn scatter<R: Real, K: Kind<R>>(batch: &mut Batch, i: usize, bsdf: &Bsdf<R, K>) {
    let (light, all) = (load(&batch.light, i), R::Word::splat(0xff));
    let (f, pdf) = bsdf.eval(light, all);
    let [uc, x, y] = &batch.u;
    let sample = bsdf.sample_f(R::load(&uc[i..]), Vec2x::load([&x[i..], &y[i..]]), all);
    store(f * pdf, &mut batch.value, i);
    store(sample.wi, &mut batch.wi, i);
    store(sample.weight, &mut batch.weight, i);
}

#[inline(always)]
fn load<R: Real>([x, y, z]: &[Vec<f32>; 3], i: usize) -> Vec3x<R> {
    Vec3x::load([&x[i..], &y[i..], &z[i..]])
}

#[inline(always)]
fn store<R: Real>(v: Vec3x<R>, [x, y, z]: &mut [Vec<f32>; 3], i: usize) {
    v.store([&mut x[i..], &mut y[i..], &mut z[i..]]);
}

/// The same numbers in 0..1 for every run.
fn uniform(k: usize) -> [Vec<f32>; 3] {
    [3571, 2927, 5477].map(|p| (0..N).map(|i| (((i + k) * p) % 8191) as f32 / 8192.0).collect())
}

fn directions(k: usize, sphere: bool) -> [Vec<f32>; 3] {
    let [z, phi, _] = uniform(k);
    let all = z.iter().zip(phi).map(|(&z, phi)| {
        let z = if sphere { 2.0 * z - 1.0 } else { z.max(1e-3) };
        Vec3::new(phi - 0.5, 0.3, 0.0).normalize() * (1.0 - z * z).sqrt() + Vec3::Z * z
    });
    let all: Vec<Vec3> = all.collect();
    [0, 1, 2].map(|k| all.iter().map(|d| d[k]).collect())
}

fn main() {
    let plastic =
        Material { metallic: 0.0, roughness: 0.4, base_color: Vec3::splat(0.7), ..Material::default() };
    let cases = [
        ("diffuse", Surface::Diffuse, plastic),
        ("plastic", Surface::Opaque, plastic),
        ("metal", Surface::Opaque, Material { metallic: 1.0, ..plastic }),
        ("glass", Surface::Clear, Material { transmission: 1.0, thin: false, ..plastic }),
        ("pane", Surface::Clear, Material { transmission: 1.0, thin: true, ..plastic }),
    ];
    for (name, surface, material) in cases {
        let mut columns = Columns::new(N);
        (0..N).for_each(|i| columns.set(i, &material));
        let clear = matches!(surface, Surface::Clear);
        let none = [vec![0.0; N], vec![0.0; N], vec![0.0; N]];
        let (value, wi, weight) = (none.clone(), none.clone(), none);
        let (wo, light) = (directions(0, false), directions(7, clear));
        let mut batch = Batch { columns, wo, light, u: uniform(3), value, wi, weight };
        let results = [Isa::Portable, Isa::fastest()].map(|isa| {
            dispatch(isa, Scatter(&mut batch, surface));
            let start = Instant::now();
            for _ in 0..500 {
                dispatch(isa, Scatter(&mut batch, surface));
            }
            let ns = start.elapsed().as_secs_f64() * 1e9 / (500 * N) as f64;
            println!("{name:8} {:9} {:2} lanes  {ns:6.2} ns per vertex", isa.name(), isa.lanes());
            [&batch.value, &batch.weight].map(|v| v.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>())
        });
        assert!(results[0] == results[1], "all lanes give the same bits");
    }
}
