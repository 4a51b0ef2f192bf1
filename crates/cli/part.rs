//! Files of parts: the sums of some samples of some pixels, with what `dapple merge` needs in place of the scene.
//!
//! A part has the container of a checkpoint: safetensors with the mean and the sample counts for inspection, the encoded
//! sums, and a checksum. It describes what it belongs to, and parts of anything else are not merged with it.

#[cfg(feature = "report")]
mod errors;
#[cfg(not(feature = "report"))]
#[path = "part/disabled.rs"]
mod errors;

pub use errors::{Errors, judged};

use crate::checkpoint::file::{Contents, Kind};
use crate::checkpoint::identity;
use crate::error::Failure;
use crate::load::Loaded;
use crate::options::RenderOptions;
use crate::values::{self, SampleRange};
use crate::{interrupt, metadata};
use dapple_integrator::camera::Film;
use dapple_integrator::imaging::picture::MetaValue;
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::NamedCamera;
use dapple_integrator::{Covered, MethodKind, Part, PilotResult, Settings, Stats, render_pilot};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::ops::ControlFlow;
use std::path::Path;

/// A part, with what it belongs to.
pub struct PartFile {
    /// Description of the render that it is a part of.
    pub about: BTreeMap<String, String>,
    /// The sums.
    pub part: Part,
    /// What the image of the merged parts is written with.
    pub notes: Notes,
    /// Renders of some pixels with other seeds, for the error estimate.
    pub errors: Errors,
}

/// Facts about a render for the metadata and the report of its merged image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Notes {
    /// Size of the set that the samples belong to; none if it is not given.
    pub of: Option<u32>,
    /// Texts of the image's metadata.
    texts: Vec<(String, String)>,
    /// Integers of the image's metadata.
    numbers: Vec<(String, i32)>,
    /// Matrices of the image's metadata.
    matrices: Vec<(String, [f32; 16])>,
    /// Exposure of PNG output in stops, metered for the full frame.
    pub exposure: f32,
    pub method: String,
    pub pattern: Option<String>,
    pub combine: Option<String>,
    pub seed: u64,
    pub roulette: bool,
    pub ambient: Vec3,
    pub transparent_shadows: bool,
}

/// Key of the metadata that has the lines of a settings file.
const SETTINGS: &str = "settings";

impl Notes {
    /// Notes on a render with `settings`, whose part is to be rendered.
    pub fn new(
        options: &RenderOptions,
        settings: &Settings,
        view: &NamedCamera,
        loaded: &Loaded,
        exposure: f32,
    ) -> Self {
        let whole = whole(settings);
        let (mut texts, mut numbers, mut matrices) = (Vec::new(), Vec::new(), Vec::new());
        for (key, value) in metadata::attributes(options, &whole, &Stats::default(), view, &loaded.scene) {
            match value {
                MetaValue::Text(text) => texts.push((key, text)),
                MetaValue::Int(number) => numbers.push((key, number)),
                MetaValue::Matrix(matrix) => matrices.push((key, matrix)),
                MetaValue::Float(_) => {}
            }
        }
        let is_path = settings.kind() == MethodKind::Path;
        Self {
            of: size_of_set(settings).filter(|_| is_bounded(options, settings)),
            texts,
            numbers,
            matrices,
            exposure,
            method: values::method_name(settings.kind()).into(),
            pattern: is_path.then(|| settings.pattern.to_string()),
            combine: (!is_path).then(|| settings.combine().to_string()),
            seed: settings.seed,
            roulette: settings.roulette(),
            ambient: settings.ambient,
            transparent_shadows: settings.transparent_shadows,
        }
    }

    /// The metadata of an image with `spp` samples per pixel; `samples` and `crop` are its samples and pixels if it is
    /// not the whole.
    pub fn attributes(
        &self,
        spp: u32,
        samples: Option<&SampleRange>,
        crop: Option<[u32; 4]>,
    ) -> Vec<(String, MetaValue)> {
        let matrices = self.matrices.iter().map(|(key, matrix)| (key.clone(), MetaValue::Matrix(*matrix)));
        let count = i32::try_from(spp).unwrap_or(i32::MAX);
        let numbers = self
            .numbers
            .iter()
            .map(|(key, number)| (key.clone(), MetaValue::Int(if key == "spp" { count } else { *number })));
        let settings = |text: &str| {
            let mut lines: Vec<String> = text.lines().map(str::to_string).collect();
            for line in lines.iter_mut().filter(|line| line.starts_with("spp = ")) {
                let of = samples.and(self.of).unwrap_or(spp);
                *line = format!("spp = {}", of.max(1));
                samples.iter().for_each(|samples| *line += &format!("\nsamples = \"{samples}\""));
            }
            lines.extend(crop.map(metadata::crop_line));
            lines.join("\n")
        };
        let texts = self.texts.iter().map(|(key, text)| {
            (key.clone(), MetaValue::Text(if key == SETTINGS { settings(text) } else { text.clone() }))
        });
        matrices.chain(numbers).chain(texts).collect()
    }
}

/// The settings without what parts of one render may differ in.
fn whole(settings: &Settings) -> Settings {
    let of = size_of_set(settings);
    let whole = Settings { crop: None, ..settings.clone() };
    let whole =
        whole.with_path(|p| (p.samples, p.of, p.allocation) = (0..of.unwrap_or(u32::MAX), None, None));
    whole.with_distribution(|d| d.samples = None)
}

