//! Surfaces from the records of triangles have the bits of [`Accel::surface`], with every instruction set.

mod solids;

use dapple_geometry::{Accel, AccelBuilder, Facets, Hit, Mesh, Opaque};
use dapple_math::Ray;
use dapple_math::lanes::{Isa, Kernel, Mask, Real, Vec3x, Word, dispatch};
use glam::{DAffine3, DVec3, Vec3};
use solids::{Noise, cube, sphere};

/// Direction that surfaces are seen from.
const VIEW: Vec3 = Vec3::new(0.36, 0.48, 0.8);

/// Surfaces of hits: whether they are known, and their numbers.
struct Look<'a>(&'a Facets, &'a [Hit]);

impl Kernel for Look<'_> {
    type Output = Vec<(bool, [Vec3; 6])>;
    fn run<R: Real>(self) -> Self::Output {
        self.1.chunks(R::LANES).flat_map(|hits| look::<R>(self.0, hits)).collect()
    }
}

fn look<R: Real>(facets: &Facets, hits: &[Hit]) -> Vec<(bool, [Vec3; 6])> {
    let words = |of: fn(&Hit) -> u32| R::Word::load(&hits.iter().map(of).collect::<Vec<_>>());
    let numbers = |of: fn(&Hit) -> f32| R::load(&hits.iter().map(of).collect::<Vec<_>>());
    let ids = (words(|hit| hit.object), words(|hit| hit.primitive));
    let at = (numbers(|hit| hit.u), numbers(|hit| hit.v));
    let s = facets.surfaces::<R>(ids, at, Vec3x::splat(VIEW));
    let vectors = [s.p, s.start, s.p_error, s.ng, s.ns, s.lift].map(stored::<R>);
    let known = s.known.bitmask();
    (0..hits.len()).map(|i| (known >> i & 1 == 1, vectors.map(|v| v[i]))).collect()
}

fn stored<R: Real>(v: Vec3x<R>) -> [Vec3; 16] {
    let (mut x, mut y, mut z) = ([0.0; 16], [0.0; 16], [0.0; 16]);
    v.store([&mut x, &mut y, &mut z]);
    std::array::from_fn(|i| Vec3::new(x[i], y[i], z[i]))
}

/// Compares the surfaces of hits; returns the number of known ones.
fn check(accel: &Accel, hits: &[Hit]) -> usize {
    let facets = accel.facets();
    let ray = Ray::new(Vec3::ZERO, Vec3::X);
    let mut count = 0;
    for isa in Isa::available() {
        let found = dispatch(isa, Look(facets, hits));
        for (hit, (_, vectors)) in hits.iter().zip(&found).filter(|(_, (known, _))| *known) {
            let s = accel.surface(&ray, 0.0, hit);
            let bits = |v: Vec3| v.to_array().map(f32::to_bits);
            let lift = accel.lift(hit, s.ng * 1f32.copysign(s.ng.dot(VIEW)), 0.0);
            let expected = [s.p, s.start, s.p_error, s.ng, s.ns, lift].map(bits);
            assert_eq!(vectors.map(bits), expected, "{hit:?} {s:?} {isa:?}");
        }
        count = found.iter().filter(|(known, _)| *known).count();
    }
    count
}

fn accel_of(mesh: Mesh) -> Accel {
    let mut builder = AccelBuilder::default();
    builder.add_mesh(mesh);
    builder.build()
}

/// Hits of random rays towards `centre`.
fn hits(accel: &Accel, centre: Vec3, r: f32) -> Vec<Hit> {
    let mut noise = Noise(3);
    let ray = |noise: &mut Noise| {
        let d = noise.direction();
        Ray::new(centre + noise.vec() * (0.6 * r) - d * (4.0 * r), d)
    };
    (0..4000).filter_map(|_| accel.intersect(&ray(&mut noise), 0.0, &Opaque)).collect()
}

/// Points near and on the edges of a triangle, and in it.
fn points(triangles: u32) -> Vec<Hit> {
    let mut noise = Noise(7);
    let mut all = Vec::new();
    for primitive in 0..triangles {
        for k in 0..60 {
            let small = 2f32.powi(-k);
            let x = noise.vec().abs() * 0.3;
            for (u, v) in [(x.x, x.y), (small, x.y), (x.x, small), (x.x, 1.0 - x.x - small), (small, small)] {
                all.push(Hit { t: 1.0, u, v, primitive, object: 0 });
            }
        }
    }
    all
}

