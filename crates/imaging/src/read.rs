//! How does a file become a picture?
//!
//! The content decides the format, the extension only where the content says nothing. sRGB files (PNG, JPEG, WebP)
//! are decoded to linear light with the exact curve. Embedded colour profiles, gamma chunks, orientation tags and
//! the EXPOSURE line of an .hdr are ignored: code values are taken as sRGB, numbers as they are. Alpha is left out
//! of pictures. Values that are not finite (only EXR can hold them) are handed on: the caller decides.
//!
//! *Approximation*: JPEG and EXR's DWAA and DWAB are decoded by kernels that may differ in the last bit between
//! machines; all other formats and compressions give every machine the same numbers.
//!
//! No content makes these functions panic, or allocate more than [`MAX_PIXELS`] and [`MAX_SAMPLES`] allow. Those that
//! take a [`MemoryLimit`] work out what decoding will take before it begins, and refuse what is over the limit.

#[cfg(feature = "exr")]
mod exr;
mod jpeg;
#[cfg(feature = "png")]
mod raster;

pub use jpeg::{Gap, gap};

use crate::{Image, ImageError, Layers, MemoryLimit, Windowed};
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, ErrorKind, Read, Seek};
use std::path::Path;

/// Pixels that a picture may have, 2²⁸ = 16384²: larger ones are refused before memory is taken.
pub const MAX_PIXELS: u64 = 1 << 28;

/// Numbers (pixels times channels) that an EXR may take in memory: 2³⁰, 4 GiB.
pub const MAX_SAMPLES: u64 = 1 << 30;

/// Texels of 8 bits per channel, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rgba8 {
    /// Texels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` texels as red, green, blue, alpha.
    pub texels: Vec<[u8; 4]>,
}

/// Texels of 16 bits per channel, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rgba16 {
    /// Texels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` texels as red, green, blue, alpha.
    pub texels: Vec<[u16; 4]>,
}

/// The texels of an image, in the depth that its values need.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Texels {
    /// 8 bits per channel.
    Eight(Rgba8),
    /// 16 bits per channel, where 8 would lose something.
    Sixteen(Rgba16),
}

impl Texels {
    /// Width and height in texels.
    pub fn size(&self) -> (usize, usize) {
        match self {
            Self::Eight(image) => (image.width, image.height),
            Self::Sixteen(image) => (image.width, image.height),
        }
    }

    /// Bytes that the texels take.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Eight(image) => size_of_val(&*image.texels),
            Self::Sixteen(image) => size_of_val(&*image.texels),
        }
    }
}

impl From<Rgba8> for Texels {
    fn from(image: Rgba8) -> Self {
        Self::Eight(image)
    }
}

/// Of 8 bits where that says the same: all values are whole multiples of 257, as of an 8-bit image saved with 16.
impl From<Rgba16> for Texels {
    fn from(image: Rgba16) -> Self {
        if image.texels.as_flattened().iter().any(|value| value % 257 != 0) {
            return Self::Sixteen(image);
        }
        let texels = image.texels.iter().map(|texel| texel.map(|value| (value / 257) as u8)).collect();
        Self::Eight(Rgba8 { width: image.width, height: image.height, texels })
    }
}

/// .exr (the display window of the first RGB layer, or else of the first luminance channel Y; black where the file
/// holds no data), .hdr, .png/.jpg/.webp (sRGB decoded to linear).
pub fn picture(path: &Path) -> Result<Image, ImageError> {
    picture_within(path, MemoryLimit::NONE)
}

/// As [`picture`], in as much memory as `limit` grants. An EXR whose data cover less than 1/64 of a frame of more than
/// 2²² pixels is refused: it would be empty space.
pub fn picture_within(path: &Path, limit: MemoryLimit) -> Result<Image, ImageError> {
    let name = path.display().to_string();
    let (kind, file, bytes) = open(path, &name)?;
    let room = Room { limit, file: bytes };
    match kind {
        Kind::Exr => exr_picture(file, &name, room),
        kind => raster_picture(file, kind, &name, room),
    }
}

