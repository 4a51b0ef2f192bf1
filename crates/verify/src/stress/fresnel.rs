//! Stress cases C09, C10: Fresnel reflection at smooth interfaces, compared with f64 and with exact averages.

use super::bsdf::exact_fresnel;
use super::gloss::albedo;
use super::{Case, Check, Effort, Outcome};
use crate::closed_form::diffuse_fresnel;
use crate::scenes::glass;
use crate::tally::Tally;
use dapple_integrator::materials::{Bsdf, Lobes, Material, fresnel};
use glam::{Vec2, Vec3};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "C09",
        title: "critical angle of total internal reflection",
        naive: "the square root of a small negative number: a ring of NaN pixels",
        source: "docs/science.md, \"Fresnel\"",
        check: Check::Run(edge),
    },
    Case {
        id: "C10",
        title: "exact averages of Fresnel's law",
        naive: "Schlick's approximation in place of Fresnel's law",
        source: "Walsh 1926; docs/science.md, \"Fresnel\"",
        check: Check::Run(averages),
    },
];

fn edge(_: Effort) -> Outcome {
    let mut tally = Tally::default();
    for ior in [1.01f32, 1.5, 2.4] {
        let eta = 1.0 / ior;
        // sin θ within a few ulp of 1/n, from inside.
        let critical = f64::from(eta).asin().cos() as f32;
        let mut last = 1.0f32;
        let mut c = critical;
        for _ in 0..200 {
            c = c.next_down();
        }
        for step in -200..=200 {
            let f = fresnel::dielectric(c, eta);
            let what = format!("n = {ior}, {step} ulp from the critical angle");
            tally.holds(format!("{what}: 0 ≤ F ≤ 1"), (0.0..=1.0).contains(&f));
            tally.holds(format!("{what}: F falls"), f <= last + 1e-6);
            // F behaves as a square root: f32 resolves the angle to one ulp, and hence F only to the root of that.
            tally.within(
                format!("{what}: F"),
                f64::from(f),
                exact_fresnel(f64::from(c), f64::from(eta)),
                2e-3,
            );
            last = f;
            c = c.next_up();
            let wo = Vec3::new((1.0 - c * c).sqrt(), 0.0, -c);
            let s = Bsdf::new(&glass(ior, 0.0), wo).sample_f(0.999_999, Vec2::splat(0.5), Lobes::ALL);
            tally.holds(
                format!("{what}: a finite direction"),
                s.is_some_and(|s| s.wi.is_finite() && s.weight.is_finite()),
            );
        }
    }
    tally.finish()
}

/// Cosine-weighted mean of F over a hemisphere: x = cos² is uniform.
fn mean(eta: f32, n: u32) -> f64 {
    let at =
        |i: u32| f64::from(fresnel::dielectric(((f64::from(i) + 0.5) / f64::from(n)).sqrt() as f32, eta));
    (0..n).map(at).sum::<f64>() / f64::from(n)
}

fn averages(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let n = effort.of(100_000, 4_000_000, 100_000_000);
    for ior in [1.1f32, 1.5, 2.4] {
        let outside = diffuse_fresnel(f64::from(ior));
        tally.within(format!("from outside, n = {ior}"), mean(ior, n), outside, 2e-6);
        let inside = 1.0 - (1.0 - outside) / f64::from(ior).powi(2);
        tally.within(format!("from inside, n = {ior}"), mean(1.0 / ior, n), inside, 2e-5);
    }
    // Both interfaces of a pane: R = 2F/(1 + F), T = (1 − F)/(1 + F).
    let pane = Material { thin: true, ..glass(1.5, 0.0) };
    let through: f64 = (0..10_000)
        .filter_map(|i| {
            Bsdf::new(&pane, Vec3::Z).sample_f((i as f32 + 0.5) / 10_000.0, Vec2::splat(0.5), Lobes::ALL)
        })
        .map(|s| if s.lobe.is_transmission() { f64::from(s.weight.x) / 10_000.0 } else { 0.0 })
        .sum();
    tally.within("transmittance of a pane along its normal", through, 0.923_077, 1e-4);
    tally.within("a pane conserves energy", albedo(&pane, Vec3::Z, 1024, 4).mean, 1.0, 1e-5);
    tally.finish()
}
