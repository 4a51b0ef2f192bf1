//! Tests exact spheres and disks: accuracy at any size and distance (docs/science.md, "Spheres"), large numbers of
//! shapes, equal distances, and filters.
mod solids;

use dapple_geometry::shapes::{Disk, Shape, Sphere};
use dapple_geometry::{Accel, AccelBuilder, Hit, HitFilter, Mesh, Opaque};
use dapple_math::Ray;
use dapple_math::motion::Motion;
use glam::{DAffine3, DVec3, Vec3};
use solids::Noise;

fn accel_with(spheres: &[Sphere]) -> Accel {
    let mut builder = AccelBuilder::default();
    for s in spheres {
        builder.add_sphere(*s);
    }
    builder.build()
}

/// Nearest intersection by bisection in f64, from the point nearest to the centre outward.
fn bisected(ray: &Ray, sphere: &Sphere, near: bool) -> f64 {
    let (o, d, c) = (ray.o.as_dvec3(), ray.d.as_dvec3(), sphere.centre.as_dvec3());
    let middle = (c - o).dot(d) / d.length_squared();
    let reach = f64::from(sphere.radius) * 1.01 / d.length();
    let (mut inside, mut outside) = (middle, if near { middle - reach } else { middle + reach });
    for _ in 0..200 {
        let t = 0.5 * (inside + outside);
        if (o + d * t - c).length() < f64::from(sphere.radius) { inside = t } else { outside = t }
    }
    0.5 * (inside + outside)
}

#[test]
fn small_far_spheres() {
    let mut noise = Noise(1);
    for distance in [10.0f32, 1e3, 1e5, 1e6] {
        let sphere = Sphere { centre: Vec3::new(0.0, 0.0, -distance), radius: 1.0 };
        let accel = accel_with(&[sphere]);
        for _ in 0..2000 {
            let target = noise.direction() * (0.99 * noise.unit());
            let ray = Ray::new(Vec3::ZERO, (sphere.centre + target) / distance);
            // The rounding of the f32 direction alone may cause a miss at this distance.
            let closest = ray.d.as_dvec3() * f64::from(distance) - sphere.centre.as_dvec3();
            if closest.truncate().length() > 0.999 {
                continue;
            }
            let hit = accel.intersect(&ray, 0.0, &Opaque).expect("aimed at the sphere");
            let exact = bisected(&ray, &sphere, true);
            assert!((f64::from(hit.t) / exact - 1.0).abs() < 1.2e-7, "{distance}: {} {exact}", hit.t);
            let p = accel.surface(&ray, 0.0, &hit).p.as_dvec3();
            let off = ((p - sphere.centre.as_dvec3()).length() - 1.0).abs();
            assert!(off <= 1.2e-7 * f64::from(distance), "{distance}: {off}");
        }
    }
}

#[test]
fn a_huge_sphere_under_the_eye() {
    let sphere = Sphere { centre: Vec3::new(0.0, -1e6, 0.0), radius: 1e6 };
    let accel = accel_with(&[sphere]);
    let mut noise = Noise(2);
    for _ in 0..2000 {
        let o = Vec3::new(0.0, 1e-3, 0.0);
        let d = Vec3::new(noise.next(), -(10f32.powf(-3.0 * noise.unit())), noise.next());
        let ray = Ray::new(o, d);
        let hit = accel.intersect(&ray, 0.0, &Opaque).expect("looking down");
        let exact = bisected(&ray, &sphere, true);
        // The bisection has an error of 1e-10 perpendicular to the surface, which is larger along a grazing ray.
        let slant = f64::from(-d.y / d.length());
        let tolerance = 1.2e-7 * exact + 1e-9 / slant;
        assert!((f64::from(hit.t) - exact).abs() < tolerance, "{d}: {} {exact}", hit.t);
    }
}

#[test]
fn many_shapes_are_hit_as_one_by_one() {
    let mut noise = Noise(3);
    let spheres: Vec<Sphere> =
        (0..3000).map(|_| Sphere { centre: noise.vec() * 10.0, radius: 0.3 * noise.unit() }).collect();
    let accel = accel_with(&spheres);
    let alone: Vec<Accel> = spheres.iter().map(|s| accel_with(&[*s])).collect();
    for _ in 0..200 {
        let ray = Ray::new(noise.vec() * 10.0, noise.direction());
        let mut expected: Option<Hit> = None;
        for (object, accel) in alone.iter().enumerate() {
            if let Some(hit) = accel.intersect(&ray, 0.0, &Opaque) {
                let hit = Hit { object: object as u32, ..hit };
                if expected.is_none_or(|e| hit.wins_over(&e)) {
                    expected = Some(hit);
                }
            }
        }
        assert_eq!(accel.intersect(&ray, 0.0, &Opaque), expected);
        assert_eq!(accel.occluded(&ray, 0.0, &Opaque), expected.is_some());
        if let Some(e) = expected {
            let short = Ray { t_max: e.t, ..ray };
            assert!(!accel.occluded(&short, 0.0, &Opaque) && accel.intersect(&short, 0.0, &Opaque).is_none());
        }
    }
}

