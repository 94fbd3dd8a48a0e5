//! Block-diagonal matrices and their factors against dense algebra.

use signorini_multibody::glam::{self, DVec3};
use signorini_multibody::{
    BlockCholesky, BlockDiagonal, BodyId, FEW_ROWS, Inertia, JacobianRows, Joint, JointKind, LANES, MassError,
    ModelBuilder, Pose, State, contact_rows_into,
};

use crate::identities::{FIXED, kinematics, mass_matrix, relative_error};
use crate::random_model::{Random, for_random_models};

#[test]
fn solving_undoes_multiplying() {
    for_random_models(21, FIXED, |model, state, random| {
        let matrix = mass_matrix(model, &kinematics(model, state)).matrix;
        let x = random.list(model.nv, 3.0);
        let mut y = vec![0.0; model.nv];
        matrix.multiply_into(&x, &mut y);
        matrix.factor().unwrap().solve_in_place(&mut y);
        assert!(relative_error(&y, &x) < 1e-10, "{}", relative_error(&y, &x));
    });
}

#[test]
fn half_solves_of_contact_rows_give_the_delassus_block() {
    for_random_models(22, FIXED, |model, state, random| {
        let at = kinematics(model, state);
        let factor = mass_matrix(model, &at).matrix.factor().unwrap();
        let mut rows = JacobianRows::new(model);
        let bodies = [0; 2].map(|_: i32| BodyId(random.below(model.bodies.len()) as u32));
        let directions = [0; 3].map(|_: i32| random.direction());
        contact_rows_into(model, &at, bodies.into(), random.vector(1.0), &directions, &mut rows);
        let mut half = rows.columns.clone();
        factor.half_solve_sparse(&rows.dofs, &mut half);
        for r in 0..3 {
            let mut column = vec![0.0; model.nv];
            rows.dofs.iter().zip(&rows.columns).for_each(|(&k, c)| column[k] = c[r]);
            factor.solve_in_place(&mut column);
            let expected = rows.multiply(&column);
            let product: [f64; 3] = std::array::from_fn(|s| half.iter().map(|y| y[r] * y[s]).sum());
            assert!(relative_error(&product, &expected) < 1e-12, "{product:?} {expected:?}");
        }
    });
}

#[test]
fn half_solves_of_the_first_rows_of_a_block_give_the_product_with_its_inverse() {
    for_random_models(24, FIXED, |model, state, random| {
        let factor = mass_matrix(model, &kinematics(model, state)).matrix.factor().unwrap();
        for (b, block) in factor.blocks().iter().enumerate() {
            let count = 1 + random.below(block.range().len());
            // Every third row is zero, as those of other branches are.
            let value = |random: &mut Random, k: usize| if k % 3 == 1 { 0.0 } else { random.vector(1.0).x };
            let rows: Vec<[f64; 2]> = (0..count).map(|k| [0; 2].map(|_: i32| value(random, k))).collect();
            let mut half = rows.clone();
            factor.half_solve_block(b, &mut half);
            let mut column = vec![0.0; block.range().len()];
            column.iter_mut().zip(&rows).for_each(|(x, row)| *x = row[0]);
            let mut by_halves = column.clone();
            factor.solve_block_in_place(b, &mut column);
            factor.half_solve_block_in_place(b, &mut by_halves);
            factor.other_half_solve_block_in_place(b, &mut by_halves);
            assert!(relative_error(&by_halves, &column) < 1e-13, "{by_halves:?} {column:?}");
            for r in 0..2 {
                let expected: f64 = rows.iter().zip(&column).map(|(row, x)| row[r] * x).sum();
                let product: f64 = half.iter().map(|y| y[0] * y[r]).sum();
                let size: f64 = rows.iter().zip(&column).map(|(row, x)| (row[r] * x).abs()).sum();
                assert!((product - expected).abs() <= 1e-10 * size, "{product} {expected}");
            }
            let first = count / 2;
            let mut sparse: Vec<f64> = (0..count).map(|k| if k < first { 0.0 } else { rows[k][1] }).collect();
            let mut solved = [sparse.clone(), vec![0.0; block.range().len() - count]].concat();
            factor.solve_block_in_place(b, &mut solved);
            let expected: f64 = sparse.iter().zip(&solved).map(|(x, y)| x * y).sum();
            let size: f64 = sparse.iter().zip(&solved).map(|(x, y)| (x * y).abs()).sum();
            let square = factor.inverse_square(b, first, &mut sparse);
            assert!((square - expected).abs() <= 1e-10 * size, "{square} {expected}");
            if block.range().len() > FEW_ROWS {
                continue;
            }
            let places: Vec<usize> = (0..count).filter(|k| k % 3 != 1).collect();
            let entries: Vec<[f64; 2]> = places.iter().map(|&k| rows[k]).collect();
            let [square, _] = factor.inverse_squares(b, &places, &entries);
            let expected: f64 = rows.iter().zip(&column).map(|(row, x)| row[0] * x).sum();
            let size: f64 = rows.iter().zip(&column).map(|(row, x)| (row[0] * x).abs()).sum();
            assert!((square - expected).abs() <= 1e-10 * size, "{square} {expected}");
        }
    });
}

