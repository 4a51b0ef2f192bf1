//! Stress case A14: intersection with tiny, huge and distant spheres.

use super::{Case, Check, Effort, Outcome};
use crate::noise::Noise;
use crate::scenes::{matte, moments, run, seen, square};
use crate::tally::Tally;
use dapple_integrator::geometry::shapes::Sphere;
use dapple_integrator::geometry::{AccelBuilder, Opaque};
use dapple_integrator::math::Ray;
use dapple_integrator::scene::{Scene, SceneError};
use glam::{DVec3, Vec3};

pub(super) const CASES: &[Case] = &[Case {
    id: "A14",
    title: "tiny and huge spheres",
    naive: "b² − 4ac cancels: at a distance of 1e4 radii no digit is correct",
    source: "Haines, Günther, Akenine-Möller 2019; docs/science.md, \"Spheres\"",
    check: Check::Run(spheres),
}];

/// The nearest root of |o + t·d − c| = r in f64, in the form without cancellation.
fn root(ray: &Ray, sphere: &Sphere) -> Option<f64> {
    let (d, f) = (ray.d.as_dvec3(), (ray.o - Vec3::ZERO).as_dvec3() - sphere.centre.as_dvec3());
    let (a, b) = (d.dot(d), -f.dot(d));
    let r = f64::from(sphere.radius);
    let delta = r * r - (f + d * (b / a)).length_squared();
    if delta < 0.0 {
        return None;
    }
    let q = b + b.signum() * (a * delta).sqrt();
    let c = (f.length() - r) * (f.length() + r);
    let (t0, t1) = (c / q, q / a);
    let (near, far) = (t0.min(t1), t0.max(t1));
    if near > 0.0 { Some(near) } else { (far > 0.0).then_some(far) }
}

fn spheres(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for (r, distance) in
        [(1.0, 10.0), (1.0, 1e3), (1.0, 1e5), (1.0, 1e6), (1e-6, 1.0), (1e6f32, 1e6f64 + 1e-3)]
    {
        let sphere = Sphere { centre: Vec3::ZERO, radius: r };
        let mut builder = AccelBuilder::default();
        builder.add_sphere(sphere);
        let accel = builder.build();
        let (mut noise, mut worst, mut lost) = (Noise(21), 0.0f64, 0u64);
        for _ in 0..effort.of(2_000, 50_000, 5_000_000) {
            let o = (noise.direction().as_dvec3() * distance).as_vec3();
            let target = noise.direction() * (0.95 * r * noise.unit());
            let ray = Ray::new(o, (target - o).normalize());
            match (root(&ray, &sphere), accel.intersect(&ray, 0.0, &Opaque)) {
                (Some(t), Some(hit)) => {
                    worst = worst.max((f64::from(hit.t) - t).abs() / t.max(f64::from(r) * 1e-9))
                }
                (None, None) => {}
                _ => lost += 1,
            }
        }
        tally.none(format!("rays that disagree, radius {r} at {distance}"), lost);
        tally.within(format!("relative error of t, radius {r} at {distance}"), worst, 0.0, 2.4e-7);
    }
    let lit = moments(&run(
        &match lone_sphere() {
            Ok(scene) => scene,
            Err(_) => return tally.finish(),
        },
        &square(8, 4),
    ));
    tally.exactly("an emitting sphere of radius 1 at 1e6", lit.mean, 3.0);
    tally.finish()
}

fn lone_sphere() -> Result<Scene, SceneError> {
    let mut builder = seen(DVec3::Z * 1e6, DVec3::ZERO, 1e-6);
    let bright = builder.material(matte(0.0, 3.0));
    builder.sphere("ball", DVec3::ZERO, 1.0, bright);
    builder.build()
}
