//! Which pairs of geoms can touch, asked once.

use std::collections::BTreeSet;

use signorini_multibody::{GeomId, Model};

/// So many geoms have a table of all their pairs; beyond that the filter is asked each time.
const TABLE: usize = 1024;

/// The answers of the model's contact filter.
#[derive(Clone, Debug, Default)]
pub(crate) struct Partners {
    /// Place of every geom in the table; `u32::MAX` for those that take no part.
    place: Vec<u32>,
    /// Rows of bits, one for each place; empty where there are too many geoms.
    rows: Vec<u64>,
    /// Words in a row.
    width: usize,
    /// Pairs that are left out besides, in order; where there is a table it knows them.
    excluded: BTreeSet<(u32, u32)>,
}

impl Partners {
    /// - `geoms`: those that may have partners at all, ascending
    pub fn new(model: &Model, geoms: &[u32]) -> Self {
        let mut place = vec![u32::MAX; model.geoms.len()];
        (0..).zip(geoms).for_each(|(k, &i)| place[i as usize] = k);
        if geoms.len() > TABLE {
            return Self { place, rows: Vec::new(), width: 0, excluded: BTreeSet::new() };
        }
        let width = geoms.len().div_ceil(64);
        let mut rows = vec![0; width * geoms.len()];
        for (k, &i) in geoms.iter().enumerate() {
            for (l, &j) in geoms.iter().enumerate().skip(k + 1) {
                if filter_allows(model, i, j) {
                    rows[k * width + l / 64] |= 1 << (l % 64);
                    rows[l * width + k / 64] |= 1 << (k % 64);
                }
            }
        }
        Self { place, rows, width, excluded: BTreeSet::new() }
    }

    /// Whether two geoms that take part can touch.
    pub fn allow(&self, model: &Model, i: u32, j: u32) -> bool {
        if self.rows.is_empty() {
            return filter_allows(model, i, j) && !self.excluded.contains(&(i.min(j), i.max(j)));
        }
        let (k, l) = (self.place[i as usize] as usize, self.place[j as usize] as usize);
        self.rows[k * self.width + l / 64] >> (l % 64) & 1 == 1
    }

    /// Lets two geoms touch no more; those that take no part never do.
    pub fn exclude(&mut self, i: u32, j: u32) {
        let [Some(&k), Some(&l)] = [i, j].map(|geom| self.place.get(geom as usize).filter(|place| **place != u32::MAX))
        else {
            return;
        };
        if self.rows.is_empty() {
            self.excluded.insert((i.min(j), i.max(j)));
            return;
        }
        for (row, column) in [(k as usize, l as usize), (l as usize, k as usize)] {
            self.rows[row * self.width + column / 64] &= !(1 << (column % 64));
        }
    }

    /// Whether a geom can touch another one; true where that is not known.
    pub fn has_any(&self, i: u32) -> bool {
        let k = self.place[i as usize] as usize;
        self.rows.is_empty() || self.rows[k * self.width..(k + 1) * self.width].iter().any(|word| *word != 0)
    }
}

/// Those of `geoms` whose masks let them meet one of `others`, or that are named in a pair; the rest meets none of them whatever
/// happens.
pub(crate) fn that_can_meet(model: &Model, geoms: &[u32], others: &[u32]) -> Vec<u32> {
    let geom = |i: u32| &model.geoms[i as usize];
    let types = others.iter().fold(0, |all, &i| all | geom(i).contact_type);
    let affinities = others.iter().fold(0, |all, &i| all | geom(i).contact_affinity);
    let can = |i: &u32| {
        let masks = geom(*i).contact_type & affinities != 0 || geom(*i).contact_affinity & types != 0;
        masks || model.pairs.iter().any(|pair| pair.geom_a.0 == *i || pair.geom_b.0 == *i)
    };
    geoms.iter().copied().filter(can).collect()
}

fn filter_allows(model: &Model, i: u32, j: u32) -> bool {
    let (a, b) = (&model.geoms[i.min(j) as usize], &model.geoms[i.max(j) as usize]);
    model.contact_filter.allows((GeomId(i.min(j)), GeomId(i.max(j))), (a, b))
}

/// Two geoms as one number, the smaller index first.
pub(crate) fn pair_of(i: u32, j: u32) -> u64 {
    u64::from(i.min(j)) << 32 | u64::from(i.max(j))
}

/// The geoms of a pair.
pub(crate) fn geoms_of(pair: u64) -> (usize, usize) {
    ((pair >> 32) as usize, pair as u32 as usize)
}
