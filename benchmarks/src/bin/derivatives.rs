//! What the derivatives of steps are worth: how often they exist, on the bundled scenes and on random ones, and whether one that is called
//! exact was ever wrong. Fails where one was.

use std::collections::BTreeMap;
use std::error::Error;

use clap::Parser;
use signorini::contact::ContactMode;
use signorini::derivatives::{StepDerivatives, Validity};
use signorini::multibody::glam::DVec3;
use signorini::multibody::{
    ContactPoint, Geom, GeomId, Geometry, Input, Model, ModelBuilder, State, difference_into, integrate_into,
};
use signorini::{Settings, Workspace, step};
use signorini_formats::load_mjcf_str;
use signorini_testkit::Random;

/// Differences narrow enough to stay in any mode whose margins are above the tie: parts of a change as large as a step makes.
const WIDTHS: [f64; 5] = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
/// The best of them is this near to a derivative, relative to its largest entry.
const AGREES: f64 = 1e-4;

/// Compares derivatives of steps that are called exact with differences of the steps.
#[derive(Parser)]
struct Options {
    /// Steps of each bundled scene
    #[arg(long, default_value_t = 400)]
    steps: u32,
    /// Random scenes, of 200 steps each
    #[arg(long, default_value_t = 100)]
    scenes: u64,
    /// The first random scene
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// A few steps of everything
    #[arg(long)]
    smoke: bool,
    /// Say why derivatives are refused or one-sided
    #[arg(long)]
    why: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut options = Options::parse();
    if options.smoke {
        (options.steps, options.scenes) = (12, 4);
    }
    let head = ["own run: exact/one/ref.", "disturbed"];
    println!("{:<16} {:>24}   {:>24}   checked  wrong unresolved", "", head[0], head[1]);
    let mut wrong = 0;
    for scene in &signorini_scenes::SCENES {
        let mut run = Run::new(load_mjcf_str(scene.text, ".")?.model)?;
        run.all(options.steps, &mut Random::new(1));
        wrong += run.counts.report(scene.name, options.why);
    }
    let mut sum = Counts::default();
    for seed in options.first..options.first + options.scenes {
        let mut random = Random::new(seed);
        let mut run = Run::new(random_scene(&mut random)?)?;
        run.all(if options.smoke { 40 } else { 200 }, &mut random);
        if run.counts.wrong + run.counts.unresolved > 0 {
            println!("random scene {seed}: {} wrong, {} unresolved", run.counts.wrong, run.counts.unresolved);
        }
        sum.add(run.counts);
    }
    wrong += sum.report("random", options.why);
    match wrong {
        0 => Ok(()),
        _ => Err(format!("{wrong} derivatives were called exact and are not").into()),
    }
}

/// Shares of exact, one-sided and refused derivatives, in the run itself and disturbed.
#[derive(Default)]
struct Counts {
    own: [u64; 3],
    disturbed: [u64; 3],
    checked: u64,
    wrong: u64,
    /// Of which no difference stays in the mode.
    unresolved: u64,
    reasons: BTreeMap<String, u64>,
}

impl Counts {
    fn add(&mut self, other: Self) {
        for k in 0..3 {
            self.own[k] += other.own[k];
            self.disturbed[k] += other.disturbed[k];
        }
        self.checked += other.checked;
        self.wrong += other.wrong;
        self.unresolved += other.unresolved;
        other.reasons.into_iter().for_each(|(reason, n)| *self.reasons.entry(reason).or_default() += n);
    }

    fn report(&self, name: &str, why: bool) -> u64 {
        let percent = |counts: [u64; 3]| {
            let all = counts.iter().sum::<u64>().max(1);
            let part = |n: u64| format!("{:.1}", 100.0 * n as f64 / all as f64);
            counts.map(part).join(" / ")
        };
        let (own, disturbed) = (percent(self.own), percent(self.disturbed));
        println!(
            "{name:<16} {own:>24}   {disturbed:>24}   {:>7} {:>6} {:>10}",
            self.checked, self.wrong, self.unresolved
        );
        if why {
            let mut reasons: Vec<_> = self.reasons.iter().collect();
            reasons.sort_by_key(|(_, n)| std::cmp::Reverse(**n));
            reasons.iter().take(8).for_each(|(reason, n)| println!("    {n:>6} {reason}"));
        }
        self.wrong
    }
}

