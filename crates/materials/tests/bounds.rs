//! Bounds of lobes: no BSDF has a lobe outside the bounds of its material, and every lobe in the bounds occurs in some
//! BSDF.

use dapple_materials::{Bsdf, Lobe, Lobes, Material, Mirror, Varying};
use glam::Vec3;

const COSINES: [f32; 8] = [1.0, 0.5, 0.03, 1e-6, -1.0, -0.5, -0.03, -1e-6];

/// Lobes over all directions.
fn lobes(material: &Material) -> Lobes {
    let of = |mu: f32| Bsdf::new(material, Vec3::new((1.0 - mu * mu).sqrt(), 0.0, mu)).lobes();
    COSINES.into_iter().map(of).fold(Lobes::NONE, |all, lobes| Lobes(all.0 | lobes.0))
}

/// Visits every combination of these parameters, and mirrors.
fn sweep(mut visit: impl FnMut(&Material)) {
    let shares = [0.0, 1e-3, 0.5, 1.0];
    let indices = [0.0, 0.5, 0.9999, 0.99995, 1.0, 1.00005, 1.0001, 1.00015, 1.0003, 1.5, f32::NAN];
    for (metallic, transmission) in shares.into_iter().flat_map(|m| shares.map(|t| (m, t))) {
        for (specular, ior) in [0.0, 0.5, 1.0].into_iter().flat_map(|s| indices.map(|i| (s, i))) {
            for roughness in [0.0, 0.031, 0.032, 0.4, 1.0] {
                for (thin, base_color) in [(true, Vec3::ONE), (false, Vec3::X), (true, Vec3::ZERO)] {
                    let shape = Material { thin, base_color, specular, ior, ..Material::default() };
                    visit(&Material { metallic, transmission, roughness, ..shape });
                }
            }
        }
    }
    for (kr, blur) in [Vec3::ZERO, Vec3::X].into_iter().flat_map(|k| [0.0, 1e-5, 1e-4, 2.0].map(|b| (k, b))) {
        visit(&Material { mirror: Some(Mirror { kr, blur }), ..Material::default() });
    }
}

#[track_caller]
fn assert_inside(part: &Material, whole: &Material, varying: Varying) {
    let (has, bounds) = (lobes(part), whole.lobe_bounds(varying));
    assert!(has.without(bounds).is_empty(), "{part:?} has {has:?}, {whole:?} {varying:?} allows {bounds:?}");
}

#[test]
fn every_bsdf_lies_inside_the_bounds() {
    sweep(|material| assert_inside(material, material, Varying::NOTHING));
}

/// Textures scale a factor by anything from 0 to 1; touching bodies result in any index.
#[test]
fn what_varies_lies_inside_the_bounds() {
    sweep(|whole| {
        for share in [0.0, 0.05, 0.5, 1.0] {
            let part = Material { metallic: whole.metallic * share, roughness: whole.roughness, ..*whole };
            let varying = Varying { metallic_roughness: true, ..Varying::NOTHING };
            assert_inside(&part, whole, varying);
            assert_inside(&Material { roughness: whole.roughness * share, ..part }, whole, varying);
            let part = Material { transmission: whole.transmission * share, ..*whole };
            assert_inside(&part, whole, Varying { transmission: true, ..Varying::NOTHING });
        }
        for ior in [0.0, 0.7, 1.0, 1.3].into_iter().filter(|_| !whole.thin) {
            let varying = Varying { ior: true, ..Varying::NOTHING };
            assert_inside(&Material { ior, ..*whole }, whole, varying);
        }
    });
}

/// Loose bounds would be of no use: away from equal indices the bounds are exactly the lobes of the BSDFs.
#[test]
fn bounds_of_plain_materials_are_exact() {
    let mut count = 0;
    sweep(|material| {
        let is_plain = material.ior == 1.5 && material.base_color == Vec3::ONE || material.mirror.is_some();
        if is_plain {
            count += 1;
            assert_eq!(material.lobe_bounds(Varying::NOTHING), lobes(material), "{material:?}");
        }
    });
    assert!(count > 200);
}

#[test]
fn sharpened_sets_are_those_of_sharpened_bsdfs() {
    let which = [Lobes::ALL, Lobes::TRANSMISSION, Lobes::of(Lobe::GlossyReflection), Lobes::NONE];
    sweep(|material| {
        let bsdf = Bsdf::new(material, Vec3::new(0.6, 0.0, 0.8));
        for which in which {
            assert_eq!(bsdf.sharp(which).lobes(), bsdf.lobes().sharpened(which), "{material:?} {which:?}");
        }
    });
}
