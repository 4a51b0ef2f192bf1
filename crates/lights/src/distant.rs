//! Light from one direction.
use glam::Vec3;
/// `towards` = unit direction to the light; `irradiance` on a facing surface (lx read as W/m²).
#[derive(Clone, Copy, Debug)]
pub struct Distant {
    pub towards: Vec3,
    pub irradiance: Vec3,
}