struct Run {
    model: Model,
    settings: Settings,
    workspace: Workspace,
    derivatives: StepDerivatives,
    counts: Counts,
}

impl Run {
    fn new(model: Model) -> Result<Self, Box<dyn Error>> {
        let settings = Settings::default();
        let workspace = Workspace::new(&model, &settings)?;
        let derivatives = StepDerivatives::new(&model);
        Ok(Self { model, settings, workspace, derivatives, counts: Counts::default() })
    }

    fn step(&mut self, state: &State, input: &Input) -> Option<(State, signorini::StepReport)> {
        let mut next = state.clone();
        let report = step(&self.model, state, input, &self.settings, &mut self.workspace, &mut next).ok()?;
        Some((next, report))
    }

    /// Every step of a run, and every fourth beside it.
    fn all(&mut self, steps: u32, random: &mut Random) {
        let mut state = State::new(&self.model);
        let mut input = Input::of_control(vec![0.0; self.model.actuators.len()]);
        if let Some(key) = self.model.keyframes.first() {
            state.q.clone_from(&key.q);
            state.v.clone_from(&key.v);
            input.control.clone_from(&key.control);
            input.control.resize(self.model.actuators.len(), 0.0);
        }
        for n in 0..steps {
            if n % 4 == 3 {
                let change = self.change(random);
                let part = random.between(0.0, 0.1);
                let (near, with) = self.moved(&state, &input, &change, part);
                if let Some(counts) = self.judge(&near, &with, random) {
                    self.counts.disturbed[counts] += 1;
                }
            }
            if let Some(counts) = self.judge(&state, &input, random) {
                self.counts.own[counts] += 1;
            }
            let Some((next, _)) = self.step(&state, &input) else { return };
            state = next;
        }
    }

    /// Whether the derivative is exact (0), one-sided (1), refused (2); compares exact ones with differences.
    fn judge(&mut self, state: &State, input: &Input, random: &mut Random) -> Option<usize> {
        let (next, report) = self.step(state, input)?;
        self.derivatives.compute(&self.model, (state, input), &self.settings, &report, &mut self.workspace);
        match self.derivatives.validity() {
            Validity::Exact => {
                let change = self.change(random);
                let product = self.derivatives.product(&change).unwrap_or_default();
                self.counts.checked += 1;
                let story = self.story();
                let signature = self.signature();
                let errors = WIDTHS.map(|h| self.error((state, input), (&next, &signature), &change, &product, h));
                if errors.iter().all(|(error, _)| *error > AGREES) {
                    let stays = errors.iter().any(|(_, stays)| *stays);
                    let margins = self.derivatives.margins();
                    let nearest = margins.iter().min_by(|a, b| a.value.total_cmp(&b.value));
                    let verdict = if stays { "wrong" } else { "no width stays in the mode" };
                    println!("{verdict}: {errors:?}, nearest {nearest:?}\n{story}");
                    if stays {
                        self.counts.wrong += 1;
                    } else {
                        self.counts.unresolved += 1;
                    }
                }
                Some(0)
            }
            Validity::OneSided { deciding } => {
                let mut kinds: Vec<String> = deciding.iter().map(|m| format!("{:?}", m.kind)).collect();
                kinds.sort();
                kinds.dedup();
                *self.counts.reasons.entry(format!("one-sided: {}", kinds.join(", "))).or_default() += 1;
                Some(1)
            }
            Validity::Refused { reason } => {
                *self.counts.reasons.entry(format!("refused: {reason}")).or_default() += 1;
                Some(2)
            }
            _ => None,
        }
    }

    /// What the contacts of the last step do.
    fn story(&self) -> String {
        let (problem, solution) = (self.workspace.problem(), self.workspace.solution());
        let kind = |id: GeomId| self.model.geoms[id.index()].geometry.kind_name();
        let of = |(i, point): (usize, &ContactPoint)| {
            let [a, b] = [point.geom_a, point.geom_b].map(kind);
            let (mode, gap, impulse) = (solution.modes[i], problem.gap[i], solution.lambda_n[i]);
            format!("    {i} {a} on {b}: {mode:?}, gap {:.1e} taken as {gap:.1e}, impulse {impulse:.1e}", point.gap)
        };
        self.workspace.contact_points().iter().enumerate().map(of).collect::<Vec<_>>().join("\n")
    }

