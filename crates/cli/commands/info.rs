//! `dapple info`: what is in a scene, as text or as one JSON object with the same facts.

use crate::args::InfoArgs;
use crate::error::{self, Failure};
use crate::load::Source;
use crate::options::RenderOptions;
use crate::{memory, report, settings_file};
use serde_json::{Value, json};
use std::path::Path;

/// Prints what is in the scene.
pub fn run(arguments: &InfoArgs) -> Result<(), Failure> {
    let source = Source::new(Some(&arguments.scene));
    let mut facts = match source.path() {
        Some(path) => file(path, arguments)?,
        None => builtin(&source)?,
    };
    facts["settings_file"] =
        source.path().and_then(settings_file::sidecar).map(|path| path.display().to_string()).into();
    if arguments.json {
        report::json(&facts);
    } else {
        text(&arguments.scene, &facts).iter().for_each(|line| report::result(line));
    }
    Ok(())
}

/// The reader's account, its counts moved to the top.
#[cfg(feature = "gltf")]
fn file(path: &Path, arguments: &InfoArgs) -> Result<Value, Failure> {
    use dapple_integrator::scene::gltf;
    let (allow_path, memory) = (arguments.allow_path, memory::limit(arguments.memory_limit));
    let info = gltf::info(path, &gltf::Options { allow_path, memory, ..gltf::Options::default() })?;
    let unsayable = |e: serde_json::Error| Failure::Arguments(format!("{}: {e}", path.display()));
    let mut facts = serde_json::to_value(info).map_err(unsayable)?;
    let counts = facts["counts"].take();
    if let (Some(facts), Value::Object(counts)) = (facts.as_object_mut(), counts) {
        facts.remove("counts");
        for (key, count) in counts {
            facts.entry(key).or_insert(count);
        }
    }
    Ok(facts)
}

#[cfg(not(feature = "gltf"))]
fn file(path: &Path, _: &InfoArgs) -> Result<Value, Failure> {
    let said = format!("{}: this dapple was built without the glTF reader (feature gltf)", path.display());
    Err(Failure::Arguments(said))
}

/// Built-in scenes have no file to look into: what they hold once built.
fn builtin(source: &Source) -> Result<Value, Failure> {
    let scene = source.read(&RenderOptions::default())?.build()?;
    let materials: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    let cameras: Vec<&str> = scene.cameras.iter().map(|c| &*c.name).collect();
    let lights: Vec<String> = scene.lights.iter().map(|l| kind(l).to_string()).collect();
    Ok(json!({
        "nodes": scene.survey.objects, "meshes": scene.survey.objects, "triangles": scene.survey.triangles,
        "materials": materials, "textures": [], "lights": lights, "cameras": cameras, "animations": [],
        "extensions": [], "memory_bytes": scene.memory_bytes(), "warnings": [],
    }))
}

fn kind(light: &dapple_integrator::lights::Light) -> &'static str {
    use dapple_integrator::lights::Light;
    match light {
        Light::Point(_) => "point",
        Light::Spot(_) => "spot",
        Light::Moving(_) => "moving",
        Light::Distant(_) => "distant",
        Light::Area(_) | Light::Patterned(_) => "area",
        Light::Environment(_) => "environment",
    }
}

/// One subject per line.
fn text(scene: &str, facts: &Value) -> Vec<String> {
    let count = |key: &str| facts[key].as_u64().unwrap_or(0);
    let mut lines = vec![format!(
        "{scene}: {} nodes, {} meshes, {} triangles, about {:.3} MB in memory",
        count("nodes"),
        count("meshes"),
        count("triangles"),
        count("memory_bytes") as f64 / 1e6,
    )];
    if let Some(generator) = facts["generator"].as_str() {
        lines.push(format!("generator: {generator}"));
    }
    if let Some(path) = facts["settings_file"].as_str() {
        lines.push(format!("settings file: {path}"));
    }
    lines.push(list(facts, "materials", plain));
    if count("shapes") > 0 {
        lines.push(format!("exact spheres and disks: {}", count("shapes")));
    }
    lines.push(list(facts, "textures", texture));
    lines.push(list(facts, "lights", plain));
    if facts["emissive"].as_array().is_some_and(|names| !names.is_empty()) {
        lines.push(list(facts, "emissive", plain).replacen("emissive", "emissive materials", 1));
    }
    lines.push(list(facts, "cameras", plain));
    lines.push(list(facts, "animations", animation));
    lines.push(list(facts, "extensions", extension));
    let warnings = facts["warnings"].as_array().into_iter().flatten();
    lines.extend(warnings.map(|w| format!("warning: {}", plain(w))));
    lines
}

fn list(facts: &Value, key: &str, item: fn(&Value) -> String) -> String {
    let items: Vec<String> = facts[key].as_array().into_iter().flatten().map(item).collect();
    if items.is_empty() {
        format!("{key}: none")
    } else {
        format!("{key} ({}): {}", items.len(), items.join(", "))
    }
}

fn plain(value: &Value) -> String {
    error::one_line(value.as_str().unwrap_or_default())
}

fn texture(t: &Value) -> String {
    match t["error"].as_str() {
        Some(error) => format!("{} (cannot be read: {error})", plain(&t["name"])),
        None => format!("{} {}x{}", plain(&t["name"]), t["width"], t["height"]),
    }
}

fn animation(a: &Value) -> String {
    let seconds = |key: &str| a[key].as_f64().unwrap_or(0.0);
    format!("{} {:.3} s to {:.3} s", plain(&a["name"]), seconds("start"), seconds("end"))
}

fn extension(e: &Value) -> String {
    let required = if e["required"] == true { "required" } else { "optional" };
    let supported = if e["supported"] == true { "" } else { ", not supported" };
    format!("{} ({required}{supported})", plain(&e["name"]))
}
