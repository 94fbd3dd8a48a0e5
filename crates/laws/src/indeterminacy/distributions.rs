//! The set of all impulses that solve a contact problem with the same velocity.

use super::faces::{admissible_impulses, generalized_impulse, project_impulses};
use super::ranges::{ForceDistributions, ImpulseRange, POSITIVE, SelfStress};
use super::row_space::{Row, distance, orthonormal};
use super::simplex::{Maximum, Simplex};
use crate::polyhedral::{Group, Groups, ImpulseCones};
use signorini_contact::certificate::{certify, tangential_impulse};
use signorini_contact::{ContactProblem, ContactSolution, ProblemError};

/// Solutions with a larger residual are refused: what they admit would not be what the data admit.
const LARGEST_RESIDUAL: f64 = 1e-6;
/// An impulse varies over the set where its row is further than this from the span of the equations.
const VARIES: f64 = 1e-8;

/// Describes all impulses that solve the problem with the velocity of a solution.
///
/// At a fixed `v⁺` the LCP (formulation §4) restricts each contact to a face of its friction cone (an open contact to 0, a
/// sliding one to the edge or ray of maximum dissipation, where `μ λ_N = eᵀα`), and the momentum balance fixes
/// `J_Nᵀλ_N + J_Tᵀλ_T + J_Bᵀλ_B`. With multipliers `γ ≥ 0` of the rays `(1, μ d_k)` of these faces this is `{γ ≥ 0 : A γ = p}`.
///
/// - **Dimension.** A ray takes part if some solution has `γ_k > 0`. Starting from the vertices met, `Σ γ_k` over the rays not
///   met yet is maximised until the maximum is 0, whose dual proves that the others vanish in every solution. On the rays that
///   take part the set has a point with `γ > 0`, so that its dimension is that of the null space of the balance on their span.
/// - **Ranges.** Two linear programs for every component that the balance does not fix.
///
/// Velocities count as zero below 1e-9 of `max|b|` (or ten times the certificate's residual, if that is larger); ranks are
/// decided at 1e-9 of rows of length 1, and multipliers are positive above 1e-9 of the largest impulse. Components refer to
/// the frames of the problem's Jacobian.
///
/// # Errors
/// [`ProblemError::NotASolution`] if the solution's [certificate](certify) exceeds 1e-6, [`ProblemError::Unsupported`] if the
/// problem has friction groups.
///
/// # Cost
/// Dense, for each group of coupled bodies: some pivots of `O(n_v (n_v + m))` for each of `6 nc` programs. For analysis, not
/// for every step of a simulation.
///
/// # Source
/// Maximal support by linear programs: Freund, Roundy, Todd, *Identifying the set of always-active constraints in a system of
/// linear inequalities by a single linear program* (1985), here as a sequence that starts warm.
pub fn force_distributions(
    problem: &ContactProblem,
    solution: &ContactSolution,
) -> Result<ForceDistributions, ProblemError> {
    problem.check_without_groups()?;
    let residual = certify(problem, solution).worst();
    if residual > LARGEST_RESIDUAL {
        return Err(ProblemError::NotASolution { residual });
    }
    let mut cones = ImpulseCones::default();
    admissible_impulses(problem, &solution.velocity, residual, &mut cones);
    let own: Vec<[f64; 3]> = (0..problem.contact_count())
        .map(|i| (solution.lambda_n[i], tangential_impulse(problem, solution, i)))
        .map(|(n, [t_1, t_2])| [n, t_1, t_2])
        .collect();
    let mut impulse = own.clone();
    project_impulses(&cones, &mut impulse);
    let mut result = ForceDistributions {
        normal: impulse.iter().map(|p| ImpulseRange::single(p[0])).collect(),
        tangential: impulse.iter().map(|p| [ImpulseRange::single(p[1]), ImpulseRange::single(p[2])]).collect(),
        bilateral: solution.bilateral.iter().copied().map(ImpulseRange::single).collect(),
        discrepancy: discrepancy(&own, &impulse),
        ..ForceDistributions::default()
    };
    let mut groups = Groups::default();
    groups.find(problem, &cones);
    for group in groups.all() {
        GroupSet::new(problem, &cones, group, &impulse, &solution.bilateral).describe(&mut result);
    }
    free_immovable_contacts(problem, &cones, &mut result);
    Ok(result)
}

