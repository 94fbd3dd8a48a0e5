"""The solvers alone: LCPs, contact problems, linear complementarity systems."""

import numpy as np
import pytest
import scipy.sparse
from lemkelcp import lemkelcp as reference

import signorini
from signorini import ContactMode, ContactProblem, solve_lcp
from signorini.lemkelcp import lemkelcp


def definite(rng, n):
    a = rng.normal(size=(n, n))
    return a @ a.T + 0.1 * np.eye(n), rng.normal(size=n)


@pytest.mark.parametrize("method", signorini.lcp_methods())
def test_every_method_finds_the_only_solution_of_a_definite_problem(method):
    rng = np.random.default_rng(3)
    for n in (1, 3, 8):
        A, b = definite(rng, n)
        result = solve_lcp(A, b, method)
        assert result.solved and result.status == "solved" and result.residual < 1e-9
        assert np.minimum(result.z, result.w) == pytest.approx(np.zeros(n), abs=1e-9)
        assert result.w == pytest.approx(A @ result.z + b) and ((result.z > 0) <= result.basis).all()


def test_sparse_lists_and_mixed():
    A, b = [[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0]
    dense = solve_lcp(A, b).z
    assert dense == pytest.approx([4 / 3, 7 / 3])
    assert np.array_equal(solve_lcp(scipy.sparse.csr_matrix(A), b).z, dense)
    free = solve_lcp([[1.0, -2.0], [2.0, 1.0]], [-1.0, 5.0], free=[True, False])
    assert free.solved and free.z == pytest.approx([1.0, 0.0]) and free.w == pytest.approx([0.0, 7.0])
    warm = solve_lcp(A, b, "lemke", warm_start=solve_lcp(A, b).basis)
    assert warm.solved and warm.iterations == 0


def test_what_has_no_solution_comes_with_a_proof_or_a_ray():
    A, b = np.array([[-1.0, 0.0], [0.0, 1.0]]), np.array([-1.0, -1.0])
    result = solve_lcp(A, b)
    assert not result.solved and result.farkas is not None
    assert (result.farkas >= 0).all() and (A.T @ result.farkas <= 1e-12).all() and b @ result.farkas < 0
    jammed = solve_lcp([[0.0, 1.0], [0.0, 0.0]], [-1.0, 0.0], "lemke")
    assert jammed.solved == (jammed.residual < 1e-9)


def test_what_complementarity_excludes_comes_with_its_cases():
    A, b = np.array([[0.0, 1.0], [0.0, 1.0]]), np.array([-1.0, 1.0])
    result = solve_lcp(A, b)
    assert result.status == "no_solution" and result.farkas is None and result.exclusion is not None
    assert solve_lcp(A, b, "lemke", explain=False).status == "unresolved"
    decided = set()
    for z_zero, w_zero, y in result.exclusion:
        decided.add((tuple(z_zero), tuple(w_zero)))
        may_be_positive = [i for i in range(2) if i not in w_zero]
        assert (y[may_be_positive] >= 0).all() and b @ y < 0
        assert all((A.T @ y)[j] <= 1e-12 for j in range(2) if j not in z_zero)
    assert decided == {((1,), ()), ((), (1,))}


def test_stages_and_history():
    free = [0.3, -0.2, -1.0, 4.0, 1.0, -0.5]
    problem = ContactProblem(np.eye(6), np.eye(6)[[2, 5]], np.eye(6)[[0, 1, 3, 4]], [0.0, 0.0], 0.5, 0.01, free)
    assert problem.solve().history == [] and problem.solve("lemke").stages == {}
    solution = problem.solve(record_history=True)
    assert solution.solved and list(solution.stages)[-1] == "proximal"
    # Two masses without ties are two islands; each that came to a stage was ended there or went on.
    assert solution.stages["proximal"].asked == solution.stages["proximal"].ended == 2
    assert sum(stage.time_share for stage in solution.stages.values()) == pytest.approx(1.0)
    runs = [run for run in solution.history if run.stage == "proximal"]
    assert sorted(run.island for run in runs) == [0, 1] and all(run.outcome == "solved" for run in runs)
    assert all(run.residuals[-1] <= 1e-12 for run in runs)


def test_stages_of_steps():
    model = signorini.Model.from_string(
        "<mujoco><worldbody><geom type='plane'/><body pos='0 0 0.1'><freejoint/><geom type='box' size='0.1 0.1 0.1'/></body>"
        "</worldbody></mujoco>"
    )
    for timed in (False, True):
        data = signorini.Data(model, settings=signorini.Settings(solver=signorini.SolverSettings(time_stages=timed)))
        signorini.step(model, data)
        assert data.report.stages["hold"].ended == 0 and sum(stage.ended for stage in data.report.stages.values()) == 1
        signorini.step(model, data)
        held = data.report.stages["hold"]
        assert (held.asked, held.ended, held.time_share) == (1, 1, 1.0 if timed else None)


def test_malformed_problems_are_refused():
    with pytest.raises(signorini.ProblemError, match="b has shape"):
        solve_lcp(np.eye(2), [1.0])
    with pytest.raises(signorini.ProblemError, match="square"):
        solve_lcp(np.ones((2, 3)), [1.0, 1.0])
    with pytest.raises(signorini.ProblemError, match=r"A\[0, 1\]"):
        solve_lcp([[1.0, np.nan], [0.0, 1.0]], [1.0, 1.0])
    with pytest.raises(signorini.ProblemError, match="cannot be read"):
        solve_lcp("A", [1.0])
    with pytest.raises(signorini.SettingError, match="simplex"):
        solve_lcp(np.eye(2), [1.0, 1.0], "simplex")
    with pytest.raises(signorini.ProblemError, match="warm_start has 1 entries, expected 2"):
        solve_lcp(np.eye(2), [1.0, 1.0], warm_start=[True])
    with pytest.raises(signorini.ProblemError, match="A cannot be read .* complex"):
        solve_lcp(np.eye(2) * 1j, [1.0, 1.0])


def test_the_shim_answers_like_the_package_that_it_stands_for(monkeypatch):
    # The package assigns to ranges, which only the lists of Python 2 allow.
    monkeypatch.setattr(reference, "range", lambda *bounds: list(range(*bounds)), raising=False)
    rng = np.random.default_rng(4)
    cases = [definite(rng, n) for n in (2, 5, 9)]
    cases += [(np.eye(2), np.ones(2)), (-np.eye(2), -np.ones(2))]
    for M, q in cases:
        expected, given = reference.lemkelcp(M, q), signorini.lemkelcp(M, q)
        assert expected[1:] == given[1:] and type(expected) is type(given)
        if expected[0] is None:
            assert given[0] is None
        else:
            assert given[0] == pytest.approx(expected[0], abs=1e-9)
    assert signorini.lemkelcp.lemkelcp is lemkelcp is signorini.lemkelcp
    M, q = definite(rng, 12)
    assert signorini.lemkelcp(M, q, maxIter=1) == (None, 2, "Max Iterations Exceeded") == reference.lemkelcp(M, q, 1)


def sliding_mass(speed, mu=0.5, **options):
    """A point mass of 2 kg on a floor that pushes down with 3 N·s and has a speed along x."""
    return ContactProblem(2 * np.eye(3), [[0, 0, 1]], [[1, 0, 0], [0, 1, 0]], [0.0], [mu], 0.01, [speed, 0, -1.5], **options)


@pytest.mark.parametrize("method", ["structured", "lemke", "automatic"])
def test_a_point_mass_sticks_and_slides_as_coulomb_says(method):
    stuck, sliding = sliding_mass(0.5).solve(method), sliding_mass(2.0).solve(method)
    assert stuck.solved and stuck.v == pytest.approx([0, 0, 0], abs=1e-9)
    assert stuck.impulse == pytest.approx(np.array([[3.0, -1.0, 0.0]])) and stuck.mode.tolist() == [ContactMode.STICKING]
    assert sliding.v == pytest.approx([2 - 0.5 * 3 / 2, 0, 0]) and sliding.mode.tolist() == [ContactMode.SLIDING]
    assert sliding.beta == pytest.approx([1.25]) and sliding.direction.tolist() == [[4, -1]]
    assert sliding.alpha.sum() == pytest.approx(1.5) and len(sliding.z) == 2 + 8


def test_data_of_a_problem_come_back(tmp_path):
    square = np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])
    problem = sliding_mass(1.0, directions=[square])
    assert (problem.nv, problem.nc, problem.dt) == (3, 1, 0.01) and np.array_equal(problem.D, square)
    assert np.array_equal(problem.Jt, [[1, 0, 0], [0, 1, 0]]) and problem.direction_offsets.tolist() == [0, 4]
    sparse = ContactProblem(scipy.sparse.eye(3) * 2, scipy.sparse.csr_matrix([[0, 0, 1.0]]), problem.Jt, [0.0], 0.5, 0.01,
                            [1, 0, -1.5], [square])
    for array in ("M", "Jn", "Jt", "phi", "mu", "v_free", "D"):
        assert np.array_equal(getattr(sparse, array), getattr(problem, array))
    problem.save(tmp_path / "problem.npz")
    again = ContactProblem.load(tmp_path / "problem.npz")
    assert np.array_equal(again.solve().v, problem.solve().v)
    A, b = problem.lcp()
    assert A.shape == (6, 6) and solve_lcp(A, b).z == pytest.approx(problem.solve().z, abs=1e-9)
    A, b, free = problem.mixed_lcp()
    assert free.tolist() == [True] * 3 + [False] * 6
    assert solve_lcp(A, b, free=free.tolist()).z[:3] == pytest.approx(problem.solve().v, abs=1e-9)


