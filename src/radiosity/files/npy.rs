//! NumPy's array files, version 1.0 (NEP 1): little-endian, in C order.

const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";

/// A number that such a file holds.
pub trait Number: bytemuck::Pod {
    /// NumPy's name of it.
    const NAME: &'static str;
}

impl Number for f64 {
    const NAME: &'static str = "<f8";
}
impl Number for f32 {
    const NAME: &'static str = "<f4";
}
impl Number for u64 {
    const NAME: &'static str = "<u8";
}
impl Number for u32 {
    const NAME: &'static str = "<u4";
}
impl Number for u16 {
    const NAME: &'static str = "<u2";
}

/// A float of 16 bits by its bits.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct HalfBits(pub u16);

impl Number for HalfBits {
    const NAME: &'static str = "<f2";
}

fn header<T: Number>(shape: &[usize]) -> String {
    let sizes: Vec<String> = shape.iter().map(ToString::to_string).collect();
    let shape = if sizes.len() == 1 { format!("({},)", sizes[0]) } else { format!("({})", sizes.join(", ")) };
    let text = format!("{{'descr': '{}', 'fortran_order': False, 'shape': {shape}, }}", T::NAME);
    // Data begin at a multiple of 64 bytes.
    let length = (MAGIC.len() + 2 + text.len() + 1).next_multiple_of(64) - MAGIC.len() - 2;
    format!("{text:<width$}\n", width = length - 1)
}

/// The file of an array.
pub fn write<T: Number>(shape: &[usize], values: &[T]) -> Vec<u8> {
    let header = header::<T>(shape);
    let mut bytes = MAGIC.to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend_from_slice(bytemuck::cast_slice(values));
    bytes
}

/// The numbers of a file as [`write`] makes it, of this shape, or in one dimension where none is said.
///
/// # Errors
/// Another form, type or shape, in words.
pub fn read<T: Number>(bytes: &[u8], shape: Option<&[usize]>) -> Result<Vec<T>, String> {
    let rest = bytes.strip_prefix(MAGIC).ok_or("is no NumPy array of version 1.0")?;
    let (length, rest) = rest.split_at_checked(2).ok_or("ends in its header")?;
    let length = usize::from(u16::from_le_bytes([length[0], length[1]]));
    let (found, data) = rest.split_at_checked(length).ok_or("ends in its header")?;
    let count = data.len() / size_of::<T>();
    let one = [count];
    let shape = shape.unwrap_or(&one);
    let wanted = header::<T>(shape);
    if found != wanted.as_bytes() {
        let said = String::from_utf8_lossy(found);
        return Err(format!("is {}, wanted is {}", said.trim(), wanted.trim()));
    }
    let elements = shape.iter().try_fold(1usize, |all, n| all.checked_mul(*n)).ok_or("has too many elements")?;
    if data.len() != elements * size_of::<T>() {
        return Err(format!("has {} bytes for {elements} elements", data.len()));
    }
    Ok(data.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
}
