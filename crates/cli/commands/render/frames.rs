//! `dapple render --frames`: the frames of an animation, each with the bytes that it has alone.

use super::image::{self, Kept};
use super::settings::settings;
use crate::error::Failure;
use crate::load::{self, Source};
use crate::options::{Frames, RenderOptions};
use crate::output::Outputs;
use crate::report::Report;
use crate::say::say;
use crate::{interrupt, metering, standard_output};
use clap::ArgMatches;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Exit code of a sequence that was stopped early.
const STOPPED: u8 = 3;

/// Renders the frames of `range`.
pub fn run(
    scene: (Option<&str>, &Source),
    options: &RenderOptions,
    range: Frames,
    typed: &ArgMatches,
) -> Result<ExitCode, Failure> {
    let mut sequence = Sequence::new(scene.1, options, range)?;
    let mut code = ExitCode::SUCCESS;
    sequence.meter(scene.1)?;
    for (i, number) in (1..).zip(range.numbers()) {
        if interrupt::asked() {
            say(&format!(
                "stopped early: {} of {} frames are not begun",
                range.count() - (i - 1),
                range.count()
            ));
            code = ExitCode::from(STOPPED);
            break;
        }
        let frame = sequence.frame(number);
        if RenderOptions::is(options.frames.skip_existing) && sequence.exists(&frame)? {
            sequence.skipped.push(number);
            continue;
        }
        let (report, ended) = image::image(scene, &frame, typed, &mut sequence.kept)?;
        if ended != ExitCode::SUCCESS {
            code = ended;
        }
        sequence.tell(number, (i, range.count()), &report);
    }
    sequence.end();
    Ok(code)
}

/// The options of the first image that a render writes.
pub fn first_of(source: &Source, options: &RenderOptions) -> Result<RenderOptions, Failure> {
    let Some(range) = options.frames.frames else { return Ok(options.clone()) };
    let first = range.numbers().next().unwrap_or_default();
    Ok(Sequence::new(source, options, range)?.frame(first))
}

/// A sequence of frames in progress.
struct Sequence<'a> {
    options: &'a RenderOptions,
    /// The outputs, with a pattern for the number.
    outputs: Vec<PathBuf>,
    kept: Kept,
    exposure: Option<f32>,
    rendered: Vec<Value>,
    skipped: Vec<i64>,
}

impl<'a> Sequence<'a> {
    fn new(source: &Source, options: &'a RenderOptions, range: Frames) -> Result<Self, Failure> {
        let default = || {
            let formats = if options.shows_picture() { &["exr", "png"][..] } else { &["exr"] };
            formats.iter().map(|format| PathBuf::from(format!("{}.####.{format}", source.name()))).collect()
        };
        let outputs: Vec<PathBuf> = options.output.clone().unwrap_or_else(default);
        let long = &options.long;
        let others =
            [("--log", &options.log), ("--checkpoint", &long.checkpoint), ("--resume", &long.resume)];
        let others = others.into_iter().filter_map(|(name, path)| Some((name, path.as_ref()?)));
        for (name, path) in outputs.iter().map(|path| ("-o", path)).chain(others) {
            if range.count() > 1 && !has_number(path) {
                return Err(Failure::Arguments(format!(
                    "{name} {}: every frame needs a file of its own; write #### where its number belongs",
                    path.display()
                )));
            }
        }
        Ok(Self {
            options,
            outputs,
            kept: Kept::default(),
            exposure: options.exposure,
            rendered: Vec::new(),
            skipped: Vec::new(),
        })
    }

    /// Meters the exposure of all PNGs at frame 0, so that it does not depend on which frames are rendered.
    fn meter(&mut self, source: &Source) -> Result<(), Failure> {
        let is_png = |path: &PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
        if self.exposure.is_some() || !self.outputs.iter().any(is_png) {
            return Ok(());
        }
        let mut first = self.frame(0);
        first.quiet = Some(true);
        let loaded = load::load(source, &first)?;
        let view = load::camera(&loaded.scene, &first)?;
        let settings = settings(&first, &view)?;
        self.exposure =
            Some(metering::metered("all PNGs", self.options, (&loaded.scene, &view.camera, &settings)));
        self.kept.loaded = Some(loaded);
        Ok(())
    }

