//! Decoding of OpenEXR files with the block interface of the `exr` crate. Only the required channels are kept, as f32,
//! in the window requested by the caller.
//!
//! Blocks are decompressed sequentially, because a panic on malformed data in the crate's thread pool would terminate
//! the process.

use super::limits::{Room, check_size};
use crate::{Image, ImageError, Layer, Layers, MetaValue, Windowed, window};
use exr::block::lines::LineRef;
use exr::block::reader::{ChunksReader, Reader};
use exr::meta::header::Header;
use exr::prelude::{AttributeValue, IntegerBounds, SampleType, Text, Vec2};
use glam::Vec3;
use half::f16;
use std::collections::{HashMap, HashSet};
use std::io::{BufRead, Seek};

/// A display window with more pixels than this must have data for at least one in [`SPARSE`] of them.
const FRAME: u64 = 1 << 22;
const SPARSE: u64 = 64;

/// A rectangle of the image plane: x0, y0 inclusive, then width, height.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Window {
    x: i64,
    y: i64,
    width: usize,
    height: usize,
}

impl Window {
    fn of(bounds: IntegerBounds) -> Self {
        let Vec2(x, y) = bounds.position;
        Self { x: x.into(), y: y.into(), width: bounds.size.0, height: bounds.size.1 }
    }

    /// The intersection with `display`, in pixels relative to the latter's corner.
    fn within(self, display: Self) -> Option<window::Window> {
        let (left, top) = (self.x.max(display.x), self.y.max(display.y));
        let right = (self.x + self.width as i64).min(display.x + display.width as i64);
        let bottom = (self.y + self.height as i64).min(display.y + display.height as i64);
        (left < right && top < bottom).then(|| window::Window {
            x: (left - display.x) as usize,
            y: (top - display.y) as usize,
            width: (right - left) as usize,
            height: (bottom - top) as usize,
        })
    }

    fn union(self, other: Self) -> Self {
        let (x, y) = (self.x.min(other.x), self.y.min(other.y));
        let right = (self.x + self.width as i64).max(other.x + other.width as i64);
        let bottom = (self.y + self.height as i64).max(other.y + other.height as i64);
        Self { x, y, width: (right - x) as usize, height: (bottom - y) as usize }
    }
}

/// A channel to be read: its index in the file, and the values read so far.
struct Wanted {
    part: usize,
    channel: usize,
    values: Vec<f32>,
}

pub(super) fn picture(file: impl BufRead + Seek, name: &str, room: Room) -> Result<Image, ImageError> {
    let reader = exr::block::read(file, false).map_err(|e| failure(e, name))?;
    let rgb = colour_channels(reader.headers()).ok_or_else(|| no_colour(reader.headers(), name))?;
    let header = &reader.headers()[rgb[0].0];
    let window = Window::of(header.shared_attributes.display_window);
    check_frame(window, Window::of(header.data_window()), name)?;
    colours(reader, &rgb, window, name, room)
}

/// Returns an error for a large display window that is nearly empty.
fn check_frame(display: Window, data: Window, name: &str) -> Result<(), ImageError> {
    let held = data.within(display).map_or(0, |part| part.width as u64 * part.height as u64);
    let (width, height) = (display.width as u64, display.height as u64);
    let frame = width.saturating_mul(height);
    if frame > FRAME && held.saturating_mul(SPARSE) < frame {
        return Err(ImageError::Sparse { name: name.to_string(), held, width, height });
    }
    Ok(())
}

/// The number of pixels of the result of [`windowed`].
pub(super) fn pixel_count(file: impl BufRead + Seek, name: &str) -> Result<u64, ImageError> {
    let reader = exr::block::read(file, false).map_err(|e| failure(e, name))?;
    let rgb = colour_channels(reader.headers()).ok_or_else(|| no_colour(reader.headers(), name))?;
    let header = &reader.headers()[rgb[0].0];
    let part = Window::of(header.data_window()).within(Window::of(header.shared_attributes.display_window));
    Ok(part.map_or(0, |part| part.width as u64 * part.height as u64))
}

