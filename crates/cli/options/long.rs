//! Options of long renders: what is saved while they run.

use crate::progress::Style;
use crate::values::{self, SampleRange, Seconds};
use clap::Args;
use std::path::PathBuf;

/// Options that decide what a running render saves.
#[derive(Args, Clone, Debug, Default)]
pub struct LongOptions {
    /// Render only the samples with indices BEGIN to END - 1 (or BEGIN:+N) of every pixel, as a part for `dapple merge`
    ///
    /// They are samples of the set that --spp names, which stratified and grid points require; without it, of a set
    /// that ends at END. For --method distribution an index is a point of the pixel. With --adaptive the indices are
    /// those of a pixel with the mean number of samples. Write the part with -o NAME.part.
    #[arg(long, value_name = "BEGIN:END", help_heading = "Long renders")]
    pub samples: Option<SampleRange>,
    /// Save the state of the render to FILE at intervals, so that --resume can continue it after an interruption
    ///
    /// The file is replaced only when the new one is complete, and is also written when the render ends. An existing
    /// file is not overwritten, unless --resume continues from it.
    #[arg(long, value_name = "FILE", help_heading = "Long renders")]
    pub checkpoint: Option<PathBuf>,
    /// Interval between two checkpoints [default: 60s]
    #[arg(long, value_name = "TIME", value_parser = values::duration, help_heading = "Long renders")]
    pub checkpoint_every: Option<Seconds>,
    /// Continue from a checkpoint; the image has the same bytes as that of an uninterrupted render
    ///
    /// Scene, settings and sample version must be those of the checkpoint. Further checkpoints replace FILE, unless
    /// --checkpoint names another one. If both name the same file, a missing file starts the render, so that a script
    /// can repeat one command.
    #[arg(long, value_name = "FILE", help_heading = "Long renders")]
    pub resume: Option<PathBuf>,
    /// Check everything, print a forecast of memory, rays, time and disk space, and end before the first ray
    ///
    /// The exit code is 2 where the render would be refused. A small image is rendered to measure the speed.
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Long renders")]
    pub dry_run: Option<bool>,
    /// How to show progress: auto (a bar on a terminal, otherwise lines), lines (on standard error, after 10 s and at
    /// intervals of up to a minute), or openjd (openjd_progress and openjd_status on standard output) [default: auto]
    #[arg(long, value_name = "STYLE", help_heading = "Long renders")]
    pub progress: Option<Style>,
    /// Save the image so far as NAME.partial.EXT at this interval; 0 = never [default: after 1, 3 and 7 minutes, then
    /// every 5 minutes]
    ///
    /// Without this option, images are saved only as often as that takes at most 1 % of the time. They are removed when
    /// the render ends. On Unix, the signal USR1 saves one at once.
    #[arg(long, value_name = "TIME", value_parser = values::interval, help_heading = "Long renders")]
    pub save_every: Option<Seconds>,
}

impl LongOptions {
    /// Whether the render can be continued from a file.
    pub fn has_checkpoint(&self) -> bool {
        self.checkpoint.is_some() || self.resume.is_some()
    }
}
