//! Automatic exposure of an image.
//!
//! The rule is documented at [`exposure`]. It uses only the image, not the scene or the camera, and gives the same
//! value for the same image on every machine.

use crate::Image;

/// Fraction of the lit pixels that are at most as bright as the pixel that is exposed to [`BRIGHT`].
const PERCENTILE: f64 = 0.9;
/// Linear value of that pixel, where 1 is the white of the display.
const BRIGHT: f64 = 0.8;
/// Minimum linear value of the logarithmic mean of the lit pixels.
const MEAN: f64 = 0.1;
/// Pixels darker than this fraction of the brightest one are not lit and are excluded from all statistics.
const LIT: f64 = 1e-6;
/// Steps per stop. The exposure is rounded to a short number, so that it can be printed and reproduced exactly.
const STEPS: f64 = 100.0;

/// A suitable exposure for a linear image, in stops, rounded to a multiple of 0.01. With it, nine tenths of the lit
/// pixels are below 0.8 of the display's white. If the logarithmic mean of the lit pixels would then be below 0.1, the
/// exposure is raised so that the mean is 0.1, which prevents a lamp that fills much of the image from making the room
/// dark. Lit pixels are those with at least a millionth of the brightness of the brightest finite one. Returns 0 for an
/// image without light.
///
/// The brightness of a pixel is its largest channel, so that the shading of saturated colours is not clipped at the
/// display's white: a blue surface has a fourteenth of the luminance of a white one. The logarithmic mean as a measure
/// of a scene's key is from [Reinhard 2002, eq. 1].
pub fn exposure(picture: &Image) -> f32 {
    let finite = picture.pixels.iter().filter(|p| p.is_finite());
    let mut lit: Vec<f64> = finite.map(|p| f64::from(p.max_element())).filter(|y| *y > 0.0).collect();
    lit.sort_unstable_by(f64::total_cmp);
    let Some(brightest) = lit.last().copied() else { return 0.0 };
    lit.retain(|y| *y >= brightest * LIT);
    let bright = lit[((lit.len() - 1) as f64 * PERCENTILE) as usize];
    let mean = libm::exp(lit.iter().map(|y| libm::log(*y)).sum::<f64>() / lit.len() as f64);
    let stops = libm::log2((BRIGHT / bright).max(MEAN / mean));
    ((stops * STEPS).round() / STEPS) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn of(parts: &[(f32, usize)]) -> f32 {
        let pixels: Vec<Vec3> =
            parts.iter().flat_map(|(y, n)| std::iter::repeat_n(Vec3::splat(*y), *n)).collect();
        exposure(&Image { width: pixels.len(), height: 1, pixels })
    }

    #[test]
    fn scale_is_undone() {
        let parts = [(0.2, 50), (0.5, 40), (0.9, 10)];
        let at = of(&parts);
        // log₂(0.8/0.5)
        assert!((at - 0.68).abs() < 0.006, "{at}");
        for stops in [-20, -3, 5, 10] {
            let scaled = parts.map(|(y, n)| (y * 2f32.powi(stops), n));
            assert!((of(&scaled) - (at - stops as f32)).abs() < 0.011, "{stops}");
        }
    }

    #[test]
    fn black_pixels_and_single_fireflies_do_not_count() {
        assert_eq!(of(&[(0.0, 10)]), 0.0);
        assert_eq!(of(&[]), 0.0);
        assert_eq!(of(&[(f32::NAN, 3), (f32::INFINITY, 3), (-1.0, 1)]), 0.0);
        let plain = of(&[(0.8, 100)]);
        assert_eq!(plain, 0.0);
        assert_eq!(of(&[(0.8, 100), (0.0, 900)]), plain);
        assert_eq!(of(&[(0.8, 100), (400.0, 1)]), plain);
    }

    /// A third of the image is a lamp a thousand times as bright as the walls.
    #[test]
    fn a_large_lamp_leaves_the_room_visible() {
        let at = of(&[(0.2, 200), (200.0, 100)]);
        let mean = 0.2f64 * 1000f64.powf(1.0 / 3.0);
        assert!((f64::from(at) - (0.1 / mean).log2()).abs() < 0.006, "{at}");
    }

    #[test]
    fn saturated_colours_are_shown_like_white() {
        let shades = |color: Vec3| {
            let pixels: Vec<Vec3> = (1..=100).map(|i| color * (0.01 * i as f32)).collect();
            exposure(&Image { width: pixels.len(), height: 1, pixels })
        };
        let white = shades(Vec3::ONE);
        for color in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(0.2, 0.1, 1.0)] {
            assert_eq!(shades(color), white, "{color}");
        }
    }

    #[test]
    fn the_value_is_a_short_decimal() {
        let at = of(&[(0.37, 7), (0.11, 9)]);
        assert_eq!(format!("{at:.2}").parse::<f32>().unwrap(), at);
    }
}