/// Contacts and rows that no degree of freedom moves balance themselves: every impulse of their cones is admitted.
fn free_immovable_contacts(problem: &ContactProblem, cones: &ImpulseCones, result: &mut ForceDistributions) {
    let (nc, nb) = (problem.contact_count(), problem.bilateral_violation.len());
    let empty = SelfStress { impulse: vec![[0.0; 3]; nc], bilateral: vec![0.0; nb] };
    for i in (0..nc).filter(|&i| problem.jacobian.group(i).0.is_empty()) {
        result.dimension += basis_of_span(cones.rays(i)).len();
        for ray in cones.rays(i) {
            let mut stress = empty.clone();
            stress.impulse[i] = *ray;
            result.add(stress);
        }
    }
    for k in (0..nb).filter(|&k| problem.bilateral_jacobian.group(k).0.is_empty()) {
        result.dimension += 1;
        for sign in [1.0, -1.0] {
            let mut stress = empty.clone();
            stress.bilateral[k] = sign;
            result.add(stress);
        }
    }
}

fn discrepancy(own: &[[f64; 3]], admitted: &[[f64; 3]]) -> f64 {
    let largest = own.iter().flatten().fold(0.0, |l: f64, x| l.max(x.abs()));
    let differences = own.iter().flatten().zip(admitted.iter().flatten()).map(|(a, b)| (a - b).abs());
    let worst = differences.fold(0.0, f64::max);
    if worst == 0.0 { 0.0 } else { worst / largest }
}

/// One impulse of a group, as a function of the variables.
#[derive(Clone, Copy)]
enum Component {
    /// Contact, component.
    Contact(usize, usize),
    /// Place in the group, row.
    Bilateral(usize, usize),
}

/// The polyhedron of one group: `x = (γ, λ_B⁺, λ_B⁻) ≥ 0`, in units of its largest impulse.
struct GroupSet<'a> {
    problem: &'a ContactProblem,
    cones: &'a ImpulseCones,
    group: Group<'a>,
    /// First variable of each contact of the group, and of the bilateral rows.
    starts: Vec<usize>,
    unit: f64,
    simplex: Simplex,
    /// Which variables are positive in some solution.
    taking_part: Vec<bool>,
}

impl<'a> GroupSet<'a> {
    fn new(
        problem: &'a ContactProblem,
        cones: &'a ImpulseCones,
        group: Group<'a>,
        impulse: &[[f64; 3]],
        bilateral: &[f64],
    ) -> Self {
        let mut starts = vec![0];
        for &i in group.contacts {
            starts.push(starts[starts.len() - 1] + cones.rays(i as usize).len());
        }
        let gammas = starts[starts.len() - 1];
        let mut start = vec![0.0; gammas + 2 * group.rows.len()];
        for (c, &i) in group.contacts.iter().enumerate() {
            cones.multipliers(i as usize, impulse[i as usize], &mut start[starts[c]..starts[c + 1]]);
        }
        for (k, &row) in group.rows.iter().enumerate() {
            let lambda = bilateral[row as usize];
            start[gammas + 2 * k + usize::from(lambda < 0.0)] = lambda.abs();
        }
        let largest = start.iter().copied().fold(0.0, f64::max);
        let unit = if largest > 0.0 { largest } else { 1.0 };
        start.iter_mut().for_each(|x| *x /= unit);
        let mut p = Vec::new();
        generalized_impulse(problem, impulse, bilateral, &mut p);
        let mut equations: Vec<Row> =
            group.dofs.iter().map(|&dof| Row { a: vec![0.0; start.len()], b: p[dof as usize] / unit }).collect();
        let mut place = |columns: &[u32], column: usize, entry: &dyn Fn(usize) -> f64| {
            for (e, &dof) in columns.iter().enumerate() {
                equations[group.local(dof)].a[column] = entry(e);
            }
        };
        for (c, &i) in group.contacts.iter().enumerate() {
            let (columns, entries) = problem.jacobian.group(i as usize);
            for (k, g) in cones.rays(i as usize).iter().enumerate() {
                place(columns, starts[c] + k, &|e| (0..3).map(|r| entries[e][r] * g[r]).sum());
            }
        }
        for (k, &row) in group.rows.iter().enumerate() {
            let (columns, entries) = problem.bilateral_jacobian.group(row as usize);
            place(columns, gammas + 2 * k, &|e| entries[e][0]);
            place(columns, gammas + 2 * k + 1, &|e| -entries[e][0]);
        }
        let taking_part = start.iter().enumerate().map(|(j, x)| j >= gammas || *x > POSITIVE).collect();
        let simplex = Simplex::new(equations, start);
        Self { problem, cones, group, starts, unit, simplex, taking_part }
    }

