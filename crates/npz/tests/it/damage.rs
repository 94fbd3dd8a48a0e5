//! Damaged bytes end in an error or in arrays, never in a panic or a huge allocation.

use proptest::prelude::*;
use signorini_npz::{Archive, ArchiveWriter, MemberProblem, NpzError, SparseMatrix};

use crate::testdata;

/// Asks an archive for everything it offers.
fn read_everything(bytes: Vec<u8>) {
    let Ok(archive) = Archive::from_bytes("damaged.npz", bytes) else {
        return;
    };
    let names: Vec<String> = archive.names().map(str::to_owned).collect();
    for name in &names {
        let _ = (archive.array(name), archive.f64(name), archive.i32(name), archive.u8(name));
        let _ = (archive.string(name), archive.scalar_f64(name), archive.matrix(name));
    }
    if let Ok(matrix) = archive.matrix("A") {
        let _ = matrix.to_dense();
    }
}

fn original(which: usize) -> Vec<u8> {
    let name = ["types.npz", "compressed.npz", "matrices.npz"][which];
    std::fs::read(testdata(name)).unwrap()
}

/// An archive with one member whose `.npy` bytes are given, with a correct checksum, by patching a
/// placeholder of the same length: damage inside reaches the `.npy` reader.
fn with_member(npy: &[u8]) -> Vec<u8> {
    let placeholder_values = npy.len().saturating_sub(128);
    let mut writer = ArchiveWriter::new();
    writer.u8("A", &[placeholder_values], &vec![0; placeholder_values]).unwrap();
    let mut bytes = writer.to_bytes().unwrap();
    let member = bytes.windows(6).position(|w| w == b"\x93NUMPY").unwrap();
    let old_crc = bytes[14..18].to_vec();
    let length = npy.len().min(128 + placeholder_values);
    bytes[member..member + length].copy_from_slice(&npy[..length]);
    let new_crc = crc32(&bytes[member..member + 128 + placeholder_values]).to_le_bytes();
    for at in 0..bytes.len() - 4 {
        if bytes[at..at + 4] == old_crc[..] && (at == 14 || at > member) {
            bytes[at..at + 4].copy_from_slice(&new_crc);
        }
    }
    bytes
}

/// CRC-32 of the zip format, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = !0u32;
    for &byte in bytes {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg());
        }
    }
    !crc
}

/// A `.npy` file padded to a header of 128 bytes, so that [`with_member`] keeps its length.
fn npy(dict: &str, payload: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(dict.as_bytes());
    bytes.resize(127, b' ');
    bytes.push(b'\n');
    bytes.extend(payload);
    bytes
}

fn member_problem(dict: &str, payload: &[u8]) -> MemberProblem {
    let archive = Archive::from_bytes("made.npz", with_member(&npy(dict, payload))).unwrap();
    match archive.array("A") {
        Err(NpzError::Member { problem, .. }) => problem,
        other => panic!("{dict}: {other:?}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn flipped_bytes(which in 0..3usize, edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8)) {
        let mut bytes = original(which);
        for (at, value) in edits {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        read_everything(bytes);
    }

    #[test]
    fn directory_fields_set_to_extremes(which in 0..3usize, at in any::<prop::sample::Index>(), value in prop::sample::select(vec![0u32, 1, 0x7FFF_FFFF, 0xFFFF_FFFE, u32::MAX])) {
        let mut bytes = original(which);
        let tail = bytes.len().min(900);
        let at = bytes.len() - tail + at.index(tail - 4);
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        read_everything(bytes);
    }

    #[test]
    fn cut_files(which in 0..3usize, length in any::<prop::sample::Index>()) {
        let mut bytes = original(which);
        bytes.truncate(length.index(bytes.len()));
        read_everything(bytes);
    }

    #[test]
    fn random_headers(header in "[{}'(),: a-z0-9<|]{0,100}", payload in prop::collection::vec(any::<u8>(), 0..40)) {
        read_everything(with_member(&npy(&header, &payload)));
    }

    #[test]
    fn random_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        read_everything(bytes);
    }

    #[test]
    fn random_sparse_matrices(rows in 0..4usize, cols in 0..4usize, indptr in prop::collection::vec(0..6usize, 0..6), indices in prop::collection::vec(0..5usize, 0..6), more in 0..2usize) {
        let values = vec![1.0; indices.len() + more];
        let sum = values.len() as f64;
        let matrix = SparseMatrix { rows, cols, indptr, indices, values };
        if let Ok(dense) = matrix.to_dense() {
            prop_assert_eq!(dense.values.iter().sum::<f64>(), sum);
        }
    }
}

#[test]
fn a_flipped_value_is_noticed_by_the_checksum() {
    let mut bytes = original(0);
    let start = bytes.windows(6).position(|w| w == b"\x93NUMPY").unwrap();
    bytes[start + 200] ^= 1;
    let archive = Archive::from_bytes("damaged.npz", bytes).unwrap();
    let damaged = archive.names().filter(|name| {
        let problem = archive.array(name);
        matches!(problem, Err(NpzError::Member { problem: MemberProblem::Checksum { .. }, .. }))
    });
    assert_eq!(damaged.count(), 1);
}

#[test]
fn declared_sizes_are_checked_before_allocation() {
    let huge = "{'descr': '<f8', 'fortran_order': False, 'shape': (4611686018427387904, 8), }";
    assert!(matches!(member_problem(huge, &[0; 8]), MemberProblem::TooLarge { .. }));
    let large = "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }";
    assert!(matches!(
        member_problem(large, &[0; 8]),
        MemberProblem::DataSize { needed: 8_000_000_000_000, found: 8, .. }
    ));
    let wide = "{'descr': '|S18446744073709551615', 'fortran_order': False, 'shape': (2,), }";
    assert!(matches!(member_problem(wide, &[0; 8]), MemberProblem::TooLarge { .. }));
    let no_width = "{'descr': '|S0', 'fortran_order': False, 'shape': (1000000000000,), }";
    assert!(matches!(member_problem(no_width, &[0; 8]), MemberProblem::ElementType { .. }));
    let wide_matrix = SparseMatrix { rows: 1, cols: usize::MAX, indptr: vec![0, 0], indices: vec![], values: vec![] };
    assert!(matches!(wide_matrix.to_dense(), Err(MemberProblem::TooLarge { .. })));
}

#[test]
fn bad_headers_say_what_is_wrong() {
    for dict in [
        "",
        "{'descr': '<f8', 'fortran_order': False}",
        "{'descr': '<f8', 'shape': (1,)}",
        "{'fortran_order': False, 'shape': (1,)}",
        "{'descr': '<f8', 'fortran_order': 0, 'shape': (1,)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (-1,)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': 1}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1,), 'more': 1}",
    ] {
        assert!(matches!(member_problem(dict, &[0; 8]), MemberProblem::Header { .. }), "{dict}");
    }
}
