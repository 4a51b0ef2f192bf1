//! `dapple diff`: measures the error of an image against a reference, as text or JSON, with an error map and limits.

use crate::args::study::{DiffArgs, ErrorMap};
use crate::error::Failure;
use crate::inputs::Inputs;
use crate::memory;
use crate::values::Threshold;
use crate::{saving, standard_output};
use dapple_analysis::metrics::{self, Comparison, Measures, Scale, SizeMismatch};
use dapple_analysis::{flip, heat, ssim};
use dapple_integrator::imaging::sheet::Frame;
use dapple_integrator::imaging::{
    Image, ImageError, Layers, MemoryLimit, Window, Windowed, color, read, write,
};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Measured bytes per pixel at peak memory use: images, their copies in other colour spaces, and the error maps. For
/// two display-referred images, for any other pair, and for a reference in two halves.
const DISPLAY_BYTES: u64 = 137;
const PAIR_BYTES: u64 = 178;
const HALVES_BYTES: u64 = 205;

/// Compares the images, writes the map, prints the measures, and fails if a limit is exceeded.
pub fn run(arguments: &DiffArgs) -> Result<(), Failure> {
    if let Some(path) = &arguments.output {
        write::check(path)?;
        check_format(path)?;
        inputs(arguments).spare([path.as_path()])?;
    }
    arguments.fail_above.iter().try_for_each(known)?;
    let pair = Pair::read(arguments)?;
    let scale = Scale { epsilon: arguments.epsilon, peak: arguments.peak, ..Scale::default() };
    let found = pair.compare(&scale)?;
    let seen = Perceptual::of(&pair)?;
    if let Some(path) = &arguments.output {
        saving::save(path, |path| write_map(path, &pair, &seen, arguments));
    }
    let facts = facts(arguments, &pair, &found, &seen);
    if arguments.json {
        standard_output::json(&facts);
    } else {
        text(&facts).iter().for_each(|line| standard_output::result(line));
    }
    held(arguments, &facts)
}

fn inputs(arguments: &DiffArgs) -> Inputs {
    let mut inputs = Inputs::default();
    inputs.add("the image", &arguments.image);
    inputs.add("the reference", &arguments.reference);
    if let Some(half) = &arguments.reference_half {
        inputs.add("half of the reference", half);
    }
    inputs
}

/// The images to compare, restricted to the pixels that all files contain.
struct Pair {
    image: Image,
    /// The reference, or the mean of its halves.
    reference: Image,
    halves: Option<[Image; 2]>,
    /// Whether both files hold display-referred values, which end at 1.
    display: bool,
    /// Position of these pixels in the full image.
    window: Window,
    full_size: (usize, usize),
}

impl Pair {
    fn read(arguments: &DiffArgs) -> Result<Self, Failure> {
        let limit = admitted(arguments)?;
        let image = read::windowed_within(&arguments.image, limit)?;
        let reference = read_like(&image, &arguments.image, &arguments.reference, limit)?;
        let display = [&arguments.image, &arguments.reference].iter().all(|path| is_display(path));
        let window = overlap(&image, image.window, arguments, &arguments.reference, &reference)?;
        let full_size = image.full_size;
        let Some(path) = &arguments.reference_half else {
            let [image, reference] = parts(window, [image, reference])?;
            return Ok(Self { image, reference, halves: None, display, window, full_size });
        };
        let half = read_like(&image, &arguments.image, path, limit)?;
        let window = overlap(&image, window, arguments, path, &half)?;
        let [image, a, b] = parts(window, [image, reference, half])?;
        let reference = metrics::mean([&a, &b]);
        Ok(Self { image, reference, halves: Some([a, b]), display, window, full_size })
    }

