//! Cryptomatte: the objects and materials that cover a pixel, with their coverage, as layers that compositing programs
//! select by name [Friedman & Jones 2015; Cryptomatte specification 1.2.0].
//!
//! An id is the hash of a name, stored as the bits of a float. Each layer holds two ranks: R and B are ids, G and A
//! their coverage, in descending order. Entries beyond the sixth are dropped.

use crate::coverage::Coverage;
use crate::facts::Names;
use dapple_imaging::{Layer, MetaValue};
use std::collections::BTreeMap;

/// Number of ids stored per pixel, two in each layer.
const RANKS: usize = 6;

/// One kind of ids of a scene.
pub(crate) struct Matte<'a> {
    /// Name of the layers without their number.
    name: &'static str,
    /// Name for each of the scene's objects.
    names: Vec<&'a str>,
    ids: Vec<u32>,
    /// Values of the layers in the order R, G, B, A, pixel by pixel.
    channels: Vec<Vec<f32>>,
    /// Whether each object occurs in the image.
    seen: Vec<bool>,
}

impl<'a> Matte<'a> {
    /// Objects by name. Objects of the same name share an id.
    pub fn of_objects(names: &'a Names, pixels: usize) -> Self {
        Self::new("CryptoObject", (0..names.count()).map(|object| names.object(object)).collect(), pixels)
    }

    /// Materials by name.
    pub fn of_materials(names: &'a Names, pixels: usize) -> Self {
        let material = |object| names.material(names.material_of(object) as usize);
        Self::new("CryptoMaterial", (0..names.count()).map(material).collect(), pixels)
    }

    fn new(name: &'static str, names: Vec<&'a str>, pixels: usize) -> Self {
        let mut ids: Vec<u32> = Vec::with_capacity(names.len());
        for (i, name) in names.iter().enumerate() {
            // Adjacent objects often share one name, which may be long.
            let known = i.checked_sub(1).filter(|before| std::ptr::eq(names[*before], *name));
            ids.push(known.map_or_else(|| id(name), |before| ids[before]));
        }
        let seen = vec![false; names.len()];
        Self { name, names, ids, channels: vec![vec![0.0; pixels]; 2 * RANKS], seen }
    }

    /// Writes the ranks of pixel `from` of a tile to pixel `to` of the image.
    pub fn set_pixel(&mut self, to: usize, coverage: &Coverage, from: usize) {
        let mut shares: Vec<(u32, f64)> = Vec::new();
        for (object, share) in coverage.objects(from).filter(|(_, share)| *share > 0.0) {
            let object = (object as usize).wrapping_sub(1);
            let Some(&id) = self.ids.get(object) else { continue };
            self.seen[object] = true;
            match shares.iter_mut().find(|(known, _)| *known == id) {
                Some((_, sum)) => *sum += share,
                None => shares.push((id, share)),
            }
        }
        shares.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        for (rank, (id, share)) in shares.into_iter().take(RANKS).enumerate() {
            self.channels[2 * rank][to] = f32::from_bits(id);
            self.channels[2 * rank + 1][to] = share as f32;
        }
    }

    /// The names that occur in the image, with their ids.
    fn manifest(&self) -> BTreeMap<&'a str, u32> {
        let mut manifest = BTreeMap::new();
        let mut last: Option<&str> = None;
        for ((name, id), _) in self.names.iter().zip(&self.ids).zip(&self.seen).filter(|(_, seen)| **seen) {
            if !last.is_some_and(|last| std::ptr::eq(last, *name)) {
                manifest.entry(*name).or_insert(*id);
                last = Some(name);
            }
        }
        manifest
    }

    /// The layers, and their metadata attributes.
    pub fn finish(self) -> (Vec<Layer>, Vec<(String, MetaValue)>) {
        let key = &format!("{:08x}", murmur3(self.name.as_bytes()))[..7];
        let attribute =
            |what: &str, value: String| (format!("cryptomatte/{key}/{what}"), MetaValue::Text(value));
        let entries = self.manifest();
        let entries = entries.iter().map(|(name, id)| format!("{}:\"{id:08x}\"", json(name)));
        let manifest = format!("{{{}}}", entries.collect::<Vec<_>>().join(","));
        let about = vec![
            attribute("name", self.name.into()),
            attribute("hash", "MurmurHash3_32".into()),
            attribute("conversion", "uint32_to_float32".into()),
            attribute("manifest", manifest),
        ];
        let mut channels = self.channels.into_iter();
        let layer = |i: usize| Layer {
            name: format!("{}{i:02}", self.name),
            channels: ["R", "G", "B", "A"].map(String::from).into_iter().zip(channels.by_ref()).collect(),
        };
        ((0..RANKS / 2).map(layer).collect(), about)
    }
}

