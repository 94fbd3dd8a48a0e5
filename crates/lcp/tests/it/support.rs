//! Random numbers, problem families and checks that do not use the code under test.

use signorini_lcp::{Farkas, Lcp, Matrix, Ray, Solution, Status};

use crate::contact_data::polyhedral;

/// SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    /// Uniform in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Uniform in 0..n.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// −1, 0 or 1.
    pub fn sign(&mut self) -> f64 {
        self.below(3) as f64 - 1.0
    }

    pub fn vector(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.signed()).collect()
    }

    pub fn matrix(&mut self, rows: usize, cols: usize) -> Matrix {
        Matrix::from_fn(rows, cols, |_, _| self.signed())
    }
}

/// `G Gᵀ`: positive semidefinite of the rank of `G`.
pub fn gram(G: &Matrix) -> Matrix {
    Matrix::from_fn(G.rows(), G.rows(), |i, j| G.row(i).iter().zip(G.row(j)).map(|(a, b)| a * b).sum())
}

/// A positive semidefinite matrix that is not symmetric: `G Gᵀ` and a skew-symmetric part.
pub fn monotone(random: &mut Random, n: usize, rank: usize, integer: bool) -> Matrix {
    let mut entry = || if integer { random.sign() } else { random.signed() };
    let G = Matrix::from_fn(n, rank, |_, _| entry());
    let K = Matrix::from_fn(n, n, |_, _| entry());
    let symmetric = gram(&G);
    Matrix::from_fn(n, n, |i, j| symmetric[(i, j)] + K[(i, j)] - K[(j, i)])
}

/// A P-matrix that is neither symmetric nor diagonally dominant: `D + G` with `D > 0` diagonal, `G` semidefinite.
pub fn p_matrix(random: &mut Random, n: usize) -> Matrix {
    let mut A = monotone(random, n, n, false);
    for i in 0..n {
        A[(i, i)] += 0.05;
    }
    A
}

/// The optimality conditions of: minimise `½ xᵀHx + cᵀx` subject to `x ≥ 0`, `G x ≥ h`; `H` of rank `rank`.
///
/// With `feasible` the constraints hold at a point `x ≥ 0`, half of them with equality.
pub fn quadratic_program(random: &mut Random, n: usize, rows: usize, rank: usize, feasible: bool) -> Lcp {
    let H = gram(&random.matrix(n, rank));
    let G = random.matrix(rows, n);
    let c: Vec<f64> = (0..n).map(|_| random.signed()).collect();
    let point: Vec<f64> = (0..n).map(|_| random.signed().max(0.0)).collect();
    let h: Vec<f64> = (0..rows)
        .map(|r| if feasible { inner(G.row(r), &point) - random.signed().max(0.0) } else { random.signed() })
        .collect();
    let A = Matrix::from_fn(n + rows, n + rows, |i, j| match (i < n, j < n) {
        (true, true) => H[(i, j)],
        (true, false) => -G[(j - n, i)],
        (false, true) => G[(i - n, j)],
        (false, false) => 0.0,
    });
    Lcp::new(A, c.into_iter().chain(h.into_iter().map(|h| -h)).collect()).unwrap()
}

