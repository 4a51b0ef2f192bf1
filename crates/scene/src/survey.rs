//! What a scene contains, exactly (what can be left out follows from it).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Survey {
    pub triangles: usize,
    pub objects: usize,
    pub materials: usize,
    pub textures: usize,
    pub lights: usize,
    pub has_alpha: bool,
    pub has_textures: bool,
    pub has_transmission: bool,
    pub has_volume: bool,
    pub has_normal_maps: bool,
}