#[test]
fn half_solves_side_by_side_have_the_bits_of_each_by_itself() {
    for_random_models(24, FIXED, |model, state, random| {
        let factor = mass_matrix(model, &kinematics(model, state)).matrix.factor().unwrap();
        for (b, block) in factor.blocks().iter().enumerate() {
            for count in [1_usize, 8, 19, 50] {
                let (width, stride) = (count.next_multiple_of(LANES), count.next_multiple_of(LANES) + 3);
                let columns: Vec<Vec<f64>> = (0..count).map(|_| random.list(block.size, 1.0)).collect();
                let mut together = vec![0.0; block.size * stride];
                for (c, column) in columns.iter().enumerate() {
                    (0..block.size).for_each(|k| together[k * stride + c] = column[k]);
                }
                factor.half_solve_rows(b, &mut together, stride, width);
                for (c, column) in columns.iter().enumerate() {
                    let mut alone: Vec<[f64; 1]> = column.iter().map(|x| [*x]).collect();
                    factor.half_solve_block(b, &mut alone);
                    (0..block.size).for_each(|k| assert_eq!(together[k * stride + c], alone[k][0], "{b} {c} {k}"));
                }
            }
        }
    });
}

#[test]
fn dense_form_round_trips_with_the_trees_as_blocks() {
    for_random_models(23, FIXED, |model, state, _| {
        let matrix = mass_matrix(model, &kinematics(model, state)).matrix;
        let dense = matrix.to_dense();
        let again = BlockDiagonal::from_dense(model.nv, &dense).unwrap();
        assert_eq!(again.to_dense(), dense);
        assert!(again.blocks().len() >= matrix.blocks().len());
        for row in 0..model.nv {
            for column in 0..model.nv {
                assert_eq!(matrix.get(row, column), dense[row * model.nv + column]);
            }
        }
    });
}

#[test]
fn every_tree_is_one_block() {
    let mut builder = ModelBuilder::new("boxes");
    let mut random = Random(5);
    for i in 0..3 {
        let body = builder.add_body(format!("box{i}"), BodyId::WORLD, Pose::IDENTITY, random.inertia()).unwrap();
        builder.add_joint(body, Joint::new(format!("free{i}"), JointKind::Free)).unwrap();
        if i == 1 {
            let arm = builder.add_body("arm", body, random.pose(), random.inertia()).unwrap();
            builder.add_joint(arm, Joint::new("ball", JointKind::Ball)).unwrap();
        }
    }
    let model = builder.build().unwrap();
    let matrix = BlockDiagonal::new(&model);
    let blocks: Vec<_> = matrix.blocks().iter().map(|b| (b.start, b.size, b.offset)).collect();
    assert_eq!(blocks, [(0, 6, 0), (6, 9, 36), (15, 6, 117)]);
    assert_eq!(matrix.block_of(14), 1);
    assert_eq!(matrix.data().len(), 36 + 81 + 36);
}

/// Branches do not fill in: two legs of one base have no coupling in the factor.
#[test]
fn factor_keeps_branches_apart() {
    let mut builder = ModelBuilder::new("two legs");
    let mut random = Random(6);
    let base = builder.add_body("base", BodyId::WORLD, Pose::IDENTITY, random.inertia()).unwrap();
    builder.add_joint(base, Joint::new("root", JointKind::Free)).unwrap();
    for leg in ["left", "right"] {
        let body = builder.add_body(leg, base, random.pose(), random.inertia()).unwrap();
        builder.add_joint(body, Joint::new(leg, JointKind::Ball)).unwrap();
    }
    let model = builder.build().unwrap();
    let factor = mass_matrix(&model, &kinematics(&model, &State::new(&model))).matrix.factor().unwrap();
    let mut rows = [[0.0], [0.0], [0.0], [0.0], [0.0], [0.0], [1.0], [2.0], [3.0], [0.0], [0.0], [0.0]];
    factor.half_solve_sparse(&(0..12).collect::<Vec<_>>(), &mut rows);
    assert_eq!(rows[9..], [[0.0]; 3]);
    let mut rows = [[0.0], [0.0], [0.0], [0.0], [0.0], [0.0], [0.0], [0.0], [0.0], [1.0], [2.0], [3.0]];
    factor.half_solve_sparse(&(0..12).collect::<Vec<_>>(), &mut rows);
    assert_eq!(rows[6..9], [[0.0]; 3]);
}

