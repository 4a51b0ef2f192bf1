//! PNG, JPEG, WebP and Radiance HDR through the `image` crate.

use super::{Kind, MAX_PIXELS, Rgba8, Rgba16, Texels, check_size};
use crate::color::{decode_f64, srgb_table};
use crate::{ImageError, Picture};
use glam::Vec3;
use image::codecs::hdr::HdrDecoder;
use image::codecs::jpeg::JpegDecoder;
use image::codecs::png::PngDecoder;
use image::codecs::webp::WebPDecoder;
use image::error::LimitErrorKind;
use image::{DynamicImage, ImageDecoder, Limits};
use std::io::{BufRead, ErrorKind, Seek};

pub(super) fn picture(file: impl BufRead + Seek, kind: Kind, name: &str) -> Result<Picture, ImageError> {
    let decoded = decode(file, kind, name)?;
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    let pixels = match decoded {
        DynamicImage::ImageRgb32F(image) => image.pixels().map(|p| Vec3::from(p.0)).collect(),
        image if image.color().bytes_per_pixel() > image.color().channel_count() => {
            let table: Vec<f32> = (0..=65_535).map(|i| decode_f64(i as f64 / 65_535.0)).collect();
            let linear = |p: &image::Rgb<u16>| Vec3::from(p.0.map(|c| table[c as usize]));
            image.into_rgb16().pixels().map(linear).collect()
        }
        image => {
            let linear = |p: &image::Rgb<u8>| Vec3::from(p.0.map(|c| srgb_table()[c as usize]));
            image.into_rgb8().pixels().map(linear).collect()
        }
    };
    Ok(Picture { width, height, pixels })
}

/// Whether the file holds grey, with alpha or without.
pub(super) fn is_grey(file: impl BufRead + Seek, kind: Kind, name: &str) -> Result<bool, ImageError> {
    decode(file, kind, name).map(|image| !image.color().has_color())
}

pub(super) fn rgba8(file: impl BufRead + Seek, kind: Kind, name: &str) -> Result<Rgba8, ImageError> {
    let image = decode(file, kind, name)?.into_rgba8();
    let (width, height) = (image.width() as usize, image.height() as usize);
    Ok(Rgba8 { width, height, texels: image.pixels().map(|p| p.0).collect() })
}

/// Of 16 bits where the file has them.
pub(super) fn texels(file: impl BufRead + Seek, kind: Kind, name: &str) -> Result<Texels, ImageError> {
    let image = decode(file, kind, name)?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    if image.color().bytes_per_pixel() > image.color().channel_count() {
        let texels = image.into_rgba16().pixels().map(|p| p.0).collect();
        return Ok(Rgba16 { width, height, texels }.into());
    }
    let texels = image.into_rgba8().pixels().map(|p| p.0).collect();
    Ok(Rgba8 { width, height, texels }.into())
}

fn decode(file: impl BufRead + Seek, kind: Kind, name: &str) -> Result<DynamicImage, ImageError> {
    match kind {
        Kind::Png => {
            let decoder = PngDecoder::with_limits(file, limits()).map_err(|e| failure(e, name))?;
            load(decoder, name)
        }
        Kind::Jpeg => load(JpegDecoder::new(file).map_err(|e| failure(e, name))?, name),
        Kind::WebP => load(WebPDecoder::new(file).map_err(|e| failure(e, name))?, name),
        // Not strict: files that begin with #?RGBE are as common as those with #?RADIANCE.
        Kind::Hdr => load(HdrDecoder::new_nonstrict(file).map_err(|e| failure(e, name))?, name),
        Kind::Exr => Err(ImageError::NotAPicture { name: name.to_string() }),
    }
}

fn load(mut decoder: impl ImageDecoder, name: &str) -> Result<DynamicImage, ImageError> {
    let (width, height) = decoder.dimensions();
    check_size(name, width.into(), height.into(), decoder.color_type().channel_count().into())?;
    decoder.set_limits(limits()).map_err(|e| failure(e, name))?;
    DynamicImage::from_decoder(decoder).map_err(|e| failure(e, name))
}

fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_PIXELS * 16);
    limits
}

/// Says in our words what the decoder said in its own.
fn failure(error: image::ImageError, name: &str) -> ImageError {
    use image::ImageError as E;
    let name = name.to_string();
    match error {
        E::Unsupported(e) => ImageError::Unsupported { name, what: e.to_string() },
        E::Limits(e) if matches!(e.kind(), LimitErrorKind::Unsupported { .. }) => {
            ImageError::Unsupported { name, what: e.to_string() }
        }
        E::IoError(source) if source.kind() != ErrorKind::UnexpectedEof => ImageError::Read { name, source },
        other => ImageError::Malformed { name, why: other.to_string() },
    }
}
