//! Stress cases C01 to C05, C12: microfacet surfaces from smooth to rough, from the normal to the horizon.

use super::{Case, Check, Effort, Outcome};
use crate::noise::Noise;
use crate::scenes::{glass, metal};
use crate::tally::Tally;
use dapple_integrator::Dimension;
use dapple_integrator::materials::{Bsdf, Lobes, Material, microfacet::Ggx};
use dapple_integrator::sampling::{Key, Moments, Pattern, point_1d, point_2d};
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "C01",
        title: "white furnace table of GGX",
        naive: "energy is created at grazing angles, or lost in the sampling",
        source: "Heitz 2014; docs/science.md, \"GGX\"",
        check: Check::Run(furnace_table),
    },
    Case {
        id: "C02",
        title: "α towards 0",
        naive: "1 − cos² in f32: D is wrong by 12 % at α = 1e-3 and by 300 % at 1e-4",
        source: "Walter 2007; docs/science.md, \"GGX\"",
        check: Check::Run(smooth_limit),
    },
    Case {
        id: "C03",
        title: "grazing view, cosine 1e-6, 0 and −0",
        naive: "0/0 in the masking function, weights above 1",
        source: "Heitz 2014; docs/science.md, \"GGX\"",
        check: Check::Run(grazing),
    },
    Case {
        id: "C04",
        title: "samples, density and value agree",
        naive: "an image with a wrong Jacobian looks plausible",
        source: "Pharr, Jakob & Humphreys 2023, §9; docs/science.md, \"GGX\"",
        check: Check::Run(consistent),
    },
    Case {
        id: "C05",
        title: "reciprocity",
        naive: "an asymmetric mix of coat and base; the missing η² of refraction",
        source: "Veach 1997, §5.2; docs/science.md, \"Clear bodies\"",
        check: Check::Run(reciprocal),
    },
    Case {
        id: "C12",
        title: "energy compensation of multiple scattering",
        naive: "rough metals are 60 % too dark",
        source: "Kulla & Conty 2017; docs/science.md, \"Compensation\"",
        check: Check::Pending("multiple-scattering compensation is not implemented: lobes scatter once"),
    },
];

/// A direction with cosine `mu` (may be negative), rotated by `phi` about z.
pub(super) fn direction(mu: f32, phi: f32) -> Vec3 {
    let s = ((1.0 - mu) * (1.0 + mu)).sqrt();
    Vec3::new(s * phi.cos(), s * phi.sin(), mu)
}

/// Mean of the samples' weights without the radiance scaling of refraction: moments over independent sets.
pub(super) fn albedo(material: &Material, wo: Vec3, points: u32, sets: u64) -> Moments {
    let bsdf = Bsdf::new(material, wo);
    let set = |seed: u64| {
        let pixel = Key::pixel(seed, 1, 2);
        let weight = |s: u32| {
            let uc = point_1d(Pattern::Sobol, s, points, pixel.at(0, Dimension::Lobe));
            let u = point_2d(Pattern::Sobol, s, points, pixel.at(0, Dimension::Direction));
            bsdf.sample_f(uc, u, Lobes::ALL).map_or(0.0, |s| f64::from(s.weight.x * s.eta))
        };
        (0..points).map(weight).sum::<f64>() / f64::from(points)
    };
    (0..sets).map(set).collect()
}

/// E(μ, α) of docs/science.md, "GGX", at μ = 1, 0.75, 0.5, 0.25, 0.1, 0.01, accurate to 5e-5.
const TABLE: [(f32, [f64; 6]); 5] = [
    (0.10, [0.98830, 0.98315, 0.96921, 0.92161, 0.88346, 0.97653]),
    (0.25, [0.91581, 0.89153, 0.85726, 0.84008, 0.89162, 0.98196]),
    (0.50, [0.68785, 0.68208, 0.69825, 0.76520, 0.86011, 0.97441]),
    (0.75, [0.46392, 0.50141, 0.56462, 0.68025, 0.81071, 0.96425]),
    (1.00, [0.306_853, 0.36453, 0.45069, 0.59764, 0.76021, 0.95385]),
];

