//! Draws a chart with the tone curves side by side: twelve hues and grey from 2^-6 to 2^6, left to right.
//!
//! `cargo run --release --example tone -p dapple-imaging [chart.png]`

use dapple_imaging::sheet::{self, Cell, Frame};
use dapple_imaging::{Image, ImageError, Tone, write};
use glam::Vec3;
use std::path::PathBuf;

const STRIP: usize = 16;
const WIDTH: usize = 256;
const ROWS: usize = 13;

/// A colour on the boundary of the Rec.709 gamut; `turn` in [0, 1).
fn hue(turn: f32) -> Vec3 {
    let ramp = |shift: f32| (((turn + shift).fract() * 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0);
    Vec3::new(ramp(0.0), ramp(2.0 / 3.0), ramp(1.0 / 3.0))
}

fn chart() -> Image {
    let mut picture = Image::filled(WIDTH, ROWS * STRIP, Vec3::ZERO);
    for (i, pixel) in picture.pixels.iter_mut().enumerate() {
        let (x, row) = (i % WIDTH, i / WIDTH / STRIP);
        let colour = if row + 1 == ROWS { Vec3::ONE } else { hue(row as f32 / 12.0) };
        *pixel = colour * ((x as f32 / WIDTH as f32) * 12.0 - 6.0).exp2();
    }
    picture
}

fn main() -> Result<(), ImageError> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("tone.png"), PathBuf::from);
    let chart = chart();
    let cells =
        Tone::ALL.map(|(tone, name)| Cell { frame: Frame::of(&chart, tone, 0.0), label: name.into() });
    let sheet = sheet::grid(&cells, 4);
    write::rgb8(&path, sheet.width, sheet.height, sheet.data)?;
    println!("{}", path.display());
    Ok(())
}
