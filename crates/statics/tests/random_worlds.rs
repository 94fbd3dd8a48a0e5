//! Verdicts on random stacks and walls of 2 to 12 bodies against another solver of programs and the simulation from rest.
//!
//! `SIGNORINI_WORLDS=100000 cargo test --release -p signorini-statics --test random_worlds -- --nocapture` for many of them.

use std::collections::BTreeMap;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};
use rayon::prelude::*;
use signorini_contact::ContactProblem;
use signorini_contact::statics::energy_part;
use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{Geom, Geometry, Input, Model, ModelBuilder, Pose, State};
use signorini_simulation::{Settings, Simulation};
use signorini_solver::ContactSolver;
use signorini_statics::{ModelStability, StabilitySettings, Verdict, stability};

const WORLDS: u64 = 200;
/// What the program must miss at least where a mechanism is proved, and may miss at most where a balance is: it knows its optimum to 1e-8
/// or so, and to less where forces are many times the loads.
const MISSES: f64 = 1e-8;
const MISSES_NONE: f64 = 1e-5;
/// Part of the free motion's energy with which a step counts as moving, and up to which it counts as resting.
const MOVES: f64 = 1e-13;
const RESTS: f64 = 1e-10;

/// Xorshift (G. Marsaglia, 2003).
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        (0..8).for_each(|_| _ = random.unit());
        random
    }

    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    fn one_of(&mut self, values: &[f64]) -> f64 {
        values[self.below(values.len())]
    }
}

struct Maker {
    world: ModelBuilder,
    count: usize,
}

impl Maker {
    fn add(&mut self, shape: Geometry, place: DVec3, turn: f64, friction: f64, density: f64) {
        let volume = match shape {
            Geometry::Box { half_extents } => 8.0 * half_extents.x * half_extents.y * half_extents.z,
            Geometry::Cylinder { radius, half_length } => std::f64::consts::TAU * radius * radius * half_length,
            _ => 1e-3,
        };
        let pose = Pose { position: place, rotation: DQuat::from_rotation_z(turn) };
        let body = self.world.body(format!("body {}", self.count)).at(pose).free();
        body.solid(Geom::new("", shape).with_friction(friction), density * volume).add().expect("a body");
        self.count += 1;
    }
}

/// A stack of boxes and discs askew on each other, on the floor.
fn stack(make: &mut Maker, random: &mut Random, friction: f64) {
    let (mut place, reach) = (DVec3::ZERO, random.one_of(&[0.0, 0.02, 0.05, 0.1]));
    let is_turned = random.unit() < 0.5;
    for _ in 0..2 + random.below(7) {
        let half = DVec3::new(random.between(0.05, 0.15), random.between(0.05, 0.15), random.between(0.02, 0.1));
        place += DVec3::new(random.between(-reach, reach), random.between(-reach, reach), half.z);
        let turn = if is_turned { random.between(-1.0, 1.0) } else { 0.0 };
        let density = random.between(300.0, 3000.0);
        let shape = match random.unit() < 0.15 {
            true => Geometry::Cylinder { radius: half.x, half_length: half.z },
            false => Geometry::Box { half_extents: half },
        };
        make.add(shape, place, turn, friction, density);
        place.z += half.z;
    }
}

/// Bricks in running bond; some are missing.
fn wall(make: &mut Maker, random: &mut Random, friction: f64) {
    let (across, half) = (2 + random.below(3), DVec3::new(0.1, 0.05, 0.03));
    let bond = random.one_of(&[0.1, 0.1, 0.06, 0.14]);
    for k in 0..4 * across {
        let (layer, column) = (k / across, k % across);
        if make.count < 12 && random.unit() < 0.8 {
            let x = 0.2 * column as f64 + if layer % 2 == 1 { bond } else { 0.0 };
            let place = DVec3::new(x, 0.0, 0.03 + 0.06 * layer as f64);
            make.add(Geometry::Box { half_extents: half }, place, 0.0, friction, 1800.0);
        }
    }
}

