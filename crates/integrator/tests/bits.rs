//! Pins the bits of small images, so that [`BITS`] increases whenever they change.

mod common;

use common::outdoors;
use dapple_integrator::{BITS, MethodKind, Settings, render};
use dapple_scene::Scene;
use dapple_scene::builtin::{NAMES, builtin};
use std::ops::ControlFlow;

/// FNV-1a over the bits of all pixels of both integrators.
fn hash(scene: &Scene) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    for method in [MethodKind::Path, MethodKind::Distribution] {
        let settings = Settings { size: (12, 9), seed: 7, ..Settings::default() };
        let settings = settings.with_method(method).with_spp(4);
        let outcome = render(scene, &scene.cameras[0].camera, &settings, &|_| ControlFlow::Continue(()));
        for pixel in &outcome.film.mean().pixels {
            for byte in pixel.to_array().into_iter().flat_map(|x| x.to_bits().to_le_bytes()) {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        }
    }
    hash
}

/// If this test fails although the sample values were meant to stay, they have changed. If they were meant to change,
/// increase [`BITS`], describe the change there and in the changelog, and replace the hashes.
#[test]
fn images_have_the_bits_of_this_version() {
    let built_in = NAMES.iter().map(|(name, _)| (*name, builtin(name).unwrap().build().unwrap()));
    let scenes = built_in.chain([("outdoors", outdoors())]);
    let found: Vec<(&str, u64)> = scenes.map(|(name, scene)| (name, hash(&scene))).collect();
    let list: String =
        found.iter().map(|(name, hash)| format!("    (\"{name}\", {hash:#018x}),\n")).collect();
    assert_eq!((BITS, found), (5, HASHES.to_vec()), "the images now have:\n{list}");
}

const HASHES: &[(&str, u64)] = &[
    ("cornell", 0x181a_7a48_2df2_aa33),
    ("cornell-spheres", 0xd52a_ed76_f19d_3f11),
    ("furnace", 0xf3bb_114f_820b_e404),
    ("outdoors", 0xca78_ea69_f916_733d),
];
