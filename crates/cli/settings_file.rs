//! Settings in TOML: the sidecar `SCENE-STEM.toml` beside a scene, and `--settings FILE`.
//!
//! Keys are the options' long names, values those of the options (a list stands for a comma-separated value).
//! `env` is relative to the folder of the file, `output` to the current folder.
//!
//! A sidecar comes with a scene that may come from an untrusted source, so it can change only how the scene looks: the
//! keys in [`SIDECAR_KEYS`] are read, all others are ignored with a warning. A sidecar causes no file to be written,
//! reads no file outside the scene's folder (symbolic links are resolved first), cannot give the user's consent (`yes`,
//! `allow-path`), and is subject to the work limits of [`crate::consent`].

use crate::consent;
use crate::error::{self, Failure};
use crate::options::{self, NO_ENVIRONMENT, OfScene, RenderOptions};
use crate::say::say;
use crate::{suggest, uses};
use clap::ArgMatches;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Author of a settings file, which determines what it may set.
#[derive(Clone, Copy, PartialEq)]
enum Trust {
    /// The author of the scene; `anywhere` if the user allows the scene to refer to files outside its folder.
    Scene { anywhere: bool },
    /// The user, who named the file on the command line.
    User,
}

/// Options that a sidecar may set: view, environment, lens, shutter, effects, tone and sampling.
const SIDECAR_KEYS: [&str; 55] = [
    "size",
    "crop",
    "camera",
    "scene",
    "variant",
    "animation",
    "at",
    "shutter",
    "fps",
    "shutter-angle",
    "fixed-seed",
    "look-from",
    "look-at",
    "orbit",
    "up",
    "fov",
    "backfaces",
    "cull-backfaces",
    "env",
    "env-color",
    "env-rotation",
    "env-intensity",
    "env-nearest",
    "env-smooth",
    "light-unit",
    "aperture-radius",
    "focus-distance",
    "aperture-shape",
    "pixel",
    "lens",
    "time",
    "light",
    "glossy",
    "refract",
    "diffuse",
    "combine",
    "secondary",
    "ambient",
    "exposure",
    "tone",
    "method",
    "spp",
    "time-limit",
    "error-limit",
    "confidence",
    "pattern",
    "adaptive",
    "seed",
    "max-bounces",
    "no-roulette",
    "clamp",
    "transparent-shadows",
    "no-soft-terminator",
    "filter",
    "plan",
];

/// Options that only the user can set: outputs, messages, use of the machine, and consent.
#[cfg(test)]
const USER_KEYS: [&str; 24] = [
    "output",
    "aov",
    "half",
    "transparent",
    "png-depth",
    "frames",
    "skip-existing",
    "samples",
    "progress",
    "dry-run",
    "save-every",
    "checkpoint",
    "checkpoint-every",
    "resume",
    "log",
    "json",
    "quiet",
    "verbose",
    "threads",
    "settings",
    "allow-path",
    "strict",
    "memory-limit",
    "yes",
];

/// Combines all layers: the sidecar of `scene`, then `--settings`, then the typed options. Options that `command` does
/// not use are skipped.
pub fn layered(scene: Option<&Path>, typed: &ArgMatches, command: &str) -> Result<RenderOptions, Failure> {
    let (mut options, warning) = layers(scene, typed, command)?;
    consent::of_values(&mut options)?;
    warning.iter().for_each(|warning| say(&format!("warning: {warning}")));
    let of_scene = &options.of_scene;
    if !of_scene.keys.is_empty() && !RenderOptions::is(options.quiet) {
        say(&format!("note: {} sets {}", of_scene.file.display(), of_scene.keys.join(", ")));
    }
    Ok(options)
}

