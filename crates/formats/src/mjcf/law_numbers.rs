//! The numbers of an actuator's law, as the elements of its default classes and its own write them over each other.
//!
//! All sorts of actuators share them, as they do in MuJoCo: `<general>` writes single numbers, every other sort makes them its own law. What
//! it does not say stays as the same sort left it, or `<general>` after it with a gain of the same form. After any other it goes on where the
//! nearest class above ends that suits it, or begins anew.

use std::f64::consts::FRAC_PI_4;

use crate::error::FormatError;
use crate::xml::{Attributes, Element};

/// What a gain or a bias is a function of (MuJoCo's `gaintype` and `biastype`).
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// Of nothing: a gain `fixed`, a bias `none`.
    Constant,
    Affine,
    Muscle,
    Other,
}

/// MuJoCo's `dyntype`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Dynamics {
    None,
    Integrator,
    Filter,
    ExactFilter,
    Muscle,
    Other,
}

/// A muscle's numbers as MuJoCo lays them out: range (2), force, scale, lmin, lmax, vmax, fpmax, fvmax.
const CURVES: [f64; 9] = [0.75, 1.05, -1.0, 200.0, 0.5, 1.6, 1.5, 1.3, 1.2];
const NAMES: [(&str, usize); 7] =
    [("force", 2), ("scale", 3), ("lmin", 4), ("lmax", 5), ("vmax", 6), ("fpmax", 7), ("fvmax", 8)];

/// What MuJoCo has as `gaintype`, `gainprm` and so on.
#[derive(Clone)]
pub(super) struct LawNumbers<'t> {
    /// The sort of the element that wrote last.
    sort: &'t str,
    pub gain_form: Form,
    pub gain: [f64; 9],
    pub bias_form: Form,
    pub bias: [f64; 9],
    pub dynamics: Dynamics,
    /// Time constants, s, and the smoothing of a muscle.
    pub dynamics_numbers: [f64; 3],
    pub early: bool,
    /// How many times as wide as the range of what it acts on that of the set point is; 0 for a range of its own.
    pub inherited_range: f64,
}

