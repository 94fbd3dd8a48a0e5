//! Trajectories through contact by differential dynamic programming: a hopper that hops half a metre and stands, and a ball that pushes
//! a box to a pose. `cargo run --release -p signorini --example trajectory_optimization -- FOLDER` writes the motions as recordings, for
//! `signorini view`.
//!
//! The model is the engine's own step, with its exact derivatives. At a tie, as where a foot just touches or a box just comes to rest, the
//! step has one derivative on each side: the matrices are those of the modes that the step is in, so that a backward pass sees what is
//! touched now. What it does not see is a contact that is not made yet: that has to be in the first guess, which lets the foot push
//! off and the ball touch the box. No step along what the backward pass proposes is taken that does not lower the cost itself.
//!
//! Source: Y. Tassa, T. Erez, E. Todorov, *Synthesis and stabilization of complex behaviors through online trajectory optimization*, IROS (2012).

use std::error::Error;
use std::path::Path;

use signorini::derivatives::{StepDerivatives, Validity};
use signorini::formats::load_mjcf_str;
use signorini::lcp::Matrix;
use signorini::lcp::linalg::Lu;
use signorini::multibody::{Input, Model, State};
use signorini::{RunRecorder, Settings, Simulation, Workspace, step};

const HOPPER: &str = "<mujoco model='hopper'><option timestep='0.01'/><worldbody>
    <geom name='floor' type='plane' friction='0.9'/>
    <body name='trunk' pos='0 0 0.6'>
      <joint name='x' type='slide' axis='1 0 0'/><joint name='z' type='slide' axis='0 0 1'/>
      <geom type='box' size='0.12 0.08 0.08' mass='4' contype='0' conaffinity='0'/>
      <body name='leg'><joint name='hip' type='hinge' axis='0 -1 0' damping='0.2'/>
        <geom type='capsule' size='0.03' fromto='0 0 0 0 0 -0.25' mass='0.4' contype='0' conaffinity='0'/>
        <body name='foot' pos='0 0 -0.55'><joint name='knee' type='slide' axis='0 0 1' stiffness='400' damping='6'/>
          <geom type='capsule' size='0.02' fromto='0 0 0 0 0 0.25' mass='0.2' contype='0' conaffinity='0'/>
          <geom name='sole' type='sphere' size='0.04' mass='0.1' friction='0.9'/></body></body></body></worldbody>
  <actuator><motor joint='hip'/><motor joint='knee'/></actuator></mujoco>";

const BOX: &str = "<mujoco model='push'><option timestep='0.02' gravity='0 0 0'/><worldbody>
    <body name='ball' pos='-0.2 0.03 0.1'><joint name='u' type='slide' axis='1 0 0' damping='4'/><joint name='v' type='slide' axis='0 1 0' damping='4'/>
      <geom name='ball' type='sphere' size='0.05' mass='0.3' friction='0.4'/></body>
    <body name='box' pos='0 0 0.1'><joint name='x' type='slide' axis='1 0 0' frictionloss='0.6'/>
      <joint name='y' type='slide' axis='0 1 0' frictionloss='0.6'/><joint name='turn' type='hinge' axis='0 0 1' frictionloss='0.04'/>
      <geom name='box' type='box' size='0.12 0.1 0.08' mass='1' friction='0.4'/></body></worldbody>
  <actuator><motor joint='u'/><motor joint='v'/></actuator></mujoco>";

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1);
    let hop = |k: usize| if k < 25 { vec![0.6, -40.0] } else { vec![-0.2, 0.0] };
    let hopper = Problem {
        model: load_mjcf_str(HOPPER, ".")?.model,
        goal: vec![0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        weights: vec![40000.0, 40000.0, 100.0, 20.0, 200.0, 200.0, 4.0, 4.0],
        effort: 2e-3,
    };
    let push = Problem {
        model: load_mjcf_str(BOX, ".")?.model,
        goal: vec![0.0, 0.0, 0.3, 0.03, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0],
        weights: vec![0.0, 0.0, 4000.0, 4000.0, 800.0, 0.0, 0.0, 40.0, 40.0, 10.0],
        effort: 1e-2,
    };
    let pushed = |k: usize| if k < 60 { vec![2.2, 0.1] } else { vec![-0.5, 0.0] };
    for (name, problem, guess) in
        [("hopper", &hopper, (0..90).map(hop).collect::<Vec<_>>()), ("box", &push, (0..90).map(pushed).collect())]
    {
        let before = problem.rollout(&guess)?;
        let found = problem.optimize(guess, 300)?;
        let end = found.states.last().ok_or("no state")?;
        println!("{name}: cost {:.3} → {:.4}", before.cost, found.cost);
        println!("  ends at {:.3?} with {:.3?}", end.q, end.v);
        println!("  steps exact, one-sided: {:?}; without contact {}", found.counts, found.apart);
        let off = problem.goal.iter().zip(end.q.iter().chain(&end.v)).zip(&problem.weights);
        let farthest = off.filter(|(_, w)| **w >= 800.0).map(|((goal, x), _)| (goal - x).abs()).fold(0.0, f64::max);
        assert!(farthest < 0.02, "{name} ends {farthest:.3} from its goal");
        assert!(found.cost < 0.1 * before.cost);
        if let Some(folder) = &folder {
            record(&problem.model, &found.controls, &Path::new(folder).join(format!("{name}.rec")))?;
        }
    }
    Ok(())
}

