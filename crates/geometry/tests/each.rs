//! Many rays in one query have the hits of single rays, with every kernel, with and without a second level.
mod solids;

use dapple_geometry::bvh::Kernel;
use dapple_geometry::shapes::Sphere;
use dapple_geometry::{Accel, AccelBuilder, Hit, Opaque};
use dapple_math::Ray;
use glam::Vec3;
use solids::{Noise, cube};

fn accels() -> Vec<Accel> {
    let mut all = Vec::new();
    for kernel in [Kernel::Avx2, Kernel::Sse2, Kernel::Portable] {
        for has_sphere in [false, true] {
            let mut builder = AccelBuilder::default();
            builder.add_mesh(cube(1.0, Vec3::ZERO));
            if has_sphere {
                builder.add_sphere(Sphere { centre: Vec3::new(0.4, 0.2, 0.9), radius: 0.5 });
            }
            all.push(builder.build().with_kernel(kernel));
        }
        all.push(AccelBuilder::default().build().with_kernel(kernel));
    }
    all
}

#[test]
fn many_rays_have_the_hits_of_single_rays() {
    let mut noise = Noise(5);
    let mut rays: Vec<Ray> = (0..500).map(|_| Ray::new(noise.vec() * 3.0, noise.direction())).collect();
    rays.extend([-1.0, 0.0, f32::NAN, 0.5].map(|t_max| Ray::new(Vec3::Z * 3.0, -Vec3::Z).until(t_max)));
    rays.push(Ray::new(Vec3::ZERO, Vec3::X * 1e30));
    for accel in accels() {
        let (mut hits, mut shadows) = (Vec::new(), Vec::new());
        let ray = |i: usize| (rays[i], 0.0);
        accel.intersect_each(rays.len(), ray, |i, hit: Option<Hit>| hits.push((i, hit)));
        accel.occluded_each(rays.len(), ray, |i, is_occluded| shadows.push((i, is_occluded)));
        for (i, ray) in rays.iter().enumerate() {
            assert_eq!(hits[i], (i, accel.intersect(ray, 0.0, &Opaque)));
            assert_eq!(shadows[i], (i, accel.occluded(ray, 0.0, &Opaque)));
        }
    }
}
