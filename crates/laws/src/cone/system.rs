//! What the cone's methods need of the equations of motion: velocities of impulses, and the linear system of a Newton step.

/// Three numbers of each unit: of a contact normal, tangent 1, tangent 2; of a friction group (units after the contacts) its bound, or
/// the velocity of the normal that its bound follows, and its two directions.
pub(super) type Triple = [f64; 3];

/// A 3 × 3 matrix of a unit, row by row.
pub(super) type Block = [[f64; 3]; 3];

/// `u = q + W λ`, with what belongs to the equations besides the contacts (bilateral rows) kept inside.
pub(super) trait ContactSystem {
    /// Number of units: contacts, then friction groups.
    fn len(&self) -> usize;

    /// `g`: the largest diagonal entry of `W`, 1/kg; 1 where it is 0.
    fn largest_scale(&self) -> f64;

    /// The largest diagonal entry of unit `i`'s block of `W`; 1 where it is 0.
    fn scale(&self, i: usize) -> f64;

    /// `s_v`: the largest velocity without impulses, m/s.
    fn velocity_scale(&self) -> f64;

    /// Writes `u = q + W λ`. Returns the largest violation of the bilateral rows, m/s.
    fn evaluate(&mut self, impulse: &[Triple], u: &mut Vec<Triple>) -> f64;

    /// Sets ε of the proximal term of the bilateral rows.
    fn set_epsilon(&mut self, epsilon: f64);

    /// Takes the present bilateral impulses as the centre of the proximal term.
    fn recentre(&mut self);

    /// Factorises the Newton matrix for the slopes `ρ B` of all contacts; `false` if it is singular.
    fn factor(&mut self, slopes: &[Block]) -> bool;

    /// Writes the change `δu` of the velocities for `δλ = r − ρ B δu`, and keeps the change of the bilateral impulses.
    fn solve(&mut self, r: &[Triple], du: &mut Vec<Triple>);

    /// Takes the part `t` of the change of the bilateral impulses that [`solve`](Self::solve) kept.
    fn step(&mut self, t: f64);

    /// Remembers the present bilateral impulses as the best ones.
    fn keep_best(&mut self);

    /// Returns to the best bilateral impulses.
    fn restore_best(&mut self);

    /// Contact `i`'s block of `W`; zero for a friction group.
    fn block(&mut self, i: usize) -> Block;

    /// `u` of unit `i`, kept up to date by [`add_impulse`](Self::add_impulse) after [`evaluate`](Self::evaluate).
    fn velocity_of(&self, i: usize) -> Triple;

    /// Adds an impulse at unit `i`.
    fn add_impulse(&mut self, i: usize, change: Triple);

    /// Solves every bilateral row once, one after another. Returns the largest velocity that this changed, m/s.
    fn sweep_bilateral(&mut self) -> f64;
}
