//! `dapple render`: one image, or the frames of an animation.

mod dry_run;
mod frames;
mod image;
mod parting;
mod settings;

use crate::error::Failure;
use crate::load::Source;
use crate::options::RenderOptions;
use crate::{events, settings_file};
use clap::ArgMatches;
use image::Kept;
#[cfg(feature = "report")]
pub use image::say_light_unit;
pub use image::warn;
pub use settings::settings;
use std::process::ExitCode;

/// Renders `scene` with the sidecar's, the settings file's and the typed options.
pub fn run(scene: Option<&str>, typed: &ArgMatches) -> Result<ExitCode, Failure> {
    let source = Source::new(scene);
    let options = settings_file::layered(source.path(), typed, "render")?;
    events::start(&options);
    if RenderOptions::is(options.long.dry_run) {
        return dry_run::run(&source, &options)
            .map(|fits| if fits { ExitCode::SUCCESS } else { ExitCode::from(2) });
    }
    if let Some(range) = options.frames.frames {
        return frames::run((scene, &source), &options, range, typed);
    }
    let (report, code) = image::image((scene, &source), &options, typed, &mut Kept::default())?;
    image::tell(&options, &report);
    Ok(code)
}
