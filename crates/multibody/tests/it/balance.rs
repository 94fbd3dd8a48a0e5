//! Derivatives of a step's momentum balance by those of the motion that it gives: `E(v^f; p) = 0` moves with `p`, so that
//! `∂E/∂p = −M̂ dv^f/dp`, here by central differences of whole steps.

use signorini_multibody::derivatives::{
    BalanceAt, BalanceChange, BalanceDerivatives, InertiaChange, JointChange, balance_derivatives_into,
};
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{
    Activation, ActivationKind, Actuator, ActuatorId, ActuatorKind, BodyId, FreeMotion, Geometry, Input, Joint,
    JointId, JointKind, Model, ModelBuilder, Muscle, SpatialVector, State, Tendon, TendonId, Transmission,
    integrate_into,
};

use crate::free_motion::free_motion;
use crate::identities::kinematics;
use crate::random_model::{Random, Recipe, for_random_models};

/// Step of the central differences.
const H: f64 = 1e-5;

/// What a step is given.
#[derive(Clone)]
struct Given {
    model: Model,
    state: State,
    input: Input,
    dt: f64,
}

/// Where the balance is differentiated.
struct Step {
    given: Given,
    free: FreeMotion,
    balance: BalanceDerivatives,
}

impl Step {
    /// Nothing where something turns too fast.
    fn of(given: Given) -> Option<Self> {
        let Given { model, state, input, dt } = &given;
        let free = free_motion(model, state, input, *dt);
        let (mut balance, at) = (BalanceDerivatives::new(model), kinematics(model, state));
        let end = (&free.free_velocity[..], &vec![SpatialVector::ZERO; model.bodies.len()][..]);
        if free.unresolved_rotations > 0 {
            return None;
        }
        balance_derivatives_into(model, &at, (state, input), *dt, &free, end, &mut balance).unwrap();
        Some(Self { free, balance, given })
    }

    /// Checks slopes by what is given at `h`.
    fn check(&self, what: &str, slopes: &[f64], vary: impl Fn(&mut Given, f64)) {
        let [before, after] = [-H, H].map(|h| {
            let mut given = self.given.clone();
            vary(&mut given, h);
            free_motion(&given.model, &given.state, &given.input, given.dt).free_velocity
        });
        let change: Vec<f64> = after.iter().zip(&before).map(|(a, b)| (b - a) / (2.0 * H)).collect();
        let mut expected = vec![0.0; change.len()];
        self.free.mass.matrix.multiply_into(&change, &mut expected);
        let size = expected.iter().chain(&self.free.free_velocity).fold(1.0_f64, |s, x| s.max(x.abs()));
        for (k, (found, expected)) in slopes.iter().zip(&expected).enumerate() {
            assert!((found - expected).abs() < 1e-6 * size, "{what}, dof {k}: {found} and {expected}");
        }
    }

    fn slopes(&self, change: &BalanceChange) -> Vec<f64> {
        let Given { model, state, input, dt } = &self.given;
        let mut out = vec![0.0; model.nv];
        let at = BalanceAt {
            model,
            kinematics: &kinematics(model, state),
            state,
            input,
            dt: *dt,
            free: &self.free,
            velocity: &self.free.free_velocity,
            impulses: &vec![SpatialVector::ZERO; model.bodies.len()],
            balance: &self.balance,
        };
        at.add(change, &mut out);
        out
    }

    fn check_states(&self) {
        let nv = self.given.model.nv;
        let column = |matrix: &[f64], k: usize| (0..nv).map(|row| matrix[row * nv + k]).collect::<Vec<_>>();
        for k in 0..nv {
            let mut unit = vec![0.0; nv];
            unit[k] = 1.0;
            self.check("configuration", &column(&self.balance.by_configuration, k), |given, h| {
                integrate_into(&given.model, &self.given.state.q, &unit, h, &mut given.state.q);
            });
            self.check("velocity", &column(&self.balance.by_velocity, k), |given, h| given.state.v[k] += h);
        }
        self.check("time step", &self.slopes(&BalanceChange::Timestep(1.0)), |given, h| given.dt += h);
    }

