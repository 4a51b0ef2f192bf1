//! From sums to the layers of the picture, in world units.

use crate::aov::Aov;
use crate::kernel::Job;
use crate::tile::{FirstHits, Tile};
use dapple_camera::{Film, PixelRect};
use dapple_imaging::{Layer, Layers, Picture};
use glam::DVec3;

/// Beauty first if there is a picture, then the layers in the order they were asked for.
pub(super) fn compose(job: &Job<'_>, film: &Film, tiles: &[Tile]) -> Layers {
    let rect = job.settings.rect();
    let beauty = job.settings.picture.then(|| rgb("", &film.mean()));
    let mut layers: Vec<Layer> = beauty.into_iter().collect();
    let first_hits = gather(rect, tiles, |tile| &tile.first_hits);
    for &aov in job.settings.aovs.iter().filter(|aov| **aov != Aov::Beauty) {
        layers.push(layer(job, aov, rect, (film, tiles), &first_hits));
    }
    Layers {
        width: (rect.x1 - rect.x0) as usize,
        height: (rect.y1 - rect.y0) as usize,
        offset: (rect.x0 as i32, rect.y0 as i32),
        full_size: (job.settings.size.0 as usize, job.settings.size.1 as usize),
        layers,
        metadata: Vec::new(),
    }
}

fn layer(
    job: &Job<'_>,
    aov: Aov,
    rect: PixelRect,
    (film, tiles): (&Film, &[Tile]),
    first: &[FirstHits],
) -> Layer {
    let name = aov.to_string();
    match aov {
        Aov::Beauty => rgb(&name, &film.mean()),
        Aov::Variance => rgb(&name, &film.variance()),
        Aov::SampleCount => {
            let counts = pixels(rect).map(|(x, y)| film.count(x, y) as f32).collect();
            Layer { name, channels: vec![("Y".into(), counts)] }
        }
        Aov::Albedo => {
            let n = pixels(rect).map(|(x, y)| film.count(x, y).max(1) as f64);
            let mean: Vec<DVec3> = first.iter().zip(n).map(|(f, n)| f.albedo / n).collect();
            vector(name, ["R", "G", "B"], &mean)
        }
        Aov::Normal => {
            let mean: Vec<DVec3> = first.iter().map(|f| f.normal.normalize_or_zero()).collect();
            vector(name, ["X", "Y", "Z"], &mean)
        }
        Aov::Position => {
            vector(name, ["X", "Y", "Z"], &first.iter().map(|f| position(job, f)).collect::<Vec<_>>())
        }
        Aov::Depth => {
            Layer { name, channels: vec![("Z".into(), first.iter().map(|f| depth(job, f)).collect())] }
        }
        Aov::ObjectId => ids(name, first, |object| object),
        Aov::MaterialId => ids(name, first, |object| {
            if object == 0 { 0 } else { job.scene.objects[object as usize - 1].material + 1 }
        }),
        Aov::Removed => removed(rect, film, tiles),
    }
}

/// What was done to a pixel's estimate, per sample.
fn removed(rect: PixelRect, film: &Film, tiles: &[Tile]) -> Layer {
    let sums = gather(rect, tiles, |tile| &tile.removed);
    let counts: Vec<f64> = pixels(rect).map(|(x, y)| film.count(x, y).max(1) as f64).collect();
    let channel = |(k, name): (usize, &str)| {
        let mean = sums.iter().zip(&counts).map(|(sum, n)| (sum[k] / n) as f32).collect();
        (name.to_string(), mean)
    };
    let names = ["clamped", "depth", "faint", "not_finite"];
    Layer { name: Aov::Removed.to_string(), channels: names.into_iter().enumerate().map(channel).collect() }
}

fn ids(name: String, first: &[FirstHits], id: impl Fn(u32) -> u32) -> Layer {
    Layer { name, channels: vec![("Y".into(), first.iter().map(|f| id(f.object) as f32).collect())] }
}

/// Mean world position of the samples that hit; zero where none did.
fn position(job: &Job<'_>, f: &FirstHits) -> DVec3 {
    if f.hits == 0.0 { DVec3::ZERO } else { f.p / f.hits / job.scene.space.scale + job.scene.space.centre }
}

/// Mean distance along the view axis, scene units; infinite where nothing was hit.
fn depth(job: &Job<'_>, f: &FirstHits) -> f32 {
    if f.hits == 0.0 {
        return f32::INFINITY;
    }
    let from_camera = f.p / f.hits - job.camera.origin.as_dvec3();
    (-from_camera.dot(job.camera.backward.as_dvec3()) / job.scene.space.scale) as f32
}

fn rgb(name: &str, picture: &Picture) -> Layer {
    let all: Vec<DVec3> = picture.pixels.iter().map(|p| p.as_dvec3()).collect();
    vector(name.into(), ["R", "G", "B"], &all)
}

fn vector(name: String, channels: [&str; 3], values: &[DVec3]) -> Layer {
    let channel = |i: usize| (channels[i].to_string(), values.iter().map(|v| v[i] as f32).collect());
    Layer { name, channels: vec![channel(0), channel(1), channel(2)] }
}

fn pixels(rect: PixelRect) -> impl Iterator<Item = (u32, u32)> {
    (rect.y0..rect.y1).flat_map(move |y| (rect.x0..rect.x1).map(move |x| (x, y)))
}

/// What all tiles hold of their pixels, in picture order; empty when they hold nothing.
fn gather<T: Copy + Default>(rect: PixelRect, tiles: &[Tile], held: impl Fn(&Tile) -> &Vec<T>) -> Vec<T> {
    if tiles.first().is_none_or(|tile| held(tile).is_empty()) {
        return Vec::new();
    }
    let width = (rect.x1 - rect.x0) as usize;
    let mut all = vec![T::default(); width * (rect.y1 - rect.y0) as usize];
    for tile in tiles {
        for ((x, y), &of) in pixels(tile.rect).zip(held(tile)) {
            all[(y - rect.y0) as usize * width + (x - rect.x0) as usize] = of;
        }
    }
    all
}