/// The id of a name: its hash, with the lowest exponent bit flipped where the float would be zero, subnormal, infinite
/// or NaN.
pub(crate) fn id(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    if matches!(hash >> 23 & 255, 0 | 255) { hash ^ 1 << 23 } else { hash }
}

/// MurmurHash3, x86, 32 bits, with seed 0 (Austin Appleby, public domain).
fn murmur3(bytes: &[u8]) -> u32 {
    let mix = |k: u32| k.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let little = |chunk: &[u8]| chunk.iter().rev().fold(0, |k, byte| k << 8 | u32::from(*byte));
    let mut hash = 0u32;
    for chunk in bytes.chunks(4) {
        hash ^= mix(little(chunk));
        if chunk.len() == 4 {
            hash = hash.rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64);
        }
    }
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

/// A JSON object that maps each name to all ids + 1 of that name, `{"lid":[3],"pot":[1,2]}`.
pub(crate) fn names_of_ids<'a>(ids: impl IntoIterator<Item = (&'a str, u32)>) -> String {
    let mut all: BTreeMap<&str, Vec<u32>> = BTreeMap::new();
    ids.into_iter().for_each(|(name, id)| all.entry(name).or_default().push(id));
    let entries = all.iter().map(|(name, ids)| {
        let ids: Vec<String> = ids.iter().map(u32::to_string).collect();
        format!("{}:[{}]", json(name), ids.join(","))
    });
    format!("{{{}}}", entries.collect::<Vec<_>>().join(","))
}

/// A JSON string [RFC 8259, §7].
fn json(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c < ' ' => quoted += &format!("\\u{:04x}", c as u32),
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_values_of_the_hash() {
        assert_eq!(murmur3(b""), 0);
        assert_eq!(murmur3(b"hello"), 0x248b_fa47);
        assert_eq!(murmur3(b"hello, world"), 0x149b_bb7f);
        assert_eq!(murmur3(b"The quick brown fox jumps over the lazy dog"), 0x2e4f_f723);
    }

    /// Values from the tests of the reference implementation.
    #[test]
    fn published_ids() {
        for (name, float) in [
            ("hello", 6.070_562_7e-17),
            ("cube", -4.084_619_1e15),
            ("sphere", 2.790_186e15),
            ("plane", 3.665_576_2e-11),
        ] {
            let id = f64::from(f32::from_bits(id(name)));
            assert!((id / float - 1.0_f64).abs() < 1e-6, "{name}: {id}");
        }
    }

    #[test]
    fn ids_are_ordinary_floats() {
        let mut turned = 0;
        for i in 0..20_000 {
            let name = format!("object {i}");
            assert!(f32::from_bits(id(&name)).is_normal(), "{name}");
            turned += u32::from(id(&name) != murmur3(name.as_bytes()));
        }
        assert!(turned > 50, "{turned}: nothing was tested");
    }

    #[test]
    fn names_are_json() {
        assert_eq!(json("a\"\\\n\u{1}µ"), "\"a\\\"\\\\\\u000a\\u0001µ\"");
        assert_eq!(names_of_ids([("b", 2), ("a", 1), ("b", 7)]), r#"{"a":[1],"b":[2,7]}"#);
    }
}
