//! From bytes to JSON: splits a .glb, checks version and required extensions, and makes the JSON fit the crate
//! `gltf`.
use super::{extensions, options::Options, sanitize};
use crate::{SceneError, Warning, error::quoted};
use gltf::json;
use serde_json::Value;
use std::{borrow::Cow, collections::BTreeSet, path::Path};

const MAGIC: &[u8; 4] = b"glTF";
const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
const BIN_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");

/// Most extensions that are named one by one.
pub(super) const SAID: usize = 40;

/// A parsed file.
pub(super) struct Content {
    /// Typed, by the crate `gltf`. Indices in it are unchecked.
    pub root: json::Root,
    /// The same as plain JSON (f64 numbers, unknown extensions).
    pub value: Value,
    /// The binary chunk of a .glb.
    pub blob: Option<Vec<u8>>,
    /// Bytes of the file.
    pub length: u64,
}

/// What to do about an extension that is required but not supported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Required {
    Refused,
    Warned,
}

/// Parses `bytes`, the content of `file`. Warnings name what the file asks for and will not get.
pub(super) fn parse(
    file: &Path,
    bytes: &[u8],
    required: Required,
    options: &Options,
    warnings: &mut Vec<Warning>,
) -> Result<Content, SceneError> {
    let malformed = |what: String| SceneError::Malformed { file: file.to_owned(), what };
    let (text, blob) = split(bytes).map_err(malformed)?;
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let memory = |overrun| SceneError::Memory { file: file.to_owned(), place: "the JSON".into(), overrun };
    let beside = blob.map_or(0, |blob| 2 * blob.len() as u64);
    options.memory.admit(json_bytes(text).saturating_add(beside), None).map_err(memory)?;
    let mut value: Value = serde_json::from_slice(text).map_err(|e| malformed(format!("its JSON: {e}")))?;
    version(&value).map_err(malformed)?;
    check_extensions(file, &value, required, warnings)?;
    let is_pointer = |name: &&str| *name == extensions::POINTER;
    if extensions::used(&value).iter().any(is_pointer)
        && !names(&value, "extensionsRequired").iter().any(is_pointer)
    {
        warnings.push(Warning(extensions::left_out(extensions::POINTER, &value)));
    }
    let pointers = strip_pointers(&mut value);
    let patched = match sanitize::sanitize(&mut value, warnings) || pointers > 0 {
        false => Cow::Borrowed(text),
        true => Cow::Owned(value.to_string().into_bytes()),
    };
    let root = gltf::Gltf::from_slice_without_validation(&patched).map_err(|e| match e {
        gltf::Error::Deserialize(e) => malformed(format!("its JSON: {e}")),
        e => malformed(e.to_string()),
    })?;
    Ok(Content {
        root: root.document.into_json(),
        value,
        blob: blob.map(<[u8]>::to_vec),
        length: bytes.len() as u64,
    })
}

/// Bytes that JSON takes once it is parsed, twice: as the crate `gltf` types it and as plain values. At most what a value
/// for each comma, colon and opening bracket takes, and the text itself.
fn json_bytes(text: &[u8]) -> u64 {
    const VALUE: u64 = 120;
    let values = text.iter().filter(|c| matches!(c, b',' | b':' | b'[' | b'{')).count() as u64;
    values.saturating_mul(VALUE).saturating_add(3 * text.len() as u64)
}

/// JSON and binary chunk; a file that is no .glb is all JSON.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    if !bytes.starts_with(MAGIC) {
        return Ok((bytes, None));
    }
    let word = |at: usize| -> Option<u32> {
        Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
    };
    let cut_short = || "the file is cut short within its header".to_owned();
    let (version, length) = (word(4).ok_or_else(cut_short)?, word(8).ok_or_else(cut_short)? as usize);
    if version != 2 {
        return Err(format!("it is a version {version} .glb; only version 2 can be read"));
    }
    if length > bytes.len() {
        return Err(format!("the file is cut short: it has {} of its {length} bytes", bytes.len()));
    }
    let (mut text, mut blob, mut at) = (None, None, 12);
    while at < length {
        let (size, kind) = (word(at).ok_or_else(cut_short)? as usize, word(at + 4).ok_or_else(cut_short)?);
        let chunk = at
            .checked_add(8 + size)
            .filter(|&end| end <= length)
            .map(|end| &bytes[at + 8..end])
            .ok_or_else(|| format!("a chunk of {size} bytes at byte {at} ends outside the file"))?;
        match (kind, text) {
            (JSON_CHUNK, None) => text = Some(chunk),
            (BIN_CHUNK, Some(_)) if blob.is_none() => blob = Some(chunk),
            _ => {}
        }
        at += 8 + size;
    }
    Ok((text.ok_or("the .glb has no JSON chunk")?, blob))
}

