//! Writing a part of a render for `dapple merge`.

use crate::checkpoint;
use crate::error::Failure;
use crate::load::Loaded;
use crate::options::RenderOptions;
use crate::output::{Outputs, Written};
use crate::part::{self, Errors, Notes, PartFile};
use crate::say::say;
use crate::{metering, saving};
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::NamedCamera;
use dapple_integrator::{MethodKind, Outcome, Part, PilotResult, Settings};
use std::collections::BTreeMap;

/// What a part holds beside its sums, and its pilot samples.
pub struct Parting {
    pilot: Option<PilotResult>,
    about: BTreeMap<String, String>,
    notes: Notes,
}

impl Parting {
    /// Whether a render depends on pilot samples that it may not have itself.
    pub fn is_asked(options: &RenderOptions, settings: &Settings, outputs: &Outputs) -> bool {
        outputs.parts().next().is_some() || (options.long.samples.is_some() && settings.adaptive())
    }

    /// Renders the pilot samples and collects the notes. If that is interrupted, the render takes no samples either.
    pub fn begin(
        options: &RenderOptions,
        settings: &mut Settings,
        view: &NamedCamera,
        loaded: &Loaded,
        outputs: &Outputs,
    ) -> Result<Self, Failure> {
        let is_part = outputs.parts().next().is_some();
        if is_part && options.error_limit.is_some() {
            let why = "the error of the whole is known only after dapple merge; leave out --error-limit";
            return Err(Failure::Arguments(format!("-o NAME.part: {why}")));
        }
        let needs_pilot = settings.adaptive() || (is_part && !has_own_pilot(settings));
        let pilot = if needs_pilot { part::pilot(settings, view, loaded)? } else { None };
        if needs_pilot && pilot.is_none() {
            *settings = settings.clone().with_path(|p| p.adaptive = false);
        }
        let about = part::describe(options, settings, view, loaded)?;
        let meter = || metering::exposure(&loaded.scene, &view.camera, settings);
        let exposure = outputs.exposure().or(options.exposure);
        let exposure = exposure.unwrap_or_else(|| if is_part && settings.picture { meter() } else { 0.0 });
        let notes = Notes::new(options, settings, view, loaded, exposure);
        Ok(Self { pilot, about, notes })
    }

    /// Measures the error of the part `sums`, and writes it to the outputs that are parts. Of a render that was stopped
    /// (`is_early`), nothing is written if its checkpoint continues it (`has_checkpoint`).
    pub fn end(
        self,
        (loaded, view, settings): (&Loaded, &NamedCamera, &Settings),
        (sums, is_early, has_checkpoint): (Option<Part>, bool, bool),
        (outputs, outcome): (&Outputs, &Outcome),
        written: &mut Written,
    ) {
        if outputs.parts().next().is_none() {
            return;
        }
        let Some(part) = sums.filter(|_| !(is_early && has_checkpoint)) else {
            let why = if has_checkpoint { "--resume continues it" } else { "not every pixel has a sample" };
            say(&format!("the part is not written: {why}"));
            written.failed.extend(outputs.parts().map(Into::into));
            return;
        };
        let start = settings.sample_range().start;
        let samples = start..start + outcome.stats.spp;
        let pilot = self.pilot.map_or_else(|| outcome.pilot.clone(), |pilot| pilot.variance);
        let errors = Errors::render(loaded, &view.camera, settings, pilot, samples);
        let file = PartFile { about: self.about, part, notes: self.notes, errors };
        match file.encode(&outcome.film) {
            Ok(bytes) => outputs.write_parts(&bytes, !is_early, written),
            Err(why) => {
                say(&format!("error: the part cannot be encoded: {why}"));
                saving::lose();
            }
        }
    }
}

/// Whether a part begins with all pilot samples, or needs none, because its samples are independent.
fn has_own_pilot(settings: &Settings) -> bool {
    let range = settings.sample_range();
    let has_all = settings.pilot_samples().is_none_or(|count| range.start == 0 && range.end >= count);
    let is_random = settings.kind() == MethodKind::Path && settings.pattern == Pattern::Random;
    has_all || is_random || !settings.picture
}

/// Whether a render both has checkpoints and writes a part under the same name.
pub fn refuse_same(outputs: &Outputs, files: &checkpoint::Files) -> Result<(), Failure> {
    let same = |part: &std::path::Path| files.paths().find(|path| *path == part).map(|_| part.to_path_buf());
    match outputs.parts().find_map(same) {
        Some(path) => Err(Failure::Arguments(format!(
            "{}: is both the checkpoint and the part; choose another name for one of them",
            path.display()
        ))),
        None => Ok(()),
    }
}
