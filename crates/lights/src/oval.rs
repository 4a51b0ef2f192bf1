//! Sampling of spheres and disks under a non-uniform transform (ellipsoids and ellipses): in their local space, where
//! they are round.
//!
//! A linear map M takes the unit direction d' of local space to M·d', of length s. It stretches solid angle by
//! |det M|/s³, lengths along the direction by s, and area on a surface with unit normal n' by |cof(M)·n'|, the length
//! of its normal in render space.
use crate::aimed::{Aimed, visible};
use crate::{Aiming, Area, AreaShape, LightPoint, LightSample, sphere};
use dapple_math::motion::Pose;
use dapple_sampling::warp;
use glam::{DMat3, DVec3, Vec2, Vec3};
use std::f64::consts::PI;

/// A sphere or disk in its local space, and its pose.
pub(crate) struct Oval<'a> {
    pub area: &'a Area,
    pub pose: &'a Pose,
}

impl Oval<'_> {
    pub fn sample_as(&self, aiming: Aiming, p: Vec3, u: Vec2) -> Option<LightSample> {
        let aimed = match (self.area.shape, aiming) {
            (AreaShape::Sphere { centre, radius }, Aiming::SolidAngle) => self.cone(p, centre, radius, u),
            (AreaShape::Sphere { centre, radius }, Aiming::Surface) => {
                let n = warp::sphere(u);
                self.at(p, centre + n * radius, n, 4.0 * PI * f64::from(radius * radius))
            }
            (AreaShape::Sphere { centre, radius }, Aiming::Centroid) => {
                return self.middle(p, centre, radius);
            }
            (AreaShape::Disk { centre, normal, radius }, _) => {
                let u = if aiming == Aiming::Centroid { Vec2::splat(0.5) } else { u };
                let (x, y) = normal.any_orthonormal_pair();
                let at = warp::disk(u) * radius;
                self.at(p, centre + x * at.x + y * at.y, normal, PI * f64::from(radius * radius))
            }
            _ => None,
        }?;
        if aiming == Aiming::Centroid { self.area.as_point(aimed) } else { self.area.sample_at(aimed) }
    }

    pub fn pdf_as(&self, aiming: Aiming, p: Vec3, wi: Vec3, distance: f32) -> f32 {
        let own = self.pose.to_object.transform_vector3(wi.as_dvec3());
        let along = own.normalize_or_zero();
        let reached = self.pose.to_object.transform_point3(p.as_dvec3()) + own * f64::from(distance);
        let pdf = match (self.area.shape, aiming) {
            (_, Aiming::Centroid) => 0.0,
            (AreaShape::Sphere { centre, radius }, Aiming::SolidAngle) => {
                let from = self.pose.to_object.transform_point3(p.as_dvec3()).as_vec3();
                sphere::pdf(from, centre, radius, self.area.two_sided) * self.per_solid_angle(along)
            }
            (AreaShape::Sphere { centre, radius }, Aiming::Surface) => {
                let n = (reached - centre.as_dvec3()).normalize_or_zero();
                self.density(wi.as_dvec3(), distance.into(), n, 4.0 * PI * f64::from(radius * radius))
            }
            (AreaShape::Disk { normal, radius, .. }, _) => {
                let whole = PI * f64::from(radius * radius);
                self.density(wi.as_dvec3(), distance.into(), normal.as_dvec3(), whole)
            }
            _ => 0.0,
        };
        (pdf as f32).min(f32::MAX)
    }

    /// Surface area in square render units. For an ellipsoid it is the mean over the normals of the sphere by the
    /// midpoint rule in height and angle; for axes up to 1 : 30 the error is a few parts in a thousand.
    pub fn surface(&self) -> f64 {
        let m = &self.pose.to_world.matrix3;
        let stretch = |n: Vec3| (cofactor(m) * n.as_dvec3()).length();
        match self.area.shape {
            AreaShape::Disk { normal, radius, .. } => PI * f64::from(radius * radius) * stretch(normal),
            AreaShape::Sphere { radius, .. } => {
                const N: u32 = 32;
                let place = |i: u32| Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.5) / N as f32;
                let mean = (0..N * N).map(|i| stretch(warp::sphere(place(i)))).sum::<f64>();
                4.0 * PI * f64::from(radius * radius) * mean / f64::from(N * N)
            }
            _ => 0.0,
        }
    }

    /// Unit normal of the front in render space; None for shapes that emit in all directions.
    pub fn normal(&self) -> Option<DVec3> {
        let AreaShape::Disk { normal, .. } = self.area.shape else { return None };
        Some(self.pose.normals().apply(normal.as_dvec3()))
    }

    /// Samples uniformly in the cone that the sphere subtends in its local space.
    fn cone(&self, p: Vec3, centre: Vec3, radius: f32, u: Vec2) -> Option<Aimed> {
        let from = self.pose.to_object.transform_point3(p.as_dvec3()).as_vec3();
        let own = sphere::sample(from, centre, radius, self.area.two_sided, u)?;
        let along = own.wi.as_dvec3();
        let to = self.pose.to_world.transform_vector3(along);
        let (wi, s) = (to.normalize(), to.length());
        let pdf = (f64::from(own.pdf) * self.per_solid_angle(along)) as f32;
        let (n, point) = (own.point.n, own.point.p);
        let point = self.place(point, n);
        let distance = (f64::from(own.distance) * s) as f32;
        (pdf > 0.0 && pdf.is_finite()).then_some(Aimed { wi: wi.as_vec3(), distance, pdf, point })
    }

    /// Solid angle in local space per solid angle in render space, about the unit direction `along` of local space.
    fn per_solid_angle(&self, along: DVec3) -> f64 {
        let m = &self.pose.to_world.matrix3;
        let s = (*m * along).length();
        s * s * s / m.determinant().abs()
    }

    /// Samples a point given in local space with the unit normal `n`, drawn uniformly from a surface of area `whole`.
    fn at(&self, p: Vec3, place: Vec3, n: Vec3, whole: f64) -> Option<Aimed> {
        let to = self.pose.to_world.transform_point3(place.as_dvec3()) - p.as_dvec3();
        let (wi, distance) = (to.try_normalize()?, to.length());
        let pdf = self.density(wi, distance, n.as_dvec3(), whole) as f32;
        let usable = pdf > 0.0 && pdf.is_finite();
        let point = self.place(place, n);
        usable.then(|| Aimed { wi: wi.as_vec3(), distance: distance as f32, pdf, point })
    }

    /// distance²/(cosθ·area) in render space, where area is `whole` scaled by the area stretch at `n`.
    fn density(&self, wi: DVec3, distance: f64, n: DVec3, whole: f64) -> f64 {
        let stretch = (cofactor(&self.pose.to_world.matrix3) * n).length();
        let cos = -wi.dot(self.pose.normals().apply(n));
        visible(cos, self.area.two_sided).map_or(0.0, |cos| distance * distance / (whole * stretch * cos))
    }

    fn place(&self, own: Vec3, n: Vec3) -> LightPoint {
        let p = self.pose.to_world.transform_point3(own.as_dvec3()).as_vec3();
        let rounding = Vec3::splat(own.abs().max_element().max(1.0) * (4.0 * f32::EPSILON));
        let p_error = self.pose.error(rounding.as_dvec3()).as_vec3() + p.abs() * f32::EPSILON;
        let n = self.pose.normals().apply(n.as_dvec3()).as_vec3();
        LightPoint { p, p_error, n, triangle: 0, u: 0.0, v: 0.0 }
    }

    /// An ellipsoid as one point with its intensity in the far field: radiance times projected area, πR²|det
    /// M|·|M⁻¹·ω|.
    fn middle(&self, p: Vec3, centre: Vec3, radius: f32) -> Option<LightSample> {
        let to = self.pose.to_world.transform_point3(centre.as_dvec3()) - p.as_dvec3();
        let (wi, d) = (to.try_normalize()?, to.length());
        let own = self.pose.to_object.transform_vector3(wi);
        let outline = self.pose.to_world.matrix3.determinant().abs() * own.length();
        let r = f64::from(radius);
        let n = -own.normalize().as_vec3();
        let near = self.place(centre + n * radius, n);
        let is_outside = d * own.length() > r;
        Some(LightSample {
            wi: wi.as_vec3(),
            pdf: 1.0,
            delta: true,
            radiance: self.area.radiance * (PI * r * r * outline / (d * d)) as f32,
            distance: d as f32,
            point: is_outside.then_some(near),
        })
    }
}

/// Maps normals to render space: det(M)·M⁻ᵀ without the inverse.
fn cofactor(m: &DMat3) -> DMat3 {
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}