/// `x·y` in plain arithmetic.
pub fn inner(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

/// Contacts of a body with `nv` coordinates and unit mass, gaps zero, hence solvable; `duplicates` of the contacts
/// are copies of the first.
pub fn touching_contacts(random: &mut Random, nc: usize, m: usize, nv: usize, duplicates: usize) -> Lcp {
    let per_contact = if m == 2 { 2 } else { 3 };
    let mut J = random.matrix(per_contact * nc, nv);
    for c in nc - duplicates..nc {
        for r in 0..per_contact {
            for j in 0..nv {
                J[(c * per_contact + r, j)] = J[(r, j)];
            }
        }
    }
    let v_free = random.vector(nv);
    let q: Vec<f64> = (0..J.rows()).map(|r| inner(J.row(r), &v_free)).collect();
    let mu: Vec<f64> = (0..nc).map(|_| [0.0, 0.3, 1.0][random.below(3)]).collect();
    let polygon: Vec<Vec<f64>> = match m {
        2 => vec![vec![1.0], vec![-1.0]],
        _ => (0..m).map(|k| std::f64::consts::TAU * k as f64 / m as f64).map(|a| vec![a.cos(), a.sin()]).collect(),
    };
    polyhedral(&gram(&J), &q, &mu, &vec![polygon; nc])
}

/// Whether `z` solves the problem to `tolerance`, entry by entry in the unit of `b`.
pub fn solves(problem: &Lcp, z: &[f64], tolerance: f64) -> bool {
    let (s, t) = (problem.scaling().z(), problem.scaling().w());
    let size = problem.b().iter().fold(0.0f64, |max, b| max.max(b.abs()));
    (0..problem.len()).all(|i| {
        let w = t[i] * (inner(problem.A().row(i), z) + problem.b()[i]);
        let z = s[i] * z[i];
        let allowed = tolerance * size;
        z >= -allowed && w >= -allowed && (z <= allowed || w <= allowed)
    })
}

/// Fails when the solution claims what does not hold: a status is checked with plain arithmetic.
pub fn assert_honest(problem: &Lcp, solution: &Solution, tolerance: f64, name: &str) {
    let solved = solves(problem, &solution.z, 1.01 * tolerance);
    match &solution.status {
        Status::Solved => assert!(solved, "{name}: claims to be solved, z = {:?}", solution.z),
        Status::Infeasible(farkas) => {
            assert_proof(problem, farkas, name);
        }
        Status::Ray(ray) => {
            assert!(ray.z.iter().chain(&ray.w).all(|&x| x >= 0.0) && ray.z0 >= 0.0, "{name}: signs of the ray");
            assert!((0..problem.len()).all(|i| ray.z[i] == 0.0 || ray.w[i] == 0.0), "{name}: ray not complementary");
            assert!(ray.z0 > 0.0 || !ray.support.is_empty(), "{name}: the ray is zero");
            assert_ray(problem, ray, name);
        }
        _ => {}
    }
    assert!(!solved || solution.status.is_solved(), "{name}: {:?}, but z solves the problem", solution.status);
}

/// Fails unless `w − A z` is `d z0` with a covering vector `d > 0`, and zero without a covering variable.
fn assert_ray(problem: &Lcp, ray: &Ray, name: &str) {
    let (s, t) = (problem.scaling().z(), problem.scaling().w());
    let size = ray.z.iter().zip(s).map(|(z, s)| z * s).fold(0.0f64, f64::max);
    assert!(size == 0.0 || (size - 1.0).abs() < 1e-12, "{name}: the largest entry of the ray is {size}");
    for i in 0..problem.len() {
        let row = problem.A().row(i);
        let terms: f64 = row.iter().zip(&ray.z).map(|(a, z)| (a * z).abs()).sum::<f64>() + ray.w[i];
        let covered = ray.w[i] - inner(row, &ray.z);
        let rounding = 1e-8 * terms.max(1.0 / t[i]);
        let holds = if ray.z0 == 0.0 { covered.abs() <= rounding } else { covered > -rounding };
        assert!(holds, "{name}: row {i} of the ray is off by {covered:e}");
    }
    let support: Vec<usize> = (0..problem.len()).filter(|&i| ray.z[i] > 0.0).collect();
    assert_eq!(support, ray.support, "{name}");
}

/// Fails unless y ≥ 0, Aᵀy ≤ 0 and bᵀy < 0.
pub fn assert_proof(problem: &Lcp, farkas: &Farkas, name: &str) {
    let n = problem.len();
    let (s, t) = (problem.scaling().z(), problem.scaling().w());
    // In one unit, as A is: the row of y times the column of z.
    let y: Vec<f64> = (0..n).map(|i| farkas.y[i] / t[i]).collect();
    let sum: f64 = y.iter().sum();
    assert!(y.iter().all(|&y| y >= 0.0) && sum > 0.0, "{name}: multipliers {y:?}");
    let entry = |i: usize, j: usize| t[i] * problem.A()[(i, j)] / s[j];
    let largest = (0..n * n).fold(0.0f64, |max, k| max.max(entry(k / n, k % n).abs()));
    for j in 0..n {
        let column: f64 = (0..n).map(|i| entry(i, j) * y[i]).sum();
        assert!(column <= 1e-9 * largest * sum, "{name}: column {j} of the proof, {column:e}");
    }
    assert!(inner(problem.b(), &farkas.y) < 0.0, "{name}: right-hand side of the proof");
}
