//! Default camera for scenes that have none. It views the scene from the front, slightly from the right and above, at
//! the smallest distance from which everything is visible. If this shows more back faces than a view straight from the
//! front (a room without a front wall, seen through its side wall), it views straight from the front.
use crate::builder::CameraPose;
use dapple_camera::Projection;
use dapple_geometry::{Accel, Opaque};
use dapple_math::Ray;
use glam::{DAffine3, DMat3, DVec3};

/// Tangent of half the vertical field of view, which is 40°.
const TAN_HALF: f64 = 0.363_970_234_266_202_4;
/// Directions from the scene to the camera; the first one with the fewest visible back faces is used.
const TOWARDS: [DVec3; 2] = [DVec3::new(0.55, 0.4, 1.0), DVec3::Z];
/// Margin around the scene, as a factor.
const MARGIN: f64 = 1.05;
/// Number of iterations that centre the image; an iteration is exact once the two outermost points are known.
const CENTRING: usize = 6;
/// Number of rays per side of the grid that counts back faces.
const GRID: i32 = 32;

/// A view whose central square contains the whole scene. `triangles` holds the triangle count of each object; it is
/// None if any object is a sphere or disk, and the scene's bounding box is framed instead.
pub(crate) fn frame(accel: &Accel, triangles: Option<Vec<usize>>) -> CameraPose {
    let points = match triangles {
        Some(counts) => corners(accel, &counts),
        None => box_corners(accel),
    };
    let poses = TOWARDS.map(|towards| fit(towards, &points));
    let [first, second] = &poses;
    if backs(accel, second) < backs(accel, first) { poses[1] } else { poses[0] }
}

fn corners(accel: &Accel, counts: &[usize]) -> Vec<DVec3> {
    let objects = counts.iter().enumerate();
    let all = objects.flat_map(|(object, &n)| (0..n).map(move |i| (object as u32, i as u32)));
    all.flat_map(|(object, i)| accel.corners(object, i)).map(|p| p.as_dvec3()).collect()
}

fn box_corners(accel: &Accel) -> Vec<DVec3> {
    let Some((min, max)) = accel.bounds() else { return Vec::new() };
    let pick = |corner: u32, bit: u32| if corner >> bit & 1 == 0 { min } else { max };
    (0..8).map(|c| DVec3::new(pick(c, 0).x.into(), pick(c, 1).y.into(), pick(c, 2).z.into())).collect()
}

/// The nearest camera position from which all points are visible when looking along −`towards`. A point with
/// coordinates (x, y, z) along the camera's axes is visible from c if |x − cx| ≤ (cz − z) tan, and likewise for y: c
/// must lie in the intersection of four half-spaces.
fn fit(towards: DVec3, points: &[DVec3]) -> CameraPose {
    let backward = towards * (1.0 / towards.length());
    let right = DVec3::Y.cross(backward);
    let right = right * (1.0 / right.length());
    let up = backward.cross(right);
    let tan = TAN_HALF / MARGIN;
    let farthest = |axis: DVec3| points.iter().map(|p| p.dot(axis)).reduce(f64::max).unwrap_or(0.0);
    let side = |axis: DVec3| (farthest(axis + backward * tan), farthest(backward * tan - axis));
    let ((r, l), (t, b)) = (side(right), side(up));
    let needed = ((r + l) * 0.5).max((t + b) * 0.5) / tan;
    // A single point is visible from any other point.
    let distance = if needed > farthest(backward) { needed } else { farthest(backward) + 1.0 };
    let axes = DMat3::from_cols(right, up, backward);
    let middle = |axis: DVec3, at: f64| {
        let seen = points.iter().map(|p| (p.dot(axis), distance - p.dot(backward)));
        (0..CENTRING).fold(at, |at, _| centred(seen.clone(), at))
    };
    let at = DVec3::new(middle(right, (r - l) * 0.5), middle(up, (t - b) * 0.5), distance);
    CameraPose {
        transform: DAffine3 { matrix3: axes, translation: axes * at },
        projection: Projection::Perspective { tan_half: TAN_HALF as f32 },
        aspect: Some(1.0),
        clip: None,
    }
}

/// Camera position along an axis of the image at which the two outermost points, as seen from `at`, are equally far
/// from the centre. `seen` holds the positions of all points along this axis, and their depths.
fn centred(seen: impl Iterator<Item = (f64, f64)>, at: f64) -> f64 {
    let tangent = |&(x, depth): &(f64, f64)| (x - at) / depth;
    let start = ((f64::NEG_INFINITY, at, 1.0), (f64::INFINITY, at, 1.0));
    let ((_, high, d), (_, low, e)) = seen.fold(start, |(high, low), p| {
        let t = tangent(&p);
        (if t > high.0 { (t, p.0, p.1) } else { high }, if t < low.0 { (t, p.0, p.1) } else { low })
    });
    (high * e + low * d) / (d + e)
}

