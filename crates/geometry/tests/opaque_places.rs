//! Tests which triangles of two opaque objects share a place, and that the search remains cheap.

use dapple_geometry::{Accel, AccelBuilder, Coincident, Mesh};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::sync::Arc;

/// A horizontal square of half side `half` at height `y`, made of `n`² cells of two triangles, facing up or down.
fn square(y: f32, half: f32, n: u32, up: bool) -> Mesh {
    let at = |i: u32| half * (2.0 * i as f32 / n as f32 - 1.0);
    let positions = (0..=n).flat_map(|j| (0..=n).map(move |i| Vec3::new(at(i), y, at(j)))).collect();
    let cell = |i: u32, j: u32| {
        let (a, b) = (j * (n + 1) + i, (j + 1) * (n + 1) + i);
        let corners = [[a, b, b + 1], [a, b + 1, a + 1]];
        if up { corners } else { corners.map(|[p, q, r]| [p, r, q]) }
    };
    let triangles = (0..n).flat_map(|j| (0..n).flat_map(move |i| cell(i, j))).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

fn of(meshes: impl IntoIterator<Item = Mesh>) -> Accel {
    let mut builder = AccelBuilder::default();
    meshes.into_iter().for_each(|mesh| _ = builder.add_mesh(mesh));
    builder.build()
}

fn found(accel: &Accel) -> Option<Box<Coincident>> {
    accel.coincident(|_| None, |_, _| false, &[], Vec3::ZERO, |_| true)
}

/// The number of coincident triangles among the first `triangles` of an object.
fn count(coincident: &Coincident, object: u32, triangles: u32) -> usize {
    (0..triangles).filter(|&primitive| coincident.contains(object, primitive)).count()
}

#[test]
fn a_panel_and_what_lies_behind_it_are_found_in_either_order() {
    for (wall, panel) in [(0, 1), (1, 0)] {
        let accel = |y: f32| {
            let mut meshes = [square(0.0, 10.0, 10, true), square(y, 0.5, 1, true)];
            meshes.rotate_left(wall);
            of(meshes)
        };
        assert!(found(&accel(0.01)).is_none(), "in front of the wall");
        let coincident = found(&accel(0.0)).expect("the panel lies in the wall");
        // At the centre, where the panel covers parts of four cells.
        let behind = count(&coincident, wall as u32, 200);
        assert!((6..=8).contains(&behind) && count(&coincident, panel, 2) == 2, "{behind}");
    }
}

#[test]
fn what_stands_on_a_floor_is_left_alone() {
    let accel = of([square(0.0, 10.0, 4, true), square(0.0, 0.5, 1, false)]);
    assert!(found(&accel).is_none());
}

#[test]
fn mirrored_instances_keep_their_front() {
    let flipped = DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0));
    let turned = DAffine3::from_quat(DQuat::from_rotation_y(0.3));
    for (second, is_found) in [(turned, true), (flipped * turned, false)] {
        let mut builder = AccelBuilder::default();
        let mesh = Arc::new(square(0.0, 1.0, 2, true));
        builder.add_instance(mesh.clone(), DAffine3::IDENTITY);
        builder.add_instance(mesh, second);
        assert_eq!(found(&builder.build()).is_some(), is_found);
    }
}

#[test]
fn triangles_of_one_object_are_not_compared() {
    let mut mesh = square(0.0, 1.0, 1, true);
    mesh.triangles.extend(mesh.triangles.clone());
    assert!(found(&of([mesh, square(3.0, 1.0, 1, true)])).is_none());
}

#[test]
fn many_objects_in_one_place_are_found_without_the_square_of_their_number() {
    let accel = of((0..1_500).map(|i| square(1.0, 1.0 + 1e-4 * i as f32, 1, true)));
    let coincident = found(&accel).unwrap();
    assert!((0..1_500).all(|object| count(&coincident, object, 2) == 2));
}

#[test]
fn where_all_is_cut_into_small_objects_nothing_is_asked() {
    let small = |i: u32| square(1.0, 1.0 + 1e-4 * i as f32, 3, true);
    assert!(found(&of((0..400).map(small))).is_none());
}
