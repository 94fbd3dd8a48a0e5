//! Carrying a solution from one step's contacts to the next's, by feature.

use signorini_contact::{ContactSolution, WarmStart};
use signorini_multibody::{ContactPoint, JointId, TendonId};

use crate::source::{ContactSource, FrictionSource};

/// What identifies a contact from step to step: its geoms and feature, or a limit of a joint or tendon.
pub(crate) type ContactKey = [u32; 3];

/// Mark the keys of limits of joints and of tendons; no geom has such an index.
const JOINT_LIMIT: u32 = u32::MAX - 1;
const TENDON_LIMIT: u32 = u32::MAX;

/// Marks the keys of friction groups that belong to no contact.
const MECHANISM: u32 = u32::MAX;

/// The key of a contact point.
pub(crate) fn point_key(point: &ContactPoint) -> ContactKey {
    [point.geom_a.0, point.geom_b.0, point.feature]
}

/// The key of the lower (`side` 0) or upper (1) limit of joint `joint`; the further rows of a ball joint's have `side` 3, 5, …
pub(crate) fn joint_limit_key(joint: usize, side: u32) -> ContactKey {
    [JOINT_LIMIT, joint as u32, side]
}

/// The key of the lower (`side` 0) or upper (1) limit of tendon `tendon`.
pub(crate) fn tendon_limit_key(tendon: usize, side: u32) -> ContactKey {
    [TENDON_LIMIT, tendon as u32, side]
}

/// What a limit's key stands for.
pub(crate) fn limit_of(key: &ContactKey) -> ContactSource {
    let upper = key[2] % 2 == 1;
    match key[0] {
        TENDON_LIMIT => ContactSource::TendonLimit { tendon: TendonId(key[1]), upper },
        _ => ContactSource::Limit { joint: JointId(key[1]), upper },
    }
}

/// What identifies a friction group from step to step: the contact it belongs to and its kind, or its place in the mechanism.
pub(crate) type GroupKey = [u32; 4];

/// The key of a friction group, given the keys of the contacts.
pub(crate) fn group_key(source: FrictionSource, contacts: &[ContactKey]) -> GroupKey {
    let of_contact = |contact: usize, kind| {
        let [a, b, feature] = contacts[contact];
        [a, b, feature, kind]
    };
    match source {
        FrictionSource::Belt { contact } => of_contact(contact, 0),
        FrictionSource::Spinning { contact } => of_contact(contact, 1),
        FrictionSource::Rolling { contact } => of_contact(contact, 2),
        FrictionSource::Joint { dof, .. } => [MECHANISM, 0, dof as u32, 0],
        FrictionSource::Servo { actuator } => [MECHANISM, 1, actuator as u32, 0],
    }
}

/// The last solution with the keys of its contacts and friction groups, ascending.
#[derive(Clone, Debug, Default)]
pub(crate) struct WarmCache {
    keys: Vec<ContactKey>,
    group_keys: Vec<GroupKey>,
    solution: ContactSolution,
    start: WarmStart,
    /// Whether the solution is one of the step at hand.
    is_of_step: bool,
}

impl WarmCache {
    /// What is kept is of an earlier step from now on.
    pub fn begin_step(&mut self) {
        self.is_of_step = false;
    }

    /// Forgets the last solution.
    pub fn clear(&mut self) {
        self.keys.clear();
        self.group_keys.clear();
        self.solution.clear_warm_part();
    }

    /// The start for contacts and friction groups with these keys, ascending.
    pub fn start_for(&mut self, keys: &[ContactKey], group_keys: &[GroupKey]) -> &WarmStart {
        let Self { start, solution, .. } = self;
        start.clear();
        match_keys(&self.keys, keys, |from| start.push(solution, from));
        match_keys(&self.group_keys, group_keys, |from| start.push_group(solution, from));
        start.set_bilateral(&solution.bilateral);
        start.nearly_solves = self.is_of_step;
        start
    }

    /// Keeps a solution.
    pub fn keep(&mut self, keys: &[ContactKey], group_keys: &[GroupKey], solution: &ContactSolution) {
        self.keys.clear();
        self.keys.extend_from_slice(keys);
        self.group_keys.clear();
        self.group_keys.extend_from_slice(group_keys);
        self.solution.copy_warm_part(solution);
        self.is_of_step = true;
    }

