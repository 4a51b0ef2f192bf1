//! Outlines of primitives, and the test whether two surfaces coincide over an area rather than only along a line where
//! they cross or meet.
use dapple_math::Aabb;
use glam::DVec3;

/// The geometry of a primitive or a point, and the error bound of its coordinates per axis.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    pub shape: Shape,
    pub error: DVec3,
}

#[derive(Clone, Debug)]
pub(super) enum Shape {
    /// A convex planar polygon with its unit normal.
    Flat(Box<Polygon>, DVec3),
    Sphere {
        centre: DVec3,
        radius: f64,
    },
    Point(DVec3),
    /// Only the bounding box is known: the primitive moves, or is neither planar nor a sphere.
    Box,
}

/// A convex polygon. It has at most as many corners as the outline of a disk clipped by a slab and by another such
/// outline.
#[derive(Clone, Debug)]
pub(super) struct Polygon {
    count: usize,
    corners: [DVec3; MOST],
}

/// Number of corners of the polygon around a disk.
const DISK: usize = 16;
const MOST: usize = 2 * DISK + 4;

/// Two surfaces coincide if their common area is more than a strip this many times as wide as the error bound. Surfaces
/// that cross at an angle of half a degree or more, or meet along an edge, do not coincide.
const STRIP: f64 = 256.0;
/// They also coincide if the common area is more than this fraction of one of them and more than a strip of twice the
/// error bound.
const SHARE: f64 = 1.0 / 8.0;

impl Polygon {
    pub fn new(from: &[DVec3]) -> Self {
        let mut polygon = Self { count: 0, corners: [DVec3::ZERO; MOST] };
        from.iter().for_each(|p| polygon.push(*p));
        polygon
    }

    /// The polygon around the disk of radius `radius` about `centre`; `x` and `y` are orthogonal unit vectors in its
    /// plane.
    pub fn around_disk(centre: DVec3, x: DVec3, y: DVec3, radius: f64) -> Self {
        let reach = radius / libm::cos(std::f64::consts::PI / DISK as f64);
        let corners: [DVec3; DISK] = std::array::from_fn(|i| {
            let angle = std::f64::consts::TAU * i as f64 / DISK as f64;
            centre + (x * libm::cos(angle) + y * libm::sin(angle)) * reach
        });
        Self::new(&corners)
    }

    fn push(&mut self, p: DVec3) {
        if self.count < MOST {
            self.corners[self.count] = p;
            self.count += 1;
        }
    }