    /// The options of one frame.
    fn frame(&mut self, number: i64) -> RenderOptions {
        let mut frame = self.options.clone();
        frame.at = Some(frame.at.unwrap_or(0.0) + number as f64 / frame.frames.rate());
        if !RenderOptions::is(frame.frames.fixed_seed) {
            frame.seed = Some(seed(frame.seed.unwrap_or(0), number));
        }
        frame.exposure = self.exposure;
        let named = |path: &PathBuf| numbered(path, number);
        frame.output = Some(self.outputs.iter().map(named).collect());
        frame.log = frame.log.as_ref().map(named);
        frame.long.checkpoint = frame.long.checkpoint.as_ref().map(named);
        frame.long.resume = frame.long.resume.as_ref().map(named);
        #[cfg(feature = "gltf")]
        {
            frame.images = Some(self.images());
        }
        frame
    }

    /// The images that are kept between frames.
    #[cfg(feature = "gltf")]
    fn images(&mut self) -> dapple_integrator::scene::gltf::KeptImages {
        self.kept.images.get_or_insert_default().clone()
    }

    /// Whether all outputs of a frame exist.
    fn exists(&self, frame: &RenderOptions) -> Result<bool, Failure> {
        Ok(Outputs::plan(frame, "")?.paths().all(Path::exists))
    }

    /// Reports a frame.
    fn tell(&mut self, number: i64, (i, of): (u64, u64), report: &Report) {
        if !RenderOptions::is(self.options.quiet) {
            say(&format!(
                "frame {number} ({i} of {of}): loaded in {:.2} s, built in {:.2} s, rendered in {:.2} s",
                report.load_seconds, report.build_seconds, report.render_seconds
            ));
        }
        if RenderOptions::is(self.options.json) {
            let mut object = json!(report);
            object["frame"] = number.into();
            self.rendered.push(object);
        } else {
            report.outputs.iter().for_each(|path| standard_output::result(path));
        }
    }

    /// Reports the sequence.
    fn end(&self) {
        let saved = self.kept.saved_seconds + self.images_saved();
        if !RenderOptions::is(self.options.quiet) {
            let skipped = match self.skipped.len() {
                0 => String::new(),
                n => format!("{n} existing frames are skipped; "),
            };
            say(&format!(
                "{skipped}what was kept between frames saved {saved:.2} s: {:.2} s for scenes that do not change, {:.2} \
                 s for decoding images",
                self.kept.saved_seconds,
                self.images_saved()
            ));
        }
        if RenderOptions::is(self.options.json) {
            standard_output::json(&json!({
                "frames": self.rendered,
                "skipped": self.skipped,
                "saved_seconds": saved,
            }));
        }
    }

    #[cfg(feature = "gltf")]
    fn images_saved(&self) -> f64 {
        self.kept.images.as_ref().map_or(0.0, |images| images.saved().as_secs_f64())
    }

    #[cfg(not(feature = "gltf"))]
    fn images_saved(&self) -> f64 {
        0.0
    }
}

/// The seed of a frame: two rounds of the finaliser of SplitMix64 [Steele, Lea & Flood 2014] over the seed and the number.
fn seed(seed: u64, number: i64) -> u64 {
    let mix = |x: u64| {
        let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    };
    mix(mix(seed.wrapping_add(0x9e37_79b9_7f4a_7c15)) ^ number as u64)
}

/// Whether the name has a place for the number of the frame.
fn has_number(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().contains('#'))
}

/// Replaces the first group of `#` in the name by the number of the frame, with at least as many digits.
fn numbered(path: &Path, number: i64) -> PathBuf {
    let Some(name) = path.file_name().and_then(|name| name.to_str()) else { return path.to_path_buf() };
    let Some(start) = name.find('#') else { return path.to_path_buf() };
    let width = name[start..].chars().take_while(|c| *c == '#').count();
    path.with_file_name(format!("{}{number:0width$}{}", &name[..start], &name[start + width..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_go_into_names() {
        let named = |name: &str, number| numbered(Path::new(name), number).display().to_string();
        assert_eq!(named("a/shot.####.exr", 7), "a/shot.0007.exr");
        assert_eq!(named("shot#.exr", 123), "shot123.exr");
        assert_eq!(named("##-##.png", -1), "-1-##.png");
        assert_eq!(named("a##/shot.exr", 1), "a##/shot.exr");
        assert!(has_number(Path::new("a.#.exr")) && !has_number(Path::new("a#/b.exr")));
    }

    #[test]
    fn seeds_of_frames_and_of_neighbouring_seeds_differ() {
        let all: std::collections::HashSet<u64> =
            (0..64).flat_map(|s| (-64..64).map(move |frame| seed(s, frame))).collect();
        assert_eq!(all.len(), 64 * 128);
    }
}
