//! Objects of the acceleration structure: a mesh or shape with its placement in the world.
use crate::shapes::{Line, Shape};
use crate::{Hit, Mesh, Surface};
use dapple_math::Ray;
use dapple_math::motion::{Motion, Pose};
use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use std::sync::Arc;

#[derive(Debug)]
pub(super) enum Body {
    Mesh(Arc<Mesh>),
    Shape(Shape),
}

/// The placement of an object's space in the world.
#[derive(Debug)]
pub(super) enum Place {
    /// Object space is world space.
    World,
    /// The transform is constant over the shutter interval.
    Fixed(Box<Pose>),
    Moving(Box<Motion>),
    /// The transform flattens the object to a line or a point during the whole shutter interval; it is never hit.
    Nowhere(DAffine3),
}

#[derive(Debug)]
pub(super) struct Object {
    pub body: Body,
    pub place: Place,
    /// For a mesh in the flat tree: index of its first triangle there.
    pub first: u32,
    /// For a mesh in the second level: index of its tree there.
    pub tree: u32,
}

impl Object {
    /// The transform at `time`; None for the identity, and for objects that cannot be hit at that time.
    fn pose(&self, time: f64) -> Option<Pose> {
        match &self.place {
            _ if cfg!(without = "second_level") => None,
            Place::Fixed(pose) => Some(**pose),
            Place::Moving(motion) => motion.pose_at(time),
            Place::World | Place::Nowhere(_) => None,
        }
    }

    /// The ray in object space, with the same t; None when the object cannot be hit at that time.
    pub fn line(&self, ray: &Ray, time: f64) -> Option<Line> {
        let line = Line::from(ray);
        if let Place::World = self.place {
            return Some(line);
        }
        let to_object = match &self.place {
            Place::Fixed(pose) => pose.to_object,
            _ => self.pose(time)?.to_object,
        };
        Some(Line { o: to_object.transform_point3(line.o), d: to_object.transform_vector3(line.d) })
    }

    #[inline(always)]
    pub fn surface(&self, ray: &Ray, time: f64, hit: &Hit) -> Surface {
        match (&self.place, &self.body) {
            (Place::World, Body::Mesh(mesh)) => {
                let (corners, normals) = triangle(mesh, hit);
                Surface::on_triangle(corners, normals, hit.u, hit.v)
            }
            _ if cfg!(without = "second_level") => Surface::on_shape(DVec3::ZERO, DVec3::Z),
            _ => self.second_level_surface(ray, time, hit),
        }
    }

    /// Surface data of objects that are not in the flat tree.
    #[inline(never)]
    fn second_level_surface(&self, ray: &Ray, time: f64, hit: &Hit) -> Surface {
        let pose = self.pose(time);
        match &self.body {
            Body::Mesh(mesh) => {
                let (corners, normals) = triangle(mesh, hit);
                match pose {
                    None => Surface::on_triangle(corners, normals, hit.u, hit.v),
                    Some(pose) => Surface::on_posed_triangle(&pose, corners, normals, hit.u, hit.v),
                }
            }
            Body::Shape(shape) => {
                let line = self.line(ray, time).unwrap_or(Line::from(ray));
                let (p, n) = shape.point(&line, hit.t);
                match pose {
                    None => Surface::on_shape(p, n),
                    Some(pose) => Surface::on_posed_shape(&pose, p, n),
                }
            }
        }
    }

    /// Surface coordinates of the point of a shape that is nearest to `p`; None for a mesh.
    pub fn coordinates_at(&self, p: Vec3, time: f64) -> Option<Vec2> {
        let Body::Shape(shape) = &self.body else { return None };
        let p = p.as_dvec3();
        let own = self.pose(time).map_or(p, |pose| pose.to_object.transform_point3(p));
        Some(shape.coordinates(&Line { o: own, d: DVec3::ZERO }, 0.0))
    }

    pub fn lift(&self, hit: &Hit, up: Vec3, time: f64) -> Vec3 {
        let Body::Mesh(mesh) = &self.body else { return Vec3::ZERO };
        let Some(normals) = mesh.values(&mesh.normals, hit.primitive) else { return Vec3::ZERO };
        let corners = mesh.corners(hit.primitive).map(Vec3::as_dvec3);
        let normals = normals.map(Vec3::as_dvec3);
        let (corners, normals) = match self.pose(time) {
            None => (corners, normals),
            Some(pose) => {
                let map = pose.normals();
                (corners.map(|p| pose.to_world.transform_point3(p)), normals.map(|n| map.apply(n)))
            }
        };
        crate::surface::lift(corners, normals, hit.u, hit.v, up.as_dvec3()).as_vec3()
    }

