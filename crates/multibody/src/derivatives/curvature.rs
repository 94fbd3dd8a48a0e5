//! How the rows of lengths turn with the configuration.

use glamx::glam::DVec3;

use crate::kinematics::Kinematics;
use crate::length::LengthRow;
use crate::model::{Model, Passage, Place, Segment, Tendon, walk};
use crate::motion::MotionDerivatives;

/// `∂g/∂q` of a length's row `g` in tangent coordinates, over the degrees of freedom of the row. Storage that is reused.
#[derive(Clone, Debug, Default)]
pub struct LengthCurvature {
    /// `∂g_i/∂q_j` for degrees of freedom `i` and `j` of the row, row by row, 1/m times the length's unit.
    pub by_configuration: Vec<f64>,
    /// How far the length is from another kind of way, such as along a geom that it does not touch yet: relative to the geom's radius, in rad.
    pub clearance: f64,
    /// Of the ends of a segment: how each degree of freedom moves them, and the material point that is there.
    moved: [Vec<Moved>; 2],
}

/// What a degree of freedom does to an end of a segment.
#[derive(Clone, Copy, Debug, Default)]
struct Moved {
    /// Rotation and displacement of the material point; zero where it does not move the body.
    turn: DVec3,
    shift: DVec3,
    /// Displacement of the end, which may slide along the body.
    whole: DVec3,
}

impl LengthCurvature {
    /// That of a tendon. A length that is a linear combination of coordinates has none.
    ///
    /// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at the configuration
    /// - `motion`: at the configuration, of any velocity
    /// - `row`: from [`tendon_length_into`](crate::tendon_length_into) at the configuration
    ///
    /// # Cost
    /// O(segments · dofs²) with the degrees of freedom of the row, no allocation once the storage has grown.
    pub fn set(
        &mut self,
        model: &Model,
        kinematics: &Kinematics,
        motion: &MotionDerivatives,
        tendon: &Tendon,
        row: &LengthRow,
    ) {
        self.clear(row);
        walk(
            model,
            |body| kinematics.pose[body.index()],
            &tendon.path,
            |segment| {
                if let Some(past) = &segment.past {
                    let side = past.side.map(|side| side.1);
                    self.clearance = self.clearance.min(past.obstacle.clearance(past.sites.map(|site| site.1), side));
                }
                self.add_segment(model, motion, row, segment);
            },
        );
    }

    /// Nothing, for the degrees of freedom of a row.
    fn clear(&mut self, row: &LengthRow) {
        self.by_configuration.clear();
        self.by_configuration.resize(row.dofs.len() * row.dofs.len(), 0.0);
        self.clearance = f64::INFINITY;
    }

    pub(super) fn scale(&mut self, factor: f64) {
        self.by_configuration.iter_mut().for_each(|x| *x *= factor);
    }

    /// `Σ_i (∂g_i/∂q_j) x_i` for the row's degree of freedom number `j`, with `x` of `[nv]`.
    pub fn turned(&self, row: &LengthRow, j: usize, x: &[f64]) -> f64 {
        let n = row.dofs.len();
        row.dofs.iter().enumerate().map(|(i, &k)| self.by_configuration[i * n + j] * x[k]).sum()
    }

    /// A straight part: `g_k = w u · (S_k(b) − S_k(a))`, with the direction `u` and the displacements `S_k` of the points at its ends.
    fn add_segment(&mut self, model: &Model, motion: &MotionDerivatives, row: &LengthRow, segment: &Segment) {
        let [from, to] = segment.ends;
        if from.0 == to.0 {
            return;
        }
        let (along, length) = (segment.direction(), segment.way().length());
        if length <= 0.0 {
            self.clearance = 0.0;
            return;
        }
        for (s, end) in segment.ends.into_iter().enumerate() {
            let past = segment.past.as_ref().filter(|past| past.touches == Some(s));
            let moved = &mut self.moved[s];
            moved.clear();
            moved.extend(row.dofs.iter().map(|&dof| moved_by(model, motion, dof, (end, s), past)));
        }
        let (links, n) = (&motion.links.of_dof, row.dofs.len());
        // The change of a displacement: its twist is carried by what comes before it, and its point moves.
        let turned = |by: &Moved, of: &Moved, carries: bool| {
            let carried = if carries { by.turn.cross(of.shift) - of.turn.cross(by.shift) } else { DVec3::ZERO };
            carried + of.turn.cross(by.whole)
        };
        for (j, &by) in row.dofs.iter().enumerate() {
            let [a, b] = [self.moved[0][j], self.moved[1][j]];
            let apart = b.whole - a.whole;
            let turn = (apart - along * along.dot(apart)) / length;
            for (i, &of) in row.dofs.iter().enumerate() {
                let [own_a, own_b] = [self.moved[0][i], self.moved[1][i]];
                let carries = links[by] <= links[of];
                let change = turned(&b, &own_b, carries) - turned(&a, &own_a, carries);
                self.by_configuration[i * n + j] +=
                    segment.weight * (turn.dot(own_b.shift - own_a.shift) + along.dot(change));
            }
        }
    }
}

/// What a degree of freedom does to end number `s` of a segment, which slides along what is `past` it.
fn moved_by(
    model: &Model,
    motion: &MotionDerivatives,
    dof: usize,
    ((body, point), s): (Place, usize),
    past: Option<&Passage>,
) -> Moved {
    let of = |(body, point): Place| {
        let moves = model.dofs_moving(body).any(|k| k == dof);
        if moves { motion.displacement(dof, point) } else { crate::spatial::SpatialVector::ZERO }
    };
    let own = of((body, point));
    let mut whole = own.linear;
    if let Some(past) = past {
        let moves = past.sites.map(|site| of(site).linear - of((past.carrier, site.1)).linear);
        let slid = past.obstacle.slide(past.sites.map(|site| site.1), past.side.map(|side| side.1), moves);
        // The first segment ends at the first point, the second begins at the last.
        whole += slid.map_or(DVec3::NAN, |slid| slid[1 - s]);
    }
    Moved { turn: own.angular, shift: own.linear, whole }
}
