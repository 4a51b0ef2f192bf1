//! Camera rays of narrow, wide and large images, and of thin lenses of moderate and extreme sizes.
use dapple_camera::{Aperture, Camera, Lens, Projection};
use dapple_testkit::{Rng, chi_square::ChiSquare};
use glam::{DVec3, Vec2, Vec3};

fn camera(projection: Projection, lens: Option<Lens>) -> Camera {
    Camera {
        origin: Vec3::ZERO,
        right: Vec3::X,
        up: Vec3::Y,
        backward: Vec3::Z,
        projection,
        lens,
        motion: None,
        aspect: None,
        clip: None,
    }
}

fn perspective(yfov_degrees: f64) -> Projection {
    Projection::Perspective { tan_half: (0.5 * yfov_degrees.to_radians()).tan() as f32 }
}

/// 1000 rows over 0.001° are 1.7e-8 rad each. A camera aligned with the axes resolves them, although unit vectors in
/// f32 do not in general.
#[test]
fn a_thousandth_of_a_degree_keeps_every_row() {
    let c = camera(perspective(0.001), None);
    let rows = 1000u32;
    let slope = |y: u32| {
        let d = c.ray((500, y), Vec2::splat(0.5), (rows, rows), Vec2::ZERO).d.as_dvec3();
        d.y / -d.z
    };
    let step = 2.0 * (0.5 * 0.001f64.to_radians()).tan() / rows as f64;
    for y in 1..rows {
        let got = slope(y - 1) - slope(y);
        assert!((got / step - 1.0).abs() < 0.01, "row {y}: {got:e} {step:e}");
    }
    let edge = slope(0) + 0.5 * step;
    assert!((edge / (0.5 * 0.001f64.to_radians()).tan() - 1.0).abs() < 1e-5);
}

/// The directions of an image of 179.9° cover the exact solid angle, integrated as dω/dA over the film.
#[test]
fn nearly_a_half_turn_fills_its_solid_angle() {
    let t = (0.5 * 179.9f64.to_radians()).tan();
    let exact = 4.0 * (t * t / (1.0 + t * t)).asin();
    let c = camera(perspective(179.9), None);
    // dω = cos³θ dA on the film plane at distance 1. It has a peak in the middle, which is therefore sampled finely.
    let solid_angle = |pixel: (u32, u32), size: u32, n: u32| {
        let mut sum = 0.0;
        for i in 0..n * n {
            let f = (Vec2::new((i % n) as f32, (i / n) as f32) + 0.5) / n as f32;
            let d = c.ray(pixel, f, (size, size), Vec2::ZERO).d.as_dvec3();
            assert!(d.is_finite() && (d.length() - 1.0).abs() < 1e-6 && d.z < 0.0);
            sum += (-d.z).powi(3);
        }
        sum / (n * n) as f64 * (2.0 * t / size as f64).powi(2)
    };
    let size = 128u32;
    let mut sum = 0.0;
    for y in 0..size {
        for x in 0..size {
            let middle = x.abs_diff(size / 2).max(y.abs_diff(size / 2)) < 3;
            sum += solid_angle((x, y), size, if middle { 400 } else { 8 });
        }
    }
    assert!((sum / exact - 1.0).abs() < 1e-3, "{sum} {exact}");
}

/// Pixel 16383 of an image resolves 2²⁰ or more positions within it: the fraction can be recovered from the direction
/// and the pixel.
#[test]
fn large_pictures_keep_their_jitter() {
    let c = camera(perspective(0.1), None);
    let size = (16384u32, 16384u32);
    let scale = 2.0 * (0.5 * 0.1f64.to_radians()).tan() / size.1 as f64;
    let mut rng = Rng::new(1);
    let mut histogram = [0u32; 64];
    let (n, mut worst) = (100_000, 0f64);
    for _ in 0..n {
        let f = rng.vec2();
        let d = c.ray((16383, 16383), f, size, Vec2::ZERO).d.as_dvec3();
        let x = d.x / -d.z / scale - 8191.0;
        worst = worst.max((x - f.x as f64).abs());
        histogram[((x * 64.0) as usize).min(63)] += 1;
    }
    assert!(worst < 1e-3, "{worst:e}");
    let expected = n as f64 / 64.0;
    let chi2: f64 = histogram.iter().map(|h| (*h as f64 - expected).powi(2) / expected).sum();
    assert!(chi2 < 130.0, "63 degrees of freedom: {chi2}");
}

fn shapes() -> [Aperture; 4] {
    let blades = |n, rotation| Aperture::Blades { n, rotation };
    [Aperture::Disk, Aperture::Square, blades(6, 0.3), blades(3, 0.0)]
}