/// Whether the size of the set is given; parts of a sequence may be continued by further ones otherwise.
fn is_bounded(options: &RenderOptions, settings: &Settings) -> bool {
    let is_sequence = matches!(settings.pattern, Pattern::Sobol | Pattern::Random);
    !(options.long.samples.is_some() && options.spp.is_none() && is_sequence)
        || settings.kind() == MethodKind::Distribution
}

/// Size of the set that the samples of a part belong to; none if they have no end.
pub fn size_of_set(settings: &Settings) -> Option<u32> {
    match settings.path_tracer() {
        Some(path) => path.of.or(settings.samples()),
        None => settings.samples().map(|_| settings.round()),
    }
}

/// Renders the pilot samples of a part, and lets them decide the allocation of an adaptive render; none if the render
/// was stopped meanwhile.
pub fn pilot(
    settings: &mut Settings,
    view: &NamedCamera,
    loaded: &Loaded,
) -> Result<Option<PilotResult>, Failure> {
    let stop = |_| if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    // The shares of an adaptive render are those of the full frame.
    let crop = if settings.adaptive() { None } else { settings.crop };
    let frame = Settings { crop, ..settings.clone() };
    let found = render_pilot(&loaded.scene, &view.camera, &frame, &stop)
        .map_err(|e| Failure::Arguments(format!("--samples: {e}")))?;
    let Some(mut found) = found else { return Ok(None) };
    if let (Some(variance), Some(rect)) = (&found.variance, settings.crop.filter(|_| crop.is_none())) {
        let row = |y: u32| {
            let start = y as usize * settings.size.0 as usize;
            variance[start + rect.x0 as usize..start + rect.x1 as usize].iter().copied()
        };
        found.variance = Some(std::sync::Arc::new((rect.y0..rect.y1).flat_map(row).collect()));
    }
    let allocation = found.allocation.clone();
    *settings = settings.clone().with_path(|p| p.allocation = allocation);
    Ok(Some(found))
}

/// Describes the render that a part belongs to.
pub fn describe(
    options: &RenderOptions,
    settings: &Settings,
    view: &NamedCamera,
    loaded: &Loaded,
) -> Result<BTreeMap<String, String>, Failure> {
    // The number of samples matters only if they form one set.
    let is_set = matches!(settings.pattern, Pattern::Stratified | Pattern::Grid);
    let spp = size_of_set(settings).filter(|_| is_set).unwrap_or_default();
    let stats = Stats { spp, ..Stats::default() };
    let lines = metadata::settings_text(options, &whole(settings), &stats, view, &loaded.scene);
    let unread = |e: io::Error| Failure::Arguments(format!("a file of the scene cannot be read again: {e}"));
    let mut about = identity::describe(&loaded.scene, settings, options, &lines).map_err(unread)?;
    if let Some(allocation) = settings.allocation() {
        about.insert(identity::PILOT.into(), format!("{:016x}", allocation.digest()));
    }
    Ok(about)
}

impl PartFile {
    /// Encodes the file; `film` has the samples of the part.
    pub fn encode(&self, film: &Film) -> Result<Vec<u8>, String> {
        let mut about = self.about.clone();
        about.insert("samples".into(), ranges(self.part.covered()));
        let state = (&self.part, &self.notes, self.errors.encode()?);
        let state = postcard::to_stdvec(&state).map_err(|e| e.to_string())?;
        Contents::of(film, about, state).encode(Kind::Part)
    }

    /// Reads a file; the error says what is wrong with it.
    pub fn read(path: &Path) -> Result<Self, String> {
        Self::decode(&fs::read(path).map_err(|e| format!("cannot be read: {e}"))?)
    }

    /// Decodes a file; the error says what is wrong with it.
    pub fn decode(bytes: &[u8]) -> Result<Self, String> {
        let Contents { mut about, state, .. } = Contents::decode(Kind::Part, bytes)?;
        about.remove("samples");
        Self::of_state(about, &state)
    }

    /// Decodes the encoded sums.
    pub fn of_state(about: BTreeMap<String, String>, state: &[u8]) -> Result<Self, String> {
        let other = "it was written by another version of this program, whose sums this one does not read";
        let (part, notes, errors): (Part, Notes, Vec<u8>) =
            postcard::from_bytes(state).map_err(|_| other.to_string())?;
        part.check().map_err(|e| e.to_string())?;
        Ok(Self { about, part, notes, errors: Errors::decode(&errors).ok_or(other)? })
    }
}

/// Lists sample ranges for messages and metadata.
pub fn ranges(covered: &[Covered]) -> String {
    const NAMED: usize = 4;
    let show = |c: &Covered| {
        let (r, s) = (&c.rect, &c.samples);
        format!("{}:{} of pixels {},{} to {},{}", s.start, s.end, r.x0, r.y0, r.x1, r.y1)
    };
    let more =
        if covered.len() > NAMED { format!(" and {} more", covered.len() - NAMED) } else { String::new() };
    format!("{}{more}", covered.iter().take(NAMED).map(show).collect::<Vec<_>>().join(", "))
}
