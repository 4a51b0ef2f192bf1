//! Reading of image files: the full image, a window, or all layers.

use super::decoders::{
    exr_is_grey, exr_layers, exr_picture, exr_pixel_count, exr_windowed, raster_is_grey, raster_picture,
    raster_size,
};
use super::kind::Kind;
use super::limits::Room;
use crate::{Image, ImageError, Layers, MemoryLimit, Windowed};
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek};
use std::path::Path;

/// Reads an .exr (the display window of the first RGB layer, or else of the first luminance channel Y; black where the
/// file contains no data), .hdr, or .png/.jpg/.webp (sRGB decoded to linear).
pub fn picture(path: &Path) -> Result<Image, ImageError> {
    picture_within(path, MemoryLimit::NONE)
}

/// As [`picture`], with a memory limit. An EXR with more than 2²² pixels in its display window, of which less than 1/64
/// have data, is an error, because nearly all of the image would be empty.
pub fn picture_within(path: &Path, limit: MemoryLimit) -> Result<Image, ImageError> {
    let name = path.display().to_string();
    let (kind, file, bytes) = open(path, &name)?;
    let room = Room::new(limit, bytes, kind);
    match kind {
        Kind::Exr => exr_picture(file, &name, room),
        kind => raster_picture(file, kind, &name, room),
    }
}

/// As [`picture`], but reads of an EXR only its data window, clipped to the display window. Other files are read
/// completely.
pub fn windowed(path: &Path) -> Result<Windowed, ImageError> {
    windowed_within(path, MemoryLimit::NONE)
}

/// As [`windowed`], with a memory limit.
pub fn windowed_within(path: &Path, limit: MemoryLimit) -> Result<Windowed, ImageError> {
    let name = path.display().to_string();
    let (kind, file, bytes) = open(path, &name)?;
    let room = Room::new(limit, bytes, kind);
    match kind {
        Kind::Exr => exr_windowed(file, &name, room),
        kind => Ok(raster_picture(file, kind, &name, room)?.into()),
    }
}

/// The number of pixels of the result of [`windowed`], from the header alone.
pub fn pixel_count(path: &Path) -> Result<u64, ImageError> {
    let name = path.display().to_string();
    let (kind, file, _) = open(path, &name)?;
    match kind {
        Kind::Exr => exr_pixel_count(file, &name),
        kind => raster_size(file, kind, &name).map(|[width, height]| width * height),
    }
}

/// The channels that [`picture`] reads from the file: "RGB", or "Y" if it has only luminance or grey.
pub fn channels(path: &Path) -> Result<&'static str, ImageError> {
    let name = path.display().to_string();
    let (kind, file, _) = open(path, &name)?;
    let grey = match kind {
        Kind::Exr => exr_is_grey(file, &name)?,
        kind => raster_is_grey(file, kind, &name)?,
    };
    Ok(if grey { "Y" } else { "RGB" })
}

/// Reads all layers of an EXR in the union of the data windows of its parts, with 0 where a part has no data. A channel
/// `a.b.C` becomes channel C of layer `a.b`; in a file of several parts, a channel without a dot belongs to the layer
/// with the name of its part.
pub fn layers(path: &Path) -> Result<Layers, ImageError> {
    let name = path.display().to_string();
    match open(path, &name)? {
        (Kind::Exr, file, bytes) => exr_layers(file, &name, Room::new(MemoryLimit::NONE, bytes, Kind::Exr)),
        _ => {
            Err(ImageError::Unsupported { name, what: "reading layers from a format other than EXR".into() })
        }
    }
}

/// Opens a regular file and returns its format and its length.
fn open(path: &Path, name: &str) -> Result<(Kind, BufReader<File>, u64), ImageError> {
    let failed = |source: std::io::Error| match source.kind() {
        ErrorKind::NotFound => ImageError::Missing { name: name.to_string() },
        _ => ImageError::Read { name: name.to_string(), source },
    };
    let found = std::fs::metadata(path).map_err(failed)?;
    if !found.is_file() {
        return Err(ImageError::NotAFile { name: name.to_string() });
    }
    let mut file = BufReader::new(File::open(path).map_err(failed)?);
    let mut start = Vec::new();
    file.by_ref().take(16).read_to_end(&mut start).map_err(failed)?;
    file.rewind().map_err(failed)?;
    let kind = Kind::by_content(&start).or_else(|| Kind::by_extension(path));
    kind.map(|kind| (kind, file, found.len()))
        .ok_or_else(|| ImageError::NotAPicture { name: name.to_string() })
}