fn furnace_table(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let sets = effort.of(8, 64, 1024);
    for (alpha, row) in TABLE {
        for (mu, exact) in [1.0f32, 0.75, 0.5, 0.25, 0.1, 0.01].into_iter().zip(row) {
            let m = albedo(&metal(alpha), direction(mu, 0.4), 4096, sets);
            let what = format!("E at α = {alpha}, μ = {mu}");
            tally.within(what, m.mean, exact, 5e-5 + 4.0 * m.standard_error());
        }
    }
    for alpha in [1e-6, 1e-4, 1e-3, 0.01, 0.1, 0.25, 0.5, 0.75, 1.0] {
        for mu in [1.0, 0.3, 0.03, 1e-3, 1e-6] {
            let m = albedo(&metal(alpha), direction(mu, 1.0), 1024, 4);
            tally.at_most(format!("energy at α = {alpha}, μ = {mu}"), m.mean, 1.0 + 1e-5);
        }
        if let Some(ggx) = Ggx::isotropic(alpha) {
            for mu in [1.0f32, 0.5, 0.1] {
                let sum = visible_normals(&ggx, direction(mu, 0.0), f64::from(alpha));
                tally.within(format!("∫ D_v dm at α = {alpha}, μ = {mu}"), sum, 1.0, 1e-3);
            }
        }
    }
    tally.finish()
}

/// ∫ G1 D (wo·m)₊/cos dm by the midpoint rule over x = tan²/(tan² + α²), which makes D·cos uniform; x = 1 − y² removes
/// the pole at the horizon.
fn visible_normals(ggx: &Ggx, wo: Vec3, alpha: f64) -> f64 {
    let (rings, sectors) = (400, 400);
    let mut sum = 0.0;
    for i in 0..rings {
        let y = (f64::from(i) + 0.5) / f64::from(rings);
        let x = 1.0 - y * y;
        let tan = alpha * (x / (1.0 - x)).sqrt();
        let cos = 1.0 / (1.0 + tan * tan).sqrt();
        for j in 0..sectors {
            let phi = TAU * (f64::from(j) + 0.5) / f64::from(sectors);
            let m = DVec3::new(tan * cos * phi.cos(), tan * cos * phi.sin(), cos).as_vec3();
            // D cos dm = dx dφ/2π.
            let exact_d = alpha * alpha / (PI * (cos * cos * (alpha * alpha + tan * tan)).powi(2));
            let over = f64::from(ggx.d(m)) / exact_d;
            let c = f64::from(wo.dot(m).max(0.0));
            sum += 2.0 * y * over * f64::from(ggx.g1(wo)) * c / (f64::from(wo.z) * cos);
        }
    }
    sum / f64::from(rings * sectors)
}

