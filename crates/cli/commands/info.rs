//! `dapple info`: the contents of a scene and the messages of a render of it, as text or as one JSON object.
//!
//! The contents of a file come from its JSON. Everything else (bounds, memory, warnings) comes from loading the scene
//! as `render` does with the same options; if that fails, the remaining facts are printed with the reason.

mod builtin;
mod text;

use crate::args::InfoArgs;
use crate::commands::render;
use crate::error::{self, Failure};
use crate::load::{self, Loaded, Source};
use crate::options::RenderOptions;
use crate::{events, machine, settings_file, standard_output};
use clap::ArgMatches;
use dapple_integrator::camera::Projection;
use dapple_integrator::scene::{NamedCamera, Scene};
use serde_json::{Value, json};
use std::path::Path;

/// Memory of worker threads and of a file being written, in addition to the image, in bytes: measured on small images.
const WORKING_BYTES: u64 = 3 << 20;

/// Prints the contents of the scene.
pub fn run(arguments: &InfoArgs, typed: &ArgMatches) -> Result<(), Failure> {
    let source = Source::new(Some(&arguments.scene));
    let (options, sidecar_warning, refused) = layers(source.path(), typed)?;
    events::start(&options);
    let would_be = match refused {
        Some(refusal) => Err(refusal),
        None => WouldBe::of(&source, &options),
    };
    let mut facts = match (source.path(), &would_be) {
        (Some(path), _) => file(path, &options)?,
        (None, Ok(would_be)) => builtin::facts(&would_be.loaded.scene),
        (None, Err(_)) => json!({}),
    };
    match would_be {
        Ok(would_be) => would_be.tell(&mut facts),
        Err(failure) if source.path().is_none() => return Err(failure),
        Err(failure) => facts["error"] = error::one_line(&failure.to_string()).into(),
    }
    if let (Some(warning), Some(all)) = (sidecar_warning, facts["warnings"].as_array_mut()) {
        all.insert(0, warning.into());
    }
    facts["settings_file"] =
        source.path().and_then(settings_file::sidecar).map(|path| path.display().to_string()).into();
    if RenderOptions::is(options.json) {
        standard_output::json(&facts);
    } else {
        text::lines(&arguments.scene, &facts).iter().for_each(|line| standard_output::result(line));
    }
    Ok(())
}

/// Returns the options of all layers, and the warning about the sidecar. If `render` would reject the sidecar, returns
/// only the typed options, and the reason.
fn layers(
    scene: Option<&Path>,
    typed: &ArgMatches,
) -> Result<(RenderOptions, Option<String>, Option<Failure>), Failure> {
    match settings_file::layers(scene, typed, "info") {
        Ok((options, warning)) => Ok((options, warning, None)),
        Err(failure) => {
            let mut options = RenderOptions::default();
            options.apply_matches(typed)?;
            if options.settings.is_some() { Err(failure) } else { Ok((options, None, Some(failure))) }
        }
    }
}

/// State of a render before its first sample.
struct WouldBe {
    loaded: Loaded,
    view: NamedCamera,
    size: (u32, u32),
    /// Peak memory of this process once the image is written, in bytes.
    peak_bytes: u64,
}

impl WouldBe {
    fn of(source: &Source, options: &RenderOptions) -> Result<Self, Failure> {
        let loaded = load::load(source, options)?;
        let view = load::camera(&loaded.scene, options)?;
        let settings = render::settings(options, &view)?;
        let picture_bytes = settings.rect().area() as u64 * load::pixel_bytes(options);
        // Loading has passed its peak, and the image is allocated in addition to the memory still in use.
        let held = machine::resident_memory_bytes().max(loaded.scene.memory_bytes() as u64);
        let peak_bytes = machine::peak_memory_bytes().max(held + picture_bytes + WORKING_BYTES);
        Ok(Self { loaded, view, size: settings.size, peak_bytes })
    }

    /// Adds the facts that are known once the scene is built.
    fn tell(self, facts: &mut Value) {
        let Self { loaded: Loaded { scene, notes, .. }, view, size, peak_bytes } = self;
        facts["bounds"] = match scene.bounds {
            Some((min, max)) => json!({ "min": min.to_array(), "max": max.to_array() }),
            None => Value::Null,
        };
        facts["memory_bytes"] = scene.memory_bytes().into();
        facts["peak_memory_bytes"] = peak_bytes.into();
        facts["width"] = size.0.into();
        facts["height"] = size.1.into();
        facts["camera"] = json!(&*view.name);
        if facts["cameras"].as_array().is_none_or(Vec::is_empty) {
            facts["cameras"] = scene.cameras.iter().map(|c| camera(c, &scene)).collect();
        }
        facts["notes"] = json!(notes);
        facts["warnings"] = scene.warnings.iter().map(|w| w.0.clone()).collect();
    }
}

/// Describes a camera that is not in a file.
fn camera(named: &NamedCamera, scene: &Scene) -> Value {
    let (camera, space) = (&named.camera, &scene.space);
    let vector = |v: glam::Vec3| v.as_dvec3().to_array();
    let mut facts = json!({
        "name": &*named.name, "position": space.to_world(camera.origin).0.to_array(),
        "direction": vector(glam::Vec3::ZERO - camera.backward), "up": vector(camera.up), "aspect": named.aspect,
    });
    match camera.projection {
        Projection::Perspective { tan_half } => {
            facts["kind"] = "perspective".into();
            facts["yfov_degrees"] = (2.0 * f64::from(tan_half).atan().to_degrees()).into();
        }
        Projection::Orthographic { half_height } => {
            let height = space.length_to_world(2.0 * f64::from(half_height));
            facts["kind"] = "orthographic".into();
            facts["size"] = json!([height * f64::from(named.aspect.unwrap_or(1.0)), height]);
        }
    }
    facts
}

/// Returns the reader's facts, with the counts moved to the top level.
#[cfg(feature = "gltf")]
fn file(path: &Path, options: &RenderOptions) -> Result<Value, Failure> {
    let info = dapple_integrator::scene::gltf::info(path, &load::reader_options(options))?;
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
fn file(path: &Path, _: &RenderOptions) -> Result<Value, Failure> {
    let said = format!("{}: this dapple was built without the glTF reader (feature gltf)", path.display());
    Err(Failure::Arguments(said))
}
