//! Limits that others published: the walls of Ferris and Tin-Loi, least friction of arches, dominoes.

mod masonry;

use masonry::{arch, brick, proved, quick};
use signorini_contact::statics::certify_stability;
use signorini_multibody::glam::DVec3;
use signorini_statics::{Assembly, Block, SafetyQuestion, Verdict};

/// A wall of courses from below: lengths of blocks in units of a whole one, negative where there is an opening. Blocks are 0.4 m × 0.175 m,
/// the coefficient of friction is 0.65; the wall stands on a fixed block.
fn wall(courses: &[&[f64]]) -> Assembly {
    let (size, friction) = ([0.4, 0.175], 0.65);
    let length: f64 = size[0] * courses[0].iter().sum::<f64>();
    let mut ground = brick("ground", [0.0, -size[1]], [length, size[1]], friction);
    ground.is_fixed = true;
    let mut blocks: Vec<Block> = vec![ground];
    for (layer, course) in courses.iter().enumerate() {
        let mut x = 0.0;
        for part in *course {
            let width = size[0] * part.abs();
            if *part > 0.0 {
                let name = format!("block {}", blocks.len());
                blocks.push(brick(name, [x, size[1] * layer as f64], [width, size[1]], friction));
            }
            x += width;
        }
    }
    Assembly::new(&blocks, None, 1e-9).expect("a wall")
}

/// Walls under a horizontal share of their weights (M. C. Ferris and F. Tin-Loi, Int. J. Mech. Sci. 43, 2001, examples 1 to 4): the limits with
/// associated friction that are published beside those of their complementarity programs.
#[test]
fn walls_of_ferris_and_tin_loi_have_their_associated_limits() {
    let (whole, halves): (&[f64], &[f64]) = (&[1.0; 5], &[0.5, 1.0, 1.0, 1.0, 1.0, 0.5]);
    let running = |count: usize| (0..count).map(|k| if k % 2 == 0 { halves } else { whole }).collect::<Vec<_>>();
    let (four, shifted): (&[f64], &[f64]) = (&[1.0; 4], &[0.5, 1.0, 1.0, 1.0, 0.5]);
    let (window, window_shifted): (&[f64], &[f64]) = (&[0.5, 1.0, -1.0, 1.0, 0.5], &[1.0, 0.5, -1.0, 0.5, 1.0]);
    let third = [four, shifted, four, window, window_shifted, window, window_shifted, window, four, shifted, four];
    let (windows, windows_shifted): (&[f64], &[f64]) =
        (&[1.0, -1.0, 1.0, -1.0, 1.0], &[0.5, 0.5, -1.0, 0.5, 0.5, -1.0, 0.5, 0.5]);
    let fourth =
        [halves, whole, halves, windows, windows_shifted, windows, windows_shifted, windows, halves, whole, halves];
    for (courses, expected) in
        [(&running(6)[..], 0.64286), (&running(10)[..], 0.58), (&third[..], 0.40369), (&fourth[..], 0.33195)]
    {
        let found = wall(courses).safety(&quick(), &SafetyQuestion::Horizontal(DVec3::X));
        let found = proved(found.expect("a limit"));
        println!("{} courses: {:.8} to {:.8}, published {expected}", courses.len(), found.holds, found.falls);
        assert!(found.falls - found.holds <= 1e-8, "{} {}", found.holds, found.falls);
        assert!((found.holds - expected).abs() <= 5e-6, "{} {expected}", found.holds);
    }
}

/// The least friction of a semicircular arch with radial joints that is too thick for hinges (G. Cocchetti and E. Rizzi, Frattura ed Integrità
/// Strutturale 51, 2020, table 3): 0.309215, with joints that slide at the springings and 28.6362° from the crown. Of 44 voussoirs a joint is
/// within 1e-4° of that place, and weights grow with the angle whatever the thickness.
#[test]
fn thick_arches_need_the_friction_of_the_literature() {
    for (count, thickness) in [(44, 0.21), (44, 0.3), (132, 0.25)] {
        let found = arch(count, thickness, 1.0).safety(&quick(), &SafetyQuestion::Friction);
        let found = proved(found.expect("a limit"));
        println!("{count} voussoirs, t / R = {thickness}: {:.8} to {:.8}", found.falls, found.holds);
        assert!((found.holds - 0.309215).abs() <= 5e-7, "{count} {thickness}: {}", found.holds);
        assert!(found.holds - found.falls <= 1e-8, "{} {}", found.holds, found.falls);
    }
}

/// Ferris and Tin-Loi's first wall with friction as it is, which is not associated: their program of complementarity finds a collapse at 0.63982,
/// before the associated limit. The search for moving solutions ends between the two.
#[test]
fn the_first_wall_of_ferris_and_tin_loi_may_move_before_its_associated_limit() {
    let (whole, halves): (&[f64], &[f64]) = (&[1.0; 5], &[0.5, 1.0, 1.0, 1.0, 1.0, 0.5]);
    let courses: Vec<&[f64]> = (0..6).map(|k| if k % 2 == 0 { halves } else { whole }).collect();
    let settings = quick().with_search_contacts(3000).with_perturbations(1);
    let wall = wall(&courses);
    let found = wall.configuration().motion_limit(&settings, &SafetyQuestion::Horizontal(DVec3::X)).expect("a limit");
    println!("still {:.6}, moves {:.6}, static limit {:.6}", found.still, found.moves, found.statics.holds);
    assert!(found.moves < 0.6425 && found.statics.holds > 0.6428, "{} {}", found.moves, found.statics.holds);
    let (problem, proof) = found.at_moves.expect("a moving solution");
    assert_eq!(proof.verdict, Verdict::MayDoEither);
    for (name, residual) in certify_stability(&problem, &proof) {
        assert!(residual <= 1e-8, "{name} {residual:e}");
    }
}

/// Dominoes in rows, each shifted by half a domino against the one below, on a table whose edge is under the middle: row `k` has `counts[k]`.
fn dominoes(counts: &[usize]) -> Assembly {
    let mut table = brick("table", [-9.0, -1.0], [9.0 + 1e-6, 1.0], 0.0);
    table.is_fixed = true;
    let mut blocks = vec![table];
    for (row, &count) in counts.iter().enumerate() {
        for k in 0..count {
            let at = [k as f64 - 0.5 * count as f64, 0.2 * row as f64];
            blocks.push(brick(format!("domino {row} {k}"), at, [1.0, 0.2], 0.0));
        }
    }
    Assembly::new(&blocks, None, 1e-9).expect("dominoes")
}

/// Diamonds of dominoes at the edge of a table (M. Paterson and U. Zwick, Overhang, 2006): those of side 2, 3 and 4 are balanced, which is an overhang of
/// 2 dominoes with 16, and that of side 5 is not; nor are their lower halves alone from side 3 on.
#[test]
fn diamonds_of_dominoes_are_balanced_up_to_side_four() {
    for side in 2..=6 {
        let half: Vec<usize> = (1..=side).collect();
        let diamond: Vec<usize> = (1..=side).chain((1..side).rev()).collect();
        for (rows, last) in [(diamond, 4), (half, 2)] {
            let found = dominoes(&rows).stability(&quick()).expect("a verdict").stability;
            assert!(found.worst() <= 1e-9, "{rows:?}: {:?}", found.residuals);
            let expected = if side <= last { Verdict::Stays } else { Verdict::MustMove };
            assert_eq!(found.verdict(), expected, "{rows:?}");
        }
    }
}
