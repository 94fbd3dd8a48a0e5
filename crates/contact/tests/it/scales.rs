//! The Delassus diagonal of blocks of any size against the dense inverse, and what is left of it and of the velocities as scales.

use signorini_contact::certificate::Scales;
use signorini_contact::{ContactProblem, ContactSolution, FrictionBound, FrictionPolygon};
use signorini_multibody::FEW_ROWS;
use signorini_testkit::reference::random_mass;
use signorini_testkit::{Dense, Random};

/// The columns of a row: those of a body, part of them, those of several, or one alone.
fn columns(random: &mut Random, sizes: &[usize]) -> Vec<u32> {
    let ends: Vec<usize> = sizes
        .iter()
        .scan(0, |end, size| {
            *end += size;
            Some(*end)
        })
        .collect();
    let nv = *ends.last().expect("a block");
    let block = random.below(sizes.len());
    let of_block = (ends[block] - sizes[block]) as u32..ends[block] as u32;
    match random.below(5) {
        0 => of_block.collect(),
        1 => of_block.filter(|_| random.below(2) > 0).collect(),
        2 => (0..nv as u32).filter(|_| random.below(8) == 0).collect(),
        3 => {
            let first = random.below(nv.saturating_sub(5).max(1)) as u32;
            (first..(first + 6).min(nv as u32)).collect()
        }
        _ => vec![random.below(nv) as u32],
    }
}

/// Rows of which some have a normal part alone, as the limits of joints have.
fn entries<const R: usize>(random: &mut Random, columns: Vec<u32>) -> Vec<(u32, [f64; R])> {
    let alone = random.below(3) == 0;
    let entry = |random: &mut Random| std::array::from_fn(|r| if r > 0 && alone { 0.0 } else { random.normal() });
    columns.into_iter().map(|column| (column, entry(random))).collect()
}

/// `j M⁻¹ jᵀ` of each of the rows.
fn squares<const R: usize>(inverse: &Dense, (columns, entries): (&[u32], &[[f64; R]])) -> [f64; R] {
    std::array::from_fn(|r| {
        let term =
            |k: usize, l: usize| entries[k][r] * inverse[(columns[k] as usize, columns[l] as usize)] * entries[l][r];
        (0..columns.len()).flat_map(|k| (0..columns.len()).map(move |l| term(k, l))).sum()
    })
}

fn assert_near(found: &[f64], wanted: &[f64], name: &str) {
    for (found, wanted) in found.iter().zip(wanted) {
        assert!((found - wanted).abs() <= 1e-8 * wanted.max(1e-3), "{name}: {found}, dense {wanted}");
    }
}

/// Contacts, bilateral rows and friction groups over blocks of all sizes that are treated apart.
#[test]
fn the_delassus_diagonal_is_that_of_the_dense_inverse() {
    let cases: [&[usize]; 6] = [
        &[1, 1, 1, 1, 1, 1, 1],
        &[6, 6, 6],
        &[2, 4, 6, 1, 5],
        &[6, FEW_ROWS / 4, 10, 6],
        &[40, 6, 3],
        &[6, FEW_ROWS + 6, 2],
    ];
    for (case, sizes) in cases.into_iter().enumerate() {
        let mut random = Random::new(case as u64);
        let mass = random_mass(&mut random, sizes);
        let nv: usize = sizes.iter().sum();
        let inverse = Dense::from_fn(nv, nv, |i, j| mass.get(i, j)).inverse();
        let mut problem = ContactProblem::new(mass, vec![0.0; nv], 0.01).expect("positive definite");
        let polygon = FrictionPolygon::regular(4, 0.0).expect("even");
        for _ in 0..40 {
            let [of_contact, of_row, of_group] = std::array::from_fn(|_| columns(&mut random, sizes));
            problem.push_contact(entries(&mut random, of_contact), 0.0, 0.5, &polygon);
            problem.push_bilateral(entries(&mut random, of_row), 0.0);
            problem.push_friction(entries(&mut random, of_group), [0.0; 2], FrictionBound::Impulse(1.0), &polygon);
        }
        problem.check().expect("valid data");
        let (mut scratch, mut largest) = (vec![0.0; nv], 0.0_f64);
        let groups = &problem.friction_groups.jacobian;
        for i in 0..40 {
            let (contact, group) = (squares(&inverse, problem.jacobian.group(i)), squares(&inverse, groups.group(i)));
            let row = squares(&inverse, problem.bilateral_jacobian.group(i));
            assert_near(&problem.delassus_diagonal(i, &mut scratch), &contact, &format!("{sizes:?}, contact {i}"));
            assert_near(&[problem.bilateral_delassus(i, &mut scratch)], &row, &format!("{sizes:?}, row {i}"));
            assert_near(&problem.group_delassus(i, &mut scratch), &group, &format!("{sizes:?}, group {i}"));
            largest = contact.iter().chain(&group).fold(largest, |a, x| a.max(*x));
        }
        assert!(scratch.iter().all(|x| *x == 0.0), "{sizes:?}: the memory is left as it was");
        assert_near(&[problem.delassus_scale()], &[largest], &format!("{sizes:?}, scale"));
    }
}

/// The last digit of 3 N·s at 5 per kg, beside 2 m/s, whichever impulse is the largest.
#[test]
fn rounding_is_the_last_digit_of_the_largest_impulse_as_a_velocity() {
    let (scales, wanted) = (Scales::new(5.0, 2.0), f64::EPSILON * 7.5);
    let largest: [fn(&mut ContactSolution); 3] =
        [|s| s.lambda_n[1] = 3.0, |s| s.group_alpha[0] = 3.0, |s| s.bilateral[0] = -3.0];
    for set in largest {
        let mut solution = ContactSolution::default();
        (solution.lambda_n, solution.group_alpha, solution.bilateral) = (vec![0.5; 2], vec![0.25; 2], vec![-0.125]);
        set(&mut solution);
        assert!((scales.rounding(&solution) - wanted).abs() <= 1e-6 * wanted, "{:e}", scales.rounding(&solution));
        assert_eq!(Scales::new(5.0, 0.0).rounding(&solution), 0.0, "nothing moves");
    }
}
