//! A model with what its steps, their derivatives and differences need.

use std::error::Error;

use signorini::contact::ContactMode;
use signorini::derivatives::StepDerivatives;
use signorini::multibody::{Input, Model, Saturation, State, difference_into, integrate_into};
use signorini::{Settings, StepReport, Workspace, step};
use signorini_testkit::{Random, start_of};

/// What a part of a step does, told to compare it with itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unit {
    Contact([u32; 3], ContactMode),
    Group(ContactMode),
    Servo(Saturation),
    /// The laws permitted only a part of the corrections.
    Limited,
}

pub struct Bench {
    pub model: Model,
    pub settings: Settings,
    pub workspace: Workspace,
    pub derivatives: StepDerivatives,
    /// Whether the last step was permitted only a part of its corrections.
    is_limited: bool,
}

impl Bench {
    pub fn new(model: Model) -> Result<Self, Box<dyn Error>> {
        let settings = Settings::default();
        let workspace = Workspace::new(&model, &settings)?;
        let derivatives = StepDerivatives::new(&model);
        Ok(Self { model, settings, workspace, derivatives, is_limited: false })
    }

    /// The first keyframe, or the reference configuration.
    pub fn start(&self) -> (State, Input) {
        start_of(&self.model)
    }

    pub fn step(&mut self, state: &State, input: &Input) -> Option<(State, StepReport)> {
        let mut next = state.clone();
        let report = step(&self.model, state, input, &self.settings, &mut self.workspace, &mut next).ok()?;
        self.is_limited = report.theta < 1.0 || report.clipped_gaps;
        Some((next, report))
    }

    /// Makes the step and its derivatives.
    pub fn differentiate(&mut self, state: &State, input: &Input) -> Option<State> {
        let (next, report) = self.step(state, input)?;
        self.derivatives.compute(&self.model, (state, input), &self.settings, &report, &mut self.workspace);
        Some(next)
    }

    /// What contacts, friction groups and servos do, and whether corrections are limited.
    pub fn signature(&self) -> Vec<Unit> {
        let solution = self.workspace.solution();
        let points = self.workspace.contact_points().iter().map(|p| [p.geom_a.0, p.geom_b.0, p.feature]);
        // Limits come after the points.
        let limits = (0..).map(|i| [u32::MAX, u32::MAX, i]);
        let closed = points.chain(limits).zip(&solution.modes).filter(|(_, mode)| **mode != ContactMode::Open);
        let of_contacts = closed.map(|(source, mode)| Unit::Contact(source, *mode));
        let of_groups = solution.group_modes.iter().map(|mode| Unit::Group(*mode));
        let of_servos = self.workspace.free_motion().saturation.iter().map(|side| Unit::Servo(*side));
        of_contacts.chain(of_groups).chain(of_servos).chain(self.is_limited.then_some(Unit::Limited)).collect()
    }

    /// The end of the step from a state a way `h` along a change, relative to `next`, `[2 nv]`.
    pub fn end(&mut self, given: (&State, &Input), next: &State, change: &[f64], h: f64) -> Option<Vec<f64>> {
        let (state, input) = self.moved(given.0, given.1, change, h);
        let (end, _) = self.step(&state, &input)?;
        Some(self.between(&end, next))
    }

    /// `(q⁺, v⁺)` of a step relative to those of another, `[2 nv]`.
    pub fn between(&self, end: &State, next: &State) -> Vec<f64> {
        let mut found = vec![0.0; self.model.nv];
        difference_into(&self.model, &end.q, &next.q, &mut found);
        found.extend(end.v.iter().zip(&next.v).map(|(end, own)| end - own));
        found
    }

    /// A random `(δq, δv, δu, δτ)`: of the configuration as far as a velocity of the same size moves it in a step.
    pub fn change(&self, random: &mut Random) -> Vec<f64> {
        let (nv, nu, dt) = (self.model.nv, self.model.actuators.len(), self.model.timestep);
        let sizes = [(nv, dt), (nv, 1.0), (nu, 1.0), (nv, 1.0)];
        sizes.iter().flat_map(|&(n, size)| vec![size; n]).map(|size| size * random.normal()).collect()
    }

    pub fn moved(&self, state: &State, input: &Input, change: &[f64], h: f64) -> (State, Input) {
        let (nv, nu) = (self.model.nv, self.model.actuators.len());
        let (mut state_out, mut input_out) = (state.clone(), input.clone());
        input_out.generalized_force.resize(nv, 0.0);
        integrate_into(&self.model, &state.q, &change[..nv], h, &mut state_out.q);
        (0..nv).for_each(|k| state_out.v[k] += h * change[nv + k]);
        (0..nu).for_each(|a| input_out.control[a] += h * change[2 * nv + a]);
        (0..nv).for_each(|k| input_out.generalized_force[k] += h * change[2 * nv + nu + k]);
        (state_out, input_out)
    }
}
