//! Fuzz targets: the readers of every file format, on bytes that a fuzzer makes up. Only built by `fuzz/run.sh`.

use crate::checkpoint::file::{Contents, Kind};
use crate::load::{self, Source};
use crate::options::RenderOptions;
use crate::part::PartFile;
use crate::settings_file;
use dapple_integrator::camera::Camera;
use dapple_integrator::imaging::MemoryLimit;
use dapple_integrator::imaging::read;
use dapple_integrator::scene::{Scene, builtin};
use dapple_integrator::{RenderState, Renderer, Settings};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::OnceLock;

/// Most memory that a file may ask for.
const MEMORY: u64 = 1 << 30;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    static TARGET: OnceLock<String> = OnceLock::new();
    match TARGET.get_or_init(|| std::env::var("FUZZ").unwrap_or_default()).as_str() {
        "checkpoint" => checkpoint(bytes),
        "part" => part(bytes),
        "gltf" => scene(bytes, "gltf"),
        "glb" => scene(bytes, "glb"),
        "hdr" => image(bytes, "hdr"),
        "exr" => image(bytes, "exr"),
        "settings" => settings(bytes),
        other => panic!("FUZZ={other}: expected checkpoint, part, gltf, glb, hdr, exr or settings"),
    }
});

/// Writes the bytes to a file of this process.
fn file(bytes: &[u8], extension: &str) -> PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = std::env::temp_dir().join(format!("dapple-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        folder
    });
    let path = folder.join(format!("a.{extension}"));
    std::fs::write(&path, bytes).expect("a temporary file");
    path
}

fn box_of_light() -> &'static (Scene, Camera, Settings) {
    static SCENE: OnceLock<(Scene, Camera, Settings)> = OnceLock::new();
    SCENE.get_or_init(|| {
        let scene = builtin::builtin("cornell").expect("a scene").build().expect("a scene");
        let camera = scene.cameras[0].camera.clone();
        let settings = Settings { size: (4, 3), ..Settings::default() }.with_spp(4).with_threads(1);
        (scene, camera, settings)
    })
}

/// The container, and the state without the checksum that protects it.
fn checkpoint(bytes: &[u8]) {
    drop(Contents::decode(Kind::Checkpoint, bytes));
    let Ok(state) = postcard::from_bytes::<RenderState>(bytes) else { return };
    let (scene, camera, settings) = box_of_light();
    if let Ok(mut renderer) = Renderer::resume(scene, camera, settings, state) {
        renderer.advance(4, &|_| ControlFlow::Continue(()));
        drop(renderer.finish());
    }
}

/// The container, and the sums without the checksum that protects them.
fn part(bytes: &[u8]) {
    drop(PartFile::decode(bytes));
    let Ok(file) = PartFile::of_state(Default::default(), bytes) else { return };
    let mut twice = file.part.clone();
    drop(twice.merge(file.part.clone()));
    if let Ok(outcome) = file.part.outcome(1) {
        drop(crate::part::judged(&file.errors, &outcome, 0.95));
        drop(file.notes.attributes(1, None, None));
    }
}

/// Loads a scene and renders a small image of it.
fn scene(bytes: &[u8], extension: &str) {
    let path = file(bytes, extension);
    let options = RenderOptions { memory_limit: Some(MEMORY), quiet: Some(true), ..RenderOptions::default() };
    let source = Source::new(path.to_str());
    let Ok(loaded) = load::load(&source, &options) else { return };
    let Ok(view) = load::camera(&loaded.scene, &options) else { return };
    let settings = Settings { size: (4, 3), ..Settings::default() }.with_spp(1).with_threads(1);
    drop(dapple_integrator::render(&loaded.scene, &view.camera, &settings, &|_| ControlFlow::Continue(())));
}

fn image(bytes: &[u8], extension: &str) {
    let path = file(bytes, extension);
    let limit = MemoryLimit::asked(MEMORY);
    drop(read::picture_within(&path, limit));
    drop(read::windowed_within(&path, limit));
    drop(read::texels_within(bytes, "image", limit));
}

fn settings(bytes: &[u8]) {
    let path = file(bytes, "toml");
    drop(settings_file::fuzzed(&path));
}
