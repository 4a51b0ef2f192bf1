//! A parsed file with checked access: every index and byte range is validated before it is used, and every message
//! names the object it refers to.
use super::{container::Content, options::Options, source};
use crate::{SceneError, Warning, error::quoted, warnings::Warnings};
use dapple_imaging::MemoryLimit;
use gltf::json::{self, Index};
use serde_json::Value;
use std::{
    cell::{Cell, OnceCell, RefCell},
    collections::HashMap,
    path::{Path, PathBuf},
    rc::Rc,
};

/// Limit of the elements of accessors without data in one file.
const ZEROS: u64 = 1 << 22;

/// Index of each element that a sparse accessor replaces, and the position of its value, in increasing order.
pub(super) type Replaced = Rc<[(u32, u32)]>;

/// A glTF file.
pub(super) struct Document<'o> {
    pub file: PathBuf,
    pub options: &'o Options,
    pub root: json::Root,
    pub value: Value,
    blob: Option<Vec<u8>>,
    buffers: Vec<OnceCell<Vec<u8>>>,
    zeros: Cell<u64>,
    /// Elements that sparse accessors replace, by accessor.
    pub sparse: RefCell<HashMap<usize, Replaced>>,
    /// Bytes of memory that the reader has allocated for the file so far. A few lines of JSON can refer to the same
    /// data any number of times.
    kept: Cell<u64>,
    /// Size in bytes of the file and of the other files read for it.
    length: Cell<u64>,
    /// Size in bytes of the file alone.
    file_length: u64,
    warnings: RefCell<Warnings>,
}

impl<'o> Document<'o> {
    pub fn new(file: &Path, options: &'o Options, content: Content, warnings: Vec<Warning>) -> Self {
        let Content { root, value, blob, length } = content;
        Self {
            file: file.to_owned(),
            options,
            buffers: root.buffers.iter().map(|_| OnceCell::new()).collect(),
            root,
            value,
            blob,
            zeros: Cell::new(ZEROS),
            sparse: RefCell::default(),
            kept: Cell::new(0),
            length: Cell::new(length),
            file_length: length,
            warnings: RefCell::new(Warnings::of(warnings)),
        }
    }

    /// An error about the object named by `place`.
    pub fn invalid(&self, place: impl Into<String>, what: impl Into<String>) -> SceneError {
        SceneError::invalid(&self.file.display().to_string(), place, what)
    }

    /// Adds a warning; of many similar ones only the first are kept, and the others counted.
    pub fn warn(&self, text: String) {
        self.warnings.borrow_mut().add(Warning(text));
    }

    pub fn take_warnings(&self) -> Vec<Warning> {
        self.warnings.take().summed()
    }

