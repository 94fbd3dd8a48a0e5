"""Gradients of rollouts in PyTorch and JAX, and parameters, against differences and closed forms."""

import numpy as np
import pytest

import signorini

BALL = """<mujoco><option timestep='0.01'/><worldbody><geom name='floor' type='plane' friction='0.3'/>
  <body name='ball' pos='0 0 0.1'><freejoint/><geom name='ball' size='0.1' mass='2' friction='0.5'/></body></worldbody></mujoco>"""

CART = """<mujoco><option timestep='0.01'/><worldbody><body name='cart'>
  <joint name='slide' type='slide' axis='1 0 0' damping='0.3'/><geom type='box' size='0.1 0.1 0.1' mass='1' contype='0' conaffinity='0'/>
  <body name='pole'><joint name='hinge' axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0 0 0.5' size='0.02' contype='0' conaffinity='0'/>
  </body></body></worldbody><actuator><motor joint='slide' gear='3'/></actuator></mujoco>"""


def rollout_end(model, q, v, controls):
    data = signorini.Data(model)
    blank = data.get_state(warm_start=False)
    for u in controls:
        data.set_state(blank)
        data.qpos[:], data.qvel[:], data.ctrl[:] = q, v, u
        signorini.step(model, data)
        q, v = data.qpos.copy(), data.qvel.copy()
    return q, v


def test_parameters_of_a_sliding_ball():
    model = signorini.Model.from_string(BALL)
    parameters = [("geom_friction", "ball"), ("body_mass", "ball"), ("gravity", 2), "timestep", ("geom_size", "ball", 0)]
    data = signorini.Data(model)
    data.qvel[:] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    signorini.step(model, data)
    slopes = signorini.derivatives(model, data, parameters)
    assert slopes.validity == "exact" and slopes.P.shape == (12, 5)
    # Friction brakes by μ g Δt; the mass does not matter; gravity points down; what the ball grows is pushed out within the step.
    assert np.allclose(slopes.P[6], [-9.81 * 0.01, 0.0, 0.5 * 0.01, -0.5 * 9.81, -0.5 / 0.01], atol=1e-12)
    gradient = np.zeros(6)
    gradient[0] = 1.0
    assert np.allclose(slopes.parameter_vjp(gv=gradient), slopes.P[6], atol=1e-12)
    with pytest.raises(ValueError, match="no parameter 'mass'"):
        signorini.derivatives(model, data, [("mass", "ball")])
    with pytest.raises(KeyError, match="ball"):
        signorini.derivatives(model, data, [("body_mass", "bal")])


def test_two_geoms_with_one_friction_change_together():
    model = signorini.Model.from_string(BALL.replace("0.3", "0.5"))
    data = signorini.Data(model)
    data.qvel[0] = 1.0
    signorini.step(model, data)
    with pytest.raises(ValueError, match="change both together"):
        signorini.derivatives(model, data, [("geom_friction", "ball")]).P
    both = signorini.derivatives(model, data, [("geom_friction", ["ball", "floor"])])
    assert both.P[6, 0] == pytest.approx(-9.81 * 0.01, rel=1e-12)


def test_parameters_are_set_in_a_new_model():
    model = signorini.Model.from_string(BALL)
    parameters = [("body_mass", "ball"), {("geom_friction", "ball"): 1.0, ("geom_friction", "floor"): 0.5}]
    assert signorini.parameter_values(model, parameters).tolist() == [2.0, 0.5]
    changed = signorini.with_parameters(model, parameters, [3.0, 0.7])
    assert changed.body_mass[1] == 3.0 and model.body_mass[1] == 2.0
    assert signorini.parameter_values(changed, [("geom_friction", "floor")]) == pytest.approx([0.4])
    with pytest.raises(ValueError, match="cannot be set to NaN"):
        signorini.with_parameters(model, parameters, [np.nan, 0.7])