/// Number of rays, of a grid over the central square, that hit a back face.
fn backs(accel: &Accel, pose: &CameraPose) -> usize {
    let at = |i: i32| (f64::from(2 * i + 1) / f64::from(GRID) - 1.0) * TAN_HALF;
    let directions = (0..GRID).flat_map(|y| (0..GRID).map(move |x| DVec3::new(at(x), at(y), -1.0)));
    let sees_back = |d: &DVec3| {
        let d = (pose.transform.matrix3 * *d).as_vec3();
        let ray = Ray::new(pose.transform.translation.as_vec3(), d * (1.0 / d.length()));
        let hit = accel.intersect(&ray, 0.0, &Opaque);
        hit.is_some_and(|hit| accel.surface(&ray, 0.0, &hit).ng.dot(ray.d) > 0.0)
    };
    directions.filter(sees_back).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_geometry::{AccelBuilder, Mesh, shapes::Sphere};
    use glam::Vec3;

    /// Distance of a point from the centre of the image, 1 at the edge of the central square; infinite behind the
    /// camera.
    fn outwards(pose: &CameraPose, p: Vec3) -> f64 {
        let q = pose.transform.inverse().transform_point3(p.as_dvec3());
        if q.z < 0.0 { q.x.abs().max(q.y.abs()) / (-q.z * TAN_HALF) } else { f64::INFINITY }
    }

    /// Quads of four corners each; the front side is where they are counter-clockwise.
    fn accel(quads: &[[Vec3; 4]]) -> (Accel, Option<Vec<usize>>) {
        let triangles = (0..quads.len() as u32)
            .flat_map(|i| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]]);
        let mesh = Mesh { positions: quads.concat(), triangles: triangles.collect(), ..Mesh::default() };
        let mut accel = AccelBuilder::default();
        accel.add_mesh(mesh);
        (accel.build(), Some(vec![2 * quads.len()]))
    }

    /// A cube of side 2 without its front, seen from inside.
    fn room() -> Vec<[Vec3; 4]> {
        let wall = |f: fn(f32, f32) -> Vec3| [f(-1.0, -1.0), f(1.0, -1.0), f(1.0, 1.0), f(-1.0, 1.0)];
        vec![
            wall(|a, b| Vec3::new(a, b, -1.0)),
            wall(|a, b| Vec3::new(a, -1.0, -b)),
            wall(|a, b| Vec3::new(a, 1.0, b)),
            wall(|a, b| Vec3::new(-1.0, b, -a)),
            wall(|a, b| Vec3::new(1.0, b, a)),
        ]
    }

    #[test]
    fn everything_is_in_view_and_nothing_could_be_nearer() {
        let turned: Vec<[Vec3; 4]> =
            room().iter().map(|q| [3, 2, 1, 0].map(|i| q[i] * Vec3::new(3.0, 0.5, 1.0))).collect();
        for quads in [room(), turned] {
            let (accel, counts) = accel(&quads);
            let pose = frame(&accel, counts);
            let farthest = quads.concat().iter().map(|&p| outwards(&pose, p)).fold(0.0, f64::max);
            assert!((farthest * MARGIN - 1.0).abs() < 1e-6, "{farthest}");
            let to_camera = pose.transform.inverse();
            for axis in 0..2 {
                let tangent = |p: &Vec3| to_camera.transform_point3(p.as_dvec3());
                let all = || quads.iter().flatten().map(tangent).map(|q| q[axis] / -q.z);
                let (low, high) = (all().fold(0.0, f64::min), all().fold(0.0, f64::max));
                assert!((low + high).abs() < 1e-6, "{low} {high}");
            }
        }
    }

    #[test]
    fn shapes_and_nothing_are_in_view() {
        let mut accel = AccelBuilder::default();
        accel.add_sphere(Sphere { centre: Vec3::new(0.5, 0.0, 0.0), radius: 0.3 });
        let pose = frame(&accel.build(), None);
        assert!(outwards(&pose, Vec3::new(0.5, 0.3, 0.0)) < 1.0);
        let nothing = frame(&AccelBuilder::default().build(), Some(Vec::new()));
        assert!(outwards(&nothing, Vec3::ZERO) < 1.0);
    }

    #[test]
    fn rooms_are_seen_through_their_open_side_and_boxes_from_a_corner() {
        let direction = |quads: &[[Vec3; 4]]| {
            let (accel, counts) = accel(quads);
            frame(&accel, counts).transform.matrix3.z_axis
        };
        assert_eq!(direction(&room()), DVec3::Z);
        let outside: Vec<[Vec3; 4]> = room().iter().map(|q| [3, 2, 1, 0].map(|i| q[i])).collect();
        assert!(direction(&outside).x > 0.0);
    }
}
