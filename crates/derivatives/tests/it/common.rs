//! Steps of models, their derivatives, and differences of the steps themselves.

use signorini_contact::ContactMode;
use signorini_derivatives::{StepDerivatives, Validity};
use signorini_formats::load_mjcf_str;
use signorini_multibody::{Input, Model, State, difference_into, integrate_into};
use signorini_simulation::{ContactSource, Settings, Workspace, step};
use signorini_testkit::{Random, start_of};

pub fn model_of(text: &str) -> Model {
    load_mjcf_str(text, ".").expect("a model").model
}

/// A model with what its steps need.
pub struct Bench {
    pub model: Model,
    pub settings: Settings,
    pub workspace: Workspace,
    pub derivatives: StepDerivatives,
}

/// What the contacts and friction groups of a step do, by their sources.
pub type Signature = Vec<String>;

impl Bench {
    pub fn new(model: Model, settings: Settings) -> Self {
        let workspace = Workspace::new(&model, &settings).expect("a workspace");
        let derivatives = StepDerivatives::new(&model);
        Self { model, settings, workspace, derivatives }
    }

    /// The first keyframe, or the reference configuration.
    pub fn start(&self) -> (State, Input) {
        let (state, mut input) = start_of(&self.model);
        input.generalized_force = vec![0.0; self.model.nv];
        (state, input)
    }

    /// Makes the step and its derivatives.
    pub fn differentiate(&mut self, state: &State, input: &Input) -> Option<State> {
        let mut next = state.clone();
        let Self { model, settings, workspace, derivatives } = self;
        let report = step(model, state, input, settings, workspace, &mut next).ok()?;
        derivatives.compute(model, (state, input), settings, &report, workspace);
        Some(next)
    }

    pub fn end(&mut self, state: &State, input: &Input) -> (Vec<f64>, Vec<f64>, Signature) {
        let mut next = state.clone();
        step(&self.model, state, input, &self.settings, &mut self.workspace, &mut next).expect("a step");
        (next.q, next.v, self.signature())
    }

    /// What the last step's contacts do.
    pub fn signature(&self) -> Signature {
        let solution = self.workspace.solution();
        let contacts = solution.modes.iter().enumerate().filter(|(_, mode)| **mode != ContactMode::Open);
        let source = |i| match self.workspace.contact_source(i) {
            Some(ContactSource::Point(p)) => format!("{} {} {}", p.geom_a.0, p.geom_b.0, p.feature),
            other => format!("{other:?}"),
        };
        let mut signature: Signature = contacts.map(|(i, mode)| format!("{} {mode:?}", source(i))).collect();
        signature.extend(solution.group_modes.iter().map(|mode| format!("{mode:?}")));
        signature.extend(self.workspace.free_motion().saturation.iter().map(|side| format!("{side:?}")));
        signature
    }

    /// The state and input a way `h` along a change `(δq, δv, δu, δτ)`.
    pub fn moved(&self, state: &State, input: &Input, change: &[f64], h: f64) -> (State, Input) {
        let (nv, nu) = (self.model.nv, self.model.actuators.len());
        let (mut state_out, mut input_out) = (state.clone(), input.clone());
        integrate_into(&self.model, &state.q, &change[..nv], h, &mut state_out.q);
        (0..nv).for_each(|k| state_out.v[k] += h * change[nv + k]);
        (0..nu).for_each(|a| input_out.control[a] += h * change[2 * nv + a]);
        (0..nv).for_each(|k| input_out.generalized_force[k] += h * change[2 * nv + nu + k]);
        (state_out, input_out)
    }

