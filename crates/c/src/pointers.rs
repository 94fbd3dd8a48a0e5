//! Pointers of the caller as references and slices.

use std::ffi::{c_char, CStr};

use crate::error::Failure;

/// What a pointer points to.
///
/// # Safety
/// `pointer` is null or valid for reads for `'a`.
pub(crate) unsafe fn shared<'a, T>(pointer: *const T, name: &str) -> Result<&'a T, Failure> {
    // SAFETY: the caller's.
    unsafe { pointer.as_ref() }.ok_or_else(|| Failure::argument(format_args!("{name} is NULL")))
}

/// The same, to change it.
///
/// # Safety
/// `pointer` is null or valid for reads and writes for `'a`, and nobody else uses what it points to.
pub(crate) unsafe fn owned<'a, T>(pointer: *mut T, name: &str) -> Result<&'a mut T, Failure> {
    // SAFETY: the caller's.
    unsafe { pointer.as_mut() }.ok_or_else(|| Failure::argument(format_args!("{name} is NULL")))
}

/// An array to read.
///
/// # Safety
/// `pointer` is null or valid for reads of `length` numbers for `'a`.
pub(crate) unsafe fn array<'a, T>(pointer: *const T, length: usize, name: &str) -> Result<&'a [T], Failure> {
    if length == 0 {
        return Ok(&[]);
    }
    // SAFETY: the caller's.
    unsafe { shared(pointer, name)? };
    // SAFETY: as above, and not null.
    Ok(unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// An array to write, of a length that has to be `expected`.
///
/// # Safety
/// `pointer` is null or valid for writes of `length` numbers for `'a`, and nobody else uses them.
pub(crate) unsafe fn array_of<'a, T>(
    pointer: *mut T,
    length: usize,
    expected: usize,
    name: &str,
) -> Result<&'a mut [T], Failure> {
    check_length(name, length, expected)?;
    if length == 0 {
        return Ok(&mut []);
    }
    // SAFETY: the caller's.
    unsafe { owned(pointer, name)? };
    // SAFETY: as above, and not null.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, length) })
}

pub(crate) fn check_length(name: &str, found: usize, expected: usize) -> Result<(), Failure> {
    if found == expected {
        return Ok(());
    }
    Err(Failure::argument(format_args!("{name} has {found} numbers; it must have {expected}")))
}

/// Text of the caller.
///
/// # Safety
/// `pointer` is null or points to text that ends with a zero, for `'a`.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, name: &str) -> Result<&'a str, Failure> {
    // SAFETY: the caller's.
    unsafe { shared(pointer, name)? };
    // SAFETY: as above, and not null.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| Failure::argument(format_args!("{name} is not UTF-8 text")))
}

/// Gives a handle to the caller.
///
/// # Safety
/// `place` is null or valid for writes.
pub(crate) unsafe fn give<T>(place: *mut *mut T, handle: T) -> Result<(), Failure> {
    // SAFETY: the caller's.
    *unsafe { owned(place, "the place for the new handle") }? = Box::into_raw(Box::new(handle));
    Ok(())
}

/// Takes a handle back and frees it.
///
/// # Safety
/// `handle` is null or came from [`give`] and was not taken back.
pub(crate) unsafe fn take_back<T>(handle: *mut T) {
    if !handle.is_null() {
        // SAFETY: the caller's.
        drop(unsafe { Box::from_raw(handle) });
    }
}