@pytest.mark.parametrize(
    "parameter, value, told",
    [
        (("geom_friction", "ball"), -1.0, "geom 'ball': friction must be finite and not negative, found -1"),
        (("geom_size", "ball", 0), 0.0, "'ball'.* radius"),
        (("geom_size", "ball", 0), -0.1, "'ball'.* radius"),
        (("geom_restitution", "ball"), 5.0, "geom 'ball': restitution must be between 0 and 1, found 5"),
        (("geom_restitution", "ball"), -5.0, "geom 'ball': restitution must be between 0 and 1, found -5"),
        (("geom_margin", "ball"), -1.0, "geom 'ball': margin must be finite and not negative, found -1"),
        (("dof_frictionloss", 0), -1.0, "friction loss must be finite and not negative, found -1"),
        (("dof_damping", 0), -1.0, "damping must be finite and not negative, found -1"),
        (("dof_armature", 0), -1.0, "armature must be finite and not negative, found -1"),
        (("body_inertia", "ball", (0, 0)), 100.0, "body 'ball': rotational inertia .* 100"),
        (("body_mass", "ball"), -1.0, "body 'ball': mass must be finite and not negative, found -1"),
        ("timestep", 0.0, "time step must be positive and finite, found 0"),
        ("timestep", -0.5, "time step must be positive and finite, found -0.5"),
    ],
)
def test_values_out_of_range_are_refused_with_their_part_and_range(parameter, value, told):
    model = signorini.Model.from_string(BALL)
    with pytest.raises(signorini.ModelError, match=told):
        signorini.with_parameters(model, [parameter], [value])


@pytest.mark.parametrize(
    "parameter, error, told",
    [
        (("body_inertia", "ball", (0, 3)), IndexError, "'body_inertia' has no index 3"),
        (("body_inertia", "ball", (2, 9)), IndexError, "'body_inertia' has no index 9"),
        (("body_inertia", "ball", 0), ValueError, "takes a row and a column after its body, not .0."),
        (("body_inertia", "ball"), ValueError, "takes a row and a column"),
        (("body_mass", "ball", 7), ValueError, "'body_mass' takes no index, not .7."),
        (("geom_friction", "ball", 0, 1), ValueError, "takes at most one index"),
        (("geom_friction", "ball", -1), IndexError, "'geom_friction' has no index -1"),
        (("body_mass",), ValueError, "'body_mass' needs the name or index of a body"),
        (("gravity",), ValueError, "'gravity' takes one index"),
        (("timestep", 0), ValueError, "'timestep' takes no index"),
        ((), ValueError, "expected a name or a tuple"),
        ({("body_mass", "ball"): np.nan}, ValueError, "the share of .*'body_mass'.* is NaN"),
        ({("body_mass", "ball"): "much"}, ValueError, "the share of .*'body_mass'.* is much"),
    ],
)
def test_parameters_that_name_no_number_are_refused(parameter, error, told):
    with pytest.raises(error, match=told):
        signorini.parameter_values(signorini.Model.from_string(BALL), [parameter])


def test_a_name_alone_may_stand_in_a_tuple():
    assert signorini.parameter_values(signorini.Model.from_string(BALL), [("timestep",)]).tolist() == [0.01]


def central(function, x, h):
    x = np.asarray(x, float)
    out = np.zeros_like(x)
    for k in np.ndindex(x.shape):
        change = np.zeros_like(x)
        change[k] = h
        out[k] = (function(x + change) - function(x - change)) / (2 * h)
    return out


def test_torch_rollouts_have_the_gradients_of_differences():
    torch = pytest.importorskip("torch")
    import signorini.torch

    model = signorini.Model.from_string(CART)
    rng = np.random.default_rng(0)
    controls = rng.normal(size=(300, 1))
    target = np.array([0.3, 0.1])

    def loss(q, v, u):
        q, v = rollout_end(model, q, v, u)
        return float(((q - target) ** 2).sum() + 0.1 * (v**2).sum())

    q, v, u = (torch.tensor(x, dtype=torch.float64, requires_grad=True) for x in ([0.0, 0.4], [0.1, -0.2], controls))
    qs, vs = signorini.torch.rollout(model, q, v, u)
    assert qs.shape == (301, 2)
    value = ((qs[-1] - torch.tensor(target)) ** 2).sum() + 0.1 * (vs[-1] ** 2).sum()
    value.backward()
    start = [0.0, 0.4], [0.1, -0.2], controls
    assert float(value.detach()) == pytest.approx(loss(*start), rel=1e-12)
    assert np.allclose(q.grad, central(lambda x: loss(x, start[1], controls), start[0], 1e-6), rtol=1e-5)
    assert np.allclose(v.grad, central(lambda x: loss(start[0], x, controls), start[1], 1e-6), rtol=1e-5)
    some = central(lambda x: loss(start[0], start[1], np.concatenate([x, controls[3:]])), controls[:3], 1e-5)
    assert np.allclose(u.grad[:3], some, rtol=1e-5)


