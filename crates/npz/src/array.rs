//! An array in memory: shape, element type, values in C order.

use crate::error::MemberProblem;

/// An array of any rank; rank 0 is a scalar.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Extent along each index.
    pub shape: Vec<usize>,
    /// The values, last index fastest.
    pub data: ArrayData,
}

/// Values by element type.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum ArrayData {
    /// `<f8`
    F64(Vec<f64>),
    /// `<f4`
    F32(Vec<f32>),
    /// `<i8`
    I64(Vec<i64>),
    /// `<i4`
    I32(Vec<i32>),
    /// `|u1`
    U8(Vec<u8>),
    /// `|b1`; any byte other than 0 reads as true
    Bool(Vec<bool>),
    /// `|S`: byte strings without the trailing zero bytes that pad them
    Bytes(Vec<Vec<u8>>),
}

impl ArrayData {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::F64(x) => x.len(),
            Self::F32(x) => x.len(),
            Self::I64(x) => x.len(),
            Self::I32(x) => x.len(),
            Self::U8(x) => x.len(),
            Self::Bool(x) => x.len(),
            Self::Bytes(x) => x.len(),
        }
    }

    /// Whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The element type's name, for messages.
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::F64(_) => "f64",
            Self::F32(_) => "f32",
            Self::I64(_) => "i64",
            Self::I32(_) => "i32",
            Self::U8(_) => "u8",
            Self::Bool(_) => "bool",
            Self::Bytes(_) => "byte strings",
        }
    }
}

/// Integers beyond this are not all representable in `f64`.
const EXACT_IN_F64: i64 = 1 << 53;

impl Array {
    /// An array of `shape` whose values are `data` in C order.
    ///
    /// # Errors
    /// [`MemberProblem::ValueCount`] when the number of values is not the product of the shape.
    pub fn new(shape: Vec<usize>, data: ArrayData) -> Result<Self, MemberProblem> {
        if element_count(&shape) != Some(data.len()) {
            let found = data.len();
            return Err(MemberProblem::ValueCount { shape, found });
        }
        Ok(Self { shape, data })
    }

    /// The values as `f64`: from `f64`, `f32` and from integers of at most 53 bits, all exactly.
    ///
    /// # Errors
    /// [`MemberProblem::WrongType`] for strings, [`MemberProblem::OutOfRange`] for larger integers.
    pub fn to_f64(&self) -> Result<Vec<f64>, MemberProblem> {
        match &self.data {
            ArrayData::F64(x) => Ok(x.clone()),
            ArrayData::F32(x) => Ok(x.iter().map(|&v| f64::from(v)).collect()),
            _ => self.integers("f64", |v| (v.abs_diff(0) <= EXACT_IN_F64 as u64).then_some(v as f64)),
        }
    }

    /// The values as `i64`: from any integer type and `bool`.
    ///
    /// # Errors
    /// [`MemberProblem::WrongType`] for floating-point numbers and strings.
    pub fn to_i64(&self) -> Result<Vec<i64>, MemberProblem> {
        self.integers("i64", Some)
    }

    /// The values as `i32`: from any integer type and `bool`, if they fit.
    ///
    /// # Errors
    /// [`MemberProblem::WrongType`] for floating-point numbers and strings,
    /// [`MemberProblem::OutOfRange`] for integers of more than 32 bits.
    pub fn to_i32(&self) -> Result<Vec<i32>, MemberProblem> {
        self.integers("i32", |v| i32::try_from(v).ok())
    }

    /// The values as `u8`: from any integer type and `bool`, if they fit.
    ///
    /// # Errors
    /// As [`Array::to_i32`].
    pub fn to_u8(&self) -> Result<Vec<u8>, MemberProblem> {
        self.integers("u8", |v| u8::try_from(v).ok())
    }

    /// The only value's text, from a byte string of rank 0, or rank 1 and length 1.
    ///
    /// # Errors
    /// [`MemberProblem::WrongType`], [`MemberProblem::Shape`], [`MemberProblem::NotUtf8`].
    pub fn to_text(&self) -> Result<String, MemberProblem> {
        let ArrayData::Bytes(strings) = &self.data else {
            return Err(self.wrong_type("a byte string"));
        };
        match &strings[..] {
            [text] => String::from_utf8(text.clone()).map_err(|_| MemberProblem::NotUtf8),
            _ => Err(self.wrong_shape("one value")),
        }
    }

    /// The entries converted one by one, where the element type is an integer or `bool`.
    fn integers<T>(&self, expected: &'static str, convert: impl Fn(i64) -> Option<T>) -> Result<Vec<T>, MemberProblem> {
        let checked =
            |(index, value): (usize, i64)| convert(value).ok_or(MemberProblem::OutOfRange { index, value, expected });
        match &self.data {
            ArrayData::I64(x) => x.iter().copied().enumerate().map(checked).collect(),
            ArrayData::I32(x) => x.iter().map(|&v| v.into()).enumerate().map(checked).collect(),
            ArrayData::U8(x) => x.iter().map(|&v| v.into()).enumerate().map(checked).collect(),
            ArrayData::Bool(x) => x.iter().map(|&v| v.into()).enumerate().map(checked).collect(),
            _ => Err(self.wrong_type(expected)),
        }
    }

    pub(crate) fn wrong_type(&self, expected: &'static str) -> MemberProblem {
        MemberProblem::WrongType { expected, found: self.data.type_name() }
    }

    pub(crate) fn wrong_shape(&self, expected: &'static str) -> MemberProblem {
        MemberProblem::Shape { expected, found: self.shape.clone() }
    }
}

/// Product of the extents; `None` when it overflows.
pub(crate) fn element_count(shape: &[usize]) -> Option<usize> {
    if shape.contains(&0) {
        return Some(0);
    }
    shape.iter().try_fold(1usize, |count, &extent| count.checked_mul(extent))
}
