//! The rows of a comparison.

use signorini::contact::ContactProblem;
use signorini::contact::problem_file::ProblemFile;

use crate::results::Row;
use crate::solving::SolverChoice;

/// A law and a method to try.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Name of the law.
    pub law: &'static str,
    /// Directions of a regular polygon; the file's own where there are none.
    pub regular: Option<usize>,
    /// Directions of each contact, where they are as many at all.
    pub directions: Option<usize>,
    /// Method.
    pub method: SolverChoice,
    /// Rows of the complementarity problem.
    pub n: usize,
}

impl Plan {
    /// Whether the method needs the dense matrix of the complementarity problem.
    pub fn is_dense(&self) -> bool {
        self.method.lcp().is_some()
    }

    /// The row before anything is known of it.
    pub fn row(&self) -> Row {
        Row {
            law: self.law.to_owned(),
            directions: self.directions,
            as_given: self.law == "polygon" && self.regular.is_none(),
            method: self.method.name(),
            n: Some(self.n),
            ..Row::default()
        }
    }
}

/// All rows for a problem.
pub fn plan(problem: &ProblemFile, directions: &[usize]) -> Vec<Plan> {
    let methods = |law, n| {
        SolverChoice::lcp_methods()
            .map(move |method| Plan { law, regular: None, directions: None, method, n })
            .collect()
    };
    match problem {
        ProblemFile::Lcp(problem) => methods("lcp", problem.len()),
        ProblemFile::MixedLcp(problem) => methods("mlcp", problem.len()),
        ProblemFile::Contact(problem) => contact_plan(problem, directions),
        ProblemFile::Frictional(problem) => {
            let nc = problem.friction.len();
            // In the plane there is one polygon.
            let counts = if problem.dimension == 2 { &[2][..] } else { directions };
            let circular = Plan {
                law: "circular",
                regular: None,
                directions: None,
                method: SolverChoice::Circular,
                n: problem.free_velocity.len(),
            };
            let polygons = counts.iter().flat_map(|&count| {
                let n = nc * (2 + count);
                SolverChoice::lcp_methods().map(move |method| polygon(Some(count), Some(count), method, n))
            });
            std::iter::once(circular).chain(polygons).collect()
        }
        _ => Vec::new(),
    }
}

fn polygon(regular: Option<usize>, directions: Option<usize>, method: SolverChoice, n: usize) -> Plan {
    Plan { law: "polygon", regular, directions, method, n }
}

fn contact_plan(problem: &ContactProblem, directions: &[usize]) -> Vec<Plan> {
    let own = common_count(problem);
    let n = problem.standard_layout().size;
    let frictional = (0..problem.contact_count()).filter(|&i| !problem.directions_of(i).is_empty()).count();
    let all = || std::iter::once(SolverChoice::structured()).chain(SolverChoice::lcp_methods());
    let mut plans: Vec<Plan> = all().map(|method| polygon(None, own, method, n)).collect();
    for &count in directions {
        if frictional > 0 && !is_regular(problem, count) {
            let n = n - problem.direction_count() + count * frictional;
            plans.extend(all().map(|method| polygon(Some(count), Some(count), method, n)));
        }
    }
    for (law, method) in [
        ("circular", SolverChoice::Circular),
        ("circular", SolverChoice::Refined),
        ("relaxation", SolverChoice::Relaxation),
    ] {
        plans.push(Plan { law, regular: None, directions: None, method, n });
    }
    plans
}

/// The number of directions that all frictional contacts have.
fn common_count(problem: &ContactProblem) -> Option<usize> {
    let mut counts = (0..problem.contact_count()).map(|i| problem.directions_of(i).len()).filter(|m| *m > 0);
    let first = counts.next()?;
    counts.all(|m| m == first).then_some(first)
}

/// Whether the problem's own polygons are the regular ones with so many directions.
fn is_regular(problem: &ContactProblem, count: usize) -> bool {
    let same = |other: ContactProblem| {
        let pairs = other.directions.iter().zip(&problem.directions);
        other.direction_offsets == problem.direction_offsets
            && pairs.into_iter().all(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12)
    };
    problem.with_directions(count).is_ok_and(same)
}
