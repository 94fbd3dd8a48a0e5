//! How often derivatives of steps exist, on the bundled scenes and on random ones, and whether one that is called exact was ever wrong.

use std::collections::BTreeMap;
use std::error::Error;

use signorini::derivatives::Validity;
use signorini::multibody::{ContactPoint, GeomId, Input, Model, ModelError, State};
use signorini_benchmarks::derivative_scenes;
use signorini_formats::load_mjcf_str;
use signorini_testkit::Random;

use crate::Options;
use crate::bench::{Bench, Unit};

/// Widths of differences, as parts of a change as large as a step makes, in the order in which they are taken: the first is narrow enough to stay
/// in nearly all modes and wide enough for the rounding of a step; wider and narrower ones are taken where it does not agree.
const WIDTHS: [f64; 6] = [1e-6, 1e-7, 1e-5, 1e-8, 1e-4, 1e-3];
/// Differences ahead and behind are both this near to a derivative at one width, relative to its largest entry.
const AGREES: f64 = 1e-4;
/// What the residual of a step, 1e-9, leaves open in its velocity, relative to the largest number of a derivative or 1.
const RESIDUAL: f64 = 1e-7;

type Scene = fn(&mut Random) -> Result<Model, ModelError>;

/// Kinds of random scenes.
const RANDOM: [(&str, Scene); 2] =
    [("random bodies", derivative_scenes::bodies), ("mechanisms", derivative_scenes::mechanism)];

/// Counts the verdicts of all scenes; how many that said exact were wrong.
pub fn count(options: &Options) -> Result<u64, Box<dyn Error>> {
    let head = ["own run: exact/one/ref.", "disturbed"];
    println!("{:<16} {:>24}   {:>24}   checked  wrong unresolved", "", head[0], head[1]);
    let mut wrong = 0;
    for scene in &signorini_scenes::SCENES {
        let mut run = Run::new(load_mjcf_str(scene.text, ".")?.model, options.twice)?;
        run.all(options.steps, &mut Random::new(1));
        wrong += run.counts.report(scene.name, options.why);
    }
    for (name, scene) in RANDOM {
        let mut sum = Counts::default();
        for seed in options.first..options.first + options.scenes {
            let mut random = Random::new(seed);
            let mut run = Run::new(scene(&mut random)?, options.twice)?;
            run.all(if options.smoke { 40 } else { 200 }, &mut random);
            if run.counts.wrong + run.counts.unresolved > 0 {
                println!("{name} {seed}: {} wrong, {} unresolved", run.counts.wrong, run.counts.unresolved);
            }
            sum.add(run.counts);
            if (seed + 1 - options.first).is_multiple_of(100) {
                sum.report(name, false);
            }
        }
        wrong += sum.report(name, options.why);
    }
    Ok(wrong)
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
    bench: Bench,
    counts: Counts,
}

impl Run {
    fn new(model: Model, twice: bool) -> Result<Self, Box<dyn Error>> {
        let mut bench = Bench::new(model)?;
        if twice {
            bench.derivatives = bench.derivatives.asking_twice();
        }
        Ok(Self { bench, counts: Counts::default() })
    }

    /// Every step of a run, and every fourth beside it.
    fn all(&mut self, steps: u32, random: &mut Random) {
        let (mut state, input) = self.bench.start();
        for n in 0..steps {
            if n % 4 == 3 {
                let change = self.bench.change(random);
                let part = random.between(0.0, 0.1);
                let (near, with) = self.bench.moved(&state, &input, &change, part);
                if let Some(counts) = self.judge(&near, &with, random) {
                    self.counts.disturbed[counts] += 1;
                }
            }
            if let Some(counts) = self.judge(&state, &input, random) {
                self.counts.own[counts] += 1;
            }
            let Some((next, _)) = self.bench.step(&state, &input) else { return };
            state = next;
        }
    }

