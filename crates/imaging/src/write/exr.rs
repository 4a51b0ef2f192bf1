//! Encoding of single-part scan-line EXR files with the block interface of the `exr` crate. Rows are converted while
//! they are compressed, without a second copy of the layers.

use super::options::Depth;
use crate::{ImageError, Layer, Layers, MetaValue};
use exr::block::writer::{ChunkWriter, ChunksWriter, ParallelBlocksCompressor};
use exr::block::{BlockIndex, UncompressedBlock};
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, Chromaticities};
use exr::meta::header::Header;
use exr::prelude::{
    AttributeValue, Compression, IntegerBounds, LineOrder, MetaData, SampleType, SmallVec, Text, Vec2,
};
use half::f16;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

/// A channel to be written.
struct Channel<'a> {
    values: &'a [f32],
    half: bool,
}

/// Channels by full name, in byte order as the format requires.
type Channels<'a> = BTreeMap<String, Channel<'a>>;

/// Encodes the layers and returns the bytes of the file.
pub(super) fn encode(path: &Path, layers: &Layers, depth: Depth) -> Result<Vec<u8>, ImageError> {
    let wrong = |why: String| ImageError::Inconsistent { path: path.to_path_buf(), why };
    let channels = channels(layers, depth).map_err(wrong)?;
    let header = header(layers, &channels).map_err(wrong)?;
    let rows: Vec<&Channel<'_>> = channels.values().collect();
    let mut bytes = Cursor::new(Vec::new());
    exr::block::write(&mut bytes, SmallVec::from_elem(header, 1), true, |meta, writer| {
        compress(&meta, writer, |block| block_data(&rows, layers.width, block))
    })
    .map_err(|e| wrong(e.to_string()))?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    Ok(bytes)
}

fn channels(layers: &Layers, depth: Depth) -> Result<Channels<'_>, String> {
    let count =
        layers.width.checked_mul(layers.height).filter(|&n| n > 0 && n as u64 <= crate::read::MAX_PIXELS);
    let Some(count) = count else {
        return Err(format!("{}×{} is not a valid image size", layers.width, layers.height));
    };
    let mut all = Channels::new();
    for layer in &layers.layers {
        for (channel, values) in &layer.channels {
            let name = full_name(&layer.name, channel)?;
            if values.len() != count {
                return Err(format!("channel `{name}` has {} values for {count} pixels", values.len()));
            }
            let half = depth == Depth::Half && fits_half(layer, channel) && !is_matte(layers, &layer.name);
            if all.insert(name.clone(), Channel { values, half }).is_some() {
                return Err(format!("duplicate channel name `{name}`"));
            }
        }
    }
    if all.is_empty() { Err("there are no channels".into()) } else { Ok(all) }
}

fn full_name(layer: &str, channel: &str) -> Result<String, String> {
    let name = if layer.is_empty() { channel.to_string() } else { format!("{layer}.{channel}") };
    let sound = !channel.is_empty() && !name.contains('\0') && name.len() <= 255;
    if sound { Ok(name) } else { Err(format!("`{name}` is not a valid channel name")) }
}

/// Whether a channel is stored as half; see [`Depth::Half`].
fn fits_half(layer: &Layer, channel: &str) -> bool {
    layer.name == "normal" || (layer.name != "variance" && ["R", "G", "B", "A"].contains(&channel))
}

/// Whether a layer belongs to a Cryptomatte: it is called `NAME00` and so on, where an attribute `cryptomatte/…/name`
/// contains the name.
fn is_matte(layers: &Layers, layer: &str) -> bool {
    let is_name = |key: &str| key.starts_with("cryptomatte/") && key.ends_with("/name");
    let named = layers.metadata.iter().filter_map(|(key, value)| match value {
        MetaValue::Text(name) if is_name(key) => layer.strip_prefix(name.as_str()),
        _ => None,
    });
    named.into_iter().any(|rest| !rest.is_empty() && rest.bytes().all(|b| b.is_ascii_digit()))
}

fn header(layers: &Layers, channels: &Channels<'_>) -> Result<Header, String> {
    let full = if layers.full_size == (0, 0) { (layers.width, layers.height) } else { layers.full_size };
    let small = |n: usize| n > 0 && n <= i32::MAX as usize / 4;
    if !small(full.0) || !small(full.1) {
        return Err(format!("{}×{} is not a valid size of the full image", full.0, full.1));
    }
    let list = channels.iter().map(|(name, channel)| {
        let kind = if channel.half { SampleType::F16 } else { SampleType::F32 };
        ChannelDescription::new(text(name), kind, false)
    });
    let mut header = Header::new(Text::default(), (layers.width, layers.height), list.collect())
        .with_encoding(Compression::ZIP16, BlockDescription::ScanLines, LineOrder::Increasing)
        .with_display_window(IntegerBounds::from_dimensions(full))
        .with_position(Vec2(layers.offset.0, layers.offset.1));
    header.own_attributes.layer_name = None;
    header.shared_attributes.chromaticities = Some(REC_709);
    for (name, value) in &layers.metadata {
        attribute(&mut header, name, value)?;
    }
    Ok(header)
}

/// Primaries and white point D65 of ITU-R BT.709-6.
const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