/// Lists keys for a warning: not too many, and each shortened.
fn listed(keys: &[String]) -> String {
    const NAMED: usize = 12;
    let mut named: Vec<String> =
        keys.iter().take(NAMED).map(|key| format!("'{}'", error::short(key))).collect();
    if keys.len() > NAMED {
        named.push(format!("and {} more", keys.len() - NAMED));
    }
    named.join(", ")
}

/// Does the work of [`layered`], but returns the warning instead of printing it.
pub fn layers(
    scene: Option<&Path>,
    typed: &ArgMatches,
    command: &str,
) -> Result<(RenderOptions, Option<String>), Failure> {
    let mut warning = None;
    let mut command_line = RenderOptions::default();
    command_line.apply_matches(typed)?;
    let mut options = RenderOptions::default();
    if let Some(sidecar) = scene.and_then(sidecar) {
        let anywhere = RenderOptions::is(command_line.allow_path);
        let ignored = apply_file(&mut options, &sidecar, Trust::Scene { anywhere }, command)?;
        let (known, unknown): (Vec<String>, Vec<String>) =
            ignored.into_iter().partition(|key| options::names().iter().any(|name| name == key));
        let mut parts = Vec::new();
        if !known.is_empty() {
            parts.push(format!(
                "ignored {}; a settings file beside the scene cannot set these (use --settings to apply it as your own)",
                listed(&known)
            ));
        }
        if !unknown.is_empty() {
            parts.push(format!("ignored {}; there are no such options", listed(&unknown)));
        }
        warning = (!parts.is_empty()).then(|| format!("{}: {}", sidecar.display(), parts.join("; ")));
    }
    if let Some(path) = &command_line.settings {
        apply_file(&mut options, path, Trust::User, command)?;
    }
    options.apply_matches(typed)?;
    Ok((options, warning))
}

/// Returns the settings file beside a scene, if it exists.
pub fn sidecar(scene: &Path) -> Option<PathBuf> {
    Some(scene.with_extension("toml")).filter(|path| path.is_file())
}

/// Applies a file as one beside a scene and as the user's own.
#[cfg(fuzzing)]
pub fn fuzzed(path: &Path) -> Result<(), Failure> {
    let mut options = RenderOptions::default();
    apply_file(&mut options, path, Trust::Scene { anywhere: false }, "render")?;
    apply_file(&mut options, path, Trust::User, "sheet")?;
    consent::of_values(&mut options)
}

/// Applies the file; returns the keys that it is not allowed to set.
fn apply_file(
    options: &mut RenderOptions,
    path: &Path,
    trust: Trust,
    command: &str,
) -> Result<Vec<String>, Failure> {
    let broken = |reason: String| Failure::SettingsFile { path: path.into(), reason };
    let text = read_text(path).map_err(|e| broken(e.to_string()))?;
    let table: toml::Table = text.parse().map_err(|e: toml::de::Error| broken(toml_line(&text, &e)))?;
    let (mut arguments, mut ignored, mut idle) = (Vec::new(), Vec::new(), Vec::new());
    let mut keys = Vec::new();
    for (key, value) in &table {
        if trust != Trust::User && !SIDECAR_KEYS.contains(&key.as_str()) {
            ignored.push(key.clone());
            continue;
        }
        let wrong =
            |reason: String| Failure::SettingsKey { path: path.into(), key: error::short(key), reason };
        let given = argument(key, value, path, trust).map_err(wrong)?;
        // Each key is parsed alone first, so that the error message names it.
        RenderOptions::default().apply(&given).map_err(|e| wrong(e.to_string()))?;
        if uses::serves(command, key) {
            arguments.extend(given);
            keys.push(key.clone());
        } else {
            idle.push(key.as_str());
        }
    }
    if !idle.is_empty() {
        let (file, keys) = (path.display(), idle.join(", "));
        say(&format!("note: {file}: {keys}: ignored, because dapple {command} does not use it"));
    }
    options.apply(&arguments).map_err(|e| broken(e.to_string()))?;
    if trust != Trust::User {
        options.of_scene = OfScene { file: path.into(), command: command.into(), keys };
    }
    Ok(ignored)
}