def test_bilateral_rows_hold():
    problem = ContactProblem(np.diag([1.0, 3.0]), np.zeros((0, 2)), np.zeros((0, 2)), [], [], 0.1, [1.0, 5.0],
                             Jb=[[1.0, -1.0]], theta=[0.02])
    solution = problem.solve()
    assert solution.v[0] - solution.v[1] == pytest.approx(-0.2) and solution.v @ [1, 3] == pytest.approx(16.0)
    assert problem.theta.tolist() == [0.02] and problem.Jb.tolist() == [[1.0, -1.0]] and len(solution.lambda_b) == 1


def test_a_warm_start_gives_the_same_solution_with_less_work(cards):
    data = signorini.Data(cards)
    data.qvel[6:12] = 0.3
    signorini.step(cards, data)
    problem = data.problem()
    cold = problem.solve()
    warm = problem.solve(warm_start=cold)
    assert warm.solved and warm.v == pytest.approx(cold.v, abs=1e-9) and warm.iterations <= cold.iterations


def test_malformed_contact_problems_are_refused():
    one = np.eye(3)
    with pytest.raises(signorini.ProblemError, match=r"Jt has shape \[1, 3\], expected \(2, 3\)"):
        ContactProblem(one, one[:1], one[:1], [0.0], 0.5, 0.01, np.zeros(3))
    with pytest.raises(signorini.ProblemError, match="positive definite"):
        ContactProblem(-one, one[:1], one[1:], [0.0], 0.5, 0.01, np.zeros(3))
    with pytest.raises(signorini.ProblemError, match=r"mu\[0\]"):
        ContactProblem(one, one[:1], one[1:], [0.0], -0.5, 0.01, np.zeros(3))
    with pytest.raises(signorini.ProblemError, match="1 arrays for 2 contacts|even"):
        ContactProblem(one, one[:1], one[1:], [0.0], 0.5, 0.01, np.zeros(3), directions=3)
    with pytest.raises(signorini.ProblemError, match="belong together"):
        ContactProblem(one, one[:1], one[1:], [0.0], 0.5, 0.01, np.zeros(3), Jb=one[:1])


