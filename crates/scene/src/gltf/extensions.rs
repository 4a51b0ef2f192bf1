//! Which glTF extensions dapple honours, and what an unsupported optional one will change in the picture.

use crate::error::quoted;

/// Extensions a file may require.
pub(super) const SUPPORTED: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// What a picture lacks when an extension is used but neither required nor supported; an empty text means nothing at
/// all, so nothing is said.
const LEFT_OUT: &[(&str, &str)] = &[
    ("EXT_lights_image_based", "its environment is left out"),
    ("EXT_meshopt_compression", "the uncompressed copy of the data is used"),
    ("KHR_animation_pointer", "animated materials, lights and cameras keep their values"),
    ("KHR_draco_mesh_compression", "the uncompressed copy of the meshes is used"),
    ("KHR_materials_anisotropy", "stretched highlights are round"),
    ("KHR_materials_clearcoat", "clear coats are left out"),
    ("KHR_materials_diffuse_transmission", "light that seeps through is left out"),
    ("KHR_materials_dispersion", "glass does not split light into colours"),
    ("KHR_materials_iridescence", "thin-film colours are left out"),
    ("KHR_materials_pbrSpecularGlossiness", "the metallic-roughness values beside it are used"),
    ("KHR_materials_sheen", "cloth has no sheen"),
    ("KHR_meshopt_compression", "the uncompressed copy of the data is used"),
    ("KHR_texture_basisu", "the textures' PNG or JPEG copies are used"),
    ("KHR_xmp", ""),
    ("KHR_xmp_json_ld", ""),
];

pub(super) fn is_supported(name: &str) -> bool {
    SUPPORTED.contains(&name)
}

/// The warning for an optional extension that is not supported; None when the picture does not change.
pub(super) fn left_out(name: &str) -> Option<String> {
    let effect = LEFT_OUT.iter().find(|(n, _)| *n == name).map_or("what it adds is left out", |(_, e)| e);
    (!effect.is_empty()).then(|| format!("{} is not supported: {effect}", quoted(name)))
}