#[test]
fn a_direction_without_inertia_is_named() {
    let dense = [2.0, 1.0, 0.0, 1.0, 0.5, 0.0, 0.0, 0.0, 3.0];
    let matrix = BlockDiagonal::from_dense(3, &dense).unwrap();
    let singular = matrix.factor().unwrap_err();
    assert!(matches!(singular, MassError::NotPositiveDefinite { dof: 0, pivot } if pivot.abs() < 1e-15), "{singular}");
    let not_a_number = BlockDiagonal::from_dense(1, &[f64::NAN]).unwrap_err();
    assert!(matches!(not_a_number, MassError::NotSymmetric { row: 0, column: 0, .. }), "{not_a_number}");
    let skew = BlockDiagonal::from_dense(2, &[1.0, 0.1, 0.2, 1.0]).unwrap_err();
    assert_eq!(skew, MassError::NotSymmetric { row: 0, column: 1, upper: 0.1, lower: 0.2 });
    let short = BlockDiagonal::from_dense(2, &[1.0]).unwrap_err();
    assert_eq!(short, MassError::WrongLength { nv: 2, expected: 4, found: 1 });
}

/// A point mass that slides across the axis of a hinge: where it meets the axis, the hinge moves nothing.
#[test]
fn a_singular_configuration_is_an_error_and_not_a_number() {
    let mut builder = ModelBuilder::new("point");
    let point = Inertia { mass: 1.0, ..Inertia::ZERO };
    let body = builder.add_body("point", BodyId::WORLD, Pose::IDENTITY, point).unwrap();
    let (x, y) = (DVec3::X, DVec3::Y);
    let mut hinge = Joint::new("hinge", JointKind::Hinge { axis: x });
    hinge.anchor = x * 0.5;
    builder.add_joint(body, hinge).unwrap();
    builder.add_joint(body, Joint::new("slide", JointKind::Slide { axis: y })).unwrap();
    let model = builder.build().unwrap();
    let mut state = State::new(&model);
    let matrix = mass_matrix(&model, &kinematics(&model, &state)).matrix;
    let mut factor = BlockCholesky::new(&matrix);
    assert_eq!(factor.refactor(&matrix), Err(MassError::NotPositiveDefinite { dof: 0, pivot: 0.0 }));
    state.q[1] = 0.5;
    let matrix = mass_matrix(&model, &kinematics(&model, &state)).matrix;
    factor.refactor(&matrix).unwrap();
    let mut x = [1.0, 3.0];
    factor.solve_in_place(&mut x);
    assert_eq!(x, [4.0, 3.0]);
}

/// A free body that turns about its origin (`offset` zero) or about a point beside it; the block of the former is diagonal.
fn free_body_mass(offset: f64, turn: f64) -> BlockDiagonal {
    let mut builder = ModelBuilder::new("brick");
    let rotational = glam::DMat3::from_diagonal(DVec3::new(0.2, 0.3, 0.4));
    let inertia = Inertia { mass: 3.0, center_of_mass: DVec3::new(offset, 0.0, 0.0), rotational };
    let body = builder.add_body("brick", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    builder.add_joint(body, Joint::new("free", JointKind::Free)).unwrap();
    let model = builder.build().unwrap();
    let mut state = State::new(&model);
    (state.q[3], state.q[6]) = ((0.5 * turn).cos(), (0.5 * turn).sin());
    mass_matrix(&model, &kinematics(&model, &state)).matrix
}

#[test]
fn a_factor_that_is_used_again_is_the_one_of_a_fresh_factorisation() {
    let (diagonal, full, turned) = (free_body_mass(0.0, 0.3), free_body_mass(0.1, 0.3), free_body_mass(0.1, 0.4));
    let mut singular = full.clone();
    singular.add_to_diagonal(4, -full.get(4, 4));
    let x: Vec<f64> = (0..6).map(|k| 1.0 + f64::from(k)).collect();
    let mut factor = BlockCholesky::new(&full);
    for matrix in [&diagonal, &diagonal, &full, &full, &turned, &singular, &turned, &singular, &diagonal, &full] {
        let fresh = matrix.factor();
        assert_eq!(factor.refactor(matrix), fresh.as_ref().map(|_| ()).map_err(Clone::clone));
        let Ok(fresh) = fresh else { continue };
        let (mut found, mut expected, mut back) = (x.clone(), x.clone(), vec![0.0; 6]);
        factor.solve_in_place(&mut found);
        fresh.solve_in_place(&mut expected);
        assert_eq!(found, expected);
        matrix.multiply_into(&found, &mut back);
        assert!(relative_error(&back, &x) < 1e-14, "{back:?}");
    }
}
