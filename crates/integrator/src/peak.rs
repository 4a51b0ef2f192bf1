//! Upper bound for samples found by chance: the brightest value that a single sample can have.
//!
//! Sample statistics cannot account for rare events that no sample has hit. But such a sample cannot be brighter than
//! the light sources of the scene allow: with an upper bound M of the value of a sample, N samples none of which was
//! that bright leave a second moment of at most M²·ln(1/δ)/N with confidence 1 − δ. This module estimates M from the
//! few places where light is far brighter than elsewhere:
//!
//! - emitters that light sampling cannot find: seen through smooth surfaces, by the camera itself, or excluded from
//!   light sampling. Their radiance is known, and a path carries at most this radiance, with a throughput of 1;
//! - surfaces close to a light, or that a light is focused on: rays are traced from every light, and where they arrive
//!   a light sample is evaluated in the direction in which the surface reflects most of it.
//!
//! *Approximation*: light is traced to the first surface, by `PROBES` rays or a few per light; light that two
//! successive surfaces focus is not searched, and textures are evaluated only where rays hit them.
//! after the other focus is not looked for, and textures are looked at where rays happen to hit them.

use crate::first_hit;
use crate::job::Job;
use crate::sample::Sample;
use crate::settings::Settings;
use dapple_camera::{Camera, Projection};
use dapple_geometry::{Hit, Opaque, Surface};
use dapple_lights::{Light, LightSample};
use dapple_materials::{Bsdf, Lobe, Lobes};
use dapple_math::{Frame, Ray, offset::offset_origin};
use dapple_sampling::{Key, mis, warp};
use dapple_scene::Scene;
use glam::{Vec2, Vec3};

/// Number of rays traced from lights, and from the camera.
const PROBES: usize = 4096;

/// Maximum number of rays per light.
const PER_LIGHT: usize = 64;

/// Number of pixels that an emitter has to cover to be hit by many samples: a hundred at the minimum sample count of a
/// render with an error limit.
const LARGE: f32 = 2.0;

/// Render space spans a few units: from this distance lights are entirely in view.
const FAR: f32 = 16.0;

/// Transmissive surfaces below this roughness are assumed to be able to focus all light.
const SMOOTH: f32 = 0.3;

/// Upper bounds of the value of one sample by the source of its light: largest channel, W·m⁻²·sr⁻¹; 0 where no such
/// source is found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Peak {
    /// Emitters that rays find by chance: through smooth surfaces, smaller than one or two pixels in the image, or
    /// excluded from light sampling.
    pub emitter: f64,
    /// Any emitter; those that are large in the image are hit by many samples.
    pub shown: f64,
    /// Diffuse surfaces that a light is close to or focused on.
    pub lit: f64,
    /// Highlights of rough surfaces. Their brightness decreases gradually in all directions, so that samples reveal a
    /// highlight before one hits its centre.
    pub highlight: f64,
}

impl Peak {
    /// The maximum of all bounds.
    pub fn most(&self) -> f64 {
        self.shown.max(self.emitter).max(self.lit).max(self.highlight)
    }
}

fn raise(bound: &mut f64, radiance: Vec3) {
    let radiance = f64::from(radiance.max_element());
    if radiance.is_finite() && radiance > *bound {
        *bound = radiance;
    }
}

/// Estimates the brightest value that a sample of `scene`, seen by `camera`, is likely to have. Independent of seed and
/// threads.
pub fn peak(scene: &Scene, camera: &Camera, settings: &Settings) -> Peak {
    let mut peak = Peak::default();
    let job = Job::new(scene, camera, settings);
    let probe = Probe { scene, camera: &job.camera, job: &job, key: Key::pixel(0x9ea4_0000, 0, 0) };
    probe.emitters(&mut peak);
    if settings.bounces() > 0 {
        probe.along_camera_rays(&mut peak);
        probe.along_light_rays(&mut peak);
    }
    peak
}

struct Probe<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    job: &'a Job<'a>,
    key: Key,
}

/// A number in \[0,1) and a point in the unit square.
fn number(key: Key, n: u32) -> f32 {
    (key.branch(n).bits() >> 40) as f32 / (1u64 << 24) as f32
}

fn point(key: Key, n: u32) -> Vec2 {
    Vec2::new(number(key, 2 * n), number(key, 2 * n + 1))
}