    /// Whether the last start had what a solution has for a unit: a contact, or a friction group counted after the contacts.
    pub fn gave(&self, unit: usize, contacts: usize, solution: &ContactSolution) -> bool {
        let mode = solution.solver_modes[unit];
        match unit.checked_sub(contacts) {
            None => self.start.contacts[unit] == Some((solution.impulse[unit], mode)),
            Some(j) => {
                let [a, b] = solution.group_impulse[j];
                self.start.groups[j].is_some_and(|(given, known)| known == mode && given[1..] == [a, b])
            }
        }
    }

    /// Adds contacts and friction groups of a solution, which it does not have: of each the keys, and which are wanted.
    pub fn take_in(
        &mut self,
        contacts: (&[ContactKey], impl Fn(usize) -> bool),
        groups: (&[GroupKey], impl Fn(usize) -> bool),
        from: &ContactSolution,
    ) {
        let Self { keys, group_keys, solution, .. } = self;
        for (i, key) in contacts.0.iter().enumerate().filter(|(i, _)| contacts.1(*i)) {
            let at = keys.partition_point(|known| known < key);
            keys.insert(at, *key);
            solution.impulse.insert(at, from.impulse[i]);
            solution.solver_modes.insert(at, from.solver_modes[i]);
        }
        for (j, key) in groups.0.iter().enumerate().filter(|(j, _)| groups.1(*j)) {
            let at = group_keys.partition_point(|known| known < key);
            group_keys.insert(at, *key);
            solution.group_impulse.insert(at, from.group_impulse[j]);
            solution.solver_modes.insert(keys.len() + at, from.solver_modes[from.impulse.len() + j]);
        }
    }

    /// The cache as plain numbers: for contacts and for friction groups the number of keys and the keys, then the
    /// [warm part](ContactSolution::write_warm_part) of the solution.
    pub fn write(&self, numbers: &mut Vec<f64>) {
        write_keys(&self.keys, numbers);
        write_keys(&self.group_keys, numbers);
        self.solution.write_warm_part(numbers);
    }

    /// Takes over what [`write`](Self::write) wrote; `None`, and no change, if it is not that.
    pub fn read(&mut self, numbers: &[f64]) -> Option<()> {
        let (keys, rest) = read_keys(numbers)?;
        let (group_keys, solution) = read_keys(rest)?;
        self.solution.read_warm_part(solution)?;
        (self.keys, self.group_keys) = (keys, group_keys);
        Some(())
    }
}

/// Writes keys with their number before them.
pub(crate) fn write_keys<const N: usize>(keys: &[[u32; N]], numbers: &mut Vec<f64>) {
    numbers.push(keys.len() as f64);
    numbers.extend(keys.iter().flatten().map(|&k| f64::from(k)));
}

/// The keys at the front of some numbers, if there are some, and what follows them.
pub(crate) fn read_keys<const N: usize>(numbers: &[f64]) -> Option<(Vec<[u32; N]>, &[f64])> {
    let (&count, rest) = numbers.split_first()?;
    let is_key = |x: f64| x >= 0.0 && x <= f64::from(u32::MAX) && x.fract() == 0.0;
    if !is_key(count) || rest.len() < (count as usize).checked_mul(N)? {
        return None;
    }
    let (keys, rest) = rest.split_at(N * count as usize);
    if !keys.iter().all(|&k| is_key(k)) {
        return None;
    }
    let keys: Vec<[u32; N]> = keys.as_chunks::<N>().0.iter().map(|key| key.map(|k| k as u32)).collect();
    Some((keys, rest))
}

/// Calls `visit` for every key with its place among the earlier ones, if it was there. Both ascending; limits that a solve
/// showed to be crossed come last, and may be missed.
fn match_keys<K: Ord>(earlier: &[K], keys: &[K], mut visit: impl FnMut(Option<usize>)) {
    let mut next = 0;
    for key in keys {
        while earlier.get(next).is_some_and(|k| k < key) {
            next += 1;
        }
        let same = earlier.get(next) == Some(key);
        visit(same.then_some(next));
        next += usize::from(same);
    }
}
