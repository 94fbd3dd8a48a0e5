//! Pairs of geoms that have not moved since their contact points were found: these are the same, to the bit.

use signorini_multibody::ContactPoint;

use crate::reach::Within;

/// The contact points of pairs that stand still, looked up in the order of the pairs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Still {
    /// The number of the search at hand.
    search: u64,
    /// For each geom the first search that found it as it is now.
    since: Vec<u64>,
    /// What the search at hand found or took over, and what the last one had.
    now: Kept,
    before: Kept,
    next: usize,
}

/// Pairs in order, with their points.
#[derive(Clone, Debug, Default)]
struct Kept {
    pairs: Vec<Pair>,
    points: Vec<ContactPoint>,
}

/// A pair whose points are kept.
#[derive(Clone, Copy, Debug)]
struct Pair {
    pair: u64,
    /// The search that found its points, and what it was told.
    found: u64,
    within: (Within, f64),
    first: usize,
    count: usize,
}

impl Still {
    pub fn new(geoms: usize) -> Self {
        Self { since: vec![0; geoms], ..Self::default() }
    }

    /// Begins a search.
    pub fn begin(&mut self) {
        self.search += 1;
        std::mem::swap(&mut self.now, &mut self.before);
        self.now.pairs.clear();
        self.now.points.clear();
        self.next = 0;
    }

    /// Forgets all points: what they follow from beside poses has changed.
    pub fn forget(&mut self) {
        self.begin();
        self.begin();
    }

    /// Takes note of a geom that is not where the last search had it, or reaches another distance.
    pub fn note_moved(&mut self, geom: usize) {
        self.since[geom] = self.search;
    }

    /// Whether both geoms are as the last search had them.
    pub fn stand(&self, [i, j]: [usize; 2]) -> bool {
        self.since[i].max(self.since[j]) < self.search
    }

    /// Appends the points that were found of a pair, where it has stood since; whether there are any.
    ///
    /// - `within`: what the search of the pair is told
    pub fn take(&mut self, pair: u64, geoms: [usize; 2], within: &(Within, f64), out: &mut Vec<ContactPoint>) -> bool {
        while self.before.pairs.get(self.next).is_some_and(|known| known.pair < pair) {
            self.next += 1;
        }
        let known = self.before.pairs.get(self.next).copied();
        let since = geoms.map(|k| self.since[k]);
        let is_same =
            |known: &Pair| known.pair == pair && known.found >= since[0].max(since[1]) && known.within == *within;
        let Some(known) = known.filter(is_same) else { return false };
        let points = &self.before.points[known.first..][..known.count];
        out.extend_from_slice(points);
        self.now.push(known, points);
        true
    }

    /// Keeps the points that were found of a pair.
    pub fn keep(&mut self, pair: u64, within: (Within, f64), points: &[ContactPoint]) {
        if !points.is_empty() {
            self.now.push(Pair { pair, found: self.search, within, first: 0, count: 0 }, points);
        }
    }

    /// Makes room for all pairs and points of a search: how many stand still does not decide about memory.
    pub fn reserve(&mut self, pairs: usize, points: usize) {
        for kept in [&mut self.now, &mut self.before] {
            kept.pairs.reserve(pairs.saturating_sub(kept.pairs.len()));
            kept.points.reserve(points.saturating_sub(kept.points.len()));
        }
    }
}

impl Kept {
    fn push(&mut self, pair: Pair, points: &[ContactPoint]) {
        self.pairs.push(Pair { first: self.points.len(), count: points.len(), ..pair });
        self.points.extend_from_slice(points);
    }
}
