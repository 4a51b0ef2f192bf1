//! Rays, lens points and filters over lanes: the same bits with every instruction set, and those of the scalar functions.

use dapple_camera::{Aperture, Camera, Clip, Filter, Lens, Projection};
use dapple_math::lanes::{Isa, Kernel, Real, Vec2x, Word, dispatch};
use dapple_testkit::Rng;
use glam::{Vec2, Vec3};

#[derive(Clone, Copy)]
struct Rays<'a> {
    camera: &'a Camera,
    filter: Filter,
    size: (u32, u32),
    pixels: &'a [[u32; 2]],
    u: &'a [Vec2],
}

/// Numbers of one sample: the ray, the point of the filter and its weight.
type Numbers = [f32; 10];

impl Kernel for Rays<'_> {
    type Output = Vec<Numbers>;
    #[inline(always)]
    fn run<R: Real>(self) -> Vec<Numbers> {
        let mut out = vec![[0.0; 10]; self.pixels.len()];
        let warp = self.filter.warp();
        for (i, out) in out.chunks_mut(R::LANES).enumerate() {
            let at = i * R::LANES..self.pixels.len().min((i + 1) * R::LANES);
            let (mut words, mut numbers) = ([[0; 16]; 2], [[0.0; 16]; 2]);
            for (k, j) in at.enumerate() {
                (words[0][k], words[1][k]) = self.pixels[j].into();
                (numbers[0][k], numbers[1][k]) = self.u[j].into();
            }
            let u = Vec2x::load([&numbers[0], &numbers[1]]);
            let (fraction, weight) = warp.sample::<R>(u);
            let pixel = [R::Word::load(&words[0]), R::Word::load(&words[1])];
            let lens_u = Vec2x::new(u.y, u.x);
            let ray = self.camera.rays(pixel, fraction, self.size, lens_u);
            let all = [ray.o.x, ray.o.y, ray.o.z, ray.d.x, ray.d.y, ray.d.z, ray.t_max, weight];
            for (c, x) in all.into_iter().chain([fraction.x, fraction.y]).enumerate() {
                let mut lanes = [0.0; 16];
                x.store(&mut lanes);
                out.iter_mut().zip(lanes).for_each(|(out, x)| out[c] = x);
            }
        }
        out
    }
}

fn bits(numbers: &[Numbers]) -> Vec<[u32; 10]> {
    numbers.iter().map(|n| n.map(f32::to_bits)).collect()
}

fn check(camera: &Camera, filter: Filter, size: (u32, u32), rng: &mut Rng) {
    let pixels: Vec<[u32; 2]> = (0..99).map(|_| [rng.below(size.0), rng.below(size.1)]).collect();
    let end = 1.0 - f32::EPSILON / 2.0;
    let special = [Vec2::ZERO, Vec2::splat(end), Vec2::splat(0.5), Vec2::new(0.0, end)];
    let u: Vec<Vec2> = special.into_iter().chain((0..95).map(|_| rng.vec2())).collect();
    let kernel = Rays { camera, filter, size, pixels: &pixels, u: &u };
    let portable = dispatch(Isa::Portable, kernel);
    for isa in Isa::available() {
        assert_eq!(bits(&portable), bits(&dispatch(isa, kernel)), "{}", isa.name());
    }
    for ((numbers, u), pixel) in portable.iter().zip(&u).zip(&pixels) {
        let (fraction, weight) = filter.sample(*u);
        let ray = camera.ray((*pixel).into(), fraction, size, Vec2::new(u.y, u.x));
        assert_eq!(numbers[..6], [ray.o.to_array(), ray.d.to_array()].concat());
        assert_eq!(numbers[6..], [ray.t_max, weight, fraction.x, fraction.y]);
        assert!(ray.o.is_finite() && ray.d.is_finite());
    }
}

#[test]
fn rays_are_the_same_in_every_lane() {
    let mut rng = Rng::new(1);
    let blades = Aperture::Blades { n: 5, rotation: 0.3 };
    let lens = |aperture, focus_distance| Some(Lens { aperture, radius: 0.2, focus_distance });
    let lenses = [None, lens(Aperture::Disk, 3.0), lens(Aperture::Square, 0.0), lens(blades, f32::INFINITY)];
    let turn = glam::Quat::from_rotation_y(0.7) * glam::Quat::from_rotation_x(-0.4);
    for projection in [
        Projection::Perspective { tan_half: 0.4 },
        Projection::Perspective { tan_half: 1e-5 },
        Projection::Perspective { tan_half: 1e18 },
        Projection::Orthographic { half_height: 2.0 },
    ] {
        for lens in lenses {
            for (clip, filter) in [
                (None, Filter::default()),
                (Some(Clip { near: 0.5, far: 7.0 }), Filter::Gaussian),
                (None, Filter::Mitchell),
                (None, Filter::Tent),
            ] {
                let camera = Camera {
                    origin: Vec3::new(1.0, -2.0, 3.0),
                    right: turn * Vec3::X,
                    up: turn * Vec3::Y,
                    backward: turn * Vec3::Z,
                    projection,
                    lens,
                    motion: None,
                    aspect: None,
                    clip,
                };
                for size in [(1, 1), (640, 480), (4001, 8192), (20_000, 30_000)] {
                    check(&camera, filter, size, &mut rng);
                }
            }
        }
    }
}

/// At the bounds of f32 the rays are those of f64 to within 1/300 pixel.
#[test]
fn plain_rays_are_accurate() {
    let mut rng = Rng::new(2);
    let turn = glam::Quat::from_rotation_y(0.7) * glam::Quat::from_rotation_x(-0.4);
    for (tan_half, size) in
        [(0.4096, (8192u32, 8192u32)), (0.0501, (1000, 1000)), (0.41, (8000, 8192)), (3.0, (500, 300))]
    {
        let camera = Camera {
            origin: Vec3::ZERO,
            right: turn * Vec3::X,
            up: turn * Vec3::Y,
            backward: turn * Vec3::Z,
            projection: Projection::Perspective { tan_half },
            lens: None,
            motion: None,
            aspect: None,
            clip: None,
        };
        let axes = [camera.right, camera.up, camera.backward].map(|a| a.as_dvec3());
        for _ in 0..20_000 {
            let (x, y, f) = (rng.below(size.0), rng.below(size.1), rng.vec2());
            let d = camera.ray((x, y), f, size, Vec2::ZERO).d.as_dvec3();
            let scale = 0.5 * f64::from(size.1) / f64::from(tan_half) / -d.dot(axes[2]);
            let at_x = d.dot(axes[0]) * scale + 0.5 * f64::from(size.0) - f64::from(x) - f64::from(f.x);
            let at_y = -d.dot(axes[1]) * scale + 0.5 * f64::from(size.1) - f64::from(y) - f64::from(f.y);
            assert!(at_x.abs().max(at_y.abs()) < 1.0 / 300.0, "{tan_half}: {at_x} {at_y}");
        }
    }
}
