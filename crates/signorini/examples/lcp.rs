//! A linear complementarity problem: `cargo run --release -p signorini --example lcp`.
//!
//! The one here is a quadratic program: the point of a polygon that is nearest to a target.
#![allow(non_snake_case)] // matrices keep the letters of the formulas

use signorini::lcp::{Enumeration, Lcp, Lemke, Matrix, Method, MethodKind, Status};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Minimise ½ ‖x − t‖² over G x ≤ h, x ≥ 0. With multipliers y: 0 ≤ x ⟂ x + Gᵀy − t ≥ 0 and 0 ≤ y ⟂ h − G x ≥ 0.
    let (target, G, h) = ([2.0, 1.5], [[1.0, 1.0], [1.0, -1.0]], [2.0, 1.0]);
    let A = Matrix::new(
        4,
        4,
        vec![
            1.0, 0.0, G[0][0], G[1][0], 0.0, 1.0, G[0][1], G[1][1], -G[0][0], -G[0][1], 0.0, 0.0, -G[1][0], -G[1][1],
            0.0, 0.0,
        ],
    )?;
    let problem = Lcp::new(A, vec![-target[0], -target[1], h[0], h[1]])?;

    let solution = Lemke::default().solve(&problem, None);
    let [x, y] = [solution.z[0], solution.z[1]];
    println!("{:?}: x = ({x:.12}, {y:.12}), residual {:.1e}", solution.status, solution.residual.value);
    // Only x + y ≤ 2 is active: the target's projection on that line.
    assert!((x - 1.25).abs() < 1e-12 && (y - 0.75).abs() < 1e-12);

    // Every other method finds the same point or says why it cannot: relaxation needs a diagonal, which multipliers have not.
    for kind in MethodKind::all() {
        let other = kind.build()?.solve(&problem, None);
        println!("{:28} {:?}", kind.to_string(), other.status);
        assert!(other.status.is_solved() || matches!(other.status, Status::Refused(_)));
        assert!(!other.status.is_solved() || other.z.iter().zip(&solution.z).all(|(a, b)| (a - b).abs() < 1e-8));
    }
    // All bases were tried: there is no other solution.
    let all = Enumeration::default().solution_set(&problem)?;
    assert!(all.is_finite() && all.points.len() == 1);
    Ok(())
}
