//! What lies in the folder of a comparison, and how it is continued.

use crate::error::Failure;
use crate::inputs::Inputs;
use crate::saving;
use dapple_analysis::converge::Reference;
use dapple_analysis::curve::Over;
use dapple_analysis::report::{self, Shown};
use dapple_analysis::results::{ReferenceRecord, Results, SCHEMA};
use dapple_analysis::{flip, heat};
use dapple_integrator::imaging::sheet::Frame;
use dapple_integrator::imaging::{Image, ImageError, Layers, MemoryLimit, Tone, read, write};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// A folder that can be written into.
pub struct Folder {
    path: PathBuf,
    /// How its PNGs show pictures: the same for all of a scene.
    tone: Tone,
    stops: f32,
    /// Files that could not be written into it, and where they are instead, if anywhere.
    elsewhere: Mutex<BTreeMap<String, Option<PathBuf>>>,
}

/// Largest side product for which FLIP is worked out: it takes a second per million pixels.
const FLIP_PIXELS: usize = 1 << 20;

/// The files that every comparison writes.
const TABLES: [&str; 3] = ["results.json", "results.csv", "report.html"];

/// How names of plots go on after the scene's name, and how those of pictures end.
const PLOTS: &str = "-error-";
const PICTURES: [&str; 7] = [
    "-reference.exr",
    "-reference.png",
    "-half-1.exr",
    "-half-2.exr",
    "-picture.exr",
    "-picture.png",
    "-errors.png",
];

/// Whether a file whose name, in small letters, goes on like this after its scene's may be written: plots and pictures, and
/// what another renderer leaves.
fn is_of_scene(rest: &str, externals: &[String]) -> bool {
    let left = |external: &String| {
        let name = format!("-{}", plain(external).to_lowercase());
        [".exr", ".time"].iter().any(|end| rest.strip_suffix(end) == Some(&name))
    };
    rest.starts_with(PLOTS) || PICTURES.iter().any(|end| rest.ends_with(end)) || externals.iter().any(left)
}

impl Folder {
    /// The one folder that was named, made if need be; fails if it cannot be written into.
    pub fn open(named: &[PathBuf]) -> Result<Self, Failure> {
        let [path] = named else {
            return Err(Failure::Arguments("-o: name one folder to write into".into()));
        };
        let failed = |e: std::io::Error| {
            Failure::Arguments(format!("{}: cannot be written into: {e}", path.display()))
        };
        std::fs::create_dir_all(path).map_err(failed)?;
        let elsewhere = Mutex::default();
        let folder = Self { path: path.clone(), tone: Tone::Srgb, stops: 0.0, elsewhere };
        write::check(&folder.file("probe.png"))?;
        Ok(folder)
    }

    /// A file in it.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// How PNGs are shown from now on.
    pub fn expose(&mut self, tone: Tone, stops: f32) {
        (self.tone, self.stops) = (tone, stops);
    }

    /// Refuses to go on if a file of this folder that the comparison of `scenes` would write, or that a renderer of
    /// `externals` would, is one of the inputs.
    pub fn spare(&self, inputs: &Inputs, scenes: &[String], externals: &[String]) -> Result<(), Failure> {
        let failed =
            |e: std::io::Error| Failure::Arguments(format!("{}: cannot be read: {e}", self.path.display()));
        let entries = std::fs::read_dir(&self.path).map_err(failed)?;
        let is_ours = |name: &str| {
            TABLES.contains(&name)
                || scenes.iter().any(|scene| {
                    let rest = name.strip_prefix(&plain(scene).to_lowercase());
                    rest.is_some_and(|rest| is_of_scene(rest, externals))
                })
        };
        for entry in entries.filter_map(Result::ok) {
            if entry.file_name().to_str().is_some_and(|name| is_ours(&name.to_lowercase())) {
                inputs.spare([entry.path().as_path()])?;
            }
        }
        Ok(())
    }

    /// Writes a file into the folder, or else elsewhere: the others are written all the same, and it is tried again the next
    /// time.
    fn put(&self, name: &str, write: impl Fn(&Path) -> Result<(), ImageError>) {
        let mut elsewhere = self.elsewhere.lock().unwrap_or_else(PoisonError::into_inner);
        let path = self.file(name);
        match (write(&path), elsewhere.get(name)) {
            (Ok(()), _) => drop(elsewhere.remove(name)),
            (Err(_), Some(Some(at))) if write(at).is_ok() => {}
            (Err(error), _) => drop(elsewhere.insert(name.into(), saving::rescue(&path, &error, write))),
        }
    }

    /// Where a file is that was to lie in the folder.
    pub fn place(&self, name: &str) -> PathBuf {
        let elsewhere = self.elsewhere.lock().unwrap_or_else(PoisonError::into_inner);
        elsewhere.get(name).cloned().flatten().unwrap_or_else(|| self.file(name))
    }

    /// Whether all files lie in the folder.
    pub fn is_whole(&self) -> bool {
        self.elsewhere.lock().unwrap_or_else(PoisonError::into_inner).is_empty()
    }

