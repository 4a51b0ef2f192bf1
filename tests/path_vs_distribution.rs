//! Both tracers give the same expected image: a z-test on each scene of `scenes/`, for each effect alone and for all
//! together, with the distribution tracer's integrals nested and paired.
//!
//! The pixel samples are independent (`random`), so that the film estimates the error of all integrals nested in them;
//! for an effect alone, they come from a filter too narrow to matter. The long version runs in `.ci/weekly`.

mod dapple;

use dapple::well;
use dapple_imaging::{Image, read};
use dapple_testkit::z_test::{self, Channel};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Size of the comparison.
#[derive(Clone, Copy)]
struct Effort {
    size: &'static str,
    /// Samples per pixel of the path tracer.
    path: u32,
    /// Pixel samples, nested.
    nested: u32,
    /// Pixel samples, paired.
    paired: u32,
    /// Side of a tile in pixels.
    tile: usize,
}

const QUICK: Effort = Effort { size: "16x12", path: 512, nested: 64, paired: 256, tile: 4 };
const LONG: Effort = Effort { size: "32x24", path: 4096, nested: 512, paired: 2048, tile: 4 };

/// Probability that any comparison of the run fails by chance.
const LEVEL: f64 = 1e-5;
/// Maximum number of comparisons of one channel; each gets its share of the level.
const COMPARISONS: usize = 400;

/// Samples of the effects within a pixel sample, when all are on.
const INNER: [&str; 7] =
    ["--lens=2", "--time=2", "--light=2", "--glossy=2", "--refract=2", "--diffuse=1", "--secondary=1"];
const EFFECTS: [&str; 7] = ["pixel", "lens", "time", "light", "glossy", "refract", "diffuse"];

fn scenes() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(dapple::scene("")).unwrap().map(|entry| entry.unwrap().path());
    let mut scenes: Vec<_> = entries.filter(|p| p.extension() == Some(OsStr::new("gltf"))).collect();
    scenes.sort();
    scenes
}

/// Returns the effects that a scene has.
fn effects_of(folder: &Path, scene: &str) -> Vec<String> {
    let json = well(folder, &["rays", scene, "--method", "distribution", "--json"]).json();
    json["effects"].as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_string()).collect()
}

/// An image and the variance of its pixels.
struct Measured {
    mean: Image,
    variance: Image,
}

fn render(folder: &Path, scene: &str, effort: Effort, more: &[String]) -> Measured {
    let fixed = ["--quiet", "--size", effort.size, "--max-bounces", "4", "--aov", "variance", "-o", "a.exr"];
    let more: Vec<&str> = more.iter().map(String::as_str).collect();
    well(folder, &[&["render", scene], &fixed[..], &more].concat());
    let layers = read::layers(&folder.join("a.exr")).unwrap();
    Measured { mean: layers.beauty().unwrap(), variance: layers.picture("variance").unwrap() }
}

/// Returns options that leave only one effect on.
fn alone(effect: &str) -> Vec<String> {
    let off = EFFECTS.iter().filter(|name| **name != effect && **name != "pixel");
    let mut options: Vec<String> = off.map(|name| format!("--{name}=0")).collect();
    if effect != "pixel" {
        options.push("--filter=box:0.001".into());
    }
    options
}

/// Returns the options of the path tracer, and of the distribution tracer, nested and paired.
fn methods(effort: Effort, effect: Option<&str>) -> [Vec<String>; 3] {
    let words = |text: String| text.split(' ').map(String::from).collect::<Vec<_>>();
    let distribution = |n: u32, combine: &str| {
        words(format!("--method=distribution --seed=2 --pixel={n}:random --combine={combine} --yes"))
    };
    let path = words(format!("--seed=1 --spp={} --pattern=random", effort.path));
    let mut all = [path, distribution(effort.nested, "nested"), distribution(effort.paired, "paired")];
    match effect {
        None => all[1].extend(INNER.map(String::from)),
        Some(effect) => {
            all.iter_mut().for_each(|options| options.extend(alone(effect)));
            if effect != "pixel" {
                all[1].push(format!("--{effect}=4"));
            }
        }
    }
    all
}

/// Compares the tiles of each channel at its share of the level; the error is a sentence.
fn compare(a: &Measured, b: &Measured, tile: usize) -> Result<(), String> {
    let channel =
        |picture: &Image, c: usize| -> Vec<f64> { picture.pixels.iter().map(|p| f64::from(p[c])).collect() };
    for c in [0, 2] {
        let sides = [a, b].map(|side| {
            let mean = channel(&side.mean, c);
            // Sums in f32 along a path are accurate to about this.
            let rounding = mean.iter().map(|m| 1e-10 * m * m);
            let variance: Vec<f64> =
                channel(&side.variance, c).iter().zip(rounding).map(|(v, r)| v + r).collect();
            (mean, variance)
        });
        let [x, y] = sides.each_ref().map(|(mean, variance)| Channel { mean, variance });
        let tiles = z_test::tiles(x, y, a.mean.width, tile, z_test::sidak(LEVEL, COMPARISONS));
        if !tiles.passed() {
            return Err(format!("channel {c}: {tiles}"));
        }
    }
    Ok(())
}

fn compare_all(effort: Effort) {
    let folder = tempfile::tempdir().unwrap();
    let mut wrong = Vec::new();
    let mut compared = 0;
    for path in scenes() {
        let scene = path.to_str().unwrap();
        let effects = effects_of(folder.path(), scene);
        for effect in effects.iter().map(|name| Some(name.as_str())).chain([None]) {
            let [path, nested, paired] =
                methods(effort, effect).map(|options| render(folder.path(), scene, effort, &options));
            for (combine, ours) in [("nested", nested), ("paired", paired)] {
                compared += 1;
                if let Err(said) = compare(&ours, &path, effort.tile) {
                    wrong.push(format!("{scene}, {}, {combine}: {said}", effect.unwrap_or("all effects")));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {compared} disagree:\n{}", wrong.len(), wrong.join("\n"));
    assert!((40..=COMPARISONS / 2).contains(&compared), "{compared}");
}

#[test]
fn the_tracers_agree_on_every_scene() {
    compare_all(QUICK);
}

#[test]
#[ignore = "takes half an hour; .ci/weekly runs it"]
fn the_tracers_agree_closely_on_every_scene() {
    compare_all(LONG);
}
