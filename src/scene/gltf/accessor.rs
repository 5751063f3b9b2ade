//! Typed views of buffers (glTF 2.0, section 3.6.2): strided, normalised, sparse, or all zero.
//!
//! A [`Reader`] exists only when all its bytes do, so reading an element below its count cannot fail.

use std::collections::HashMap;

use ::gltf::json::accessor as codes;

use super::budget::Budget;
use super::buffers::Buffers;
use super::document::Document;
use super::json::{Value, shorten};
use crate::error::Result;

/// Most elements of a file that no byte stands for (accessors without a `bufferView`).
const MAX_ZERO_ELEMENTS: usize = 1 << 20;

/// `componentType`
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

/// Elements of equal size in a buffer, all inside it.
#[derive(Debug, Clone, Copy)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

#[derive(Debug, Clone, Copy)]
struct Sparse<'a> {
    count: usize,
    indices: Strided<'a>,
    index_component: Component,
    values: Strided<'a>,
}

/// An accessor whose bytes are known to be there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reader<'a> {
    /// Its number in the file, for messages.
    pub(super) id: usize,
    /// Elements.
    pub(super) count: usize,
    /// Components an element, 1 to 4.
    pub(super) width: usize,
    pub(super) component: Component,
    normalized: bool,
    /// `None`: every element is 0 but the sparse ones.
    dense: Option<Strided<'a>>,
    sparse: Option<Sparse<'a>>,
}

/// All accessors met so far, each checked once.
pub(super) struct Accessors<'a> {
    document: &'a Document<'a>,
    buffers: &'a Buffers<'a>,
    readers: HashMap<usize, Reader<'a>>,
    zero_elements: usize,
}

