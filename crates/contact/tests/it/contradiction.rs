//! How far multipliers are from the proof that rows contradict each other, against the speeds that they exclude.

use signorini_contact::GapContradiction;
use signorini_testkit::Random;

use crate::written::{Kind, NV, Rows, dot, problem};

/// The rows of a random problem with the last ones made such that the multipliers leave a small remainder.
#[test]
fn the_residual_is_the_velocity_scale_by_the_speed_that_is_excluded() {
    let (mut proofs, mut none) = (0, 0);
    for seed in 0..300 {
        let mut random = Random::new(seed);
        let problem = problem(&mut random, [Kind::Plain, Kind::Bystander][seed as usize % 2]);
        let rows = Rows::of(&problem);
        let proof = GapContradiction {
            normal: (0..3).map(|_| random.choice(&[1.0, 1.7]) * random.choice(&[0.0, 1.0, 1.3])).collect(),
            bilateral: (0..2).map(|_| random.between(-2.0, 2.0)).collect(),
        };
        let multipliers: Vec<f64> = proof.normal.iter().chain(&proof.bilateral).copied().collect();
        let all: Vec<[f64; NV]> = rows.normals.iter().chain(&rows.bilateral).copied().collect();
        let rates: Vec<f64> =
            (0..3).map(|i| rows.opening(i, &[0.0; NV])).chain((0..2).map(|k| rows.drift(k, &[0.0; NV]))).collect();
        let shortfall = -multipliers.iter().zip(&rates).map(|(y, rate)| y * rate).sum::<f64>();
        let found = proof.residual(&problem);
        if shortfall <= 0.0 {
            assert_eq!(found, f64::INFINITY, "seed {seed}");
            none += 1;
            continue;
        }
        let left = |k: usize| {
            let terms: Vec<f64> = all.iter().zip(&multipliers).map(|(row, y)| y * row[k]).collect();
            let sizes: f64 = terms.iter().map(|x| x.abs()).sum();
            let taking_part = all.iter().zip(&multipliers).filter(|(row, _)| row[k] != 0.0);
            let sum: f64 = taking_part.map(|(_, y)| y.abs()).sum();
            if sizes > 0.0 { terms.iter().sum::<f64>().abs() / sizes * sum } else { 0.0 }
        };
        let speed = shortfall / (0..NV).map(left).sum::<f64>();
        let wanted = problem.velocity_scale() / speed;
        assert!((found - wanted).abs() <= 1e-9 * wanted, "seed {seed}: {found}, {wanted}");
        // No velocity whose terms all are below that speed satisfies the rows.
        for _ in 0..50 {
            let v: [f64; NV] = std::array::from_fn(|k| {
                let most = all.iter().zip(&multipliers).filter(|(_, y)| **y != 0.0).map(|(row, _)| row[k].abs());
                random.choice(&[-1.0, 1.0]) * 0.999 * speed / most.fold(f64::MIN_POSITIVE, f64::max)
            });
            let values: Vec<f64> = all.iter().zip(&rates).map(|(row, rate)| dot(row, &v) + rate).collect();
            assert!(values.iter().zip(&multipliers).map(|(u, y)| u * y).sum::<f64>() < 0.0, "seed {seed}");
        }
        let taking_part: Vec<usize> = (0..3).filter(|&i| proof.normal[i] > 0.0).collect();
        assert_eq!(proof.contacts(), taking_part);
        proofs += 1;
    }
    assert!(proofs >= 50 && none >= 50, "{proofs} {none}");
}

#[test]
fn multipliers_of_wrong_sizes_or_signs_prove_nothing() {
    let mut random = Random::new(2);
    let problem = problem(&mut random, Kind::Plain);
    let towards = |violation: &f64| -violation.signum();
    let proof =
        GapContradiction { normal: vec![0.0; 3], bilateral: problem.bilateral_violation.iter().map(towards).collect() };
    assert!(proof.residual(&problem).is_finite());
    let changes: [fn(&mut GapContradiction); 6] = [
        |p| p.normal.truncate(2),
        |p| p.bilateral.push(0.0),
        |p| p.normal[1] = -1e-12,
        |p| p.normal[1] = f64::NAN,
        |p| p.normal[1] = f64::INFINITY,
        |p| p.bilateral[1] = f64::NAN,
    ];
    for (k, change) in changes.into_iter().enumerate() {
        let mut other = proof.clone();
        change(&mut other);
        assert_eq!(other.residual(&problem), f64::INFINITY, "change {k}");
    }
}
