//! Ray intersection with exact spheres and disks, solved in f64 with formulas that avoid cancellation \[Haines 2019\].
//!
//! Shapes are surfaces, not solids: they are hit from both sides, and a ray may start on or inside them. A shape with a
//! non-finite parameter or a radius that is not positive is never hit.
use dapple_math::{Aabb, vector::unit_or};
use dapple_math::{Frame, Ray, offset::gamma};
use glam::{DVec3, Vec2, Vec3};

/// The points at distance `radius` from `centre`; the front side faces outward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The centre.
    pub centre: Vec3,
    /// The radius, greater than zero.
    pub radius: f32,
}

/// The points of a plane within `radius` of `centre`; the front side is the one that `normal` points to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    /// The centre.
    pub centre: Vec3,
    /// The normal, of any length except zero.
    pub normal: Vec3,
    /// The radius, greater than zero.
    pub radius: f32,
}

/// An exact surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A sphere.
    Sphere(Sphere),
    /// A disk.
    Disk(Disk),
}

/// The line of points `o + t·d` in the shape's space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub o: DVec3,
    pub d: DVec3,
}

impl From<&Ray> for Line {
    fn from(ray: &Ray) -> Self {
        Self { o: ray.o.as_dvec3(), d: ray.d.as_dvec3() }
    }
}

/// Relative distance below which f64 cannot distinguish a ray origin from the surface.
const ON_SURFACE: f64 = 1.0 / (1u64 << 48) as f64;

impl Shape {
    /// Distances t > 0 of the intersections along the line, in increasing order.
    pub(crate) fn roots(&self, line: &Line) -> [Option<f32>; 2] {
        match self {
            Self::Sphere(s) => s.roots(line),
            Self::Disk(d) => [d.root(line), None],
        }
    }

    /// The point at `t` projected onto the surface, and the unit normal of the front side there.
    pub(crate) fn point(&self, line: &Line, t: f32) -> (DVec3, DVec3) {
        match self {
            Self::Sphere(s) => s.point(line, t),
            Self::Disk(d) => d.point(line, t),
        }
    }

    /// Surface coordinates of a hit (see [`Hit::u`](crate::Hit::u)).
    pub(crate) fn coordinates(&self, line: &Line, t: f32) -> Vec2 {
        let (p, n) = self.point(line, t);
        match self {
            Self::Sphere(_) => octahedral(n),
            Self::Disk(d) => {
                let q = (p - d.centre.as_dvec3()) / f64::from(d.radius);
                Frame::from_z(n.as_vec3()).to_local(q.as_vec3()).truncate()
            }
        }
    }

    /// Texture coordinates. Sphere: longitude ½ + atan2(nₓ, −n_z)/2π and colatitude acos(n_y)/π, as in an environment
    /// map. Disk: the angle about the normal in turns and the distance from the centre in radii.
    pub(crate) fn uv(&self, u: f32, v: f32) -> Vec2 {
        use std::f32::consts::{PI, TAU};
        match self {
            Self::Sphere(_) => {
                let n = from_octahedral(u, v);
                Vec2::new(0.5 + libm::atan2f(n.x, -n.z) / TAU, libm::acosf(n.y.clamp(-1.0, 1.0)) / PI)
            }
            Self::Disk(_) => {
                let turns = libm::atan2f(v, u) / TAU;
                Vec2::new(if turns < 0.0 { turns + 1.0 } else { turns }, Vec2::new(u, v).length())
            }
        }
    }

    /// Error bound per axis of the surface due to the rounding of the shape's parameters.
    pub(crate) fn coordinate_error(&self) -> DVec3 {
        let (centre, radius) = match self {
            Self::Sphere(s) => (s.centre, s.radius),
            Self::Disk(d) => (d.centre, d.radius),
        };
        (centre.as_dvec3().abs() + DVec3::splat(radius.into())) * f64::from(gamma(4))
    }

    /// Maps `u` in \[0, 1\]² to surface coordinates, uniformly in area.
    pub(crate) fn even_coordinates(&self, u: Vec2) -> Vec2 {
        let (sin, cos) = libm::sincosf(std::f32::consts::TAU * u.x);
        match self {
            Self::Sphere(_) => {
                let z = 1.0 - 2.0 * u.y;
                let r = (1.0 - z * z).max(0.0).sqrt();
                octahedral(Vec3::new(r * cos, r * sin, z).as_dvec3())
            }
            Self::Disk(_) => Vec2::new(cos, sin) * u.y.sqrt(),
        }
    }

