//! The glTF 2.0 reader: .gltf and .glb to a [`SceneBuilder`](crate::SceneBuilder).
//!
//! The crate `gltf` parses the JSON; everything it would trust the file with is done here: splitting the .glb,
//! required extensions, every index, byte range and count, the node graph, files and images. Whatever bytes a file
//! has, reading it ends in a scene or in one [`SceneError`](crate::SceneError) that says where and why.
mod accessor;
mod animation;
mod choose;
mod container;
mod document;
mod enumerations;
mod extensions;
mod info;
mod instancing;
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
pub use open::{files, info, read, read_bytes};
pub use options::{Choice, Options};
