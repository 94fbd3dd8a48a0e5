//! The `.npy` format: magic, a header that is a Python dict literal, raw values.
//!
//! # Source
//! NumPy, `numpy.lib.format` (versions 1.0, 2.0 and 3.0 of the format).

use std::path::Path;

use crate::array::{Array, ArrayData, element_count};
use crate::error::{MemberProblem, NpzError};

const MAGIC: &[u8] = b"\x93NUMPY";
/// Values start at a multiple of this.
const ALIGNMENT: usize = 64;

/// Reads a lone `.npy` file.
///
/// # Errors
/// [`NpzError::Io`], and [`NpzError::Member`] (with an empty member name) for damaged contents.
pub fn read_npy(path: impl AsRef<Path>) -> Result<Array, NpzError> {
    let file = path.as_ref().to_path_buf();
    let bytes = match std::fs::read(&file) {
        Ok(bytes) => bytes,
        Err(source) => return Err(NpzError::Io { file, source }),
    };
    decode(&bytes).map_err(|problem| NpzError::Member { file, member: String::new(), problem })
}

/// Writes a lone `.npy` file in C order, whole or not at all.
///
/// # Errors
/// [`NpzError::Io`], and [`NpzError::Unwritable`] when values and shape disagree.
pub fn write_npy(path: impl AsRef<Path>, array: &Array) -> Result<(), NpzError> {
    let file = path.as_ref().to_path_buf();
    let bytes = encode(array).map_err(|problem| NpzError::Unwritable { member: String::new(), problem })?;
    signorini_files::write(&file, bytes).map_err(|source| NpzError::Io { file, source })
}

/// The element types read, with the width in bytes where it is not fixed.
#[derive(Clone, Copy)]
enum Element {
    F64,
    F32,
    I64,
    I32,
    U8,
    Bool,
    Bytes(usize),
}

impl Element {
    fn parse(descr: &str) -> Option<Self> {
        Some(match descr {
            "<f8" => Self::F64,
            "<f4" => Self::F32,
            "<i8" => Self::I64,
            "<i4" => Self::I32,
            "|u1" => Self::U8,
            "|b1" => Self::Bool,
            _ => Self::Bytes(descr.strip_prefix("|S")?.parse().ok().filter(|&width| width > 0)?),
        })
    }

    fn of(data: &ArrayData) -> Self {
        match data {
            ArrayData::F64(_) => Self::F64,
            ArrayData::F32(_) => Self::F32,
            ArrayData::I64(_) => Self::I64,
            ArrayData::I32(_) => Self::I32,
            ArrayData::U8(_) => Self::U8,
            ArrayData::Bool(_) => Self::Bool,
            ArrayData::Bytes(x) => Self::Bytes(x.iter().map(Vec::len).max().unwrap_or(1).max(1)),
        }
    }

    fn descr(self) -> String {
        match self {
            Self::F64 => "<f8".into(),
            Self::F32 => "<f4".into(),
            Self::I64 => "<i8".into(),
            Self::I32 => "<i4".into(),
            Self::U8 => "|u1".into(),
            Self::Bool => "|b1".into(),
            Self::Bytes(width) => format!("|S{width}"),
        }
    }

    fn width(self) -> usize {
        match self {
            Self::F64 | Self::I64 => 8,
            Self::F32 | Self::I32 => 4,
            Self::U8 | Self::Bool => 1,
            Self::Bytes(width) => width,
        }
    }
}

/// The array in a `.npy` file's bytes.
pub(crate) fn decode(bytes: &[u8]) -> Result<Array, MemberProblem> {
    let (header, payload) = split_header(bytes)?;
    let header = Header::parse(header)?;
    let Some(element) = Element::parse(&header.descr) else {
        return Err(MemberProblem::ElementType { descr: header.descr });
    };
    let Some((count, needed)) =
        element_count(&header.shape).and_then(|count| Some((count, count.checked_mul(element.width())?)))
    else {
        return Err(MemberProblem::TooLarge { shape: header.shape });
    };
    if payload.len() != needed {
        return Err(MemberProblem::DataSize {
            shape: header.shape,
            element: header.descr,
            needed,
            found: payload.len(),
        });
    }
    let order = Order { shape: &header.shape, fortran: header.fortran_order, count };
    let data = order.read(payload, element);
    Ok(Array { shape: header.shape, data })
}