    /// The bounding box; empty for a shape that is never hit.
    pub(crate) fn bounds(&self) -> Aabb {
        let (centre, half) = match self {
            Self::Sphere(s) if s.is_valid() => (s.centre, DVec3::splat(s.radius.into())),
            Self::Disk(d) if d.is_valid() => (d.centre, d.half_widths()),
            _ => return Aabb::EMPTY,
        };
        Aabb::new(centre.as_dvec3() - half, centre.as_dvec3() + half)
    }
}

impl Sphere {
    /// With f = o − c, a = d·d, b = −f·d: Δ = (R − |l|)(R + |l|), l = f + (b/a)d; q = b + sign(b)√(aΔ);
    /// t = (|f| − R)(|f| + R)/q and q/a \[Haines 2019, ch. 7\].
    fn roots(&self, line: &Line) -> [Option<f32>; 2] {
        let (f, d, r) = (line.o - self.centre.as_dvec3(), line.d, f64::from(self.radius));
        let (a, b, length) = (d.length_squared(), -f.dot(d), f.length());
        let l = (f + d * (b / a)).length();
        let delta = (r - l) * (r + l);
        // The condition is also false for NaN, so that a NaN is not a hit.
        if !(a > 0.0 && r > 0.0 && delta >= 0.0) {
            return [None; 2];
        }
        let q = b + (a * delta).sqrt().copysign(b);
        let outside = length - r;
        // If the origin is on the surface within rounding, that root is the origin itself.
        let c = if outside.abs() <= ON_SURFACE * r { 0.0 } else { outside * (length + r) };
        let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (c / q, q / a) };
        [ahead(t0.min(t1)), ahead(t0.max(t1))]
    }

    fn point(&self, line: &Line, t: f32) -> (DVec3, DVec3) {
        let c = self.centre.as_dvec3();
        let n = unit_or(line.o - c + line.d * f64::from(t), DVec3::Z);
        (c + n * f64::from(self.radius), n)
    }

    fn is_valid(&self) -> bool {
        self.centre.is_finite() && self.radius.is_finite() && self.radius > 0.0
    }
}

impl Disk {
    /// t = n·(c − o)/n·d if the line crosses the plane within the radius; None for a line in the plane.
    fn root(&self, line: &Line) -> Option<f32> {
        let (n, f) = (self.unit_normal(), line.o - self.centre.as_dvec3());
        let height = -n.dot(f);
        if height.abs() <= ON_SURFACE * n.abs().dot(f.abs()) {
            return None;
        }
        let t = height / n.dot(line.d);
        let q = f + line.d * t;
        let inside = (q - n * n.dot(q)).length() <= f64::from(self.radius);
        if inside && self.is_valid() { ahead(t) } else { None }
    }

    fn point(&self, line: &Line, t: f32) -> (DVec3, DVec3) {
        let (n, c) = (self.unit_normal(), self.centre.as_dvec3());
        let q = line.o - c + line.d * f64::from(t);
        (c + (q - n * n.dot(q)), n)
    }

    /// R·√(1 − nᵢ²) per axis.
    fn half_widths(&self) -> DVec3 {
        let n = self.unit_normal();
        (DVec3::ONE - n * n).max(DVec3::ZERO).map(f64::sqrt) * f64::from(self.radius)
    }

    fn unit_normal(&self) -> DVec3 {
        unit_or(self.normal.as_dvec3(), DVec3::Z)
    }

    fn is_valid(&self) -> bool {
        let finite = self.normal.is_finite() && self.centre.is_finite() && self.radius.is_finite();
        finite && self.normal != Vec3::ZERO && self.radius > 0.0
    }
}

/// `t` as f32 if it is positive and finite.
fn ahead(t: f64) -> Option<f32> {
    let t = t as f32;
    (t > 0.0 && t.is_finite()).then_some(t)
}

/// Maps a unit vector to the square \[−1, 1\]² \[Cigolle 2014\], which is cheap and has no poles.
fn octahedral(n: DVec3) -> Vec2 {
    let s = n.abs().element_sum();
    let (x, y) = (n.x / s, n.y / s);
    let fold = |a: f64, b: f64| (1.0 - b.abs()).copysign(a);
    let (x, y) = if n.z < 0.0 { (fold(x, y), fold(y, x)) } else { (x, y) };
    Vec2::new(x as f32, y as f32)
}

