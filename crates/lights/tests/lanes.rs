//! Formulas over lanes give the same bits with every instruction set, and those of the scalar types.
mod support;
use dapple_lights::lanes::{Chosen, Hit, Receiver, Table, probabilities};
use dapple_lights::{Area, AreaShape, Distant, Light, LightSampler, Point, Spot};
use dapple_math::lanes::{Isa, Kernel, Mask, Real, Vec2x, Vec3x, Word, dispatch};
use dapple_testkit::Rng;
use glam::{Vec2, Vec3};
use support::square;

/// Columns of inputs: index of the light, receiver, u.
#[derive(Default)]
struct Inputs {
    index: Vec<u32>,
    p: [Vec<f32>; 3],
    u: [Vec<f32>; 2],
}

impl Inputs {
    fn push(&mut self, index: usize, p: Vec3, u: Vec2) {
        self.index.push(index as u32);
        self.p.iter_mut().zip(p.to_array()).for_each(|(column, x)| column.push(x));
        self.u.iter_mut().zip(u.to_array()).for_each(|(column, x)| column.push(x));
    }

    fn at(&self, i: usize) -> (usize, Vec3, Vec2) {
        let p = Vec3::new(self.p[0][i], self.p[1][i], self.p[2][i]);
        (self.index[i] as usize, p, Vec2::new(self.u[0][i], self.u[1][i]))
    }
}

/// Samples every input; the columns of the output are those of the sample and the density of its direction.
struct SampleAll<'a> {
    table: &'a Table,
    lights: &'a [Light],
    inputs: &'a Inputs,
    out: &'a mut [Vec<f32>; 19],
}

impl Kernel for SampleAll<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let Self { table, lights, inputs, out } = self;
        let [x, y, z] = &inputs.p;
        for i in (0..inputs.index.len()).step_by(R::LANES) {
            let active = <R::Mask as Mask>::first(inputs.index.len() - i);
            let index = R::Word::load(&inputs.index[i..]);
            let from = Receiver { p: Vec3x::load([&x[i..], &y[i..], &z[i..]]), time: R::splat(0.0) };
            let u = Vec2x::load([&inputs.u[0][i..], &inputs.u[1][i..]]);
            let s = table.sample::<R>(lights, active, index, from, u);
            let hit = Hit { wi: s.wi, distance: s.distance, n: s.n };
            let pdf = table.pdf::<R>(lights, active, index, from, hit);
            let (zero, one) = (R::splat(0.0), R::splat(1.0));
            let (delta, point) = (R::select(s.delta, one, zero), R::select(s.has_point, one, zero));
            let (l, p, e, n) = (s.radiance, s.p, s.p_error, s.n);
            let values = [
                s.pdf, s.wi.x, s.wi.y, s.wi.z, delta, l.x, l.y, l.z, s.distance, point, p.x, p.y, p.z, e.x,
                n.z, s.triangle, s.u, s.v, pdf,
            ];
            for (column, value) in out.iter_mut().zip(values) {
                value.store(&mut column[i..]);
            }
        }
    }
}

fn lights() -> Vec<Light> {
    let area = |shape, two_sided| Light::Area(Area { shape, radiance: Vec3::new(1.0, 2.0, 3.0), two_sided });
    let (p, axis) = (Vec3::new(0.3, -0.4, 1.5), Vec3::new(0.36, 0.48, -0.8));
    let [a, b, c] = [Vec3::new(-1.0, 0.3, 0.5), Vec3::new(1.5, 0.1, 0.2), Vec3::new(0.2, 1.2, 1.5)];
    let spot = |outer| {
        let (inner, range) = (Spot::height(0.5 * outer), f32::INFINITY);
        Light::Spot(Spot { p, axis, intensity: Vec3::ONE, inner, outer: Spot::height(outer), range })
    };
    vec![
        area(square(1.0, 0.4, 0.0), false),
        area(square(0.01, 0.4, 2.0), true),
        area(AreaShape::Quad { corner: a, e1: axis, e2: axis.any_orthonormal_vector() * 3.0 }, true),
        area(AreaShape::Quad { corner: a, e1: b - a, e2: c - a }, true),
        area(AreaShape::Triangle([a, b, c]), true),
        area(AreaShape::Triangle([a, b, c].map(|p| p * 0.01)), false),
        area(AreaShape::Triangle([a, a, c]), true),
        area(AreaShape::Sphere { centre: p, radius: 0.7 }, true),
        area(AreaShape::Sphere { centre: p, radius: 0.01 }, false),
        area(AreaShape::Disk { centre: p, normal: axis, radius: 0.6 }, true),
        Light::Point(Point { p, intensity: Vec3::ONE, range: 4.0 }),
        spot(1.0),
        spot(0.01),
        Light::Distant(Distant { towards: axis, irradiance: Vec3::X }),
    ]
}

