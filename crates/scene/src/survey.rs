//! Statistics and features of a scene, from which the renderer derives what it can leave out.

/// Counts and features of a scene; the kernel that renders it need not support a feature that is false.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Survey {
    /// Number of triangles that can be hit.
    pub triangles: usize,
    /// Number of placed meshes, spheres and disks.
    pub objects: usize,
    /// Number of exact spheres and disks among the objects.
    pub shapes: usize,
    /// Number of materials, including unused ones.
    pub materials: usize,
    /// Number of textures in memory.
    pub textures: usize,
    /// Number of lights, including the environment.
    pub lights: usize,
    /// A used material is not opaque (Mask or Blend).
    pub has_alpha: bool,
    /// A used material looks up a texture.
    pub has_textures: bool,
    /// A used material transmits light.
    pub has_transmission: bool,
    /// A used material absorbs light in its interior.
    pub has_volume: bool,
    /// A used material has a normal map.
    pub has_normal_maps: bool,
    /// A used material is unlit.
    pub has_unlit: bool,
    /// An object, a light or a camera moves while the shutter is open.
    pub has_motion: bool,
    /// A used material interpolates vertex colours.
    pub has_colors: bool,
    /// Number of constant textures that were folded into factors.
    pub constant_textures: usize,
    /// Number of texture channels, of four per texture in memory, that are not stored: no material reads them, or they
    /// are redundant (1 everywhere, or equal to another channel).
    pub dropped_channels: usize,
    /// Parts of the file that were not read.
    pub unread: Unread,
}

/// Counts of the parts of a file that were not read: the scene does not refer to them, or this render does not use
/// them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unread {
    /// Nodes outside the scene, and hidden nodes.
    pub nodes: usize,
    /// Meshes.
    pub meshes: usize,
    /// Materials.
    pub materials: usize,
    /// Images that were not decoded.
    pub images: usize,
}