/// The inverse of [`octahedral`].
fn from_octahedral(u: f32, v: f32) -> Vec3 {
    let z = 1.0 - u.abs() - v.abs();
    let fold = (-z).max(0.0);
    let n = Vec3::new(u - fold.copysign(u), v - fold.copysign(v), z);
    n / n.length()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(o: Vec3, d: Vec3) -> Line {
        Line::from(&Ray::new(o, d))
    }

    #[test]
    fn octahedral_round_trip() {
        for i in 0..2000 {
            let (a, z) = (i as f64 * 2.399963, 1.0 - (i as f64 + 0.5) / 1000.0);
            let r = (1.0 - z * z).sqrt();
            let n = DVec3::new(r * a.cos(), r * a.sin(), z);
            let e = octahedral(n);
            assert!((from_octahedral(e.x, e.y).as_dvec3() - n).length() < 5e-7, "{n:?}");
        }
        for n in [DVec3::Z, -DVec3::Z, DVec3::X, -DVec3::Y] {
            let e = octahedral(n);
            assert!((from_octahedral(e.x, e.y).as_dvec3() - n).length() < 1e-7);
        }
    }

    #[test]
    fn both_crossings_from_outside_one_from_inside_none_from_behind() {
        let s = Shape::Sphere(Sphere { centre: Vec3::new(1.0, 2.0, 3.0), radius: 2.0 });
        let t = |o, d| s.roots(&line(o, d));
        assert_eq!(t(Vec3::new(1.0, 2.0, 8.0), -Vec3::Z), [Some(3.0), Some(7.0)]);
        assert_eq!(t(Vec3::new(1.0, 2.0, 3.0), Vec3::X * 0.5), [None, Some(4.0)]);
        assert_eq!(t(Vec3::new(1.0, 2.0, 8.0), Vec3::Z), [None, None]);
        assert_eq!(t(Vec3::new(1.0, 2.0, 5.0), Vec3::Z), [None, None]);
        assert_eq!(t(Vec3::new(1.0, 2.0, 5.0), -Vec3::Z), [None, Some(4.0)]);
        assert_eq!(t(Vec3::NAN, Vec3::Z), [None, None]);
        assert_eq!(t(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO), [None, None]);
        let point = Shape::Sphere(Sphere { centre: Vec3::ZERO, radius: 0.0 });
        assert_eq!(point.roots(&line(Vec3::Z, -Vec3::Z)), [None; 2]);
        assert_eq!(point.bounds(), Aabb::EMPTY);
    }

    #[test]
    fn disk_edge_sides_and_coordinates() {
        let disk = Shape::Disk(Disk { centre: Vec3::Z, normal: Vec3::Z * 3.0, radius: 0.5 });
        let hit = |x, d| disk.roots(&line(Vec3::new(x, 0.0, 2.0), d))[0];
        assert_eq!(hit(0.5, -Vec3::Z), Some(1.0));
        assert_eq!(hit(0.5000001, -Vec3::Z), None);
        assert_eq!(hit(0.2, Vec3::Z), None);
        assert_eq!(hit(0.2, Vec3::X), None);
        let from_below = line(Vec3::new(0.125, 0.0, 0.0), Vec3::Z * 2.0);
        assert_eq!(disk.roots(&from_below)[0], Some(0.5));
        assert_eq!(disk.point(&from_below, 0.5), (DVec3::new(0.125, 0.0, 1.0), DVec3::Z));
        assert_eq!(disk.coordinates(&from_below, 0.5).length(), 0.25);
        assert_eq!(disk.uv(0.0, -0.5), Vec2::new(0.75, 0.5));
        assert_eq!(disk.bounds(), Aabb::new(DVec3::new(-0.5, -0.5, 1.0), DVec3::new(0.5, 0.5, 1.0)));
    }

    #[test]
    fn sphere_uv_follows_the_environment() {
        let s = Shape::Sphere(Sphere { centre: Vec3::ONE, radius: 2.0 });
        let uv = |d: Vec3| {
            let l = line(Vec3::ONE, d);
            let e = s.coordinates(&l, s.roots(&l)[1].unwrap());
            s.uv(e.x, e.y)
        };
        assert!((uv(-Vec3::Z) - Vec2::new(0.5, 0.5)).length() < 1e-6);
        assert!((uv(Vec3::X) - Vec2::new(0.75, 0.5)).length() < 1e-6);
        assert!(uv(Vec3::Y).y < 1e-3);
    }
}
