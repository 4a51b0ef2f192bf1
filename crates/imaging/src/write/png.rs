//! PNG encoding by the `image` crate (pure Rust deflate, which gives the same bytes everywhere), with additional
//! chunks.

use super::options::{PngDepth, PngOptions};
use crate::{Image, ImageError};
use glam::Vec3;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use std::path::Path;

/// The code values of an image, row by row: red, green, blue, and alpha if present. `code` converts each value in [0,
/// 1].
pub(super) fn code_values<const N: usize>(
    picture: &Image,
    options: &PngOptions<'_>,
    code: impl Fn(f32) -> [u8; N],
) -> Vec<u8> {
    let scale = libm::exp2f(options.exposure);
    let channels = if options.alpha.is_some() { 4 } else { 3 };
    let mut bytes = Vec::with_capacity(picture.pixels.len() * channels * N);
    for (i, &pixel) in picture.pixels.iter().enumerate() {
        let alpha = options.alpha.map(|alpha| alpha[i].clamp(0.0, 1.0));
        let colour = match alpha {
            Some(alpha) if alpha > 0.0 => pixel / alpha,
            Some(_) => Vec3::ZERO,
            None => pixel,
        };
        bytes.extend(options.tone.apply(colour * scale).to_array().into_iter().flat_map(&code));
        bytes.extend(alpha.into_iter().flat_map(&code));
    }
    bytes
}

/// Encodes code values, with or without alpha. The caller has checked that there are `width * height` pixels; this
/// function checks that the last one is complete.
pub(super) fn encode(
    path: &Path,
    (width, height): (usize, usize),
    data: &[u8],
    kind: (bool, PngDepth),
    texts: &[(&str, &str)],
) -> Result<Vec<u8>, ImageError> {
    let wrong = |why: String| ImageError::Inconsistent { path: path.to_path_buf(), why };
    let (color, bytes) = match kind {
        (false, PngDepth::Eight) => (ExtendedColorType::Rgb8, 3),
        (false, PngDepth::Sixteen) => (ExtendedColorType::Rgb16, 6),
        (true, PngDepth::Eight) => (ExtendedColorType::Rgba8, 4),
        (true, PngDepth::Sixteen) => (ExtendedColorType::Rgba16, 8),
    };
    if data.len() != width * height * bytes {
        return Err(wrong("the last pixel is incomplete".into()));
    }
    let mut file = Vec::new();
    PngEncoder::new_with_quality(&mut file, CompressionType::Default, FilterType::Adaptive)
        .write_image(data, width as u32, height as u32, color)
        .map_err(|e| wrong(e.to_string()))?;
    file.splice(HEADER..HEADER, metadata_chunks(texts));
    Ok(file)
}

/// Length of the signature and header of a PNG, after which other chunks follow.
const HEADER: usize = 8 + 25;

/// Chunks before the image data: sRGB with the perceptual intent [PNG 2003, §11.3.3.5], and the texts.
fn metadata_chunks(texts: &[(&str, &str)]) -> Vec<u8> {
    let mut chunks = chunk(b"sRGB", &[0]);
    for (keyword, text) in texts {
        let text = text.replace(|c: char| c.is_control() && c != '\n', "?");
        if text.is_ascii() {
            chunks.extend(chunk(b"tEXt", &[keyword.as_bytes(), b"\0", text.as_bytes()].concat()));
        } else {
            // Uncompressed, with empty language tag and translated keyword.
            let body = [keyword.as_bytes(), b"\0\0\0\0\0", text.as_bytes()].concat();
            chunks.extend(chunk(b"iTXt", &body));
        }
    }
    chunks
}

fn chunk(kind: &[u8; 4], body: &[u8]) -> Vec<u8> {
    let kind_and_body = [&kind[..], body].concat();
    let length = (body.len() as u32).to_be_bytes();
    [&length[..], &kind_and_body, &crc(&kind_and_body).to_be_bytes()].concat()
}

/// The CRC of PNG chunks [PNG 2003, annex D]: polynomial 0x04C11DB7, reflected.
fn crc(bytes: &[u8]) -> u32 {
    let step = |c: u32| if c & 1 == 1 { 0xEDB8_8320 ^ (c >> 1) } else { c >> 1 };
    !bytes.iter().fold(!0, |c, byte| (0..8).fold(c ^ u32::from(*byte), |c, _| step(c)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_values_of_the_crc() {
        assert_eq!(crc(b"123456789"), 0xCBF4_3926);
        // The last chunk of every PNG.
        assert_eq!(crc(b"IEND"), 0xAE42_6082);
    }

    #[test]
    fn texts_are_chunks_that_readers_pass_over() {
        let data: Vec<u8> = (0..4 * 3 * 3).collect();
        let texts = [("Comment", "half\u{1b} black"), ("settings", "spp = 3\ncamera = \"µ\"")];
        let file = encode(Path::new("a.png"), (4, 3), &data, (false, PngDepth::Eight), &texts).unwrap();
        let has = |part: &[u8]| file.windows(part.len()).any(|w| w == part);
        assert!(has(b"tEXtComment\0half? black"));
        assert!(has("iTXtsettings\0\0\0\0\0spp = 3\ncamera = \"µ\"".as_bytes()));
        assert!(has(b"\0\0\0\x01sRGB\0\xae\xce\x1c\xe9"));
        assert_eq!(image::load_from_memory(&file).unwrap().into_rgb8().into_raw(), data);
    }
}
