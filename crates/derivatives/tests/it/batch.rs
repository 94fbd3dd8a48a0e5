//! Derivatives of many simulations at once are those of each alone.

use crate::common::model_of;
use signorini_derivatives::{Direction, ScalarParameter, StepDerivatives, Validity};
use signorini_simulation::{Batch, Settings, Simulation};

#[test]
fn derivatives_of_a_batch_are_those_of_each_simulation() {
    let model = model_of(include_str!("../../testdata/humanoid.xml"));
    let directions: Vec<Direction> =
        vec![vec![(ScalarParameter::Timestep, 1.0)], vec![(ScalarParameter::Gravity(2), 1.0)]];
    let mut batch = Batch::new(model.clone(), Settings::default(), 5, 2).expect("a batch");
    (0..5).for_each(|i| batch.state_mut(i).v[0] = 0.1 * i as f64);
    batch.state_mut(3).v[1] = f64::NAN;
    let mut all = vec![StepDerivatives::with_parameters(&model, directions.clone()); 5];
    assert!(!StepDerivatives::step_batch(&mut batch, &mut all));
    for (i, found) in all.iter().enumerate() {
        if i == 3 {
            assert!(matches!(found.validity(), Validity::Refused { reason } if reason.contains("not made")));
            assert!(found.state_matrix().is_none());
            continue;
        }
        let mut simulation = Simulation::new(model.clone(), Settings::default()).expect("a simulation");
        let mut start = simulation.state().clone();
        start.v[0] = 0.1 * i as f64;
        simulation.set_state(&start).expect("a state");
        let mut alone = StepDerivatives::with_parameters(&model, directions.clone());
        let validity = alone.step(&mut simulation).expect("a step").clone();
        assert_eq!(&validity, found.validity(), "{i}");
        let data = |matrix: Option<signorini_lcp::Matrix>| matrix.map(|m| m.data().to_vec());
        assert_eq!(data(alone.state_matrix()), data(found.state_matrix()), "{i}");
        assert_eq!(
            alone.parameter_matrix().map(|m| m.data().to_vec()),
            found.parameter_matrix().map(|m| m.data().to_vec())
        );
    }
}