/// Adds an attribute: standard attributes are stored in the fields of the `exr` crate, all others as custom attributes.
fn attribute(header: &mut Header, name: &str, value: &MetaValue) -> Result<(), String> {
    if name.is_empty() || name.len() > 255 || name.contains('\0') {
        return Err(format!("`{name}` is not a valid attribute name"));
    }
    let own = &mut header.own_attributes;
    let taken = match (name, value) {
        ("worldToCamera", MetaValue::Matrix(m)) => own.world_to_camera.replace(*m).is_some(),
        ("worldToNDC", MetaValue::Matrix(m)) => own.world_to_normalized_device.replace(*m).is_some(),
        ("software", MetaValue::Text(t)) => own.software_name.replace(text(t)).is_some(),
        ("comments", MetaValue::Text(t)) => own.comments.replace(text(t)).is_some(),
        ("owner", MetaValue::Text(t)) => own.owner.replace(text(t)).is_some(),
        _ => own.other.insert(text(name), custom(value)).is_some(),
    };
    if taken { Err(format!("duplicate attribute name `{name}`")) } else { Ok(()) }
}

fn custom(value: &MetaValue) -> AttributeValue {
    match value {
        MetaValue::Text(t) => AttributeValue::Text(text(t)),
        MetaValue::Int(i) => AttributeValue::I32(*i),
        MetaValue::Float(f) => AttributeValue::F32(*f),
        MetaValue::Matrix(m) => AttributeValue::Matrix4x4(*m),
    }
}

/// The UTF-8 bytes unchanged: the format does not specify an encoding, and readers expect UTF-8.
fn text(s: &str) -> Text {
    Text::from_slice_unchecked(s.as_bytes())
}

/// Compresses all blocks on as many threads as the current rayon pool has. The blocks are written in the order of their
/// rows, independently of the order in which they are finished.
fn compress<W: std::io::Write + std::io::Seek>(
    meta: &MetaData,
    writer: &mut ChunkWriter<W>,
    data: impl FnMut(BlockIndex) -> Vec<u8>,
) -> exr::error::UnitResult {
    let threads = rayon::current_num_threads();
    let blocks = meta.collect_ordered_block_data(data);
    let pool = || rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    if threads > 1
        && let Some(mut parallel) = ParallelBlocksCompressor::new_with_thread_pool(meta, writer, pool)
    {
        return blocks
            .into_iter()
            .try_for_each(|(i, block)| parallel.add_block_to_compression_queue(i, block));
    }
    sequential(meta, writer, blocks)
}

fn sequential<W: std::io::Write + std::io::Seek>(
    meta: &MetaData,
    writer: &mut ChunkWriter<W>,
    blocks: impl Iterator<Item = (usize, UncompressedBlock)>,
) -> exr::error::UnitResult {
    let mut one = writer.sequential_blocks_compressor(meta);
    for (i, block) in blocks {
        one.compress_block(i, block)?;
    }
    Ok(())
}

/// The rows of a block in the layout of the format: row by row, and within each row channel by channel.
fn block_data(channels: &[&Channel<'_>], width: usize, block: BlockIndex) -> Vec<u8> {
    let mut bytes = Vec::new();
    let (x0, y0) = (block.pixel_position.0, block.pixel_position.1);
    for y in y0..y0 + block.pixel_size.1 {
        let row = y * width + x0..y * width + x0 + block.pixel_size.0;
        for channel in channels {
            let values = &channel.values[row.clone()];
            if channel.half {
                bytes.extend(values.iter().flat_map(|&v| to_half(v).to_ne_bytes()));
            } else {
                bytes.extend(values.iter().flat_map(|v| v.to_ne_bytes()));
            }
        }
    }
    bytes
}

/// Rounds to nearest even in software (the conversion of the processor may treat NaN differently); finite values remain
/// finite.
fn to_half(v: f32) -> f16 {
    f16::from_f32_const(if v.is_finite() { v.clamp(-65504.0, 65504.0) } else { v })
}

/// Sorts the attributes of the header by name, because the crate stores custom attributes in a hash map whose order
/// differs from run to run. Each attribute consists of name, 0, type, 0, length (i32), value; an empty name ends the
/// header. The length of the header does not change, so that the following offsets remain valid.
fn sort_attributes(bytes: &mut [u8]) {
    const START: usize = 8; // magic number and version
    let mut attributes = Vec::new();
    let mut at = START;
    while let Some(length) = attribute_length(&bytes[at..]) {
        attributes.push(bytes[at..at + length].to_vec());
        at += length;
    }
    let name = |a: &Vec<u8>| a.iter().take_while(|&&b| b != 0).copied().collect::<Vec<u8>>();
    attributes.sort_by_key(name);
    let sorted = attributes.concat();
    bytes[START..START + sorted.len()].copy_from_slice(&sorted);
}

/// Length of the attribute at the start of `bytes`; `None` at the end of the header.
fn attribute_length(bytes: &[u8]) -> Option<usize> {
    let name = bytes.iter().position(|&b| b == 0).filter(|&n| n > 0)?;
    let kind = bytes[name + 1..].iter().position(|&b| b == 0)?;
    let size_at = name + kind + 2;
    let size = i32::from_le_bytes(bytes.get(size_at..size_at + 4)?.try_into().ok()?);
    Some(size_at + 4 + size as usize).filter(|&n| n <= bytes.len())
}
