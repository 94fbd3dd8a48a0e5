//! Contacts, friction groups and the edges of their polygons, as the interior point has them.

/// An edge of a unit's polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub normal: [f64; 2],
    /// `μ h`.
    pub reach: f64,
    pub distance: f64,
    pub multiplier: f64,
    pub distance_rate: f64,
    pub multiplier_rate: f64,
    /// What the corrector takes from the product.
    pub correction: f64,
    /// Place of its multiplier among the unknowns of the unit's system, where it is near the impulse.
    pub place: Option<usize>,
}

/// A contact or a friction group.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Unit {
    /// Its edges in the list of all.
    pub edges: (usize, usize),
    /// The contact whose normal impulse bounds its friction; none where the bound is constant.
    pub bounded_by: Option<usize>,
    /// The velocity of `bounded_by`'s normal is the first row of the unit divided by this.
    pub row_factor: f64,
    /// Whether it has a normal pair: contacts do.
    pub has_normal: bool,
    pub compliance: f64,
    pub impulse: [f64; 3],
    pub slack: f64,
    pub impulse_rate: [f64; 3],
    pub slack_rate: f64,
    pub correction: f64,
    /// `u_N − s` and `u_T + Σ γ n`.
    pub normal_residual: f64,
    pub tangential_residual: [f64; 2],
    /// How the impulse falls with the velocity.
    pub slope: [[f64; 3]; 3],
    /// The rate of the impulse at a constant velocity.
    pub drive: [f64; 3],
}
