//! How long the derivatives of a step take, beside the step and beside central differences of the step in the same run.

use std::error::Error;
use std::hint::black_box;
use std::path::PathBuf;

use clap::Parser;
use cpu_time::ThreadTime;
use signorini::derivatives::{StepDerivatives, Validity};
use signorini::lcp::Matrix;
use signorini::multibody::{Input, Model, State, difference_into, integrate_into};
use signorini::{Settings, StepReport, Workspace, step};
use signorini_benchmarks::robots::a1_on_its_feet;
use signorini_formats::load_mjcf_str;
use signorini_testkit::Random;

/// Half-widths of the differences that are timed; their accuracy is not judged here.
const WIDTH: f64 = 1e-6;

/// Times `A` and `B` of an arm, a quadruped and a humanoid.
#[derive(Parser)]
struct Options {
    /// Seconds of one thread that each figure is measured for
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// A few repetitions of everything
    #[arg(long)]
    smoke: bool,
    /// A folder with `a1_description`, as `benchmarks/robots/fetch.py` makes it
    #[arg(long)]
    robots: Option<PathBuf>,
    /// The derivatives alone, for a profiler
    #[arg(long)]
    alone: bool,
    /// Only the model of this name
    #[arg(long)]
    only: Option<String>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut options = Options::parse();
    if options.smoke {
        options.seconds = 0.005;
    }
    let bundled = |text: &str| load_mjcf_str(text, ".").map(|loaded| loaded.model);
    let quadruped = signorini_scenes::named("quadruped").ok_or("there is no scene of a quadruped")?;
    let mut models = vec![
        ("arm", bundled(include_str!("../../derivatives/arm.xml"))?),
        ("quadruped", bundled(quadruped.text)?),
        ("humanoid", bundled(include_str!("../../derivatives/humanoid.xml"))?),
    ];
    if let Some(folder) = &options.robots {
        models.push(("a1", a1_on_its_feet(folder)?));
    }
    println!("model       nv  nu rows   step µs   A, B µs    differences µs   times quicker   validity");
    for (name, model) in models {
        if options.only.as_deref().is_none_or(|only| only == name) {
            Bench::new(model)?.report(name, &options)?;
        }
    }
    Ok(())
}

/// A model with what its steps and their derivatives need.
struct Bench {
    model: Model,
    settings: Settings,
    workspace: Workspace,
    derivatives: StepDerivatives,
    state: State,
    input: Input,
    next: State,
    by_state: Matrix,
    by_control: Matrix,
}

impl Bench {
    /// The first state with an exact derivative beside the motion that the model makes, at random.
    fn new(model: Model) -> Result<Self, Box<dyn Error>> {
        let settings = Settings::default();
        let (nv, nu) = (model.nv, model.actuators.len());
        let (workspace, derivatives) = (Workspace::new(&model, &settings)?, StepDerivatives::new(&model));
        let (mut state, mut input) = (State::new(&model), Input::of_control(vec![0.0; nu]));
        if let Some(key) = model.keyframes.first() {
            state.q.clone_from(&key.q);
            input.control[..key.control.len()].copy_from_slice(&key.control);
        }
        let next = state.clone();
        let (by_state, by_control) = (Matrix::zeros(2 * nv, 2 * nv), Matrix::zeros(2 * nv, nu));
        let mut bench = Self { model, settings, workspace, derivatives, state, input, next, by_state, by_control };
        for _ in 0..300 {
            bench.step()?;
            std::mem::swap(&mut bench.state, &mut bench.next);
        }
        let (settled, mut random) = (bench.state.clone(), Random::new(1));
        for _ in 0..100 {
            let report = bench.step()?;
            bench.differentiate(&report);
            if *bench.derivatives.validity() == Validity::Exact {
                break;
            }
            bench.state.clone_from(&settled);
            bench.state.v.iter_mut().for_each(|v| *v += 1e-3 * random.normal());
        }
        Ok(bench)
    }

    fn step(&mut self) -> Result<StepReport, Box<dyn Error>> {
        let Self { model, settings, workspace, state, input, next, .. } = self;
        Ok(step(model, state, input, settings, workspace, next)?)
    }