fn smooth_limit(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    // D compared with f64 inside the lobe.
    for alpha in [1.0f32, 0.1, 0.03, 1e-2, 3e-3, 1e-3] {
        let Some(ggx) = Ggx::isotropic(alpha) else { continue };
        let (mut noise, mut worst) = (Noise(41), 0.0f64);
        for _ in 0..effort.of(1_000, 50_000, 5_000_000) {
            let tan = alpha * 4.0 * noise.unit();
            let m = direction(1.0 / (1.0 + tan * tan).sqrt(), TAU as f32 * noise.unit());
            let m = Vec3::new(m.x, m.y, 0.0) + Vec3::Z * m.z;
            let (a, d) = (f64::from(alpha), m.as_dvec3());
            let sum = (d.x * d.x + d.y * d.y) / (a * a) + d.z * d.z;
            let exact = 1.0 / (PI * a * a * sum * sum);
            worst = worst.max((f64::from(ggx.d(m)) / exact - 1.0).abs());
        }
        tally.within(format!("relative error of D at α = {alpha}"), worst, 0.0, 2e-6);
    }
    // A step in the environment 0.2 rad from the mirror direction: as α → 0, the result approaches that of a mirror.
    for alpha in [1e-1f32, 3e-2, 1e-2, 3e-3, 1.1e-3, 9e-4, 1e-6] {
        let wo = direction(0.8, 0.0);
        let mirrored = Vec3::new(-wo.x, -wo.y, wo.z);
        let bsdf = Bsdf::new(&metal(alpha), wo);
        let (mut noise, mut lit) = (Noise(43), Moments::default());
        for _ in 0..effort.of(2_000, 100_000, 10_000_000) {
            let s = bsdf.sample_f(noise.unit(), noise.point(), Lobes::ALL);
            lit.add(s.map_or(0.0, |s| if s.wi.dot(mirrored) > 0.98 { f64::from(s.weight.x) } else { 0.0 }));
        }
        // Along the normal the part beyond 2δ is α²/(α² + tan²δ) ≤ α/2δ; the lobe is 1/μ times as wide at μ.
        let most = 1.0 / (2.0 * 0.1 * 0.8);
        tally.at_most(format!("|L(α) − L(0)|/α at α = {alpha}"), (1.0 - lit.mean) / f64::from(alpha), most);
    }
    tally.finish()
}

fn grazing(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let mut noise = Noise(47);
    for alpha in [1e-6, 1e-3, 0.01, 0.1, 0.5, 1.0] {
        for base in [metal(alpha), Material { metallic: 0.0, ..metal(alpha) }, glass(1.5, alpha.sqrt())] {
            let (mut bad, mut most, mut unsure) = (0u64, 0.0f64, 0u64);
            for z in [1e-3f32, 1e-6, 1e-12, 1e-30, 0.0, -0.0, -1e-6] {
                let wo = Vec3::new((1.0 - z * z).sqrt(), 0.0, z);
                let bsdf = Bsdf::new(&base, wo);
                for _ in 0..effort.of(100, 5_000, 200_000) {
                    let wi = noise.direction();
                    let (f, pdf) = bsdf.eval(wi, Lobes::ALL);
                    bad += u64::from(
                        !(f.is_finite() && pdf.is_finite() && pdf >= 0.0 && f.min_element() >= 0.0),
                    );
                    unsure += u64::from(f.max_element() > 0.0 && pdf <= 0.0);
                    if let Some(s) = bsdf.sample_f(noise.unit(), noise.point(), Lobes::ALL) {
                        bad += u64::from(!(s.weight.is_finite() && s.wi.is_finite() && s.pdf > 0.0));
                        most = most.max(f64::from(s.weight.max_element() * s.eta));
                    }
                }
            }
            let what = format!("α = {alpha}, metallic {}, transmission {}", base.metallic, base.transmission);
            tally.none(format!("not finite or negative: {what}"), bad);
            tally.none(format!("value without density: {what}"), unsure);
            // The weight of a single lobe is F·G2/G1; that of a mixture may be larger, but has no pole.
            tally.at_most(
                format!("largest weight: {what}"),
                most,
                if base.metallic == 1.0 { 1.0 + 1e-5 } else { 20.0 },
            );
        }
    }
    tally.finish()
}

/// The materials that are compared, with their names.
fn materials(roughness: f32) -> Vec<(&'static str, Material)> {
    let metal = Material { base_color: Vec3::new(1.0, 0.8, 0.4), roughness, ..Material::default() };
    let plastic = Material { metallic: 0.0, ..metal };
    let clear = glass(1.5, roughness);
    vec![
        ("metal", metal),
        ("plastic", plastic),
        ("glass", clear),
        ("glass of index 2.4", Material { ior: 2.4, ..clear }),
        ("pane", Material { thin: true, ..clear }),
        ("everything", Material { metallic: 0.3, transmission: 0.5, ..metal }),
    ]
}

/// Number of cells of the sphere, uniform in polar angle and azimuth.
const CELLS: [usize; 2] = [16, 32];

