//! Contact forces that balance the loads, or the mechanism that says there are none, by an interior-point method in blocks of bodies.
//!
//! The forces of a contact are `Σ y_k g_k`, `y ≥ 0`, over the extreme rays `g_k = (1, μ d_k)` of its cone. The linear program
//!
//! ```text
//! minimise Σ (s⁺ + s⁻)   with   A y + s⁺ − s⁻ = b,   y, s⁺, s⁻ ≥ 0,       b = −M^{-1/2} p
//! maximise bᵀx           with   Aᵀx ≤ 0,   −1 ≤ x ≤ 1
//! ```
//!
//! always has points of both sorts, and `−x` is a virtual motion that opens every contact faster than friction resists. What makes this
//! quicker than a solver of programs is that it need not end: forces that lie inside their cones are put onto `A y = b` by the same
//! factorised system as soon as the way there leaves them inside, and a motion with power is judged at every step.

use signorini_contact::statics::certify_mechanism;
use signorini_contact::{ContactProblem, ContactSolution};

use crate::balance::as_balance;
use crate::impulses::solution_from;
use crate::mechanism::Collapse;
use crate::normal_system::NormalSystem;
use crate::settings::StabilitySettings;

/// Steps of the method at most; commonly it takes five to thirty.
const STEPS: usize = 80;
/// Part of the way to the boundary that a step goes (S. Mehrotra, SIAM J. Optimization 2, 1992, takes 0.9 to 1).
const TO_BOUNDARY: f64 = 0.995;
/// Rounds of refinement towards the balance, as long as each leaves at most half of what is missing.
const ROUNDS: usize = 12;
/// Loads that meet no contact, relative to the largest.
const LOST: f64 = 1e-13;
/// Part of a load along a contact's normal from which the contact counts as pressed.
const PRESSED: f64 = 1e-6;
/// The gap at which a collapse is known, relative to its power.
const COLLAPSED: f64 = 1e-6;

/// What the method found.
pub(crate) enum Forces {
    /// Impulses that balance the loads.
    Balance(Box<ContactSolution>),
    /// A motion that proves the contrary.
    Mechanism(Box<Collapse>),
    /// Neither to the accuracy asked for, or the problem has rows that are no contacts.
    Unknown,
}

/// The method, with memory that problems of one structure share.
#[derive(Default)]
pub(crate) struct ForceSearch {
    system: NormalSystem,
    /// The contacts that may have forces.
    contacts: Vec<usize>,
    /// Their extreme rays, and where each contact's begin.
    rays: Vec<[f64; 3]>,
    offsets: Vec<usize>,
    b: Vec<f64>,
    /// Unit of `b`.
    size: f64,
    /// Whether a mechanism is enough, and not followed to the collapse.
    ends_at_proof: bool,
}

/// A point of the method: forces and what they lack, with multipliers.
struct Point {
    /// `y`, then `s⁺`, then `s⁻`.
    v: Vec<f64>,
    z: Vec<f64>,
    x: Vec<f64>,
}

/// Whether a problem has neither bilateral rows nor friction beside that of contacts.
pub(crate) fn has_contacts_alone(problem: &ContactProblem) -> bool {
    problem.bilateral_violation.is_empty() && problem.friction_groups.is_empty()
}

impl ForceSearch {
    /// Looks for forces and mechanisms of a problem that has contacts alone; a mechanism comes with the collapse.
    pub fn find(&mut self, problem: &ContactProblem, settings: &StabilitySettings) -> Forces {
        self.ends_at_proof = false;
        self.find_either(problem, settings)
    }

    /// The same, but it ends where either is proved: the collapse is any mechanism.
    pub fn find_proof(&mut self, problem: &ContactProblem, settings: &StabilitySettings) -> Forces {
        self.ends_at_proof = true;
        self.find_either(problem, settings)
    }

    fn find_either(&mut self, problem: &ContactProblem, settings: &StabilitySettings) -> Forces {
        if !has_contacts_alone(problem) {
            return Forces::Unknown;
        }
        // Without friction a stack is held by its level faces alone: sides that touch are many, and no load presses on them.
        let pressed = if problem.friction.iter().all(|mu| *mu == 0.0) { pressed(problem) } else { Vec::new() };
        if !pressed.is_empty() && pressed.len() < problem.contact_count() {
            self.contacts = pressed;
            match self.find_among(problem, settings) {
                Forces::Balance(balance) => return Forces::Balance(balance),
                // It is judged against all contacts, but the collapse of these alone may close others.
                Forces::Mechanism(proof) if self.ends_at_proof => return Forces::Mechanism(proof),
                _ => {}
            }
        }
        self.contacts = (0..problem.contact_count()).collect();
        self.find_among(problem, settings)
    }