def test_torch_steps_in_batches_with_parameters():
    torch = pytest.importorskip("torch")
    import signorini.torch

    model = signorini.Model.from_string(BALL)
    q = torch.tensor(np.tile(signorini.Data(model).qpos, (2, 1)), requires_grad=True)
    v = torch.tensor([[1.0, 0, 0, 0, 0, 0], [0, 2.0, 0, 0, 0, 0]], dtype=torch.float64)
    theta = torch.tensor([0.5], dtype=torch.float64, requires_grad=True)
    _, after = signorini.torch.step(model, q, v, parameters=[("geom_friction", "ball")], theta=theta)
    (after[0, 0] + 2 * after[1, 1]).backward()
    assert theta.grad.numpy() == pytest.approx([-3 * 9.81 * 0.01], rel=1e-9)
    assert q.grad.shape == (2, 7)


def test_torch_says_where_there_is_no_derivative():
    torch = pytest.importorskip("torch")
    import signorini.torch

    model = signorini.Model.from_string(BALL)
    q = torch.tensor(signorini.Data(model).qpos.copy(), requires_grad=True)
    v = torch.tensor([0, 0, 0.0981, 0, 0, 0], dtype=torch.float64)
    qs, _ = signorini.torch.step(model, q, v, ties="raise")
    with pytest.raises(signorini.torch.DerivativeError, match="step 0 has a derivative on each side alone"):
        qs.sum().backward()


def test_rollouts_of_arrays_that_do_not_belong_together_are_refused():
    """They had been cut to the shorter one without a word."""
    torch = pytest.importorskip("torch")
    import signorini.torch

    model = signorini.Model.from_string(CART)
    q, v, u = (torch.zeros(shape, dtype=torch.float64) for shape in ((3, 2), (3, 2), (3, 4, 1)))
    force = torch.zeros((3, 4, 2), dtype=torch.float64)
    qs, _ = signorini.torch.rollout(model, q, v, u, force, steps=4)
    assert qs.shape == (3, 5, 2)
    for told, given in {
        r"ctrl has shape \(2, 4, 1\): it must be \(3, 4, 1\)": (q, v, u[:2]),
        r"ctrl has shape \(4, 1\): it must be \(3, 4, 1\)": (q, v, u[0]),
        r"qvel has shape \(2, 2\): it must be \(3, 2\)": (q, v[:2], u),
        r"qvel has shape \(2,\)": (q, v[0], u),
        r"qfrc_applied has shape \(3, 2, 2\): it must be \(3, 4, 2\)": (q, v, u, force[:, :2]),
        r"ctrl has shape \(4, 2\): it must be \(4, 1\)": (q[0], v[0], force[0]),
        "qpos has type torch.int64": (torch.zeros((3, 2), dtype=torch.int64), v, u),
        r"qpos has shape \(1, 3, 2\)": (q[None], v[None], u[None]),
    }.items():
        with pytest.raises(ValueError, match=told):
            signorini.torch.rollout(model, *given)
    for steps, told in ((7, r"it must be \(3, 7, 1\)"), (-1, "steps is -1")):
        with pytest.raises(ValueError, match=told):
            signorini.torch.rollout(model, q, v, u, steps=steps)


def test_jax_rollouts_of_arrays_that_do_not_belong_together_are_refused():
    jax = pytest.importorskip("jax")
    import signorini.jax

    model = signorini.Model.from_string(CART)
    q, u = np.zeros(2), np.zeros((4, 1))
    for told, given, steps in (
        ("qpos has type int", (np.zeros(2, int), q, u), None),
        ("qfrc_applied has shape", (q, q, u, np.zeros((3, 2))), None),
        ("ctrl has shape", (q, q, np.zeros((4, 2))), None),
        ("ctrl has shape", (q, q, u), 9),
        ("jax.vmap", (np.zeros((3, 2)), np.zeros((3, 2)), u), None),
    ):
        with pytest.raises(ValueError, match=told):
            signorini.jax.rollout(model, *given, steps=steps)
    starts = np.zeros((3, 2))
    assert jax.vmap(lambda q: signorini.jax.rollout(model, q, np.zeros(2), u)[0])(starts).shape == (3, 5, 2)


