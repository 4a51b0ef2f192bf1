//! Brute-force ray intersection in f64: the reference for acceleration structures, packets and f32.
//!
//! Rays have any origin and direction; t is in units of the length of the direction. Edges and corners belong to a
//! triangle, both sides of it are hit, and at equal t the lowest index is returned. No ray passes between adjacent
//! triangles.

use glam::DVec3;

/// A hit on triangle `index` at `t`, with the barycentric coordinates of corners 1 and 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the triangle.
    pub index: usize,
    /// Ray parameter; the hit point is origin + t·direction.
    pub t: f64,
    /// Barycentric coordinate of the second corner.
    pub b1: f64,
    /// Barycentric coordinate of the third corner.
    pub b2: f64,
}

/// Returns t, of any value, and the barycentric coordinates (b1, b2) of the intersection of the ray with one triangle,
/// or None for a miss or an edge-on triangle.
///
/// The corners are sheared so that the ray is the z axis [Woop, Benthin & Wald 2013]. Each edge function is then a
/// difference of two products, whose computed sign is correct or zero because rounding is monotonic.
pub fn triangle(origin: DVec3, direction: DVec3, corners: [DVec3; 3]) -> Option<(f64, f64, f64)> {
    let z = direction.abs().max_position();
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let shear = [direction[x] / direction[z], direction[y] / direction[z]];
    let [a, b, c] = corners.map(|p| {
        let p = p - origin;
        [p[x] - shear[0] * p[z], p[y] - shear[1] * p[z], p[z] / direction[z]]
    });
    let area = |p: [f64; 3], q: [f64; 3]| p[0] * q[1] - p[1] * q[0];
    let [u, v, w] = [area(b, c), area(c, a), area(a, b)];
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    let sum = u + v + w;
    if !inside || sum == 0.0 || !sum.is_finite() {
        return None;
    }
    let (b1, b2) = (v / sum, w / sum);
    Some((u / sum * a[2] + b1 * b[2] + b2 * c[2], b1, b2))
}

/// Returns the closest hit with 0 ≤ t ≤ `t_max` among triangles given as arrays of corners.
pub fn intersect(
    triangles: &[[[f32; 3]; 3]],
    origin: [f32; 3],
    direction: [f32; 3],
    t_max: f64,
) -> Option<Hit> {
    let ray = [origin, direction].map(wide);
    let hit = |(index, corners): (usize, &[[f32; 3]; 3])| {
        let (t, b1, b2) = triangle(ray[0], ray[1], corners.map(wide))?;
        (0.0..=t_max).contains(&t).then_some(Hit { index, t, b1, b2 })
    };
    // `min_by` returns the first of equal elements, which has the lowest index.
    triangles.iter().enumerate().filter_map(hit).min_by(|a, b| a.t.total_cmp(&b.t))
}

/// Returns whether any triangle is hit with 0 ≤ t ≤ `t_max`.
pub fn occluded(triangles: &[[[f32; 3]; 3]], origin: [f32; 3], direction: [f32; 3], t_max: f64) -> bool {
    intersect(triangles, origin, direction, t_max).is_some()
}

/// Returns the entry and exit of the ray in the closed box, with t clipped to [0, t_max], or None for a miss.
pub fn slab(low: DVec3, high: DVec3, origin: DVec3, direction: DVec3, t_max: f64) -> Option<(f64, f64)> {
    let mut range = (0.0f64, t_max);
    for axis in 0..3 {
        let (o, d) = (origin[axis], direction[axis]);
        if d == 0.0 {
            if o < low[axis] || o > high[axis] {
                return None;
            }
            continue;
        }
        let (a, b) = ((low[axis] - o) / d, (high[axis] - o) / d);
        range = (range.0.max(a.min(b)), range.1.min(a.max(b)));
    }
    (range.0 <= range.1).then_some(range)
}

