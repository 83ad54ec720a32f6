//! Accessors: where in the buffers each element lies, checked before anything is read. glTF 2.0, 3.6.2; quantized
//! positions as in KHR_mesh_quantization.

use gltf::accessor::Item;
use gltf::json::accessor::{Accessor, ComponentType, GenericComponentType, IndexComponentType, Type};
use gltf::json::validation::{Checked, USize64};
use gltf::json::{Index, Root, buffer};

use super::buffers::Buffers;

/// What `items` gives, as far as memory allows.
pub(super) fn collect<T>(items: impl ExactSizeIterator<Item = T>) -> Result<Vec<T>, String> {
    let mut all = Vec::new();
    let count = items.len();
    all.try_reserve_exact(count).map_err(|_| format!("its {count} elements don't fit in memory"))?;
    all.extend(items);
    Ok(all)
}

/// An accessor's elements: each is where it should be.
pub(super) struct Elements<'b> {
    pub(super) count: usize,
    /// Index of the accessor, for messages.
    number: usize,
    of: Type,
    component: ComponentType,
    normalized: bool,
    /// None: zeros.
    base: Option<Strided<'b>>,
    /// Indices that differ from `base`, ascending, and their elements.
    sparse: Option<(Vec<u32>, Strided<'b>)>,
}

/// Elements at even distances.
#[derive(Clone, Copy)]
struct Strided<'b> {
    bytes: &'b [u8],
    stride: usize,
}

impl<'b> Strided<'b> {
    /// `count` elements of `size` bytes from byte `offset` of a view on.
    fn open(
        root: &Root,
        buffers: &'b Buffers,
        view: Index<buffer::View>,
        offset: USize64,
        count: usize,
        size: usize,
    ) -> Result<Self, String> {
        let (number, view) = (view.value(), &root.buffer_views[view.value()]);
        let in_view = buffers.view(number, view)?;
        let stride = view.byte_stride.map_or(size, |s| s.0);
        if stride < size {
            return Err(format!("buffer view {number} puts elements of {size} bytes {stride} bytes apart"));
        }
        let last = (count as u64).checked_sub(1).map(|n| n.checked_mul(stride as u64));
        let end = last.map_or(Some(0), |last| last?.checked_add(offset.0)?.checked_add(size as u64));
        if end.is_none_or(|end| end > in_view.len() as u64) {
            let has = in_view.len();
            return Err(format!("{count} elements reach beyond the {has} bytes of buffer view {number}"));
        }
        Ok(Self { bytes: in_view.get(offset.0 as usize..).unwrap_or_default(), stride })
    }

    fn at(&self, i: usize) -> &'b [u8] {
        &self.bytes[i * self.stride..]
    }
}

impl<'b> Elements<'b> {
    /// Opens accessor `number`.
    ///
    /// # Errors
    /// In words: a buffer too short, sparse indices out of order, more zeros than there are bytes.
    pub(super) fn open(root: &Root, buffers: &'b Buffers, number: usize) -> Result<Self, String> {
        let accessor = &root.accessors[number];
        let said = |what| format!("accessor {number}: {what}");
        let elements = Self::read(root, buffers, number, accessor).map_err(said)?;
        let count = elements.count;
        if elements.base.is_none() && count as u64 > buffers.size() {
            return Err(said(format!(
                "{count} elements without a buffer view, in {} bytes of buffers",
                buffers.size()
            )));
        }
        Ok(elements)
    }

    fn read(root: &Root, buffers: &'b Buffers, number: usize, accessor: &Accessor) -> Result<Self, String> {
        let (Checked::Valid(of), Checked::Valid(GenericComponentType(component))) =
            (accessor.type_, accessor.component_type)
        else {
            return Err("its type is unknown".to_owned());
        };
        let size = of.multiplicity() * component.size();
        let count = accessor.count.0 as usize;
        let open = |view, offset, count, size| Strided::open(root, buffers, view, offset, count, size);
        let base =
            accessor.buffer_view.map(|v| open(v, accessor.byte_offset.unwrap_or_default(), count, size));
        let sparse = accessor.sparse.as_ref().map(|sparse| {
            let Checked::Valid(IndexComponentType(kind)) = sparse.indices.component_type else {
                return Err("its sparse indices are no integers".to_owned());
            };
            let (at, n) = (&sparse.indices, sparse.count.0 as usize);
            let indices = open(at.buffer_view, at.byte_offset, n, kind.size())?;
            let indices = collect((0..n).map(|i| index(kind, indices.at(i))))?;
            if !indices.is_sorted_by(|a, b| a < b) || indices.last().is_some_and(|l| *l as usize >= count) {
                return Err("its sparse indices do not ascend, or one is beyond its count".to_owned());
            }
            let values = &sparse.values;
            Ok((indices, open(values.buffer_view, values.byte_offset, n, size)?))
        });
        let (base, sparse) = (base.transpose()?, sparse.transpose()?);
        Ok(Self { count, number, of, component, normalized: accessor.normalized, base, sparse })
    }

    /// The bytes of element `i`; none: zeros.
    fn at(&self, i: usize) -> Option<&'b [u8]> {
        let differs = self.sparse.as_ref().and_then(|(indices, values)| {
            let k = indices.binary_search(&(i as u32)).ok()?;
            Some(values.at(k))
        });
        differs.or_else(|| self.base.map(|b| b.at(i)))
    }

    /// All elements as vertex indices.
    pub(super) fn indices(&self) -> Result<Vec<u32>, String> {
        match (self.of, self.component) {
            (Type::Scalar, kind @ (ComponentType::U8 | ComponentType::U16 | ComponentType::U32)) => {
                collect((0..self.count).map(|i| self.at(i).map_or(0, |b| index(kind, b))))
            }
            _ => Err(format!("accessor {}: vertex indices must be SCALAR and unsigned", self.number)),
        }
    }

    /// Whether [`Self::position`] may be asked.
    pub(super) fn must_be_positions(&self) -> Result<(), String> {
        match (self.of, self.component) {
            (Type::Vec3, ComponentType::U32) | (Type::Scalar | Type::Vec2 | Type::Vec4, _) => {
                Err(format!("accessor {}: positions must be VEC3 of float, byte or short", self.number))
            }
            (Type::Mat2 | Type::Mat3 | Type::Mat4, _) => {
                Err(format!("accessor {}: positions must be VEC3, not matrices", self.number))
            }
            (Type::Vec3, _) => Ok(()),
        }
    }

    /// Element `i` as a position.
    pub(super) fn position(&self, i: usize) -> [f32; 3] {
        let Some(b) = self.at(i) else { return [0.0; 3] };
        let scaled =
            |v: [f32; 3], most: f32| if self.normalized { v.map(|c| (c / most).max(-1.0)) } else { v };
        match self.component {
            ComponentType::I8 => scaled(<[i8; 3]>::from_slice(b).map(f32::from), 127.0),
            ComponentType::U8 => scaled(<[u8; 3]>::from_slice(b).map(f32::from), 255.0),
            ComponentType::I16 => scaled(<[i16; 3]>::from_slice(b).map(f32::from), 32767.0),
            ComponentType::U16 => scaled(<[u16; 3]>::from_slice(b).map(f32::from), 65535.0),
            ComponentType::U32 | ComponentType::F32 => <[f32; 3]>::from_slice(b),
        }
    }
}

fn index(kind: ComponentType, bytes: &[u8]) -> u32 {
    match kind {
        ComponentType::U8 => u8::from_slice(bytes).into(),
        ComponentType::U16 => u16::from_slice(bytes).into(),
        _ => u32::from_slice(bytes),
    }
}
