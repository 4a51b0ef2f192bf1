//! Composition of the output layers from the sums, in world units.

use crate::aov::Aov;
use crate::bias_report::Removed;
use crate::cryptomatte::{Matte, names_of_ids};
use crate::facts::Facts;
use crate::tile::Tile;
use dapple_camera::Film;
use dapple_imaging::{Image, Layer, Layers, MetaValue};
use dapple_math::{FixedSum, FixedVector, PixelRect};
use glam::DVec3;
use std::collections::BTreeSet;

/// The beauty layer if the image is rendered, then the layers in the requested order; finally the sample counts if only
/// some pixels have samples.
pub(super) fn compose(facts: &Facts, rect: PixelRect, film: &Film, tiles: &[Tile], some: bool) -> Layers {
    let beauty = facts.picture.then(|| beauty(facts, rect, film, tiles));
    let mut layers: Vec<Layer> = beauty.into_iter().collect();
    let mut metadata = names(facts, rect, tiles);
    for &aov in facts.aovs.iter().filter(|aov| **aov != Aov::Beauty) {
        match aov {
            Aov::Cryptomatte => mattes(facts, rect, tiles, &mut layers, &mut metadata),
            aov => layers.push(layer(facts, aov, rect, film, tiles)),
        }
    }
    if some && !facts.aovs.contains(&Aov::SampleCount) {
        layers.push(layer(facts, Aov::SampleCount, rect, film, tiles));
    }
    Layers {
        width: (rect.x1 - rect.x0) as usize,
        height: (rect.y1 - rect.y0) as usize,
        offset: (rect.x0 as i32, rect.y0 as i32),
        full_size: (facts.size.0 as usize, facts.size.1 as usize),
        layers,
        metadata,
    }
}

/// The image, with alpha if its background is transparent.
fn beauty(facts: &Facts, rect: PixelRect, film: &Film, tiles: &[Tile]) -> Layer {
    let mut beauty = rgb("", &film.mean());
    if facts.transparent {
        let mut alpha = vec![0.0; rect.area()];
        let counts: Vec<u64> = pixels(rect).map(|(x, y)| film.count(x, y)).collect();
        each_pixel(rect, tiles, |to, tile, from| {
            alpha[to] = tile.first_hits.coverage.alpha(from, counts[to]);
        });
        beauty.channels.push(("A".into(), alpha));
    }
    beauty
}

/// Adds the Cryptomatte layers and their metadata.
fn mattes(
    facts: &Facts,
    rect: PixelRect,
    tiles: &[Tile],
    layers: &mut Vec<Layer>,
    metadata: &mut Vec<(String, MetaValue)>,
) {
    for of in [Matte::of_objects, Matte::of_materials] {
        let mut matte = of(&facts.names, rect.area());
        each_pixel(rect, tiles, |to, tile, from| matte.set_pixel(to, &tile.first_hits.coverage, from));
        let (more, about) = matte.finish();
        layers.extend(more);
        metadata.extend(about);
    }
}

/// The names of the ids in the layers `object` and `material` that occur in the image.
fn names(facts: &Facts, rect: PixelRect, tiles: &[Tile]) -> Vec<(String, MetaValue)> {
    let asks = |aov| facts.aovs.contains(&aov);
    if !asks(Aov::ObjectId) && !asks(Aov::MaterialId) {
        return Vec::new();
    }
    let (all, seen) = (&facts.names, gather(rect, tiles, |tile| &tile.first_hits.object, |id| *id));
    let objects: BTreeSet<u32> = seen.into_iter().filter(|object| *object != 0).collect();
    let materials: BTreeSet<u32> = objects.iter().map(|id| all.material_of(*id as usize - 1) + 1).collect();
    let mut names = Vec::new();
    if asks(Aov::ObjectId) {
        let text = names_of_ids(objects.iter().map(|id| (shown(all.object(*id as usize - 1)), *id)));
        names.push(("objectNames".into(), MetaValue::Text(text)));
    }
    if asks(Aov::MaterialId) {
        let name = |id: u32| all.material(id as usize - 1);
        let text = names_of_ids(materials.iter().map(|id| (shown(name(*id)), *id)));
        names.push(("materialNames".into(), MetaValue::Text(text)));
    }
    names
}

/// At most the first 1000 characters of a name, which many objects may share.
fn shown(name: &str) -> &str {
    name.char_indices().nth(1000).map_or(name, |(end, _)| &name[..end])
}

/// Calls `of` with the index of each pixel in the image, its tile, and its index in the tile.
fn each_pixel(rect: PixelRect, tiles: &[Tile], mut of: impl FnMut(usize, &Tile, usize)) {
    for tile in tiles {
        for (from, (x, y)) in pixels(tile.rect).enumerate() {
            of((y - rect.y0) as usize * rect.width() as usize + (x - rect.x0) as usize, tile, from);
        }
    }
}