/// The intersection of the display window with the data window of the colour channels.
pub(super) fn windowed(file: impl BufRead + Seek, name: &str, room: Room) -> Result<Windowed, ImageError> {
    let reader = exr::block::read(file, false).map_err(|e| failure(e, name))?;
    let rgb = colour_channels(reader.headers()).ok_or_else(|| no_colour(reader.headers(), name))?;
    let header = &reader.headers()[rgb[0].0];
    let display = Window::of(header.shared_attributes.display_window);
    let Some(part) = Window::of(header.data_window()).within(display) else {
        let what = "an EXR whose data window is outside of its display window".into();
        return Err(ImageError::Unsupported { name: name.to_string(), what });
    };
    let (x, y) = (display.x + part.x as i64, display.y + part.y as i64);
    let picture = colours(reader, &rgb, Window { x, y, width: part.width, height: part.height }, name, room)?;
    Ok(Windowed { picture, window: part, full_size: (display.width, display.height) })
}

fn colours<R: BufRead + Seek>(
    reader: Reader<R>,
    rgb: &[(usize, usize); 3],
    window: Window,
    name: &str,
    room: Room,
) -> Result<Image, ImageError> {
    let mut found = rgb.to_vec();
    found.dedup();
    let values = read(reader, &found, window, name, (room, size_of::<Vec3>() as u64))?;
    let (r, g, b) = (&values[0], &values[values.len() / 2], &values[values.len() - 1]);
    let pixels = r.iter().zip(g).zip(b).map(|((&r, &g), &b)| Vec3::new(r, g, b)).collect();
    Ok(Image { width: window.width, height: window.height, pixels })
}

/// Whether the colour of [`picture`] is a single luminance channel.
pub(super) fn is_grey(file: impl BufRead + Seek, name: &str) -> Result<bool, ImageError> {
    let reader = exr::block::read(file, false).map_err(|e| failure(e, name))?;
    let rgb = colour_channels(reader.headers()).ok_or_else(|| no_colour(reader.headers(), name))?;
    Ok(rgb[0] == rgb[2])
}

pub(super) fn layers(file: impl BufRead + Seek, name: &str, room: Room) -> Result<Layers, ImageError> {
    let reader = exr::block::read(file, false).map_err(|e| failure(e, name))?;
    let headers = reader.headers();
    let window = headers.iter().map(|h| Window::of(h.data_window())).reduce(Window::union);
    let Some(window) = window else { return Err(broken(name, "it has no parts")) };
    let display = Window::of(headers[0].shared_attributes.display_window);
    let metadata = metadata(&headers[0]);
    let mut wanted = Vec::new();
    let mut names = Vec::new();
    for (part, header) in headers.iter().enumerate() {
        for (channel, description) in header.channels.list.iter().enumerate() {
            wanted.push((part, channel));
            names.push(split_name(header, headers.len() > 1, &text(&description.name)));
        }
    }
    let values = read(reader, &wanted, window, name, (room, 0))?;
    Ok(Layers {
        width: window.width,
        height: window.height,
        offset: ((window.x - display.x) as i32, (window.y - display.y) as i32),
        full_size: (display.width, display.height),
        layers: group(names, values),
        metadata,
    })
}

/// Splits a full channel name into layer and channel.
fn split_name(header: &Header, many_parts: bool, full: &str) -> (String, String) {
    match full.rsplit_once('.') {
        Some((layer, channel)) => (layer.to_string(), channel.to_string()),
        None if many_parts => {
            (header.own_attributes.layer_name.as_ref().map(text).unwrap_or_default(), full.to_string())
        }
        None => (String::new(), full.to_string()),
    }
}

/// Groups channels into layers in order of occurrence; R, G, B (A) are sorted in this order.
fn group(names: Vec<(String, String)>, values: Vec<Vec<f32>>) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    let mut known: HashMap<String, usize> = HashMap::new();
    for ((layer, channel), values) in names.into_iter().zip(values) {
        match known.get(&layer) {
            Some(&at) => layers[at].channels.push((channel, values)),
            None => {
                known.insert(layer.clone(), layers.len());
                layers.push(Layer { name: layer, channels: vec![(channel, values)] });
            }
        }
    }
    let rank = |name: &str| ["R", "G", "B", "A"].iter().position(|c| *c == name).unwrap_or(4);
    for layer in &mut layers {
        layer.channels.sort_by_key(|(name, _)| rank(name));
    }
    layers
}

