//! Reading of accessors: all component types, normalised integers, strides, sparse accessors, and accessors without
//! data (zeros). Reads byte by byte, so misaligned data are accepted. Quantised attributes (KHR_mesh_quantization) are
//! ordinary integers here.
use super::document::{Document, Replaced, label, range};
use crate::SceneError;
use gltf::json::{
    self, Index,
    accessor::{ComponentType, Type, sparse},
    validation::Checked,
};

/// Maximum count of an accessor; indices are 32-bit.
const MAX_COUNT: u64 = u32::MAX as u64;

/// Location and type of the elements of an accessor.
struct Layout<'a> {
    /// None stands for zeros.
    bytes: Option<&'a [u8]>,
    stride: usize,
    count: usize,
    component: ComponentType,
    components: usize,
    normalized: bool,
    place: String,
}

/// Number of components of a type; None for matrices, which are not supported.
fn components(t: Type) -> Option<usize> {
    match t {
        Type::Scalar => Some(1),
        Type::Vec2 => Some(2),
        Type::Vec3 => Some(3),
        Type::Vec4 => Some(4),
        Type::Mat2 | Type::Mat3 | Type::Mat4 => None,
    }
}

fn size(c: ComponentType) -> usize {
    match c {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

/// Reads one component as a number; `bytes` has at least its size. Normalised integers follow glTF 2.0 §3.6.2.2.
fn number(bytes: &[u8], component: ComponentType, normalized: bool) -> f32 {
    let two = || [bytes[0], bytes[1]];
    let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
    let (value, largest) = match component {
        ComponentType::I8 => (f32::from(bytes[0] as i8), 127.0),
        ComponentType::U8 => (f32::from(bytes[0]), 255.0),
        ComponentType::I16 => (f32::from(i16::from_le_bytes(two())), 32767.0),
        ComponentType::U16 => (f32::from(u16::from_le_bytes(two())), 65535.0),
        ComponentType::U32 => (u32::from_le_bytes(four()) as f32, u32::MAX as f32),
        ComponentType::F32 => return f32::from_le_bytes(four()),
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}

/// Reads one unsigned integer; None for signed and floating-point components.
fn integer(bytes: &[u8], component: ComponentType) -> Option<u32> {
    match component {
        ComponentType::U8 => Some(u32::from(bytes[0])),
        ComponentType::U16 => Some(u32::from(u16::from_le_bytes([bytes[0], bytes[1]]))),
        ComponentType::U32 => Some(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        _ => None,
    }
}

impl Document<'_> {
    /// Reads elements of exactly N components.
    pub fn vectors<const N: usize>(
        &self,
        index: Index<json::Accessor>,
        place: &str,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        self.vectors_at(index, None, place)
    }

    /// Reads the elements with the given indices, which are less than the count; all elements without indices.
    pub fn vectors_at<const N: usize>(
        &self,
        index: Index<json::Accessor>,
        at: Option<&[u32]>,
        place: &str,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let layout = self.layout(index, place)?;
        if layout.components != N {
            let what = format!("has {} components where {N} are needed ({place})", layout.components);
            return Err(self.invalid(layout.place, what));
        }
        self.decode(index, &layout, at)
    }

    /// As [`Self::vectors_at`] for elements of 3 or 4 components (COLOR_0); a missing fourth component is 1.
    pub fn colors_at(
        &self,
        index: Index<json::Accessor>,
        at: Option<&[u32]>,
        place: &str,
    ) -> Result<Vec<[f32; 4]>, SceneError> {
        let layout = self.layout(index, place)?;
        match layout.components {
            3 => {
                let all: Vec<[f32; 3]> = self.decode(index, &layout, at)?;
                Ok(all.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
            }
            _ => self.vectors_at(index, at, place),
        }
    }

    /// Reads unsigned integers.
    pub fn indices(&self, index: Index<json::Accessor>, place: &str) -> Result<Vec<u32>, SceneError> {
        let layout = self.layout(index, place)?;
        if layout.components != 1 || integer(&[0; 4], layout.component).is_none() {
            let what = format!("does not hold indices, which must be unsigned integers ({place})");
            return Err(self.invalid(layout.place, what));
        }
        let mut out = vec![0; layout.count];
        if let Some(bytes) = layout.bytes {
            for (value, chunk) in out.iter_mut().zip(bytes.chunks(layout.stride)) {
                *value = integer(chunk, layout.component).unwrap_or(0);
            }
        }
        for (at, bytes) in self.patches(index, &layout)?.iter() {
            out[at] = integer(bytes, layout.component).unwrap_or(0);
        }
        Ok(out)
    }

    /// Checks whether the elements of an accessor can be read, without reading them.
    pub fn check(&self, index: Index<json::Accessor>, place: &str) -> Result<(), SceneError> {
        let before = self.zeros_left();
        let checked = self.layout(index, place).map(drop);
        self.set_zeros_left(before);
        checked
    }

    /// Number of elements of an accessor.
    pub fn count(&self, index: Index<json::Accessor>, place: &str) -> Result<u64, SceneError> {
        Ok(self.get(&self.root.accessors, index, "accessor", place)?.count.0)
    }

    fn decode<const N: usize>(
        &self,
        index: Index<json::Accessor>,
        layout: &Layout<'_>,
        at: Option<&[u32]>,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let step = size(layout.component);
        let element = |bytes: &[u8]| {
            std::array::from_fn(|i| number(&bytes[i * step..], layout.component, layout.normalized))
        };
        let patches = self.patches(index, layout)?;
        if let Some(at) = at {
            let plain = |i: u32| layout.bytes.map_or([0.0; N], |b| element(&b[i as usize * layout.stride..]));
            return Ok(at.iter().map(|&i| patches.of(i).map_or_else(|| plain(i), element)).collect());
        }
        let mut out = match layout.bytes {
            Some(bytes) => bytes.chunks(layout.stride).take(layout.count).map(element).collect(),
            None => vec![[0.0; N]; layout.count],
        };
        for (at, bytes) in patches.iter() {
            out[at] = element(bytes);
        }
        Ok(out)
    }

    /// Checks an accessor. The returned bytes start at the first element and end with the last.
    fn layout(&self, index: Index<json::Accessor>, place: &str) -> Result<Layout<'_>, SceneError> {
        let accessor = self.get(&self.root.accessors, index, "accessor", place)?;
        let place = label("accessor", index.value(), accessor.name.as_deref());
        let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_)
        else {
            return Err(self.invalid(place, "has an unknown type or component type"));
        };
        let Some(components) = components(kind) else {
            return Err(self.invalid(place, "holds matrices where numbers or vectors are needed"));
        };
        let count = accessor.count.0;
        if count > MAX_COUNT {
            return Err(
                self.invalid(place, format!("has {count} elements; at most {MAX_COUNT} are supported"))
            );
        }
        let element = (components * size(component.0)) as u64;
        let mut layout = Layout {
            bytes: None,
            stride: element as usize,
            count: count as usize,
            component: component.0,
            components,
            normalized: accessor.normalized,
            place,
        };
        let Some(view) = accessor.buffer_view else {
            self.zeros(count, &layout.place)?;
            return Ok(layout);
        };
        let stride = self.stride(view).unwrap_or(element);
        if stride < element {
            let what = format!("needs {element} bytes per element, but its view has a stride of {stride}");
            return Err(self.invalid(layout.place, what));
        }
        let bytes = self.view(view, &layout.place)?;
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let length = match count {
            0 => Some(0),
            _ => stride.checked_mul(count - 1).and_then(|n| n.checked_add(element)),
        };
        let Some(bytes) = length.and_then(|length| range(bytes, offset, length)) else {
            let what =
                format!("has {count} elements, but its buffer view of {} bytes ends early", bytes.len());
            return Err(self.invalid(layout.place, what));
        };
        layout.bytes = Some(bytes);
        layout.stride = stride as usize;
        Ok(layout)
    }

    /// The elements that a sparse accessor replaces. They are checked and sorted once per accessor, as many primitives
    /// may share one.
    fn patches(&self, index: Index<json::Accessor>, layout: &Layout<'_>) -> Result<Patches<'_>, SceneError> {
        let Some(sparse) = self.root.accessors.get(index.value()).and_then(|a| a.sparse.as_ref()) else {
            return Ok(Patches::default());
        };
        let element = layout.components * size(layout.component);
        let values = self.packed(&sparse.values, sparse.count.0, element as u64, &layout.place)?;
        if let Some(order) = self.sparse.borrow().get(&index.value()) {
            return Ok(Patches { order: order.clone(), values, element });
        }
        let Checked::Valid(kind) = sparse.indices.component_type else {
            return Err(self.invalid(&layout.place, "has sparse indices of an unknown type"));
        };
        let step = size(kind.0);
        let indices = self.packed(&sparse.indices, sparse.count.0, step as u64, &layout.place)?;
        let mut order = Vec::with_capacity(values.len() / element);
        for (i, at) in (0..).zip(indices.chunks_exact(step)) {
            match integer(at, kind.0) {
                Some(at) if (at as usize) < layout.count => order.push((at, i)),
                at => {
                    let what = format!("has sparse index {at:?}, but {} elements", layout.count);
                    return Err(self.invalid(&layout.place, what));
                }
            }
        }
        order.sort_unstable();
        let order: Replaced = order.into();
        self.sparse.borrow_mut().insert(index.value(), order.clone());
        Ok(Patches { order, values, element })
    }

    /// `count` tightly packed elements of the indices or values of a sparse accessor.
    fn packed(
        &self,
        part: &impl SparsePart,
        count: u64,
        element: u64,
        place: &str,
    ) -> Result<&[u8], SceneError> {
        let (view, offset) = part.place();
        let bytes = self.view(view, place)?;
        count.checked_mul(element).and_then(|length| range(bytes, offset, length)).ok_or_else(|| {
            self.invalid(place, format!("replaces {count} elements, but the data for them end early"))
        })
    }
}

/// The elements that a sparse accessor replaces.
#[derive(Default)]
struct Patches<'a> {
    /// Index of each element and position of its value, in increasing order: of equal indices, the last one holds.
    order: Replaced,
    values: &'a [u8],
    /// Bytes per element.
    element: usize,
}

impl<'a> Patches<'a> {
    fn value(&self, position: u32) -> &'a [u8] {
        &self.values[position as usize * self.element..][..self.element]
    }

    /// All elements, each with its index.
    fn iter(&self) -> impl Iterator<Item = (usize, &'a [u8])> {
        self.order.iter().map(|(at, position)| (*at as usize, self.value(*position)))
    }

    /// The element with an index.
    fn of(&self, at: u32) -> Option<&'a [u8]> {
        let end = self.order.partition_point(|(other, _)| *other <= at);
        let (found, position) = *self.order[..end].last()?;
        (found == at).then(|| self.value(position))
    }
}

/// Indices or values of a sparse accessor, with their buffer view and byte offset.
trait SparsePart {
    fn place(&self) -> (Index<json::buffer::View>, u64);
}

impl SparsePart for sparse::Indices {
    fn place(&self) -> (Index<json::buffer::View>, u64) {
        (self.buffer_view, self.byte_offset.0)
    }
}

impl SparsePart for sparse::Values {
    fn place(&self) -> (Index<json::buffer::View>, u64) {
        (self.buffer_view, self.byte_offset.0)
    }
}
