//! The warm start of a whole problem, and the islands that it solves already.
//!
//! At rest a step is like the one before it: its impulses satisfy the laws of the next one to rounding. An island of which that is
//! true is not even assembled. Where it rests, its velocity is zero, and not what is left when weight and impulses cancel: that
//! would move bodies by a last digit from time to time, which the next steps would have to take back. Nothing is remembered for
//! it beside the warm start, so that any change sets the island in motion.

use signorini_contact::projection::{Cones, Mode};
use signorini_contact::scales::raise;
use signorini_contact::{ContactProblem, ContactSolution, WarmStart};

use crate::islands::{Island, Islands};
use crate::iterate::Iterate;
use crate::residual::{RESIDUALS, is_exact, law_residual};
use crate::settings::SolverSettings;
use crate::task::{SIZES, accepted_closely};

/// A warm start in the terms of the problem at hand.
#[derive(Clone, Debug, Default)]
pub(crate) struct GivenStart {
    /// Impulse and mode of each unit of the problem: contacts, then friction groups.
    pub impulse: Vec<[f64; 3]>,
    pub modes: Vec<Mode>,
    /// Of each bilateral row.
    pub bilateral: Vec<f64>,
    /// The velocity that the impulses give, over all degrees of freedom.
    pub velocity: Vec<f64>,
    /// Whether few of the modes are wrong: [`WarmStart::nearly_solves`].
    pub nearly_solves: bool,
    /// That of each contact along its rows, zero where its island rests, if its island [holds](Self::hold).
    pub rates: Vec<[f64; 3]>,
    islands: Vec<Held>,
}

/// What the impulses do in an island.
#[derive(Clone, Copy, Debug, Default)]
struct Held {
    /// Whether its laws hold with the velocity that they give, as far as is known.
    holds: bool,
    /// Whether that velocity is zero to rounding, and the laws hold with zero, too.
    rests: bool,
    /// The largest error, and what it may be in motion and at rest, m/s.
    residual: f64,
    most: f64,
    most_at_rest: f64,
    /// Contacts and friction groups in it, and blocks of the mass matrix.
    units: usize,
    blocks: usize,
    /// The largest entry of an impulse, and of the Delassus diagonals.
    largest: f64,
    scale: f64,
}

impl GivenStart {
    /// Reads a start; `false` if it is that of a problem with another number of contacts.
    pub fn read(&mut self, problem: &ContactProblem, cones: &Cones, islands: &Islands, warm: &WarmStart) -> bool {
        let nc = problem.contact_count();
        if warm.contacts.len() != nc {
            return false;
        }
        self.nearly_solves = warm.nearly_solves;
        self.impulse.clear();
        self.modes.clear();
        self.velocity.clear();
        self.velocity.resize(problem.nv(), 0.0);
        for (i, entry) in warm.contacts.iter().enumerate() {
            let (impulse, mode) = entry.filter(|_| islands.of_unit(i).is_some()).unwrap_or(([0.0; 3], Mode::Open));
            let pushing = self.push(cones, impulse, mode);
            problem.jacobian.add_transposed(i, pushing, &mut self.velocity);
        }
        for (j, bound) in problem.friction_groups.bound.iter().enumerate() {
            let entry = warm.groups.get(j).copied().flatten().filter(|_| islands.of_unit(nc + j).is_some());
            let ([_, a, b], mode) = entry.unwrap_or(([0.0; 3], Mode::Open));
            let bound = bound.normal().map_or(bound.constant(), |(contact, _)| self.impulse[contact][0]);
            let [_, a, b] = self.push(cones, [bound, a, b], mode);
            problem.friction_groups.jacobian.add_transposed(j, [a, b], &mut self.velocity);
        }
        self.bilateral.clear();
        self.bilateral.resize(problem.bilateral_violation.len(), 0.0);
        if warm.bilateral.len() == self.bilateral.len() {
            self.bilateral.copy_from_slice(&warm.bilateral);
        }
        for (k, &p) in self.bilateral.iter().enumerate() {
            problem.bilateral_jacobian.add_transposed(k, [p], &mut self.velocity);
        }
        // `v = v^f + M⁻¹ Jᵀ λ`.
        problem.mass_factor.solve_in_place(&mut self.velocity);
        self.velocity.iter_mut().zip(&problem.free_velocity).for_each(|(v, f)| *v += f);
        true
    }

    /// Gives an island its part of the start.
    pub fn give(&self, problem: &ContactProblem, island: &Island, iterate: &mut Iterate) {
        iterate.clear(problem, island);
        iterate.modes.extend(island.units.iter().map(|&i| self.modes[i as usize]));
        for (impulse, &i) in iterate.impulse.iter_mut().zip(&island.units) {
            *impulse = self.impulse[i as usize];
        }
        for (impulse, &i) in iterate.bilateral.iter_mut().zip(&island.bilateral) {
            *impulse = self.bilateral[i as usize];
        }
        island.gather(&self.velocity, &mut iterate.velocity);
    }