    fn check_bodies(&self, random: &mut Random) {
        let toward = random.direction();
        let vary = |given: &mut Given, h: f64| given.model.gravity += toward * h;
        self.check("gravity", &self.slopes(&BalanceChange::Gravity(toward)), vary);
        for b in 1..self.given.model.bodies.len() {
            let part = DMat3::from_cols(random.vector(0.1), random.vector(0.1), random.vector(0.1));
            let (mass, center_of_mass) = (random.uniform(-1.0, 1.0), random.vector(0.5));
            let change = InertiaChange { mass, center_of_mass, rotational: part + part.transpose() };
            self.check("inertia", &self.slopes(&BalanceChange::Inertia(BodyId(b as u32), change)), |given, h| {
                let inertia = &mut given.model.bodies[b].inertia;
                inertia.mass += change.mass * h;
                inertia.center_of_mass += change.center_of_mass * h;
                inertia.rotational += change.rotational * h;
            });
        }
        for j in 0..self.given.model.joints.len() {
            let mut change = JointChange { damping: random.uniform(-1.0, 1.0), ..JointChange::default() };
            // With a rotor a ball or a free joint would no longer turn freely.
            if self.given.model.joints[j].kind.nv() == 1 {
                change.armature = random.uniform(-1.0, 1.0);
                (change.stiffness, change.spring_reference) = (random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
            }
            self.check("joint", &self.slopes(&BalanceChange::Joint(JointId(j as u32), change)), |given, h| {
                let joint = &mut given.model.joints[j];
                joint.damping += change.damping * h;
                joint.armature += change.armature * h;
                joint.stiffness += change.stiffness * h;
                joint.spring_reference += change.spring_reference * h;
            });
        }
    }

    fn check_actuators(&self) {
        let nu = self.given.model.actuators.len();
        for (a, actuator) in self.given.model.actuators.iter().enumerate() {
            let column: Vec<f64> = self.balance.by_control.iter().skip(a).step_by(nu).copied().collect();
            self.check(&actuator.name, &column, |given, h| given.input.control[a] += h);
            if let Some(activation) = &actuator.activation {
                let slopes = self.slopes(&BalanceChange::Activation(ActuatorId(a as u32), 1.0));
                self.check(&actuator.name, &slopes, |given, h| given.state.activation[activation.index] += h);
            }
        }
    }
}

/// Trees and bodies that turn freely, by less and by more than a tenth of a radian in a step, and at rest, where Coriolis forces are none but have a
/// slope, with springs and dampers.
#[test]
fn balances_have_the_slopes_of_whole_steps() {
    for (seed, floating, armature, dt) in [(1, true, false, 0.2), (2, false, true, 0.02), (3, true, true, 0.02)] {
        for_random_models(700 + seed, Recipe { bodies: 4, floating, armature }, |model, state, random| {
            let mut model = model.clone();
            for joint in model.joints.iter_mut().filter(|joint| joint.kind.nv() == 1) {
                (joint.damping, joint.stiffness) = (random.uniform(0.5, 2.0), random.uniform(5.0, 20.0));
                joint.spring_reference = random.uniform(-0.5, 0.5);
            }
            model.joints.iter_mut().filter(|joint| joint.kind == JointKind::Ball).for_each(|joint| joint.damping = 0.7);
            let input = Input::of_force(random.list(model.nv, 2.0));
            let at_rest = State::at(state.q.clone(), vec![0.0; model.nv]);
            for state in [state.clone(), at_rest] {
                if let Some(step) = Step::of(Given { model: model.clone(), state, input: input.clone(), dt }) {
                    step.check_states();
                    step.check_bodies(random);
                }
            }
        });
    }
}

/// A trunk with two branches, a tendon with spring and damper across all three, a ball that is pulled along its rotation vector, and actuators
/// with every kind of activation that acts in the step in which it moves.
#[test]
fn balances_have_the_slopes_of_actuators_and_tendons() {
    let mut builder = ModelBuilder::new("branches");
    let shape = Geometry::Box { half_extents: DVec3::new(0.1, 0.2, 0.3) };
    let hinge = |name: &str, axis| Joint::hinge(name, axis).with_anchor([0.1, 0.2, -0.3]);
    let trunk = builder.body("trunk").joint(hinge("trunk", DVec3::Y)).solid(shape.clone(), 2.0).add().unwrap();
    for (name, x) in [("left", 0.4), ("right", -0.4)] {
        let part = builder.body(name).on(trunk).at([x, 0.0, 0.5]).joint(hinge(name, DVec3::X));
        part.solid(shape.clone(), 1.0).add().unwrap();
    }
    builder
        .body("ball")
        .at([3.0, 0.0, 0.0])
        .joint(Joint::new("ball", JointKind::Ball))
        .solid(shape, 1.5)
        .add()
        .unwrap();
    let terms = [0.7, -1.2, 0.9].into_iter().enumerate().map(|(j, weight)| (JointId(j as u32), weight)).collect();
    builder.add_tendon(Tendon::new("across", terms).with_stiffness(30.0).with_damping(4.0).with_rest([0.1, 0.2]));
    let servo = ActuatorKind::Position { kp: 40.0, kv: 3.0 };
    let early = |kind| Activation::new(kind).with_early(true).with_range(Some([-1.0, 1.0]));
    let axes = [0.5, -0.3, 0.8, 0.0, 0.0, 0.0];
    let muscle = ActuatorKind::Muscle(Muscle::new(100.0, [-2.0, 3.0]));
    let kinds = [
        (Transmission::Joint(JointId(0)), servo, ActivationKind::Integrator),
        (Transmission::Joint(JointId(1)), servo, ActivationKind::Filter { time_constant: 0.2 }),
        (Transmission::Tendon(TendonId(0)), servo, ActivationKind::ExactFilter { time_constant: 0.3 }),
        (Transmission::Joint(JointId(2)), muscle, ActivationKind::Muscle { times: [0.1, 0.2], smoothing: 0.1 }),
        (Transmission::JointAxes { joint: JointId(3), axes }, servo, ActivationKind::Integrator),
    ];
    for (k, (transmission, kind, activation)) in kinds.into_iter().enumerate() {
        let actuator = Actuator::new(format!("actuator {k}"), transmission, kind).with_gear(1.3);
        builder.add_actuator(actuator.with_activation(early(activation)));
    }
    let model = builder.build().unwrap();
    let mut random = Random(71);
    for _ in 0..10 {
        let (mut state, control) = (State::new(&model), random.list(5, 0.9).iter().map(|u| 0.05 + u.abs()).collect());
        state.v = random.list(model.nv, 2.0);
        let turn = random.list(model.nv, 0.8);
        integrate_into(&model, &model.reference_configuration(), &turn, 1.0, &mut state.q);
        // One is beyond its range, where it does not move the force.
        let mut activation: Vec<f64> = random.list(5, 0.4).iter().map(|a| 0.5 + a).collect();
        activation[0] = 1.2;
        let state = state.with_activation(activation);
        let input = Input::default().with_control(control);
        let step = Step::of(Given { model: model.clone(), state, input, dt: 0.02 }).unwrap();
        step.check_states();
        step.check_actuators();
        // A centre that leaves the origin of its body: a first moment arises, and the inertia about the origin stays to first order.
        let center_of_mass = random.direction();
        for b in 1..model.bodies.len() {
            let change =
                BalanceChange::Inertia(BodyId(b as u32), InertiaChange { center_of_mass, ..InertiaChange::ZERO });
            step.check("centre", &step.slopes(&change), |given, h| {
                given.model.bodies[b].inertia.center_of_mass += center_of_mass * h;
            });
        }
    }
}
