//! What can go wrong with a picture file; each names the file and the remedy.
/// An unreadable, unwritable or malformed picture.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    #[error("stub")]
    Stub,
}
