//! `dapple info`: what is in a scene, as text or JSON.

use crate::args::InfoArgs;
use crate::error::Failure;
use crate::load::Source;
use crate::report;
use serde_json::{Value, json};
use std::path::Path;

/// Prints what is in the scene.
pub fn run(arguments: &InfoArgs) -> Result<(), Failure> {
    let source = Source::new(Some(&arguments.scene));
    let told = match source.path() {
        Some(path) => file(path, arguments.allow_path)?,
        None => builtin(&source)?,
    };
    if arguments.json {
        report::json(&told);
    } else {
        text(&told, 0);
    }
    Ok(())
}

#[cfg(feature = "gltf")]
fn file(path: &Path, allow_path: bool) -> Result<Value, Failure> {
    use dapple_integrator::scene::gltf;
    let info = gltf::info(path, &gltf::Options { allow_path, ..gltf::Options::default() })?;
    serde_json::to_value(info).map_err(|e| Failure::Arguments(format!("{}: {e}", path.display())))
}

#[cfg(not(feature = "gltf"))]
fn file(path: &Path, _: bool) -> Result<Value, Failure> {
    let said = format!("{}: this dapple was built without the glTF reader (feature gltf)", path.display());
    Err(Failure::Arguments(said))
}

/// Built-in scenes have no file to look into: what they hold once built.
fn builtin(source: &Source) -> Result<Value, Failure> {
    let scene = source.read(0.0, false)?.build()?;
    let names = |all: Vec<&str>| all.into_iter().map(String::from).collect::<Vec<_>>();
    Ok(json!({
        "name": scene.name,
        "triangles": scene.survey.triangles,
        "objects": names(scene.objects.iter().map(|o| o.name.as_str()).collect()),
        "materials": names(scene.materials.iter().map(|m| m.name.as_str()).collect()),
        "lights": scene.lights.len(),
        "cameras": names(scene.cameras.iter().map(|c| c.name.as_str()).collect()),
        "memory_bytes": scene.memory_bytes(),
    }))
}

/// Key and value per line; what is nested is indented.
fn text(value: &Value, depth: usize) {
    let Value::Object(entries) = value else { return report::result(&plain(value)) };
    let indent = "  ".repeat(depth);
    for (key, value) in entries {
        let key = key.replace('_', " ");
        match value {
            Value::Object(inner) if !inner.is_empty() => {
                report::result(&format!("{indent}{key}:"));
                text(value, depth + 1);
            }
            Value::Array(items) if items.iter().any(Value::is_object) => {
                report::result(&format!("{indent}{key}:"));
                items.iter().for_each(|item| report::result(&format!("{indent}  - {}", plain(item))));
            }
            _ => report::result(&format!("{indent}{key}: {}", plain(value))),
        }
    }
}

/// A value in one line.
fn plain(value: &Value) -> String {
    match value {
        Value::Null => "none".into(),
        Value::String(s) => s.clone(),
        Value::Array(items) if items.is_empty() => "none".into(),
        Value::Array(items) => items.iter().map(plain).collect::<Vec<_>>().join(", "),
        Value::Object(entries) => {
            let parts = entries.iter().map(|(key, v)| format!("{} {}", key.replace('_', " "), plain(v)));
            parts.collect::<Vec<_>>().join(", ")
        }
        other => other.to_string(),
    }
}
