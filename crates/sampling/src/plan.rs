//! How many points an integral gets, and which: `4x4:stratified`, `16:random`, `1`, `0`.
use crate::{Key, Pattern};
use glam::Vec2;
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Plan {
    pub nx: u32,
    pub ny: u32,
    pub pattern: Pattern,
}
impl Plan {
    pub fn count(self) -> u32 {
        self.nx * self.ny
    }
    pub fn point_2d(self, _s: u32, _key: Key) -> Vec2 {
        todo!()
    }
    pub fn point_1d(self, _s: u32, _key: Key) -> f32 {
        todo!()
    }
}
// plus FromStr (typed error PlanError) and Display that round-trip
