//! `dapple render --dry-run`: loads the scene, checks every output, and forecasts memory, rays, time and disk space.

use super::settings::settings;
use super::{frames, image};
use crate::error::Failure;
use crate::load::{self, Loaded, Source};
use crate::options::RenderOptions;
use crate::output::Outputs;
use crate::preflight::{Planned, Space, megabytes, planned, spaces};
use crate::{checkpoint, log, machine, memory, metering, standard_output};
use dapple_integrator::imaging::write;
use dapple_integrator::scene::NamedCamera;
use dapple_integrator::{MethodKind, Settings, forecast};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Size of the file that is written to measure the speed of a disk.
const TRIAL: usize = 1 << 24;

/// What a render would take.
#[derive(Serialize)]
struct Forecast {
    width: u32,
    height: u32,
    /// Images of the sequence.
    images: u64,
    /// Samples of one image; null if only time limits them.
    samples: Option<u64>,
    /// Rays of one image.
    rays: Option<f64>,
    /// Seconds of rendering one image, by the rate of a small render.
    render_seconds: Option<f64>,
    scene_bytes: u64,
    /// Peak memory of the process.
    peak_memory_bytes: u64,
    memory_limit_bytes: u64,
    files: Vec<Planned>,
    disks: Vec<Space>,
    /// Seconds for writing a checkpoint, by the measured rate of its disk.
    checkpoint_seconds: Option<f64>,
    warnings: Vec<String>,
    /// Whether the render would begin.
    fits: bool,
}

/// Prints the forecast of a render; fails where the render would.
pub fn run(source: &Source, options: &RenderOptions) -> Result<bool, Failure> {
    let first = frames::first_of(source, options)?;
    let outputs = Outputs::plan(&first, &source.name())?;
    let files = checkpoint::Files::open(&first)?;
    log::check(&first, &outputs)?;
    let loaded = load::load(source, &first)?;
    let view = load::camera(&loaded.scene, &first)?;
    let settings = settings(&first, &view)?;
    image::warn(&loaded);
    let (small, rate) = small(&loaded, &view, &settings);
    let samples = settings.sample_range();
    let count = settings.samples().map(|end| u64::from(end - samples.start) * settings.rect().area() as u64);
    let rays = match settings.kind() {
        MethodKind::Path => count.map(|count| count as f64 * small),
        MethodKind::Distribution => {
            Some(forecast(&loaded.scene, &view.camera, &settings).total() * settings.rect().area() as f64)
        }
    };
    let images = options.frames.frames.map_or(1, |frames| frames.count());
    let files_planned = planned(&outputs, &files, &first, &settings, images);
    let disks = spaces(&files_planned);
    let scene_bytes = loaded.scene.memory_bytes() as u64;
    let picture = settings.rect().area() as u64 * load::pixel_bytes(&first);
    let checkpoint = files.paths().next().map(Path::to_path_buf);
    let fits = !disks.iter().any(Space::is_short) || RenderOptions::is(options.effects.yes);
    let told = Forecast {
        width: settings.size.0,
        height: settings.size.1,
        images,
        samples: count,
        rays,
        render_seconds: rays.map(|rays| rays / rate).filter(|seconds| seconds.is_finite()),
        scene_bytes,
        peak_memory_bytes: machine::peak_memory_bytes().max(machine::resident_memory_bytes() + picture),
        memory_limit_bytes: memory::limit(options.memory_limit).bytes(),
        checkpoint_seconds: checkpoint.and_then(|path| seconds_to_write(&path, picture)),
        files: files_planned,
        disks,
        warnings: loaded.scene.warnings.iter().map(|warning| warning.0.clone()).collect(),
        fits,
    };
    if RenderOptions::is(options.json) {
        standard_output::json(&told);
    } else {
        standard_output::results(&told.text());
    }
    Ok(fits)
}

/// Rays per sample of a small image, and rays per second.
fn small(loaded: &Loaded, view: &NamedCamera, settings: &Settings) -> (f64, f64) {
    let stats = metering::trial(&loaded.scene, &view.camera, settings);
    (stats.rays as f64 / stats.samples.max(1) as f64, stats.rays as f64 / stats.seconds)
}

/// Seconds for writing `bytes` beside `path`, by the time that a trial takes.
fn seconds_to_write(path: &Path, bytes: u64) -> Option<f64> {
    let mut trial: PathBuf = path.to_path_buf();
    trial.set_file_name(format!("{}.trial", path.file_name()?.to_string_lossy()));
    if trial.exists() {
        return None;
    }
    let start = Instant::now();
    let written = write::replace(&trial, &vec![0x5a; TRIAL]);
    let seconds = start.elapsed().as_secs_f64();
    let _ = std::fs::remove_file(&trial);
    written.ok()?;
    Some(seconds * bytes as f64 / TRIAL as f64)
}

impl Forecast {
    fn text(&self) -> String {
        let images = if self.images > 1 { format!("{} images, each ", self.images) } else { String::new() };
        let known = |value: Option<String>| value.unwrap_or_else(|| "limited by time".into());
        let rays = self.rays.map(|rays| format!("{:.1} M rays", rays / 1e6));
        let time = self.render_seconds.map(|seconds| format!("about {seconds:.0} s"));
        let mut lines = vec![
            format!("{images}{}x{}: {}, {}", self.width, self.height, known(rays), known(time)),
            format!(
                "memory: scene {}, peak {} of {}",
                megabytes(self.scene_bytes),
                megabytes(self.peak_memory_bytes),
                megabytes(self.memory_limit_bytes)
            ),
        ];
        for file in &self.files {
            lines.push(format!("{}: writable, up to {}", file.path.display(), megabytes(file.bytes_at_most)));
        }
        for disk in &self.disks {
            let free = disk.free_bytes.map_or("an unknown amount".into(), megabytes);
            let short = if disk.is_short() { "; this is too little" } else { "" };
            let (needed, folder) = (megabytes(disk.needed_bytes), disk.folder.display());
            lines.push(format!("disk of {folder}: up to {needed} needed, {free} free{short}"));
        }
        lines.extend(self.checkpoint_seconds.map(|s| format!("a checkpoint takes about {s:.2} s to write")));
        lines.join("\n")
    }
}
