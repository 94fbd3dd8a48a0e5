//! What the next step starts from beside the state: impulses, what was withheld, who sleeps.

use signorini_multibody::BodyId;

use crate::SimulationError;
use crate::sleepers::take_in;
use crate::withheld::Withheld;
use crate::workspace::Workspace;

impl Workspace {
    /// The last solution in the form that the next step starts from, as plain numbers: stored with `(t, q, v)` and given
    /// back to [`set_warm_start`](Self::set_warm_start), a run goes on with the same bits.
    pub fn warm_start(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        self.withheld.write(&mut numbers);
        if let Some(part) = self.sleepers.part() {
            let mut all = self.warm.clone();
            take_in(&mut all, &part);
            all.write(&mut numbers);
        } else {
            self.warm.write(&mut numbers);
        }
        numbers
    }

    /// Takes over a [`warm_start`](Self::warm_start) of the same model.
    ///
    /// # Errors
    /// [`SimulationError::WarmStart`] if the numbers are not those of a warm start; nothing has changed then.
    pub fn set_warm_start(&mut self, numbers: &[f64]) -> Result<(), SimulationError> {
        self.fixed_point.clear();
        let wrong = SimulationError::WarmStart { found: numbers.len() };
        let Some((withheld, rest)) = Withheld::read(numbers) else { return Err(wrong) };
        self.warm.read(rest).ok_or(wrong)?;
        self.withheld = withheld;
        self.forget_sleepers();
        Ok(())
    }

    /// Whether the last step left a body alone, because the bodies around it and it stood as they had stood before
    /// ([`Settings::sleeping`](crate::Settings::sleeping)). Its contacts are among those of the step.
    pub fn sleeps(&self, body: BodyId) -> bool {
        self.sleepers.was_left_alone(body)
    }

    /// Forgets the last solution, so that the next step starts cold.
    pub fn clear_warm_start(&mut self) {
        self.fixed_point.clear();
        self.warm.clear();
        self.withheld = Withheld::default();
        self.sleepers.holds = false;
        self.forget_sleepers();
    }
}