impl Probe<'_> {
    /// Emitters that are found by chance.
    fn emitters(&self, peak: &mut Peak) {
        let through = self.job.bounces > 0 && self.is_smooth_anywhere();
        for object in &self.scene.objects {
            let material = &self.scene.materials[object.material as usize];
            if through || object.first_light == u32::MAX && !material.unlit {
                raise(&mut peak.emitter, material.emission);
            }
        }
        let large = self.is_large();
        for (i, light) in self.scene.lights.iter().enumerate().filter(|(_, light)| !light.is_delta()) {
            for k in 0..self.per_light().max(4) {
                let key = self.key.branch(1).branch(i as u32).branch(k as u32);
                let Some((sample, from)) = self.on_light(light, key) else { continue };
                let radiance = self.radiance(i, &sample);
                raise(&mut peak.shown, radiance);
                if through || !large[i] && self.sees(from, &sample) {
                    raise(&mut peak.emitter, radiance);
                }
            }
        }
    }

    /// For every light, whether the object it belongs to covers more than [`LARGE`] pixels as seen from the camera.
    fn is_large(&self) -> Vec<bool> {
        let mut large = vec![false; self.scene.lights.len()];
        let mut starts = vec![true; large.len() + 1];
        let is_area = |i: usize| self.scene.lights.get(i).is_some_and(Light::is_area);
        (0..large.len()).for_each(|i| starts[i] = !is_area(i));
        for object in &self.scene.objects {
            starts.get_mut(object.first_light as usize).into_iter().for_each(|start| *start = true);
        }
        let (mut first, mut sum) = (0, 0.0);
        for (i, light) in self.scene.lights.iter().enumerate() {
            if starts[i] {
                (first, sum) = (i, 0.0);
            }
            sum += self.pixels_of(light);
            if starts[i + 1] {
                large[first..=i].fill(sum > LARGE);
            }
        }
        large
    }

    /// Number of pixels that a light covers, ignoring occlusion.
    fn pixels_of(&self, light: &Light) -> f32 {
        let side = 2.0 / self.job.settings.size.1.max(1) as f32;
        match (light, self.camera.projection) {
            (Light::Environment(sky), _) if sky.is_constant() => f32::INFINITY,
            (Light::Patterned(light), _) => self.pixels_of(&Light::Area(light.area.clone())),
            (Light::Moving(light), _) => light.at(0.0).map_or(0.0, |light| self.pixels_of(&light)),
            (Light::Area(area), Projection::Orthographic { half_height }) => {
                0.25 * area.shape.area() as f32 / (side * half_height).powi(2)
            }
            (Light::Area(_), Projection::Perspective { tan_half }) => {
                let sample = light.sample(self.camera.origin, Vec2::splat(0.5), 0.0);
                sample.map_or(0.0, |s| 1.0 / (s.pdf * (side * tan_half).powi(2)))
            }
            _ => 0.0,
        }
    }

    /// Whether a material has a lobe that can transport the full radiance of a light in one direction.
    fn is_smooth_anywhere(&self) -> bool {
        self.scene.used_materials().any(|m| {
            let lobes = m.lobes_by_factors().sharpened(self.job.sharp);
            lobes.meets(Lobes::DELTA) || lobes.meets(Lobes::TRANSMISSION) && m.is_smoother_than(SMOOTH)
        })
    }

    fn per_light(&self) -> usize {
        (PROBES / self.scene.lights.len().max(1)).clamp(1, PER_LIGHT)
    }

    /// A point sampled on a light, as seen from a random position around it.
    fn on_light(&self, light: &Light, key: Key) -> Option<(LightSample, Vec3)> {
        let from = match light {
            Light::Environment(_) => Vec3::ZERO,
            Light::Area(light) => light.shape.centroid() + warp::sphere(point(key, 0)) * FAR,
            Light::Patterned(light) => light.area.shape.centroid() + warp::sphere(point(key, 0)) * FAR,
            Light::Moving(light) => return self.on_light(&light.at(0.0)?, key),
            _ => self.camera.origin,
        };
        light.sample(from, point(key, 1), 0.0).map(|sample| (sample, from))
    }

    fn radiance(&self, light: usize, sample: &LightSample) -> Vec3 {
        match &sample.point {
            Some(point) if !sample.delta => {
                self.scene.light_radiance(light as u32, point, sample.radiance, 0.0)
            }
            _ => sample.radiance,
        }
    }

    /// Whether the camera may see the point of a light sample taken from `from`: inside the image, and not occluded.
    fn sees(&self, from: Vec3, sample: &LightSample) -> bool {
        let is_far = !sample.distance.is_finite();
        let d = match &sample.point {
            Some(point) => point.p - self.camera.origin,
            None if is_far => sample.wi,
            None => from + sample.wi * sample.distance - self.camera.origin,
        };
        if self.camera.motion.is_some() || self.camera.lens.is_some() {
            return true;
        }
        let Projection::Perspective { tan_half } = self.camera.projection else { return true };
        let (x, y, z) = (d.dot(self.camera.right), d.dot(self.camera.up), -d.dot(self.camera.backward));
        let (w, h) = self.job.settings.size;
        let wide = tan_half * w as f32 / h.max(1) as f32;
        if z <= 0.0 || x.abs() > wide * z || y.abs() > tan_half * z {
            return false;
        }
        let ray = Ray::new(self.camera.origin, d);
        let hit = first_hit::solid(self.job, &ray, 0.0);
        let near = self.job.near(&ray, 0.0);
        hit.is_none_or(|(hit, _)| self.scene.light_of(&hit).is_some() || !is_far && hit.t + near >= 1.0)
    }

    /// Evaluates the hits of camera rays, and of diffuse directions from these hits.
    fn along_camera_rays(&self, peak: &mut Peak) {
        let rect = self.job.settings.rect();
        let step = (rect.area() as f32 / PROBES as f32).sqrt().max(1.0) as u32;
        for y in (rect.y0..rect.y1).step_by(step as usize) {
            for x in (rect.x0..rect.x1).step_by(step as usize) {
                let sample = Sample::new(self.job.settings, (x, y), 0).timed(self.job);
                let (ray, _) = sample.camera_ray(self.job, (x, y));
                let key = self.key.branch(2).branch(x).branch(y);
                let Some((hit, surface)) = first_hit::solid(self.job, &ray, sample.time) else { continue };
                self.lit(peak, (&hit, &surface), sample.time, key);
                let side = surface.ng * -ray.d.dot(surface.ng).signum();
                let d = Frame::from_z(side).to_world(warp::hemisphere_cosine(point(key, 0)));
                let next = Ray::new(surface.origin_towards(d), d);
                let Some((hit, surface)) = self.meet(&next, sample.time) else { continue };
                self.lit(peak, (&hit, &surface), sample.time, key.branch(1));
            }
        }
    }

    fn meet(&self, ray: &Ray, time: f32) -> Option<(Hit, Surface)> {
        let hit = self.scene.accel.intersect(ray, time, &Opaque)?;
        let surface = self.scene.accel.surface(ray, time, &hit);
        Some((hit, surface))
    }

    /// Evaluates one light, chosen as in the path tracer, at a hit.
    fn lit(&self, peak: &mut Peak, at: (&Hit, &Surface), time: f32, key: Key) {
        let Some(choice) = &self.scene.light_choice else { return };
        if let Some(chosen) = choice.sample(at.1.p, Vec3::ZERO, number(key, 99)) {
            self.evaluate(peak, at, (chosen.index, chosen.pmf), time, key);
        }
    }

    /// Evaluates every light at the hits of rays from that light.
    fn along_light_rays(&self, peak: &mut Peak) {
        let Some(choice) = &self.scene.light_choice else { return };
        for (i, light) in self.scene.lights.iter().enumerate().filter(|(i, _)| choice.contains(*i)) {
            for k in 0..self.per_light() {
                let key = self.key.branch(3).branch(i as u32).branch(k as u32);
                let Some(ray) = self.leaving(light, key) else { continue };
                let Some((hit, surface)) = self.meet(&ray, 0.0) else { continue };
                let pmf = choice.pmf(surface.p, Vec3::ZERO, i);
                self.evaluate(peak, (&hit, &surface), (i, pmf), 0.0, key);
            }
        }
    }

    /// A ray from a light; none for infinite lights, whose light is the same everywhere.
    fn leaving(&self, light: &Light, key: Key) -> Option<Ray> {
        match light {
            Light::Point(light) => Some(Ray::new(light.p, warp::sphere(point(key, 2)))),
            Light::Spot(light) => {
                let d = warp::cone(point(key, 2), light.outer as f32);
                Some(Ray::new(light.p, Frame::from_z(light.axis).to_world(d)))
            }
            Light::Moving(light) => self.leaving(&light.at(0.0)?, key),
            Light::Area(_) | Light::Patterned(_) => {
                let (sample, _) = self.on_light(light, key)?;
                let place = sample.point?;
                let side = place.n * -place.n.dot(sample.wi).signum();
                let d = Frame::from_z(side).to_world(warp::hemisphere_cosine(point(key, 2)));
                Some(Ray::new(offset_origin(place.p, place.p_error, place.n, d), d))
            }
            Light::Distant(_) | Light::Environment(_) => None,
        }
    }

    /// One sample of `light` at a hit, evaluated in the mirror direction and in the straight direction of transmission.
    fn evaluate(
        &self,
        peak: &mut Peak,
        (hit, surface): (&Hit, &Surface),
        (light, pmf): (usize, f32),
        time: f32,
        key: Key,
    ) {
        let shading = self.scene.shading(hit, surface, time);
        let sample = self.scene.lights[light].sample(surface.p, point(key, 3), time);
        let Some(sample) = sample.filter(|_| !shading.unlit && pmf > 0.0) else { return };
        let (radiance, pdf) = (self.radiance(light, &sample), sample.pdf * pmf);
        let wi = shading.frame.to_local(sample.wi);
        for wo in [Vec3::new(-wi.x, -wi.y, wi.z), -wi] {
            let bsdf = Bsdf::new(&shading.material, wo);
            let weighed = |lobes| {
                let (f, chance) = bsdf.eval(wi, lobes);
                let weight = if sample.delta { 1.0 } else { mis::power(pdf, chance) };
                // Found by light sampling, or by BSDF sampling.
                (f * wi.z.abs() * radiance * (weight / pdf)).max(radiance * (1.0 - weight))
            };
            let diffuse = Lobes::of(Lobe::Diffuse);
            if bsdf.lobes().contains(Lobe::Diffuse) {
                raise(&mut peak.lit, weighed(diffuse));
            }
            if !bsdf.lobes().without(diffuse).without(Lobes::DELTA).is_empty() {
                raise(&mut peak.highlight, weighed(Lobes::ALL.without(diffuse)));
            }
        }
    }
}
