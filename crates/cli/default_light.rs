//! Decides whether the lights of a file illuminate enough of it, or a default studio environment is needed.
//!
//! A file may contain a light and still leave its image black: a few texels of an emissive texture on an object that
//! nothing else lights. The rule: **a studio environment is added when, in a small render, less than a quarter of the
//! pixels that show a surface are lit, and less than an eighth by light that the surface reflects; lit means at least
//! 1/256 of the 99th percentile of the pixels' luminance.** The criterion is the lit fraction, not the brightness: the
//! exposure is chosen for whatever is lit, which would be a few bright spots on black. The render is always the same
//! for a scene and a view. A coarser render comes first: if direct lighting alone already lights most of the surfaces,
//! the rule is not evaluated.
//!
//! So a planet in sunlight keeps its dark side, a room with one candle stays dim, and self-luminous panels are left
//! alone.

use crate::interrupt;
use dapple_integrator::camera::{Camera, Projection};
use dapple_integrator::imaging::{Image, color, metering};
use dapple_integrator::scene::Scene;
use dapple_integrator::{Aov, Backfaces, Settings, render};
use glam::Vec3;
use std::ops::ControlFlow;

/// Size of the small render, and its samples per pixel.
const SIZE: (u32, u32) = (48, 36);
const SAMPLES: u32 = 8;

/// Size of the coarse first render, at one sample per pixel, and the lit fraction of surface pixels above which it
/// suffices.
const GLANCE: (u32, u32) = (16, 12);
const CLEARLY: f64 = 0.4;

/// Resolutions of the search for a surface: the side of the image if it were square, and samples per pixel.
const PROBES: [(f64, u32); 3] = [(14.0, 1), (64.0, 1), (384.0, 2)];

/// Right and up vectors of the six views from the camera onto the sides of a cube, and the pixels along an edge.
const AROUND: [(Vec3, Vec3); 6] = [
    (Vec3::X, Vec3::Y),
    (Vec3::NEG_X, Vec3::Y),
    (Vec3::Z, Vec3::Y),
    (Vec3::NEG_Z, Vec3::Y),
    (Vec3::X, Vec3::Z),
    (Vec3::X, Vec3::NEG_Z),
];
const WALL: u32 = 24;

/// Albedo below which a surface appears black under any light.
const BLACK: f32 = 1.0 / 256.0;

/// Thresholds on the fractions of surface pixels that are lit at all, and lit by reflected light.
const LIT: f64 = 0.25;
const REFLECTING: f64 = 0.125;
/// Relative luminance below which a pixel is not lit: one step of an 8-bit image.
const SEEN: f64 = 1.0 / 256.0;
/// Percentile of the luminance that counts as the brightness of the image.
const PERCENTILE: f64 = 0.99;

/// A scene and the view of it.
#[derive(Clone, Copy)]
pub struct Look<'a> {
    pub scene: &'a Scene,
    pub camera: &'a Camera,
    pub backfaces: Backfaces,
}

/// A small render: the image, the ids of the visible objects + 1 (0 where there is none), and their albedo.
struct Preview {
    picture: Image,
    surfaces: Image,
    albedo: Image,
}