#[test]
fn the_lowest_object_wins_a_tie() {
    let quad = Mesh {
        positions: vec![Vec3::new(-1.0, -1.0, 1.0), Vec3::new(1.0, -1.0, 1.0), Vec3::new(0.0, 2.0, 1.0)],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let disk = Disk { centre: Vec3::Z, normal: Vec3::Z, radius: 1.0 };
    let ray = Ray::new(Vec3::new(0.1, 0.2, 3.0), -Vec3::Z);
    let wide = Motion::fixed(DAffine3::from_scale(DVec3::new(2.0, 2.0, 1.0)));
    let kinds: [&dyn Fn(&mut AccelBuilder) -> u32; 3] =
        [&|b| b.add_mesh(quad.clone()), &|b| b.add_disk(disk), &|b| {
            b.add_moving_shape(Shape::Disk(disk), wide.clone())
        }];
    for first in 0..3 {
        for second in 0..3 {
            let mut builder = AccelBuilder::default();
            kinds[first](&mut builder);
            kinds[second](&mut builder);
            let accel = builder.build();
            let hit = accel.intersect(&ray, 0.0, &Opaque).unwrap();
            assert_eq!((hit.object, hit.t), (0, 2.0), "{first} {second}");
        }
    }
}

/// Accepts only this object.
struct Only(u32);
impl HitFilter<Hit> for Only {
    const OPAQUE: bool = false;
    fn accept(&self, hit: &Hit) -> bool {
        hit.object == self.0
    }
}

/// Rejects the front of a sphere and accepts its back.
struct Back(Vec3);
impl HitFilter<Hit> for Back {
    const OPAQUE: bool = false;
    fn accept(&self, hit: &Hit) -> bool {
        hit.t > self.0.z
    }
}

#[test]
fn filters_see_every_crossing() {
    let spheres = [2.0, 1.0, 3.0].map(|radius| Sphere { centre: Vec3::ZERO, radius });
    let accel = accel_with(&spheres);
    let ray = Ray::new(Vec3::new(0.0, 0.0, 10.0), -Vec3::Z);
    for (object, t) in [(0, 8.0), (1, 9.0), (2, 7.0)] {
        let hit = accel.intersect(&ray, 0.0, &Only(object)).unwrap();
        assert_eq!((hit.object, hit.t), (object, t));
        assert!(accel.occluded(&ray, 0.0, &Only(object)));
    }
    assert!(!accel.occluded(&ray, 0.0, &Only(7)));
    let hit = accel.intersect(&ray, 0.0, &Back(Vec3::new(0.0, 0.0, 9.5))).unwrap();
    assert_eq!((hit.object, hit.t), (1, 11.0));
}

#[test]
fn an_uneven_transform_makes_an_exact_ellipsoid() {
    let axes = DVec3::new(3.0, 0.5, 1.5);
    let place = DAffine3::from_translation(DVec3::new(1.0, 2.0, 3.0)) * DAffine3::from_scale(axes);
    let mut builder = AccelBuilder::default();
    builder.add_moving_shape(Shape::Sphere(Sphere { centre: Vec3::ZERO, radius: 1.0 }), Motion::fixed(place));
    let accel = builder.build();
    let (lo, hi) = accel.bounds().unwrap();
    assert!(
        (lo - Vec3::new(-2.0, 1.5, 1.5)).length() < 1e-4 && (hi - Vec3::new(4.0, 2.5, 4.5)).length() < 1e-4
    );
    let mut noise = Noise(4);
    let (mut out, mut into) = (0, 0);
    for _ in 0..2000 {
        let target = Vec3::new(1.0, 2.0, 3.0) + noise.vec() * 0.2;
        let d = noise.direction();
        let ray = Ray::new(target - d * 10.0, d);
        let hit = accel.intersect(&ray, 0.0, &Opaque).expect("aimed at the middle");
        let s = accel.surface(&ray, 0.0, &hit);
        let q = (s.p.as_dvec3() - DVec3::new(1.0, 2.0, 3.0)) / axes;
        assert!((q.length() - 1.0).abs() < 2e-6, "{}", q.length());
        assert!((s.ng.as_dvec3() - (q / axes).normalize()).length() < 2e-6);
        let bad = solids::leave(&accel, &mut noise, &ray, 0.0, &hit, 10);
        out += bad.0;
        into += bad.1;
    }
    assert_eq!((out, into), (0, 0));
}

#[test]
fn shapes_that_are_no_shapes_are_never_hit() {
    let bad = [f32::NAN, f32::INFINITY, 0.0, -1.0];
    let mut builder = AccelBuilder::default();
    for radius in bad {
        builder.add_sphere(Sphere { centre: Vec3::ZERO, radius });
        builder.add_disk(Disk { centre: Vec3::ZERO, normal: Vec3::Z, radius });
        builder.add_disk(Disk { centre: Vec3::ZERO, normal: Vec3::splat(radius - radius), radius: 1.0 });
    }
    let accel = builder.build();
    assert_eq!(accel.bounds(), None);
    let mut noise = Noise(6);
    for _ in 0..1000 {
        let ray = Ray::new(noise.vec(), noise.direction());
        assert_eq!(accel.intersect(&ray, 0.0, &Opaque), None);
    }
    let nothing = Ray::new(Vec3::NAN, Vec3::ZERO);
    assert_eq!(
        accel_with(&[Sphere { centre: Vec3::ZERO, radius: 1.0 }]).intersect(&nothing, 0.0, &Opaque),
        None
    );
}
