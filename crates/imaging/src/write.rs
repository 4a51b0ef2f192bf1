//! Pictures to files: encoded in memory, written beside the target under a temporary name, then renamed.

use crate::{ImageError, Layers, Picture, Tone};
use std::io::Write;
use std::path::Path;

/// Precision of EXR colour channels; ids, depth and positions are always 32-bit float.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Depth {
    /// 32-bit float.
    #[default]
    Float,
    /// 16-bit float.
    Half,
}

/// All layers in one part, channels named `layer.C` (what compositing programs expect); ZIP.
#[cfg(feature = "exr")]
pub fn exr(path: &Path, layers: &Layers, depth: Depth) -> Result<(), ImageError> {
    let bytes =
        exr_encode(layers, depth).map_err(|why| ImageError::Inconsistent { path: path.into(), why })?;
    replace(path, &bytes)
}

/// Left out of this build.
#[cfg(not(feature = "exr"))]
pub fn exr(path: &Path, _: &Layers, _: Depth) -> Result<(), ImageError> {
    Err(ImageError::NotBuiltIn { name: path.display().to_string(), format: "OpenEXR", feature: "exr" })
}

#[cfg(feature = "exr")]
fn exr_encode(layers: &Layers, depth: Depth) -> Result<Vec<u8>, String> {
    use exr::prelude::*;
    let pixels = layers.width * layers.height;
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    for layer in &layers.layers {
        let narrow = depth == Depth::Half
            && !matches!(&*layer.name, "depth" | "position" | "object" | "material" | "samples");
        for (name, values) in &layer.channels {
            if values.len() != pixels {
                return Err(format!(
                    "layer '{}' has {} values for {pixels} pixels",
                    layer.name,
                    values.len()
                ));
            }
            let name = if layer.name.is_empty() { name.clone() } else { format!("{}.{name}", layer.name) };
            let samples = if narrow {
                FlatSamples::F16(values.iter().map(|&v| half::f16::from_f32(v)).collect())
            } else {
                FlatSamples::F32(values.clone())
            };
            channels.push(AnyChannel::new(Text::from(&*name), samples));
        }
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let mut attributes = LayerAttributes {
        layer_position: Vec2(layers.offset.0, layers.offset.1),
        ..LayerAttributes::default()
    };
    metadata(&layers.metadata, &mut attributes);
    let layer =
        Layer::new(Vec2(layers.width, layers.height), attributes, encoding, AnyChannels::sort(channels));
    let full = if layers.full_size == (0, 0) { (layers.width, layers.height) } else { layers.full_size };
    let image = Image::new(ImageAttributes::new(IntegerBounds::from_dimensions(Vec2(full.0, full.1))), layer);
    let mut bytes = Vec::new();
    image.write().non_parallel().to_buffered(std::io::Cursor::new(&mut bytes)).map_err(|e| e.to_string())?;
    Ok(bytes)
}

/// Matrices go where compositing programs look; everything else into one text attribute, `dapple`, line by line: the
/// encoder keeps custom attributes in a hash map, and a second one would make the order of bytes a matter of chance.
#[cfg(feature = "exr")]
fn metadata(facts: &[(String, crate::MetaValue)], attributes: &mut exr::meta::header::LayerAttributes) {
    use crate::MetaValue;
    let mut lines = String::new();
    for (key, value) in facts {
        match (key.as_str(), value) {
            ("worldToCamera", MetaValue::Matrix(m)) => attributes.world_to_camera = Some(*m),
            ("worldToNDC", MetaValue::Matrix(m)) => attributes.world_to_normalized_device = Some(*m),
            (_, MetaValue::Text(text)) => lines += &format!("{key} = {text}\n"),
            (_, MetaValue::Int(i)) => lines += &format!("{key} = {i}\n"),
            (_, MetaValue::Float(x)) => lines += &format!("{key} = {x}\n"),
            (_, MetaValue::Matrix(m)) => lines += &format!("{key} = {m:?}\n"),
        }
    }
    if !lines.is_empty() {
        attributes.other.insert(
            exr::meta::attribute::Text::from("dapple"),
            exr::meta::attribute::AttributeValue::Text(exr::meta::attribute::Text::from(&*lines)),
        );
    }
}

/// 8-bit sRGB with a tone curve, after multiplying by 2^`exposure`.
#[cfg(feature = "png")]
pub fn png(path: &Path, picture: &Picture, tone: Tone, exposure: f32) -> Result<(), ImageError> {
    let scale = libm::exp2f(exposure);
    let byte = |c: f32| (c * 255.0 + 0.5) as u8;
    let data: Vec<u8> =
        picture.pixels.iter().flat_map(|&p| tone.apply(p * scale).to_array().map(byte)).collect();
    rgb8(path, picture.width, picture.height, data)
}

/// 8-bit values as they are.
#[cfg(feature = "png")]
pub fn rgb8(path: &Path, width: usize, height: usize, data: Vec<u8>) -> Result<(), ImageError> {
    let why = |why: String| ImageError::Inconsistent { path: path.into(), why };
    let image = image::RgbImage::from_raw(width as u32, height as u32, data)
        .ok_or_else(|| why("too few pixels".into()))?;
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).map_err(|e| why(e.to_string()))?;
    replace(path, bytes.get_ref())
}