    /// Takes the next unit's impulse, brought into its cone.
    #[inline]
    fn push(&mut self, cones: &Cones, impulse: [f64; 3], mode: Mode) -> [f64; 3] {
        let i = self.impulse.len();
        self.modes.push(cones.nearest_valid(i, mode));
        let impulse = cones.project(i, cones.mode_at(i, impulse), impulse);
        self.impulse.push(impulse);
        impulse
    }

    /// Writes what the impulses do where they solve an island already, and its residual; how many islands that are.
    pub fn hold(
        &mut self,
        problem: &ContactProblem,
        cones: &Cones,
        islands: &Islands,
        settings: &SolverSettings,
        solution: &mut ContactSolution,
        residuals: &mut [f64],
    ) -> u32 {
        self.islands.clear();
        let scales = (0..residuals.len()).map(|k| islands.scale_of(k));
        let held = |scale| Held { holds: scale > 0.0, rests: true, ..Held::default() };
        self.islands.extend(scales.map(held));
        self.count_parts(problem, islands);
        self.limit_errors(islands, settings);
        self.look_for_motion(problem, islands);
        self.check_laws(problem, cones, islands);
        let mut count = 0;
        for (k, held) in self.islands.iter_mut().enumerate() {
            let scale = islands.scale_of(k);
            held.holds = held.holds && held.needs_no_refinement(scale);
            if held.holds {
                (residuals[k], count) = (held.residual / scale, count + 1);
            }
        }
        if count > 0 {
            self.write(problem, islands, solution);
        }
        count
    }

    /// How many islands [hold](Self::hold) at rest.
    pub fn resting(&self) -> usize {
        self.islands.iter().filter(|held| held.holds && held.rests).count()
    }

    /// Makes the residuals of the islands that [hold](Self::hold) unknown, so that they are solved.
    pub fn let_go(&self, residuals: &mut [f64]) {
        let held = residuals.iter_mut().zip(&self.islands).filter(|(_, held)| held.holds);
        held.for_each(|(residual, _)| *residual = f64::INFINITY);
    }

    fn count_parts(&mut self, problem: &ContactProblem, islands: &Islands) {
        for k in (0..self.impulse.len()).filter_map(|i| islands.of_unit(i)) {
            self.islands[k].units += 1;
        }
        for k in (0..problem.mass.blocks().len()).filter_map(|b| islands.of_block(b)) {
            self.islands[k].blocks += 1;
        }
    }

    /// Rounding adds up: at rest from body to body of a stack, so that a velocity that its contacts permit would move what lies on top, and the next step,
    /// which takes that back, leave impulses that the one after it has to; in a large island of gaps metres above the ground, too, and of impulses that carry
    /// many bodies. What rests may lack so much more: with velocity zero it lacks no more in the next step. In a large island it may lack what counts as solved,
    /// as the last digits of a heap, in which sticking contacts contradict each other by their rounding, would cost a cold solve in every step.
    fn limit_errors(&mut self, islands: &Islands, settings: &SolverSettings) {
        for (k, held) in self.islands.iter_mut().enumerate() {
            let scale = islands.scale_of(k);
            let polished = settings.polish * scale;
            let rounded = RESIDUALS.rounded * polished;
            (held.most, held.most_at_rest) = (polished, if held.blocks > 1 { rounded } else { polished });
            if held.units >= SIZES.large {
                let closely = accepted_closely(held.units, settings).min(SIZES.closely[1] * SIZES.rough);
                (held.most, held.most_at_rest) = (rounded, rounded.max(closely * scale));
            }
        }
    }

    /// Which islands have momentum above rounding.
    fn look_for_motion(&mut self, problem: &ContactProblem, islands: &Islands) {
        for (b, block) in problem.mass.blocks().iter().enumerate() {
            let Some(k) = islands.of_block(b).filter(|&k| self.islands[k].rests) else { continue };
            let (mass, v) = (problem.mass.block_data(b), &self.velocity[block.range()]);
            let most = self.islands[k].most_at_rest;
            self.islands[k].rests = match block.size {
                1 => (mass[0] * v[0]).abs() <= most * mass[0],
                3 => is_still::<3>(mass, v, most),
                6 => is_still::<6>(mass, v, most),
                _ => is_still_in(mass, v, most),
            };
        }
    }

