//! `dapple replay`: the path of one sample, vertex by vertex, as text or JSON.

use crate::args::ReplayArgs;
use crate::commands::render;
use crate::error::Failure;
use crate::load::{self, Source};
use crate::options::RenderOptions;
use crate::values::Pixel;
use crate::{effects, events, settings_file, standard_output};
use clap::ArgMatches;
use dapple_integrator::{PathVertex, Settings, replay};
use glam::{DVec3, Vec3};
use serde_json::json;

/// Traces the sample again and prints its vertices.
pub fn run(arguments: &ReplayArgs, typed: &ArgMatches) -> Result<(), Failure> {
    let source = Source::new(Some(&arguments.scene));
    let options = settings_file::layered(source.path(), typed, "replay")?;
    events::start(&options);
    let loaded = load::load(&source, &options)?;
    let view = &load::camera(&loaded.scene, &options)?;
    let settings = render::settings(&options, view)?;
    check(&settings, arguments.pixel, arguments.sample)?;
    render::warn(&loaded);
    effects::note_idle(&options, &settings, &loaded.scene, &view.camera);
    let Pixel(x, y) = arguments.pixel;
    let (vertices, radiance) = replay(&loaded.scene, &view.camera, &settings, (x, y), arguments.sample);
    if RenderOptions::is(options.json) {
        let vertices: Vec<_> = vertices.iter().map(as_json).collect();
        standard_output::json(&json!({
            "pixel": [x, y], "sample": arguments.sample, "radiance": numbers(radiance), "vertices": vertices,
        }));
    } else {
        vertices.iter().enumerate().for_each(|(i, vertex)| standard_output::results(&as_text(i, vertex)));
        standard_output::result(&format!("radiance {}", vector(radiance)));
    }
    Ok(())
}

fn check(settings: &Settings, Pixel(x, y): Pixel, sample: u32) -> Result<(), Failure> {
    let (w, h) = settings.size;
    if x >= w || y >= h {
        return Err(Failure::Arguments(format!("--pixel {x},{y}: outside the image, which is {w}x{h}")));
    }
    match settings.samples() {
        Some(spp) if sample >= spp => {
            let said = format!(
                "--sample {sample}: there are {spp} samples per pixel, counted from 0; see --spp and --pixel"
            );
            Err(Failure::Arguments(said))
        }
        _ => Ok(()),
    }
}

fn as_text(index: usize, v: &PathVertex) -> String {
    let mut line = format!("{index} depth {} {}", v.depth, v.kind);
    if !v.object.is_empty() || !v.material.is_empty() {
        line += &format!(" '{}' material '{}'", v.object, v.material);
    }
    line += &format!("\n    p {} n {} beta {}", position(v.p), vector(v.n), vector(v.beta));
    line += &format!("\n    emitted {} direct {}", vector(v.emitted), vector(v.direct));
    if !v.lobe.is_empty() {
        line += &format!("\n    leaves by {} with pdf {}", v.lobe, v.pdf);
    }
    line
}

fn vector(v: Vec3) -> String {
    format!("({}, {}, {})", v.x, v.y, v.z)
}

fn position(p: DVec3) -> String {
    format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z)
}

fn as_json(v: &PathVertex) -> serde_json::Value {
    json!({
        "depth": v.depth, "kind": v.kind, "object": v.object, "material": v.material,
        "p": [number(v.p.x), number(v.p.y), number(v.p.z)], "n": numbers(v.n),
        "lobe": v.lobe, "pdf": number(v.pdf.into()),
        "beta": numbers(v.beta), "emitted": numbers(v.emitted), "direct": numbers(v.direct),
    })
}

fn numbers(v: Vec3) -> serde_json::Value {
    json!([number(v.x.into()), number(v.y.into()), number(v.z.into())])
}

/// Encodes a number; non-finite numbers, which replay exists to diagnose, become text, as JSON has no infinities.
fn number(x: f64) -> serde_json::Value {
    if x.is_finite() { json!(x) } else { json!(x.to_string()) }
}