/// Radiance HDR (RGBE).
#[cfg(feature = "png")]
pub fn hdr(path: &Path, picture: &Picture) -> Result<(), ImageError> {
    let pixels: Vec<image::Rgb<f32>> = picture.pixels.iter().map(|p| image::Rgb(p.to_array())).collect();
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes)
        .encode(&pixels, picture.width, picture.height)
        .map_err(|e| ImageError::Inconsistent { path: path.into(), why: e.to_string() })?;
    replace(path, &bytes)
}

/// Left out of this build.
#[cfg(not(feature = "png"))]
pub fn png(path: &Path, _: &Picture, _: Tone, _: f32) -> Result<(), ImageError> {
    Err(ImageError::NotBuiltIn { name: path.display().to_string(), format: "PNG", feature: "png" })
}

/// Left out of this build.
#[cfg(not(feature = "png"))]
pub fn hdr(path: &Path, _: &Picture) -> Result<(), ImageError> {
    Err(ImageError::NotBuiltIn { name: path.display().to_string(), format: "Radiance HDR", feature: "png" })
}

/// Fails early when `path` cannot be written: unknown kind, missing folder, no permission, a folder of that name.
pub fn check(path: &Path) -> Result<(), ImageError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let name = || path.display().to_string();
    match &*extension {
        "exr" if cfg!(feature = "exr") => {}
        "png" | "hdr" if cfg!(feature = "png") => {}
        "exr" => return Err(ImageError::NotBuiltIn { name: name(), format: "OpenEXR", feature: "exr" }),
        "png" | "hdr" => {
            return Err(ImageError::NotBuiltIn { name: name(), format: "PNG and HDR", feature: "png" });
        }
        _ => return Err(ImageError::UnknownExtension(path.into())),
    }
    if path.is_dir() {
        return Err(ImageError::write(path, std::io::Error::other("it is a folder")));
    }
    temporary(path).map(drop)
}

/// Writes the whole of `bytes` or leaves what was there.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    let wrong = |e: std::io::Error| ImageError::write(path, e);
    let mut file = temporary(path)?;
    file.write_all(bytes).map_err(wrong)?;
    file.as_file().sync_all().map_err(wrong)?;
    file.persist(path).map_err(|e| wrong(e.error)).map(drop)
}

fn temporary(path: &Path) -> Result<tempfile::NamedTempFile, ImageError> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".dapple-").suffix(".tmp");
    #[cfg(unix)]
    {
        // What any new file gets, less the umask; temporary files are private by default.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder).map_err(|e| ImageError::write(path, e))
}