    pub fn tangent(&self, hit: &Hit, time: f64) -> Option<Vec4> {
        let Body::Mesh(mesh) = &self.body else { return None };
        let tangent = mesh.tangent_at(hit.primitive, hit.u, hit.v)?;
        let Some(pose) = self.pose(time) else { return Some(tangent) };
        Some(posed_tangent(&pose, tangent))
    }

    pub fn corners(&self, primitive: u32, time: f64) -> [Vec3; 3] {
        let Body::Mesh(mesh) = &self.body else { return [Vec3::ZERO; 3] };
        let corners = mesh.corners(primitive);
        match self.placement(time) {
            None => corners,
            Some(m) => corners.map(|p| m.transform_point3(p.as_dvec3()).as_vec3()),
        }
    }

    /// As [`Object::corners`], without rounding to f32.
    pub fn corners_exact(&self, primitive: u32, time: f64) -> [DVec3; 3] {
        let Body::Mesh(mesh) = &self.body else { return [DVec3::ZERO; 3] };
        let corners = mesh.corners(primitive).map(Vec3::as_dvec3);
        match self.placement(time) {
            None => corners,
            Some(m) => corners.map(|p| m.transform_point3(p)),
        }
    }

    /// Bound per axis of the error of a surface point relative to other surfaces. A shape is exact for ray queries, but
    /// its parameters were rounded: centre and radius, by up to half an ulp of each.
    pub fn coincidence_error(&self, surface: &Surface, time: f64) -> DVec3 {
        let p_error = surface.p_error.as_dvec3();
        let Body::Shape(shape) = &self.body else { return p_error };
        let error = shape.coordinate_error();
        p_error + self.pose(time).map_or(error, |pose| pose.error(error))
    }

    /// Transforms map the front side to the front side, so the test can be done in object space: with d' the direction
    /// there, n·d has the sign of n'·d'.
    pub fn is_from_behind(&self, primitive: u32, d: Vec3, time: f64) -> bool {
        let Body::Mesh(mesh) = &self.body else { return false };
        let [a, b, c] = mesh.corners(primitive);
        match self.pose(time) {
            None => (b - a).cross(c - a).dot(d) > 0.0,
            Some(pose) => {
                let normal = (b - a).as_dvec3().cross((c - a).as_dvec3());
                normal.dot(pose.to_object.transform_vector3(d.as_dvec3())) > 0.0
            }
        }
    }

    pub fn placement(&self, time: f64) -> Option<DAffine3> {
        match &self.place {
            Place::World => None,
            Place::Fixed(pose) => Some(pose.to_world),
            Place::Moving(motion) => Some(motion.at(time)),
            Place::Nowhere(m) => Some(*m),
        }
    }

    /// Whether a static instance is mirrored, so that its corners are clockwise when seen from the front.
    pub fn is_mirrored(&self) -> bool {
        matches!(&self.place, Place::Fixed(pose) if pose.is_mirrored())
    }

    pub fn is_moving(&self) -> bool {
        matches!(self.place, Place::Moving(_))
    }

    pub fn mesh(&self) -> Option<&Arc<Mesh>> {
        match &self.body {
            Body::Mesh(mesh) => Some(mesh),
            Body::Shape(_) => None,
        }
    }
}

/// Corners and normals of the triangle that was hit.
#[inline]
fn triangle(mesh: &Mesh, hit: &Hit) -> ([Vec3; 3], Option<[Vec3; 3]>) {
    (mesh.corners(hit.primitive), mesh.values(&mesh.normals, hit.primitive))
}

/// Transforms a tangent with the surface; a mirroring transform inverts the sign of the bitangent w·(n × t).
fn posed_tangent(pose: &Pose, tangent: Vec4) -> Vec4 {
    let along: DVec3 = pose.to_world.transform_vector3(tangent.truncate().as_dvec3());
    let sign = if pose.is_mirrored() { -tangent.w } else { tangent.w };
    dapple_math::vector::unit_or(along, DVec3::ZERO).as_vec3().extend(sign)
}

/// `mesh` transformed to world space: positions, normals and tangents are transformed, and a mirroring transform
/// reverses the winding so that the front side is preserved.
pub(super) fn baked(mesh: &Mesh, pose: &Pose) -> Mesh {
    let mirrored = pose.is_mirrored();
    let point = |p: &Vec3| pose.to_world.transform_point3(p.as_dvec3()).as_vec3();
    let map = pose.normals();
    let normal = |n: &Vec3| map.apply(n.as_dvec3()).as_vec3();
    Mesh {
        positions: mesh.positions.iter().map(point).collect(),
        triangles: mesh
            .triangles
            .iter()
            .map(|&[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] })
            .collect(),
        normals: mesh.normals.iter().map(normal).collect(),
        tangents: mesh.tangents.iter().map(|t| posed_tangent(pose, *t)).collect(),
        uv: mesh.uv.clone(),
        colors: mesh.colors.clone(),
    }
}