    /// What contacts and friction groups do.
    fn signature(&self) -> Vec<String> {
        let solution = self.workspace.solution();
        let points = self.workspace.contact_points().iter();
        let closed = points.zip(&solution.modes).filter(|(_, mode)| **mode != ContactMode::Open);
        let of_contacts = closed.map(|(p, mode)| format!("{} {} {} {mode:?}", p.geom_a.0, p.geom_b.0, p.feature));
        of_contacts.chain(solution.group_modes.iter().map(|mode| format!("{mode:?}"))).collect()
    }

    /// How far central differences of this width are from the product, relative to its largest entry, and whether both sides are in the mode.
    fn error(
        &mut self,
        given: (&State, &Input),
        (next, signature): (&State, &[String]),
        change: &[f64],
        product: &[f64],
        h: f64,
    ) -> (f64, bool) {
        let (nv, mut stays) = (self.model.nv, true);
        let mut sides = [Vec::new(), Vec::new()];
        for (sign, side) in [1.0, -1.0].into_iter().zip(&mut sides) {
            let (state, input) = self.moved(given.0, given.1, change, sign * h);
            let Some((end, _)) = self.step(&state, &input) else { return (f64::INFINITY, false) };
            stays &= self.signature() == signature;
            side.resize(nv, 0.0);
            difference_into(&self.model, &end.q, &next.q, side);
            side.extend(&end.v);
        }
        let size = product.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
        let slope = sides[0].iter().zip(&sides[1]).map(|(a, b)| (a - b) / (2.0 * h));
        let off = slope.zip(product).fold(0.0, |s: f64, (found, expected)| s.max((found - expected).abs()));
        (off / size, stays)
    }

    /// A random `(δq, δv, δu, δτ)`.
    fn change(&self, random: &mut Random) -> Vec<f64> {
        let (nv, nu, dt) = (self.model.nv, self.model.actuators.len(), self.model.timestep);
        let sizes = [(nv, dt), (nv, 1.0), (nu, 1.0), (nv, 1.0)];
        sizes.iter().flat_map(|&(n, size)| vec![size; n]).map(|size| size * random.normal()).collect()
    }

    fn moved(&self, state: &State, input: &Input, change: &[f64], h: f64) -> (State, Input) {
        let (nv, nu) = (self.model.nv, self.model.actuators.len());
        let (mut state_out, mut input_out) = (state.clone(), input.clone());
        input_out.generalized_force.resize(nv, 0.0);
        integrate_into(&self.model, &state.q, &change[..nv], h, &mut state_out.q);
        (0..nv).for_each(|k| state_out.v[k] += h * change[nv + k]);
        (0..nu).for_each(|a| input_out.control[a] += h * change[2 * nv + a]);
        (0..nv).for_each(|k| input_out.generalized_force[k] += h * change[2 * nv + nu + k]);
        (state_out, input_out)
    }
}

/// One to eight bodies of all shapes over a floor, a ramp or a bowl of three planes, thrown at each other, some of them standing.
fn random_scene(random: &mut Random) -> Result<Model, Box<dyn Error>> {
    let mut world = ModelBuilder::new("random");
    world.timestep(random.between(0.001, 0.01));
    world.floor();
    for i in 0..1 + random.below(8) {
        let size = random.between(0.05, 0.15);
        let second = size * random.between(0.4, 1.0);
        let geometry = match random.below(6) {
            0 => Geometry::Sphere { radius: size },
            1 => Geometry::Capsule { radius: second, half_length: size },
            2 | 3 => Geometry::Box { half_extents: DVec3::new(size, second, size * random.between(0.3, 1.0)) },
            4 => Geometry::Cylinder { radius: second, half_length: size },
            _ => Geometry::Ellipsoid { semi_axes: DVec3::new(size, second, size * random.between(0.4, 1.0)) },
        };
        let place = [random.between(-0.2, 0.2), random.between(-0.2, 0.2), 0.15 + 0.25 * i as f64];
        let mut shape = Geom::from(geometry).with_friction(random.between(0.0, 1.2));
        if random.below(2) == 0 {
            shape = shape.with_placement([random.between(-0.05, 0.05), 0.0, random.between(-0.05, 0.05)]);
        }
        if random.below(3) == 0 {
            shape = shape.with_restitution(random.between(0.0, 0.9));
        }
        world.body(format!("part{i}")).at(place).free().solid(shape, random.between(0.1, 5.0)).add()?;
    }
    Ok(world.build()?)
}
