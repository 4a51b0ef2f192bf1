//! A chart of the tone curves: exposure runs to the right, hue downward, one band per curve.
//! `cargo run --release --example tone -p dapple-imaging`

use dapple_imaging::{Tone, text, write};
use glam::Vec3;

fn main() -> Result<(), dapple_imaging::ImageError> {
    const HUES: [Vec3; 4] =
        [Vec3::ONE, Vec3::new(1.0, 0.1, 0.05), Vec3::new(0.1, 1.0, 0.1), Vec3::new(0.05, 0.15, 1.0)];
    let (width, row) = (640, 28);
    let height = Tone::ALL.len() * HUES.len() * row;
    let mut data = vec![0u8; width * height * 3];
    for y in 0..height {
        let (tone, _) = Tone::ALL[y / (HUES.len() * row)];
        let hue = HUES[y / row % HUES.len()];
        for x in 0..width {
            let stops = x as f32 / width as f32 * 14.0 - 7.0;
            let color = tone.apply(hue * 0.18 * libm::exp2f(stops));
            data[(y * width + x) * 3..][..3]
                .copy_from_slice(&color.to_array().map(|c| (c * 255.0 + 0.5) as u8));
        }
    }
    for (i, (_, name)) in Tone::ALL.iter().enumerate() {
        text::draw(&mut data, width, (6, i * HUES.len() * row + 6), 2, [255; 3], name);
    }
    let path = std::path::Path::new("tone.png");
    write::rgb8(path, width, height, data)?;
    println!("{}", path.display());
    Ok(())
}