/// As [`picture`], but of an EXR only what is there: its data window, cut to the display window. All of any other file.
pub fn windowed(path: &Path) -> Result<Windowed, ImageError> {
    windowed_within(path, MemoryLimit::NONE)
}

/// As [`windowed`], in as much memory as `limit` grants.
pub fn windowed_within(path: &Path, limit: MemoryLimit) -> Result<Windowed, ImageError> {
    let name = path.display().to_string();
    let (kind, file, bytes) = open(path, &name)?;
    let room = Room { limit, file: bytes };
    match kind {
        Kind::Exr => exr_windowed(file, &name, room),
        kind => Ok(raster_picture(file, kind, &name, room)?.into()),
    }
}

/// How many pixels [`windowed`] would give, from the header alone.
pub fn pixel_count(path: &Path) -> Result<u64, ImageError> {
    let name = path.display().to_string();
    let (kind, file, _) = open(path, &name)?;
    match kind {
        Kind::Exr => exr_pixel_count(file, &name),
        kind => raster_size(file, kind, &name).map(|[width, height]| width * height),
    }
}

/// The channels that [`picture`] takes from the file: "RGB", or "Y" where it has only luminance or grey.
pub fn channels(path: &Path) -> Result<&'static str, ImageError> {
    let name = path.display().to_string();
    let (kind, file, _) = open(path, &name)?;
    let grey = match kind {
        Kind::Exr => exr_is_grey(file, &name)?,
        kind => raster_is_grey(file, kind, &name)?,
    };
    Ok(if grey { "Y" } else { "RGB" })
}

/// All layers of an EXR: the union of the data windows of its parts, 0 where a part has no data. A channel
/// `a.b.C` becomes channel C of layer `a.b`; in a file of several parts a channel without a dot belongs to the
/// layer named like its part.
pub fn layers(path: &Path) -> Result<Layers, ImageError> {
    let name = path.display().to_string();
    match open(path, &name)? {
        (Kind::Exr, file, bytes) => exr_layers(file, &name, Room { limit: MemoryLimit::NONE, file: bytes }),
        _ => Err(ImageError::Unsupported { name, what: "reading layers from anything but an EXR".into() }),
    }
}

/// Encoded bytes (png, jpeg, webp by content) to RGBA8; `name` is for the error message. Grey becomes equal
/// R, G, B; missing alpha is opaque; 16 bits are rounded to 8. Values stay encoded as they are in the file.
pub fn rgba8(bytes: &[u8], name: &str) -> Result<Rgba8, ImageError> {
    rgba8_within(bytes, name, MemoryLimit::NONE)
}

/// As [`rgba8`], in as much memory as `limit` grants.
pub fn rgba8_within(bytes: &[u8], name: &str, limit: MemoryLimit) -> Result<Rgba8, ImageError> {
    let room = Room { limit, file: bytes.len() as u64 };
    raster_rgba8(Cursor::new(bytes), texture_kind(bytes, name)?, name, room)
}

/// Width and height that [`rgba8`] would give, from the header alone.
pub fn size(bytes: &[u8], name: &str) -> Result<[u64; 2], ImageError> {
    raster_size(Cursor::new(bytes), texture_kind(bytes, name)?, name)
}

/// As [`rgba8`], but a PNG of 16 bits keeps them, unless its values have no more than 8.
pub fn texels(bytes: &[u8], name: &str) -> Result<Texels, ImageError> {
    texels_within(bytes, name, MemoryLimit::NONE)
}

/// As [`texels`], in as much memory as `limit` grants.
pub fn texels_within(bytes: &[u8], name: &str, limit: MemoryLimit) -> Result<Texels, ImageError> {
    let room = Room { limit, file: bytes.len() as u64 };
    raster_texels(Cursor::new(bytes), texture_kind(bytes, name)?, name, room)
}

