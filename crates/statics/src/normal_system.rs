//! The system `A W Aᵀ + diag` of the interior-point method on contact forces, in blocks of bodies.

use signorini_contact::ContactProblem;
use signorini_sparse::{BlockLu, Symbolic};

/// Columns of a contact that belong to one block.
#[derive(Clone, Copy, Debug)]
struct Run {
    block: usize,
    /// First column within the block.
    start: usize,
    /// Its entries among those of all contacts.
    begin: usize,
    end: usize,
}

/// An entry of a row this small beside the row's largest is rounding of a frame.
const NOTHING: f64 = 1e-15;
/// The place of a degree of freedom that no contact moves.
const UNTOUCHED: usize = usize::MAX;

/// The rows of contacts in units of the loads, and a factorised system over the degrees of freedom that they move.
#[derive(Debug, Default)]
pub(crate) struct NormalSystem {
    /// `√M_kk`.
    root_mass: Vec<f64>,
    /// Place of every degree of freedom among those that contacts move.
    place: Vec<usize>,
    /// Where each block's places begin, and the total.
    starts: Vec<usize>,
    /// Block of every place.
    block: Vec<usize>,
    runs: Vec<Run>,
    /// Where each contact's runs begin, and the total.
    run_offsets: Vec<usize>,
    /// Entries of the three rows of contacts by `√M_kk`, contact after contact.
    entries: Vec<[f64; 3]>,
    symbolic: Symbolic,
    lu: BlockLu,
}

impl NormalSystem {
    /// Reads contacts of a problem and finds an elimination order, unless the last problem's still does.
    pub fn read(&mut self, problem: &ContactProblem, contacts: &[usize]) {
        self.find_places(problem, contacts);
        self.runs.clear();
        self.entries.clear();
        self.run_offsets.clear();
        self.run_offsets.push(0);
        let mut edges = Vec::new();
        for &i in contacts {
            let first = self.runs.len();
            self.push_contact(problem.jacobian.group(i));
            for (k, b) in self.runs[first..].iter().enumerate() {
                edges.extend(self.runs[first..first + k].iter().map(|a| (a.block as u32, b.block as u32)));
            }
            self.run_offsets.push(self.runs.len());
        }
        edges.sort_unstable();
        edges.dedup();
        self.symbolic.analyse(&self.starts, &edges);
    }

    fn find_places(&mut self, problem: &ContactProblem, contacts: &[usize]) {
        let mut touched = vec![false; problem.nv()];
        for &i in contacts {
            let rows = if problem.friction[i] > 0.0 { 3 } else { 1 };
            let (columns, entries) = problem.jacobian.group(i);
            let size = |e: &[f64; 3]| e[..rows].iter().fold(0.0, |a: f64, e| a.max(e.abs()));
            let largest = entries.iter().map(size).fold(0.0, f64::max);
            let moved = columns.iter().zip(entries).filter(|(_, e)| size(e) > NOTHING * largest);
            moved.for_each(|(&k, _)| touched[k as usize] = true);
        }
        self.root_mass.resize(problem.nv(), 0.0);
        self.place.clear();
        self.place.resize(problem.nv(), UNTOUCHED);
        self.starts.clear();
        self.block.clear();
        for (index, block) in problem.mass.blocks().iter().enumerate() {
            let data = problem.mass.block_data(index);
            (0..block.size).for_each(|k| self.root_mass[block.start + k] = data[k * block.size + k].sqrt());
            let first = self.block.len();
            for k in (block.start..block.start + block.size).filter(|&k| touched[k]) {
                self.place[k] = self.block.len();
                self.block.push(self.starts.len());
            }
            if self.block.len() > first {
                self.starts.push(first);
            }
        }
        self.starts.push(self.block.len());
    }

    fn push_contact(&mut self, (columns, entries): (&[u32], &[[f64; 3]])) {
        let mut last: Option<Run> = None;
        for (&column, entry) in columns.iter().zip(entries) {
            let place = self.place[column as usize];
            if place == UNTOUCHED {
                continue;
            }
            let block = self.block[place];
            let start = place - self.starts[block];
            if let Some(run) = last.filter(|run| run.block != block) {
                self.runs.push(run);
                last = None;
            }
            let begin = self.entries.len();
            let run = last.get_or_insert(Run { block, start, begin, end: begin });
            // Columns between that have no entry are zero ones.
            self.entries.resize(run.begin + start - run.start, [0.0; 3]);
            self.entries.push(entry.map(|e| e / self.root_mass[column as usize]));
            run.end = self.entries.len();
        }
        self.runs.extend(last);
    }

