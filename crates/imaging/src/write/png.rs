//! 8-bit PNG through the `image` crate (pure Rust deflate: the same bytes everywhere).

use crate::ImageError;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use std::path::Path;

/// The caller has checked that there are `width * height` pixels; whether the last one is whole is checked here.
pub(super) fn encode(path: &Path, width: usize, height: usize, data: &[u8]) -> Result<Vec<u8>, ImageError> {
    let wrong = |why: String| ImageError::Inconsistent { path: path.to_path_buf(), why };
    if data.len() != width * height * 3 {
        return Err(wrong("its last pixel lacks a channel".into()));
    }
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
        .write_image(data, width as u32, height as u32, ExtendedColorType::Rgb8)
        .map_err(|e| wrong(e.to_string()))?;
    Ok(bytes)
}

/// Signature and header of a PNG, which other chunks follow.
const HEADER: usize = 8 + 25;

/// `png` with a tEXt chunk of the keyword `Comment` behind its header; what of the text is not ASCII becomes `?`.
pub(super) fn with_comment(mut png: Vec<u8>, comment: &str) -> Vec<u8> {
    let text = comment.chars().map(|c| if c.is_ascii() && !c.is_ascii_control() { c as u8 } else { b'?' });
    let body: Vec<u8> = b"tEXtComment\0".iter().copied().chain(text).collect();
    let mut chunk = ((body.len() - 4) as u32).to_be_bytes().to_vec();
    chunk.extend(&body);
    chunk.extend(crc(&body).to_be_bytes());
    png.splice(HEADER..HEADER, chunk);
    png
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
        // The chunk that ends every PNG.
        assert_eq!(crc(b"IEND"), 0xAE42_6082);
    }

    #[test]
    fn a_comment_is_a_chunk_that_readers_pass_over() {
        let data: Vec<u8> = (0..4 * 3 * 3).collect();
        let plain = encode(Path::new("a.png"), 4, 3, &data).unwrap();
        let noted = with_comment(plain.clone(), "half black µ");
        assert!(noted.windows(24).any(|w| w == b"tEXtComment\0half black ?"));
        let pixels = |bytes: &[u8]| image::load_from_memory(bytes).unwrap().into_rgb8().into_raw();
        assert_eq!((pixels(&plain), pixels(&noted)), (data.clone(), data));
    }
}
