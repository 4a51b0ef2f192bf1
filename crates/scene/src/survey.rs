//! What a scene contains, exactly (what can be left out follows from it).

/// Counts and questions; a feature that is false need not exist in the kernel that renders the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Survey {
    /// Triangles that can be hit.
    pub triangles: usize,
    /// Meshes, spheres and disks placed in the scene.
    pub objects: usize,
    /// Exact spheres and disks among the objects.
    pub shapes: usize,
    /// Materials, used or not.
    pub materials: usize,
    /// Texture maps in memory.
    pub textures: usize,
    /// Lights, the environment included.
    pub lights: usize,
    /// Some used material has holes (Mask or Blend).
    pub has_alpha: bool,
    /// Some used material looks up a texture.
    pub has_textures: bool,
    /// Some used material transmits light.
    pub has_transmission: bool,
    /// Some used material absorbs light in its inside.
    pub has_volume: bool,
    /// Some used material has a normal map.
    pub has_normal_maps: bool,
    /// Some used material is shadeless.
    pub has_unlit: bool,
    /// An object, a light or a camera moves while the shutter is open.
    pub has_motion: bool,
    /// Some used material interpolates colours of vertices.
    pub has_colors: bool,
    /// Textures of one colour that became factors.
    pub constant_textures: usize,
    /// Channels of the textures in memory, of four each, that are not kept: no material reads them, or they hold nothing
    /// new (1 everywhere, or the same as another).
    pub dropped_channels: usize,
    /// What the file holds and the picture does not need.
    pub unread: Unread,
}

/// Parts of a file that were left alone: nothing in the scene refers to them, or this render does not look at them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unread {
    /// Nodes outside the scene, or hidden.
    pub nodes: usize,
    /// Meshes.
    pub meshes: usize,
    /// Materials.
    pub materials: usize,
    /// Images, not decoded.
    pub images: usize,
}
