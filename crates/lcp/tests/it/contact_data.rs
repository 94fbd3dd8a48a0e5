//! The public contact and complementarity problems, assembled as dense LCPs.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use signorini_lcp::{Lcp, Matrix, MixedLcp, Scaling};
use signorini_npz::{Archive, NpzError};

fn open(path: &Path) -> Archive {
    expect(Archive::read(path))
}

/// The value, or the error's own message, which names file and array.
fn expect<T>(result: Result<T, NpzError>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

fn values(archive: &Archive, name: &str) -> Vec<f64> {
    expect(archive.f64(name))
}

fn kind(archive: &Archive) -> String {
    expect(archive.string("kind"))
}

/// A problem of the collection with its name, e.g. `Rover1040 m=8`.
pub struct Named<P> {
    pub name: String,
    pub expected: String,
    pub problem: P,
}

/// The folder of the data, or `None` (and a line that says so) when it is absent.
pub fn folder() -> Option<PathBuf> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/contact_problems"));
    if folder.is_dir() {
        return Some(folder.to_owned());
    }
    println!("skipped: {} is absent", folder.display());
    None
}

pub fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("readable folder")
        .map(|entry| entry.expect("readable entry").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "npz"))
        .collect();
    files.sort();
    files
}

/// The LCPs of one file with at most `max_pairs` pairs; none for a mixed problem.
pub fn lcps(path: &Path, max_pairs: usize) -> Vec<Named<Lcp>> {
    let arrays = open(path);
    let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
    let named = |suffix: &str, problem| Named {
        name: format!("{stem}{suffix}"),
        expected: arrays.string("expected").unwrap_or_else(|_| "solvable".to_owned()),
        problem,
    };
    match kind(&arrays).as_str() {
        "lcp" => {
            let A = dense(&arrays, "A");
            vec![named("", Lcp::new(A, values(&arrays, "b")).unwrap())]
        }
        "frictional2d" => {
            let nc = values(&arrays, "mu").len();
            if 4 * nc > max_pairs {
                return Vec::new();
            }
            let directions = vec![vec![vec![1.0], vec![-1.0]]; nc];
            vec![named("", from_delassus(&arrays, &directions))]
        }
        "frictional3d" => {
            let nc = values(&arrays, "mu").len();
            [4, 8]
                .into_iter()
                .filter(|m| (m + 2) * nc <= max_pairs)
                .map(|m| {
                    let angle = |k: usize| TAU * k as f64 / m as f64;
                    let polygon: Vec<Vec<f64>> = (0..m).map(|k| vec![angle(k).cos(), angle(k).sin()]).collect();
                    named(&format!(" m={m}"), from_delassus(&arrays, &vec![polygon; nc]))
                })
                .collect()
        }
        "contact" => {
            let m: Vec<usize> = values(&arrays, "m").iter().map(|&m| m as usize).collect();
            if 2 * m.len() + m.iter().sum::<usize>() > max_pairs {
                return Vec::new();
            }
            vec![named("", from_jacobians(&arrays, &m))]
        }
        _ => Vec::new(),
    }
}

/// The mixed problem of one file, if it holds a square one.
pub fn mixed(path: &Path) -> Option<Named<MixedLcp>> {
    let arrays = open(path);
    if kind(&arrays) != "mlcp" {
        return None;
    }
    let A = dense(&arrays, "A");
    let free = values(&arrays, "is_comp").iter().map(|&comp| comp == 0.0).collect();
    Some(Named {
        name: path.file_stem().unwrap().to_string_lossy().into_owned(),
        expected: "solvable".to_owned(),
        problem: MixedLcp::new(A, values(&arrays, "b"), free).ok()?,
    })
}

fn dense(archive: &Archive, name: &str) -> Matrix {
    let matrix = expect(archive.matrix(name)).to_dense().expect("a matrix that fits into memory");
    Matrix::new(matrix.rows, matrix.cols, matrix.values).unwrap()
}

fn from_delassus(arrays: &Archive, directions: &[Vec<Vec<f64>>]) -> Lcp {
    polyhedral(&dense(arrays, "W"), &values(arrays, "q"), &values(arrays, "mu"), directions)
}