/// Maximum size of a settings file, in bytes.
const MAX_FILE: u64 = 1 << 20;

fn read_text(path: &Path) -> std::io::Result<String> {
    use std::io::Read;
    let mut text = String::new();
    std::fs::File::open(path)?.take(MAX_FILE + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MAX_FILE {
        return Err(std::io::Error::other("it is larger than 1 MiB, the maximum for a settings file"));
    }
    Ok(text)
}

/// Converts a key and its value to arguments, as they would be typed.
fn argument(key: &str, value: &toml::Value, file: &Path, trust: Trust) -> Result<Vec<OsString>, String> {
    if !options::names().iter().any(|name| name == key) {
        let said = "unknown; the keys are the options of dapple render, without the leading dashes";
        let meant = suggest::key(key, &options::names()).map(|remedy| format!("; {remedy}"));
        return Err(format!("{said}{}", meant.unwrap_or_default()));
    }
    if key == "settings" {
        return Err("can be set only on the command line".into());
    }
    let mut values: Vec<String> = match value {
        toml::Value::Array(items) => items.iter().map(scalar).collect::<Result<_, _>>()?,
        single => vec![scalar(single)?],
    };
    match key {
        "env" if values == [NO_ENVIRONMENT] => {}
        "env" => values = values.iter().map(|v| beside(file, v, trust)).collect::<Result<_, _>>()?,
        "output" => {}
        _ => values = vec![values.join(",")],
    }
    Ok(values.iter().map(|v| OsString::from(format!("--{key}={v}"))).collect())
}

fn scalar(value: &toml::Value) -> Result<String, String> {
    match value {
        toml::Value::String(s) => Ok(s.clone()),
        toml::Value::Integer(i) => Ok(i.to_string()),
        toml::Value::Float(x) => Ok(x.to_string()),
        toml::Value::Boolean(b) => Ok(b.to_string()),
        other => Err(format!("a {} is not a valid value", other.type_str())),
    }
}

/// Resolves a path relative to the settings file.
fn beside(file: &Path, value: &str, trust: Trust) -> Result<String, String> {
    let folder = file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let path: PathBuf = file.parent().unwrap_or(Path::new("")).join(value);
    if trust == (Trust::Scene { anywhere: false }) {
        let real = |path: &Path| {
            path.canonicalize().map_err(|e| format!("'{}' cannot be read: {e}", error::short(value)))
        };
        if !real(&path)?.starts_with(real(folder)?) {
            return Err(format!(
                "'{}' lies outside the scene's folder; allow it with --allow-path",
                error::short(value)
            ));
        }
    }
    path.into_os_string().into_string().map_err(|_| "the folder's name is not Unicode".into())
}

/// Describes an error in the TOML, with its line number.
fn toml_line(text: &str, error: &toml::de::Error) -> String {
    let line = error.span().map(|s| 1 + text[..s.start.min(text.len())].matches('\n').count());
    match line {
        Some(line) => format!("line {line}: {}", error.message()),
        None => error.message().to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const SCENE: Trust = Trust::Scene { anywhere: false };

    fn apply(trust: Trust, text: &str) -> Result<RenderOptions, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.toml");
        fs::write(&path, text).unwrap();
        fs::write(folder.path().join("sky.hdr"), "").unwrap();
        let mut options = RenderOptions::default();
        apply_file(&mut options, &path, trust, "render").map(|_| options).map_err(|e| e.to_string())
    }

    #[test]
    fn every_option_is_either_the_scenes_or_the_users_to_set() {
        for name in options::names() {
            let lists = [&SIDECAR_KEYS[..], &USER_KEYS[..]];
            let count = lists.iter().filter(|list| list.contains(&name.as_str())).count();
            assert_eq!(count, 1, "--{name} has to be on one of the two lists");
        }
        assert_eq!(SIDECAR_KEYS.len() + USER_KEYS.len(), options::names().len());
    }

    #[test]
    fn a_sidecar_sets_nothing_that_is_the_users() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.toml");
        let text = "spp = 3\naov = 'depth'\noutput = ['a.exr']\nlog = 'b'\nyes = true\nallow-path = true\nthreads = 0\nsppp = 1\n";
        fs::write(&path, text).unwrap();
        for anywhere in [false, true] {
            let mut options = RenderOptions::default();
            let ignored = apply_file(&mut options, &path, Trust::Scene { anywhere }, "render").unwrap();
            assert_eq!(ignored.join(" "), "allow-path aov log output sppp threads yes");
            assert!(options.aov.is_none());
            assert!(options.output.is_none() && options.log.is_none() && options.allow_path.is_none());
            assert!(options.effects.yes.is_none() && options.threads.is_none());
            assert_eq!(options.spp, Some(3));
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_out_of_the_folder_are_seen_through() {
        let (folder, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        fs::write(other.path().join("sky.hdr"), "").unwrap();
        std::os::unix::fs::symlink(other.path().join("sky.hdr"), folder.path().join("in.hdr")).unwrap();
        let path = folder.path().join("s.toml");
        fs::write(&path, "env = 'in.hdr'").unwrap();
        let apply = |trust| apply_file(&mut RenderOptions::default(), &path, trust, "render");
        assert!(apply(SCENE).is_err_and(|e| e.to_string().contains("--allow-path")));
        assert!(apply(Trust::Scene { anywhere: true }).is_ok() && apply(Trust::User).is_ok());
    }

    #[test]
    fn every_kind_of_value_is_an_option() {
        let text = "spp = 9\nsize = '8x4'\nexposure = -1.5\nhalf = true\ncrop = [0, 0, 2, 2]\naov = ['albedo', 'depth']\noutput = ['a.exr', 'b.png']\n";
        let options = apply(Trust::User, text).unwrap();
        assert_eq!(options.spp, Some(9));
        assert_eq!(options.exposure, Some(-1.5));
        assert_eq!(options.half, Some(true));
        assert_eq!(options.crop.unwrap().0.x1, 2);
        assert_eq!(options.aov.unwrap().len(), 2);
        assert_eq!(options.output.unwrap().len(), 2);
    }

    #[test]
    fn complaints_name_file_and_key() {
        for (text, key) in [
            ("sppp = 3", "key 'sppp': unknown"),
            ("spp = 0", "key 'spp': "),
            ("spp = { a = 1 }", "key 'spp': a table"),
            ("seed = -1", "key 'seed': "),
            ("settings = 'b.toml'", "key 'settings': "),
            ("spp = ", "line 1"),
        ] {
            let said = apply(Trust::User, text).unwrap_err();
            assert!(said.contains("s.toml: ") && said.contains(key), "{text}: {said}");
        }
    }

    #[test]
    fn a_sidecar_stays_in_its_folder() {
        assert!(apply(SCENE, "env = 'sky.hdr'").unwrap().env.unwrap().ends_with("sky.hdr"));
        for text in ["env = '/etc/hosts'", "env = '../sky.hdr'", "env = 'missing.hdr'"] {
            assert!(apply(SCENE, text).is_err(), "{text}");
        }
        assert!(apply(Trust::User, "output = '../a.exr'\nallow-path = true").is_ok());
    }

    #[test]
    fn a_later_environment_replaces_the_other_kind() {
        let mut options = RenderOptions::default();
        options.apply(&["--env=sky.hdr".into()]).unwrap();
        options.apply(&["--env-color=1,1,1".into()]).unwrap();
        assert!(options.env.is_none() && options.env_color.is_some());
        options.apply(&["--half".into()]).unwrap();
        assert_eq!((options.half, options.env_color.is_some()), (Some(true), true));
    }
}