    /// The element of a list at `index`, or an error that names both.
    pub fn get<'a, T>(
        &self,
        list: &'a [T],
        index: Index<T>,
        kind: &str,
        place: &str,
    ) -> Result<&'a T, SceneError> {
        list.get(index.value()).ok_or_else(|| {
            self.invalid(place, format!("refers to {kind} {}, but there are {}", index.value(), list.len()))
        })
    }

    /// The bytes of a buffer view.
    pub fn view(&self, index: Index<json::buffer::View>, place: &str) -> Result<&[u8], SceneError> {
        let view = self.get(&self.root.buffer_views, index, "buffer view", place)?;
        let place = label("buffer view", index.value(), view.name.as_deref());
        let buffer = self.buffer(view.buffer, &place)?;
        let (start, length) = (view.byte_offset.unwrap_or_default().0, view.byte_length.0);
        range(buffer, start, length).ok_or_else(|| {
            let what = format!("ends at byte {}", u128::from(start) + u128::from(length));
            self.invalid(place, format!("{what}, but its buffer has only {} bytes", buffer.len()))
        })
    }

    /// Distance in bytes between elements of a view; None if they are tightly packed.
    pub fn stride(&self, index: Index<json::buffer::View>) -> Option<u64> {
        self.root.buffer_views.get(index.value())?.byte_stride.map(|s| s.0 as u64)
    }

    fn buffer(&self, index: Index<json::Buffer>, place: &str) -> Result<&[u8], SceneError> {
        let buffer = self.get(&self.root.buffers, index, "buffer", place)?;
        let cell = &self.buffers[index.value()];
        if let Some(bytes) = cell.get() {
            return Ok(bytes);
        }
        let place = label("buffer", index.value(), buffer.name.as_deref());
        let length = buffer.byte_length.0;
        let truncated = |held: usize| {
            self.invalid(&*place, format!("holds {held} of its {length} bytes; export the scene again"))
        };
        let mut bytes = match (&buffer.uri, &self.blob) {
            (Some(uri), _) => self.outside(uri, length, &place)?,
            (None, Some(blob)) if index.value() == 0 => {
                return range(blob, 0, length).ok_or_else(|| truncated(blob.len()));
            }
            (None, _) => return Err(self.invalid(place, "has no data; export the scene again")),
        };
        if (bytes.len() as u64) < length {
            return Err(truncated(bytes.len()));
        }
        bytes.truncate(length as usize);
        let _ = cell.set(bytes);
        Ok(cell.get().map_or(&[], Vec::as_slice))
    }

    /// Up to `limit` bytes of the data or the file that a URI denotes.
    pub fn outside(&self, uri: &str, limit: u64, place: &str) -> Result<Vec<u8>, SceneError> {
        // Upper bound: the length of a data URI, or the size of a file.
        let at_most = match source::path(&self.file, uri) {
            Some(path) => path.metadata().map_or(0, |found| found.len()).min(limit),
            None => uri.len() as u64,
        };
        self.has_read(if uri.starts_with("data:") { 0 } else { at_most });
        self.keep(at_most, place)?;
        let bytes = source::bytes(&self.file, uri, limit, place, self.options)?;
        if let Some(found) = source::other_name(&self.file, uri) {
            let (uri, found) = (quoted(uri), quoted(&found));
            self.warn(format!(
                "{place}: there is no file '{uri}'; '{found}' is used: correct the name in the scene"
            ));
        }
        Ok(bytes)
    }

    /// Paths of the file itself and of the files that its buffers and images name.
    pub fn files(&self) -> Vec<PathBuf> {
        let buffers = self.root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
        let images = self.root.images.iter().filter_map(|image| image.uri.as_deref());
        let named = buffers.chain(images).filter_map(|uri| source::path(&self.file, uri));
        std::iter::once(self.file.clone()).chain(named).collect()
    }

    /// Counts `count` elements against the limit of elements without data.
    pub fn zeros(&self, count: u64, place: &str) -> Result<(), SceneError> {
        let left = self.zeros.get().checked_sub(count);
        self.zeros.set(left.ok_or_else(|| {
            self.invalid(place, format!("has {count} elements without data; a file may have at most {ZEROS}"))
        })?);
        Ok(())
    }

    /// Number of elements without data that may still be read.
    pub fn zeros_left(&self) -> u64 {
        self.zeros.get()
    }

    /// Sets the number of elements without data that may still be read.
    pub fn set_zeros_left(&self, left: u64) {
        self.zeros.set(left);
    }

    /// Counts `bytes` against the memory limit of the file, before they are allocated.
    pub fn keep(&self, bytes: u64, place: &str) -> Result<(), SceneError> {
        self.would_keep(bytes, place)?;
        self.kept.set(self.kept.get().saturating_add(bytes));
        Ok(())
    }

    /// Checks whether `bytes` more bytes would stay within the memory limit.
    pub fn would_keep(&self, bytes: u64, place: &str) -> Result<(), SceneError> {
        let kept = self.kept.get().saturating_add(bytes);
        let refuse = |overrun| SceneError::Memory {
            file: self.file.clone(),
            place: format!("{place}: the scene with it"),
            overrun,
        };
        self.options.memory.admit(kept, Some(self.length.get())).map_err(refuse)
    }

    /// The memory that the reader may still allocate for the file.
    pub fn left(&self) -> MemoryLimit {
        self.options.memory.less(self.kept.get())
    }

    /// Adds to the size of the input the bytes read from another file.
    pub fn has_read(&self, bytes: u64) {
        self.length.set(self.length.get().saturating_add(bytes));
    }

    /// Size in bytes of the file and of all buffers that it names, whether read or not.
    pub fn whole_length(&self) -> u64 {
        let named = self.root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
        let mut paths: Vec<PathBuf> = named.filter_map(|uri| source::path(&self.file, uri)).collect();
        paths.sort_unstable();
        paths.dedup();
        let length = |path: &PathBuf| path.metadata().map_or(0, |at| if at.is_file() { at.len() } else { 0 });
        paths.iter().map(length).fold(self.file_length, u64::saturating_add)
    }

    /// The `dapple` object of `extras`, if there is one.
    pub fn dapple(&self, extras: &json::Extras, place: &str) -> Result<Option<Value>, SceneError> {
        let Some(extras) = extras else { return Ok(None) };
        let value: Value =
            serde_json::from_str(extras.get()).map_err(|e| self.invalid(place, format!("extras: {e}")))?;
        Ok(value.get("dapple").cloned())
    }
}

/// The `length` bytes from `start`; None if the range exceeds the slice.
pub(super) fn range(bytes: &[u8], start: u64, length: u64) -> Option<&[u8]> {
    let start = usize::try_from(start).ok()?;
    let end = start.checked_add(usize::try_from(length).ok()?)?;
    bytes.get(start..end)
}

/// Name in messages of the `index`-th object of a kind.
pub(super) fn label(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) if !name.is_empty() => {
            format!("{kind} {index} '{}'", quoted(name))
        }
        _ => format!("{kind} {index}"),
    }
}