/// A box that leans on nothing but touches two walls, or a row of boxes between them.
fn between_walls(make: &mut Maker, random: &mut Random, friction: f64) {
    let count = 1 + random.below(4);
    let height = random.one_of(&[0.0, 0.3]);
    for (name, x, towards) in [("left", -0.1, 1.0), ("right", 0.2 * count as f64 - 0.1, -1.0)] {
        let pose = Pose { position: x * DVec3::X, rotation: DQuat::from_rotation_arc(DVec3::Z, towards * DVec3::X) };
        let shape = Geom::new(name, Geometry::Plane).with_friction(friction);
        make.world.body(name).at(pose).shape(shape).add().expect("a wall");
    }
    for k in 0..count {
        let half = DVec3::new(0.1, random.between(0.05, 0.1), random.between(0.05, 0.1));
        let place = DVec3::new(0.2 * k as f64, random.between(-0.03, 0.03), height + half.z);
        make.add(Geometry::Box { half_extents: half }, place, 0.0, friction, random.between(300.0, 3000.0));
    }
}

fn world(seed: u64) -> Model {
    let mut random = Random::new(seed);
    let mut make = Maker { world: ModelBuilder::new("world"), count: 0 };
    let friction = random.one_of(&[0.0, 0.1, 0.3, 0.5, 0.8, 1.2]);
    let slope = random.one_of(&[0.0, 0.0, 0.05, 0.1, 0.2, 0.3, 0.5]);
    let heading = random.between(0.0, 6.3);
    let gravity = DVec3::new(slope * heading.cos(), slope * heading.sin(), -1.0).normalize();
    make.world.gravity(9.81 * gravity);
    make.world.floor();
    match random.below(5) {
        0 | 1 => stack(&mut make, &mut random, friction),
        2 | 3 => wall(&mut make, &mut random, friction),
        _ => between_walls(&mut make, &mut random, friction),
    }
    make.world.build().expect("a world")
}

/// The least sum of impulses that must be added for a balance, in units of the loads: a linear program for the forces of all cones, while
/// verdicts come from motions and from forces in blocks of bodies.
fn imbalance(problem: &ContactProblem) -> f64 {
    let nv = problem.nv();
    let root: Vec<f64> = (0..nv)
        .map(|k| {
            let mut unit = vec![0.0; nv];
            unit[k] = 1.0;
            let mut column = vec![0.0; nv];
            problem.mass.multiply_into(&unit, &mut column);
            column[k].sqrt()
        })
        .collect();
    let mut load = vec![0.0; nv];
    problem.mass.multiply_into(&problem.free_velocity, &mut load);
    load.iter_mut().zip(&root).for_each(|(p, m)| *p /= -m);
    let size = load.iter().fold(0.0, |most: f64, p| most.max(p.abs()));
    if size == 0.0 {
        return 0.0;
    }
    load.iter_mut().for_each(|p| *p /= size);
    let (mut rows, mut columns, mut values, mut count) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for i in 0..problem.contact_count() {
        let (places, entries) = problem.jacobian.group(i);
        let mu = problem.friction[i];
        let directions = if mu > 0.0 { problem.directions_of(i).to_vec() } else { vec![[0.0; 2]] };
        for d in directions {
            for (&place, e) in places.iter().zip(entries) {
                let value = e[0] + mu * (d[0] * e[1] + d[1] * e[2]);
                rows.push(place as usize);
                columns.push(count);
                values.push(value / root[place as usize]);
            }
            count += 1;
        }
    }
    let forces = count;
    for k in 0..nv {
        for sign in [1.0, -1.0] {
            rows.push(k);
            columns.push(count);
            values.push(sign);
            count += 1;
        }
    }
    for k in 0..count {
        rows.push(nv + k);
        columns.push(k);
        values.push(-1.0);
    }
    let cost: Vec<f64> = (0..count).map(|k| f64::from(u8::from(k >= forces))).collect();
    let right: Vec<f64> = load.iter().copied().chain(std::iter::repeat_n(0.0, count)).collect();
    let matrix = CscMatrix::new_from_triplets(nv + count, count, rows, columns, values);
    let cones = [SupportedConeT::ZeroConeT(nv), SupportedConeT::NonnegativeConeT(count)];
    let settings =
        DefaultSettings { verbose: false, tol_gap_abs: 1e-11, tol_gap_rel: 1e-11, ..DefaultSettings::default() };
    let quadratic = CscMatrix::zeros((count, count));
    let mut solver = DefaultSolver::new(&quadratic, &cost, &matrix, &right, &cones, settings).expect("a program");
    solver.solve();
    solver.solution.obj_val
}

