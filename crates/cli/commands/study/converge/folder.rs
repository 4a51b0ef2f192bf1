//! The output folder of a comparison: its files, and how an earlier comparison is continued.

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

/// A writable folder.
pub struct Folder {
    path: PathBuf,
    /// Tone curve and exposure of PNGs: the same for all images of a scene.
    tone: Tone,
    stops: f32,
    /// Files that could not be written into the folder, each with the path that was written instead, if any.
    elsewhere: Mutex<BTreeMap<String, Option<PathBuf>>>,
}

/// Maximum number of pixels for which FLIP is computed: it takes a second per million pixels.
const FLIP_PIXELS: usize = 1 << 20;

/// Files of every comparison.
const TABLES: [&str; 3] = ["results.json", "results.csv", "report.html"];

/// Prefix of the names of plots after the scene's name, and suffixes of the names of images.
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

/// Whether a file name (lower case, after the scene's name) may be one of the outputs: plots, images, and files of
/// other renderers.
fn is_of_scene(rest: &str, externals: &[String]) -> bool {
    let left = |external: &String| {
        let name = format!("-{}", plain(external).to_lowercase());
        [".exr", ".time"].iter().any(|end| rest.strip_suffix(end) == Some(&name))
    };
    rest.starts_with(PLOTS) || PICTURES.iter().any(|end| rest.ends_with(end)) || externals.iter().any(left)
}

impl Folder {
    /// Opens the one named folder, which is created if needed; fails if it cannot be written into.
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

    /// Returns the path of a file in the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Sets the tone curve and exposure of the following PNGs.
    pub fn expose(&mut self, tone: Tone, stops: f32) {
        (self.tone, self.stops) = (tone, stops);
    }

    /// Fails if a file of this folder that the comparison of `scenes` or a renderer of `externals` would write is one
    /// of the inputs.
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

    /// Writes a file into the folder, or else elsewhere; a failure does not stop the other files, and the folder is
    /// tried again the next time.
    fn put(&self, name: &str, write: impl Fn(&Path) -> Result<(), ImageError>) {
        let mut elsewhere = self.elsewhere.lock().unwrap_or_else(PoisonError::into_inner);
        let path = self.file(name);
        match (write(&path), elsewhere.get(name)) {
            (Ok(()), _) => drop(elsewhere.remove(name)),
            (Err(_), Some(Some(at))) if write(at).is_ok() => {}
            (Err(error), _) => drop(elsewhere.insert(name.into(), saving::rescue(&path, &error, write))),
        }
    }

    /// Returns the path of a file, in the folder or elsewhere.
    pub fn place(&self, name: &str) -> PathBuf {
        let elsewhere = self.elsewhere.lock().unwrap_or_else(PoisonError::into_inner);
        elsewhere.get(name).cloned().flatten().unwrap_or_else(|| self.file(name))
    }

    /// Whether all files are in the folder.
    pub fn is_whole(&self) -> bool {
        self.elsewhere.lock().unwrap_or_else(PoisonError::into_inner).is_empty()
    }

    /// Reads the results of an earlier call; empty in a new folder.
    pub fn read(&self) -> Result<Results, Failure> {
        let path = self.file("results.json");
        let failed = |why: String| {
            let said = "is not a result file of this version of dapple converge; choose another \
                        folder or remove the file";
            Failure::Arguments(format!("{}: {said} ({why})", path.display()))
        };
        let text = match std::fs::read_to_string(&path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
                // Files of these names without results.json are not of an earlier call.
                let foreign = TABLES.iter().map(|name| self.file(name)).find(|path| path.exists());
                return foreign.map_or(Ok(Results::default()), |path| {
                    let said = "was not written by dapple converge; choose another folder or remove the file";
                    Err(Failure::Arguments(format!("{}: {said}", path.display())))
                });
            }
            Err(e) => return Err(failed(e.to_string())),
            Ok(text) => text,
        };
        let results: Results = serde_json::from_str(&text).map_err(|e| failed(e.to_string()))?;
        match results.schema {
            SCHEMA => Ok(results),
            other => Err(failed(format!("schema {other}"))),
        }
    }

    /// Writes both tables.
    pub fn write(&self, results: &mut Results) -> Result<(), Failure> {
        results.sum_up();
        let json = serde_json::to_vec_pretty(results).map_err(|e| Failure::Arguments(e.to_string()))?;
        let csv = results.csv();
        self.put("results.json", |path| write::replace(path, &json));
        self.put("results.csv", |path| write::replace(path, csv.as_bytes()));
        Ok(())
    }

    /// Writes tables, plots and the report page.
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
                // A build without PNG support still writes the SVG.
                self.put_frame(&format!("{file}.png"), &chart.frame());
            }
            shown.push(self.shown(results, scene));
        }
        let page = report::html(results, &shown);
        self.put("report.html", |path| write::replace(path, page.as_bytes()));
        Ok(())
    }

    /// Returns the images of a scene from the folder: the references, then the runs.
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

    /// Writes a reference; returns the names of its files.
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

    /// Reads a reference from the folder, if it is complete.
    pub fn reference(&self, record: &ReferenceRecord, limit: MemoryLimit) -> Option<Reference> {
        let files = record.files.iter().filter(|f| f.ends_with(".exr"));
        let read = |file: &String| read::picture_within(&self.place(file), limit).ok();
        let pictures: Option<Vec<Image>> = files.map(read).collect();
        match <[Image; 2]>::try_from(pictures?) {
            Ok(halves) => Some(Reference::Halves(halves)),
            Err(one) => one.into_iter().next().map(Reference::Exact),
        }
    }

    /// Writes the image and the error map of a run; returns the names of the files, and FLIP.
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

/// Converts a name to one that is valid on every file system.
pub fn plain(name: &str) -> String {
    let stem = Path::new(name).file_stem().map_or(name.into(), |s| s.to_string_lossy());
    let stem = if name.starts_with("builtin:") { name.trim_start_matches("builtin:").into() } else { stem };
    stem.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' }).collect()
}