impl Component {
    fn parse(value: Value<'_>) -> Result<Self> {
        Ok(match value.code()? {
            codes::BYTE => Self::I8,
            codes::UNSIGNED_BYTE => Self::U8,
            codes::SHORT => Self::I16,
            codes::UNSIGNED_SHORT => Self::U16,
            codes::UNSIGNED_INT => Self::U32,
            codes::FLOAT => Self::F32,
            other => return Err(value.error(format_args!("{other} is not a component type"))),
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// True for the types that indices may have.
    pub(super) fn is_unsigned(self) -> bool {
        matches!(self, Self::U8 | Self::U16 | Self::U32)
    }

    /// The whole number in the first bytes; 0 for the signed and floating types.
    fn unsigned(self, bytes: &[u8]) -> u32 {
        match self {
            Self::U8 => bytes[0].into(),
            Self::U16 => u16::from_le_bytes([bytes[0], bytes[1]]).into(),
            Self::U32 => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
            Self::I8 | Self::I16 | Self::F32 => 0,
        }
    }

    fn float(self, bytes: &[u8], normalized: bool) -> f32 {
        let (raw, one) = match self {
            Self::I8 => (f32::from(bytes[0] as i8), 127.0),
            Self::U8 => (f32::from(bytes[0]), 255.0),
            Self::I16 => (f32::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
            Self::U16 => (f32::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
            Self::U32 => return self.unsigned(bytes) as f32,
            Self::F32 => return f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        };
        // Section 3.6.2.2: the most negative integer also means -1.
        if normalized { (raw / one).max(-1.0) } else { raw }
    }
}

impl<'a> Strided<'a> {
    fn element(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..]
    }
}

impl Sparse<'_> {
    fn index(&self, nth: usize) -> usize {
        self.index_component.unsigned(self.indices.element(nth)) as usize
    }

    /// Which of the displaced values stands for element `index`. The indices increase, so halving finds it.
    fn position(&self, index: usize) -> Option<usize> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = (low + high) / 2;
            if self.index(middle) < index {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        (low < self.count && self.index(low) == index).then_some(low)
    }
}

impl Reader<'_> {
    /// Element `index`, below `count`; components that it has not are 1.
    pub(super) fn element<const N: usize>(&self, index: usize) -> [f32; N] {
        let displaced = self.sparse.and_then(|sparse| sparse.position(index).map(|nth| sparse.values.element(nth)));
        let Some(bytes) = displaced.or(self.dense.map(|dense| dense.element(index))) else {
            return std::array::from_fn(|i| if i < self.width { 0.0 } else { 1.0 });
        };
        let size = self.component.bytes();
        std::array::from_fn(|i| {
            if i < self.width { self.component.float(&bytes[i * size..], self.normalized) } else { 1.0 }
        })
    }

    /// Element `index`, below `count`, as a vertex number.
    pub(super) fn index(&self, index: usize) -> u32 {
        let displaced = self.sparse.and_then(|sparse| sparse.position(index).map(|nth| sparse.values.element(nth)));
        displaced.or(self.dense.map(|dense| dense.element(index))).map_or(0, |bytes| self.component.unsigned(bytes))
    }

    /// The elements that `source` lists.
    pub(super) fn gather<const N: usize>(&self, source: &[u32]) -> Vec<[f32; N]> {
        source.iter().map(|index| self.element(*index as usize)).collect()
    }
}

impl<'a> Accessors<'a> {
    pub(super) fn new(document: &'a Document<'a>, buffers: &'a Buffers<'a>) -> Self {
        Self { document, buffers, readers: HashMap::new(), zero_elements: 0 }
    }

    /// The accessor that the number `reference` names.
    ///
    /// # Errors
    /// Anything that would make one of its elements unreadable.
    pub(super) fn reader(&mut self, reference: Value<'a>, budget: &mut Budget) -> Result<Reader<'a>> {
        let (id, accessor) = self.document.accessors.referred(reference)?;
        if let Some(reader) = self.readers.get(&id) {
            return Ok(*reader);
        }
        let reader = self.open(id, accessor)?;
        if reader.dense.is_none() {
            self.zero_elements = self.zero_elements.saturating_add(reader.count);
            if self.zero_elements > MAX_ZERO_ELEMENTS {
                return Err(accessor.error(format_args!(
                    "count {} without a bufferView: a file may have at most {MAX_ZERO_ELEMENTS} such elements",
                    reader.count
                )));
            }
        }
        // A hash table grows by doubling and holds old and new entries while it does.
        budget.charge(4 * size_of::<(usize, Reader)>() as u64, 0, &"accessors")?;
        self.readers.insert(id, reader);
        Ok(reader)
    }

    fn open(&self, id: usize, accessor: Value<'a>) -> Result<Reader<'a>> {
        let count = accessor.require("count")?.index()?;
        let component = Component::parse(accessor.require("componentType")?)?;
        let kind = accessor.require("type")?;
        let width = match kind.text()? {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            other => return Err(kind.error(format_args!("{} is not a type of mesh data", shorten(other)))),
        };
        let normalized = accessor.get("normalized")?.map_or(Ok(false), Value::boolean)?;
        let size = component.bytes() * width;
        let dense = match accessor.get("bufferView")? {
            Some(view) => Some(self.strided(accessor, view, count, size)?),
            None => None,
        };
        let sparse = match accessor.get("sparse")? {
            Some(sparse) => Some(self.sparse(sparse, count, size)?),
            None => None,
        };
        Ok(Reader { id, count, width, component, normalized, dense, sparse })
    }

    /// `count` elements of `size` bytes from `holder`'s `byteOffset` on.
    fn strided(&self, holder: Value<'a>, view: Value<'a>, count: usize, size: usize) -> Result<Strided<'a>> {
        let number = view.index()?;
        let view = self.buffers.view(view)?;
        let offset = holder.get("byteOffset")?.map_or(Ok(0), Value::index)?;
        let stride = view.stride.unwrap_or(size);
        if stride < size {
            return Err(holder
                .error(format_args!("an element has {size} bytes, but bufferViews[{number}].byteStride is {stride}")));
        }
        let length = match count.checked_sub(1) {
            Some(last) => last.checked_mul(stride).and_then(|bytes| bytes.checked_add(size)),
            None => Some(0),
        };
        let range = length.and_then(|length| view.bytes.get(offset..offset.checked_add(length)?));
        let Some(bytes) = range else {
            let (length, end) = (count.saturating_sub(1).saturating_mul(stride).saturating_add(size), view.bytes.len());
            return Err(holder.error(format_args!(
                "byteOffset {offset} + {length} bytes pass the end of bufferViews[{number}] ({end} bytes)"
            )));
        };
        Ok(Strided { bytes, stride })
    }

    fn sparse(&self, sparse: Value<'a>, count: usize, size: usize) -> Result<Sparse<'a>> {
        let displaced = sparse.require("count")?.index()?;
        if displaced > count {
            return Err(sparse.error(format_args!("count {displaced} is more than the accessor's {count}")));
        }
        let (indices, values) = (sparse.require("indices")?, sparse.require("values")?);
        let index_component = Component::parse(indices.require("componentType")?)?;
        if !index_component.is_unsigned() {
            return Err(indices.error("componentType is not an unsigned integer"));
        }
        let packed = self.strided(indices, indices.require("bufferView")?, displaced, index_component.bytes())?;
        let values = self.strided(values, values.require("bufferView")?, displaced, size)?;
        let opened = Sparse { count: displaced, indices: packed, index_component, values };
        for nth in 0..displaced {
            let index = opened.index(nth);
            if index >= count {
                return Err(
                    indices.error(format_args!("index {nth} is {index}, but the accessor has {count} elements"))
                );
            }
            if nth > 0 && opened.index(nth - 1) >= index {
                return Err(indices.error(format_args!("index {nth} is not greater than the one before it")));
            }
        }
        Ok(opened)
    }
}
