//! What is written is read back, by us and (structure) by the zip rules.

use proptest::prelude::*;
use signorini_npz::{
    Archive, ArchiveWriter, Array, ArrayData, MemberProblem, NpzError, SparseMatrix, StoredMatrix, read_npy, write_npy,
};

fn data(len: usize) -> impl Strategy<Value = ArrayData> {
    use prop::collection::vec;
    prop_oneof![
        vec(-1e300..1e300f64, len).prop_map(ArrayData::F64),
        vec(-1e30..1e30f32, len).prop_map(ArrayData::F32),
        vec(any::<i64>(), len).prop_map(ArrayData::I64),
        vec(any::<i32>(), len).prop_map(ArrayData::I32),
        vec(any::<u8>(), len).prop_map(ArrayData::U8),
        vec(any::<bool>(), len).prop_map(ArrayData::Bool),
        vec(vec(1..=255u8, 0..6), len).prop_map(ArrayData::Bytes),
    ]
}

fn array() -> impl Strategy<Value = Array> {
    prop::collection::vec(0..5usize, 0..4)
        .prop_flat_map(|shape| data(shape.iter().product()).prop_map(move |data| Array { shape: shape.clone(), data }))
}

proptest! {
    #[test]
    fn arrays_survive(arrays in prop::collection::vec(array(), 0..4)) {
        let mut writer = ArchiveWriter::new();
        for (i, array) in arrays.iter().enumerate() {
            writer.array(&format!("array {i}"), array).unwrap();
        }
        let archive = Archive::from_bytes("memory", writer.to_bytes().unwrap()).unwrap();
        prop_assert_eq!(archive.names().count(), arrays.len());
        for (i, array) in arrays.iter().enumerate() {
            prop_assert_eq!(&archive.array(&format!("array {i}")).unwrap(), array);
        }
    }
}

#[test]
fn files_on_disk() {
    let folder = std::env::temp_dir().join(format!("signorini-npz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let sparse =
        SparseMatrix { rows: 2, cols: 3, indptr: vec![0, 2, 3], indices: vec![2, 0, 1], values: vec![1.0, 2.0, 3.0] };
    let mut writer = ArchiveWriter::new();
    writer.csr("A", &sparse).unwrap().string("kind", "lcp").unwrap();
    writer.scalar_f64("dt", 0.01).unwrap();
    writer.write(folder.join("a.npz")).unwrap();
    let archive = Archive::read(folder.join("a.npz")).unwrap();
    assert_eq!(archive.matrix("A").unwrap(), StoredMatrix::Sparse(sparse));
    assert_eq!(archive.i64("A_shape").unwrap(), [2, 3]);
    assert_eq!(archive.scalar_f64("dt").unwrap(), 0.01);

    let array = Array { shape: vec![3], data: ArrayData::I32(vec![1, 2, 3]) };
    write_npy(folder.join("a.npy"), &array).unwrap();
    assert_eq!(read_npy(folder.join("a.npy")).unwrap(), array);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn the_writer_refuses_contradictions() {
    let problem = |result: Result<&mut ArchiveWriter, NpzError>| match result {
        Err(NpzError::Unwritable { problem, .. }) => problem,
        other => panic!("{other:?}"),
    };
    let mut writer = ArchiveWriter::new();
    let short = problem(writer.f64("x", &[2, 2], &[1.0]));
    assert_eq!(short, MemberProblem::ValueCount { shape: vec![2, 2], found: 1 });
    writer.f64("x", &[1], &[1.0]).unwrap();
    assert_eq!(problem(writer.f64("x", &[1], &[1.0])), MemberProblem::Name);
    assert_eq!(problem(writer.f64("", &[1], &[1.0])), MemberProblem::Name);
    let outside = SparseMatrix { rows: 1, cols: 1, indptr: vec![0, 1], indices: vec![1], values: vec![1.0] };
    assert!(matches!(problem(writer.csr("A", &outside)), MemberProblem::Csr { index: 0, .. }));
}