fn layer(facts: &Facts, aov: Aov, rect: PixelRect, film: &Film, tiles: &[Tile]) -> Layer {
    let name = aov.to_string();
    match aov {
        // The Cryptomatte layers are created in [`mattes`].
        Aov::Beauty | Aov::Cryptomatte => rgb(&name, &film.mean()),
        Aov::Variance => rgb(&name, &film.variance()),
        Aov::SampleCount => {
            let counts = pixels(rect).map(|(x, y)| film.count(x, y) as f32).collect();
            Layer { name, channels: vec![("Y".into(), counts)] }
        }
        Aov::Albedo => {
            let n = pixels(rect).map(|(x, y)| film.count(x, y).max(1) as f64);
            let sums = gather(rect, tiles, |tile| &tile.first_hits.albedo, FixedVector::value);
            let mean: Vec<DVec3> = sums.iter().zip(n).map(|(sum, n)| sum / n).collect();
            vector(name, ["R", "G", "B"], &mean)
        }
        Aov::Normal => {
            let mean = |sum: &FixedVector| sum.value().normalize_or_zero();
            let mean = gather(rect, tiles, |tile| &tile.first_hits.normal, mean);
            vector(name, ["X", "Y", "Z"], &mean)
        }
        Aov::Position => {
            let all: Vec<DVec3> = places(rect, tiles).map(|at| position(facts, at)).collect();
            vector(name, ["X", "Y", "Z"], &all)
        }
        Aov::Depth => {
            let all = places(rect, tiles).map(|at| depth(facts, at)).collect();
            Layer { name, channels: vec![("Z".into(), all)] }
        }
        Aov::ObjectId => ids(name, rect, tiles, |object| object),
        Aov::MaterialId => ids(name, rect, tiles, |object| {
            if object == 0 { 0 } else { facts.names.material_of(object as usize - 1) + 1 }
        }),
        Aov::Removed => removed(rect, film, tiles),
    }
}

/// Energy removed from the estimate of each pixel, per sample.
fn removed(rect: PixelRect, film: &Film, tiles: &[Tile]) -> Layer {
    let sums = gather(rect, tiles, |tile| &tile.removed, Removed::energies);
    let counts: Vec<f64> = pixels(rect).map(|(x, y)| film.count(x, y).max(1) as f64).collect();
    let channel = |(k, name): (usize, &str)| {
        let mean = sums.iter().zip(&counts).map(|(sum, n)| (sum[k] / n) as f32).collect();
        (name.to_string(), mean)
    };
    let names = ["clamped", "depth", "faint", "not_finite"];
    Layer { name: Aov::Removed.to_string(), channels: names.into_iter().enumerate().map(channel).collect() }
}

fn ids(name: String, rect: PixelRect, tiles: &[Tile], id: impl Fn(u32) -> u32) -> Layer {
    let ids = gather(rect, tiles, |tile| &tile.first_hits.object, |object| id(*object) as f32);
    Layer { name, channels: vec![("Y".into(), ids)] }
}

/// Mean hit position of each pixel in render space; `None` where no sample hit a surface.
fn places(rect: PixelRect, tiles: &[Tile]) -> impl Iterator<Item = Option<DVec3>> {
    let hits = gather(rect, tiles, |tile| &tile.first_hits.hits, FixedSum::value);
    let sums = gather(rect, tiles, |tile| &tile.first_hits.p, FixedVector::value);
    hits.into_iter().zip(sums).map(|(hits, sum)| (hits != 0.0).then(|| sum / hits))
}

/// Position in world space; zero where nothing was hit.
fn position(facts: &Facts, at: Option<DVec3>) -> DVec3 {
    at.map_or(DVec3::ZERO, |at| facts.space().to_world_f64(at).0)
}

/// Distance along the view axis in scene units; infinite where nothing was hit.
fn depth(facts: &Facts, at: Option<DVec3>) -> f32 {
    let Some(at) = at else { return f32::INFINITY };
    let from_camera = at - facts.camera.0.as_dvec3();
    facts.space().length_to_world(-from_camera.dot(facts.camera.1.as_dvec3())) as f32
}

fn rgb(name: &str, picture: &Image) -> Layer {
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

/// Values of the sums of all tiles in image order; empty if the tiles have none.
fn gather<S, T: Clone + Default>(
    rect: PixelRect,
    tiles: &[Tile],
    held: impl Fn(&Tile) -> &Vec<S>,
    value: impl Fn(&S) -> T,
) -> Vec<T> {
    if tiles.first().is_none_or(|tile| held(tile).is_empty()) {
        return Vec::new();
    }
    let width = (rect.x1 - rect.x0) as usize;
    let mut all = vec![T::default(); width * (rect.y1 - rect.y0) as usize];
    for tile in tiles {
        for ((x, y), sum) in pixels(tile.rect).zip(held(tile)) {
            all[(y - rect.y0) as usize * width + (x - rect.x0) as usize] = value(sum);
        }
    }
    all
}