def test_torch_rollouts_of_no_simulations_have_no_states_and_gradients_of_zero():
    torch = pytest.importorskip("torch")
    import signorini.torch

    model = signorini.Model.from_string(CART)
    q, v, u = (torch.zeros(shape, dtype=torch.float64, requires_grad=True) for shape in ((0, 2), (0, 2), (0, 4, 1)))
    theta = torch.ones(1, dtype=torch.float64, requires_grad=True)
    qs, vs = signorini.torch.rollout(model, q, v, u, parameters=[("body_mass", "cart")], theta=theta)
    assert qs.shape == vs.shape == (0, 5, 2) and qs.dtype == torch.float64
    (qs.sum() + vs.sum()).backward()
    assert q.grad.shape == (0, 2) and u.grad.shape == (0, 4, 1) and theta.grad.tolist() == [0.0]
    after, _ = signorini.torch.step(model, q, v)
    assert after.shape == (0, 2)


def test_jax_rollouts_of_no_simulations_have_no_states_and_gradients_of_zero():
    jax = pytest.importorskip("jax")
    import signorini.jax

    model = signorini.Model.from_string(CART)
    q, v, u, theta = (jax.numpy.zeros(shape) for shape in ((0, 2), (0, 2), (0, 4, 1), (1,)))

    def rollout(q, v, u, theta):
        return signorini.jax.rollout(model, q, v, u, parameters=[("body_mass", "cart")], theta=theta + 1.0)

    def total(*given):
        qs, vs = jax.vmap(rollout, (0, 0, 0, None))(*given)
        assert qs.shape == vs.shape == (0, 5, 2)
        return qs.sum() + vs.sum()

    found = jax.grad(total, (0, 1, 2, 3))(q, v, u, theta)
    assert [x.shape for x in found] == [(0, 2), (0, 2), (0, 4, 1), (1,)] and found[3][0] == 0.0


def test_rollouts_of_activations_are_refused():
    """Their state has none: each step had begun with activations of zero, so that such actuators did nothing."""
    torch = pytest.importorskip("torch")
    import signorini.torch

    filtered = CART.replace("<motor joint='slide' gear='3'/>", "<general joint='slide' dyntype='filter' dynprm='0.1'/>")
    model = signorini.Model.from_string(filtered)
    assert model.na == 1
    start = torch.zeros(2, dtype=torch.float64)
    with pytest.raises(ValueError, match="1 activations of actuators"):
        signorini.torch.rollout(model, start, start, torch.ones((4, 1)))


def test_jax_rollouts_have_the_gradients_of_differences():
    jax = pytest.importorskip("jax")
    import signorini.jax

    jax.config.update("jax_enable_x64", True)
    model = signorini.Model.from_string(CART)
    controls = np.random.default_rng(1).normal(size=(100, 1))

    def loss(q, u):
        qs, vs = signorini.jax.rollout(model, q, np.array([0.1, -0.2]), u)
        return (qs[-1] ** 2).sum() + 0.1 * (vs[-1] ** 2).sum()

    q0 = np.array([0.0, 0.4])
    value, (by_q, by_u) = jax.jit(jax.value_and_grad(loss, argnums=(0, 1)))(q0, controls)

    def plain(q, u):
        q, v = rollout_end(model, q, [0.1, -0.2], u)
        return float((q**2).sum() + 0.1 * (v**2).sum())

    assert float(value) == pytest.approx(plain(q0, controls), rel=1e-12)
    assert np.allclose(by_q, central(lambda x: plain(x, controls), q0, 1e-6), rtol=1e-5)
    some = central(lambda x: plain(q0, np.concatenate([x, controls[2:]])), controls[:2], 1e-5)
    assert np.allclose(by_u[:2], some, rtol=1e-5)
