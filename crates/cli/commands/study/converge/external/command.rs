//! The command line of another renderer, and the rendering of one image by it.

use super::super::folder::plain;
use super::super::session::Session;
use crate::error::{self, Failure};
use crate::{machine, memory};
use dapple_integrator::imaging::{Image, Window, read};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

/// Another renderer.
pub struct External {
    pub name: String,
    pub command: String,
}

/// Time that an image took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Took {
    /// Wall-clock seconds of the whole command.
    pub wall: f64,
    /// Processor seconds of all its processes.
    pub cpu: f64,
    /// Wall-clock seconds of rendering that the command reported.
    pub told_wall: Option<f64>,
    /// Processor seconds of rendering that the command reported.
    pub told_cpu: Option<f64>,
}

impl External {
    /// Parses `NAME=COMMAND`; the command must contain `{spp}` and `{out}`.
    pub fn parse(text: &str) -> Result<Self, Failure> {
        let wrong = |why: &str| Failure::Arguments(format!("--external '{}': {why}", error::short(text)));
        let (name, command) = text.split_once('=').ok_or_else(|| wrong("write it as NAME=COMMAND"))?;
        for needed in ["{spp}", "{out}"] {
            if !command.contains(needed) {
                return Err(wrong(&format!("the command must contain {needed}")));
            }
        }
        Ok(Self { name: name.trim().into(), command: command.trim().into() })
    }

    pub fn has_seeds(&self) -> bool {
        self.command.contains("{seed}")
    }

    /// Whether the command reports its rendering time.
    pub fn tells_time(&self) -> bool {
        self.command.contains("{time}")
    }

    /// Renders one image; returns it and the time that it took.
    pub fn render(
        &self,
        session: &Session<'_>,
        scene: &str,
        spp: u32,
        seed: u32,
    ) -> Result<(Image, Took), Failure> {
        let file = |end: &str| session.folder.file(&format!("{}-{}{end}", plain(scene), plain(&self.name)));
        let (out, time) = (file(".exr"), file(".time"));
        let mut line = self.command.replace("{scene}", scene);
        for (key, value) in [
            ("{spp}", spp.to_string()),
            ("{out}", out.display().to_string()),
            ("{time}", time.display().to_string()),
            ("{seed}", seed.to_string()),
            ("{threads}", machine::threads(session.arguments.options.threads).to_string()),
        ] {
            line = line.replace(key, &value);
        }
        let what = format!("{scene}: {} · seed {seed} · {spp} spp", self.name);
        session.bar.show_task(session.clock.fraction(), session.clock.elapsed(), &what);
        let failed = |why: String| Failure::Arguments(format!("--external {}: `{line}` {why}", self.name));
        // Files of an earlier call must not be mistaken for those of this call.
        [&out, &time].into_iter().for_each(|file| drop(std::fs::remove_file(file)));
        let (cpu, start) = (machine::children_cpu_seconds(), Instant::now());
        let done = shell(&line).stdin(Stdio::null()).stdout(Stdio::null()).output();
        let (wall, cpu) = (start.elapsed().as_secs_f64(), machine::children_cpu_seconds() - cpu);
        let done = done.map_err(|e| failed(format!("cannot be started: {e}")))?;
        if !done.status.success() {
            let said = String::from_utf8_lossy(&done.stderr);
            let last = said.lines().rfind(|l| !l.trim().is_empty()).unwrap_or_default().to_string();
            return Err(failed(format!("failed ({}): {}", done.status, error::short(&last))));
        }
        let picture = read::windowed_within(&out, memory::limit(session.memory_limit))
            .map_err(|e| failed(format!("wrote no image: {e}")))?;
        let full = Window::full(picture.full_size);
        let picture = picture.covering(full, &out.display().to_string())?;
        let told = if self.tells_time() { told(&time).map_err(failed)? } else { (None, None) };
        Ok((picture, Took { wall, cpu, told_wall: told.0, told_cpu: told.1 }))
    }
}

/// Reads a time file: the wall-clock seconds of rendering and, optionally, the processor seconds.
fn told(path: &Path) -> Result<(Option<f64>, Option<f64>), String> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("wrote no {{time}} file: {e}"))?;
    let numbers: Option<Vec<f64>> = text
        .split_whitespace()
        .map(|n| n.parse().ok().filter(|s: &f64| s.is_finite() && *s >= 0.0))
        .collect();
    match numbers.as_deref() {
        Some([wall]) => Ok((Some(*wall), None)),
        Some([wall, cpu]) => Ok((Some(*wall), Some(*cpu))),
        _ => Err(format!(
            "wrote a {{time}} file that is not one or two numbers (seconds of rendering, processor seconds): '{}'",
            error::short(&error::one_line(&text))
        )),
    }
}

fn shell(line: &str) -> Command {
    let (shell, option) = if cfg!(windows) { ("cmd", "/C") } else { ("sh", "-c") };
    let mut command = Command::new(shell);
    command.arg(option).arg(line);
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_say_where_counts_and_pictures_go() {
        let found = External::parse("other = render {scene} -s {spp} -o {out} --seed {seed}").unwrap();
        assert_eq!((found.name.as_str(), found.has_seeds(), found.tells_time()), ("other", true, false));
        for bad in ["other", "other=render {spp}", "other=render {out}"] {
            assert!(External::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn time_files_are_one_or_two_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("time");
        let of = |text: &str| {
            std::fs::write(&path, text).unwrap();
            told(&path)
        };
        assert_eq!(of("1.5\n"), Ok((Some(1.5), None)));
        assert_eq!(of("0.25 0.5"), Ok((Some(0.25), Some(0.5))));
        for bad in ["", "a", "1 2 3", "-1", "nan"] {
            assert!(of(bad).unwrap_err().contains("{time}"), "{bad}");
        }
    }
}