    /// The same with forces at the chosen contacts; a mechanism is judged against all.
    fn find_among(&mut self, problem: &ContactProblem, settings: &StabilitySettings) -> Forces {
        if !self.read(problem) {
            return Forces::Unknown;
        }
        let mut point = self.begin();
        let mut proof: Option<Collapse> = None;
        for _ in 0..STEPS {
            let residual = self.residual(&point);
            let gap = point.complementarity();
            if let Some(found) = &mut proof {
                found.collapse = self.motion(&point.x);
                if gap * point.v.len() as f64 <= COLLAPSED * self.dot_load(&point.x) {
                    break;
                }
            } else if self.dot_load(&point.x) > 0.0 {
                proof = self.mechanism(problem, &point.x, settings);
                if proof.is_some() && self.ends_at_proof {
                    break;
                }
                if proof.is_none() && self.contacts.len() < problem.contact_count() && self.opens_all(&point.x) {
                    // The chosen contacts have no balance; whether all have one is another question.
                    break;
                }
            }
            if !self.factor(&point) {
                break;
            }
            if proof.is_none()
                && let Some(y) = self.onto_balance(&point)
                && let Some(balance) = self.balance(problem, &y, settings)
            {
                return Forces::Balance(Box::new(balance));
            }
            if !self.step(&mut point, &residual, gap) {
                break;
            }
        }
        proof.map_or(Forces::Unknown, |collapse| Forces::Mechanism(Box::new(collapse)))
    }

    /// Reads the problem; whether every load meets a contact.
    fn read(&mut self, problem: &ContactProblem) -> bool {
        self.system.read(problem, &self.contacts);
        self.rays.clear();
        self.offsets.clear();
        for &i in &self.contacts {
            self.offsets.push(self.rays.len());
            let mu = problem.friction[i];
            let directions = if mu > 0.0 { problem.directions_of(i) } else { &[] };
            self.rays.extend(directions.iter().map(|d| [1.0, mu * d[0], mu * d[1]]));
            if directions.is_empty() {
                self.rays.push([1.0, 0.0, 0.0]);
            }
        }
        self.offsets.push(self.rays.len());
        let mut load = vec![0.0; problem.nv()];
        problem.mass.multiply_into(&problem.free_velocity, &mut load);
        let (b, lost) = self.system.gather(&load);
        let size = b.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        self.size = if size > 0.0 { size } else { 1.0 };
        self.b = b.into_iter().map(|b| -b / self.size).collect();
        lost <= LOST * size
    }

    fn begin(&self) -> Point {
        let (ny, nv) = (self.rays.len(), self.b.len());
        let mut v = vec![1.0; ny + 2 * nv];
        for i in 0..self.offsets.len() - 1 {
            let range = self.offsets[i]..self.offsets[i + 1];
            let count = range.len() as f64;
            v[range].fill(1.0 / count);
        }
        let missing = self.missing(&v[..ny]);
        for (k, r) in missing.iter().enumerate() {
            v[ny + k] = 1.0 + r.max(0.0);
            v[ny + nv + k] = 1.0 + (-r).max(0.0);
        }
        Point { v, z: vec![1.0; ny + 2 * nv], x: vec![0.0; nv] }
    }

    /// The force of a contact.
    fn force(&self, i: usize, y: &[f64]) -> [f64; 3] {
        let mut f = [0.0; 3];
        for k in self.offsets[i]..self.offsets[i + 1] {
            (0..3).for_each(|r| f[r] += self.rays[k][r] * y[k]);
        }
        f
    }

