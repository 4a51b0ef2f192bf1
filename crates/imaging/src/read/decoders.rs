//! The decoders of this build, guarded against panics. Functions for formats that this build does not support return an
//! error that names the required feature.

#[cfg(feature = "exr")]
use super::exr;
use super::kind::Kind;
use super::limits::Room;
#[cfg(feature = "png")]
use super::raster;
use super::texels::{Rgba8, Texels};
use crate::{Image, ImageError, Layers, Windowed};
use std::io::{BufRead, Seek};

/// A panic of a decoder, which is code of other crates, on malformed content is reported as a damaged file.
#[allow(dead_code, reason = "unused without any decoder")]
fn guarded<T>(name: &str, decode: impl FnOnce() -> Result<T, ImageError>) -> Result<T, ImageError> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(decode)).unwrap_or_else(|_| {
        Err(ImageError::Malformed { name: name.to_string(), why: "the decoder failed".into() })
    })
}

#[cfg(feature = "exr")]
pub(super) fn exr_is_grey(file: impl BufRead + Seek, name: &str) -> Result<bool, ImageError> {
    guarded(name, || exr::is_grey(file, name))
}

#[cfg(feature = "exr")]
pub(super) fn exr_picture(file: impl BufRead + Seek, name: &str, room: Room) -> Result<Image, ImageError> {
    guarded(name, || exr::picture(file, name, room))
}

#[cfg(feature = "exr")]
pub(super) fn exr_windowed(
    file: impl BufRead + Seek,
    name: &str,
    room: Room,
) -> Result<Windowed, ImageError> {
    guarded(name, || exr::windowed(file, name, room))
}

#[cfg(feature = "exr")]
pub(super) fn exr_layers(file: impl BufRead + Seek, name: &str, room: Room) -> Result<Layers, ImageError> {
    guarded(name, || exr::layers(file, name, room))
}

#[cfg(feature = "exr")]
pub(super) fn exr_pixel_count(file: impl BufRead + Seek, name: &str) -> Result<u64, ImageError> {
    guarded(name, || exr::pixel_count(file, name))
}

#[cfg(not(feature = "exr"))]
pub(super) fn exr_pixel_count(_: impl BufRead + Seek, name: &str) -> Result<u64, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: Kind::Exr.name(), feature: "exr" })
}

#[cfg(feature = "png")]
pub(super) fn raster_size(file: impl BufRead + Seek, kind: Kind, name: &str) -> Result<[u64; 2], ImageError> {
    guarded(name, || raster::size(file, kind, name))
}

#[cfg(not(feature = "png"))]
pub(super) fn raster_size(_: impl BufRead + Seek, kind: Kind, name: &str) -> Result<[u64; 2], ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: kind.name(), feature: "png" })
}

#[cfg(feature = "png")]
pub(super) fn raster_is_grey(file: impl BufRead + Seek, kind: Kind, name: &str) -> Result<bool, ImageError> {
    guarded(name, || raster::is_grey(file, kind, name))
}

#[cfg(feature = "png")]
pub(super) fn raster_picture(
    file: impl BufRead + Seek,
    kind: Kind,
    name: &str,
    room: Room,
) -> Result<Image, ImageError> {
    guarded(name, || raster::picture(file, kind, name, room))
}

#[cfg(feature = "png")]
pub(super) fn raster_rgba8(
    file: impl BufRead + Seek,
    kind: Kind,
    name: &str,
    room: Room,
) -> Result<Rgba8, ImageError> {
    guarded(name, || raster::rgba8(file, kind, name, room))
}

#[cfg(feature = "png")]
pub(super) fn raster_texels(
    file: impl BufRead + Seek,
    kind: Kind,
    name: &str,
    room: Room,
) -> Result<Texels, ImageError> {
    guarded(name, || raster::texels(file, kind, name, room))
}

#[cfg(not(feature = "exr"))]
pub(super) fn exr_is_grey(_: impl BufRead + Seek, name: &str) -> Result<bool, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: Kind::Exr.name(), feature: "exr" })
}

#[cfg(not(feature = "exr"))]
pub(super) fn exr_picture(_: impl BufRead + Seek, name: &str, _: Room) -> Result<Image, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: Kind::Exr.name(), feature: "exr" })
}

#[cfg(not(feature = "exr"))]
pub(super) fn exr_windowed(_: impl BufRead + Seek, name: &str, _: Room) -> Result<Windowed, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: Kind::Exr.name(), feature: "exr" })
}

#[cfg(not(feature = "exr"))]
pub(super) fn exr_layers(_: impl BufRead + Seek, name: &str, _: Room) -> Result<Layers, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: Kind::Exr.name(), feature: "exr" })
}

#[cfg(not(feature = "png"))]
pub(super) fn raster_is_grey(_: impl BufRead + Seek, kind: Kind, name: &str) -> Result<bool, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: kind.name(), feature: "png" })
}

#[cfg(not(feature = "png"))]
pub(super) fn raster_picture(
    _: impl BufRead + Seek,
    kind: Kind,
    name: &str,
    _: Room,
) -> Result<Image, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: kind.name(), feature: "png" })
}

#[cfg(not(feature = "png"))]
pub(super) fn raster_rgba8(
    _: impl BufRead + Seek,
    kind: Kind,
    name: &str,
    _: Room,
) -> Result<Rgba8, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: kind.name(), feature: "png" })
}

#[cfg(not(feature = "png"))]
pub(super) fn raster_texels(
    _: impl BufRead + Seek,
    kind: Kind,
    name: &str,
    _: Room,
) -> Result<Texels, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: kind.name(), feature: "png" })
}
