//! Objects of a scene under construction: geometry, validation and bounds.
use crate::{Placement, bake, exposure::Exposure, form::Form};
use dapple_geometry::Mesh;
use dapple_geometry::shapes::{Disk, Shape, Sphere};
use dapple_math::motion::Chain;
use glam::{DVec3, Vec3};
use std::{collections::HashSet, sync::Arc};

/// An object with its name and material.
#[derive(Debug)]
pub(crate) struct Placed {
    pub name: Arc<str>,
    pub material: u32,
    pub geometry: Geometry,
    /// Objects of the same group bound one body.
    pub group: u32,
    /// Index of the node in the file, or of the object for scenes built in code.
    pub node: u32,
}

#[derive(Debug)]
pub(crate) enum Geometry {
    Mesh { mesh: Arc<Mesh>, placement: Placement },
    Sphere { centre: DVec3, radius: f64 },
    Disk { centre: DVec3, normal: DVec3, radius: f64 },
    Moving { body: Body, chain: Chain },
}

/// Geometry at the end of a chain of nodes.
#[derive(Debug)]
pub(crate) enum Body {
    Mesh(Arc<Mesh>),
    /// A sphere about the origin.
    Sphere {
        radius: f64,
    },
    /// A disk about the origin, facing +z.
    Disk {
        radius: f64,
    },
}

impl Body {
    /// Radius of a sphere or disk; None for a mesh.
    pub fn radius(&self) -> Option<f64> {
        match self {
            Self::Mesh(_) => None,
            Self::Sphere { radius } | Self::Disk { radius } => Some(*radius),
        }
    }

    /// Shape for light creation, in the body's own space.
    pub fn form(&self) -> Form {
        match self {
            Self::Mesh(mesh) => Form::Triangles(mesh.triangles.len()),
            Self::Sphere { .. } => Form::Sphere { centre: Vec3::ZERO, radius: 1.0 },
            Self::Disk { .. } => Form::Disk { centre: Vec3::ZERO, normal: Vec3::Z, radius: 1.0 },
        }
    }

    /// Static geometry of the body at a placement; spheres and disks use the mean of the scales.
    pub fn placed(&self, placement: &Placement) -> Geometry {
        let (m, centre) = (&placement.linear, placement.point(DVec3::ZERO));
        let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(DVec3::length);
        match self {
            Self::Mesh(mesh) => Geometry::Mesh { mesh: mesh.clone(), placement: *placement },
            Self::Sphere { radius } => Geometry::Sphere { centre, radius: radius * ((x + y + z) / 3.0) },
            Self::Disk { radius } => {
                let normal = m.x_axis.cross(m.y_axis);
                let normal = if normal.dot(m.z_axis) < 0.0 { -normal } else { normal };
                Geometry::Disk { centre, normal, radius: radius * ((x + y) / 2.0) }
            }
        }
    }

    /// World-space bounding box of the body at a placement.
    pub fn bounds(&self, placement: &Placement) -> Option<(DVec3, DVec3)> {
        let Some(radius) = self.radius() else {
            let Self::Mesh(mesh) = self else { return None };
            return bake::bounds(mesh, placement);
        };
        let m = &placement.linear;
        let longest = m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length());
        let (centre, half) = (placement.point(DVec3::ZERO), DVec3::splat(radius * longest));
        Some((centre - half, centre + half))
    }

    /// Sphere or disk of radius 1; None for a mesh.
    pub fn unit_shape(&self) -> Option<Shape> {
        match self {
            Self::Mesh(_) => None,
            Self::Sphere { .. } => Some(Shape::Sphere(Sphere { centre: Vec3::ZERO, radius: 1.0 })),
            Self::Disk { .. } => Some(Shape::Disk(Disk { centre: Vec3::ZERO, normal: Vec3::Z, radius: 1.0 })),
        }
    }
}

impl Placed {
    pub fn form(&self) -> Form {
        match &self.geometry {
            Geometry::Mesh { mesh, .. } => Form::Triangles(mesh.triangles.len()),
            Geometry::Sphere { .. } => Form::Sphere { centre: Vec3::ZERO, radius: 1.0 },
            Geometry::Disk { .. } => Form::Disk { centre: Vec3::ZERO, normal: Vec3::Z, radius: 1.0 },
            Geometry::Moving { body, .. } => body.form(),
        }
    }

    pub fn mesh(&self) -> Option<&Mesh> {
        match &self.geometry {
            Geometry::Mesh { mesh, .. } | Geometry::Moving { body: Body::Mesh(mesh), .. } => Some(mesh),
            _ => None,
        }
    }

    /// Describes the first problem of the object. Each mesh is checked once: `sound` holds the addresses of valid
    /// meshes.
    pub fn fault(&self, materials: usize, sound: &mut HashSet<usize>) -> Option<String> {
        if self.material as usize >= materials {
            return Some(format!("uses material {}, but there are {materials}", self.material));
        }
        match &self.geometry {
            Geometry::Mesh { placement, .. } if !placement.is_finite() => {
                Some("its transform is not finite".into())
            }
            Geometry::Mesh { mesh, .. } | Geometry::Moving { body: Body::Mesh(mesh), .. } => {
                let address = Arc::as_ptr(mesh) as usize;
                if sound.contains(&address) {
                    return None;
                }
                let fault = bake::fault(mesh);
                if fault.is_none() {
                    sound.insert(address);
                }
                fault
            }
            Geometry::Moving { body, .. } => {
                let bad = body.radius().is_some_and(|radius| !(radius > 0.0 && radius.is_finite()));
                bad.then(|| "its radius must be finite and above 0".into())
            }
            Geometry::Sphere { centre, radius } | Geometry::Disk { centre, radius, .. }
                if !(centre.is_finite() && *radius > 0.0 && radius.is_finite()) =>
            {
                Some("its radius must be finite and above 0, and its centre finite".into())
            }
            Geometry::Disk { normal, .. } if normal.try_normalize().is_none() => {
                Some("its normal has no direction".into())
            }
            _ => None,
        }
    }

    /// Bounding box in the object's own space, flat for flat objects, and the ratio of world to own volume when the
    /// shutter opens.
    pub fn own_box(&self, exposure: &Exposure) -> Option<((DVec3, DVec3), f64)> {
        let round = |radius: f64, flat: bool| {
            let half = DVec3::new(radius, radius, if flat { 0.0 } else { radius });
            (-half, half)
        };
        let of = |placement: &Placement| placement.linear.determinant().abs();
        match &self.geometry {
            Geometry::Mesh { mesh, placement } => {
                Some((bake::bounds(mesh, &Placement::IDENTITY)?, of(placement)))
            }
            Geometry::Sphere { radius, .. } => Some((round(*radius, false), 1.0)),
            Geometry::Disk { radius, .. } => Some((round(*radius, true), 1.0)),
            Geometry::Moving { body, chain } => {
                Some((body.bounds(&Placement::IDENTITY)?, of(&exposure.placement(chain))))
            }
        }
    }

    /// World-space bounding box when the shutter opens.
    pub fn bounds(&self, exposure: &Exposure) -> Option<(DVec3, DVec3)> {
        match &self.geometry {
            Geometry::Moving { body, chain } => body.bounds(&exposure.placement(chain)),
            Geometry::Mesh { mesh, placement } => bake::bounds(mesh, placement),
            // A disk uses the box of the sphere: an *approximation* that only makes the bounds slightly larger.
            Geometry::Sphere { centre, radius } | Geometry::Disk { centre, radius, .. } => {
                Some((*centre - DVec3::splat(*radius), *centre + DVec3::splat(*radius)))
            }
        }
    }
}