fn cell(w: Vec3) -> usize {
    let z = f64::from(w.z).clamp(-1.0, 1.0).acos() / PI * CELLS[0] as f64;
    let phi = (f64::from(w.y).atan2(f64::from(w.x)) / TAU + 0.5) * CELLS[1] as f64;
    (z as usize).min(CELLS[0] - 1) * CELLS[1] + (phi as usize).min(CELLS[1] - 1)
}

/// ∫ pdf over each cell to `tolerance`, with adaptive subdivision where two rules disagree. Densities have a step where
/// a facet turns away, and a fixed grid would treat the error there as agreement.
fn expected(bsdf: &Bsdf, tolerance: f64) -> Vec<f64> {
    let [rows, columns] = CELLS;
    let density = |a: f64, b: f64| {
        let ((s, z), phi) = ((PI * a / rows as f64).sin_cos(), TAU * (b / columns as f64 - 0.5));
        f64::from(bsdf.pdf(DVec3::new(s * phi.cos(), s * phi.sin(), z).as_vec3(), Lobes::ALL)) * s
    };
    let area = 2.0 * PI * PI / (rows * columns) as f64;
    let cells = (0..rows).flat_map(|i| (0..columns).map(move |j| (i as f64, j as f64)));
    cells.map(|(i, j)| halving(&density, (i, j), 1.0, tolerance / area, 0) * area).collect()
}

/// ∫ over the square at `corner` by Simpson's rule, or over its quarters if their sum differs. The rule samples the
/// corners, so that a step through the square has points on both sides. The tolerance is halved with every halving of
/// the side, because the number of pieces along a curve doubles.
fn halving(f: &impl Fn(f64, f64) -> f64, corner: (f64, f64), side: f64, tolerance: f64, depth: u32) -> f64 {
    let quarters = [(0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5)]
        .map(|(a, b)| (corner.0 + a * side, corner.1 + b * side));
    let fine: f64 = quarters.iter().map(|&c| simpson(f, c, 0.5 * side)).sum();
    let settled = depth >= 1 && (simpson(f, corner, side) - fine).abs() < tolerance;
    if settled || depth == DEEPEST {
        return fine;
    }
    quarters.iter().map(|&c| halving(f, c, 0.5 * side, 0.5 * tolerance, depth + 1)).sum()
}

/// Maximum depth of subdivision.
const DEEPEST: u32 = 9;

fn simpson(f: &impl Fn(f64, f64) -> f64, (x, y): (f64, f64), side: f64) -> f64 {
    let rule = [(0.0, 1.0 / 6.0), (0.5, 2.0 / 3.0), (1.0, 1.0 / 6.0)];
    let column = |a: f64| rule.iter().map(|&(b, w)| w * f(x + a * side, y + b * side)).sum::<f64>();
    side * side * rule.iter().map(|&(a, w)| w * column(a)).sum::<f64>()
}

fn consistent(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let n = effort.of(20_000u32, 100_000, 2_000_000);
    for roughness in [0.5f32, 0.7, 1.0] {
        for (name, material) in materials(roughness) {
            for mu in [1.0f32, 0.5, 0.1, -0.3] {
                let wo = direction(mu, 0.7);
                let bsdf = Bsdf::new(&material, wo);
                let what = format!("{name}, roughness {roughness}, μ = {mu}");
                let (mut noise, mut counts) =
                    (Noise(u64::from(mu.to_bits())), vec![0u32; CELLS[0] * CELLS[1]]);
                let (mut apart, mut at_edge, mut none) = (0.0f64, 0.0f64, 0u64);
                for _ in 0..n {
                    let Some(s) = bsdf.sample_f(noise.unit(), noise.point(), Lobes::ALL) else { continue };
                    counts[cell(s.wi)] += 1;
                    let (f, pdf) = bsdf.eval(s.wi, Lobes::ALL);
                    none += u64::from(pdf <= 0.0);
                    let quotient = f * s.wi.z.abs() / pdf;
                    let scale = s.weight.max_element().max(1e-3);
                    let off =
                        (pdf / s.pdf - 1.0).abs().max((quotient - s.weight).abs().max_element() / scale);
                    let worst = if is_at_edge(&material, wo, s.wi) { &mut at_edge } else { &mut apart };
                    *worst = worst.max(f64::from(off));
                }
                tally.none(format!("samples without density: {what}"), none);
                tally.within(format!("f·cos/pdf against the weight: {what}"), apart, 0.0, 1e-4);
                tally.within(format!("the same near the critical angle: {what}"), at_edge, 0.0, 5e-3);
                // A tenth of the standard deviation of the counts in the rarest cells.
                let z = chi(&counts, &expected(&bsdf, 0.3 / f64::from(n)), f64::from(n));
                tally.within(format!("(χ² − k)/√2k: {what}"), z, 0.0, 5.0);
            }
        }
    }
    tally.finish()
}

