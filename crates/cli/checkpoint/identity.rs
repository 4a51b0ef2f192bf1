//! What a checkpoint belongs to: program, settings, and the files of the scene with their hashes.

use super::file::hex;
use crate::error;
use crate::options::{NO_ENVIRONMENT, RenderOptions};
use dapple_integrator::scene::Scene;
use dapple_integrator::{BITS, Settings};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Keys of the description.
const PROGRAM: &str = "program";
const BITS_KEY: &str = "bits";
const SCENE: &str = "scene";
const SETTINGS: &str = "settings";
const FILES: &str = "files";

/// Key of the digest of the sample allocation, for parts of adaptive renders.
pub const PILOT: &str = "pilot";

/// Most differences that a message names.
const NAMED: usize = 4;

/// Describes a render: `lines` are the lines of a settings file that reproduces it.
///
/// # Errors
/// If a file of the scene cannot be read again.
pub fn describe(
    scene: &Scene,
    settings: &Settings,
    options: &RenderOptions,
    lines: &str,
) -> io::Result<BTreeMap<String, String>> {
    let layers: Vec<String> = settings.aovs.iter().map(ToString::to_string).collect();
    let mut all: Vec<String> = lines.lines().map(str::to_string).collect();
    all.push(format!("aov = \"{}\"", layers.join(",")));
    all.push(format!("plan = \"{}\"", if settings.general { "general" } else { "smallest" }));
    let environment = options.env.as_deref().filter(|path| path.as_os_str() != NO_ENVIRONMENT);
    let files = scene.files.iter().map(|path| path.as_path()).chain(environment);
    let hashes: Vec<String> =
        files.map(|path| Ok(format!("{} {}", hash(path)?, name(path)))).collect::<io::Result<_>>()?;
    let text = [
        (PROGRAM, format!("dapple {}", env!("CARGO_PKG_VERSION"))),
        (BITS_KEY, BITS.to_string()),
        (SCENE, scene.name.to_string()),
        (SETTINGS, all.join("\n")),
        (FILES, hashes.join("\n")),
    ];
    Ok(text.into_iter().map(|(key, value)| (key.to_string(), value)).collect())
}

/// Returns what differs between the render of a checkpoint and the present one; none if they are the same render. The
/// version of the program may differ, as long as it computes the same bits.
pub fn difference(then: &BTreeMap<String, String>, now: &BTreeMap<String, String>) -> Option<String> {
    let of = |map: &BTreeMap<String, String>, key: &str| map.get(key).cloned().unwrap_or_default();
    let both = |key: &str| (of(then, key), of(now, key));
    let (bits, current) = both(BITS_KEY);
    if bits != current {
        return Some(format!(
            "it was written by {} with version {} of the samples, and this program computes version {current}",
            error::short(&of(then, PROGRAM)),
            error::short(&bits)
        ));
    }
    let (scene, current) = both(SCENE);
    if scene != current {
        let [scene, current] = [scene, current].map(|name| error::short(&name));
        return Some(format!("it belongs to the scene '{scene}', not '{current}'"));
    }
    let (then, now, pilots) = (both(SETTINGS), both(FILES), both(PILOT));
    let mut found = lines(&then.0, &then.1).map(|(was, is)| match (was, is) {
        (Some(was), Some(is)) => format!("{} instead of {}", error::short(is), error::short(was)),
        (Some(was), None) => format!("without {}", error::short(was)),
        (None, is) => error::short(is.unwrap_or_default()),
    });
    let settings: Vec<String> = found.by_ref().collect();
    if !settings.is_empty() {
        return Some(format!("it belongs to other settings: now {}", listed(&settings)));
    }
    let changed = lines(&now.0, &now.1).map(|(was, is)| {
        let name = was.or(is).and_then(|line| line.split_once(' ')).map_or("", |(_, name)| name);
        format!("'{}'", error::short(name))
    });
    let mut changed: Vec<String> = changed.collect();
    changed.dedup();
    if !changed.is_empty() {
        return Some(format!("files of the scene have changed: {}", listed(&changed)));
    }
    let (was, is) = pilots;
    (was != is).then(|| "its pilot samples gave another sample allocation".to_string())
}

/// Pairs the lines that differ, by key: what precedes ` = `, or the position.
fn lines<'a>(then: &'a str, now: &'a str) -> impl Iterator<Item = (Option<&'a str>, Option<&'a str>)> {
    let keyed = |text: &'a str| {
        text.lines().enumerate().map(|(i, line)| {
            let key = line.split_once(" = ").map_or_else(|| format!("{i:09}"), |(key, _)| key.to_string());
            (key, line)
        })
    };
    let mut all: BTreeMap<String, (Option<&str>, Option<&str>)> = BTreeMap::new();
    keyed(then).for_each(|(key, line)| all.entry(key).or_default().0 = Some(line));
    keyed(now).for_each(|(key, line)| all.entry(key).or_default().1 = Some(line));
    all.into_values().filter(|(was, is)| was != is)
}

fn listed(all: &[String]) -> String {
    let more = if all.len() > NAMED { format!(" and {} more", all.len() - NAMED) } else { String::new() };
    format!("{}{more}", all[..all.len().min(NAMED)].join(", "))
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// SHA-256 of a file.
fn hash(path: &Path) -> io::Result<String> {
    let mut file = match File::open(path) {
        // A file that the scene names and that does not exist: the texture is left out.
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok("missing".into()),
        file => file?,
    };
    let (mut hash, mut buffer) = (Sha256::new(), vec![0; 1 << 16]);
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(hex(&hash.finalize())),
            n => hash.update(&buffer[..n]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(settings: &str, files: &str, bits: &str) -> BTreeMap<String, String> {
        let all =
            [(SETTINGS, settings), (FILES, files), (BITS_KEY, bits), (SCENE, "a"), (PROGRAM, "dapple 0")];
        all.into_iter().map(|(key, value)| (key.to_string(), value.to_string())).collect()
    }

    #[test]
    fn differences_are_named() {
        let then = of("seed = 1\nsize = \"8x8\"", "aa a.gltf\nbb b.png", "3");
        assert_eq!(difference(&then, &then), None);
        let said = |now| difference(&then, &now).unwrap();
        assert_eq!(
            said(of("seed = 2\nsize = \"8x8\"", "aa a.gltf\nbb b.png", "3")),
            "it belongs to other settings: now seed = 2 instead of seed = 1"
        );
        assert_eq!(
            said(of("size = \"8x8\"\nclamp = 3", "", "3")),
            "it belongs to other settings: now clamp = 3, without seed = 1"
        );
        assert_eq!(
            said(of("seed = 1\nsize = \"8x8\"", "aa a.gltf\ncc b.png", "3")),
            "files of the scene have changed: 'b.png'"
        );
        assert!(said(of("", "", "4")).contains("version 3 of the samples"));
        let other = BTreeMap::from_iter(
            then.clone().into_iter().map(|(k, v)| if k == SCENE { (k, "b".into()) } else { (k, v) }),
        );
        assert_eq!(said(other), "it belongs to the scene 'a', not 'b'");
    }

    #[test]
    fn files_are_told_apart_by_content() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("a"), "abc").unwrap();
        assert_eq!(
            hash(&at("a")).unwrap(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
        assert_eq!(hash(&at("none")).unwrap(), "missing");
    }
}