/// Splits a file into the header's text and the raw values.
fn split_header(bytes: &[u8]) -> Result<(&str, &[u8]), MemberProblem> {
    let bad = |problem| MemberProblem::Header { problem };
    let rest = bytes.strip_prefix(MAGIC).ok_or(bad("does not start with \\x93NUMPY"))?;
    let (length, rest) = match rest {
        [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2 | 3, _, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        _ => return Err(bad("the format version is not 1, 2 or 3")),
    };
    if rest.len() < length {
        return Err(MemberProblem::Truncated { needed: bytes.len() - rest.len() + length, found: bytes.len() });
    }
    let (header, payload) = rest.split_at(length);
    let header = std::str::from_utf8(header).map_err(|_| bad("is not text"))?;
    Ok((header, payload))
}

/// The three entries of the header's dict.
struct Header {
    descr: String,
    fortran_order: bool,
    shape: Vec<usize>,
}

impl Header {
    /// Parses `{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }`, keys in any order.
    fn parse(text: &str) -> Result<Self, MemberProblem> {
        let bad = |problem| MemberProblem::Header { problem };
        let mut rest = text
            .trim()
            .strip_prefix('{')
            .and_then(|t| t.strip_suffix('}'))
            .ok_or(bad("is not a dict in braces"))?
            .trim();
        let (mut descr, mut fortran_order, mut shape) = (None, None, None);
        while !rest.is_empty() {
            let (key, after) = quoted(rest).ok_or(bad("a key is not a quoted string"))?;
            rest = after.trim_start().strip_prefix(':').ok_or(bad("a key without a colon"))?;
            rest = rest.trim_start();
            rest = match key {
                "descr" => {
                    let (value, after) =
                        quoted(rest).ok_or_else(|| MemberProblem::ElementType { descr: "(structured)".into() })?;
                    descr = Some(value.to_owned());
                    after
                }
                "fortran_order" => {
                    let (value, after) = python_bool(rest).ok_or(bad("fortran_order is no bool"))?;
                    fortran_order = Some(value);
                    after
                }
                "shape" => {
                    let (value, after) = tuple(rest).ok_or(bad("shape is no tuple of sizes"))?;
                    shape = Some(value);
                    after
                }
                _ => return Err(bad("has a key other than descr, fortran_order, shape")),
            };
            rest = rest.trim_start();
            rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
        }
        Ok(Self {
            descr: descr.ok_or(bad("has no descr"))?,
            fortran_order: fortran_order.ok_or(bad("has no fortran_order"))?,
            shape: shape.ok_or(bad("has no shape"))?,
        })
    }
}

fn quoted(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    text[1..].split_once(quote)
}

fn python_bool(text: &str) -> Option<(bool, &str)> {
    let after_true = text.strip_prefix("True").map(|after| (true, after));
    after_true.or_else(|| text.strip_prefix("False").map(|after| (false, after)))
}

fn tuple(text: &str) -> Option<(Vec<usize>, &str)> {
    let (inside, after) = text.strip_prefix('(')?.split_once(')')?;
    let inside = inside.trim();
    let inside = inside.strip_suffix(',').unwrap_or(inside);
    if inside.is_empty() {
        return Some((Vec::new(), after));
    }
    let sizes: Result<_, _> = inside.split(',').map(|size| size.trim().parse()).collect();
    Some((sizes.ok()?, after))
}

/// How the raw values are laid out.
struct Order<'a> {
    shape: &'a [usize],
    fortran: bool,
    count: usize,
}

