//! The shared set of problems with known answers.

use signorini_lcp::{Lcp, Matrix};

/// A problem with what is known about it.
pub struct Case {
    pub name: &'static str,
    pub problem: Lcp,
    /// Known solutions.
    pub solutions: Vec<Vec<f64>>,
    /// Whether `solutions` are all there are.
    pub complete: bool,
    /// Points that look close but solve nothing.
    pub non_solutions: Vec<Vec<f64>>,
    /// Methods that give up here, although there is a solution: a hypothesis of theirs fails.
    pub beyond: &'static [&'static str],
}

fn case(name: &'static str, rows: &[&[f64]], b: &[f64]) -> Case {
    let A = Matrix::new(rows.len(), b.len(), rows.concat()).unwrap();
    let problem = Lcp::new(A, b.to_vec()).unwrap();
    Case { name, problem, solutions: Vec::new(), complete: false, non_solutions: Vec::new(), beyond: &[] }
}

impl Case {
    fn only(mut self, solutions: &[&[f64]]) -> Self {
        self.complete = true;
        self.solutions = solutions.iter().map(|z| z.to_vec()).collect();
        self
    }

    fn among_others(mut self, solutions: &[&[f64]]) -> Self {
        self.solutions = solutions.iter().map(|z| z.to_vec()).collect();
        self
    }

    fn not(mut self, points: &[&[f64]]) -> Self {
        self.non_solutions = points.iter().map(|z| z.to_vec()).collect();
        self
    }

    fn beyond(mut self, methods: &'static [&'static str]) -> Self {
        self.beyond = methods;
        self
    }
}

pub fn all() -> Vec<Case> {
    [regular(), degenerate(), contacts(), unsolvable()].into_iter().flatten().collect()
}

/// P-matrices (one solution for every b) and other problems with isolated solutions.
fn regular() -> Vec<Case> {
    vec![
        case("nothing", &[], &[]).only(&[&[]]),
        case("b positive", &[&[-1.0, 2.0], &[0.0, 3.0]], &[1.0, 2.0]).among_others(&[&[0.0, 0.0]]).not(&[&[1.0, 1.0]]),
        // 2z₁ + z₂ = 5, z₁ + 2z₂ = 6
        case("symmetric positive definite", &[&[2.0, 1.0], &[1.0, 2.0]], &[-5.0, -6.0])
            .only(&[&[4.0 / 3.0, 7.0 / 3.0]])
            .not(&[&[2.5, 0.0], &[0.0, 3.0], &[0.0, 0.0]]),
        // Murty (1988), §2.2.9 and chapter 6: exponential for some pivot rules; z = e_n since row n reads z_n = 1.
        case(
            "Murty upper triangular",
            &[&[1.0, 2.0, 2.0, 2.0], &[0.0, 1.0, 2.0, 2.0], &[0.0, 0.0, 1.0, 2.0], &[0.0, 0.0, 0.0, 1.0]],
            &[-1.0; 4],
        )
        .only(&[&[0.0, 0.0, 0.0, 1.0]])
        .not(&[&[1.0, 0.0, 0.0, 0.0]]),
        // The optimality conditions of: minimise z₁ subject to z₁ ≥ 1; both pairs active.
        case("skew-symmetric", &[&[0.0, -1.0], &[1.0, 0.0]], &[1.0, -1.0])
            .only(&[&[1.0, 1.0]])
            .not(&[&[1.0, 0.0]])
            .beyond(&["psor"]),
        // w = 1 − z: zero and one.
        case("two solutions", &[&[-1.0]], &[1.0]).only(&[&[0.0], &[1.0]]).not(&[&[0.5], &[2.0]]),
        // Rows 1 and 3 with z₂ = z₄ = 0: 3z₁ = 2, 3z₃ = 1; w₂ = −2/3 + 1/3 + 1 = 2/3, w₄ = 4/3.
        case(
            "strictly diagonally dominant",
            &[&[3.0, 1.0, 0.0, -1.0], &[-1.0, 2.0, 1.0, 1.0], &[0.0, 1.0, 3.0, -1.0], &[0.0, 0.0, 1.0, 2.0]],
            &[-2.0, 1.0, -1.0, 1.0],
        )
        .only(&[&[2.0 / 3.0, 0.0, 1.0 / 3.0, 0.0]]),
        // A bimatrix game (Cottle, Pang, Stone 2009, §1.2): A ≥ 0, so the first entering column only grows and any
        // positive covering vector ends on a ray. The mixed one: 10z₃ + 20z₄ = 1, 30z₃ + 15z₄ = 1.
        case(
            "bimatrix game",
            &[&[0.0, 0.0, 10.0, 20.0], &[0.0, 0.0, 30.0, 15.0], &[10.0, 20.0, 0.0, 0.0], &[30.0, 15.0, 0.0, 0.0]],
            &[-1.0; 4],
        )
        .only(&[
            &[0.1, 0.0, 0.1, 0.0],
            &[0.0, 1.0 / 15.0, 0.0, 1.0 / 15.0],
            &[1.0 / 90.0, 2.0 / 45.0, 1.0 / 90.0, 2.0 / 45.0],
        ])
        .beyond(&["lemke", "principal-pivoting", "psor"]),
    ]
}