    /// What an earlier call left; nothing in a new folder.
    pub fn read(&self) -> Result<Results, Failure> {
        let path = self.file("results.json");
        let failed = |why: String| {
            let said = "is no result of this dapple converge; name another folder or remove it";
            Failure::Arguments(format!("{}: {said} ({why})", path.display()))
        };
        let text = match std::fs::read_to_string(&path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Results::default()),
            Err(e) => return Err(failed(e.to_string())),
            Ok(text) => text,
        };
        let results: Results = serde_json::from_str(&text).map_err(|e| failed(e.to_string()))?;
        match results.schema {
            SCHEMA => Ok(results),
            other => Err(failed(format!("schema {other}"))),
        }
    }

    /// Both tables.
    pub fn write(&self, results: &mut Results) -> Result<(), Failure> {
        results.sum_up();
        let json = serde_json::to_vec_pretty(results).map_err(|e| Failure::Arguments(e.to_string()))?;
        let csv = results.csv();
        self.put("results.json", |path| write::replace(path, &json));
        self.put("results.csv", |path| write::replace(path, csv.as_bytes()));
        Ok(())
    }

    /// Tables, plots and the page.
    pub fn write_page(&self, results: &mut Results) -> Result<(), Failure> {
        self.write(results)?;
        let scenes: Vec<String> = results.scenes().iter().map(|s| s.to_string()).collect();
        let mut shown = Vec::new();
        for scene in &scenes {
            let axes =
                [(Over::Seconds, "seconds"), (Over::CpuSeconds, "cpu-seconds"), (Over::Samples, "samples")];
            for (over, name) in axes {
                let chart = report::chart(results, scene, over);
                let file = format!("{}-error-{name}", plain(scene));
                let svg = chart.svg();
                self.put(&format!("{file}.svg"), |path| write::replace(path, svg.as_bytes()));
                // A build without PNG still has the SVG.
                self.put_frame(&format!("{file}.png"), &chart.frame());
            }
            shown.push(self.shown(results, scene));
        }
        let page = report::html(results, &shown);
        self.put("report.html", |path| write::replace(path, page.as_bytes()));
        Ok(())
    }

    /// The pictures of a scene, as they lie here: the reference, then the runs.
    fn shown(&self, results: &Results, scene: &str) -> Vec<Shown> {
        let bytes = |name: &String| std::fs::read(self.place(name)).ok();
        let png = |files: &[String], end: &str| files.iter().find(|f| f.ends_with(end)).and_then(bytes);
        let references = results.references.iter().filter(|r| r.scene == scene).filter_map(|r| {
            Some(Shown { label: r.name.clone(), picture: png(&r.files, "reference.png")?, errors: None })
        });
        let runs = results.of_scene(scene).filter_map(|run| {
            let picture = png(&run.files, "picture.png")?;
            Some(Shown { label: run.name.clone(), picture, errors: png(&run.files, "errors.png") })
        });
        references.chain(runs).collect()
    }

    /// Writes a reference; the names of its files.
    pub fn put_reference(&self, name: &str, reference: &Reference) -> Vec<String> {
        let mut files = Vec::new();
        match reference {
            Reference::Halves(halves) => {
                for (half, i) in halves.iter().zip(1..) {
                    files.push(format!("{name}-half-{i}.exr"));
                    self.put_exr(&files[i - 1], half);
                }
            }
            Reference::Exact(picture) => {
                files.push(format!("{name}-reference.exr"));
                self.put_exr(&files[0], picture);
            }
        }
        files.push(format!("{name}-reference.png"));
        self.put_png(&files[files.len() - 1], &reference.picture());
        files
    }

    /// A reference as it lies here, if it is whole.
    pub fn reference(&self, record: &ReferenceRecord, limit: MemoryLimit) -> Option<Reference> {
        let files = record.files.iter().filter(|f| f.ends_with(".exr"));
        let read = |file: &String| read::picture_within(&self.place(file), limit).ok();
        let pictures: Option<Vec<Image>> = files.map(read).collect();
        match <[Image; 2]>::try_from(pictures?) {
            Ok(halves) => Some(Reference::Halves(halves)),
            Err(one) => one.into_iter().next().map(Reference::Exact),
        }
    }

    /// Writes a run's picture and where its errors are; the names of the files, and FLIP.
    pub fn put_picture(
        &self,
        name: &str,
        picture: &Image,
        reference: &Image,
    ) -> Result<(Vec<String>, Option<f64>), Failure> {
        let names = ["picture.exr", "picture.png", "errors.png"].map(|end| format!("{name}-{end}"));
        self.put_exr(&names[0], picture);
        self.put_png(&names[1], picture);
        self.put_frame(&names[2], &heat::relative(picture, reference));
        let flip = match picture.pixels.len() {
            n if n > FLIP_PIXELS => None,
            _ => Some(flip::ldr(picture, reference, flip::PIXELS_PER_DEGREE)?.mean()),
        };
        Ok((names.to_vec(), flip))
    }

    fn put_exr(&self, name: &str, picture: &Image) {
        if cfg!(feature = "exr") {
            let layers = Layers::from(picture);
            self.put(name, |path| write::exr(path, &layers, write::Depth::Float));
        }
    }

    fn put_png(&self, name: &str, picture: &Image) {
        if cfg!(feature = "png") {
            self.put(name, |path| write::png(path, picture, self.tone, self.stops));
        }
    }

    fn put_frame(&self, name: &str, frame: &Frame) {
        if cfg!(feature = "png") {
            self.put(name, |path| write::rgb8(path, frame.width, frame.height, frame.data.clone()));
        }
    }
}

/// A name that every file system takes.
pub fn plain(name: &str) -> String {
    let stem = Path::new(name).file_stem().map_or(name.into(), |s| s.to_string_lossy());
    let stem = if name.starts_with("builtin:") { name.trim_start_matches("builtin:").into() } else { stem };
    stem.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' }).collect()
}
