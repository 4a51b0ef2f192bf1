//! Decoding of PNG, JPEG, WebP and Radiance HDR by the `image` crate.

use super::kind::Kind;
use super::limits::{MAX_PIXELS, Room, check_size};
use super::texels::{Rgba8, Rgba16, Texels};
use crate::color::{decode_f64, srgb_table};
use crate::{Image, ImageError};
use glam::Vec3;
use image::codecs::hdr::HdrDecoder;
use image::codecs::jpeg::JpegDecoder;
use image::codecs::png::PngDecoder;
use image::codecs::webp::WebPDecoder;
use image::error::LimitErrorKind;
use image::{DynamicImage, ImageDecoder, Limits};
use std::io::{BufRead, ErrorKind, Seek};

/// Bytes per pixel in addition to the decoded image: linear colour, and RGB of 16 bits as an intermediate result.
const PICTURE_BYTES: u64 = 12 + 6;
/// Bytes per pixel in addition to the decoded image: RGBA, twice.
const RGBA8_BYTES: u64 = 8;

pub(super) fn picture(
    file: impl BufRead + Seek,
    kind: Kind,
    name: &str,
    room: Room,
) -> Result<Image, ImageError> {
    let decoded = decode(decoder(file, kind, name)?, name, room, PICTURE_BYTES)?;
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
    Ok(Image { width, height, pixels })
}

/// Whether the image is grey, with or without alpha, according to its header.
pub(super) fn is_grey(file: impl BufRead + Seek, kind: Kind, name: &str) -> Result<bool, ImageError> {
    decoder(file, kind, name).map(|decoder| !decoder.color_type().has_color())
}

/// Width and height according to the header.
pub(super) fn size(file: impl BufRead + Seek, kind: Kind, name: &str) -> Result<[u64; 2], ImageError> {
    let (width, height) = decoder(file, kind, name)?.dimensions();
    Ok([width.into(), height.into()])
}

pub(super) fn rgba8(
    file: impl BufRead + Seek,
    kind: Kind,
    name: &str,
    room: Room,
) -> Result<Rgba8, ImageError> {
    let image = decode(decoder(file, kind, name)?, name, room, RGBA8_BYTES)?.into_rgba8();
    let (width, height) = (image.width() as usize, image.height() as usize);
    Ok(Rgba8 { width, height, texels: image.pixels().map(|p| p.0).collect() })
}

/// Decodes texels, with 16 bits if the file has them.
pub(super) fn texels(
    file: impl BufRead + Seek,
    kind: Kind,
    name: &str,
    room: Room,
) -> Result<Texels, ImageError> {
    let decoder = decoder(file, kind, name)?;
    let deep = decoder.color_type().bytes_per_pixel() > decoder.color_type().channel_count();
    let image = decode(decoder, name, room, if deep { 2 * RGBA8_BYTES } else { RGBA8_BYTES })?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    if deep {
        let texels = image.into_rgba16().pixels().map(|p| p.0).collect();
        return Ok(Rgba16 { width, height, texels }.into());
    }
    let texels = image.into_rgba8().pixels().map(|p| p.0).collect();
    Ok(Rgba8 { width, height, texels }.into())
}

/// The decoder of the file, which has read the header.
fn decoder<'a>(
    file: impl BufRead + Seek + 'a,
    kind: Kind,
    name: &str,
) -> Result<Box<dyn ImageDecoder + 'a>, ImageError> {
    let failed = |e| failure(e, name);
    Ok(match kind {
        Kind::Png => Box::new(PngDecoder::with_limits(file, png_limits()).map_err(failed)?),
        Kind::Jpeg => Box::new(JpegDecoder::new(file).map_err(failed)?),
        Kind::WebP => Box::new(WebPDecoder::new(file).map_err(failed)?),
        // Non-strict, because files that begin with #?RGBE are as common as those with #?RADIANCE.
        Kind::Hdr => Box::new(HdrDecoder::new_nonstrict(file).map_err(failed)?),
        Kind::Exr => return Err(ImageError::NotAPicture { name: name.to_string() }),
    })
}

/// Decodes an image if it fits into `room` together with `beside` additional bytes per pixel.
fn decode(
    mut decoder: impl ImageDecoder,
    name: &str,
    room: Room,
    beside: u64,
) -> Result<DynamicImage, ImageError> {
    let (width, height) = decoder.dimensions();
    let color = decoder.color_type();
    check_size(name, width.into(), height.into(), color.channel_count().into())?;
    room.admit(name, [width.into(), height.into()], u64::from(color.bytes_per_pixel()) + beside, 0)?;
    decoder.set_limits(limits()).map_err(|e| failure(e, name))?;
    DynamicImage::from_decoder(decoder).map_err(|e| failure(e, name))
}

/// Limits for the memory of a PNG decoder in addition to the pixels: rows in progress, and a colour profile, which is
/// skipped if it needs more.
fn png_limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_alloc = Some(1 << 26);
    limits
}

fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_PIXELS * 16);
    limits
}

/// Converts an error of the decoder.
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