    pub fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    fn edges(&self) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
        let corners = self.corners();
        corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| (*a, *b))
    }

    /// The part with n·x ≤ `limit`.
    fn clipped(&self, n: DVec3, limit: f64) -> Self {
        let mut kept = Self::new(&[]);
        for (a, b) in self.edges() {
            let (from, to) = (n.dot(a) - limit, n.dot(b) - limit);
            if from <= 0.0 {
                kept.push(a);
            }
            if (from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0) {
                kept.push(a + (b - a) * (from / (from - to)));
            }
        }
        kept
    }

    /// Area projected along `n`.
    fn area(&self, n: DVec3) -> f64 {
        let Some(&a) = self.corners().first() else { return 0.0 };
        let sum: DVec3 = self.edges().map(|(b, c)| (b - a).cross(c - a)).sum();
        0.5 * sum.dot(n).abs()
    }

    fn diameter(&self) -> f64 {
        let bounds = self.corners().iter().fold(Aabb::EMPTY, |b, p| b.union(Aabb::new(*p, *p)));
        if self.count == 0 { 0.0 } else { (bounds.hi - bounds.lo).length() }
    }

    fn distance(&self, n: DVec3, q: DVec3) -> f64 {
        let inside = self.edges().all(|(a, b)| (b - a).cross(n).dot(q - a) <= 0.0);
        if inside {
            return self.corners().first().map_or(f64::INFINITY, |a| n.dot(q - *a).abs());
        }
        let to_edge = |(a, b): (DVec3, DVec3)| {
            let (along, length) = (b - a, (b - a).length_squared());
            let s = if length > 0.0 { ((q - a).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
            (q - a - along * s).length()
        };
        self.edges().map(to_edge).fold(f64::INFINITY, f64::min)
    }
}

impl Outline {
    /// Whether the two have a place in common. The test is conservative, except between planar surfaces, whose common
    /// area is computed.
    pub fn meets(&self, other: &Self) -> bool {
        let error = self.error + other.error;
        let reach = error.length();
        match (&self.shape, &other.shape) {
            (Shape::Box, _) | (_, Shape::Box) | (Shape::Point(_), Shape::Point(_)) => true,
            (Shape::Flat(a, n), Shape::Flat(b, m)) => overlap((&**a, *n), (&**b, *m), error),
            (Shape::Flat(a, n), Shape::Point(q)) | (Shape::Point(q), Shape::Flat(a, n)) => {
                a.distance(*n, *q) <= reach
            }
            (Shape::Sphere { centre, radius }, Shape::Point(q))
            | (Shape::Point(q), Shape::Sphere { centre, radius }) => {
                ((*q - *centre).length() - radius).abs() <= reach
            }
            (Shape::Sphere { centre, radius }, Shape::Flat(a, n))
            | (Shape::Flat(a, n), Shape::Sphere { centre, radius }) => {
                let farthest = a.corners().iter().map(|p| (*p - *centre).length()).fold(0.0, f64::max);
                a.distance(*n, *centre) <= radius + reach && farthest >= radius - reach
            }
            (Shape::Sphere { centre: a, radius: r }, Shape::Sphere { centre: b, radius: s }) => {
                let apart = (*a - *b).length();
                apart <= r + s + reach && apart >= (r - s).abs() - reach
            }
        }
    }
}

/// Whether the two triangles do not coincide: either an edge of one separates them, seen along its normal, up to
/// `tolerance`, as for coplanar triangles that share an edge or a corner; or they cross at an angle and are wide
/// compared with `within`, a bound of their error.
pub(super) fn are_apart(a: &[DVec3; 3], b: &[DVec3; 3], tolerance: f64, within: f64) -> bool {
    is_beside(a, b, tolerance) || is_beside(b, a, tolerance) || cross_widely(a, b, within)
}

/// Implements the same early exit as [`overlap`].
fn cross_widely(a: &[DVec3; 3], b: &[DVec3; 3], within: f64) -> bool {
    let normal = |t: &[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]);
    let diameter = |t: &[DVec3; 3]| {
        let bounds = t.iter().fold(Aabb::EMPTY, |b, p| b.union(Aabb::new(*p, *p)));
        (bounds.hi - bounds.lo).length()
    };
    let (n, m) = (normal(a), normal(b));
    let (in_a, in_b) = (n.length(), m.length());
    let thinner = (0.5 * in_a / diameter(a)).min(0.5 * in_b / diameter(b));
    n.cross(m).length() > 4.0 / STRIP * (in_a * in_b) && thinner > STRIP / SHARE * within
}

fn is_beside(a: &[DVec3; 3], b: &[DVec3; 3], tolerance: f64) -> bool {
    let n = (a[1] - a[0]).cross(a[2] - a[0]);
    (0..3).any(|i| {
        let outward = (a[(i + 1) % 3] - a[i]).cross(n);
        let least = -tolerance * outward.length();
        b.iter().all(|q| outward.dot(*q - a[i]) >= least)
    })
}

/// Whether two planar surfaces coincide over an area.
fn overlap((a, n): (&Polygon, DVec3), (b, m): (&Polygon, DVec3), error: DVec3) -> bool {
    let within = n.abs().dot(error).max(m.abs().dot(error));
    let Some(&start) = a.corners().first() else { return false };
    let heights = b.corners().iter().map(|p| n.dot(*p - start));
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    if low > within || high < -within {
        return false;
    }
    let (area_a, area_b) = (a.area(n), b.area(m));
    let thinner = (area_a / a.diameter()).min(area_b / b.diameter());
    // At this angle the common strip is too narrow, and both surfaces are much wider than the strip.
    if n.cross(m).length() > 4.0 / STRIP && thinner > STRIP / SHARE * within {
        return false;
    }
    if are_folded((a, n), (b, m), within) {
        return false;
    }
    let height = n.dot(start);
    let mut common = b.clipped(n, height + within).clipped(-n, within - height);
    for (from, to) in a.edges() {
        let outward = (to - from).cross(n);
        common = common.clipped(outward, outward.dot(from));
    }
    let (area, strip) = (common.area(n), within * common.diameter());
    area > 2.0 * strip && (area > STRIP * strip || area > SHARE * area_a.min(area_b))
}

