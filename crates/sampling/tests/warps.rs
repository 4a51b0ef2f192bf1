//! χ² tests of every warp and table against its density, over the sphere, the plane, a line and indices.

use dapple_sampling::{Discrete, Grid2d, warp};
use dapple_testkit::chi_square::{ChiSquare, Outcome};
use glam::{Vec2, Vec3};

/// One of the tests of this file, which together raise one false alarm in 10 000 runs.
fn test() -> ChiSquare {
    ChiSquare::family(24)
}

fn pass(name: &str, outcome: Outcome) {
    assert!(outcome.passed(), "{name}: {outcome}");
    assert!((outcome.integral - 1.0).abs() < 2e-3, "{name}: {outcome}");
}

#[test]
fn spheres_and_hemispheres() {
    let cosine = test().sphere(|u, _| Some(warp::hemisphere_cosine(u)), |w| warp::hemisphere_cosine_pdf(w.z));
    pass("cosine", cosine);
    pass("sphere", test().sphere(|u, _| Some(warp::sphere(u)), |_| warp::SPHERE_PDF));
}

#[test]
fn cones_of_any_size() {
    for one_minus_cos in [1e-14f32, 1e-6, 0.1, 1.0, 1.9] {
        let inside = |w: Vec3| {
            let w = w.as_dvec3();
            let r2 = w.x * w.x + w.y * w.y;
            let v = if w.z > 0.0 { r2 / (1.0 + w.z) } else { 1.0 - w.z };
            if v <= f64::from(one_minus_cos) { warp::cone_pdf(one_minus_cos) } else { 0.0 }
        };
        // The density is discontinuous at the edge of the cone, which usually does not coincide with a cell boundary,
        // so that the quadrature needs more regions.
        let test = ChiSquare { regions: 400, ..test() };
        pass(
            &format!("cone {one_minus_cos}"),
            test.sphere(|u, _| Some(warp::cone(u, one_minus_cos)), inside),
        );
    }
}

#[test]
fn plane_shapes() {
    let one = Vec2::ONE;
    let within = |inside: bool, pdf: f32| if inside { pdf } else { 0.0 };
    let disk = |p: Vec2| within(p.length_squared() <= 1.0, warp::DISK_PDF);
    pass("disk", test().plane(-one, one, |u, _| Some(warp::disk(u)), disk));
    pass("square", test().plane(-one, one, |u, _| Some(warp::square(u)), |_| 0.25));
    let triangle = |p: Vec2| within(p.x + p.y <= 1.0, 2.0);
    pass("triangle", test().plane(Vec2::ZERO, one, |u, _| Some(warp::triangle(u)), triangle));
    for (blades, rotation) in [(3, 0.0), (5, 0.3), (6, -2.0), (17, 9.0)] {
        // A point is inside if it is on the inner side of every edge, whose distance from the centre is cos(π/n).
        let side = std::f64::consts::TAU / f64::from(blades);
        let inside = move |p: Vec2| {
            let angle = f64::from(p.y).atan2(f64::from(p.x)) - f64::from(rotation);
            let from_middle = (angle / side).rem_euclid(1.0) * side - side / 2.0;
            f64::from(p.length()) * from_middle.cos() <= (side / 2.0).cos()
        };
        let pdf = |p: Vec2| within(inside(p), warp::polygon_pdf(blades));
        let sample = |u: Vec2, _| Some(warp::polygon(u, blades, rotation));
        pass(&format!("{blades} blades"), test().plane(-one * 1.01, one * 1.01, sample, pdf));
    }
}

#[test]
fn tents() {
    for radius in [0.5, 2.0] {
        let sample = |u| warp::tent(u, radius);
        pass("tent", test().line(-radius, radius, sample, |x| warp::tent_pdf(x, radius)));
    }
}

#[test]
fn discrete_choices_and_their_rest() {
    let weights = [1.0, 0.0, 3.0, 1e-3, 7.0, 0.0];
    let table = Discrete::new(&weights).unwrap();
    let pmf: Vec<f64> = (0..weights.len()).map(|i| f64::from(table.pmf(i))).collect();
    pass("discrete", test().indices(&pmf, |u| table.sample(u).index));
    // The rescaled u is uniform within each choice.
    for index in [0, 2, 4] {
        let sample = |u: Vec2, _| {
            let c = table.sample(u.x);
            (c.index == index).then_some(Vec2::new(c.u, u.y))
        };
        let pmf = table.pmf(index);
        let outcome = test().plane(Vec2::ZERO, Vec2::ONE, sample, |_| pmf);
        assert!(outcome.passed(), "{outcome}");
    }
}

#[test]
fn grids() {
    // 12×5 cells with weights over four decades; some cells and one row have weight 0.
    let weight = |i: usize| match (i % 12, i / 12) {
        (_, 2) | (3, _) => 0.0,
        (x, y) => ((x * 7 + y * 5) % 11) as f64 * 10f64.powi((x % 4) as i32),
    };
    let weights: Vec<f64> = (0..60).map(weight).collect();
    let grid = Grid2d::new(12, 5, &weights).unwrap();
    let sum: f64 = weights.iter().sum();
    // The expected density is computed from the weights, not from the grid.
    let pdf = |p: Vec2| {
        let cell = (p.x * 12.0).min(11.0) as usize + (p.y * 5.0).min(4.0) as usize * 12;
        (weights[cell] / sum * 60.0) as f32
    };
    let mut worst: f32 = 0.0;
    let sample = |u: Vec2, _| {
        let s = grid.sample(u);
        worst = worst.max((s.pdf / pdf(s.point) - 1.0).abs());
        Some(s.point)
    };
    pass("grid", ChiSquare { regions: 400, ..test() }.plane(Vec2::ZERO, Vec2::ONE, sample, pdf));
    assert!(worst < 1e-5, "{worst}");
}

/// Stratified u give stratified cells: with n² points, the error of a cell's count is the number of strata that its
/// border crosses, and not the square root of the count.
#[test]
fn grids_keep_strata() {
    let weights: Vec<f64> = (0..64).map(|i| 1.0 + f64::from(i * 29 % 17)).collect();
    let grid = Grid2d::new(8, 8, &weights).unwrap();
    let (n, sum) = (256u32, weights.iter().sum::<f64>());
    let mut counts = [0.0; 64];
    for i in 0..n * n {
        let cell = grid.sample((Vec2::new((i % n) as f32, (i / n) as f32) + 0.5) / n as f32).cell;
        counts[(cell.1 * 8 + cell.0) as usize] += 1.0;
    }
    for (count, weight) in counts.iter().zip(&weights) {
        let expected = weight / sum * f64::from(n * n);
        // A row border is off by at most one line of n points; a random count would be off by about 30.
        let row = f64::from(n) * (weight / weights.iter().fold(0.0f64, |m, w| m.max(*w)));
        assert!((count - expected).abs() <= row.max(f64::from(n) / 2.0), "{count} {expected}");
    }
}
