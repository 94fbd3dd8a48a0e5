//! Carrying a solution from one step's contacts to the next's, by feature.

use signorini_contact::{ContactSolution, WarmStart};
use signorini_multibody::{ContactPoint, JointId};

/// What identifies a contact from step to step: its geoms and feature, or a joint's limit.
pub(crate) type ContactKey = [u32; 3];

/// Marks the keys of joint limits; no geom has this index.
const LIMIT: u32 = u32::MAX;

/// The key of a contact point.
pub(crate) fn point_key(point: &ContactPoint) -> ContactKey {
    [point.geom_a.0, point.geom_b.0, point.feature]
}

/// The key of the lower (`side` 0) or upper (1) limit of joint `joint`.
pub(crate) fn limit_key(joint: usize, side: u32) -> ContactKey {
    [LIMIT, joint as u32, side]
}

/// The joint and side (whether upper) of a limit's key.
pub(crate) fn limit_of(key: &ContactKey) -> (JointId, bool) {
    (JointId(key[1]), key[2] == 1)
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

    /// The cache as plain numbers: the number of keys, the keys, and the
    /// [warm part](ContactSolution::write_warm_part) of the solution.
    pub fn write(&self, numbers: &mut Vec<f64>) {
        numbers.push(self.keys.len() as f64);
        numbers.extend(self.keys.iter().flatten().map(|&k| f64::from(k)));
        self.solution.write_warm_part(numbers);
    }

    /// Takes over what [`write`](Self::write) wrote; `None`, and no change, if it is not that.
    pub fn read(&mut self, numbers: &[f64]) -> Option<()> {
        let (&count, rest) = numbers.split_first()?;
        let is_key = |x: f64| x >= 0.0 && x <= f64::from(u32::MAX) && x.fract() == 0.0;
        if !is_key(count) || rest.len() < (count as usize).checked_mul(3)? {
            return None;
        }
        let (keys, solution) = rest.split_at(3 * count as usize);
        if !keys.iter().all(|&k| is_key(k)) {
            return None;
        }
        let keys: Vec<ContactKey> = keys.chunks_exact(3).map(|k| [k[0] as u32, k[1] as u32, k[2] as u32]).collect();
        if !keys.is_sorted() {
            return None;
        }
        self.solution.read_warm_part(solution)?;
        self.keys = keys;
        Some(())
    }
}
