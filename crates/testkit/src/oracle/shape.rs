//! Intersections of rays with spheres and planes. Those with triangles and boxes are in [`crate::intersect`].

use glam::DVec3;

/// Returns the smallest t > 0 with |o + t·d − c| = r. It is computed from the distance of the line from the centre and
/// half the chord; the root that would cancel is computed from the other one.
pub fn sphere(o: DVec3, d: DVec3, centre: DVec3, radius: f64) -> Option<f64> {
    let length = d.length();
    let (d, f) = (d / length, centre - o);
    let along = f.dot(d);
    let from_line = f - d * along;
    let half2 = (radius - from_line.length()) * (radius + from_line.length());
    if half2 < 0.0 {
        return None;
    }
    let far = along + along.signum() * half2.sqrt();
    let near = (f.length() - radius) * (f.length() + radius) / far;
    let (low, high) = (near.min(far), near.max(far));
    [low, high].into_iter().find(|&t| t > 0.0).map(|t| t / length)
}

/// Returns the t of the intersection of a ray with the plane through `p` with normal `n`.
pub fn plane(o: DVec3, d: DVec3, p: DVec3, n: DVec3) -> f64 {
    n.dot(p - o) / n.dot(d)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_sides_of_a_sphere() {
        let hit = |o: f64| sphere(DVec3::X * o, DVec3::X * 2.0, DVec3::ZERO, 1.0);
        assert_eq!((hit(-3.0), hit(0.5), hit(2.0)), (Some(1.0), Some(0.25), None));
        assert_eq!(plane(DVec3::Z * 3.0, -DVec3::Z, DVec3::Z, DVec3::Z), 2.0);
    }
}
