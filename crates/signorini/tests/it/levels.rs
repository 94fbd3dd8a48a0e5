//! Points of a flat patch are at one height, at which the rows of a body that sticks agree.

use signorini::contact::ContactProblem;
use signorini::multibody::integrate_into;
use signorini::{Settings, Simulation};

/// By how much normals that close their gaps and tangents that stick contradict each other, m/s: what is left of the velocities asked for when rows
/// have been made orthogonal to those before them, where nothing is left of the row.
fn contradiction(problem: &ContactProblem) -> f64 {
    let (mut basis, mut worst) = (Vec::<(Vec<f64>, f64)>::new(), 0.0_f64);
    for i in 0..problem.contact_count() {
        let (columns, entries) = problem.jacobian.group(i);
        for r in 0..3 {
            let mut row = vec![0.0; problem.nv()];
            columns.iter().zip(entries).for_each(|(&k, entry)| row[k as usize] = entry[r]);
            let mut asked = if r == 0 { -problem.gap[i] / problem.timestep } else { 0.0 };
            for (other, value) in basis.iter().chain(&basis) {
                let along: f64 = row.iter().zip(other).map(|(x, y)| x * y).sum();
                row.iter_mut().zip(other).for_each(|(x, y)| *x -= along * y);
                asked -= along * value;
            }
            let length = row.iter().map(|x| x * x).sum::<f64>().sqrt();
            if length > 1e-6 {
                row.iter_mut().for_each(|x| *x /= length);
                basis.push((row, asked / length));
            } else {
                worst = worst.max(asked.abs());
            }
        }
    }
    worst
}

/// A foot above the floor, tilted and coming down on all corners at once.
fn tilted(foot: &str, height: f64, tilt: [f64; 2]) -> Simulation {
    let text = format!(
        "<mujoco><option timestep='0.002'/><worldbody><geom type='plane'/>
           <body pos='0.3 -0.2 {height}'><freejoint/>{foot}</body></worldbody></mujoco>"
    );
    let model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    let mut state = simulation.state().clone();
    let start = state.q.clone();
    integrate_into(simulation.model(), &start, &[0.0, 0.0, 0.0, tilt[0], tilt[1], 0.0], 1.0, &mut state.q);
    state.v[2] = -0.1;
    simulation.set_state(&state).unwrap();
    simulation
}

/// Midway between the surfaces the tangents contradict each other by the product of the tilt and the rate at which it goes.
#[test]
fn rows_of_a_tilted_foot_agree() {
    let balls = [[0.1, 0.05], [0.1, -0.05], [-0.1, 0.05], [-0.1, -0.05]];
    let balls = balls.map(|[x, y]| format!("<geom type='sphere' size='0.01' pos='{x} {y} 0' mass='0.5'/>")).concat();
    let block = "<geom type='box' size='0.1 0.05 0.02' mass='2'/>";
    for (foot, half) in [(balls.as_str(), 0.01), (block, 0.02)] {
        for tilt in [[1e-6, 3e-7], [1e-5, -4e-5], [3e-4, 1e-4]] {
            let mut simulation = tilted(foot, half + 1e-4, tilt);
            simulation.step().unwrap();
            let workspace = simulation.workspace();
            let points = workspace.contact_points();
            assert_eq!(points.len(), 4, "{tilt:?}");
            let gaps = points.iter().map(|point| point.gap);
            let [low, high] = [gaps.clone().fold(f64::INFINITY, f64::min), gaps.fold(0.0, f64::max)];
            assert!(high - low > 0.1 * tilt[0], "the foot is not tilted: gaps {low} to {high}");
            let off = contradiction(workspace.problem());
            assert!(off < 1e-12, "tilt {tilt:?}: rows contradict each other by {off:.1e} m/s");
        }
    }
}

/// What touches beside what comes down later stays where it touches.
#[test]
fn what_is_far_does_not_lift_what_touches() {
    let mut simulation = tilted("<geom type='box' size='0.1 0.05 0.02' mass='2'/>", 0.02 + 1e-3, [0.0, 0.01]);
    let mut state = simulation.state().clone();
    // The far edge comes down, too.
    (state.v[2], state.v[4]) = (-1.0, -8.0);
    simulation.set_state(&state).unwrap();
    simulation.step().unwrap();
    let points = simulation.workspace().contact_points();
    let lowest = points.iter().min_by(|p, q| p.gap.total_cmp(&q.gap)).unwrap();
    assert!(lowest.gap < 1e-5 && points.iter().any(|point| point.gap > 1e-3), "{points:?}");
    assert!(lowest.position.z.abs() < 1e-6, "{lowest:?}");
}
