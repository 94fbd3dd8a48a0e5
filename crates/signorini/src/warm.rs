//! Carrying a solution from one step's contacts to the next's, by feature.

use signorini_contact::{ContactSolution, WarmStart};
use signorini_multibody::{ContactPoint, JointId, TendonId};

use crate::step::ContactSource;

/// What identifies a contact from step to step: its geoms and feature, or a limit of a joint or tendon.
pub(crate) type ContactKey = [u32; 3];

/// Mark the keys of limits of joints and of tendons; no geom has such an index.
const JOINT_LIMIT: u32 = u32::MAX - 1;
const TENDON_LIMIT: u32 = u32::MAX;

/// The key of a contact point.
pub(crate) fn point_key(point: &ContactPoint) -> ContactKey {
    [point.geom_a.0, point.geom_b.0, point.feature]
}

/// The key of the lower (`side` 0) or upper (1) limit of joint `joint`.
pub(crate) fn joint_limit_key(joint: usize, side: u32) -> ContactKey {
    [JOINT_LIMIT, joint as u32, side]
}

/// The key of the lower (`side` 0) or upper (1) limit of tendon `tendon`.
pub(crate) fn tendon_limit_key(tendon: usize, side: u32) -> ContactKey {
    [TENDON_LIMIT, tendon as u32, side]
}

/// What a limit's key stands for.
pub(crate) fn limit_of(key: &ContactKey) -> ContactSource {
    let upper = key[2] == 1;
    match key[0] {
        TENDON_LIMIT => ContactSource::TendonLimit { tendon: TendonId(key[1]), upper },
        _ => ContactSource::Limit { joint: JointId(key[1]), upper },
    }
}

/// The last solution with the keys of its contacts, ascending.
#[derive(Clone, Debug, Default)]
pub(crate) struct WarmCache {
    keys: Vec<ContactKey>,
    solution: ContactSolution,
    start: WarmStart,
}

impl WarmCache {
    /// Forgets the last solution.
    pub fn clear(&mut self) {
        self.keys.clear();
    }

    /// Whether the solution kept is one of exactly these contacts.
    pub fn holds(&self, keys: &[ContactKey]) -> bool {
        self.keys == keys
    }

    /// The start for contacts with these keys, ascending.
    pub fn start_for(&mut self, keys: &[ContactKey]) -> &WarmStart {
        self.start.clear();
        let mut earlier = 0;
        for key in keys {
            while self.keys.get(earlier).is_some_and(|k| k < key) {
                earlier += 1;
            }
            let same = self.keys.get(earlier) == Some(key);
            self.start.push(&self.solution, same.then_some(earlier));
            earlier += usize::from(same);
        }
        self.start.set_bilateral(&self.solution.bilateral);
        &self.start
    }

    /// Keeps a solution, taking its place in exchange.
    pub fn keep(&mut self, keys: &[ContactKey], solution: &ContactSolution) {
        self.keys.clear();
        self.keys.extend_from_slice(keys);
        self.solution.copy_warm_part(solution);
    }
}
