//! Other numbers for a model that is being simulated: masses, friction, sizes, gains, without building anything anew that could stay.
//!
//! A model never changes. A run that gets other numbers goes on with a model of its own, which shares the meshes of the one that was
//! compiled; so a step looks nothing up, and makes the same bits as with a model that was compiled with these numbers.

use std::sync::{Arc, OnceLock};

use signorini_multibody::{ChangedRow, Effect, FreeMotion, Kinematics, Model, Parameter, ParameterChange};

use crate::adhesion::Adhesion;
use crate::moving::Moving;
use crate::overlaps;
use crate::reach::BodyReach;
use crate::settings::Settings;
use crate::workspace::{SensorWork, Workspace, shapes_of_sensors};
use crate::{Simulation, SimulationError};

impl Workspace {
    /// Goes on with other numbers. The warm start stays; the last step's problem and solution can still be read, its sensors not.
    ///
    /// - `model`: that of this workspace; exchanged for one with these numbers
    /// - `settings`: those of this workspace
    /// - `changes`: all values of each parameter
    ///
    /// # Errors
    /// [`SimulationError::Model`] naming the part and what is wrong with its numbers, [`SimulationError::OwnOverlaps`] where the settings
    /// stop at overlaps; nothing has changed then.
    ///
    /// # Cost
    /// A copy of the model without its meshes, and what [`Effect`] says. Steps cost what they cost before.
    pub fn change(
        &mut self,
        model: &mut Arc<Model>,
        settings: &Settings,
        changes: &[ParameterChange<'_>],
    ) -> Result<(), SimulationError> {
        let changed = model.with_parameters(changes)?;
        self.take_model(model, changed, settings, changes.iter().map(|change| change.0))
    }

    fn take_model(
        &mut self,
        model: &mut Arc<Model>,
        changed: Model,
        settings: &Settings,
        parameters: impl Iterator<Item = Parameter> + Clone,
    ) -> Result<(), SimulationError> {
        let rows: Vec<ChangedRow> = parameters.flat_map(|parameter| changed.rows_unlike(model, parameter)).collect();
        if rows.is_empty() {
            return Ok(());
        }
        self.wake_all();
        if rows.iter().any(|row| row.parameter.effect() == Effect::Search) {
            let mut collider = self.collider.renewed(&changed)?;
            self.own_overlaps = overlaps::apply(&changed, settings.overlaps, &mut collider)?;
            self.reach = BodyReach::new(&changed, &collider);
            self.collider = collider;
            self.queries = shapes_of_sensors(&changed);
        }
        self.collider.take_laws(&changed);
        self.fixed_point.clear();
        self.ahead.forget();
        // Bodies that cannot move are placed here alone.
        self.kinematics = Kinematics::new(&changed);
        self.moving = Moving::of(&changed);
        self.builder.take_parameters(&changed, settings);
        self.adhesion = Adhesion::new(&changed);
        self.smooth = FreeMotion::new(&changed);
        self.sensors = SensorWork::new(&changed);
        self.changed.extend(rows.into_iter().map(|row| ((row.parameter, row.index), row.values)));
        *model = Arc::new(changed);
        Ok(())
    }
}

impl Simulation {
    /// Goes on with other numbers of the model: see [`Workspace::change`]. State, input, warm start and sums stay; a run that is being
    /// recorded needs a new recording.
    ///
    /// - `changes`: all values of each parameter
    ///
    /// # Errors
    /// [`SimulationError`] naming what is wrong; nothing has changed then.
    pub fn change(&mut self, changes: &[ParameterChange<'_>]) -> Result<(), SimulationError> {
        self.sensors();
        self.workspace.change(&mut self.model, &self.settings, changes)?;
        self.measured = true;
        self.assembled = false;
        self.model_hash = OnceLock::new();
        Ok(())
    }
}
