//! Sources of bytes: data URIs and files.
//!
//! A scene may read only files in its own folder and below: absolute paths, `..` that leaves the folder and symbolic
//! links out of it are errors unless the user allows them. No more bytes are read than the scene declares.
use super::options::Options;
use crate::{SceneError, error::quoted};
use base64::{
    Engine,
    alphabet::{STANDARD, URL_SAFE},
    engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig},
};
use std::{
    borrow::Cow,
    ffi::OsString,
    fs::File,
    io::Read,
    path::{Component, Path, PathBuf},
};

/// Maximum size in bytes of an image file.
pub(super) const MAX_FILE: u64 = 1 << 31;

const LENIENT: GeneralPurposeConfig =
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);

/// The bytes that `uri` denotes, at most `limit` of them (a file may be longer). `place` names the referring object.
pub(super) fn bytes(
    file: &Path,
    uri: &str,
    limit: u64,
    place: &str,
    options: &Options,
) -> Result<Vec<u8>, SceneError> {
    if let Some(data) = uri.strip_prefix("data:") {
        return data_uri(data).map_err(|what| SceneError::Malformed {
            file: file.to_owned(),
            what: format!("{place}: its data URI {what}"),
        });
    }
    let refused = |what: &str| SceneError::Path {
        file: file.to_owned(),
        place: place.to_owned(),
        uri: uri.to_owned(),
        what: what.to_owned(),
    };
    let path = relative(uri, options.allow_path).map_err(refused)?;
    // The label of an image without a name contains its URI.
    let named = format!(" '{}'", quoted(uri));
    let what = if place.ends_with(&named) { place.to_owned() } else { format!("{place}{named}") };
    let io = |source| SceneError::Io { file: file.to_owned(), what: what.clone(), source };
    let folder = folder(file);
    let path = nearest(folder, &path).unwrap_or_else(|| folder.join(path));
    if !options.allow_path {
        let inside = path.canonicalize().map_err(io)?.starts_with(folder.canonicalize().map_err(io)?);
        if !inside {
            return Err(refused(
                "it is a symbolic link out of the scene's folder; allow it with --allow-path",
            ));
        }
    }
    if !path.metadata().map_err(io)?.is_file() {
        return Err(refused("it is not a file"));
    }
    let mut bytes = Vec::new();
    File::open(&path).and_then(|f| f.take(limit).read_to_end(&mut bytes)).map_err(io)?;
    Ok(bytes)
}

fn folder(file: &Path) -> &Path {
    file.parent().filter(|p| *p != Path::new("")).unwrap_or(Path::new("."))
}

/// Path of the file that a URI names, whether it exists or not; None for data URIs and invalid paths.
pub(super) fn path(file: &Path, uri: &str) -> Option<PathBuf> {
    let relative = relative(uri, true).ok().filter(|_| !uri.starts_with("data:"))?;
    Some(nearest(folder(file), &relative).unwrap_or_else(|| folder(file).join(relative)))
}

/// The existing path below `folder` that matches `relative`: exactly, or else with `/` for `\`, or else ignoring case.
/// None if there is none. Scenes exported on systems that do not distinguish these may spell names differently.
fn nearest(folder: &Path, relative: &Path) -> Option<PathBuf> {
    let exact = folder.join(relative);
    if exact.exists() {
        return Some(exact);
    }
    let slashed = PathBuf::from(relative.to_str()?.replace('\\', "/"));
    let is_below = slashed.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    if slashed != relative && !is_below {
        return None;
    }
    let mut found = if slashed.is_absolute() { PathBuf::new() } else { folder.to_path_buf() };
    for component in slashed.components() {
        let next = found.join(component);
        found = if next.exists() {
            next
        } else {
            found.join(ignoring_case(&found, component.as_os_str().to_str()?)?)
        };
    }
    Some(found)
}

/// The first entry of a folder, in order of names, that equals `name` except for case.
fn ignoring_case(folder: &Path, name: &str) -> Option<OsString> {
    let wanted = name.to_lowercase();
    let entries = folder.read_dir().ok()?.filter_map(|entry| Some(entry.ok()?.file_name()));
    entries.filter(|entry| entry.to_str().is_some_and(|entry| entry.to_lowercase() == wanted)).min()
}