/// A verdict on a world.
struct Judged {
    verdict: &'static str,
    /// Where the search for a moving solution started when it found one beside a balance.
    moves_from: Option<&'static str>,
    contradicted: Option<String>,
}

fn judged(seed: u64) -> Judged {
    let model = world(seed);
    let settings = StabilitySettings::default().with_perturbations(2).with_enumeration_programs(20);
    let state = State::new(&model);
    let found = match stability(&model, &state, &Input::default(), &settings) {
        Ok(found) => found,
        Err(error) => {
            let contradicted = Some(format!("seed {seed}: {error}"));
            return Judged { verdict: "refused", moves_from: None, contradicted };
        }
    };
    let verdict = found.stability.verdict();
    let is_open = verdict == Verdict::MayDoEither;
    let moves_from = found.stability.search.iter().find(|run| is_open && run.end == "moves").map(|run| run.start);
    let reason = contradiction(model, &found, settings.tolerance);
    let contradicted = reason.map(|reason| format!("seed {seed}: {}, but {reason}", verdict.name()));
    Judged { verdict: verdict.name(), moves_from, contradicted }
}

/// What contradicts a verdict, if anything.
fn contradiction(model: Model, found: &ModelStability, tolerance: f64) -> Option<String> {
    let (verdict, problem) = (found.stability.verdict(), &found.rest.problem);
    if found.stability.worst() > tolerance {
        return Some(format!("its proof lacks {:?}", found.stability.residuals));
    }
    let missing = imbalance(problem);
    let agrees = if verdict == Verdict::MustMove { missing > MISSES } else { missing < MISSES_NONE };
    if !agrees {
        return Some(format!("a program misses {missing:e} of a balance"));
    }
    let mut simulation = Simulation::new(model, Settings::default()).expect("a simulation");
    if let Err(error) = simulation.step() {
        return Some(format!("the step ends: {error}"));
    }
    // A step takes a disc by 8 points of its rim and a verdict by 96: what stands on the latter may tip over the former.
    let has_disc = simulation.model().geoms.iter().any(|geom| matches!(geom.geometry, Geometry::Cylinder { .. }));
    let moved = match has_disc {
        true => energy_part(problem, &ContactSolver::default().solve(problem, None).velocity),
        false => energy_part(problem, &simulation.state().v),
    };
    match verdict {
        Verdict::MustMove if moved < MOVES => Some(format!("the step has {moved:e} of the free motion's energy")),
        Verdict::Stays if moved > RESTS => Some(format!("the step has {moved:e} of the free motion's energy")),
        Verdict::Stands if moved > RESTS => Some(format!("the step moves with {moved:e}: the search missed it")),
        _ => None,
    }
}

#[test]
fn no_verdict_is_contradicted() {
    let read = |name: &str| std::env::var(name).ok().and_then(|text| text.parse().ok());
    let (worlds, first): (u64, u64) =
        (read("SIGNORINI_WORLDS").unwrap_or(WORLDS), read("SIGNORINI_FIRST").unwrap_or(0));
    let all: Vec<Judged> = (first..first + worlds).into_par_iter().map(judged).collect();
    let mut counts = BTreeMap::<&str, usize>::new();
    let mut starts = BTreeMap::<&str, usize>::new();
    all.iter().for_each(|world| *counts.entry(world.verdict).or_default() += 1);
    all.iter().filter_map(|world| world.moves_from).for_each(|start| *starts.entry(start).or_default() += 1);
    println!("{worlds} worlds: {counts:?}; moving solutions first found from {starts:?}");
    let contradicted: Vec<&String> = all.iter().filter_map(|world| world.contradicted.as_ref()).collect();
    contradicted.iter().for_each(|reason| println!("{reason}"));
    assert!(contradicted.is_empty(), "{} verdicts of {worlds} are contradicted", contradicted.len());
    // A few worlds need not have all verdicts.
    let expected = if worlds < WORLDS { &[][..] } else { &["must_move", "stays", "may_do_either"] };
    for &verdict in expected {
        assert!(counts.contains_key(verdict), "no world has the verdict {verdict}: {counts:?}");
    }
}