/// Receivers near and far, in planes and on surfaces of the lights, and not finite.
fn inputs(lights: usize) -> Inputs {
    let (mut inputs, mut rng) = (Inputs::default(), Rng::new(5));
    let special = [0.0, 1e-30, 0.5, 1.5, -1e4, 1e30, f32::MAX, f32::INFINITY, f32::NAN];
    for i in 0..60_000usize {
        let scale = [0.01, 1.0, 3.0, 100.0][i % 4];
        let mut p = rng.direction().as_vec3() * (scale * rng.f32());
        if i % 16 == 0 {
            p.z = special[i / 16 % special.len()];
        }
        if i % 160 == 0 {
            p.x = special[i / 160 % special.len()];
        }
        let u = rng.vec2();
        let u = if i % 50 == 0 { u.round().min(Vec2::splat(1.0 - f32::EPSILON / 2.0)) } else { u };
        inputs.push(rng.bits() as usize % lights, p, u);
    }
    inputs
}

fn run(isa: Isa, lights: &[Light], inputs: &Inputs) -> [Vec<f32>; 19] {
    let mut out = [(); 19].map(|()| vec![0.0; inputs.index.len()]);
    dispatch(isa, SampleAll { table: &Table::new(lights), lights, inputs, out: &mut out });
    out
}

fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let lights = lights();
    let inputs = inputs(lights.len());
    let portable = run(Isa::Portable, &lights, &inputs);
    for isa in Isa::available() {
        let other = run(isa, &lights, &inputs);
        for (k, (a, b)) in portable.iter().zip(&other).enumerate() {
            for (i, (a, b)) in a.iter().zip(b).enumerate() {
                assert!(same(*a, *b), "{}, column {k}, {:?}: {a:e} {b:e}", isa.name(), inputs.at(i));
            }
        }
    }
}

#[test]
fn the_table_has_the_lights() {
    let lights = lights();
    let inputs = inputs(lights.len());
    let out = run(Isa::fastest(), &lights, &inputs);
    let mut found = 0;
    for i in 0..inputs.index.len() {
        let (index, p, u) = inputs.at(i);
        let value = out.each_ref().map(|column| column[i]);
        let Some(s) = lights[index].sample(p, u, 0.0) else {
            assert_eq!(value[0], 0.0, "{index} {p} {u}");
            continue;
        };
        found += 1;
        let n = s.point.map_or(Vec3::ZERO, |point| point.n);
        let pdf = lights[index].pdf(p, s.wi, s.distance, n, 0.0);
        let mut expected = vec![s.pdf, s.wi.x, s.wi.y, s.wi.z, f32::from(s.delta)];
        expected.extend(s.radiance.to_array());
        expected.extend([s.distance, f32::from(s.point.is_some())]);
        if let Some(q) = s.point {
            expected.extend(q.p.to_array());
            expected.extend([q.p_error.x, q.n.z, q.triangle as f32, q.u, q.v]);
        }
        for (k, e) in expected.into_iter().enumerate() {
            assert!(same(value[k], e), "{:?} {p} {u}, column {k}: {} {e}", lights[index], value[k]);
        }
        assert!(same(value[18], pdf), "{index} {p} {u}");
    }
    assert!(found > 30_000, "{found}");
}

/// Selects a light for every input, and computes its probability again.
struct ChooseAll<'a> {
    sampler: &'a LightSampler,
    inputs: &'a Inputs,
    out: &'a mut [Vec<f32>; 4],
}

impl Kernel for ChooseAll<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let Self { sampler, inputs, out } = self;
        let [x, y, z] = &inputs.p;
        for i in (0..inputs.index.len()).step_by(R::LANES) {
            let active = <R::Mask as Mask>::first(inputs.index.len() - i);
            let p = Vec3x::load([&x[i..], &y[i..], &z[i..]]);
            let n = Vec3x::load([&y[i..], &z[i..], &x[i..]]).normalize();
            let c = Chosen::<R>::new(sampler, active, p, n, R::load(&inputs.u[0][i..]));
            let again = probabilities::<R>(sampler, active, p, n, c.index);
            for (column, value) in out.iter_mut().zip([c.index.to_real(), c.pmf, c.u, again]) {
                value.store(&mut column[i..]);
            }
        }
    }
}

#[test]
fn lights_are_selected_with_the_same_bits() {
    let mut rng = Rng::new(6);
    // Without and with infinite lights.
    for (count, is_near) in [(1, true), (2, true), (7, true), (9, true), (300, true), (300, false)] {
        let all = (0..count).flat_map(|_| lights());
        let all = all.filter(|light| !(is_near && matches!(light, Light::Distant(_))));
        let mut lights: Vec<Light> = all.take(count).collect();
        for light in &mut lights {
            if let Light::Point(l) = light {
                l.p = rng.direction().as_vec3() * 5.0;
            }
        }
        let sampler = LightSampler::new(&lights, 10.0).unwrap();
        let inputs = inputs(lights.len());
        let run = |isa| {
            let mut out = [(); 4].map(|()| vec![0.0; inputs.index.len()]);
            dispatch(isa, ChooseAll { sampler: &sampler, inputs: &inputs, out: &mut out });
            out
        };
        let portable = run(Isa::Portable);
        for isa in Isa::available() {
            assert_eq!(portable, run(isa), "{count} lights, {}", isa.name());
        }
        assert_eq!(portable[1], portable[3], "{count} lights");
    }
}
