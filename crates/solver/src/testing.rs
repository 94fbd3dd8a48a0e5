//! Problems of one island, for the tests of parts that work on islands.

use signorini_contact::projection::Cones;
use signorini_contact::{ContactProblem, FrictionPolygon};
use signorini_multibody::BlockDiagonal;
use signorini_sparse::Random;

use crate::interior::Ground;
use crate::islands::Islands;
use crate::iterate::Iterate;
use crate::proximal::ProximalMap;
use crate::settings::SolverSettings;
use crate::task::{Look, Task};

/// Calls `run` on the ground of an interior start without impulses.
pub(crate) fn on_ground_of<T>(problem: &ContactProblem, run: impl FnOnce(&mut Ground) -> T) -> T {
    let (mut cones, mut islands) = (Cones::default(), Islands::default());
    cones.prepare(problem);
    islands.find(problem);
    islands.assemble(problem, |_| true);
    let [island] = islands.all() else { panic!("{} islands", islands.all().len()) };
    let (settings, mut map, mut iterate) = (SolverSettings::default(), ProximalMap::default(), Iterate::default());
    let task = Task {
        problem,
        cones: &cones,
        island,
        settings: &settings,
        look: Look::First,
        is_warm: false,
        is_nearly_solved: false,
    };
    map.begin(&task);
    iterate.clear(problem, island);
    run(&mut Ground { map: &mut map, iterate: &mut iterate, task: &task })
}

const BOXES: usize = 40;

/// Boxes of unit mass on each other, each on the four corners of the face below it, that fall, slide and turn.
pub(crate) fn pile(seed: u32) -> Box<ContactProblem> {
    let mut random = Random::new(seed);
    let n = 6 * BOXES;
    let entry = |k: usize| if k / n != k % n { 0.0 } else { [1.0, 1.0 / 6.0][k % 6 / 3] };
    let mass = BlockDiagonal::from_dense(n, &(0..n * n).map(entry).collect::<Vec<_>>()).expect("definite");
    let free_velocity = (0..n).map(|k| random.between(-0.1, 0.1) - 0.1 * f64::from(u8::from(k % 6 == 2))).collect();
    let mut problem = Box::new(ContactProblem::new(mass, free_velocity, 1e-2).expect("numbers"));
    let polygon = FrictionPolygon::regular(4, 0.0).expect("even");
    for upper in 0..BOXES {
        for (a, b) in [(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)] {
            let (x, y) = (a + random.between(-0.1, 0.1), b + random.between(-0.1, 0.1));
            let columns = |body: usize, sign: f64, z: f64| {
                // The normal is z, the tangents are x and y; columns are those of the velocity, then of the rotation.
                let rows =
                    [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [y, 0.0, -z], [-x, z, 0.0], [0.0, -y, x]];
                rows.into_iter().enumerate().map(move |(k, row)| ((6 * body + k) as u32, row.map(|entry| sign * entry)))
            };
            let lower = upper.checked_sub(1).into_iter().flat_map(|lower| columns(lower, -1.0, 0.5));
            problem.push_contact(lower.chain(columns(upper, 1.0, -0.5)), 0.0, 0.5, &polygon);
        }
    }
    problem
}