/// All rays of one film point meet at one point of the plane in focus, for every aperture and projection.
#[test]
fn the_plane_in_focus_is_sharp() {
    let mut rng = Rng::new(2);
    for projection in [perspective(50.0), Projection::Orthographic { half_height: 2.0 }] {
        for aperture in shapes() {
            for radius in [1e-9f32, 0.1, 1e3] {
                for focus_distance in [1e-3f32, 1.0, 1e9] {
                    let lens = Lens { aperture, radius, focus_distance };
                    let (c, pinhole) = (camera(projection, Some(lens)), camera(projection, None));
                    for _ in 0..50 {
                        let f = rng.vec2();
                        let meet = |c: &Camera, u: Vec2| -> DVec3 {
                            let ray = c.ray((13, 40), f, (100, 60), u);
                            assert!(ray.d.is_finite() && (ray.d.length() - 1.0).abs() < 1e-6);
                            let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
                            o + d * (-focus_distance as f64 - o.z) / d.z
                        };
                        let (a, b) = (meet(&c, rng.vec2()), meet(&pinhole, Vec2::ZERO));
                        // Directions are rounded to 2⁻²⁴, and a slope of radius/focus amplifies the error.
                        let slant = 1.0 + (radius / focus_distance) as f64;
                        let tolerance = 4e-7 * (focus_distance as f64 * slant * slant + radius as f64 + 2.0);
                        assert!((a - b).length() < tolerance, "{lens:?}: {a} {b}");
                    }
                }
            }
        }
    }
}

#[test]
fn focus_at_infinity_keeps_directions() {
    let lens = |focus_distance| Some(Lens { aperture: Aperture::Disk, radius: 0.5, focus_distance });
    let (far, pinhole) = (camera(perspective(40.0), lens(f32::INFINITY)), camera(perspective(40.0), None));
    let mut rng = Rng::new(3);
    for _ in 0..1000 {
        let (f, u) = (rng.vec2(), rng.vec2());
        let (a, b) = (far.ray((3, 4), f, (10, 10), u), pinhole.ray((3, 4), f, (10, 10), u));
        assert_eq!(a.d.to_array().map(f32::to_bits), b.d.to_array().map(f32::to_bits));
        assert!(a.o.length() <= 0.5 + 1e-6);
    }
    for focus in [0.0, -1.0, f32::NAN] {
        let ray = camera(perspective(40.0), lens(focus)).ray((3, 4), Vec2::ZERO, (10, 10), Vec2::splat(0.3));
        assert!(ray.d.is_finite() && ray.o.is_finite());
    }
}

/// Apertures are sampled uniformly, with density 1/area.
#[test]
fn apertures_are_even() {
    let test = ChiSquare { regions: 2000, ..ChiSquare::family(2) };
    for aperture in [Aperture::Disk, Aperture::Square] {
        let lens = Lens { aperture, radius: 2.0, focus_distance: 1.0 };
        let inside = |p: Vec2| aperture == Aperture::Square || p.length() <= 2.0;
        let density = 1.0 / lens.area() as f32;
        let result = test.plane(
            Vec2::splat(-2.0),
            Vec2::splat(2.0),
            |u, _| Some(lens.point(u)),
            |p| if inside(p) { density } else { 0.0 },
        );
        assert!(result.passed(), "{aperture:?}: {result}");
    }
    // No point of a polygon is outside of an edge, and each of 2n sectors gets its expected share.
    for (n, rotation) in [(3u32, 0.0f32), (6, 0.3), (5, -1.0)] {
        let lens = Lens { aperture: Aperture::Blades { n, rotation }, radius: 1.0, focus_distance: 1.0 };
        let apothem = (std::f64::consts::PI / n as f64).cos();
        let sector = std::f64::consts::TAU / n as f64;
        let mut rng = Rng::new(4);
        let (mut counts, mut inner) = (vec![0f64; 2 * n as usize], 0.0);
        let total = 120_000;
        for _ in 0..total {
            let p = lens.point(rng.vec2()).as_dvec2();
            let angle = (p.y.atan2(p.x) - rotation as f64).rem_euclid(std::f64::consts::TAU);
            let to_edge = p.length() * (angle.rem_euclid(sector) - 0.5 * sector).cos();
            assert!(to_edge <= apothem + 1e-6);
            counts[((angle / sector * 2.0) as usize).min(2 * n as usize - 1)] += 1.0;
            inner += f64::from(to_edge <= apothem / 2f64.sqrt());
        }
        let deviation =
            |count: f64, share: f64| (count - share * total as f64).abs() / (share * total as f64).sqrt();
        assert!(counts.iter().all(|c| deviation(*c, 0.5 / n as f64) < 4.5), "{counts:?}");
        assert!(deviation(inner, 0.5) < 4.0, "half of the area within 1/√2 of the apothem: {inner}");
        assert!((lens.area() - n as f64 * apothem * (1.0 - apothem * apothem).sqrt()).abs() < 1e-12);
    }
}
