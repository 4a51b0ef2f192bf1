//! Does the file's own light show what is in it?
//!
//! A file may hold a light and still leave its picture black: a few texels of an emissive texture on an object that nothing
//! else lights. The rule: **a studio environment is added when, in a small render, less than a quarter of the pixels that
//! show a surface are lit, and less than an eighth by light that the surface reflects; lit means at least 1/256 of the
//! luminance that 99 % of the pixels stay below.** The share, not the brightness, decides: whatever is lit is exposed to be
//! seen, and would be a few bright spots on black. The render is always the same for a scene and a view. A glance comes
//! first: where direct light alone already shows most of the surfaces, nothing more is asked.
//!
//! So a planet in the sun stays dark on its far side, a room with one candle stays dim, and panels that glow by themselves
//! are left alone.

use crate::interrupt;
use dapple_integrator::camera::Camera;
use dapple_integrator::imaging::{Image, color};
use dapple_integrator::scene::Scene;
use dapple_integrator::{Aov, Backfaces, Settings, render};
use glam::Vec3;
use std::ops::ControlFlow;

/// Size of the small render, and its samples per pixel.
const SIZE: (u32, u32) = (48, 36);
const SAMPLES: u32 = 8;

/// The glance: its size, at one sample per pixel, and the share of the surfaces that it has to find lit.
const GLANCE: (u32, u32) = (16, 12);
const CLEARLY: f64 = 0.4;

/// Shares of the pixels that show a surface: lit at all, and by light that it reflects.
const LIT: f64 = 0.25;
const REFLECTING: f64 = 0.125;
/// Part of the picture's brightness: less is below one step of an 8-bit image.
const SEEN: f64 = 1.0 / 256.0;
/// Which brightness is the picture's: that of the pixel that so large a share are not brighter than.
const PERCENTILE: f64 = 0.99;

/// Whether the scene, seen by `camera`, is nearly black by its own light.
pub fn is_wanted(scene: &Scene, camera: &Camera, backfaces: Backfaces) -> bool {
    let progress = |_| if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    // The picture, and a mask that is 0 where no surface is seen.
    let look = |settings: &Settings| {
        let outcome = render(scene, camera, settings, &progress);
        (
            outcome.film.mean(),
            outcome
                .layers
                .picture(&Aov::ObjectId.to_string())
                .unwrap_or_else(|| Image::filled(0, 0, Vec3::ZERO)),
        )
    };
    let aovs = vec![Aov::Albedo, Aov::ObjectId];
    let glance = Settings { size: GLANCE, max_bounces: 1, backfaces, aovs, ..Settings::default() }
        .with_threads(1)
        .with_spp(1);
    let (picture, surfaces) = look(&glance);
    let black = Image::filled(picture.width, picture.height, Vec3::ZERO);
    if shares(&picture, &black, &surfaces).is_some_and(|(lit, _)| lit > CLEARLY) {
        return false;
    }
    let whole =
        Settings { size: SIZE, max_bounces: Settings::default().max_bounces, ..glance }.with_spp(SAMPLES);
    let (emitted, surfaces) = look(&Settings { max_bounces: 0, ..whole.clone() });
    is_dark(&look(&whole).0, &emitted, &surfaces)
}

/// The rule, for the picture, the light in it that surfaces emit, and the mask.
fn is_dark(all: &Image, emitted: &Image, surfaces: &Image) -> bool {
    shares(all, emitted, surfaces).is_some_and(|(lit, reflecting)| lit < LIT && reflecting < REFLECTING)
}

/// Of the pixels that show a surface, the shares that are lit, and that reflect light; None if there are none.
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

    /// 1000 pixels, of which so many glow, so many reflect, and the rest is black; all show a surface.
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
        assert!(dark(0, 0, 0.0) && dark(100, 0, 0.0) && dark(240, 0, 0.0), "next to nothing is lit");
        assert!(!dark(260, 0, 0.0), "what glows is the picture");
        assert!(dark(30, 80, 1.0) && !dark(30, 140, 1.0), "what is lit is the picture");
        assert!(dark(0, 100, 1e-9), "a rim that stray light reaches, however bright beside the rest");
        assert!(dark(30, 900, 1e-3) && !dark(30, 900, 5e-3), "steps of an 8-bit image");
        let nothing = Image::filled(10, 1, Vec3::ZERO);
        assert!(!is_dark(&nothing, &nothing, &nothing), "no surface is in the picture");
    }
}