    fn compare(&self, scale: &Scale) -> Result<Comparison, SizeMismatch> {
        let mut found = match &self.halves {
            None => metrics::compare(&self.image, &self.reference, scale),
            Some([a, b]) => metrics::compare_halves(&self.image, [a, b], scale),
        }?;
        // Positions are reported in the full image, as `dapple replay` takes them.
        let all = found.channels.iter_mut().chain([&mut found.overall]);
        let places = all.map(|m| &mut m.max_error_pixel).chain([&mut found.nan_pixel]);
        places.flatten().for_each(|[x, y]| (*x, *y) = (*x + self.window.x, *y + self.window.y));
        Ok(found)
    }
}

/// Returns the memory limit, after checking that all images can be read and compared within it.
fn admitted(arguments: &DiffArgs) -> Result<MemoryLimit, Failure> {
    let limit = memory::limit(arguments.memory_limit);
    let (mut pixels, mut bytes) = (0, 0);
    for path in [&arguments.image, &arguments.reference].into_iter().chain(&arguments.reference_half) {
        pixels = read::pixel_count(path)?.max(pixels);
        bytes += path.metadata().map_or(0, |found| found.len());
    }
    let each = match () {
        () if arguments.reference_half.is_some() => HALVES_BYTES,
        () if is_display(&arguments.image) && is_display(&arguments.reference) => DISPLAY_BYTES,
        () => PAIR_BYTES,
    };
    limit.admit(pixels.saturating_mul(each), Some(bytes)).map_err(|overrun| {
        let (image, reference) = (arguments.image.display(), arguments.reference.display());
        Failure::Arguments(format!("{image}, {reference}: comparing {pixels} pixels {overrun}"))
    })?;
    Ok(limit)
}

/// Reads an image from `path` that must have the frame and channels of `image`; errors name both files.
fn read_like(
    image: &Windowed,
    image_path: &Path,
    path: &Path,
    limit: MemoryLimit,
) -> Result<Windowed, Failure> {
    let picture = read::windowed_within(path, limit)?;
    let (a, b) = (image_path.display(), path.display());
    if image.full_size != picture.full_size {
        let e = SizeMismatch { image: image.full_size, reference: picture.full_size };
        return Err(Failure::Arguments(format!("{a}, {b}: {e}; render or scale them to the same size")));
    }
    let channels = [read::channels(image_path)?, read::channels(path)?];
    if channels[0] != channels[1] {
        let [c, d] = channels;
        let said = format!(
            "{a}, {b}: the images have different channels: {c} and {d}; save them with equal channels"
        );
        return Err(Failure::Arguments(said));
    }
    Ok(picture)
}

/// Returns the pixels of `window` that `other`, read from `path`, also contains.
fn overlap(
    image: &Windowed,
    window: Window,
    arguments: &DiffArgs,
    path: &Path,
    other: &Windowed,
) -> Result<Window, Failure> {
    window.intersection(&other.window).ok_or_else(|| Failure::NoOverlap {
        image: arguments.image.clone(),
        other: path.into(),
        windows: Box::new([image.window, other.window]),
    })
}

fn parts<const N: usize>(window: Window, of: [Windowed; N]) -> Result<[Image; N], Failure> {
    let found: Result<Vec<Image>, _> = of.into_iter().map(|p| p.into_covering(window, "")).collect();
    found?.try_into().map_err(|_| Failure::Arguments("the images could not be cropped".into()))
}

fn is_display(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    !matches!(extension.as_str(), "exr" | "hdr" | "pic")
}

/// Perceptual measures of the images.
struct Perceptual {
    ldr: flip::Map,
    /// None for display-referred images.
    hdr: Option<flip::Map>,
    /// None for images smaller than its window.
    ssim: Option<f64>,
}

impl Perceptual {
    fn of(pair: &Pair) -> Result<Self, SizeMismatch> {
        let (image, reference) = (&pair.image, &pair.reference);
        let ldr = flip::ldr(image, reference, flip::PIXELS_PER_DEGREE)?;
        let hdr = match pair.display {
            true => None,
            false => Some(flip::hdr(image, reference, flip::PIXELS_PER_DEGREE)?),
        };
        Ok(Self { ldr, hdr, ssim: ssim::ssim(image, reference)? })
    }

