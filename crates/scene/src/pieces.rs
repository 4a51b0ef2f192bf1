//! Subdivision of a triangle by the grid of texels.
//!
//! The integral of a texture over a triangle is the sum over the pieces of area × value at the centroid. It is exact
//! for nearest-neighbour lookups, and for whole cells between texel centres with linear interpolation, whose mean is
//! the value at their centre.
use glam::DVec2;

/// A triangle clipped to a row and a column: at most seven corners, and one spare.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [DVec2; 8],
    count: usize,
}

impl Polygon {
    /// The part in which `inside`, a linear function of the position, is ≥ 0.
    fn clipped(&self, inside: impl Fn(DVec2) -> f64) -> Self {
        let mut out = Self { corners: [DVec2::ZERO; 8], count: 0 };
        let mut push = |p: DVec2| {
            if out.count < 8 {
                out.corners[out.count] = p;
                out.count += 1;
            }
        };
        for i in 0..self.count {
            let (a, b) = (self.corners[i], self.corners[(i + 1) % self.count]);
            let (da, db) = (inside(a), inside(b));
            if da >= 0.0 {
                push(a);
            }
            if (da >= 0.0) != (db >= 0.0) {
                push(a + (b - a) * (da / (da - db)));
            }
        }
        out
    }

    fn range(&self, coordinate: impl Fn(DVec2) -> f64) -> (f64, f64) {
        self.corners[..self.count].iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
            (low.min(coordinate(*p)), high.max(coordinate(*p)))
        })
    }

    /// Centroid and area; None if the area is zero.
    fn middle(&self) -> Option<(DVec2, f64)> {
        let origin = self.corners[0];
        let (mut sum, mut twice) = (DVec2::ZERO, 0.0);
        for i in 1..self.count.saturating_sub(1) {
            let (a, b) = (self.corners[i] - origin, self.corners[i + 1] - origin);
            let area = a.perp_dot(b).abs();
            sum += (a + b) * area;
            twice += area;
        }
        (twice > 0.0).then(|| (origin + sum / (3.0 * twice), 0.5 * twice))
    }
}

/// Approximate upper bound of the number of pieces; infinite if the coordinates are not finite or too large.
pub(crate) fn count(corners: [DVec2; 3]) -> f64 {
    let [a, b, c] = corners;
    let size = a.max(b).max(c) - a.min(b).min(c);
    let count = 0.5 * (b - a).perp_dot(c - a).abs() + 2.0 * (size.x + size.y) + 4.0;
    // Larger coordinates in f64 cannot represent positions within a cell.
    let near = corners.iter().all(|p| p.abs().max_element() < 1e12);
    if near { count } else { f64::INFINITY }
}

/// Calls `visit` for every piece of the triangle `corners` (in units of cells) with its centroid, its area, and whether
/// it is a whole cell.
pub(crate) fn visit(corners: [DVec2; 3], mut visit: impl FnMut(DVec2, f64, bool)) {
    let whole = triangle(corners);
    let (low, high) = whole.range(|p| p.y);
    let (first, last) = (low.floor() as i64, high.ceil() as i64);
    for row in first..last {
        let (top, bottom) = (row as f64, (row + 1) as f64);
        let strip = whole.clipped(|p| p.y - top).clipped(|p| bottom - p.y);
        if strip.count < 3 {
            continue;
        }
        let inner = if low <= top && high >= bottom { inner(&whole, top, bottom) } else { (1.0, 0.0) };
        let (from, to) = strip.range(|p| p.x);
        let mut column = from.floor();
        while column < to {
            if column >= inner.0 && column + 1.0 <= inner.1 {
                visit(DVec2::new(column + 0.5, top + 0.5), 1.0, true);
            } else {
                let cell = strip.clipped(|p| p.x - column).clipped(|p| column + 1.0 - p.x);
                if let Some((middle, area)) = cell.middle() {
                    visit(middle, area, false);
                }
            }
            column += 1.0;
        }
    }
}

fn triangle([a, b, c]: [DVec2; 3]) -> Polygon {
    let mut corners = [a; 8];
    (corners[1], corners[2]) = (b, c);
    Polygon { corners, count: 3 }
}

/// Range of x that is inside at both heights, and therefore, as the triangle is convex, at all heights in between.
fn inner(whole: &Polygon, top: f64, bottom: f64) -> (f64, f64) {
    let section = |y: f64| {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 0..3 {
            let (a, b) = (whole.corners[i], whole.corners[(i + 1) % 3]);
            if (a.y <= y) != (b.y <= y) || a.y == y {
                let x = if a.y == b.y { a.x } else { a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)) };
                (low, high) = (low.min(x), high.max(x));
            }
        }
        (low, high)
    };
    let (above, below) = (section(top), section(bottom));
    (above.0.max(below.0), above.1.min(below.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pieces fill the triangle, and their centroids average to that of the triangle.
    #[test]
    fn pieces_tile_the_triangle() {
        let triangles = [
            [DVec2::ZERO, DVec2::new(4.0, 0.0), DVec2::new(4.0, 4.0)],
            [DVec2::new(-3.3, 1.7), DVec2::new(20.1, 5.2), DVec2::new(2.0, 33.3)],
            [DVec2::new(0.2, 0.3), DVec2::new(0.4, 0.3), DVec2::new(0.3, 0.6)],
            [DVec2::new(100.5, -7.0), DVec2::new(0.5, -7.0), DVec2::new(50.0, -7.001)],
            [DVec2::new(5.0, 5.0), DVec2::new(1.0, 5.0), DVec2::new(1.0, 9.0)],
        ];
        for corners in triangles {
            let [a, b, c] = corners;
            let (mut sum, mut moment, mut number) = (0.0, DVec2::ZERO, 0);
            visit(corners, |middle, area, is_whole| {
                assert!(!is_whole || area == 1.0);
                (sum, moment, number) = (sum + area, moment + middle * area, number + 1);
            });
            let exact = 0.5 * (b - a).perp_dot(c - a).abs();
            assert!((sum / exact - 1.0).abs() < 1e-9, "{corners:?}: {sum} {exact}");
            assert!((moment / sum - (a + b + c) / 3.0).length() < 1e-8, "{corners:?}");
            assert!(f64::from(number) <= count(corners), "{number} {}", count(corners));
        }
    }
}