/// The (part, channel) indices of red, green and blue: of the first part that has them without a prefix, else those
/// with the first prefix that has all three, else the first luminance channel.
fn colour_channels(headers: &[Header]) -> Option<[(usize, usize); 3]> {
    let channels = |h: &Header| h.channels.list.iter().map(|c| text(&c.name)).collect::<Vec<_>>();
    let all: Vec<Vec<String>> = headers.iter().map(channels).collect();
    let each = || all.iter().enumerate().flat_map(|(p, names)| names.iter().map(move |n| (p, n.as_str())));
    // The first channel for each prefix and upper-case last letter.
    let mut places: HashMap<(usize, &str, char), usize> = HashMap::new();
    for (part, names) in all.iter().enumerate() {
        for (channel, name) in names.iter().enumerate() {
            let Some(letter) = name.chars().next_back() else { continue };
            let prefix = &name[..name.len() - letter.len_utf8()];
            places.entry((part, prefix, letter.to_ascii_uppercase())).or_insert(channel);
        }
    }
    let three = |part: usize, prefix: &str| {
        let find = |letter| places.get(&(part, prefix, letter)).map(|channel| (part, *channel));
        Some([find('R')?, find('G')?, find('B')?])
    };
    let mut seen = HashSet::new();
    let mut prefixes =
        each().filter_map(|(p, n)| Some((p, &n[..=n.rfind('.')?]))).filter(|prefix| seen.insert(*prefix));
    let is_grey = |n: &str| n.rsplit('.').next().is_some_and(|n| n.eq_ignore_ascii_case("Y"));
    let grey = || {
        let of = |(p, names): (usize, &Vec<String>)| Some((p, names.iter().position(|n| is_grey(n))?));
        all.iter().enumerate().find_map(of)
    };
    (0..headers.len())
        .find_map(|p| three(p, ""))
        .or_else(|| prefixes.find_map(|(p, prefix)| three(p, prefix)))
        .or_else(|| grey().map(|place| [place; 3]))
}

fn no_colour(headers: &[Header], name: &str) -> ImageError {
    let names: Vec<String> =
        headers.iter().flat_map(|h| h.channels.list.iter().map(|c| text(&c.name))).take(12).collect();
    let what = format!("an EXR without the channels R, G, B or Y (it has {})", names.join(", "));
    ImageError::Unsupported { name: name.to_string(), what }
}

/// Reads the channels `(part, channel)` into `window`, with 0 where the file has no data. They must fit into the memory
/// limit together with `beside` additional bytes per pixel.
fn read<R: BufRead + Seek>(
    reader: Reader<R>,
    channels: &[(usize, usize)],
    window: Window,
    name: &str,
    (room, beside): (Room, u64),
) -> Result<Vec<Vec<f32>>, ImageError> {
    for header in reader.headers() {
        // The blocks of the file must also be within the limits, even if the window contains little of them.
        check_size(name, header.layer_size.0 as u64, header.layer_size.1 as u64, 1)?;
    }
    let (width, height) = (window.width as u64, window.height as u64);
    check_size(name, width, height, channels.len() as u64)?;
    let block = reader.headers().iter().map(|h| h.max_block_byte_size() as u64).max().unwrap_or(0);
    room.admit(name, [width, height], 4 * channels.len() as u64 + beside, block.saturating_mul(3))?;
    let wanted = |&(part, channel): &(usize, usize)| Wanted {
        part,
        channel,
        values: vec![0.0; window.width * window.height],
    };
    let mut wanted: Vec<Wanted> = channels.iter().map(wanted).collect();
    reader
        .filter_chunks(false, |_, tile, block| {
            tile.level_index == Vec2(0, 0) && channels.iter().any(|c| c.0 == block.layer)
        })
        .and_then(|chunks| {
            chunks.decompress_sequential(false, |meta, block| {
                let header = &meta.headers[block.index.layer];
                for line in block.lines(&header.channels) {
                    place(&mut wanted, header, window, line)?;
                }
                Ok(())
            })
        })
        .map_err(|e| failure(e, name))?;
    Ok(wanted.into_iter().map(|w| w.values).collect())
}

