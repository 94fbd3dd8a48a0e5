//! Wrong input is refused at construction, with its place.

use signorini_lcp::{
    Enumeration, EnumerationSettings, Lcp, LcpError, Lemke, LemkeSettings, Matrix, MethodKind, MixedLcp,
    PrincipalPivoting, PrincipalPivotingSettings, Psor, PsorSettings, SemismoothNewton, SemismoothNewtonSettings,
};
use signorini_lcp::{Method, Scaling, Status};

#[test]
fn shapes_and_entries_are_checked() {
    assert_eq!(Matrix::new(2, 2, vec![0.0; 3]), Err(LcpError::MatrixSize { rows: 2, cols: 2, found: 3 }));
    assert_eq!(Lcp::new(Matrix::zeros(2, 3), vec![0.0; 2]), Err(LcpError::NotSquare { rows: 2, cols: 3 }));
    let short = Lcp::new(Matrix::zeros(2, 2), vec![0.0; 3]);
    assert_eq!(short, Err(LcpError::Length { what: "b", expected: 2, found: 3 }));
    let mut A = Matrix::zeros(3, 3);
    A[(1, 2)] = f64::INFINITY;
    let error = Lcp::new(A, vec![0.0; 3]).unwrap_err();
    assert_eq!(error, LcpError::MatrixNotFinite { row: 1, col: 2, value: f64::INFINITY });
    assert!(error.to_string().contains("A[1, 2]"));
    let error = Lcp::new(Matrix::zeros(2, 2), vec![0.0, f64::NAN]).unwrap_err();
    assert!(matches!(error, LcpError::VectorNotFinite { what: "b", index: 1, .. }));
    let mixed = MixedLcp::new(Matrix::zeros(2, 2), vec![0.0; 2], vec![true]);
    assert_eq!(mixed, Err(LcpError::Length { what: "free", expected: 2, found: 1 }));
}

#[test]
fn weights_are_positive() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = Scaling::new(vec![1.0, 1.0], vec![1.0, bad]).unwrap_err();
        assert!(matches!(error, LcpError::Weight { what: "w", index: 1, .. }), "{bad}: {error}");
    }
    let scaling = Scaling::new(vec![1.0], vec![1.0]).unwrap();
    let error = Lcp::with_scaling(Matrix::zeros(2, 2), vec![0.0; 2], scaling).unwrap_err();
    assert_eq!(error, LcpError::Length { what: "scaling", expected: 2, found: 1 });
}

#[test]
fn settings_are_checked() {
    let refused = |settings: LemkeSettings, field: &str| match Lemke::new(settings) {
        Err(LcpError::Setting { setting, .. }) => assert_eq!(setting, field),
        other => panic!("{field}: {other:?}"),
    };
    refused(LemkeSettings::default().with_tolerance(0.0), "tolerance");
    refused(LemkeSettings::default().with_tolerance(f64::NAN), "tolerance");
    refused(LemkeSettings::default().with_tie(1.0), "tie");
    refused(LemkeSettings::default().with_pivot(-1.0), "pivot");
    refused(LemkeSettings::default().with_updates(0), "updates");
    refused(LemkeSettings::default().with_pivots_per_pair(0), "pivots_per_pair");
    refused(LemkeSettings::default().with_covering_vectors(0), "covering_vectors");
    let psor = Psor::new(PsorSettings::default().with_relaxation(2.0)).unwrap_err();
    assert!(matches!(psor, LcpError::Setting { setting: "relaxation", value: 2.0, .. }));
    let newton = SemismoothNewtonSettings::default().with_steps(0);
    assert!(matches!(SemismoothNewton::new(newton), Err(LcpError::Setting { setting: "steps", .. })));
    let principal = PrincipalPivotingSettings::default().with_tie(1.0);
    assert!(matches!(PrincipalPivoting::new(principal), Err(LcpError::Setting { setting: "tie", .. })));
    let error = Enumeration::new(EnumerationSettings::default().with_max_pairs(25)).unwrap_err();
    assert!(matches!(error, LcpError::Setting { setting: "max_pairs", .. }));
}

#[test]
fn methods_have_names() {
    for kind in MethodKind::all() {
        assert_eq!(kind.to_string().parse(), Ok(kind));
    }
    let error = "simplex".parse::<MethodKind>().unwrap_err();
    assert!(error.to_string().contains("lemke, enumeration"), "{error}");
}

#[test]
fn enumeration_refuses_large_problems() {
    let problem = Lcp::new(Matrix::zeros(17, 17), vec![-1.0; 17]).unwrap();
    let solution = Enumeration::default().solve(&problem, None);
    assert_eq!(solution.status, Status::TooLarge { limit: 16 });
    let error = Enumeration::default().solution_set(&problem).unwrap_err();
    assert_eq!(error, LcpError::TooManyPairs { found: 17, limit: 16 });
}
