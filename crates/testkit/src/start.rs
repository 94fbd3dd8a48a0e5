use signorini_multibody::{Input, Model, State};

/// Where a model begins: its first keyframe, or the reference configuration; controls are zero where the keyframe has none.
pub fn start_of(model: &Model) -> (State, Input) {
    let mut state = State::new(model);
    let mut input = Input::of_control(vec![0.0; model.actuators.len()]);
    if let Some(key) = model.keyframes.first() {
        state.q.clone_from(&key.q);
        state.v.clone_from(&key.v);
        state.activation.clone_from(&key.activation);
        input.control.clone_from(&key.control);
        input.control.resize(model.actuators.len(), 0.0);
    }
    (state, input)
}