/// The format of a texture.
fn texture_kind(bytes: &[u8], name: &str) -> Result<Kind, ImageError> {
    match Kind::by_content(bytes) {
        Some(kind @ (Kind::Png | Kind::Jpeg | Kind::WebP)) => Ok(kind),
        Some(kind) => Err(ImageError::Unsupported {
            name: name.to_string(),
            what: format!("{} as a texture (use PNG, JPEG or WebP)", kind.name()),
        }),
        None => Err(ImageError::NotAPicture { name: name.to_string() }),
    }
}

/// The formats that are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Exr,
    Hdr,
    Png,
    Jpeg,
    WebP,
}

impl Kind {
    fn by_content(start: &[u8]) -> Option<Self> {
        match start {
            [0x76, 0x2f, 0x31, 0x01, ..] => Some(Self::Exr),
            [b'#', b'?', ..] => Some(Self::Hdr),
            [0x89, b'P', b'N', b'G', ..] => Some(Self::Png),
            [0xff, 0xd8, 0xff, ..] => Some(Self::Jpeg),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some(Self::WebP),
            _ => None,
        }
    }

    fn by_extension(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "exr" => Some(Self::Exr),
            "hdr" | "pic" => Some(Self::Hdr),
            "png" => Some(Self::Png),
            "jpg" | "jpeg" => Some(Self::Jpeg),
            "webp" => Some(Self::WebP),
            _ => None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Exr => "EXR",
            Self::Hdr => "Radiance HDR",
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::WebP => "WebP",
        }
    }
}

/// What one file may take.
#[derive(Clone, Copy, Debug)]
#[allow(dead_code, reason = "unused without any decoder")]
struct Room {
    limit: MemoryLimit,
    /// Bytes of the file.
    file: u64,
}

#[allow(dead_code, reason = "unused without any decoder")]
impl Room {
    /// Whether so many pixels of so many bytes each, and `more` bytes, may be held.
    fn admit(&self, name: &str, [width, height]: [u64; 2], each: u64, more: u64) -> Result<(), ImageError> {
        let needed = width.saturating_mul(height).saturating_mul(each).saturating_add(more);
        let refuse = |overrun| ImageError::Memory { name: name.to_string(), width, height, overrun };
        self.limit.admit(needed, Some(self.file)).map_err(refuse)
    }
}

/// Opens a plain file and finds out its kind and its length.
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

/// Decoders are other people's code: should one panic on malformed content, that is a damaged file too.
#[allow(dead_code, reason = "unused without any decoder")]
fn guarded<T>(name: &str, decode: impl FnOnce() -> Result<T, ImageError>) -> Result<T, ImageError> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(decode)).unwrap_or_else(|_| {
        Err(ImageError::Malformed { name: name.to_string(), why: "the decoder gave up".into() })
    })
}

#[allow(dead_code, reason = "unused without any decoder")]
fn check_size(name: &str, width: u64, height: u64, channels: u64) -> Result<(), ImageError> {
    let pixels = width.saturating_mul(height);
    if pixels == 0 {
        let why = format!("its size is {width}×{height}");
        return Err(ImageError::Malformed { name: name.to_string(), why });
    }
    if pixels > MAX_PIXELS || pixels.saturating_mul(channels) > MAX_SAMPLES {
        return Err(ImageError::TooLarge { name: name.to_string(), width, height, channels });
    }
    Ok(())
}

#[cfg(feature = "exr")]
fn exr_is_grey(file: impl BufRead + Seek, name: &str) -> Result<bool, ImageError> {
    guarded(name, || exr::is_grey(file, name))
}

#[cfg(feature = "exr")]
fn exr_picture(file: impl BufRead + Seek, name: &str, room: Room) -> Result<Image, ImageError> {
    guarded(name, || exr::picture(file, name, room))
}

