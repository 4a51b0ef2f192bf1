//! Parsing of a file's bytes: splits a .glb, checks version and required extensions, and adapts the JSON to the crate
//! `gltf`.
use super::{extensions, options::Options, sanitize};
use crate::{SceneError, Warning, error::quoted};
use gltf::json;
use serde_json::Value;
use std::{borrow::Cow, collections::BTreeSet, path::Path};

const MAGIC: &[u8; 4] = b"glTF";
const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
const BIN_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");

/// Maximum number of extensions that warnings name individually.
pub(super) const MAX_NAMED: usize = 40;

/// A parsed file.
pub(super) struct Content {
    /// The JSON as typed by the crate `gltf`. Its indices are unchecked.
    pub root: json::Root,
    /// The same JSON as plain values (f64 numbers, unknown extensions).
    pub value: Value,
    /// The binary chunk of a .glb.
    pub blob: Option<Vec<u8>>,
    /// Size of the file in bytes.
    pub length: u64,
}

/// Treatment of extensions that are required but not supported: an error or a warning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Required {
    Refused,
    Warned,
}

/// Parses `bytes`, the content of `file`. Adds warnings about unsupported features.
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

/// Upper bound of the memory in bytes that JSON takes once it is parsed both by the crate `gltf` and to plain values:
/// one value for each comma, colon and opening bracket, plus the text itself.
fn json_bytes(text: &[u8]) -> u64 {
    const VALUE: u64 = 120;
    let values = text.iter().filter(|c| matches!(c, b',' | b':' | b'[' | b'{')).count() as u64;
    values.saturating_mul(VALUE).saturating_add(3 * text.len() as u64)
}

/// The JSON and the binary chunk; a file that is not a .glb is all JSON.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    if !bytes.starts_with(MAGIC) {
        return Ok((bytes, None));
    }
    let word = |at: usize| -> Option<u32> {
        Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
    };
    let truncated = || "the file is truncated within a header; copy or export it again".to_owned();
    let (version, length) = (word(4).ok_or_else(truncated)?, word(8).ok_or_else(truncated)? as usize);
    if version != 2 {
        return Err(format!("it is a version {version} .glb; only version 2 is supported"));
    }
    if length > bytes.len() {
        let held = bytes.len();
        return Err(format!(
            "the file is truncated to {held} of its {length} bytes; copy or export it again"
        ));
    }
    let (mut text, mut blob, mut at) = (None, None, 12);
    while at < length {
        let (size, kind) = (word(at).ok_or_else(truncated)? as usize, word(at + 4).ok_or_else(truncated)?);
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
    let asset = value.get("asset").ok_or("there is no 'asset' entry; is this a glTF file?")?;
    let newest = asset.get("minVersion").or(asset.get("version")).and_then(Value::as_str);
    match newest {
        Some(v) if v == "2.0" || (asset.get("minVersion").is_none() && v.starts_with("2.")) => Ok(()),
        Some(v) => Err(format!("it is glTF {}; only glTF 2.0 is supported", quoted(v))),
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
                "{extension} is required but not supported: dapple cannot render this file"
            )));
        }
    }
    let (more_idle, idle) = (idle.len().saturating_sub(MAX_NAMED), idle.into_iter().take(MAX_NAMED));
    for name in idle {
        let name = quoted(name);
        warnings.push(Warning(format!("{name} is declared as required, but nothing in the file uses it")));
    }
    if more_idle > 0 {
        let text = format!("{more_idle} more extensions are declared as required, but nothing uses them");
        warnings.push(Warning(text));
    }
    Ok(())
}

/// The strings of a top-level array.
pub(super) fn names<'a>(value: &'a Value, key: &str) -> Vec<&'a str> {
    let list = value.get(key).and_then(Value::as_array).into_iter().flatten();
    list.filter_map(Value::as_str).collect()
}

/// Removes animation channels without target node (those of KHR_animation_pointer, and those that the specification
/// says to ignore), which the crate `gltf` 1.4 cannot parse. Returns their number.
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