fn version(value: &Value) -> Result<(), String> {
    let asset = value.get("asset").ok_or("there is no 'asset' entry; is it glTF?")?;
    let newest = asset.get("minVersion").or(asset.get("version")).and_then(Value::as_str);
    match newest {
        Some(v) if v == "2.0" || (asset.get("minVersion").is_none() && v.starts_with("2.")) => Ok(()),
        Some(v) => Err(format!("it is glTF {}; only glTF 2.0 can be read", quoted(v))),
        None => Err("'asset' has no version".into()),
    }
}

fn check_extensions(
    file: &Path,
    value: &Value,
    required: Required,
    warnings: &mut Vec<Warning>,
) -> Result<(), SceneError> {
    let used = extensions::used(value);
    let unsupported = |name: &&str| !extensions::is_supported(name);
    let required_names: BTreeSet<&str> =
        names(value, "extensionsRequired").into_iter().filter(unsupported).collect();
    let (missing, idle): (Vec<&str>, Vec<&str>) =
        required_names.iter().partition(|name| used.contains(*name));
    let extension = missing.join(" and ");
    match required {
        _ if missing.is_empty() => {}
        Required::Refused => return Err(SceneError::Extension { file: file.to_owned(), extension }),
        Required::Warned => {
            let extension = quoted(&extension);
            warnings.push(Warning(format!(
                "{extension} is required but not supported: dapple cannot render this"
            )));
        }
    }
    let (more_idle, idle) = (idle.len().saturating_sub(SAID), idle.into_iter().take(SAID));
    for name in idle {
        let name = quoted(name);
        warnings.push(Warning(format!("{name} is said to be required, but nothing in the file uses it")));
    }
    if more_idle > 0 {
        let said = format!("{more_idle} more extensions are said to be required, but nothing uses them");
        warnings.push(Warning(said));
    }
    Ok(())
}

/// The strings of a top-level array.
pub(super) fn names<'a>(value: &'a Value, key: &str) -> Vec<&'a str> {
    let list = value.get(key).and_then(Value::as_array).into_iter().flatten();
    list.filter_map(Value::as_str).collect()
}

/// Removes animation channels that target no node (KHR_animation_pointer, or to be ignored by the specification):
/// the crate `gltf` 1.4 cannot parse them. Returns how many.
fn strip_pointers(value: &mut Value) -> usize {
    let mut count = 0;
    for animation in value.get_mut("animations").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) {
            let before = channels.len();
            channels.retain(|c| {
                let target = c.get("target");
                let path = target.and_then(|t| t.get("path")).and_then(Value::as_str);
                target.is_some_and(|t| t.get("node").is_some()) && path != Some("pointer")
            });
            count += before - channels.len();
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(json: &str, blob: &[u8]) -> Vec<u8> {
        let mut body = Vec::new();
        for (kind, filler, content) in [(b"JSON", b' ', json.as_bytes()), (b"BIN\0", 0, blob)] {
            body.extend((content.len().next_multiple_of(4) as u32).to_le_bytes());
            body.extend(kind);
            body.extend(content);
            body.resize(body.len().next_multiple_of(4), filler);
        }
        [b"glTF", &2_u32.to_le_bytes()[..], &(12 + body.len() as u32).to_le_bytes(), &body].concat()
    }

    #[test]
    fn chunks_come_apart() {
        let bytes = glb("{\"a\":1}", b"1234567");
        let (text, blob) = split(&bytes).unwrap();
        assert_eq!(text, b"{\"a\":1} ");
        assert_eq!(blob.unwrap(), b"1234567\0");
        assert_eq!(split(b"{}").unwrap(), (&b"{}"[..], None));
    }

    #[test]
    fn every_truncation_is_an_error() {
        let bytes = glb("{\"asset\":{\"version\":\"2.0\"}}", &[7; 20]);
        assert!(split(&bytes).is_ok());
        for n in 4..bytes.len() {
            assert!(split(&bytes[..n]).is_err(), "{n}");
        }
    }

    #[test]
    fn chunk_lengths_are_not_believed() {
        let mut bytes = glb("{}", &[0; 8]);
        bytes[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(split(&bytes).unwrap_err().contains("ends outside"));
    }

    #[test]
    fn versions() {
        let check = |json: &str| version(&serde_json::from_str(json).unwrap());
        assert!(check(r#"{"asset":{"version":"2.0"}}"#).is_ok());
        assert!(check(r#"{"asset":{"version":"2.1"}}"#).is_ok());
        assert!(check(r#"{"asset":{"version":"1.0"}}"#).unwrap_err().contains("1.0"));
        assert!(check(r#"{"asset":{"version":"2.1","minVersion":"2.1"}}"#).is_err());
        assert!(check(r#"{}"#).is_err());
    }

    #[test]
    fn pointers_go_and_nodes_stay() {
        let mut value = serde_json::json!({"animations": [{"channels": [
            {"sampler": 0, "target": {"path": "pointer"}},
            {"sampler": 0, "target": {"node": 1, "path": "rotation"}},
            {"sampler": 0, "target": {"path": "rotation"}},
        ]}]});
        assert_eq!(strip_pointers(&mut value), 2);
        assert_eq!(value["animations"][0]["channels"].as_array().unwrap().len(), 1);
    }
}