    /// Returns the FLIP map that suits the images.
    fn map(&self) -> &flip::Map {
        self.hdr.as_ref().unwrap_or(&self.ldr)
    }
}

/// Converts measures to an object; values that are not numbers are null.
fn measures(m: &Measures) -> Map<String, Value> {
    match serde_json::to_value(m) {
        Ok(Value::Object(object)) => object,
        _ => Map::new(),
    }
}

fn facts(arguments: &DiffArgs, pair: &Pair, found: &Comparison, seen: &Perceptual) -> Map<String, Value> {
    let mut facts = measures(&found.overall);
    let [r, g, b] = found.channels.each_ref().map(measures);
    let more = json!({
        "flip": seen.map().mean(), "flip_ldr": seen.ldr.mean(),
        "flip_hdr": seen.hdr.as_ref().map(flip::Map::mean), "ssim": seen.ssim,
        "nan_pixels": found.nan_pixels, "nan_pixel": found.nan_pixel, "pixels": found.pixels,
        "width": pair.image.width, "height": pair.image.height,
        "window": [pair.window.x, pair.window.y, pair.window.end().0, pair.window.end().1],
        "full_size": [pair.full_size.0, pair.full_size.1],
        "epsilon": arguments.epsilon, "trim": Scale::default().trim, "psnr_peak": arguments.peak,
        "reference_mse": pair.halves.as_ref().and_then(|[a, b]| metrics::halves_mse([a, b]).ok()),
        "channels": { "r": r, "g": g, "b": b },
    });
    if let Value::Object(more) = more {
        facts.extend(more);
    }
    facts
}

/// Measures in the order of the printed table.
const ROWS: [&str; 10] = [
    "mse",
    "rmse",
    "relative_rmse",
    "relmse",
    "relmse_trimmed",
    "bias",
    "mape",
    "smape",
    "psnr",
    "max_error",
];

fn text(facts: &Map<String, Value>) -> Vec<String> {
    let channel = |c: &str, key: &str| number(&facts["channels"][c][key]);
    let mut lines = vec![format!("{:<16}{:>13}{:>13}{:>13}{:>13}", "", "overall", "red", "green", "blue")];
    lines.extend(ROWS.iter().map(|key| {
        let [r, g, b] = ["r", "g", "b"].map(|c| channel(c, key));
        format!("{key:<16}{:>13}{r:>13}{g:>13}{b:>13}", number(&facts[*key]))
    }));
    let seen = ["flip", "ssim"].map(|key| format!("{key:<16}{:>13}", number(&facts[key])));
    lines.extend(seen);
    if let Value::Array(at) = &facts["max_error_pixel"] {
        lines.push(format!("largest error at pixel {},{}", at[0], at[1]));
    }
    let [epsilon, peak] = ["epsilon", "psnr_peak"].map(|key| number(&facts[key]));
    lines.push(format!("{} pixels; epsilon {epsilon}, psnr peak {peak}", facts["pixels"]));
    if facts["width"] != facts["full_size"][0] || facts["height"] != facts["full_size"][1] {
        let [w, h] = [0, 1].map(|i| &facts["full_size"][i]);
        let [x0, y0, x1, y1] = [0, 1, 2, 3].map(|i| &facts["window"][i]);
        lines.push(format!("compared: {x0},{y0} to {x1},{y1} of {w}x{h}, the pixels that all files contain"));
    }
    if let Some(mse) = facts["reference_mse"].as_f64() {
        lines.push(format!("the mean of the two references itself has an mse of {mse:.5e}"));
    }
    if let Value::Array(at) = &facts["nan_pixel"] {
        let n = &facts["nan_pixels"];
        lines.push(format!("{n} pixels are not finite and were excluded, the first at {},{}", at[0], at[1]));
    }
    lines
}

