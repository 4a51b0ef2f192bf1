//! The glTF 2.0 reader: converts .gltf and .glb files to a [`SceneBuilder`](crate::SceneBuilder).
//!
//! The crate `gltf` parses the JSON. Everything for which it would trust the file is implemented here: splitting the
//! .glb, required extensions, the check of every index, byte range and count, the node graph, files and images.
//! Whatever the bytes of a file, reading it returns either a scene or one [`SceneError`](crate::SceneError) with place
//! and reason.
mod accessor;
mod animation;
mod choose;
mod container;
mod document;
mod enumerations;
mod extensions;
mod info;
mod instancing;
mod kept;
mod load;
mod material;
mod mesh;
mod node;
mod open;
mod options;
mod read;
mod sanitize;
mod source;
mod texture;
mod visible;

pub use info::{
    AnimationInfo, CameraInfo, Counts, EmissiveInfo, ExtensionInfo, Info, LightInfo, LightUnitInfo,
    MorphInfo, ObjectInfo, SceneInfo, SkinInfo, TextureInfo, VariantInfo,
};
pub use kept::KeptImages;
pub use open::{files, info, read, read_bytes};
pub use options::{Choice, Options};