    /// Whether the derivative is exact (0), one-sided (1), refused (2); compares exact ones with differences.
    fn judge(&mut self, state: &State, input: &Input, random: &mut Random) -> Option<usize> {
        let next = self.bench.differentiate(state, input)?;
        match self.bench.derivatives.validity() {
            Validity::Exact => {
                let change = self.bench.change(random);
                let product = self.bench.derivatives.product(&change).unwrap_or_default();
                self.counts.checked += 1;
                let signature = self.bench.signature();
                let end = (&next, &signature[..]);
                let mut errors = Vec::new();
                for (beside, h) in [false, true].iter().flat_map(|beside| WIDTHS.map(|h| (*beside, h))) {
                    let found = self.error((state, input), end, (&change, &product), h, beside);
                    errors.push((h, found));
                    if found.0 <= AGREES {
                        return Some(0);
                    }
                }
                self.blame((state, input), end, &change, &errors);
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

    /// Counts a derivative with which no difference agrees, and says along which coordinates.
    fn blame(
        &mut self,
        given: (&State, &Input),
        end: (&State, &[Unit]),
        change: &[f64],
        errors: &[(f64, (f64, bool))],
    ) {
        let stays = errors.iter().any(|(_, (_, stays))| *stays);
        let nearest = self.bench.derivatives.margins().iter().min_by(|a, b| a.value.total_cmp(&b.value)).copied();
        let verdict = if stays { "wrong" } else { "no width stays in the mode" };
        println!("{verdict}: {errors:?}, nearest {nearest:?}");
        let (nv, nu) = (self.bench.model.nv, self.bench.model.actuators.len());
        for k in 0..3 * nv + nu {
            let mut change = vec![0.0; 3 * nv + nu];
            change[k] = if k < nv { self.bench.model.timestep } else { 1.0 };
            let product = self.bench.derivatives.product(&change).unwrap_or_default();
            let found = WIDTHS.map(|h| self.error(given, end, (&change, &product), h, false).0);
            let least = found.into_iter().fold(f64::INFINITY, f64::min);
            if least > AGREES {
                let kind = ["q", "v", "u", "τ"]
                    [usize::from(k >= nv) + usize::from(k >= 2 * nv) + usize::from(k >= 2 * nv + nu)];
                println!("    along {kind}, {k}: off by {least:.1e}");
            }
        }
        let still = vec![0.0; 3 * nv + nu];
        for (name, change) in [("the same step again", &still[..]), ("a step beside it", change)] {
            let (state, input) = self.bench.moved(given.0, given.1, change, WIDTHS[3]);
            let Some((next, _)) = self.bench.step(&state, &input) else { continue };
            let off = next.v.iter().zip(&end.0.v).map(|(a, b)| (a - b).abs()).enumerate();
            let (k, off) = off.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
            let [begin, found, own] = [given.0.v[k], next.v[k], end.0.v[k]];
            println!("    {name}: velocity {k} of {begin:.3e} becomes {found:.3e}, was {own:.3e}, off by {off:.1e}");
        }
        if self.bench.step(given.0, given.1).is_some() {
            println!("{}", self.story());
        }
        if stays {
            self.counts.wrong += 1;
        } else {
            self.counts.unresolved += 1;
        }
    }

    /// What the contacts of the last step do.
    fn story(&self) -> String {
        let (problem, solution) = (self.bench.workspace.problem(), self.bench.workspace.solution());
        let kind = |id: GeomId| self.bench.model.geoms[id.index()].geometry.kind_name();
        let of = |(i, point): (usize, &ContactPoint)| {
            let [a, b] = [point.geom_a, point.geom_b].map(kind);
            let (mode, gap, impulse) = (solution.modes[i], problem.gap[i], solution.lambda_n[i]);
            format!("    {i} {a} on {b}: {mode:?}, gap {:.1e} taken as {gap:.1e}, impulse {impulse:.1e}", point.gap)
        };
        self.bench.workspace.contact_points().iter().enumerate().map(of).collect::<Vec<_>>().join("\n")
    }

    /// How far differences of this width ahead and behind are from the product, relative to its largest entry, the larger of the two, and
    /// whether both are in the mode. They are taken from the step itself or, `beside` it, from one at the width to one at twice the width, so that
    /// the residual of the step itself, up to [`RESIDUAL`], is in none of them.
    fn error(
        &mut self,
        given: (&State, &Input),
        (next, signature): (&State, &[Unit]),
        (change, product): (&[f64], &[f64]),
        h: f64,
        beside: bool,
    ) -> (f64, bool) {
        let size = product.iter().fold(f64::MIN_POSITIVE, |s, x| s.max(x.abs()));
        let (mut worst, mut stays) = (0.0_f64, true);
        for way in [h, -h] {
            let Some(far) = self.bench.end(given, next, change, if beside { 2.0 * way } else { way }) else {
                return (f64::INFINITY, false);
            };
            stays &= self.bench.signature() == signature;
            let mut near = vec![0.0; far.len()];
            if beside {
                let Some(found) = self.bench.end(given, next, change, way) else { return (f64::INFINITY, false) };
                stays &= self.bench.signature() == signature;
                let jump = found.iter().zip(product).fold(0.0, |s: f64, (x, y)| s.max((x - way * y).abs()));
                if jump > RESIDUAL * size.max(1.0) {
                    return (f64::INFINITY, stays);
                }
                near = found;
            }
            let off = far.iter().zip(&near).zip(product).map(|((far, near), x)| ((far - near) / way - x).abs());
            worst = off.fold(worst, |s, x| if x <= s { s } else { x });
        }
        (worst / size, stays)
    }
}
