//! Two environment maps: by day a gradient, a horizon, a ground and a sun of one texel; by night the lights of a town.

use dapple_imaging::Image;
use glam::Vec3;

const WIDTH: usize = 128;
const HEIGHT: usize = 64;
/// Column and row of the sun: to the upper right behind the camera of `environment.gltf`.
const SUN: (usize, usize) = (112, 18);

/// The day sky: linear radiance, latitude-longitude.
pub fn picture() -> Image {
    let mut pixels = Vec::with_capacity(WIDTH * HEIGHT);
    for row in 0..HEIGHT {
        // 1 at the zenith, 0 at the horizon, −1 at the nadir.
        let height = 1.0 - (2 * row + 1) as f32 / HEIGHT as f32;
        pixels.extend(std::iter::repeat_n(colour(height), WIDTH));
    }
    pixels[SUN.1 * WIDTH + SUN.0] = Vec3::new(900.0, 780.0, 600.0);
    Image { width: WIDTH, height: HEIGHT, pixels }
}

fn colour(height: f32) -> Vec3 {
    let (zenith, horizon, ground) =
        (Vec3::new(0.12, 0.28, 0.75), Vec3::new(0.85, 0.9, 1.0), Vec3::new(0.18, 0.15, 0.12));
    if height < 0.0 {
        return ground;
    }
    let fade = (1.0 - height) * (1.0 - height);
    zenith + (horizon - zenith) * (fade * fade)
}

/// The town: linear radiance, latitude-longitude; a dark sky, and lamps of one texel each just above the horizon ahead
/// (−z).
pub fn town() -> Image {
    const WIDTH: usize = 512;
    const HEIGHT: usize = 256;
    let mut pixels = Vec::with_capacity(WIDTH * HEIGHT);
    for row in 0..HEIGHT {
        let height = 1.0 - (2 * row + 1) as f32 / HEIGHT as f32;
        let fade = if height < 0.0 { 0.3 } else { 1.0 - height };
        pixels.extend(std::iter::repeat_n(Vec3::new(0.012, 0.016, 0.035) * (fade * fade), WIDTH));
    }
    let colours = [
        Vec3::new(1.0, 0.62, 0.25),
        Vec3::new(1.0, 0.85, 0.6),
        Vec3::new(0.5, 0.75, 1.0),
        Vec3::new(1.0, 0.3, 0.2),
    ];
    for i in 0..26 {
        // Steps without a common divisor with the visible width: scattered, but not in rows.
        let column = WIDTH / 2 + (i * 19) % 83 - 41;
        let row = HEIGHT / 2 - 3 - (i * 7) % 11;
        pixels[row * WIDTH + column] = colours[i % 4] * (9.0 + (i * 5 % 7) as f32);
    }
    Image { width: WIDTH, height: HEIGHT, pixels }
}
