//! Files written by NumPy (`testdata/generate.py`).

use signorini_npz::{Archive, ArrayData, MemberProblem, NpzError, StoredMatrix, read_npy};

use crate::testdata;

fn check_types(archive: &Archive) {
    let counting: Vec<f64> = (0..24).map(f64::from).collect();
    for name in ["c_order", "fortran_order"] {
        let array = archive.array(name).unwrap();
        assert_eq!(array.shape, [2, 3, 4]);
        assert_eq!(array.data, ArrayData::F64(counting.clone()), "{name}");
    }
    assert_eq!(archive.f64("f32").unwrap(), [f64::from(0.1f32), -2.5]);
    assert_eq!(archive.i32("i32").unwrap(), [1, -2, 3, i32::MAX]);
    assert_eq!(archive.i64("i64").unwrap(), [1 << 53, -(1 << 62)]);
    assert_eq!(archive.u8("u8").unwrap(), [0, 255]);
    assert_eq!(archive.array("bool").unwrap().data, ArrayData::Bool(vec![true, false, true]));
    assert_eq!(archive.i32("bool").unwrap(), [1, 0, 1]);
    assert_eq!(archive.string("text").unwrap(), "frictional3d");
    let texts = ["a", "longer", ""].map(|text| text.as_bytes().to_vec());
    assert_eq!(archive.array("texts").unwrap().data, ArrayData::Bytes(texts.to_vec()));
    assert_eq!(archive.scalar_f64("scalar").unwrap(), 0.001);
    assert_eq!(archive.array("scalar").unwrap().shape, [0usize; 0]);
    let special = archive.f64("special").unwrap();
    let bits: Vec<u64> = special.iter().map(|x| x.to_bits()).collect();
    assert!(special[2].is_nan());
    let expected = [f64::INFINITY, f64::NEG_INFINITY, special[2], -0.0, 5e-324];
    assert_eq!(bits, expected.map(f64::to_bits));
    assert_eq!(archive.array("empty").unwrap().shape, [0, 3]);
    assert!(archive.f64("empty").unwrap().is_empty());
}

#[test]
fn stored_archive() {
    check_types(&Archive::read(testdata("types.npz")).unwrap());
}

#[test]
fn deflated_archive() {
    check_types(&Archive::read(testdata("compressed.npz")).unwrap());
}

#[test]
fn lone_array_in_fortran_order() {
    let array = read_npy(testdata("fortran.npy")).unwrap();
    assert_eq!(array.shape, [2, 3]);
    assert_eq!(array.data, ArrayData::I64(vec![0, 1, 2, 3, 4, 5]));
}

#[test]
fn matrices_dense_and_sparse() {
    let archive = Archive::read(testdata("matrices.npz")).unwrap();
    let dense = archive.matrix("dense").unwrap();
    assert!(matches!(dense, StoredMatrix::Dense(_)));
    assert_eq!(dense.to_dense().unwrap().values, [1.0, 2.0, 0.0, 0.0, -3.0, 4.5]);
    let StoredMatrix::Sparse(sparse) = archive.matrix("A").unwrap() else { panic!("A is stored as CSR") };
    let entries = sparse.to_dense().unwrap();
    let expected = [[0.0, 0.0, 4.5, 0.0], [1.0, 2.0, 0.0, 0.0], [0.0, -3.0, 0.0, 0.0]];
    assert_eq!(entries.values, expected.as_flattened());
    assert_eq!(entries.get(1, 1), 2.0);
    assert!(!archive.contains_matrix("B") && archive.contains_matrix("A"));
}

#[test]
fn unsupported_types_are_named() {
    let archive = Archive::read(testdata("unsupported.npz")).unwrap();
    for (name, expected) in
        [("big_endian", ">f8"), ("unicode", "<U4"), ("structured", "(structured)"), ("complex", "<c16")]
    {
        match archive.array(name) {
            Err(NpzError::Member { member, problem: MemberProblem::ElementType { descr }, .. }) => {
                assert_eq!((member.as_str(), descr.as_str()), (name, expected));
            }
            other => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn wrong_requests_are_errors_with_names() {
    let archive = Archive::read(testdata("types.npz")).unwrap();
    let message = archive.f64("absent").unwrap_err().to_string();
    assert!(message.contains("types.npz") && message.contains("`absent`"), "{message}");
    assert!(message.contains("fortran_order"), "the names present are listed: {message}");
    let problem = |result: Result<(), NpzError>| match result {
        Err(NpzError::Member { problem, .. }) => problem,
        other => panic!("{other:?}"),
    };
    assert!(matches!(
        problem(archive.i32("c_order").map(drop)),
        MemberProblem::WrongType { expected: "i32", found: "f64" }
    ));
    assert!(matches!(
        problem(archive.f64("i64").map(drop)),
        MemberProblem::OutOfRange { index: 1, value: -4611686018427387904, expected: "f64" }
    ));
    assert!(matches!(problem(archive.scalar_f64("f32").map(drop)), MemberProblem::Shape { .. }));
    assert!(matches!(problem(archive.matrix("f32").map(drop)), MemberProblem::Shape { .. }));
    assert!(matches!(problem(archive.string("u8").map(drop)), MemberProblem::WrongType { .. }));
    assert!(matches!(Archive::read(testdata("absent.npz")), Err(NpzError::Io { .. })));
    assert!(matches!(Archive::read(testdata("fortran.npy")), Err(NpzError::Zip { .. })));
}

#[test]
fn every_public_contact_problem_decodes() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/contact_problems");
    let Ok(entries) = std::fs::read_dir(folder) else {
        println!("skipped: {folder} is absent");
        return;
    };
    let mut files = 0;
    for path in entries.map(|entry| entry.unwrap().path()) {
        if path.extension().is_none_or(|extension| extension != "npz") {
            continue;
        }
        let archive = Archive::read(&path).unwrap();
        for name in archive.names() {
            archive.array(name).unwrap();
        }
        for name in ["A", "W", "M", "JN", "JT"] {
            if archive.contains_matrix(name) {
                let (rows, cols) = archive.matrix(name).unwrap().shape();
                assert!(rows > 0 && cols > 0, "{}: {name}", path.display());
            }
        }
        files += 1;
    }
    assert!(files > 0, "no .npz file in {folder}");
}
