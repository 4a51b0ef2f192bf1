//! Settings in TOML: the sidecar `SCENE-STEM.toml` beside a scene, and `--settings FILE`.
//!
//! Keys are the options' long names, values what the option takes (a list stands for a comma-separated value).
//! `env` is relative to the file's own folder, `output` to the current one. A sidecar comes with a scene that may
//! come from anywhere, so it cannot do what the scene itself may not: it reads and writes no file outside the
//! scene's folder and the current one, and cannot grant `allow-path`.

use crate::error::Failure;
use crate::options::{self, RenderOptions};
use clap::ArgMatches;
use std::ffi::OsString;
use std::path::{Component, Path, PathBuf};

/// Who wrote the file.
#[derive(Clone, Copy, PartialEq)]
enum Trust {
    Scene,
    User,
}

/// All layers: the sidecar of `scene`, then `--settings`, then what was typed.
pub fn layered(scene: Option<&Path>, typed: &ArgMatches) -> Result<RenderOptions, Failure> {
    let mut command_line = RenderOptions::default();
    command_line.lay_matches(typed)?;
    let mut options = RenderOptions::default();
    if let Some(sidecar) = scene.map(|s| s.with_extension("toml")).filter(|p| p.is_file()) {
        let trust = if RenderOptions::is(command_line.allow_path) { Trust::User } else { Trust::Scene };
        lay_file(&mut options, &sidecar, trust)?;
    }
    if let Some(path) = &command_line.settings {
        lay_file(&mut options, path, Trust::User)?;
    }
    options.lay_matches(typed)?;
    Ok(options)
}

fn lay_file(options: &mut RenderOptions, path: &Path, trust: Trust) -> Result<(), Failure> {
    let broken = |reason: String| Failure::SettingsFile { path: path.into(), reason };
    let text = std::fs::read_to_string(path).map_err(|e| broken(e.to_string()))?;
    let table: toml::Table = text.parse().map_err(|e: toml::de::Error| broken(toml_line(&text, &e)))?;
    let mut arguments = Vec::new();
    for (key, value) in &table {
        let wrong = |reason: String| Failure::SettingsKey { path: path.into(), key: key.clone(), reason };
        let given = argument(key, value, path, trust).map_err(wrong)?;
        // Alone first, so that the complaint names this key.
        RenderOptions::default().lay(&given).map_err(|e| wrong(e.to_string()))?;
        arguments.extend(given);
    }
    options.lay(&arguments).map_err(|e| broken(e.to_string()))
}

/// A key and its value as they would be typed.
fn argument(key: &str, value: &toml::Value, file: &Path, trust: Trust) -> Result<Vec<OsString>, String> {
    if !options::names().iter().any(|name| name == key) {
        return Err("unknown; the keys are the options of dapple render, without the leading dashes".into());
    }
    if key == "settings" || (key == "allow-path" && trust == Trust::Scene) {
        return Err("only the command line can say this".into());
    }
    let mut values: Vec<String> = match value {
        toml::Value::Array(items) => items.iter().map(scalar).collect::<Result<_, _>>()?,
        single => vec![scalar(single)?],
    };
    match key {
        "env" => values = values.iter().map(|v| beside(file, v, trust)).collect::<Result<_, _>>()?,
        "output" | "log" if trust == Trust::Scene => values.iter().try_for_each(|v| stays_below(v))?,
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
        other => Err(format!("a {} is no value for it", other.type_str())),
    }
}

/// A path as seen from the settings file.
fn beside(file: &Path, value: &str, trust: Trust) -> Result<String, String> {
    if trust == Trust::Scene {
        stays_below(value)?;
    }
    let path: PathBuf = file.parent().unwrap_or(Path::new("")).join(value);
    path.into_os_string().into_string().map_err(|_| "the folder's name is not Unicode".into())
}

fn stays_below(value: &str) -> Result<(), String> {
    if Path::new(value).components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir)) {
        Ok(())
    } else {
        Err(format!("'{value}' lies outside the folder; allow it with --allow-path"))
    }
}

/// What is wrong with the TOML, with its line.
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

    fn lay(trust: Trust, text: &str) -> Result<RenderOptions, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.toml");
        fs::write(&path, text).unwrap();
        let mut options = RenderOptions::default();
        lay_file(&mut options, &path, trust).map(|()| options).map_err(|e| e.to_string())
    }

    #[test]
    fn every_kind_of_value_is_an_option() {
        let text = "spp = 9\nsize = '8x4'\nexposure = -1.5\nhalf = true\ncrop = [0, 0, 2, 2]\naov = ['albedo', 'depth']\noutput = ['a.exr', 'b.png']\n";
        let options = lay(Trust::User, text).unwrap();
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
            let said = lay(Trust::User, text).unwrap_err();
            assert!(said.contains("s.toml: ") && said.contains(key), "{text}: {said}");
        }
    }

    #[test]
    fn a_sidecar_stays_in_its_folder() {
        assert!(lay(Trust::Scene, "env = 'sky.hdr'").unwrap().env.unwrap().ends_with("sky.hdr"));
        for text in ["env = '/sky.hdr'", "env = '../sky.hdr'", "output = '../a.exr'", "allow-path = true"] {
            assert!(lay(Trust::Scene, text).is_err(), "{text}");
        }
        assert!(lay(Trust::User, "output = '../a.exr'\nallow-path = true").is_ok());
    }

    #[test]
    fn a_later_environment_replaces_the_other_kind() {
        let mut options = RenderOptions::default();
        options.lay(&["--env=sky.hdr".into()]).unwrap();
        options.lay(&["--env-color=1,1,1".into()]).unwrap();
        assert!(options.env.is_none() && options.env_color.is_some());
        options.lay(&["--half".into()]).unwrap();
        assert_eq!((options.half, options.env_color.is_some()), (Some(true), true));
    }
}