impl Order<'_> {
    fn read(&self, payload: &[u8], element: Element) -> ArrayData {
        match element {
            Element::F64 => ArrayData::F64(self.collect(payload, f64::from_le_bytes)),
            Element::F32 => ArrayData::F32(self.collect(payload, f32::from_le_bytes)),
            Element::I64 => ArrayData::I64(self.collect(payload, i64::from_le_bytes)),
            Element::I32 => ArrayData::I32(self.collect(payload, i32::from_le_bytes)),
            Element::U8 => ArrayData::U8(self.collect(payload, |[byte]| byte)),
            Element::Bool => ArrayData::Bool(self.collect(payload, |[byte]| byte != 0)),
            Element::Bytes(width) => ArrayData::Bytes(self.strings(payload, width)),
        }
    }

    fn collect<T: Clone, const N: usize>(&self, payload: &[u8], value: impl Fn([u8; N]) -> T) -> Vec<T> {
        let (values, _) = payload.as_chunks::<N>();
        self.to_c_order(values.iter().map(|&bytes| value(bytes)).collect())
    }

    fn strings(&self, payload: &[u8], width: usize) -> Vec<Vec<u8>> {
        let unpadded = |field: &[u8]| {
            let end = field.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
            field[..end].to_vec()
        };
        self.to_c_order(payload.chunks_exact(width).map(unpadded).collect())
    }

    /// Reorders values whose first index runs fastest.
    fn to_c_order<T: Clone>(&self, values: Vec<T>) -> Vec<T> {
        if !self.fortran || self.shape.len() < 2 || self.count == 0 {
            return values;
        }
        let mut stride = vec![1; self.shape.len()];
        for axis in 1..self.shape.len() {
            stride[axis] = stride[axis - 1] * self.shape[axis - 1];
        }
        let mut index = vec![0; self.shape.len()];
        let mut source = 0;
        let mut reordered = Vec::with_capacity(self.count);
        for _ in 0..self.count {
            reordered.push(values[source].clone());
            for axis in (0..self.shape.len()).rev() {
                index[axis] += 1;
                source += stride[axis];
                if index[axis] < self.shape[axis] {
                    break;
                }
                source -= stride[axis] * self.shape[axis];
                index[axis] = 0;
            }
        }
        reordered
    }
}

/// The bytes of a version 1.0 `.npy` file.
pub(crate) fn encode(array: &Array) -> Result<Vec<u8>, MemberProblem> {
    if element_count(&array.shape) != Some(array.data.len()) {
        let (shape, found) = (array.shape.clone(), array.data.len());
        return Err(MemberProblem::ValueCount { shape, found });
    }
    let element = Element::of(&array.data);
    let mut bytes = encode_header(element, &array.shape)?;
    match &array.data {
        ArrayData::F64(x) => x.iter().for_each(|v| bytes.extend(v.to_le_bytes())),
        ArrayData::F32(x) => x.iter().for_each(|v| bytes.extend(v.to_le_bytes())),
        ArrayData::I64(x) => x.iter().for_each(|v| bytes.extend(v.to_le_bytes())),
        ArrayData::I32(x) => x.iter().for_each(|v| bytes.extend(v.to_le_bytes())),
        ArrayData::U8(x) => bytes.extend(x),
        ArrayData::Bool(x) => bytes.extend(x.iter().map(|&v| u8::from(v))),
        ArrayData::Bytes(x) => {
            for text in x {
                bytes.extend(text);
                bytes.resize(bytes.len() + element.width() - text.len(), 0);
            }
        }
    }
    Ok(bytes)
}

fn encode_header(element: Element, shape: &[usize]) -> Result<Vec<u8>, MemberProblem> {
    let sizes: Vec<String> = shape.iter().map(usize::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    let dict = format!(
        "{{'descr': '{}', 'fortran_order': False, 'shape': ({}{comma}), }}",
        element.descr(),
        sizes.join(", "),
    );
    let prefix = MAGIC.len() + 4;
    let total = (prefix + dict.len() + 1).next_multiple_of(ALIGNMENT);
    let length = u16::try_from(total - prefix).map_err(|_| MemberProblem::TooLarge { shape: shape.to_vec() })?;
    let mut bytes = Vec::with_capacity(total);
    bytes.extend(MAGIC);
    bytes.extend([1, 0]);
    bytes.extend(length.to_le_bytes());
    bytes.extend(dict.as_bytes());
    bytes.resize(total - 1, b' ');
    bytes.push(b'\n');
    Ok(bytes)
}