    fn describe(mut self, result: &mut ForceDistributions) {
        self.find_those_taking_part(result);
        let spans: Vec<Vec<[f64; 3]>> = (0..self.group.contacts.len()).map(|c| self.span(c)).collect();
        let size = spans.iter().map(Vec::len).sum::<usize>() + self.group.rows.len();
        let balance = orthonormal(self.balance_on(&spans, size));
        result.dimension += size - balance.len();
        let contacts = (0..spans.len()).flat_map(|c| (0..3).map(move |r| Component::Contact(c, r)));
        let rows = self.group.rows.iter().enumerate().map(|(k, &row)| Component::Bilateral(k, row as usize));
        for component in contacts.chain(rows) {
            if size > balance.len() && distance(&balance, &coordinates(component, &spans, size)) > VARIES {
                self.find_range(component, result);
            }
        }
        result.residual.merge(&self.simplex.residual);
        result.pivots += self.simplex.pivots;
    }

    /// Maximal support.
    fn find_those_taking_part(&mut self, result: &mut ForceDistributions) {
        self.note_support(None);
        while self.taking_part.iter().any(|known| !known) {
            let objective: Vec<f64> = self.taking_part.iter().map(|&known| f64::from(u8::from(!known))).collect();
            result.linear_programs += 1;
            let grown = match self.simplex.maximize(&objective) {
                Maximum::Attained(sum) if sum <= POSITIVE => false,
                Maximum::Attained(_) => self.note_support(None),
                Maximum::Unbounded(ray) => {
                    result.add(self.stress(&ray));
                    self.note_support(Some(&ray))
                }
            };
            if !grown {
                break;
            }
        }
    }

    /// Marks what is positive at the current vertex or along a ray; whether anything new is.
    fn note_support(&mut self, ray: Option<&[f64]>) -> bool {
        let mut grown = false;
        for (j, known) in self.taking_part.iter_mut().enumerate() {
            let positive = self.simplex.x[j] > POSITIVE || ray.is_some_and(|ray| ray[j] > POSITIVE);
            grown |= positive && !*known;
            *known |= positive;
        }
        grown
    }

    /// Orthonormal basis of the span of contact `c`'s rays that take part.
    fn span(&self, c: usize) -> Vec<[f64; 3]> {
        let rays = self.cones.rays(self.group.contacts[c] as usize);
        let known = &self.taking_part[self.starts[c]..self.starts[c + 1]];
        let rays: Vec<[f64; 3]> = rays.iter().zip(known).filter(|(_, known)| **known).map(|(g, _)| *g).collect();
        basis_of_span(&rays)
    }

    /// The balance as rows over coordinates in the spans, then `λ_B`.
    fn balance_on(&self, spans: &[Vec<[f64; 3]>], size: usize) -> Vec<Row> {
        let mut rows = vec![Row { a: vec![0.0; size], b: 0.0 }; self.group.dofs.len()];
        let mut at = 0;
        for (&i, span) in self.group.contacts.iter().zip(spans) {
            let (columns, entries) = self.problem.jacobian.group(i as usize);
            for u in span {
                for (&dof, e) in columns.iter().zip(entries) {
                    rows[self.group.local(dof)].a[at] = (0..3).map(|r| e[r] * u[r]).sum();
                }
                at += 1;
            }
        }
        for &row in self.group.rows {
            let (columns, entries) = self.problem.bilateral_jacobian.group(row as usize);
            for (&dof, e) in columns.iter().zip(entries) {
                rows[self.group.local(dof)].a[at] = e[0];
            }
            at += 1;
        }
        rows
    }