def next_velocity(model, data, dq, dv, u):
    """v⁺ of a real step from a state nearby."""
    other = signorini.Data(model, data.settings)
    other.qpos = signorini.integrate(model, data.qpos, dq)
    other.qvel = data.qvel + dv
    other.ctrl = u
    signorini.step(model, other)
    return other.qvel.copy()


@pytest.mark.parametrize("scene", ["slope", "cards", "pendulum"])
def test_the_linear_complementarity_system_is_the_step_at_its_state(scene, request):
    model = request.getfixturevalue(scene)
    data = signorini.Data(model)
    signorini.step(model, data, nstep=5)
    data.ctrl = 0.3
    system = signorini.linearize(model, data)
    nv, nu, n = model.nv, model.nu, len(system.c)
    shapes = {"A": (2 * nv, 2 * nv), "B": (2 * nv, nu), "D": (2 * nv, n), "E": (n, 2 * nv), "F": (n, n), "H": (n, nu)}
    assert all(getattr(system, name).shape == shape for name, shape in shapes.items())
    x = np.concatenate([np.zeros(nv), data.qvel])
    q = data.qpos.copy()
    A, b = system.problem.lcp()
    assert np.array_equal(system.F, A) and system.E @ x + system.H @ data.ctrl + system.c == pytest.approx(b, abs=1e-9)
    following, multiplier = system.step()
    # The same by hand, with a solver of the matrices alone.
    result = solve_lcp(system.F, system.E @ x + system.H @ data.ctrl + system.c)
    by_hand = system.A @ x + system.B @ data.ctrl + system.D @ result.z + system.d
    signorini.step(model, data)
    assert following[nv:] == pytest.approx(data.qvel, abs=1e-9) and by_hand == pytest.approx(following, abs=1e-9)
    assert signorini.integrate(model, q, following[:nv]) == pytest.approx(data.qpos, abs=1e-9)
    assert np.minimum(multiplier, system.F @ multiplier + b) == pytest.approx(np.zeros(n), abs=1e-9)