    fn differentiate(&mut self, report: &StepReport) {
        let Self { model, settings, workspace, derivatives, state, input, by_state, by_control, .. } = self;
        derivatives.compute(model, (state, input), settings, report, workspace);
        derivatives.matrices_into(by_state, by_control);
        black_box((by_state, by_control));
    }

    fn report(&mut self, name: &str, options: &Options) -> Result<(), Box<dyn Error>> {
        let seconds = options.seconds;
        let by_step = if options.alone { f64::NAN } else { microseconds(seconds, || self.step().map(drop))? };
        let report = self.step()?;
        let own = microseconds(seconds, || {
            self.differentiate(&report);
            Ok(())
        })?;
        let validity = match self.derivatives.validity() {
            Validity::Exact => "exact".to_owned(),
            Validity::OneSided { deciding } => format!("one-sided ({})", deciding.len()),
            other => format!("{other:?}"),
        };
        let mut columns = Columns::new(&self.model);
        let mut by_differences = || microseconds(seconds, || self.differences(&mut columns));
        let differences = if options.alone { f64::NAN } else { by_differences()? };
        let (nv, nu, rows) = (self.model.nv, self.model.actuators.len(), self.workspace.problem().contact_count());
        let ratio = differences / own;
        println!(
            "{name:<10} {nv:>3} {nu:>3} {rows:>4} {by_step:>9.2} {own:>9.2} {differences:>17.1} {ratio:>15.1}   {validity}"
        );
        Ok(())
    }

    /// The same matrices by central differences, two steps a column.
    fn differences(&mut self, columns: &mut Columns) -> Result<(), Box<dyn Error>> {
        let (nv, nu) = (self.model.nv, self.model.actuators.len());
        let (state, input) = (self.state.clone(), self.input.clone());
        for column in 0..2 * nv + nu {
            for (sign, end) in [1.0, -1.0].into_iter().zip(&mut columns.ends) {
                let h = sign * WIDTH;
                match column {
                    k if k < nv => {
                        columns.unit[k] = 1.0;
                        integrate_into(&self.model, &state.q, &columns.unit, h, &mut self.state.q);
                        columns.unit[k] = 0.0;
                    }
                    k if k < 2 * nv => self.state.v[k - nv] += h,
                    k => self.input.control[k - 2 * nv] += h,
                }
                step(&self.model, &self.state, &self.input, &self.settings, &mut self.workspace, &mut self.next)?;
                end.q.clone_from(&self.next.q);
                end.v.clone_from(&self.next.v);
                self.state.q.clone_from(&state.q);
                self.state.v.clone_from(&state.v);
                self.input.control.clone_from(&input.control);
            }
            let [ahead, behind] = &columns.ends;
            difference_into(&self.model, &ahead.q, &behind.q, &mut columns.place);
            let rates = ahead.v.iter().zip(&behind.v).map(|(a, b)| a - b);
            for (r, change) in columns.place.iter().copied().chain(rates).enumerate() {
                columns.all[(r, column)] = change / (2.0 * WIDTH);
            }
        }
        black_box(&columns.all);
        Ok(())
    }
}

struct Columns {
    all: Matrix,
    ends: [State; 2],
    unit: Vec<f64>,
    place: Vec<f64>,
}

impl Columns {
    fn new(model: &Model) -> Self {
        let (nv, nu) = (model.nv, model.actuators.len());
        let ends = [State::new(model), State::new(model)];
        Self { all: Matrix::zeros(2 * nv, 2 * nv + nu), ends, unit: vec![0.0; nv], place: vec![0.0; nv] }
    }
}

/// The least time of one thread over ten rounds, µs.
fn microseconds(seconds: f64, mut work: impl FnMut() -> Result<(), Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    let start = ThreadTime::now();
    let mut repetitions = 0_u32;
    while start.elapsed().as_secs_f64() < 0.1 * seconds {
        work()?;
        repetitions += 1;
    }
    let mut least = f64::INFINITY;
    for _ in 0..9 {
        let start = ThreadTime::now();
        for _ in 0..repetitions {
            work()?;
        }
        least = least.min(start.elapsed().as_secs_f64() * 1e6 / f64::from(repetitions));
    }
    Ok(least)
}