    /// `(q⁺, v⁺)` at `h` along a change less that at `-h`, over `2 h`, `[2 nv]`; whether both are in the mode of `signature`.
    pub fn central(
        &mut self,
        (state, input): (&State, &Input),
        change: &[f64],
        h: f64,
        (next, signature): (&State, &Signature),
    ) -> (Vec<f64>, bool) {
        let nv = self.model.nv;
        let mut stays = true;
        let mut sides = [1.0, -1.0].map(|sign| {
            let (state, input) = self.moved(state, input, change, sign * h);
            let (q, v, own) = self.end(&state, &input);
            stays &= own == *signature;
            let mut place = vec![0.0; nv];
            difference_into(&self.model, &q, &next.q, &mut place);
            place.extend(v);
            place
        });
        let [ahead, behind] = &mut sides;
        (ahead.iter().zip(behind.iter()).map(|(a, b)| (a - b) / (2.0 * h)).collect(), stays)
    }

    /// Richardson's extrapolation of central differences, exact to `h⁶`; nothing where they leave the mode.
    pub fn extrapolated(
        &mut self,
        given: (&State, &Input),
        change: &[f64],
        h: f64,
        end: (&State, &Signature),
    ) -> Option<Vec<f64>> {
        let estimates = [h, h / 2.0, h / 4.0].map(|h| self.central(given, change, h, end));
        let [(coarse, true), (middle, true), (fine, true)] = estimates else { return None };
        let better = |fine: &[f64], coarse: &[f64], order: f64| -> Vec<f64> {
            fine.iter().zip(coarse).map(|(f, c)| f + (f - c) / (order - 1.0)).collect()
        };
        let (first, second) = (better(&middle, &coarse, 4.0), better(&fine, &middle, 4.0));
        Some(better(&second, &first, 16.0))
    }

    /// A random change `(δq, δv, δu, δτ)`: of the configuration as far as a velocity of the same size moves it in a step, of the applied
    /// force as much as turns it into such a velocity.
    pub fn random_change(&self, random: &mut Random) -> Vec<f64> {
        let (nv, nu, dt) = (self.model.nv, self.model.actuators.len(), self.model.timestep);
        let mut change = random_vector(random, nv, dt);
        change.extend(random_vector(random, nv, 1.0));
        change.extend(random_vector(random, nu, 1.0));
        change.extend(random_vector(random, nv, 1.0));
        change
    }

    /// The relative distance of the derivative's product from differences of the step that stay in the mode, the least over several widths:
    /// wide ones are not linear, narrow ones are rounding. Nothing where all of them leave it.
    pub fn error_along(&mut self, state: &State, input: &Input, change: &[f64], next: &State) -> Option<f64> {
        let product = self.derivatives.product(change).expect("a derivative");
        let size = product.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
        let signature = self.signature();
        let mut least = None;
        // Last digits of a step, over a shorter way, are more than what is asked for.
        for h in [1e-2, 1e-3, 1e-4, 1e-5] {
            let Some(found) = self.extrapolated((state, input), change, h, (next, &signature)) else { continue };
            let off = found.iter().zip(&product).fold(0.0, |s: f64, (x, y)| s.max((x - y).abs()));
            least = Some(f64::min(least.unwrap_or(f64::INFINITY), off / size));
            if off / size < 1e-8 {
                break;
            }
        }
        least
    }

    pub fn is_exact(&self) -> bool {
        *self.derivatives.validity() == Validity::Exact
    }
}

/// Normal numbers.
pub fn random_vector(random: &mut Random, n: usize, size: f64) -> Vec<f64> {
    (0..n).map(|_| size * random.normal()).collect()
}

/// A state disturbed in configuration, velocity and control.
pub fn disturbed(bench: &Bench, random: &mut Random, state: &State, input: &Input, size: [f64; 3]) -> (State, Input) {
    let (nv, nu) = (bench.model.nv, bench.model.actuators.len());
    let mut change = random_vector(random, nv, size[0]);
    change.extend(random_vector(random, nv, size[1]));
    change.extend(random_vector(random, nu, size[2]));
    change.extend(random_vector(random, nv, 0.0));
    bench.moved(state, input, &change, 1.0)
}