fn number(value: &Value) -> String {
    match value.as_f64() {
        Some(0.0) => "0".into(),
        Some(x) if (1e-3..1e5).contains(&x.abs()) => format!("{x:.6}"),
        Some(x) => format!("{x:.5e}"),
        None => "-".into(),
    }
}

/// Further measures that a limit can be set on.
const MORE: [&str; 4] = ["flip", "flip_ldr", "flip_hdr", "nan_pixels"];

/// Fails unless the measure of the limit exists.
fn known(limit: &Threshold) -> Result<(), Failure> {
    let mut names = ROWS.iter().chain(&MORE);
    if names.any(|name| *name == limit.measure) {
        return Ok(());
    }
    let names = [&ROWS[..], &MORE].concat().join(", ");
    Err(Failure::Arguments(format!(
        "--fail-above {}: there is no such measure; use one of {names}",
        limit.measure
    )))
}

/// Checks all limits; fails with the first that is exceeded.
fn held(arguments: &DiffArgs, facts: &Map<String, Value>) -> Result<(), Failure> {
    for limit in &arguments.fail_above {
        let name = &limit.measure;
        let failed = match facts.get(name).and_then(Value::as_f64) {
            Some(x) if x <= limit.limit => continue,
            Some(x) => format!("{name} is {}, above {}", number(&x.into()), limit.limit),
            // Equal images have no peak signal-to-noise ratio, and an empty set of pixels has no measures.
            None => format!("{name} is not a number, so it is not below {}", limit.limit),
        };
        return Err(Failure::Check(failed));
    }
    Ok(())
}

fn check_format(path: &Path) -> Result<(), Failure> {
    match write::Format::of(path)? {
        write::Format::Hdr => {
            let said = "an error map is a .png (false colours) or an .exr (signed difference)";
            Err(Failure::Arguments(format!("{}: {said}", path.display())))
        }
        _ => Ok(()),
    }
}

fn write_map(path: &Path, pair: &Pair, seen: &Perceptual, arguments: &DiffArgs) -> Result<(), ImageError> {
    if write::Format::of(path)? == write::Format::Exr {
        let difference = pair.image.pixels.iter().zip(&pair.reference.pixels).map(|(a, b)| *a - *b);
        let picture = Image { pixels: difference.collect(), ..pair.image };
        let offset = (pair.window.x as i32, pair.window.y as i32);
        let layers = Layers { offset, full_size: pair.full_size, ..Layers::from(&picture) };
        return write::exr(path, &layers, write::Depth::Float);
    }
    let frame = map(pair, seen, arguments);
    write::rgb8(path, frame.width, frame.height, frame.data)
}

fn map(pair: &Pair, seen: &Perceptual, arguments: &DiffArgs) -> Frame {
    let width = pair.image.width;
    let pixels = || pair.image.pixels.iter().zip(&pair.reference.pixels);
    match arguments.map {
        ErrorMap::Relative => {
            let scale = |r: glam::DVec3| r * r + arguments.epsilon;
            let error = |d: glam::DVec3, r| ((d * d / scale(r)).element_sum() / 3.0).sqrt();
            let values: Vec<f64> = pixels().map(|(a, b)| error((*a - *b).as_dvec3(), b.as_dvec3())).collect();
            heat::logarithmic(&values, width, [1e-3, 1.0])
        }
        ErrorMap::Signed => {
            let light = |p: &glam::Vec3| f64::from(color::luminance(*p));
            let error = |a: f64, b: f64| (a - b) / (b.abs() + arguments.epsilon);
            let values: Vec<f64> = pixels().map(|(a, b)| error(light(a), light(b))).collect();
            heat::signed(&values, width, 1.0)
        }
        ErrorMap::Flip => {
            let values: Vec<f64> = seen.map().values.iter().map(|v| f64::from(*v)).collect();
            heat::linear(&values, width)
        }
    }
}