def test_the_system_follows_the_step_nearby_to_second_order(pendulum):
    data = signorini.Data(pendulum)
    data.qpos[0], data.qvel[0], data.ctrl[0] = 0.7, 1.0, 0.5
    system = signorini.linearize(pendulum, data)
    errors = []
    for size in (1e-2, 1e-3):
        dq, dv, u = np.array([size]), np.array([-2 * size]), data.ctrl + 3 * size
        following, _ = system.step(system.x + np.concatenate([dq, dv]), u)
        errors.append(abs(following[1] - next_velocity(pendulum, data, dq, dv, u)[0]))
    assert errors[0] < 1e-5 and errors[1] < 0.02 * errors[0]


def test_the_system_knows_sticking_from_sliding(slope):
    data = signorini.Data(slope)
    signorini.step(slope, data, nstep=5)
    system = signorini.linearize(slope, data)
    for speed in (-1.0, 0.0, 1.0):
        dv = np.array([speed, 0, 0, 0, 0, 0]) - data.qvel
        following, _ = system.step(system.x + np.concatenate([np.zeros(6), dv]))
        assert following[6:] == pytest.approx(next_velocity(slope, data, np.zeros(6), dv, data.ctrl), abs=1e-8)


def test_overlapping_walls_have_a_proof_that_there_is_no_solution():
    rows = np.array([[1.0, 0.0], [-1.0, 0.0]])
    problem = signorini.ContactProblem(
        np.eye(2), rows, np.zeros((4, 2)), [-2e-3, -1e-3], [0.0, 0.0], 0.01, np.zeros(2), Jb=[[0.0, 1.0]], theta=[0.5]
    )
    y, z, residual = problem.contradiction()
    assert residual < 1e-12 and np.all(y > 0) and abs(y[0] - y[1]) < 1e-12 * y[0] and abs(z[0]) < 1e-12
    assert problem.solve().status == "infeasible"
    apart = signorini.ContactProblem(np.eye(2), rows, np.zeros((4, 2)), [-2e-3, 1e-2], [0.0, 0.0], 0.01, np.zeros(2))
    assert apart.contradiction() is None


def test_the_system_of_a_closed_loop_and_of_a_distant_floor():
    loop = """<mujoco><option timestep="0.002"/><worldbody>
      <body><joint name="a" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" contype="0"/>
        <body pos="0.3 0 0"><joint name="b" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.02" contype="0"/></body></body>
    </worldbody><equality><joint joint1="a" joint2="b" polycoef="0 -1 0 0 0"/></equality></mujoco>"""
    model = signorini.Model.from_string(loop)
    data = signorini.Data(model)
    data.qvel[:] = [0.5, -0.5]
    system = signorini.linearize(model, data)
    following, _ = system.step()
    signorini.step(model, data)
    assert following[2:] == pytest.approx(data.qvel, abs=1e-9) and following[2] == pytest.approx(-following[3], abs=1e-9)

    ball = signorini.Model.from_string(
        """<mujoco><worldbody><geom type="plane" size="1 1 1"/><body pos="0 0 1.1"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>"""
    )
    above = signorini.Data(ball)
    assert signorini.linearize(ball, above).c.size == 0 < signorini.linearize(ball, above, within=1.5).c.size
    with pytest.raises(signorini.SettingError):
        signorini.linearize(ball, above, within=-1.0)