/// Bring `(q, v)` near a goal at the end, with little effort: `½ Σ w (x − goal)² + ½ r Σ u²`. Joints slide or turn about one axis.
struct Problem {
    model: Model,
    goal: Vec<f64>,
    weights: Vec<f64>,
    effort: f64,
}

/// A motion, with the matrices of its steps.
struct Motion {
    states: Vec<State>,
    controls: Vec<Vec<f64>>,
    slopes: Vec<[Matrix; 2]>,
    cost: f64,
    /// Steps whose derivative is exact, and one-sided.
    counts: [usize; 2],
    /// Steps in which nothing touches.
    apart: usize,
}

/// What a backward pass proposes for a step: a change of the control, and its answer to a change of the state.
struct Answer {
    change: Vec<f64>,
    gain: Vec<Vec<f64>>,
}

impl Problem {
    fn rollout(&self, controls: &[Vec<f64>]) -> Result<Motion, Box<dyn Error>> {
        self.follow(controls, None)
    }

    /// The motion with controls, or with those that a backward pass makes of another motion, a part `alpha` of the way.
    fn follow(
        &self,
        controls: &[Vec<f64>],
        other: Option<(&Motion, &[Answer], f64)>,
    ) -> Result<Motion, Box<dyn Error>> {
        let (model, settings) = (&self.model, Settings::default());
        let mut workspace = Workspace::new(model, &settings)?;
        let mut derivatives = StepDerivatives::new(model);
        let mut motion = Motion {
            states: vec![State::new(model)],
            controls: Vec::new(),
            slopes: Vec::new(),
            cost: 0.0,
            counts: [0; 2],
            apart: 0,
        };
        for (k, control) in controls.iter().enumerate() {
            let state = motion.states[k].clone();
            let mut control = control.clone();
            if let Some((other, answers, alpha)) = other {
                let off = difference(&state, &other.states[k]);
                for (u, (change, gain)) in control.iter_mut().zip(answers[k].change.iter().zip(&answers[k].gain)) {
                    *u += alpha * change + dot(gain, &off);
                }
            }
            let input = Input::of_control(control.clone());
            let mut next = state.clone();
            let report = step(model, &state, &input, &settings, &mut workspace, &mut next)?;
            derivatives.compute(model, (&state, &input), &settings, &report, &mut workspace);
            motion.counts[usize::from(*derivatives.validity() != Validity::Exact)] += 1;
            motion.apart += usize::from(workspace.solution().lambda_n.iter().all(|lambda| *lambda == 0.0));
            let slopes = derivatives.state_matrix().zip(derivatives.control_matrix());
            let (a, b) = slopes.ok_or_else(|| format!("step {k}: {:?}", derivatives.validity()))?;
            motion.cost += 0.5 * self.effort * dot(&control, &control);
            motion.slopes.push([a, b]);
            motion.controls.push(control);
            motion.states.push(next);
        }
        let off = self.off(&motion);
        motion.cost += 0.5 * off.iter().zip(&self.weights).map(|(x, w)| w * x * x).sum::<f64>();
        Ok(motion)
    }

    fn off(&self, motion: &Motion) -> Vec<f64> {
        let end = &motion.states[motion.states.len() - 1];
        end.q.iter().chain(&end.v).zip(&self.goal).map(|(x, goal)| x - goal).collect()
    }