/// The actual name of the file that a URI names, if it is spelled differently.
pub(super) fn other_name(file: &Path, uri: &str) -> Option<String> {
    let relative = relative(uri, true).ok().filter(|_| !uri.starts_with("data:"))?;
    let found = nearest(folder(file), &relative)?;
    let written = folder(file).join(&relative);
    (found != written).then(|| found.strip_prefix(folder(file)).unwrap_or(&found).display().to_string())
}

/// Whether a URI names a file that does not exist.
pub(super) fn is_missing(file: &Path, uri: &str) -> bool {
    path(file, uri).is_some_and(|path| !path.exists())
}

/// The path that a URI names, percent-decoded, or the reason why it is not allowed.
fn relative(uri: &str, allow_path: bool) -> Result<PathBuf, &'static str> {
    let scheme = uri.split_once(':').map(|(scheme, _)| scheme);
    let is_scheme =
        |s: &str| s.len() > 1 && s.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c));
    if scheme.is_some_and(is_scheme) {
        return Err("only files and data URIs can be read");
    }
    let decoded: Cow<str> =
        percent_encoding::percent_decode_str(uri).decode_utf8().map_err(|_| "it is not UTF-8")?;
    if decoded.contains('\0') {
        return Err("it contains a zero byte");
    }
    let path = PathBuf::from(&*decoded);
    if !allow_path {
        let mut depth = 0_i64;
        for component in path.components() {
            depth += match component {
                Component::Normal(_) => 1,
                Component::CurDir => 0,
                Component::ParentDir => -1,
                Component::RootDir | Component::Prefix(_) => i64::MIN / 2,
            };
            if depth < 0 {
                return Err("it lies outside the scene's folder; allow it with --allow-path");
            }
        }
    }
    Ok(path)
}

/// Decodes a data URI from the part after `data:`.
fn data_uri(data: &str) -> Result<Vec<u8>, String> {
    let (header, content) = data.split_once(',').ok_or("has no comma")?;
    let content = percent_encoding::percent_decode_str(content);
    if !header.ends_with(";base64") {
        return Ok(content.collect());
    }
    let content: Cow<[u8]> = content.into();
    let engine = |alphabet| GeneralPurpose::new(alphabet, LENIENT);
    engine(&STANDARD)
        .decode(&content)
        .or_else(|e| engine(&URL_SAFE).decode(&content).map_err(|_| e))
        .map_err(|e| format!("is not valid base64: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_uris() {
        assert_eq!(data_uri(";base64,AQID").unwrap(), [1, 2, 3]);
        assert_eq!(data_uri("application/octet-stream;base64,AQI").unwrap(), [1, 2]);
        assert_eq!(data_uri("application/octet-stream;base64,AQI=").unwrap(), [1, 2]);
        assert_eq!(data_uri("text/plain,a%20b").unwrap(), b"a b");
        assert!(data_uri(";base64,A*ID").is_err());
        assert!(data_uri(";base64").is_err());
    }

    #[test]
    fn only_paths_below_the_folder() {
        for good in ["a.bin", "a/b.bin", "./a.bin", "a/../b.bin", "with%20space.bin", "sub:dir/x"] {
            let plain = !good.contains(':');
            assert_eq!(relative(good, false).is_ok(), plain, "{good}");
        }
        let bad = ["../a.bin", "a/../../b.bin", "/etc/passwd", "%2e%2e/a.bin", "%2Fetc%2Fpasswd", "a%00b"];
        for bad in bad {
            assert!(relative(bad, false).is_err(), "{bad}");
        }
        for never in ["http://example.org/a.bin", "file:///etc/passwd", "a%ffb"] {
            assert!(relative(never, true).is_err(), "{never}");
        }
        assert!(relative("../a.bin", true).is_ok() && relative("/a.bin", true).is_ok());
        assert_eq!(relative("with%20space.bin", false).unwrap(), PathBuf::from("with space.bin"));
    }
}