impl<'t> LawNumbers<'t> {
    /// The numbers of an actuator; `classes` as [`Defaults::classes_of`](super::defaults::Defaults::classes_of) has them.
    pub fn read(element: Element<'t>, classes: &[Vec<Element<'t>>]) -> Result<Self, FormatError> {
        let (mut numbers, mut above) = (Self::of("general"), Vec::new());
        for class in classes.iter().rev() {
            class.iter().rev().try_for_each(|layer| numbers.write(*layer, &above))?;
            above.push(numbers.clone());
        }
        numbers.write(element, &above)?;
        Ok(numbers)
    }

    /// What an actuator of a sort begins with.
    fn of(sort: &'t str) -> Self {
        let mut numbers = Self {
            sort,
            gain_form: Form::Constant,
            gain: [0.0; 9],
            bias_form: Form::Constant,
            bias: [0.0; 9],
            dynamics: Dynamics::None,
            dynamics_numbers: [1.0, 0.0, 0.0],
            early: false,
            inherited_range: 0.0,
        };
        match form_of(sort) {
            Form::Muscle => (numbers.gain, numbers.dynamics_numbers) = (CURVES, [0.01, 0.04, 0.0]),
            Form::Affine => {}
            _ => numbers.gain[0] = 1.0,
        }
        numbers
    }

    /// What multiplies the damping ratio of a servo to give its damping is known of the model alone; until then there is none.
    pub fn take_damping_ratio(&mut self) -> Option<f64> {
        let is_ratio = self.is_servo() && self.bias[2] > 0.0;
        is_ratio.then(|| std::mem::take(&mut self.bias[2]))
    }

    /// Whether the force is a gain times the difference of a set point and the length, up to what does not depend on them.
    pub fn is_servo(&self) -> bool {
        self.gain_form == Form::Constant && self.bias_form == Form::Affine && self.gain[0] == -self.bias[1]
    }

    /// Whether a sort of actuators goes on from here.
    fn suits(&self, sort: &str) -> bool {
        self.sort == sort || self.sort == "general" && self.gain_form == form_of(sort)
    }

    /// Writes what an element says; `above`: what the classes above leave, the nearest last.
    fn write(&mut self, element: Element<'t>, above: &[Self]) -> Result<(), FormatError> {
        let (sort, a) = (element.name(), element.attributes());
        if sort != "general" {
            if !self.suits(sort) {
                *self = above.iter().rev().find(|left| left.suits(sort)).cloned().unwrap_or_else(|| Self::of(sort));
            }
            (self.gain_form, self.early) = (form_of(sort), false);
        }
        self.sort = sort;
        match sort {
            "general" => self.general(&a),
            "position" | "intvelocity" => self.servo(&a),
            "velocity" => {
                self.gain[0] = a.non_negative("kv")?.unwrap_or(self.gain[0]);
                self.follow(Form::Affine, [0.0, 0.0, -self.gain[0]], Dynamics::None)
            }
            "damper" => {
                self.gain =
                    [0.0, 0.0, a.non_negative("kv")?.map_or(self.gain[2], |kv| -kv), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
                self.follow(Form::Constant, [0.0; 3], Dynamics::None)
            }
            "cylinder" => self.cylinder(&a),
            "muscle" => self.muscle(&a),
            "adhesion" => {
                self.gain[0] = a.non_negative("gain")?.unwrap_or(self.gain[0]);
                self.follow(Form::Constant, [0.0; 3], Dynamics::None)
            }
            _ => {
                self.gain[0] = 1.0;
                self.follow(Form::Constant, [0.0; 3], Dynamics::None)
            }
        }
    }

    /// Sets the bias and how the activation follows.
    fn follow(&mut self, form: Form, bias: [f64; 3], dynamics: Dynamics) -> Result<(), FormatError> {
        (self.bias_form, self.dynamics) = (form, dynamics);
        self.bias[..3].copy_from_slice(&bias);
        Ok(())
    }

    fn general(&mut self, a: &Attributes) -> Result<(), FormatError> {
        let form = |name: &'static str, constant: &str| {
            a.text(name).map(|form| match form {
                "affine" => Form::Affine,
                "muscle" => Form::Muscle,
                _ if form == constant => Form::Constant,
                _ => Form::Other,
            })
        };
        self.gain_form = form("gaintype", "fixed").unwrap_or(self.gain_form);
        self.bias_form = form("biastype", "none").unwrap_or(self.bias_form);
        if let Some(dynamics) = a.text("dyntype") {
            self.dynamics = match dynamics {
                "none" => Dynamics::None,
                "integrator" => Dynamics::Integrator,
                "filter" => Dynamics::Filter,
                "filterexact" => Dynamics::ExactFilter,
                "muscle" => Dynamics::Muscle,
                _ => Dynamics::Other,
            };
        }
        write_over(&mut self.gain, a.numbers("gainprm")?);
        write_over(&mut self.bias, a.numbers("biasprm")?);
        write_over(&mut self.dynamics_numbers, a.numbers("dynprm")?);
        self.early = a.flag("actearly")?.unwrap_or(self.early);
        self.inherited_range = a.non_negative("inheritrange")?.unwrap_or(self.inherited_range);
        Ok(())
    }

    fn servo(&mut self, a: &Attributes) -> Result<(), FormatError> {
        let kp = a.non_negative("kp")?.unwrap_or(self.gain[0]);
        let damping = match (a.non_negative("kv")?, a.non_negative("dampratio")?) {
            (Some(_), Some(ratio)) if ratio > 0.0 => {
                return Err(a.invalid("dampratio", "either 'kv' or 'dampratio'"));
            }
            (Some(kv), _) => -kv,
            // Its sign tells it from a damping.
            (None, Some(ratio)) => ratio,
            (None, None) => self.bias[2],
        };
        self.gain[0] = kp;
        self.inherited_range = a.non_negative("inheritrange")?.unwrap_or(self.inherited_range);
        let dynamics = match (self.sort, a.non_negative("timeconst")?) {
            ("intvelocity", _) => Dynamics::Integrator,
            (_, Some(0.0)) => Dynamics::None,
            (_, Some(time)) => {
                self.dynamics_numbers[0] = time;
                Dynamics::ExactFilter
            }
            (_, None) if self.dynamics == Dynamics::ExactFilter => Dynamics::ExactFilter,
            (_, None) => Dynamics::None,
        };
        self.follow(Form::Affine, [0.0, -kp, damping], dynamics)
    }

    fn cylinder(&mut self, a: &Attributes) -> Result<(), FormatError> {
        let area = a.non_negative("diameter")?.map(|d| FRAC_PI_4 * d * d);
        self.gain[0] = area.or(a.non_negative("area")?).unwrap_or(self.gain[0]);
        self.dynamics_numbers[0] = a.non_negative("timeconst")?.unwrap_or(self.dynamics_numbers[0]);
        let [constant, by_length, by_rate, ..] = self.bias;
        let bias = a.vector::<3>("bias")?.unwrap_or([constant, by_length, by_rate]);
        self.follow(Form::Affine, bias, Dynamics::Filter)
    }

    /// Negative numbers say nothing.
    fn muscle(&mut self, a: &Attributes) -> Result<(), FormatError> {
        let positive = |numbers: &mut [f64], given: Option<Vec<f64>>| {
            let given = numbers.iter_mut().zip(given.unwrap_or_default());
            given.filter(|(_, x)| *x >= 0.0).for_each(|(number, x)| *number = x);
        };
        positive(&mut self.gain[..2], a.numbers("range")?);
        positive(&mut self.dynamics_numbers[..2], a.numbers("timeconst")?);
        self.dynamics_numbers[2] = a.non_negative("tausmooth")?.unwrap_or(self.dynamics_numbers[2]);
        for (name, k) in NAMES {
            positive(&mut self.gain[k..=k], a.number(name)?.map(|x| vec![x]));
        }
        self.bias = self.gain;
        (self.bias_form, self.dynamics) = (Form::Muscle, Dynamics::Muscle);
        Ok(())
    }
}

/// The form of the gain that a sort of actuators has.
fn form_of(sort: &str) -> Form {
    match sort {
        "damper" => Form::Affine,
        "muscle" => Form::Muscle,
        _ => Form::Constant,
    }
}

fn write_over(numbers: &mut [f64], given: Option<Vec<f64>>) {
    numbers.iter_mut().zip(given.unwrap_or_default()).for_each(|(number, x)| *number = x);
}
