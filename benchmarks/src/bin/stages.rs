//! Counts what every stage of the structured solver does on bundled problems: the public list, cold and from the solution of a problem
//! nearby, and families in which the later stages have something to do. Fails where a stage was never asked, or never ended an island:
//! then it is dead, or what it is for is missing here.

use std::error::Error;

use clap::Parser;
use signorini::contact::{ContactProblem, ContactSolver, SolverSettings, StageCounts, WarmStart};
use signorini_testkit::suite::entries;
use signorini_testkit::{Gap, Motion, Parameters, Random, articulated, families};

/// Counts what every stage of the structured solver does.
#[derive(Parser)]
struct Options {
    /// Problems of each family
    #[arg(long, default_value_t = 20)]
    problems: u64,
    /// Contacts of a problem of the list at most
    #[arg(long, default_value_t = 300)]
    contacts: usize,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let mut counter = Counter::new()?;
    for (seed, entry) in (0..).zip(entries()) {
        let problem = entry.problem(seed);
        if problem.contact_count() <= options.contacts {
            counter.solve(problem, &mut Random::new(u64::from(seed)));
        }
    }
    counter.report("the public list");
    for (name, make) in FAMILIES {
        for seed in 0..options.problems {
            counter.solve(make(seed), &mut Random::new(seed));
        }
        counter.report(name);
    }
    let idle = |ended: bool| {
        let stages = counter.sum.iter().filter(|(_, count)| if ended { count.ended == 0 } else { count.asked == 0 });
        stages.map(|(stage, _)| stage.name()).collect::<Vec<_>>().join(", ")
    };
    match (idle(false), idle(true)) {
        (asked, _) if !asked.is_empty() => Err(format!("never asked: {asked}").into()),
        (_, ended) if !ended.is_empty() => Err(format!("never ended an island: {ended}").into()),
        _ => {
            println!("every stage was asked and ended islands");
            Ok(())
        }
    }
}

/// A family by name, and its problems by their seed.
type Family = (&'static str, fn(u64) -> ContactProblem);

const FAMILIES: [Family; 5] = [
    ("robots on their feet", |seed| {
        let mut random = Random::new(4_000 + seed);
        let parameters = Parameters { friction: 0.4, copies: 1, ..Parameters::random(&mut random) };
        articulated(&mut random, &parameters, 12, 1)
    }),
    ("wedges that overlap", |seed| {
        let mut random = Random::new(seed);
        let parameters = Parameters { friction: 0.9, gap: Gap::Negative, ..Parameters::random(&mut random) };
        families::wedge(&mut random, &parameters, 0.6, 3)
    }),
    ("clusters that slide", |seed| cluster(seed, Motion::Slide, Gap::Zero)),
    ("clusters that tumble", |seed| cluster(seed, Motion::Random, Gap::Mixed)),
    ("clusters that fall upwards", |seed| {
        let mut problem = cluster(seed, Motion::Rest, Gap::Positive);
        problem.free_velocity.iter_mut().for_each(|v| *v = -*v);
        problem
    }),
];

/// 40 to 100 bodies.
fn cluster(seed: u64, motion: Motion, gap: Gap) -> ContactProblem {
    let mut random = Random::new(2_900 + seed);
    let parameters = Parameters { directions: 8, motion, gap, ..Parameters::default() };
    families::cluster(&mut random, &parameters, 40 + seed as usize % 4 * 20)
}

/// Solves problems and counts.
struct Counter {
    solver: ContactSolver,
    /// With so few iterations that large islands come to the last stages, too: with the settings as they are, none of 643 clusters did.
    hurried: ContactSolver,
    /// With contact sweeps in all large islands: by themselves they are for thousands of contacts.
    sweeper: ContactSolver,
    /// Since the last report, and of all.
    counts: StageCounts,
    sum: StageCounts,
}

impl Counter {
    fn new() -> Result<Self, Box<dyn Error>> {
        let settings = SolverSettings::default().with_time_stages(true);
        let solver = ContactSolver::new(settings.clone())?;
        let hurried = ContactSolver::new(settings.clone().with_max_proximal_iterations(1))?;
        let sweeper = ContactSolver::new(settings.with_sweeps_from(64))?;
        Ok(Self { solver, hurried, sweeper, counts: StageCounts::default(), sum: StageCounts::default() })
    }

    /// Solves a problem cold, again from its solution, in a hurry, by sweeps, and one nearby from there.
    fn solve(&mut self, mut problem: ContactProblem, random: &mut Random) {
        let cold = self.solver.solve(&problem, None);
        let start = WarmStart::from_solution(&cold);
        let warm = self.solver.solve(&problem, Some(&start));
        let hurried = self.hurried.solve(&problem, None);
        let swept = self.sweeper.solve(&problem, None);
        let scale = 0.1 * problem.velocity_scale();
        problem.free_velocity.iter_mut().for_each(|v| *v += scale * random.normal());
        let nearby = self.solver.solve(&problem, Some(&start));
        [cold, warm, hurried, swept, nearby].iter().for_each(|solution| self.counts.add(&solution.report.stages));
    }

    fn report(&mut self, name: &str) {
        println!("{name}");
        for (stage, count) in self.counts.iter().filter(|(_, count)| count.asked > 0) {
            let share = 100.0 * self.counts.time_share(stage).unwrap_or(0.0);
            println!(
                "  {:14} asked {:6}  ended {:6}  {share:5.1} % of the time",
                stage.name(),
                count.asked,
                count.ended
            );
        }
        self.sum.add(&self.counts);
        self.counts = StageCounts::default();
    }
}