    /// The variables' coefficients in a component.
    fn objective(&self, component: Component, sign: f64) -> Vec<f64> {
        let mut c = vec![0.0; self.simplex.x.len()];
        match component {
            Component::Contact(at, r) => {
                let rays = self.cones.rays(self.group.contacts[at] as usize);
                for (c, g) in c[self.starts[at]..].iter_mut().zip(rays) {
                    *c = sign * g[r];
                }
            }
            Component::Bilateral(k, _) => {
                let at = self.starts[self.group.contacts.len()] + 2 * k;
                (c[at], c[at + 1]) = (sign, -sign);
            }
        }
        c
    }

    fn find_range(&mut self, component: Component, result: &mut ForceDistributions) {
        for sign in [-1.0, 1.0] {
            let range = self.range_mut(component, result);
            let known = if sign < 0.0 { range.falls_along } else { range.grows_along };
            if known.is_some() {
                continue;
            }
            let objective = self.objective(component, sign);
            let end = self.simplex.maximize(&objective);
            result.linear_programs += 1;
            match end {
                Maximum::Attained(value) => {
                    // Adding zero removes the sign of −0.
                    let value = sign * value * self.unit + 0.0;
                    let range = self.range_mut(component, result);
                    if sign < 0.0 {
                        range.min = value;
                    } else {
                        range.max = value;
                    }
                }
                Maximum::Unbounded(ray) => result.add(self.stress(&ray)),
            }
        }
    }

    fn range_mut<'b>(&self, component: Component, result: &'b mut ForceDistributions) -> &'b mut ImpulseRange {
        let contact = |at: usize| self.group.contacts[at] as usize;
        match component {
            Component::Contact(at, 0) => &mut result.normal[contact(at)],
            Component::Contact(at, r) => &mut result.tangential[contact(at)][r - 1],
            Component::Bilateral(_, row) => &mut result.bilateral[row],
        }
    }

    /// The impulses of a ray.
    fn stress(&self, ray: &[f64]) -> SelfStress {
        let mut stress = SelfStress {
            impulse: vec![[0.0; 3]; self.problem.contact_count()],
            bilateral: vec![0.0; self.problem.bilateral_violation.len()],
        };
        for (c, &i) in self.group.contacts.iter().enumerate() {
            let gamma = &ray[self.starts[c]..self.starts[c + 1]];
            for (g, x) in self.cones.rays(i as usize).iter().zip(gamma) {
                (0..3).for_each(|r| stress.impulse[i as usize][r] += x * g[r]);
            }
        }
        let at = self.starts[self.group.contacts.len()];
        for (k, &row) in self.group.rows.iter().enumerate() {
            stress.bilateral[row as usize] = ray[at + 2 * k] - ray[at + 2 * k + 1];
        }
        stress
    }
}

/// A component over coordinates in the spans, then `λ_B`.
fn coordinates(component: Component, spans: &[Vec<[f64; 3]>], size: usize) -> Vec<f64> {
    let mut row = vec![0.0; size];
    let total: usize = spans.iter().map(Vec::len).sum();
    match component {
        Component::Contact(c, r) => {
            let at: usize = spans[..c].iter().map(Vec::len).sum();
            row[at..].iter_mut().zip(&spans[c]).for_each(|(x, u)| *x = u[r]);
        }
        Component::Bilateral(k, _) => row[total + k] = 1.0,
    }
    row
}

/// Orthonormal basis of the span of vectors.
fn basis_of_span(vectors: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let rows = vectors.iter().map(|g| Row { a: g.to_vec(), b: 0.0 }).collect();
    orthonormal(rows).iter().map(|row| std::array::from_fn(|r| row.a[r])).collect()
}