/// Whether the facet between the two directions is near the critical angle: F has a vertical tangent there, so that a
/// rounding of the direction by 2⁻²⁴ changes F by up to 2⁻¹² times its slope.
fn is_at_edge(material: &Material, wo: Vec3, wi: Vec3) -> bool {
    let eta = f64::from(if wo.z > 0.0 { material.ior } else { 1.0 / material.ior });
    let (a, b) = (wo.as_dvec3(), wi.as_dvec3());
    let facet = if a.z * b.z > 0.0 { a + b } else { a + b * eta };
    let cosine = a.dot(facet.normalize());
    (1.0 - (1.0 - cosine * cosine) / (eta * eta)).abs() < 0.02
}

/// (χ² − k)/√2k over the cells, with rare cells merged. The last cell contains the rejected samples.
fn chi(counts: &[u32], expected: &[f64], n: f64) -> f64 {
    let drawn: u32 = counts.iter().sum();
    let mass: f64 = expected.iter().sum();
    let rejected = (n - f64::from(drawn), (1.0 - mass) * n);
    let mut rest = [0.0; 2];
    let (mut sum, mut cells) = (0.0, 0.0);
    let pairs = counts.iter().zip(expected).map(|(c, e)| (f64::from(*c), e * n)).chain([rejected]);
    for (count, expected) in pairs {
        if expected < 10.0 {
            rest = [rest[0] + count, rest[1] + expected.max(0.0)];
        } else {
            sum += (count - expected).powi(2) / expected;
            cells += 1.0;
        }
    }
    if rest[1] >= 10.0 {
        sum += (rest[0] - rest[1]).powi(2) / rest[1];
        cells += 1.0;
    }
    let k = (cells - 1.0f64).max(1.0);
    (sum - k) / (2.0 * k).sqrt()
}

fn reciprocal(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for roughness in [0.1f32, 0.4, 0.7, 1.0] {
        for (name, material) in materials(roughness) {
            let (mut noise, mut worst, mut one) = (Noise(53), 0.0f64, 0u64);
            for _ in 0..effort.of(1_000, 30_000, 1_000_000) {
                let (a, b) = (noise.direction(), noise.direction());
                if a.z.abs().min(b.z.abs()) < 0.02 {
                    continue;
                }
                let ab = Bsdf::new(&material, a).f(b, Lobes::ALL).as_dvec3();
                let ba = Bsdf::new(&material, b).f(a, Lobes::ALL).as_dvec3();
                let eta = |w: Vec3| if w.z > 0.0 || material.thin { 1.0 } else { f64::from(material.ior) };
                let (left, right) = (ab * eta(b).powi(2), ba * eta(a).powi(2));
                let size = left.max_element().max(right.max_element());
                if size > 1e-6 {
                    worst = worst.max((left - right).abs().max_element() / size);
                }
                one += u64::from((left.max_element() > 1e-6) != (right.max_element() > 1e-6) && size > 1e-4);
            }
            tally.none(format!("light in one direction only: {name}, roughness {roughness}"), one);
            tally.within(format!("f(a, b) against f(b, a): {name}, roughness {roughness}"), worst, 0.0, 1e-3);
        }
    }
    tally.finish()
}