#[cfg(feature = "exr")]
fn exr_windowed(file: impl BufRead + Seek, name: &str, room: Room) -> Result<Windowed, ImageError> {
    guarded(name, || exr::windowed(file, name, room))
}

#[cfg(feature = "exr")]
fn exr_layers(file: impl BufRead + Seek, name: &str, room: Room) -> Result<Layers, ImageError> {
    guarded(name, || exr::layers(file, name, room))
}

#[cfg(feature = "exr")]
fn exr_pixel_count(file: impl BufRead + Seek, name: &str) -> Result<u64, ImageError> {
    guarded(name, || exr::pixel_count(file, name))
}

#[cfg(not(feature = "exr"))]
fn exr_pixel_count(_: impl BufRead + Seek, name: &str) -> Result<u64, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: Kind::Exr.name(), feature: "exr" })
}

#[cfg(feature = "png")]
fn raster_size(file: impl BufRead + Seek, kind: Kind, name: &str) -> Result<[u64; 2], ImageError> {
    guarded(name, || raster::size(file, kind, name))
}

#[cfg(not(feature = "png"))]
fn raster_size(_: impl BufRead + Seek, kind: Kind, name: &str) -> Result<[u64; 2], ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: kind.name(), feature: "png" })
}

#[cfg(feature = "png")]
fn raster_is_grey(file: impl BufRead + Seek, kind: Kind, name: &str) -> Result<bool, ImageError> {
    guarded(name, || raster::is_grey(file, kind, name))
}

#[cfg(feature = "png")]
fn raster_picture(
    file: impl BufRead + Seek,
    kind: Kind,
    name: &str,
    room: Room,
) -> Result<Image, ImageError> {
    guarded(name, || raster::picture(file, kind, name, room))
}

#[cfg(feature = "png")]
fn raster_rgba8(file: impl BufRead + Seek, kind: Kind, name: &str, room: Room) -> Result<Rgba8, ImageError> {
    guarded(name, || raster::rgba8(file, kind, name, room))
}

#[cfg(feature = "png")]
fn raster_texels(
    file: impl BufRead + Seek,
    kind: Kind,
    name: &str,
    room: Room,
) -> Result<Texels, ImageError> {
    guarded(name, || raster::texels(file, kind, name, room))
}

#[cfg(not(feature = "exr"))]
fn exr_is_grey(_: impl BufRead + Seek, name: &str) -> Result<bool, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: Kind::Exr.name(), feature: "exr" })
}

#[cfg(not(feature = "exr"))]
fn exr_picture(_: impl BufRead + Seek, name: &str, _: Room) -> Result<Image, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: Kind::Exr.name(), feature: "exr" })
}

#[cfg(not(feature = "exr"))]
fn exr_windowed(_: impl BufRead + Seek, name: &str, _: Room) -> Result<Windowed, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: Kind::Exr.name(), feature: "exr" })
}

#[cfg(not(feature = "exr"))]
fn exr_layers(_: impl BufRead + Seek, name: &str, _: Room) -> Result<Layers, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: Kind::Exr.name(), feature: "exr" })
}

#[cfg(not(feature = "png"))]
fn raster_is_grey(_: impl BufRead + Seek, kind: Kind, name: &str) -> Result<bool, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: kind.name(), feature: "png" })
}

#[cfg(not(feature = "png"))]
fn raster_picture(_: impl BufRead + Seek, kind: Kind, name: &str, _: Room) -> Result<Image, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: kind.name(), feature: "png" })
}

#[cfg(not(feature = "png"))]
fn raster_rgba8(_: impl BufRead + Seek, kind: Kind, name: &str, _: Room) -> Result<Rgba8, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: kind.name(), feature: "png" })
}

#[cfg(not(feature = "png"))]
fn raster_texels(_: impl BufRead + Seek, kind: Kind, name: &str, _: Room) -> Result<Texels, ImageError> {
    Err(ImageError::NotBuiltIn { name: name.to_string(), format: kind.name(), feature: "png" })
}