/// A mesh whose triangles have corners and, where asked for, normals of their own.
fn soup(corners: &[[Vec3; 3]], normals: Option<&[[Vec3; 3]]>) -> Mesh {
    Mesh {
        positions: corners.concat(),
        triangles: (0..corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        normals: normals.map(<[_]>::concat).unwrap_or_default(),
        ..Mesh::default()
    }
}

#[test]
fn surfaces_of_solids_are_those_of_single_hits() {
    for (r, shift) in [(1e-3, 0.0), (1.0, 0.0), (1.0, 100.0), (1e3, 1e5)] {
        let centre = Vec3::new(shift, -shift, 0.5 * shift);
        for solid in [cube(r, centre), sphere(2, r, centre)] {
            let mesh = Mesh { normals: vec![], ..solid };
            let accel = accel_of(mesh);
            let hits = hits(&accel, centre, r);
            let known = check(&accel, &hits);
            assert!(known * 10 > hits.len() * 9, "{r} {shift}: {known} of {}", hits.len());
        }
    }
}

#[test]
fn triangles_of_any_shape_and_points_near_edges_are_those_of_single_hits() {
    let mut noise = Noise(1);
    let mut triangle = |i: u32| {
        let (at, size) = (noise.vec() * 10f32.powi(i as i32 % 5), 10f32.powi(i as i32 % 7 - 4));
        let (a, b) = (at + noise.vec() * size, at + noise.vec() * size);
        let is_thin = i.is_multiple_of(3);
        let along = if is_thin { (b - a) * noise.vec().x } else { noise.vec() * size };
        let thin = if is_thin { noise.vec() * (size * 1e-5) } else { Vec3::ZERO };
        [a, b, a + along + thin]
    };
    let corners: Vec<[Vec3; 3]> = (0..300).map(&mut triangle).collect();
    let accel = accel_of(soup(&corners, None));
    let points = points(300);
    let known = check(&accel, &points);
    // Many of these points are near edges, and many triangles are thin or tiny beside their coordinates.
    assert!(known * 10 > points.len() && known * 10 < points.len() * 9, "{known} of {}", points.len());
}

#[test]
fn normals_are_known_if_they_are_one_or_unit_vectors() {
    let mut noise = Noise(5);
    let mut three = || [noise.direction(), noise.direction(), noise.direction()];
    let corners: Vec<[Vec3; 3]> = (0..200).map(|_| three().map(|v| v * 3.0)).collect();
    let several: Vec<[Vec3; 3]> = (0..200).map(|_| three()).collect();
    // Close to the normal of the triangle, so that the normals span a surface above it.
    let round = |[a, b, c]: [Vec3; 3], bent: [Vec3; 3]| {
        let n = (b - a).cross(c - a).normalize();
        bent.map(|bend| (n + bend * 0.3).normalize())
    };
    let round: Vec<[Vec3; 3]> = corners.iter().zip(&several).map(|(t, bent)| round(*t, *bent)).collect();
    let scaled: Vec<[Vec3; 3]> = several.iter().map(|n| n.map(|n| n * 1.1)).collect();
    let same: Vec<[Vec3; 3]> = scaled.iter().map(|[a, ..]| [*a; 3]).collect();
    let signs = vec![[Vec3::new(0.0, 0.6, 0.8), Vec3::new(-0.0, 0.6, 0.8), Vec3::new(0.0, 0.6, 0.8)]; 200];
    let inner: Vec<Hit> =
        points(200).into_iter().filter(|hit| hit.u.min(hit.v).min(1.0 - hit.u - hit.v) > 0.01).collect();
    for normals in [several, round, same, signs] {
        let known = check(&accel_of(soup(&corners, Some(&normals))), &inner);
        assert!(known * 10 > inner.len() * 9, "{known} of {}", inner.len());
    }
    assert_eq!(check(&accel_of(soup(&corners, Some(&scaled))), &inner), 0);
}

#[test]
fn smooth_solids_are_lifted_as_single_hits_are() {
    for (r, shift) in [(1e-3, 0.0), (1.0, 0.0), (1.0, 100.0), (1e3, 1e5)] {
        let centre = Vec3::new(shift, -shift, 0.5 * shift);
        let ball = sphere(2, r, centre);
        let normals = ball.positions.iter().map(|p| (*p - centre).normalize()).collect();
        let accel = accel_of(Mesh { normals, ..ball });
        let hits = hits(&accel, centre, r);
        let known = check(&accel, &hits);
        assert!(known * 10 > hits.len() * 9, "{r} {shift}: {known} of {}", hits.len());
    }
}

#[test]
fn instances_and_absent_objects_are_not_known() {
    let mesh = std::sync::Arc::new(cube(1.0, Vec3::ZERO));
    let mut builder = AccelBuilder::default();
    builder.add_mesh(cube(2.0, Vec3::ZERO));
    builder.add_instance(mesh.clone(), DAffine3::from_translation(DVec3::X));
    builder.add_instance(mesh, DAffine3::from_translation(DVec3::Y));
    let accel = builder.build();
    let hit = |object| Hit { t: 1.0, u: 0.3, v: 0.4, primitive: 3, object };
    let found = dispatch(Isa::Portable, Look(accel.facets(), &[hit(0), hit(1), hit(2), hit(u32::MAX)]));
    assert_eq!(found.iter().map(|(known, _)| *known).collect::<Vec<_>>(), [true, false, false, false]);
    let nothing = accel_of(Mesh::default());
    assert!(!dispatch(Isa::Portable, Look(nothing.facets(), &[hit(0)]))[0].0);
}
