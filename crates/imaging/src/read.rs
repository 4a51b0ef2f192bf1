//! Files to pictures. The kind is told by content, not by name.

use crate::{ImageError, Layers, Picture};
use std::path::Path;

/// Most pixels of a picture that is read: beyond it a small file could ask for all memory.
pub const MAX_PIXELS: u64 = 1 << 28;

/// RGBA bytes, row by row from the top.
#[derive(Clone, Debug)]
pub struct Rgba8 {
    /// Texels across.
    pub width: usize,
    /// Texels down.
    pub height: usize,
    /// `width`·`height` of them.
    pub texels: Vec<[u8; 4]>,
}

/// .exr (first RGB layer), .hdr, and .png, .jpg or .webp with sRGB decoded to linear.
pub fn picture(path: &Path) -> Result<Picture, ImageError> {
    let bytes = bytes(path)?;
    let name = path.display().to_string();
    if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        let layers = exr_layers(&bytes, &name)?;
        return layers.beauty().ok_or_else(|| ImageError::malformed(&name, "it has no R, G, B or Y channel"));
    }
    decode(&bytes, &name)
}

/// All layers of an EXR.
pub fn layers(path: &Path) -> Result<Layers, ImageError> {
    exr_layers(&bytes(path)?, &path.display().to_string())
}

fn bytes(path: &Path) -> Result<Vec<u8>, ImageError> {
    std::fs::read(path).map_err(|source| ImageError::Open { path: path.into(), source })
}

fn check_size(name: &str, width: u64, height: u64) -> Result<(), ImageError> {
    if width.saturating_mul(height) > MAX_PIXELS {
        return Err(ImageError::TooLarge { name: name.into(), width, height, limit: MAX_PIXELS });
    }
    if width == 0 || height == 0 {
        return Err(ImageError::malformed(name, "it has no pixels"));
    }
    Ok(())
}

#[cfg(feature = "png")]
fn reader<'a>(
    bytes: &'a [u8],
    name: &str,
) -> Result<image::ImageReader<std::io::Cursor<&'a [u8]>>, ImageError> {
    let wrong = |e: &dyn std::fmt::Display| ImageError::malformed(name, e);
    let open = || image::ImageReader::new(std::io::Cursor::new(bytes)).with_guessed_format();
    let (width, height) = open().map_err(|e| wrong(&e))?.into_dimensions().map_err(|e| wrong(&e))?;
    check_size(name, width.into(), height.into())?;
    let mut reader = open().map_err(|e| wrong(&e))?;
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(16 * MAX_PIXELS);
    reader.limits(limits);
    Ok(reader)
}

/// Encoded bytes (png, jpeg, webp by content) to RGBA8; 16-bit values are narrowed, colour profiles ignored. `name` is
/// for the error message.
#[cfg(feature = "png")]
pub fn rgba8(bytes: &[u8], name: &str) -> Result<Rgba8, ImageError> {
    let image = reader(bytes, name)?.decode().map_err(|e| ImageError::malformed(name, e))?.into_rgba8();
    let (width, height) = (image.width() as usize, image.height() as usize);
    Ok(Rgba8 { width, height, texels: image.pixels().map(|p| p.0).collect() })
}

#[cfg(feature = "png")]
fn decode(bytes: &[u8], name: &str) -> Result<Picture, ImageError> {
    use crate::color::{SRGB_BYTE, srgb_to_linear};
    use glam::Vec3;
    let image = reader(bytes, name)?.decode().map_err(|e| ImageError::malformed(name, e))?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    let deep = image.color().bytes_per_pixel() / image.color().channel_count() > 1;
    let pixels = match &image {
        image::DynamicImage::ImageRgb32F(i) => i.pixels().map(|p| Vec3::from(p.0)).collect(),
        image::DynamicImage::ImageRgba32F(_) => image.to_rgb32f().pixels().map(|p| Vec3::from(p.0)).collect(),
        _ if deep => image
            .to_rgb16()
            .pixels()
            .map(|p| Vec3::from(p.0.map(|c| srgb_to_linear(f32::from(c) / 65535.0))))
            .collect(),
        _ => image.to_rgb8().pixels().map(|p| Vec3::from(p.0.map(|c| SRGB_BYTE[c as usize]))).collect(),
    };
    Ok(Picture { width, height, pixels })
}

/// Left out of this build.
#[cfg(not(feature = "png"))]
pub fn rgba8(_: &[u8], name: &str) -> Result<Rgba8, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.into(), format: "PNG, JPEG and WebP", feature: "png" })
}

#[cfg(not(feature = "png"))]
fn decode(_: &[u8], name: &str) -> Result<Picture, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.into(), format: "PNG, JPEG, WebP and HDR", feature: "png" })
}

#[cfg(not(feature = "exr"))]
fn exr_layers(_: &[u8], name: &str) -> Result<Layers, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.into(), format: "OpenEXR", feature: "exr" })
}

#[cfg(feature = "exr")]
fn exr_layers(bytes: &[u8], name: &str) -> Result<Layers, ImageError> {
    // The decoder is known to panic on some damaged files; a picture must never end the program.
    std::panic::catch_unwind(|| exr_decode(bytes, name))
        .unwrap_or_else(|_| Err(ImageError::malformed(name, "damaged EXR")))
}

#[cfg(feature = "exr")]
fn exr_decode(bytes: &[u8], name: &str) -> std::result::Result<crate::Layers, ImageError> {
    use exr::prelude::*;
    let wrong = |e: &dyn std::fmt::Display| ImageError::malformed(name, e);
    let meta =
        exr::meta::MetaData::read_from_buffered(std::io::Cursor::new(bytes), false).map_err(|e| wrong(&e))?;
    for header in &meta.headers {
        check_size(name, header.layer_size.x() as u64, header.layer_size.y() as u64)?;
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes))
        .map_err(|e| wrong(&e))?;
    let first = image.layer_data.first().ok_or_else(|| ImageError::malformed(name, "it has no layer"))?;
    let (size, position) = (first.size, first.attributes.layer_position);
    let window = image.attributes.display_window;
    let mut out = crate::Layers {
        width: size.x(),
        height: size.y(),
        offset: (position.x() - window.position.x(), position.y() - window.position.y()),
        full_size: (window.size.x(), window.size.y()),
        ..crate::Layers::default()
    };
    for layer in image.layer_data.iter().filter(|layer| layer.size == size) {
        let part = layer.attributes.layer_name.as_ref().map(ToString::to_string).unwrap_or_default();
        for channel in &layer.channel_data.list {
            add_channel(
                &mut out,
                &part,
                &channel.name.to_string(),
                channel.sample_data.values_as_f32().collect(),
            );
        }
        for (key, value) in &layer.attributes.other {
            if let AttributeValue::Text(text) = value {
                out.metadata.push((key.to_string(), crate::MetaValue::Text(text.to_string())));
            }
        }
    }
    out.metadata.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(out)
}

/// `albedo.R` goes to layer `albedo` as `R`; a part's own name comes before.
#[cfg(feature = "exr")]
fn add_channel(out: &mut crate::Layers, part: &str, name: &str, values: Vec<f32>) {
    let (layer, channel) = name.rsplit_once('.').unwrap_or(("", name));
    let layer = if out.layers.is_empty() || part.is_empty() || !layer.is_empty() { layer } else { part };
    match out.layers.iter_mut().find(|l| l.name == layer) {
        Some(found) => found.channels.push((channel.into(), values)),
        None => {
            out.layers.push(crate::Layer { name: layer.into(), channels: vec![(channel.into(), values)] })
        }
    }
}