    /// The laws of all units and bilateral rows, as long as those of an island hold.
    fn check_laws(&mut self, problem: &ContactProblem, cones: &Cones, islands: &Islands) {
        let (nc, v) = (problem.contact_count(), &self.velocity);
        let g = islands.residual_scale();
        self.rates.clear();
        self.rates.resize(nc, [0.0; 3]);
        for (i, (&p, rates)) in self.impulse.iter().zip(&mut self.rates).enumerate() {
            let Some(k) = islands.of_unit(i) else { continue };
            let held = &mut self.islands[k];
            if !held.holds {
                continue;
            }
            let terms;
            (*rates, terms) = if held.rests {
                problem.jacobian.multiply_with_terms(i, v)
            } else {
                (problem.jacobian.multiply(i, v), 0.0)
            };
            let ([c, c_1, c_2], offset) = (*rates, problem.gap[i] / problem.timestep);
            held.take(law_residual(cones, i, p, [c + offset, c_1, c_2], g), p, islands.delassus_of(i));
            // At rest nothing slides, and the impulse is in its cone.
            held.rests &= terms <= held.most_at_rest && (g * p[0]).min(offset).abs() <= held.most_at_rest;
        }
        for (j, target) in problem.friction_groups.target.iter().enumerate() {
            let Some(k) = islands.of_unit(nc + j).filter(|&k| self.islands[k].holds) else { continue };
            let (held, p) = (&mut self.islands[k], self.impulse[nc + j]);
            let ([c_1, c_2], terms) = problem.friction_groups.jacobian.multiply_with_terms(j, v);
            let residual = |u_1: f64, u_2: f64| law_residual(cones, nc + j, p, [0.0, u_1, u_2], g);
            held.take(residual(c_1 - target[0], c_2 - target[1]), p, islands.delassus_of(nc + j));
            let at_rest = terms.max(residual(-target[0], -target[1]));
            held.rests = held.rests && at_rest <= held.most_at_rest;
        }
        for row in 0..self.bilateral.len() {
            let Some(k) = islands.of_bilateral(row).filter(|&k| self.islands[k].holds) else { continue };
            let held = &mut self.islands[k];
            let ([c], terms) = problem.bilateral_jacobian.multiply_with_terms(row, v);
            let offset = problem.bilateral_violation[row] / problem.timestep;
            held.take((c + offset).abs(), [0.0; 3], 0.0);
            held.rests &= terms.max(offset.abs()) <= held.most_at_rest;
        }
    }

    /// Gives the solution the islands that hold.
    fn write(&mut self, problem: &ContactProblem, islands: &Islands, solution: &mut ContactSolution) {
        let Self { impulse, modes, bilateral, velocity, rates, islands: found, .. } = self;
        let nc = rates.len();
        let holds = |k: Option<usize>| k.map(|k| found[k]).filter(|held| held.holds);
        let written = solution.impulse.iter_mut().zip(&mut solution.solver_modes);
        let contacts = written.zip(rates).zip(impulse.iter().zip(&*modes)).enumerate();
        for (i, (((to, to_mode), rates), (impulse, mode))) in contacts {
            let Some(held) = holds(islands.of_unit(i)) else { continue };
            (*to, *to_mode) = (*impulse, *mode);
            if held.rests {
                *rates = [0.0; 3];
            }
        }
        for i in (nc..impulse.len()).filter(|&i| holds(islands.of_unit(i)).is_some()) {
            solution.take_unit(i, impulse[i], modes[i]);
        }
        for i in (0..bilateral.len()).filter(|&i| holds(islands.of_bilateral(i)).is_some()) {
            solution.bilateral[i] = bilateral[i];
        }
        for (b, block) in problem.mass.blocks().iter().enumerate() {
            let Some(held) = holds(islands.of_block(b)) else { continue };
            let written = &mut solution.velocity[block.range()];
            if held.rests {
                written.fill(0.0);
            } else {
                written.copy_from_slice(&velocity[block.range()]);
            }
        }
    }
}

impl Held {
    /// Whether the velocity of the impulses needs no refinement, where the laws hold with it. In a small island a factorisation for
    /// it costs several times what the start costs: what the iterations stop at is enough, if the dissipation law does not see it.
    fn needs_no_refinement(&self, scale: f64) -> bool {
        let (residual, size) = (self.residual / scale, self.largest * self.scale / scale);
        let is_enough = is_exact(residual, size) || self.units < SIZES.large && residual * size <= RESIDUALS.exact_work;
        self.rests || self.residual <= self.most && is_enough
    }

    /// Takes in a unit's residual, its impulse, and the largest entry of its Delassus diagonal.
    #[inline]
    fn take(&mut self, residual: f64, impulse: [f64; 3], delassus: f64) {
        raise(&mut self.residual, residual);
        // A velocity that is no number holds nothing.
        self.holds = residual <= if self.rests { self.most_at_rest } else { self.most };
        impulse.iter().for_each(|p| raise(&mut self.largest, p.abs()));
        raise(&mut self.scale, delassus);
    }
}

/// Whether a block of the mass matrix has no momentum above `most` times its largest entry.
#[inline]
fn is_still_in(mass: &[f64], v: &[f64], most: f64) -> bool {
    let mut largest = 0.0;
    (0..v.len()).for_each(|i| raise(&mut largest, mass[i * (v.len() + 1)]));
    let most = most * largest;
    mass.chunks_exact(v.len()).all(|row| row.iter().zip(v).map(|(m, v)| m * v).sum::<f64>().abs() <= most)
}

/// The same for a block of `N` rows.
fn is_still<const N: usize>(mass: &[f64], v: &[f64], most: f64) -> bool {
    let sized = mass.first_chunk::<N>().and(v.first_chunk::<N>());
    sized.is_some_and(|v| is_still_in(&mass[..N * N], v, most))
}
