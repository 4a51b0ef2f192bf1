//! Vectors and frames over lanes: the bits of glam and of `Frame`, with every instruction set.

use dapple_math::Frame;
use dapple_math::glam::{Vec2, Vec3};
use dapple_math::lanes::{Framex, Isa, Kernel, Mask, Real, Vec2x, Vec3x, dispatch};
use dapple_testkit::Rng;

const RESULTS: usize = 40;

/// All operations on the vectors a and b, one row of results per pair.
struct All<'a> {
    a: [&'a [f32]; 3],
    b: [&'a [f32]; 3],
    out: &'a mut [[f32; RESULTS]],
}

impl Kernel for All<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        for i in (0..self.out.len()).step_by(R::LANES) {
            let a = Vec3x::<R>::load(self.a.map(|c| &c[i..]));
            let b = Vec3x::<R>::load(self.b.map(|c| &c[i..]));
            let k = a.x;
            let frame = Framex::from_z(a.normalize());
            let nearer = Vec3x::select(a.x.lt(b.x), a, b);
            let vectors = [
                a + b,
                a - b,
                a * b,
                a * k,
                a / k,
                -a,
                a.cross(b),
                a.normalize(),
                a.reflect(b.normalize()),
                nearer,
                frame.to_local(b),
                frame.to_world(b),
            ];
            let (p, q) = (Vec2x::new(a.x, a.y), Vec2x::new(b.x, b.y));
            let numbers =
                [a.dot(b), a.length(), a.max_element(), p.perp_dot(q) + p.dot(q) * (p / k - q).length()];
            let mut lane = [0.0; 16];
            for (column, x) in vectors.into_iter().flat_map(|v| [v.x, v.y, v.z]).chain(numbers).enumerate() {
                x.store(&mut lane);
                for (row, x) in self.out[i..].iter_mut().zip(lane).take(R::LANES) {
                    row[column] = x;
                }
            }
        }
    }
}

fn with_glam(a: Vec3, b: Vec3) -> [f32; RESULTS] {
    let k = a.x;
    let frame = Frame::from_z(a.normalize());
    let vectors = [
        a + b,
        a - b,
        a * b,
        a * k,
        a / k,
        -a,
        a.cross(b),
        a.normalize(),
        a.reflect(b.normalize()),
        if a.x < b.x { a } else { b },
        frame.to_local(b),
        frame.to_world(b),
    ];
    let (p, q) = (Vec2::new(a.x, a.y), Vec2::new(b.x, b.y));
    let numbers = [a.dot(b), a.length(), a.max_element(), p.perp_dot(q) + p.dot(q) * (p / k - q).length()];
    let all: Vec<f32> = vectors.into_iter().flat_map(|v| v.to_array()).chain(numbers).collect();
    all.try_into().unwrap()
}

#[test]
fn vectors_round_as_those_of_glam() {
    let mut rng = Rng::new(2);
    let n = 10_007;
    let mut column = || -> Vec<f32> { (0..n).map(|_| rng.f32() * 4.0 - 2.0).collect() };
    let (a, b) = ([column(), column(), column()], [column(), column(), column()]);
    for isa in Isa::available() {
        let mut out = vec![[0.0; RESULTS]; n];
        dispatch(isa, All { a: [&a[0], &a[1], &a[2]], b: [&b[0], &b[1], &b[2]], out: &mut out });
        for (i, row) in out.iter().enumerate() {
            let at = |v: &[Vec<f32>; 3]| Vec3::new(v[0][i], v[1][i], v[2][i]);
            let expected = with_glam(at(&a), at(&b));
            assert_eq!(
                row.map(f32::to_bits),
                expected.map(f32::to_bits),
                "{} {} {}",
                isa.name(),
                at(&a),
                at(&b)
            );
        }
    }
}

/// Columns in, the vectors above the plane z = 0 out, packed.
struct Above<'a>([&'a [f32]; 3], [&'a mut [f32]; 3]);

impl Kernel for Above<'_> {
    type Output = usize;
    #[inline(always)]
    fn run<R: Real>(self) -> usize {
        let (from, [x, y, z]) = (self.0, self.1);
        let mut at = 0;
        for i in (0..from[0].len()).step_by(R::LANES) {
            let v = Vec3x::<R>::load([&from[0][i..], &from[1][i..], &from[2][i..]]);
            let inside = R::Mask::first(from[0].len() - i);
            let keep = v.z.gt(R::splat(0.0)) & v.is_finite() & inside;
            at += v.compress_store(keep, [&mut x[at..], &mut y[at..], &mut z[at..]]);
        }
        at
    }
}

#[test]
fn vectors_are_packed_in_order() {
    let mut rng = Rng::new(9);
    let mut column = || -> Vec<f32> { (0..1003).map(|_| rng.f32() - 0.5).collect() };
    let (x, y, mut z) = (column(), column(), column());
    z[77] = f32::INFINITY;
    let kept: Vec<usize> = (0..1003).filter(|&i| z[i] > 0.0 && z[i].is_finite()).collect();
    for isa in Isa::available() {
        let mut to = [vec![0.0; 1003], vec![0.0; 1003], vec![0.0; 1003]];
        let [a, b, c] = &mut to;
        let n = dispatch(isa, Above([&x, &y, &z], [a, b, c]));
        assert_eq!(n, kept.len());
        for (from, to) in [&x, &y, &z].into_iter().zip(&to) {
            assert!(kept.iter().zip(to).all(|(&i, &got)| from[i] == got));
        }
    }
}
