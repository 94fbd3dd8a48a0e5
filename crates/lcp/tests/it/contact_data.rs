//! The public contact and complementarity problems, assembled as dense LCPs.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use signorini_lcp::{Lcp, Matrix, MixedLcp, Scaling};

use crate::npz::{self, Array};

type Arrays = HashMap<String, Array>;

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
    let arrays = npz::read(path);
    let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
    let named = |suffix: &str, problem| Named {
        name: format!("{stem}{suffix}"),
        expected: arrays.get("expected").map_or_else(|| "solvable".to_owned(), Array::text),
        problem,
    };
    match arrays["kind"].text().as_str() {
        "lcp" => {
            let A = dense(&arrays, "A");
            vec![named("", Lcp::new(A, arrays["b"].values.clone()).unwrap())]
        }
        "frictional2d" => {
            let nc = arrays["mu"].values.len();
            if 4 * nc > max_pairs {
                return Vec::new();
            }
            let directions = vec![vec![vec![1.0], vec![-1.0]]; nc];
            vec![named("", from_delassus(&arrays, &directions))]
        }
        "frictional3d" => {
            let nc = arrays["mu"].values.len();
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
            let m: Vec<usize> = arrays["m"].values.iter().map(|&m| m as usize).collect();
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
    let arrays = npz::read(path);
    if arrays["kind"].text() != "mlcp" {
        return None;
    }
    let A = dense(&arrays, "A");
    let free = arrays["is_comp"].values.iter().map(|&comp| comp == 0.0).collect();
    Some(Named {
        name: path.file_stem().unwrap().to_string_lossy().into_owned(),
        expected: "solvable".to_owned(),
        problem: MixedLcp::new(A, arrays["b"].values.clone(), free).ok()?,
    })
}

fn dense(arrays: &Arrays, name: &str) -> Matrix {
    if let Some(array) = arrays.get(name) {
        return Matrix::new(array.shape[0], array.shape[1], array.values.clone()).unwrap();
    }
    let part = |suffix: &str| &arrays[&format!("{name}_{suffix}")].values;
    let (data, indices, indptr, shape) = (part("data"), part("indices"), part("indptr"), part("shape"));
    let mut matrix = Matrix::zeros(shape[0] as usize, shape[1] as usize);
    for i in 0..matrix.rows() {
        for k in indptr[i] as usize..indptr[i + 1] as usize {
            matrix[(i, indices[k] as usize)] += data[k];
        }
    }
    matrix
}

fn from_delassus(arrays: &Arrays, directions: &[Vec<Vec<f64>>]) -> Lcp {
    polyhedral(&dense(arrays, "W"), &arrays["q"].values, &arrays["mu"].values, directions)
}

/// W = J M⁻¹ Jᵀ = (L⁻¹Jᵀ)ᵀ(L⁻¹Jᵀ) with the Cholesky factor of M; q = J v_f + (φ/Δt, 0, 0).
fn from_jacobians(arrays: &Arrays, m: &[usize]) -> Lcp {
    let (mass, jn, jt) = (dense(arrays, "M"), dense(arrays, "JN"), dense(arrays, "JT"));
    let (nc, nv) = (m.len(), mass.rows());
    let (v_free, phi, dt) = (&arrays["vf"].values, &arrays["phi"].values, arrays["dt"].values[0]);
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
    polyhedral(&W, &q, &arrays["mu"].values, &directions)
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
