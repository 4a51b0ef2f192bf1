//! A custom integrator: ambient occlusion, the unoccluded share of the cosine-weighted hemisphere within a distance.
//! `cargo run --release --example ambient_occlusion -p dapple-integrator` writes `ambient_occlusion.png`.

use dapple_integrator::imaging::{Tone, write};
use dapple_integrator::math::{Frame, Ray, glam::Vec3};
use dapple_integrator::{Integrator, Renderer, SampleContext, Settings, sampling::warp, scene::builtin};
use std::ops::ControlFlow;

/// Decision number of the ray direction in the hemisphere.
const HEMISPHERE: u32 = 128;

struct AmbientOcclusion {
    /// Maximum distance of occluders, in render-space units.
    reach: f32,
}

impl Integrator for AmbientOcclusion {
    fn radiance(&self, ray: &Ray, context: &SampleContext<'_>) -> Vec3 {
        let Some(at) = context.intersect(ray, 0) else { return Vec3::ONE };
        let local = warp::hemisphere_cosine(context.point_2d(0, HEMISPHERE));
        let towards = Frame::from_z(at.facing_normal()).to_world(local);
        let is_occluded = context.is_occluded(&at.ray(towards).until(self.reach), 0);
        Vec3::splat(if is_occluded { 0.0 } else { 1.0 })
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = builtin::builtin("cornell").ok_or("no such scene")?.build()?;
    let integrator = AmbientOcclusion { reach: scene.space.length_to_render(0.2) };
    let settings = Settings { size: (256, 256), ..Settings::default() }.with_spp(16);
    let mut renderer = Renderer::with_integrator(&scene, &scene.cameras[0].camera, &settings, &integrator)?;
    renderer.advance(u32::MAX, &|_| ControlFlow::Continue(()));
    write::png("ambient_occlusion.png".as_ref(), &renderer.finish().film.mean(), Tone::Srgb, 0.0)?;
    Ok(())
}