    /// `b − A y`.
    fn missing(&self, y: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.b.len()];
        (0..self.offsets.len() - 1).for_each(|i| self.system.add_transposed(i, self.force(i, y), &mut sum));
        sum.iter().zip(&self.b).map(|(a, b)| b - a).collect()
    }

    /// Calls `f(k, a_kᵀx)` for every ray.
    fn along_rays(&self, x: &[f64], mut f: impl FnMut(usize, f64)) {
        for i in 0..self.offsets.len() - 1 {
            let c = self.system.multiply(i, x);
            for k in self.offsets[i]..self.offsets[i + 1] {
                let g = self.rays[k];
                f(k, g[0] * c[0] + g[1] * c[1] + g[2] * c[2]);
            }
        }
    }

    /// Whether a motion opens all chosen contacts faster than friction resists.
    fn opens_all(&self, x: &[f64]) -> bool {
        let mut opens = true;
        self.along_rays(x, |_, a| opens &= a <= 0.0);
        opens
    }

    fn dot_load(&self, x: &[f64]) -> f64 {
        x.iter().zip(&self.b).map(|(x, b)| x * b).sum()
    }

    /// What is missing of `A y + s⁺ − s⁻ = b`, and of the dual equations, `[ny + 2 nv]`.
    fn residual(&self, point: &Point) -> (Vec<f64>, Vec<f64>) {
        let (ny, nv) = (self.rays.len(), self.b.len());
        let mut primal = self.missing(&point.v[..ny]);
        let mut dual: Vec<f64> = point.z.iter().map(|z| -z).collect();
        for k in 0..nv {
            primal[k] -= point.v[ny + k] - point.v[ny + nv + k];
            dual[ny + k] += 1.0 - point.x[k];
            dual[ny + nv + k] += 1.0 + point.x[k];
        }
        self.along_rays(&point.x, |k, a| dual[k] -= a);
        (primal, dual)
    }

    /// Factorises the system with the weights `v / z`.
    fn factor(&mut self, point: &Point) -> bool {
        let (ny, nv) = (self.rays.len(), self.b.len());
        let weights: Vec<[[f64; 3]; 3]> = (0..self.offsets.len() - 1)
            .map(|i| {
                let mut weight = [[0.0; 3]; 3];
                for k in self.offsets[i]..self.offsets[i + 1] {
                    let (g, w) = (self.rays[k], point.v[k] / point.z[k]);
                    (0..3).for_each(|r| (0..3).for_each(|s| weight[r][s] += w * g[r] * g[s]));
                }
                weight
            })
            .collect();
        let ratio = |k: usize| point.v[k] / point.z[k];
        let diagonal: Vec<f64> = (0..nv).map(|k| ratio(ny + k) + ratio(ny + nv + k)).collect();
        self.system.factor(&weights, &diagonal)
    }

    /// The step for complementarity products `products`: `(Δx, Δv, Δz)`.
    fn direction(
        &mut self,
        point: &Point,
        (primal, dual): &(Vec<f64>, Vec<f64>),
        products: &[f64],
    ) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let (ny, nv) = (self.rays.len(), self.b.len());
        // Δv = t + (v / z) aᵀΔx.
        let mut change: Vec<f64> =
            (0..point.v.len()).map(|k| (products[k] - point.v[k] * dual[k]) / point.z[k]).collect();
        let mut x = primal.clone();
        for i in 0..self.offsets.len() - 1 {
            self.system.add_transposed(i, self.force(i, &change).map(|f| -f), &mut x);
        }
        (0..nv).for_each(|k| x[k] -= change[ny + k] - change[ny + nv + k]);
        self.system.solve(&mut x);
        let mut dz = dual.clone();
        let mut take = |k: usize, a: f64| {
            change[k] += point.v[k] / point.z[k] * a;
            dz[k] -= a;
        };
        self.along_rays(&x, &mut take);
        for k in 0..nv {
            take(ny + k, x[k]);
            take(ny + nv + k, -x[k]);
        }
        (x, change, dz)
    }

    /// One step of predictor and corrector; whether it went anywhere.
    fn step(&mut self, point: &mut Point, residual: &(Vec<f64>, Vec<f64>), gap: f64) -> bool {
        let count = point.v.len();
        let mut products: Vec<f64> = (0..count).map(|k| -point.v[k] * point.z[k]).collect();
        let (_, dv, dz) = self.direction(point, residual, &products);
        let (a, b) = (longest(&point.v, &dv), longest(&point.z, &dz));
        let ahead = (0..count).map(|k| (point.v[k] + a * dv[k]) * (point.z[k] + b * dz[k])).sum::<f64>() / count as f64;
        let centre = (ahead / gap).powi(3) * gap;
        (0..count).for_each(|k| products[k] += centre - dv[k] * dz[k]);
        let (dx, dv, dz) = self.direction(point, residual, &products);
        let (a, b) = (TO_BOUNDARY * longest(&point.v, &dv), TO_BOUNDARY * longest(&point.z, &dz));
        let (a, b) = (a.min(1.0), b.min(1.0));
        let add = |x: &mut [f64], length: f64, d: &[f64]| x.iter_mut().zip(d).for_each(|(x, d)| *x += length * d);
        add(&mut point.v, a, &dv);
        add(&mut point.z, b, &dz);
        add(&mut point.x, b, &dx);
        let finite = point.v.iter().chain(&point.z).chain(&point.x).all(|x| x.is_finite());
        finite && a.max(b) > 1e-10
    }

    /// Forces on `A y = b` near those of a point, if the way there stays inside the cones.
    fn onto_balance(&mut self, point: &Point) -> Option<Vec<f64>> {
        let ny = self.rays.len();
        let (v, z) = (&point.v, &point.z);
        // A ray with more multiplier than force has none in any balance: a side that touches and that nothing presses.
        let mut y: Vec<f64> = (0..ny).map(|k| if v[k] > z[k] { v[k] } else { 0.0 }).collect();
        let mut last = f64::INFINITY;
        for _ in 0..ROUNDS {
            let mut missing = self.missing(&y);
            let size = missing.iter().fold(0.0, |a: f64, r| a.max(r.abs()));
            if !size.is_finite() || size > 0.5 * last {
                break;
            }
            last = size;
            self.system.solve(&mut missing);
            let mut inside = true;
            self.along_rays(&missing, |k, a| {
                if v[k] > z[k] {
                    y[k] += v[k] / z[k] * a;
                    inside &= y[k] >= 0.0;
                }
            });
            if !inside {
                return None;
            }
        }
        (last <= 1e-12).then_some(y)
    }

    /// Forces as a balance, if they are one.
    fn balance(&self, problem: &ContactProblem, y: &[f64], settings: &StabilitySettings) -> Option<ContactSolution> {
        let mut alpha = vec![0.0; problem.direction_count()];
        let mut lambda = vec![0.0; problem.contact_count()];
        for (c, &i) in self.contacts.iter().enumerate() {
            let range = self.offsets[c]..self.offsets[c + 1];
            lambda[i] = self.size * y[range.clone()].iter().sum::<f64>();
            if problem.friction[i] > 0.0 && !problem.directions_of(i).is_empty() {
                let own = alpha[problem.direction_offsets[i]..].iter_mut();
                own.zip(&y[range]).for_each(|(a, y)| *a = problem.friction[i] * self.size * y);
            }
        }
        as_balance(problem, &solution_from(problem, &lambda, &alpha, &[], &[]), settings)
    }

    /// The virtual motion of a dual point, m/s or rad/s.
    fn motion(&self, x: &[f64]) -> Vec<f64> {
        let mut motion = self.system.scatter(x);
        motion.iter_mut().for_each(|x| *x = -*x);
        motion
    }

    fn mechanism(&self, problem: &ContactProblem, x: &[f64], settings: &StabilitySettings) -> Option<Collapse> {
        let motion = self.motion(x);
        let certificate = certify_mechanism(problem, &motion);
        let proves = certificate.residual <= settings.tolerance;
        proves.then(|| Collapse { collapse: motion.clone(), motion, certificate })
    }
}

impl Point {
    fn complementarity(&self) -> f64 {
        self.v.iter().zip(&self.z).map(|(v, z)| v * z).sum::<f64>() / self.v.len() as f64
    }
}

/// The longest step along `d` on which `x` stays positive, 1 at most.
fn longest(x: &[f64], d: &[f64]) -> f64 {
    x.iter().zip(d).filter(|(_, d)| **d < 0.0).map(|(x, d)| -x / d).fold(1.0 / TO_BOUNDARY, f64::min)
}

/// Contacts along whose normal one of its bodies is loaded.
fn pressed(problem: &ContactProblem) -> Vec<usize> {
    let free = &problem.free_velocity;
    let is_pressed = |&i: &usize| {
        let (columns, entries) = problem.jacobian.group(i);
        let along = columns.iter().zip(entries).map(|(&k, e)| (e[0], free[k as usize]));
        let [mut power, mut row, mut load] = [0.0_f64; 3];
        for (e, v) in along {
            (power, row, load) = (power.max((e * v).abs()), row.max(e.abs()), load.max(v.abs()));
        }
        power > PRESSED * row * load
    };
    (0..problem.contact_count()).filter(is_pressed).collect()
}
