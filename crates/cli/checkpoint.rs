//! Checkpoints: the complete state of a render in a file, from which `--resume` continues to the same bytes.
//!
//! A checkpoint is written to a temporary file, synced and renamed, so that the file under its name is always complete.
//! It describes what it belongs to, and a render of anything else does not resume from it.

pub mod file;
pub mod identity;
mod lock;

use crate::error::{self, Failure};
use crate::error_watch::Saved;
use crate::options::RenderOptions;
use crate::say::say;
use dapple_integrator::imaging::write;
use dapple_integrator::scene::Scene;
use dapple_integrator::{RenderState, Renderer, Settings};
use file::{Contents, Kind};
use lock::Lock;
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Default interval between two checkpoints.
const EVERY: Duration = Duration::from_secs(60);

/// The state of a render and of its error estimate.
pub type State = (RenderState, Saved);

/// Files of a render that can be resumed, before the scene is loaded.
pub struct Files {
    /// The file to write, with its lock; none if there are no checkpoints.
    target: Option<(PathBuf, Lock)>,
    resumed: Option<(PathBuf, Contents)>,
    every: Duration,
}

impl Files {
    /// Locks the file that the options name, and reads the checkpoint to resume from.
    ///
    /// # Errors
    /// If a file cannot be read or written, another process uses it, or an existing checkpoint would be lost.
    pub fn open(options: &RenderOptions) -> Result<Self, Failure> {
        let long = &options.long;
        let every = long.checkpoint_every.unwrap_or(EVERY);
        let resume = long.resume.as_ref();
        let target = long.checkpoint.as_ref().or(resume);
        if let Some(path) = target {
            write::probe(path)?;
        }
        let target = match target {
            Some(path) => Some((path.clone(), Lock::take(path)?)),
            None => None,
        };
        if let Some(path) = long.checkpoint.as_ref().filter(|path| path.exists() && resume.is_none()) {
            let path = path.display();
            return Err(Failure::Arguments(format!(
                "--checkpoint {path}: the file exists; continue with --resume {path}, or remove it to start again"
            )));
        }
        let is_new = |path: &&PathBuf| long.checkpoint.as_ref() == Some(*path) && !path.exists();
        if let Some(path) = resume.filter(is_new) {
            say(&format!("note: --resume {}: there is no checkpoint yet; the render starts", path.display()));
        }
        let resumed = match resume.filter(|path| !is_new(path)) {
            Some(path) => Some((path.clone(), read(path)?)),
            None => None,
        };
        Ok(Self { target, resumed, every })
    }

    /// Returns the checkpoint files, which must be neither inputs nor outputs.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        let target = self.target.iter().map(|(path, _)| path.as_path());
        target.chain(self.resumed.iter().map(|(path, _)| path.as_path()))
    }

    /// Checks that the checkpoint belongs to this render, of which `lines` are the lines of a settings file, and
    /// decodes its state.
    ///
    /// # Errors
    /// If it belongs to another render.
    pub fn begin(
        self,
        (scene, settings): (&Scene, &Settings),
        options: &RenderOptions,
        lines: &str,
    ) -> Result<(Option<Checkpoint>, Option<State>), Failure> {
        if self.target.is_none() {
            return Ok((None, None));
        }
        let unread = |e: io::Error| {
            Failure::Arguments(format!("--checkpoint: a file of the scene cannot be read: {e}"))
        };
        let about = identity::describe(scene, settings, options, lines).map_err(unread)?;
        let state = match &self.resumed {
            Some((path, contents)) => Some(decode(path, contents, &about, settings.samples())?),
            None => None,
        };
        let checkpoint = self.target.map(|(path, lock)| Checkpoint {
            path,
            _lock: lock,
            about,
            every: self.every,
            next: Instant::now().checked_add(self.every),
            is_failing: false,
        });
        Ok((checkpoint, state))
    }
}

/// The error of a checkpoint that this render cannot continue.
fn refused(path: &Path, why: &str) -> Failure {
    Failure::Arguments(format!("--resume {}: {why}", path.display()))
}

fn read(path: &Path) -> Result<Contents, Failure> {
    let bytes = fs::read(path).map_err(|e| refused(path, &format!("cannot be read: {e}")))?;
    Contents::decode(Kind::Checkpoint, &bytes).map_err(|why| refused(path, &why))
}

fn decode(
    path: &Path,
    contents: &Contents,
    about: &BTreeMap<String, String>,
    most: Option<u32>,
) -> Result<State, Failure> {
    if let Some(why) = identity::difference(&contents.about, about) {
        return Err(refused(path, &why));
    }
    let state: State = postcard::from_bytes(&contents.state).map_err(|_| {
        refused(path, "it was written by another version of this program, whose state this one does not read")
    })?;
    match (state.0.next_sample(), most) {
        (has, Some(most)) if has > most => Err(refused(
            path,
            &format!("it has {has} samples per pixel, more than the {most} that are requested"),
        )),
        _ => Ok(state),
    }
}

/// The checkpoint of a running render.
pub struct Checkpoint {
    path: PathBuf,
    _lock: Lock,
    about: BTreeMap<String, String>,
    every: Duration,
    /// Time of the next checkpoint; none if it is out of reach.
    next: Option<Instant>,
    is_failing: bool,
}

impl Checkpoint {
    /// Writes a checkpoint if it is due or requested.
    pub fn between(&mut self, renderer: &Renderer<'_>, errors: impl FnOnce() -> Saved, is_asked: bool) {
        if is_asked || self.next.is_some_and(|next| Instant::now() >= next) {
            self.save(renderer, &errors());
            self.next = Instant::now().checked_add(self.every);
        }
    }

    /// Writes a checkpoint; returns whether that succeeded. A failure is reported once, and the former checkpoint is
    /// kept.
    pub fn save(&mut self, renderer: &Renderer<'_>, errors: &Saved) -> bool {
        match self.write(renderer, errors) {
            Ok(()) => {
                self.is_failing = false;
                true
            }
            Err(why) => {
                if !self.is_failing {
                    let path = self.path.display();
                    say(&format!(
                        "error: --checkpoint {path}: cannot be written: {why}; the former one is kept"
                    ));
                }
                self.is_failing = true;
                false
            }
        }
    }

    fn write(&self, renderer: &Renderer<'_>, errors: &Saved) -> Result<(), String> {
        let start = Instant::now();
        let state = postcard::to_stdvec(&(renderer.saved(), errors)).map_err(|e| e.to_string())?;
        let contents = Contents::of(&renderer.snapshot().film(), self.about.clone(), state);
        let bytes = contents.encode(Kind::Checkpoint)?;
        write::replace(&self.path, &bytes).map_err(|e| error::one_line(&e.to_string()))?;
        tracing::debug!(bytes = bytes.len(), seconds = start.elapsed().as_secs_f64(), "checkpoint written");
        Ok(())
    }
}
