//! Numbers in forms that deflate well: differences of neighbours, and equal bytes of all numbers beside each other. The
//! page's `coding.ts` reads them.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Of 10; higher levels are slower and save little.
const COMPRESSION_LEVEL: u8 = 6;

/// Bytes deflated and as text.
pub(super) fn pack(bytes: &[u8]) -> String {
    STANDARD.encode(miniz_oxide::deflate::compress_to_vec_zlib(bytes, COMPRESSION_LEVEL))
}

/// Appends `values`, of which `row` belong together, as differences to the row before: first all low bytes, then all high ones.
pub(super) fn write_differences(values: &[u16], row: usize, block: &mut Vec<u8>) {
    let difference = |i: usize| values[i].wrapping_sub(if i < row { 0 } else { values[i - row] }).to_le_bytes();
    for byte in 0..2 {
        block.extend((0..values.len()).map(|i| difference(i)[byte]));
    }
}

/// Appends indices that appear for the first time in ascending order, each as its distance from the first one not met so far,
/// which is small where neighbours follow each other: first all low bytes, then the next ones.
pub(super) fn write_indices(indices: &[u32], block: &mut Vec<u8>) {
    let mut next = 0;
    let distances: Vec<[u8; 4]> = indices
        .iter()
        .map(|&index| {
            let distance = next - index;
            next = next.max(index + 1);
            distance.to_le_bytes()
        })
        .collect();
    write_planes(&distances, block);
}

/// Appends numbers of which `row` belong together: column after column, each number as the difference of its bits to those of
/// the number before in its column.
pub(super) fn write_columns(values: &[f32], row: usize, block: &mut Vec<u8>) {
    let column = |k: usize| values.iter().skip(k).step_by(row).map(|x| x.to_bits());
    let mut differences = Vec::with_capacity(values.len());
    for k in 0..row {
        let before = std::iter::once(0).chain(column(k));
        differences.extend(column(k).zip(before).map(|(bits, before)| bits.wrapping_sub(before).to_le_bytes()));
    }
    write_planes(&differences, block);
}

/// Appends the lowest bytes of all numbers, then the next ones, and so on.
pub(super) fn write_planes(numbers: &[[u8; 4]], block: &mut Vec<u8>) {
    for byte in 0..4 {
        block.extend(numbers.iter().map(|bytes| bytes[byte]));
    }
}

/// The number with `bits` bits after the leading one, rounded.
pub(super) fn rounded(x: f64, bits: u32) -> f32 {
    let x = x as f32;
    if !x.is_finite() {
        return x;
    }
    let dropped = f32::MANTISSA_DIGITS - 1 - bits;
    let half = 1_u32 << (dropped - 1);
    let rounded = f32::from_bits((x.to_bits() + half) & !((1 << dropped) - 1));
    // The largest numbers would round to infinity.
    if rounded.is_finite() { rounded } else { x }
}