/// Whether two surfaces are joined along an edge and separate elsewhere, as the sides of a thin blade are. They are at
/// one place near the edge, but there the order of hits only shows on which side of the edge the ray passes.
fn are_folded((a, n): (&Polygon, DVec3), (b, m): (&Polygon, DVec3), within: f64) -> bool {
    let common = a.corners().iter().filter(|p| b.corners().contains(p)).count();
    let lies_in = |p: &Polygon, q: &Polygon, n: DVec3| {
        p.corners().iter().all(|x| n.dot(*x - q.corners()[0]).abs() <= within)
    };
    common == 2 && !(lies_in(a, b, m) && lies_in(b, a, n))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ERROR: DVec3 = DVec3::splat(1e-6);

    fn triangle(corners: [DVec3; 3]) -> Outline {
        let n = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        Outline { shape: Shape::Flat(Box::new(Polygon::new(&corners)), n), error: ERROR }
    }

    fn square(z: f64, size: f64) -> [Outline; 2] {
        let p = |x, y| DVec3::new(x * size, y * size, z);
        [
            triangle([p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0)]),
            triangle([p(-1.0, -1.0), p(1.0, 1.0), p(-1.0, 1.0)]),
        ]
    }

    fn any(a: &[Outline], b: &[Outline]) -> bool {
        a.iter().any(|a| b.iter().any(|b| a.meets(b) && b.meets(a)))
    }

    #[test]
    fn what_lies_in_the_plane_meets_and_what_lies_a_little_before_it_does_not() {
        let wall = square(0.0, 5.0);
        assert!(any(&wall, &square(0.0, 1.0)) && any(&wall, &square(1e-6, 0.01)));
        assert!(!any(&wall, &square(1e-5, 1.0)));
        // As small as a light can be: a few error bounds across.
        assert!(any(&wall, &square(0.0, 2e-5)));
    }

    #[test]
    fn neighbours_and_what_stands_on_a_surface_do_not_meet() {
        let [a, b] = square(0.0, 1.0);
        assert!(!a.meets(&b) && !b.meets(&a), "across the diagonal");
        let wall = triangle([DVec3::ZERO, DVec3::X, DVec3::Z]);
        assert!(!a.meets(&wall) && !wall.meets(&a), "a wall on a floor");
        let corners = |outline: &Outline| match &outline.shape {
            Shape::Flat(polygon, _) => <[DVec3; 3]>::try_from(polygon.corners()).unwrap(),
            _ => panic!(),
        };
        assert!(are_apart(&corners(&a), &corners(&b), 1e-12, 2e-6));
        let [part, _] = square(0.0, 0.5);
        assert!(!are_apart(&corners(&a), &corners(&part), 1e-12, 2e-6));
        let slope = triangle([DVec3::ZERO, DVec3::X, DVec3::new(0.5, 0.5, 0.2)]);
        assert!(!a.meets(&slope) && !slope.meets(&a), "a ramp on a floor");
        let slight = triangle([DVec3::ZERO, DVec3::X, DVec3::new(0.5, 0.5, 1e-5)]);
        assert!(a.meets(&slight) && slight.meets(&a), "nearly the floor");
        let corners = [DVec3::splat(-1.0) * DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, 1.0, 0.0)];
        let blade = triangle([corners[1], corners[0], DVec3::new(0.5, -0.5, 1e-3)]);
        assert!(!a.meets(&blade) && !blade.meets(&a), "a blade");
        let back = triangle([corners[1], corners[0], DVec3::new(0.5, -0.5, 0.0)]);
        assert!(a.meets(&back) && back.meets(&a), "a leaf with two sides");
    }

    #[test]
    fn round_shapes_meet_where_their_surfaces_do() {
        let ball =
            |x: f64, radius| Outline { shape: Shape::Sphere { centre: DVec3::X * x, radius }, error: ERROR };
        assert!(ball(0.0, 1.0).meets(&ball(1e-7, 1.0)) && ball(0.0, 1.0).meets(&ball(2.0, 1.0)));
        assert!(!ball(0.0, 1.0).meets(&ball(0.1, 0.5)) && !ball(0.0, 1.0).meets(&ball(2.1, 1.0)));
        let floor =
            triangle([DVec3::new(-9.0, -9.0, -1.0), DVec3::new(9.0, -9.0, -1.0), DVec3::new(0.0, 9.0, -1.0)]);
        assert!(floor.meets(&ball(0.0, 1.0)) && !floor.meets(&ball(0.0, 0.9)));
        let point = |z| Outline { shape: Shape::Point(DVec3::new(0.0, 0.0, z)), error: ERROR };
        assert!(
            floor.meets(&point(-1.0)) && !floor.meets(&point(-0.99)) && ball(0.0, 1.0).meets(&point(1.0))
        );
        let disk = Polygon::around_disk(DVec3::NEG_Z, DVec3::X, DVec3::Y, 0.5);
        let disk = Outline { shape: Shape::Flat(Box::new(disk), DVec3::Z), error: ERROR };
        assert!(disk.meets(&floor) && floor.meets(&disk));
    }
}
