//! The residuals of the laws of one step, whatever the law of friction.

/// Residuals of the laws of one step, relative to the data's own scales. Each is 0 for an exact solution, and none changes with the units
/// of mass, length or time.
///
/// The same six for the polygon's law ([`certify`](crate::certify)) and for the circular cone's ([`certify_cone`](crate::certify_cone)).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Certificate {
    /// `r_dyn`: `‖M(v⁺ − v^f) − J_Nᵀλ_N − J_Tᵀλ_T − J_Bᵀλ_B − J_Fᵀλ_F‖_∞`, momentum balance of the claimed `v⁺` and impulses, of each kinematic
    /// tree relative to its own mass.
    pub momentum: f64,
    /// `r_nat`: natural map of the standard LCP in one unit, `w` computed from `z` (and the free rows of bilateral
    /// constraints). Circular cone: `‖gλ − P_K(gλ − u − μ‖u_T‖n)‖` (formulation §9) with the velocities that the impulses give, which
    /// is of first order in every error, the direction of friction included.
    pub natural_map: f64,
    /// `r_sig`: `|min(g λ_N, φ/Δt + c_N)|`, Signorini's condition with the gap velocity of the claimed `v⁺`.
    pub signorini: f64,
    /// `r_cone`: friction bound, in the polygon's gauge or `max(0, ‖λ_T‖ − μ λ_N)`; friction where none can act counts in full.
    pub friction: f64,
    /// `r_mdp`: maximum dissipation, the distance from the linear program's minimum. One factor `s_v` of its scale is
    /// `max(s_v, g r)` with the bound `r` of the friction: impulses far larger than the data ask for (a light body under a heavy
    /// one, a servo that could do more than it has to) would multiply the rounding of the slip. It remains the slip that
    /// friction lets pass, in units of s_v. Circular cone: `|c_Tᵀλ_T + μ λ_N ‖c_T‖|`, of second order in the angle between the two, by
    /// `s_v²/g` at contacts.
    pub dissipation: f64,
    /// Bilateral rows `∇Θ v⁺ + Θ/Δt` with the claimed `v⁺`.
    pub bilateral: f64,
}

impl Certificate {
    /// Every residual infinite: what is claimed cannot be judged.
    pub fn everything_violated() -> Self {
        let r = f64::INFINITY;
        Self { momentum: r, natural_map: r, signorini: r, friction: r, dissipation: r, bilateral: r }
    }

    /// The residuals by their names in JSON.
    pub fn list(&self) -> [(&'static str, f64); 6] {
        [
            ("momentum", self.momentum),
            ("natural_map", self.natural_map),
            ("signorini", self.signorini),
            ("friction", self.friction),
            ("dissipation", self.dissipation),
            ("bilateral", self.bilateral),
        ]
    }

    /// The largest residual; NaN counts as infinite.
    pub fn worst(&self) -> f64 {
        self.list().into_iter().fold(0.0, |worst, (_, r)| if r.is_nan() { f64::INFINITY } else { r.max(worst) })
    }

    /// Whether every law holds within `tolerance`.
    pub fn holds(&self, tolerance: f64) -> bool {
        self.worst() <= tolerance
    }

    /// Keeps the larger of each residual.
    pub fn merge(&mut self, other: &Self) {
        keep(&mut self.momentum, other.momentum);
        keep(&mut self.natural_map, other.natural_map);
        keep(&mut self.signorini, other.signorini);
        keep(&mut self.friction, other.friction);
        keep(&mut self.dissipation, other.dissipation);
        keep(&mut self.bilateral, other.bilateral);
    }

    /// Raw residuals divided by their scales: velocities by `s_v`, impulses by `s_v/g`. The momentum's is relative already.
    pub(crate) fn relative_to(self, velocity: f64, delassus: f64) -> Self {
        Self {
            momentum: self.momentum,
            natural_map: self.natural_map / velocity,
            signorini: self.signorini / velocity,
            friction: self.friction * delassus / velocity,
            dissipation: self.dissipation * delassus / velocity / velocity,
            bilateral: self.bilateral / velocity,
        }
    }
}

/// What a residual belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LackingRow {
    /// A contact, by its index in the problem.
    Contact(usize),
    /// A friction group.
    FrictionGroup(usize),
    /// A bilateral row.
    Bilateral(usize),
}

/// How the residual of the [natural map](Certificate::natural_map) is spread over contacts, friction groups and bilateral rows. What sweeps leave
/// behind is mostly that of a few contacts: the root mean square tells how well the others are solved.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ResidualSpread {
    /// The row that lacks most.
    pub worst_row: LackingRow,
    /// What it lacks, relative to the velocity scale: `natural_map` of the certificate.
    pub worst: f64,
    /// Root mean square over all contacts, groups and rows.
    pub rms: f64,
}

/// The larger of two numbers, in one instruction; the second where one of them is none.
#[inline]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Keeps the larger value; NaN counts as infinite.
pub(crate) fn keep(largest: &mut f64, value: f64) {
    if value > *largest {
        *largest = value;
    } else if value.is_nan() {
        *largest = f64::INFINITY;
    }
}

/// `|min(z, w)|`, NaN where one of them is (`f64::min` would drop it).
pub(crate) fn natural(z: f64, w: f64) -> f64 {
    if z.is_nan() || w.is_nan() { f64::NAN } else { z.min(w).abs() }
}
