//! What can be wrong with a scene; each error names file, object and remedy.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    #[error("stub")]
    Stub,
}
/// Something that will look different from what the file says; rendering goes on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning(pub String);