impl Look<'_> {
    fn settings(&self, size: (u32, u32), spp: u32, max_bounces: u32) -> Settings {
        Settings {
            size,
            max_bounces,
            backfaces: self.backfaces,
            aovs: vec![Aov::Albedo, Aov::ObjectId],
            ..Settings::default()
        }
        .with_threads(1)
        .with_spp(spp)
    }

    fn at(&self, settings: &Settings) -> Preview {
        let progress =
            |_| if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let outcome = render(self.scene, self.camera, settings, &progress);
        let layer = |aov: Aov| {
            let layer = outcome.layers.picture(&aov.to_string());
            layer.unwrap_or_else(|| Image::filled(0, 0, Vec3::ZERO))
        };
        let (surfaces, albedo) = (layer(Aov::ObjectId), layer(Aov::Albedo));
        Preview { picture: outcome.film.mean(), surfaces, albedo }
    }

    /// Whether almost none of the visible surfaces are lit by the existing lights.
    pub fn is_nearly_black(&self) -> bool {
        let glance = self.at(&self.settings(GLANCE, 1, 1));
        let black = Image::filled(glance.picture.width, glance.picture.height, Vec3::ZERO);
        if shares(&glance.picture, &black, &glance.surfaces).is_some_and(|(lit, _)| lit > CLEARLY) {
            return false;
        }
        let emitted = self.at(&self.settings(SIZE, SAMPLES, 0));
        let whole = self.at(&self.settings(SIZE, SAMPLES, Settings::default().max_bounces));
        is_dark(&whole.picture, &emitted.picture, &emitted.surfaces)
    }

    /// Whether almost all visible surfaces are nearly black in an image with metered exposure.
    pub fn appears_black(&self) -> bool {
        let seen = self.at(&self.settings(SIZE, SAMPLES, Settings::default().max_bounces));
        let scale = metering::exposure(&seen.picture).exp2();
        let pairs = seen.picture.pixels.iter().zip(&seen.surfaces.pixels).filter(|(_, id)| id.x > 0.0);
        let (mut shown, mut visible) = (0_u32, 0_u32);
        for (radiance, _) in pairs {
            shown += 1;
            visible += u32::from(f64::from((*radiance * scale).max_element()) >= SEEN);
        }
        f64::from(visible) < LIT * f64::from(shown)
    }

    /// Whether almost none of the visible surfaces reflect light.
    pub fn is_of_black_surfaces(&self) -> bool {
        let seen = self.at(&Settings { picture: false, ..self.settings(SIZE, SAMPLES, 0) });
        let pairs = seen.albedo.pixels.iter().zip(&seen.surfaces.pixels);
        let (mut shown, mut black) = (0_u32, 0_u32);
        for (albedo, _) in pairs.filter(|(_, id)| id.x > 0.0) {
            shown += 1;
            black += u32::from(albedo.max_element() < BLACK);
        }
        f64::from(shown - black) < LIT * f64::from(shown)
    }

    /// Whether any camera ray hits a surface. The resolutions of [`PROBES`] are tried in turn until one finds a hit.
    /// `size` is the width and height of the image.
    pub fn shows_a_surface(&self, size: (u32, u32)) -> bool {
        let aspect = (f64::from(size.0.max(1)) / f64::from(size.1.max(1))).sqrt();
        PROBES.iter().any(|&(side, spp)| {
            let length = |scale: f64| (side * scale).round().max(1.0) as u32;
            let settings = self.settings((length(aspect), length(1.0 / aspect)), spp, 0);
            self.meets(&settings).any(|met| met)
        })
    }

    /// Whether the camera is enclosed on all sides: every ray from its position hits a surface.
    pub fn is_enclosed(&self) -> bool {
        AROUND.iter().all(|(right, up)| {
            let camera = Camera {
                right: *right,
                up: *up,
                backward: right.cross(*up),
                projection: Projection::Perspective { tan_half: 1.0 },
                lens: None,
                motion: None,
                aspect: None,
                clip: None,
                ..*self.camera
            };
            let look = Look { camera: &camera, backfaces: Backfaces::Shown, ..*self };
            look.meets(&look.settings((WALL, WALL), 1, 0)).all(|met| met)
        })
    }

    /// Returns for each pixel whether its camera ray hits a surface.
    fn meets(&self, settings: &Settings) -> impl Iterator<Item = bool> {
        let aovs = vec![Aov::ObjectId];
        let seen = self.at(&Settings { picture: false, aovs, ..settings.clone() });
        seen.surfaces.pixels.into_iter().map(|id| id.x > 0.0)
    }
}

/// Evaluates the rule for the image, the emitted part of its light, and the mask of surfaces.
fn is_dark(all: &Image, emitted: &Image, surfaces: &Image) -> bool {
    shares(all, emitted, surfaces).is_some_and(|(lit, reflecting)| lit < LIT && reflecting < REFLECTING)
}

/// Returns the fractions of the surface pixels that are lit, and that reflect light; `None` if no pixel shows a
/// surface.
fn shares(all: &Image, emitted: &Image, surfaces: &Image) -> Option<(f64, f64)> {
    let luminance = |p: &Image| -> Vec<f64> {
        p.pixels.iter().map(|p| f64::from(color::luminance(*p)).max(0.0)).collect()
    };
    let (all, emitted) = (luminance(all), luminance(emitted));
    let mut sorted = all.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let bright = sorted.get((sorted.len() as f64 * PERCENTILE) as usize).copied().unwrap_or(0.0);
    let is_seen = |y: f64| y > 0.0 && y >= bright * SEEN;
    let (mut shown, mut lit, mut reflecting) = (0.0, 0.0, 0.0);
    for i in (0..all.len()).filter(|i| surfaces.pixels.get(*i).is_some_and(|id| id.x > 0.0)) {
        shown += 1.0;
        lit += f64::from(u8::from(is_seen(all[i])));
        reflecting += f64::from(u8::from(is_seen(all[i] - emitted[i])));
    }
    (shown > 0.0).then(|| (lit / shown, reflecting / shown))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evaluates the rule on 1000 surface pixels: `glowing` emit, the next `reflecting` reflect, and the rest is black.
    fn dark(glowing: usize, reflecting: usize, reflected: f32) -> bool {
        let pixels = |reflected: f32| -> Image {
            let value = |i: usize| match i {
                i if i < glowing => 1.0,
                i if i < glowing + reflecting => reflected,
                _ => 0.0,
            };
            let pixels = (0..1000).map(|i| Vec3::splat(value(i))).collect();
            Image { width: 1000, height: 1, pixels }
        };
        is_dark(&pixels(reflected), &pixels(0.0), &Image::filled(1000, 1, Vec3::ONE))
    }

    #[test]
    fn the_rule() {
        assert!(dark(0, 0, 0.0) && dark(100, 0, 0.0) && dark(240, 0, 0.0), "almost nothing is lit");
        assert!(!dark(260, 0, 0.0), "emitters fill enough of the image");
        assert!(dark(30, 80, 1.0) && !dark(30, 140, 1.0), "lit surfaces fill enough of the image");
        assert!(dark(0, 100, 1e-9), "a rim lit by stray light, however bright relative to the rest");
        assert!(dark(30, 900, 1e-3) && !dark(30, 900, 5e-3), "steps of an 8-bit image");
        let nothing = Image::filled(10, 1, Vec3::ZERO);
        assert!(!is_dark(&nothing, &nothing, &nothing), "no surface is visible");
    }
}