    /// A vector over all degrees of freedom by `√M_kk` in places, and the largest entry that has none.
    pub fn gather(&self, load: &[f64]) -> (Vec<f64>, f64) {
        let (mut out, mut lost) = (vec![0.0; self.block.len()], 0.0_f64);
        for (k, p) in load.iter().enumerate() {
            let scaled = p / self.root_mass[k];
            match self.place[k] {
                UNTOUCHED => lost = lost.max(scaled.abs()),
                place => out[place] = scaled,
            }
        }
        (out, lost)
    }

    /// A vector in places by `√M_kk` over all degrees of freedom.
    pub fn scatter(&self, x: &[f64]) -> Vec<f64> {
        let value = |(k, &place): (usize, &usize)| if place == UNTOUCHED { 0.0 } else { x[place] / self.root_mass[k] };
        self.place.iter().enumerate().map(value).collect()
    }

    fn runs_of(&self, contact: usize) -> &[Run] {
        &self.runs[self.run_offsets[contact]..self.run_offsets[contact + 1]]
    }

    /// `J_i x`.
    pub fn multiply(&self, contact: usize, x: &[f64]) -> [f64; 3] {
        let mut out = [0.0; 3];
        for run in self.runs_of(contact) {
            let x = &x[self.starts[run.block] + run.start..];
            for (entry, x) in self.entries[run.begin..run.end].iter().zip(x) {
                (0..3).for_each(|r| out[r] += entry[r] * x);
            }
        }
        out
    }

    /// `y += J_iᵀ f`.
    pub fn add_transposed(&self, contact: usize, f: [f64; 3], y: &mut [f64]) {
        for run in self.runs_of(contact) {
            let y = &mut y[self.starts[run.block] + run.start..];
            for (entry, y) in self.entries[run.begin..run.end].iter().zip(y) {
                *y += entry[0] * f[0] + entry[1] * f[1] + entry[2] * f[2];
            }
        }
    }

    /// Factorises `Σ J_iᵀ W_i J_i + diag`; whether that went without a pivot of zero.
    pub fn factor(&mut self, weights: &[[[f64; 3]; 3]], diagonal: &[f64]) -> bool {
        self.lu.clear(&self.symbolic);
        for block in 0..self.starts.len() - 1 {
            let position = self.symbolic.position[block] as usize;
            let (place, stride) = (self.symbolic.upper_panel(position), self.symbolic.width(position));
            for (k, d) in diagonal[self.starts[block]..self.starts[block + 1]].iter().enumerate() {
                self.lu.upper[place + k * stride + k] = *d;
            }
        }
        for (contact, weight) in weights.iter().enumerate() {
            let range = self.run_offsets[contact]..self.run_offsets[contact + 1];
            for i in range.clone() {
                for j in range.start..=i {
                    self.add_product(self.runs[j], self.runs[i], weight);
                }
            }
        }
        self.lu.factor(&self.symbolic) > 0.0
    }

    /// Adds `J_aᵀ W J_b`, the part of a contact's product where two blocks meet.
    fn add_product(&mut self, a: Run, b: Run, weight: &[[f64; 3]; 3]) {
        let swapped = self.symbolic.position[a.block] > self.symbolic.position[b.block];
        let (a, b) = if swapped { (b, a) } else { (a, b) };
        let weighted = |e: &[f64; 3]| [0, 1, 2].map(|r| (0..3).map(|s| weight[r][s] * e[s]).sum::<f64>());
        let right: [[f64; 3]; 6] = {
            let mut columns = [[0.0; 3]; 6];
            let own = &self.entries[b.begin..b.end];
            if own.len() <= 6 {
                columns.iter_mut().zip(own).for_each(|(c, e)| *c = weighted(e));
            }
            columns
        };
        let (upper, upper_stride, lower) = if a.block == b.block {
            let position = self.symbolic.position[a.block] as usize;
            (self.symbolic.upper_panel(position), self.symbolic.width(position), None)
        } else {
            let place = self.symbolic.place(a.block, b.block);
            (place.upper, place.upper_stride, Some((place.lower, place.lower_stride)))
        };
        for (i, e) in self.entries[a.begin..a.end].iter().enumerate() {
            let row = upper + (a.start + i) * upper_stride + b.start;
            for (j, own) in self.entries[b.begin..b.end].iter().enumerate() {
                let w = if j < 6 && b.end - b.begin <= 6 { right[j] } else { weighted(own) };
                let product = e[0] * w[0] + e[1] * w[1] + e[2] * w[2];
                self.lu.upper[row + j] += product;
                if let Some((lower, stride)) = lower {
                    self.lu.lower[lower + (a.start + i) * stride + b.start + j] += product;
                }
            }
        }
    }

    /// Overwrites `x` with the solution.
    pub fn solve(&mut self, x: &mut [f64]) {
        self.lu.solve(&self.symbolic, x);
    }
}