/// W = J M⁻¹ Jᵀ = (L⁻¹Jᵀ)ᵀ(L⁻¹Jᵀ) with the Cholesky factor of M; q = J v_f + (φ/Δt, 0, 0).
fn from_jacobians(arrays: &Archive, m: &[usize]) -> Lcp {
    let (mass, jn, jt) = (dense(arrays, "M"), dense(arrays, "JN"), dense(arrays, "JT"));
    let (nc, nv) = (m.len(), mass.rows());
    let (v_free, phi, dt) = (&values(arrays, "vf"), values(arrays, "phi"), expect(arrays.scalar_f64("dt")));
    let jacobian_row = |r: usize| {
        if r.is_multiple_of(3) { jn.row(r / 3) } else { jt.row(2 * (r / 3) + r % 3 - 1) }
    };
    let L = cholesky(&mass);
    let half: Vec<Vec<f64>> = (0..3 * nc).map(|r| forward_substitution(&L, jacobian_row(r))).collect();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let W = Matrix::from_fn(3 * nc, 3 * nc, |r, s| product(&half[r], &half[s]));
    let q: Vec<f64> = (0..3 * nc)
        .map(|r| product(jacobian_row(r), v_free) + if r.is_multiple_of(3) { phi[r / 3] / dt } else { 0.0 })
        .collect();
    assert_eq!(v_free.len(), nv);
    let mut rows = dense(arrays, "D").data().chunks_exact(2).map(<[f64]>::to_vec).collect::<Vec<_>>().into_iter();
    let directions: Vec<Vec<Vec<f64>>> = m.iter().map(|&m| rows.by_ref().take(m).collect()).collect();
    polyhedral(&W, &q, &values(arrays, "mu"), &directions)
}

fn cholesky(M: &Matrix) -> Matrix {
    let n = M.rows();
    let mut L = Matrix::zeros(n, n);
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = M[(i, j)] - (0..j).map(|k| L[(i, k)] * L[(j, k)]).sum::<f64>();
            L[(i, j)] = if i == j { sum.sqrt() } else { sum / L[(j, j)] };
        }
    }
    L
}

fn forward_substitution(L: &Matrix, rhs: &[f64]) -> Vec<f64> {
    let mut x: Vec<f64> = Vec::with_capacity(rhs.len());
    for i in 0..rhs.len() {
        let sum: f64 = L.row(i)[..i].iter().zip(&x).map(|(a, x)| a * x).sum();
        x.push((rhs[i] - sum) / L[(i, i)]);
    }
    x
}

/// The LCP of contacts with friction polygons, z = (λ_N, α, β), in velocity units.
///
/// - `W`: Delassus matrix, per contact the normal and then the tangents
/// - `directions[c][k]`: tangent direction k of contact c
pub fn polyhedral(W: &Matrix, q: &[f64], mu: &[f64], directions: &[Vec<Vec<f64>>]) -> Lcp {
    let nc = mu.len();
    let per_contact = W.rows() / nc;
    let alphas: Vec<(usize, &[f64])> =
        directions.iter().enumerate().flat_map(|(c, ds)| ds.iter().map(move |d| (c, &d[..]))).collect();
    // Every impulse (λ_N or α) acts along a few rows of W with weights.
    let mut terms: Vec<Vec<(usize, f64)>> = (0..nc).map(|c| vec![(c * per_contact, 1.0)]).collect();
    for (c, d) in &alphas {
        terms.push(d.iter().enumerate().map(|(t, d)| (c * per_contact + 1 + t, *d)).collect());
    }
    let impulses = terms.len();
    let n = impulses + nc;
    let mut A = Matrix::zeros(n, n);
    let mut b = vec![0.0; n];
    for (i, row) in terms.iter().enumerate() {
        b[i] = row.iter().map(|(r, d)| d * q[*r]).sum();
        for (j, col) in terms.iter().enumerate() {
            A[(i, j)] = row.iter().flat_map(|(r, d)| col.iter().map(move |(s, e)| d * e * W[(*r, *s)])).sum();
        }
    }
    for (k, (c, _)) in alphas.iter().enumerate() {
        A[(nc + k, impulses + c)] = 1.0;
        A[(impulses + c, nc + k)] = -1.0;
    }
    for c in 0..nc {
        A[(impulses + c, c)] = mu[c];
    }
    let g = (0..W.rows()).fold(0.0f64, |max, i| max.max(W[(i, i)]));
    let in_velocity = |impulse: f64, bound: f64| [vec![impulse; impulses], vec![bound; nc]].concat();
    Lcp::with_scaling(A, b, Scaling::new(in_velocity(g, 1.0), in_velocity(1.0, g)).unwrap()).unwrap()
}