    fn optimize(&self, guess: Vec<Vec<f64>>, passes: usize) -> Result<Motion, Box<dyn Error>> {
        let mut best = self.rollout(&guess)?;
        let mut damping = 1e-3;
        for _ in 0..passes {
            let Some(answers) = self.backward(&best, damping) else {
                damping *= 10.0;
                continue;
            };
            let tried = [1.0, 0.5, 0.25, 0.1, 0.03, 0.01]
                .iter()
                .map(|alpha| self.follow(&best.controls, Some((&best, &answers, *alpha))));
            // A motion through a step without any derivative is no better.
            let better = tried.filter_map(Result::ok).find(|motion| motion.cost < best.cost);
            match better {
                Some(motion) => {
                    let gained = best.cost - motion.cost;
                    best = motion;
                    damping = f64::max(damping * 0.3, 1e-9);
                    if gained < 1e-7 * best.cost {
                        break;
                    }
                }
                None if damping > 1e6 => break,
                None => damping *= 10.0,
            }
        }
        Ok(best)
    }

    /// The answers that the quadratic model of the cost-to-go asks for; nothing where it is not convex.
    fn backward(&self, motion: &Motion, damping: f64) -> Option<Vec<Answer>> {
        let (n, nu) = (self.goal.len(), self.model.actuators.len());
        let mut slope: Vec<f64> = self.off(motion).iter().zip(&self.weights).map(|(x, w)| w * x).collect();
        let mut curvature = Matrix::from_fn(n, n, |i, j| if i == j { self.weights[i] } else { 0.0 });
        let mut answers = Vec::new();
        for ([a, b], control) in motion.slopes.iter().zip(&motion.controls).rev() {
            let va = product(&curvature, a);
            let vb = product(&curvature, b);
            let by_control: Vec<f64> = (0..nu).map(|j| self.effort * control[j] + dot(&column(b, j), &slope)).collect();
            let mut system = Lu::default();
            let entries = system.start(nu);
            for (i, j) in (0..nu * nu).map(|e| (e / nu, e % nu)) {
                let own = if i == j { self.effort + damping } else { 0.0 };
                entries[i * nu + j] = own + dot(&column(b, i), &column(&vb, j));
            }
            if system.factorize() < 1e-14 {
                return None;
            }
            let solved = |mut right: Vec<f64>| {
                system.solve(&mut right);
                right.iter().map(|x| -x).collect::<Vec<f64>>()
            };
            let change = solved(by_control.clone());
            let mixed: Vec<Vec<f64>> =
                (0..n).map(|i| (0..nu).map(|j| dot(&column(b, j), &column(&va, i))).collect()).collect();
            let columns: Vec<Vec<f64>> = mixed.iter().map(|right| solved(right.clone())).collect();
            let gain: Vec<Vec<f64>> = (0..nu).map(|j| columns.iter().map(|c| c[j]).collect()).collect();
            let next: Vec<f64> = (0..n).map(|i| dot(&column(a, i), &slope) + dot(&mixed[i], &change)).collect();
            curvature = Matrix::from_fn(n, n, |i, j| {
                let (i, j) = (i.min(j), i.max(j));
                dot(&column(a, i), &column(&va, j)) + 0.5 * (dot(&mixed[i], &columns[j]) + dot(&mixed[j], &columns[i]))
            });
            slope = next;
            answers.push(Answer { change, gain });
        }
        answers.reverse();
        Some(answers)
    }
}

fn difference(a: &State, b: &State) -> Vec<f64> {
    a.q.iter().chain(&a.v).zip(b.q.iter().chain(&b.v)).map(|(a, b)| a - b).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn column(matrix: &Matrix, j: usize) -> Vec<f64> {
    (0..matrix.rows()).map(|i| matrix[(i, j)]).collect()
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let columns: Vec<Vec<f64>> = (0..b.cols()).map(|j| column(b, j)).collect();
    Matrix::from_fn(a.rows(), b.cols(), |i, j| dot(a.row(i), &columns[j]))
}

fn record(model: &Model, controls: &[Vec<f64>], path: &Path) -> Result<(), Box<dyn Error>> {
    let mut simulation = Simulation::new(model.clone(), Settings::default())?;
    let mut recorder = RunRecorder::create(path, &simulation)?;
    for control in controls {
        simulation.input.control.clone_from(control);
        simulation.step()?;
        recorder.add(&simulation)?;
    }
    recorder.finish(&simulation, "the end of the plan")?;
    println!("  {}", path.display());
    Ok(())
}
