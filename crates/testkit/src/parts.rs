//! A contact problem taken apart, to be changed and put together again.

use signorini_contact::{ContactProblem, FrictionBound};

/// A contact.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPart {
    /// Jacobian columns with the entries (normal, tangent 1, tangent 2).
    pub columns: Vec<(u32, [f64; 3])>,
    /// Gap φ, m.
    pub gap: f64,
    /// Coefficient of friction μ.
    pub friction: f64,
    /// Friction directions; none without friction.
    pub directions: Vec<[f64; 2]>,
}

/// A bilateral row.
#[derive(Clone, Debug, PartialEq)]
pub struct BilateralPart {
    /// Jacobian columns.
    pub columns: Vec<(u32, [f64; 1])>,
    /// Θ, m or rad.
    pub violation: f64,
}

/// A friction group.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupPart {
    /// Jacobian columns with the entries of both rows.
    pub columns: Vec<(u32, [f64; 2])>,
    /// Target velocity.
    pub target: [f64; 2],
    /// Bound of the impulse.
    pub bound: FrictionBound,
    /// Friction directions.
    pub directions: Vec<[f64; 2]>,
}

/// A contact problem as lists of its parts.
#[derive(Clone, Debug)]
pub struct Parts {
    /// Mass, free velocity and time step; without contacts, rows and groups.
    pub base: ContactProblem,
    /// The contacts.
    pub contacts: Vec<ContactPart>,
    /// The bilateral rows.
    pub bilateral: Vec<BilateralPart>,
    /// The friction groups.
    pub groups: Vec<GroupPart>,
}

fn pairs<const R: usize>((columns, entries): (&[u32], &[[f64; R]])) -> Vec<(u32, [f64; R])> {
    columns.iter().copied().zip(entries.iter().copied()).collect()
}

impl Parts {
    /// The parts of a problem.
    pub fn of(problem: &ContactProblem) -> Self {
        let contact = |i: usize| ContactPart {
            columns: pairs(problem.jacobian.group(i)),
            gap: problem.gap[i],
            friction: problem.friction[i],
            directions: problem.directions_of(i).to_vec(),
        };
        let row = |k: usize| BilateralPart {
            columns: pairs(problem.bilateral_jacobian.group(k)),
            violation: problem.bilateral_violation[k],
        };
        let groups = &problem.friction_groups;
        let group = |j: usize| GroupPart {
            columns: pairs(groups.jacobian.group(j)),
            target: groups.target[j],
            bound: groups.bound[j],
            directions: groups.directions_of(j).to_vec(),
        };
        let mut base = problem.clone();
        base.clear_contacts();
        Self {
            base,
            contacts: (0..problem.contact_count()).map(contact).collect(),
            bilateral: (0..problem.bilateral_violation.len()).map(row).collect(),
            groups: (0..groups.len()).map(group).collect(),
        }
    }

    /// The problem of these parts.
    ///
    /// # Panics
    /// If they do not fit together.
    pub fn problem(&self) -> ContactProblem {
        let mut problem = self.base.clone();
        for contact in &self.contacts {
            problem.jacobian.push(contact.columns.iter().copied());
            problem.gap.push(contact.gap);
            problem.friction.push(contact.friction);
            problem.directions.extend(&contact.directions);
            problem.direction_offsets.push(problem.directions.len());
        }
        for row in &self.bilateral {
            problem.push_bilateral(row.columns.iter().copied(), row.violation);
        }
        let groups = &mut problem.friction_groups;
        for group in &self.groups {
            groups.jacobian.push(group.columns.iter().copied());
            groups.target.push(group.target);
            groups.bound.push(group.bound);
            groups.directions.extend(&group.directions);
            groups.direction_offsets.push(groups.directions.len());
        }
        problem.check().expect("parts that fit together");
        problem
    }

    /// Takes the contacts with these indices, in this order; an index may appear several times. The bounds of friction groups
    /// follow the first copy of their contact, and groups whose contact is left out leave, too. Returns the groups that stay.
    pub fn take_contacts(&mut self, order: &[usize]) -> Vec<usize> {
        self.contacts = order.iter().map(|&i| self.contacts[i].clone()).collect();
        let place = |contact: usize| order.iter().position(|&i| i == contact);
        let kept: Vec<usize> = (0..self.groups.len())
            .filter(|&j| self.groups[j].bound.normal().is_none_or(|(contact, _)| place(contact).is_some()))
            .collect();
        self.groups = kept.iter().map(|&j| self.groups[j].clone()).collect();
        for group in &mut self.groups {
            if let FrictionBound::Normal { contact, .. } | FrictionBound::Shifted { contact, .. } = &mut group.bound {
                *contact = place(*contact).unwrap_or_default();
            }
        }
        kept
    }

    /// Rows of the standard LCP.
    pub fn rows(&self) -> usize {
        let contacts: usize = self.contacts.iter().map(|c| 2 + c.directions.len()).sum();
        let groups: usize = self.groups.iter().map(|g| 1 + g.directions.len()).sum();
        self.bilateral.len() + contacts + groups
    }
}