/// Copies one row of one channel to its position in the window, and clips it.
fn place(
    wanted: &mut [Wanted],
    header: &Header,
    window: Window,
    line: LineRef<'_>,
) -> Result<(), exr::error::Error> {
    let at = line.location;
    let targets = wanted.iter_mut().filter(|w| w.part == at.layer && w.channel == at.channel);
    for target in targets {
        let data = Window::of(header.data_window());
        let (x, y) = (data.x + at.position.0 as i64 - window.x, data.y + at.position.1 as i64 - window.y);
        if y < 0 || y >= window.height as i64 {
            continue;
        }
        let row = &mut target.values[y as usize * window.width..][..window.width];
        let mut put = |i: usize, v: f32| {
            if let Ok(x) = usize::try_from(x + i as i64)
                && let Some(slot) = row.get_mut(x)
            {
                *slot = v;
            }
        };
        let Some(channel) = header.channels.list.get(at.channel) else { continue };
        match channel.sample_type {
            SampleType::F32 => each(line, |i, v: f32| put(i, v))?,
            SampleType::F16 => each(line, |i, v: f16| put(i, v.to_f32_const()))?,
            SampleType::U32 => each(line, |i, v: u32| put(i, v as f32))?,
        }
    }
    Ok(())
}

fn each<T: exr::io::Data>(line: LineRef<'_>, mut put: impl FnMut(usize, T)) -> Result<(), exr::error::Error> {
    for (i, sample) in line.read_samples::<T>().enumerate() {
        put(i, sample?);
    }
    Ok(())
}

/// Attributes of the types of [`MetaValue`], sorted by name, without those that only describe the layout of the pixels.
fn metadata(header: &Header) -> Vec<(String, MetaValue)> {
    let own = &header.own_attributes;
    let texts = [("software", &own.software_name), ("comments", &own.comments), ("owner", &own.owner)];
    let matrices = [("worldToCamera", &own.world_to_camera), ("worldToNDC", &own.world_to_normalized_device)];
    let mut all: Vec<(String, MetaValue)> = Vec::new();
    all.extend(texts.iter().filter_map(|(n, t)| Some((n.to_string(), MetaValue::Text(text(t.as_ref()?))))));
    all.extend(matrices.iter().filter_map(|(n, m)| Some((n.to_string(), MetaValue::Matrix((**m)?)))));
    all.extend(own.other.iter().filter_map(|(n, v)| Some((text(n), known(v)?))));
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

fn known(value: &AttributeValue) -> Option<MetaValue> {
    match value {
        AttributeValue::Text(t) => Some(MetaValue::Text(text(t))),
        AttributeValue::I32(i) => Some(MetaValue::Int(*i)),
        AttributeValue::F32(f) => Some(MetaValue::Float(*f)),
        AttributeValue::F64(f) => Some(MetaValue::Float(*f as f32)),
        AttributeValue::Matrix4x4(m) => Some(MetaValue::Matrix(*m)),
        _ => None,
    }
}

/// Decodes UTF-8, or Latin-1 if it is not valid UTF-8.
fn text(t: &Text) -> String {
    std::str::from_utf8(t.as_slice())
        .map_or_else(|_| t.as_slice().iter().map(|&b| b as char).collect(), str::to_string)
}

fn failure(error: exr::error::Error, name: &str) -> ImageError {
    match error {
        exr::error::Error::NotSupported(what) => {
            ImageError::Unsupported { name: name.to_string(), what: what.to_string() }
        }
        exr::error::Error::Io(source) => ImageError::Read { name: name.to_string(), source },
        other => broken(name, &other.to_string()),
    }
}

fn broken(name: &str, why: &str) -> ImageError {
    ImageError::Malformed { name: name.to_string(), why: why.to_string() }
}
