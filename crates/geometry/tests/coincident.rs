//! Tests which primitives share a place with an emitter: those that lie in its plane over an area, but not its
//! neighbours.

use dapple_geometry::shapes::{Disk, Sphere};
use dapple_geometry::{Accel, AccelBuilder, Coincident, Mesh};
use dapple_math::Motion;
use dapple_math::motion::{Channel, Interpolation, Node, Track, Trs};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::sync::Arc;

/// A square of half side `half` about the origin at height `z`, made of `n`² cells of two triangles.
fn square(z: f32, half: f32, n: u32, turn: DQuat) -> Mesh {
    let at = |i: u32| half * (2.0 * i as f32 / n as f32 - 1.0);
    let place = |p: Vec3| (turn * p.as_dvec3()).as_vec3();
    let positions = (0..=n).flat_map(|j| (0..=n).map(move |i| place(Vec3::new(at(i), at(j), z)))).collect();
    let cell = |i: u32, j: u32| {
        let a = j * (n + 1) + i;
        [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
    };
    let triangles = (0..n).flat_map(|j| (0..n).flat_map(move |i| cell(i, j))).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

/// The coincident primitives if the objects from index `emitters` on emit.
fn found(accel: &Accel, emitters: u32, points: &[DVec3]) -> Option<Box<Coincident>> {
    let points: Vec<_> = points.iter().map(|p| (*p, *p)).collect();
    accel.coincident(
        |object| (object >= emitters).then_some(object),
        |_, _| true,
        &points,
        Vec3::ZERO,
        |_| false,
    )
}

fn turns() -> [DQuat; 3] {
    [0.0, 0.7, 2.0].map(|angle: f64| {
        let v = DVec3::new(1.0, 2.0, 3.0).normalize() * libm::sin(angle / 2.0);
        DQuat::from_xyzw(v.x, v.y, v.z, libm::cos(angle / 2.0))
    })
}

#[test]
fn of_a_wall_the_triangles_behind_the_lamp_are_found_and_no_others() {
    for turn in turns() {
        let accel = |z: f32| {
            let mut builder = AccelBuilder::default();
            builder.add_mesh(square(2.0, 10.0, 10, turn));
            builder.add_mesh(square(0.0, 10.0, 10, turn));
            builder.add_mesh(square(z, 0.5, 1, turn));
            builder.build()
        };
        assert!(found(&accel(1.999), 2, &[]).is_none());
        let coincident = found(&accel(2.0), 2, &[]).expect("the lamp lies in the wall");
        let count = |object: u32| (0..200).filter(|&p| coincident.contains(object, p)).count();
        assert_eq!((count(1), coincident.contains(2, 0), coincident.contains(2, 1)), (0, true, true));
        // At the centre, where the lamp covers parts of four cells.
        assert!((6..=8).contains(&count(0)), "{}", count(0));
        assert!(coincident.thickness() > 0.0 && coincident.thickness() < 1e-4);
        assert!(!coincident.contains(7, 0) && !coincident.contains(0, 9999));
    }
}

#[test]
fn a_finely_cut_emitter_is_not_in_its_own_way() {
    let mut builder = AccelBuilder::default();
    let mut mesh = square(0.0, 1.0, 60, DQuat::IDENTITY);
    for p in &mut mesh.positions {
        p.z = 0.05 * libm::sinf(7.0 * p.x) * libm::cosf(9.0 * p.y);
    }
    builder.add_mesh(mesh);
    assert!(found(&builder.build(), 0, &[]).is_none());
}

#[test]
fn many_emitters_in_one_place_are_found_without_the_square_of_their_number() {
    let mut builder = AccelBuilder::default();
    let one = square(1.0, 1.0, 1, DQuat::IDENTITY);
    let copies = 20_000u32;
    let mut mesh = Mesh::default();
    for i in 0..copies {
        mesh.positions.extend(&one.positions);
        mesh.triangles.extend(one.triangles.iter().map(|t| t.map(|k| k + 4 * i)));
    }
    builder.add_mesh(mesh);
    let accel = builder.build();
    let coincident = found(&accel, 0, &[]).unwrap();
    assert!((0..2 * copies).all(|p| coincident.contains(0, p)));
    assert!(coincident.memory_bytes() < 10_000);
    // Primitives of one group that emit no light need not be distinguished.
    assert!(accel.coincident(Some, |_, _| false, &[], Vec3::ZERO, |_| false).is_none());
}

#[test]
fn shapes_points_and_what_moves() {
    let slide = |to: DVec3| {
        let track = Track::new(vec![0.0, 1.0], vec![DVec3::ZERO, to], Interpolation::Linear).unwrap();
        let trs = Trs { translation: Channel::Track(Arc::new(track)), ..Trs::default() };
        Motion::new(vec![Node::Trs(trs)], DAffine3::IDENTITY, 0.0)
    };
    let mut builder = AccelBuilder::default();
    builder.add_mesh(square(0.0, 5.0, 1, DQuat::IDENTITY));
    builder.add_sphere(Sphere { centre: Vec3::new(0.0, 0.0, 3.0), radius: 1.0 });
    builder.add_disk(Disk { centre: Vec3::new(3.0, 3.0, 0.0), normal: Vec3::Z, radius: 0.5 });
    builder.add_sphere(Sphere { centre: Vec3::new(0.0, 0.0, 3.0), radius: 1.0 });
    builder.add_moving(square(0.0, 0.5, 1, DQuat::IDENTITY), slide(DVec3::X));
    builder.add_disk(Disk { centre: Vec3::new(3.0, 3.0, 1.0), normal: Vec3::Z, radius: 0.5 });
    builder.add_moving(square(7.0, 0.5, 1, DQuat::IDENTITY), slide(DVec3::X));
    let accel = builder.build_for(0.0, 1.0);
    let points = [DVec3::new(1.0, 2.0, 0.0), DVec3::new(1.0, 2.0, 0.01), DVec3::new(0.0, 1.0, 3.0)];
    let coincident = found(&accel, 2, &points).unwrap();
    let of: Vec<bool> = (0..7).map(|object| coincident.contains(object, 0)).collect();
    assert_eq!(of, [true, true, true, true, true, false, false]);
    assert_eq!([0, 1, 2, 3].map(|i| coincident.contains_point(i)), [true, false, true, false]);
    assert!(found(&accel, 99, &[]).is_none(), "nothing emits");
}