/// Converts f32 coordinates to f64, which is exact.
pub fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rng;

    const UNIT: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn a_known_hit_from_both_sides() {
        for (z, d) in [(3.0, -2.0), (-3.0, 2.0)] {
            let hit = intersect(&[UNIT], [0.25, 0.5, z], [0.0, 0.0, d], f64::INFINITY).unwrap();
            assert_eq!(hit, Hit { index: 0, t: 1.5, b1: 0.25, b2: 0.5 });
        }
        assert!(!occluded(&[UNIT], [0.25, 0.5, 3.0], [0.0, 0.0, -2.0], 1.49));
        assert!(!occluded(&[UNIT], [0.25, 0.5, 3.0], [0.0, 0.0, 2.0], f64::INFINITY));
        assert!(!occluded(&[UNIT], [0.6, 0.5, 3.0], [0.0, 0.0, -2.0], f64::INFINITY));
        assert!(!occluded(&[UNIT], [-1.0, 0.2, 0.0], [1.0, 0.0, 0.0], f64::INFINITY), "edge-on");
    }

    #[test]
    fn corners_count_and_the_lowest_index_wins() {
        let two = [UNIT, UNIT];
        let hit = intersect(&two, [1.0, 0.0, 1.0], [0.0, 0.0, -1.0], f64::INFINITY).unwrap();
        assert_eq!((hit.index, hit.b1, hit.b2), (0, 1.0, 0.0));
    }

    /// The barycentric coordinates and t must give the same point, and a ray aimed at a point of a triangle must hit
    /// it.
    #[test]
    fn aimed_rays_hit_where_aimed() {
        let mut rng = Rng::new(5);
        for _ in 0..10_000 {
            let corners = [(); 3].map(|()| rng.direction() * 10.0);
            let (mut b1, mut b2) = (rng.f64(), rng.f64());
            if b1 + b2 > 1.0 {
                (b1, b2) = (1.0 - b1, 1.0 - b2);
            }
            let target = corners[0] * (1.0 - b1 - b2) + corners[1] * b1 + corners[2] * b2;
            let direction = rng.direction();
            if (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize().dot(direction).abs()
                < 0.01
            {
                continue;
            }
            let (t, c1, c2) = triangle(target - direction * 7.0, direction, corners).unwrap();
            let point = corners[0] * (1.0 - c1 - c2) + corners[1] * c1 + corners[2] * c2;
            assert!((t - 7.0).abs() < 1e-9 && point.distance(target) < 1e-9);
        }
    }

    /// Rays from the inside of a closed octahedron with perturbed corners, aimed at its edges and corners, never miss
    /// it.
    #[test]
    fn nothing_leaks_between_neighbours() {
        let mut rng = Rng::new(6);
        let mut perturbed = |x: f64, y: f64, z: f64| {
            (DVec3::new(x, y, z) + 0.2 * rng.direction()).to_array().map(|c| c as f32)
        };
        let pole = [perturbed(0.0, 0.0, 1.0), perturbed(0.0, 0.0, -1.0)];
        let rim = [
            perturbed(1.0, 0.0, 0.0),
            perturbed(0.0, 1.0, 0.0),
            perturbed(-1.0, 0.0, 0.0),
            perturbed(0.0, -1.0, 0.0),
        ];
        let mesh: Vec<_> = (0..8).map(|i| [pole[i / 4], rim[i % 4], rim[(i + 1) % 4]]).collect();
        for i in 0..20_000u32 {
            let corners = mesh[rng.below(8) as usize].map(wide);
            let s = if i % 4 == 0 { 1.0 } else { rng.f64() };
            let target = corners[rng.below(3) as usize].lerp(corners[rng.below(3) as usize], s);
            let origin = 0.3 * rng.direction();
            let through = |corners: &[[f32; 3]; 3]| {
                triangle(origin, target - origin, corners.map(wide)).is_some_and(|hit| hit.0 > 0.0)
            };
            assert!(mesh.iter().any(through));
        }
    }

    #[test]
    fn slabs() {
        let (low, high) = (DVec3::ZERO, DVec3::ONE);
        let hit = |o: [f64; 3], d: [f64; 3]| slab(low, high, o.into(), d.into(), 10.0);
        assert_eq!(hit([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]), Some((1.0, 2.0)));
        assert_eq!(hit([0.5, 0.5, 0.5], [0.0, 0.0, -2.0]), Some((0.0, 0.25)));
        assert_eq!(hit([-1.0, 0.0, 1.0], [1.0, 0.0, 0.0]), Some((1.0, 2.0)), "a ray in a face");
        assert_eq!(hit([-1.0, -0.1, 0.5], [1.0, 0.0, 0.0]), None);
        assert_eq!(hit([2.0, 0.5, 0.5], [1.0, 0.0, 0.0]), None);
        assert_eq!(hit([-20.0, 0.5, 0.5], [1.0, 0.0, 0.0]), None);
    }
}