/// Ties, zero right-hand sides and singular matrices.
fn degenerate() -> Vec<Case> {
    vec![
        // z₁ + z₂ = 1
        case("rank one", &[&[1.0, 1.0], &[1.0, 1.0]], &[-1.0, -1.0])
            .among_others(&[&[1.0, 0.0], &[0.0, 1.0], &[0.25, 0.75]])
            .not(&[&[1.0, 1.0], &[0.0, 0.0], &[2.0, -1.0]]),
        case("b zero", &[&[1.0, -1.0], &[-1.0, 2.0]], &[0.0, 0.0]).only(&[&[0.0, 0.0]]).not(&[&[1.0, 0.0]]),
        case("A and b zero", &[&[0.0, 0.0], &[0.0, 0.0]], &[0.0, 0.0]).among_others(&[&[0.0, 0.0]]),
        case("A zero", &[&[0.0, 0.0], &[0.0, 0.0]], &[0.0, 3.0]).among_others(&[&[0.0, 0.0], &[7.0, 0.0]]),
        // Three equal rows of which the first must hold: z₁ + z₂ + z₃ = 1
        case("rank one, three ties", &[&[1.0; 3], &[1.0; 3], &[1.0; 3]], &[-1.0; 3])
            .among_others(&[&[1.0, 0.0, 0.0], &[0.25, 0.25, 0.5]]),
        // Linear program in disguise with a degenerate vertex: z₁ = z₂ = 1 and redundant z₁ + z₂ ≥ 2.
        case(
            "redundant inequality",
            &[
                &[1.0, 0.0, -1.0, 0.0, -1.0],
                &[0.0, 1.0, 0.0, -1.0, -1.0],
                &[1.0, 0.0, 0.0, 0.0, 0.0],
                &[0.0, 1.0, 0.0, 0.0, 0.0],
                &[1.0, 1.0, 0.0, 0.0, 0.0],
            ],
            &[0.0, 0.0, -1.0, -1.0, -2.0],
        )
        .among_others(&[&[1.0, 1.0, 1.0, 1.0, 0.0], &[1.0, 1.0, 0.0, 0.0, 1.0]])
        .beyond(&["psor"]),
        // Rows 1–2: 11z = z₄ − 50 → z = 3 for z₄ = 83; row 4: z₁ + z₂ = 6; w₃ = 60 + 23 − 83 = 0, degenerate.
        case(
            "quadratic program, degenerate",
            &[&[11.0, 0.0, 10.0, -1.0], &[0.0, 11.0, 10.0, -1.0], &[10.0, 10.0, 21.0, -1.0], &[1.0, 1.0, 1.0, 0.0]],
            &[50.0, 50.0, 23.0, -6.0],
        )
        .among_others(&[&[3.0, 3.0, 0.0, 83.0]])
        .beyond(&["psor"]),
    ]
}

/// One point contact in the plane, unit mass: z = (λ_N, α₊, α₋, β); W = I, μ = 1/2, approach speed 1.
fn contact(name: &'static str, tangential: f64) -> Case {
    case(
        name,
        &[&[1.0, 0.0, 0.0, 0.0], &[0.0, 1.0, -1.0, 1.0], &[0.0, -1.0, 1.0, 1.0], &[0.5, -1.0, -1.0, 0.0]],
        &[-1.0, tangential, -tangential, 0.0],
    )
    .beyond(&["psor"])
}

fn contacts() -> Vec<Case> {
    vec![
        // |λ_T| = 1/4 < μ λ_N = 1/2 stops the sliding.
        contact("sticking", 0.25).among_others(&[&[1.0, 0.0, 0.25, 0.0]]).not(&[&[1.0, 0.25, 0.0, 0.0]]),
        // λ_T = −μ λ_N leaves the speed 1 − 1/2 = β.
        contact("sliding", 1.0).only(&[&[1.0, 0.0, 0.5, 0.5]]).not(&[&[1.0, 0.0, 1.0, 0.0]]),
        contact("impact at rest", 0.0).among_others(&[&[1.0, 0.0, 0.0, 0.0], &[1.0, 0.25, 0.25, 0.0]]),
        // Two contacts in one point, frictionless: only the sum of the impulses is determined, 2(z₁ + z₂) = 3.
        case("contact given twice", &[&[2.0, 2.0], &[2.0, 2.0]], &[-3.0, -3.0])
            .among_others(&[&[1.5, 0.0], &[0.75, 0.75]])
            .not(&[&[1.5, 1.5]]),
    ]
}

/// Problems without a solution.
fn unsolvable() -> Vec<Case> {
    vec![
        case("zero matrix, negative b", &[&[0.0]], &[-1.0]).only(&[]).not(&[&[0.0], &[1.0], &[1e9]]),
        case("negative matrix, negative b", &[&[-1.0]], &[-1.0]).only(&[]).not(&[&[1.0]]),
        // A plate pushed from both sides by approaching walls: z₁ − z₂ ≥ 1 and z₂ − z₁ ≥ 1.
        case("squeezed", &[&[1.0, -1.0], &[-1.0, 1.0]], &[-1.0, -1.0]).only(&[]).not(&[&[1.0, 1.0], &[1.0, 0.0]]),
        // Feasible, e.g. z = (2, 1), but w₁ = z₂ + 1 > 0 forces z₁ = 0, and then w₂ = −z₂ − 1 < 0.
        case("feasible, no solution", &[&[0.0, 1.0], &[1.0, -1.0]], &[1.0, -1.0])
            .only(&[])
            .not(&[&[1.0, 0.0], &[2.0, 1.0]]),
    ]
}
