"""A program that uses every public name of the package; type checkers read it and the tests run it."""

from __future__ import annotations

import pathlib
import tempfile
import warnings
from typing import Optional, Tuple

import numpy as np
from numpy.typing import NDArray

import signorini
from signorini import ContactMode, Data, Model, Settings, SolverSettings

TEXT = """<mujoco model="arm">
  <worldbody>
    <geom name="floor" type="plane"/>
    <body name="arm" pos="0 0 0.5"><joint name="hinge" axis="0 1 0" range="-90 90"/><geom name="link" size="0.1"/></body>
    <body name="box" pos="1 0 0.1"><freejoint/><geom name="skin" type="box" size="0.1 0.1 0.1"/></body>
  </worldbody>
  <actuator><position name="servo" joint="hinge" kp="10"/></actuator>
  <keyframe><key name="home" qpos="0.5 1 0 0.1 1 0 0 0"/></keyframe>
</mujoco>"""


def models() -> Model:
    model: Model = Model.from_string(TEXT)
    body: signorini.Body = model.body("arm")
    joint: signorini.Joint = model.joint("hinge")
    geom: signorini.Geom = model.geom("skin")
    actuator: signorini.Actuator = model.actuator(0)
    driven: Optional[int] = actuator.joint if actuator.tendon is None and actuator.site is actuator.body is None else None
    assert driven == 0 and model.nsensor == len(model.sensor_names) == 0
    keyframe: signorini.Keyframe = model.keyframe("home")
    numbers: Tuple[float, float, float, float] = (body.mass, joint.damping, geom.friction, actuator.gear + keyframe.time)
    report: list[signorini.ImportWarning] = model.import_report
    assert len(numbers) == 4 and not report and isinstance(signorini.__version__, str) and not model.sleeping
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", signorini.ModelWarning)
        try:
            Model.from_mjcf("<mujoco><worldbody><geom/></worldbody></mujoco>")
        except signorini.ModelError as error:
            line: Optional[int] = error.line
            assert line == 1
    return model


def stepping(model: Model) -> Data:
    data = Data(model, Settings(directions=4, solver=SolverSettings(max_rounds=2)))
    data.reset(keyframe="home")
    with warnings.catch_warnings():
        warnings.simplefilter("error", signorini.ToleranceWarning)
        warnings.simplefilter("error", signorini.OverlapWarning)
        signorini.step(model, data, nstep=10)
    signorini.forward(model, data)
    signorini.kinematics(model, data)
    arm: signorini.BodyData = data.body("arm")
    hinge: signorini.JointData = data.joint("hinge")
    servo: signorini.ActuatorData = data.actuator("servo")
    servo.ctrl, hinge.qvel = 0.1, 0.0
    data.mocap_pos, data.mocap_quat = np.zeros((0, 3)), np.zeros((0, 4))
    assert model.nmocap == len(data.mocap_pos) == len(data.mocap_quat) == 0
    position: NDArray[np.float64] = arm.xpos
    contacts: signorini.Contacts = data.contact
    limits: signorini.Limits = data.limit
    sensors: NDArray[np.float64] = data.sensordata
    assert sensors.shape == (model.nsensordata,) and limits.tendon.size == 0
    report: signorini.StepReport = data.report
    certificate: signorini.Certificate = data.certificate
    assert len(contacts) == 4 and (contacts.mode == ContactMode.STICKING).all() and len(limits) == 0
    assert position.shape == (3,) and report.status == "solved" and certificate.holds(1e-9)
    tau = signorini.inverse(model, data, data.qacc)
    assert np.allclose(tau, signorini.mass_matrix(model, data) @ data.qacc + signorini.bias_force(model, data))
    linear, angular = signorini.jacobian(model, data, 1)
    moved = signorini.integrate(model, data.qpos, data.qvel, 0.1)
    assert linear.shape == angular.shape == (3, 7) and signorini.difference(model, moved, data.qpos).shape == (7,)
    return data


def asking(model: Model, data: Data) -> None:
    signorini.forward(model, data)
    near: Optional[signorini.Nearest] = signorini.distance(model, data, 0, "skin")
    points: list[signorini.ContactPoint] = signorini.contacts_at(model, data, data.qpos, within=0.1)
    hit: Optional[signorini.RayHit] = signorini.cast_ray(model, data, [0, 0, 5], [0, 0, -1], exclude_body="arm")
    distances, geoms, normals = signorini.cast_rays(model, data, [0, 0, 5], [[0, 0, -1], [0, 0, 1]], exclude_body="arm")
    assert near is not None and points and hit is not None and hit.distance == distances[0] and geoms[1] == -1 and normals.shape == (2, 3)
    assert all(depth > 0 for _, _, depth in signorini.overlaps(model, data))
    place, turn = signorini.frame_pose(model, data, geom="skin")
    rate, _ = signorini.jacobian_rate(model, data, geom="skin")
    center, (moves, _) = signorini.center_of_mass(model, data), signorini.center_of_mass_jacobian(model, data)
    inertia = signorini.operational_space_inertia(model, data, moves)
    found: signorini.InverseKinematics = signorini.inverse_kinematics(model, data, place, geom="skin")
    corners, pressure = signorini.support_polygon(model, data), signorini.zero_moment_point(model, data)
    assert found.converged and turn.shape == inertia.shape == (3, 3) and rate.shape == moves.shape and center.shape == (3,)
    assert corners.shape[1] == 3 and pressure is not None and data.actuator_force.shape == (model.nu,) == data.xfrc_applied[0, :1].shape


def editing(model: Model) -> None:
    spec: signorini.Spec = signorini.Spec(model)
    part: signorini.SpecPart = spec.body(1)
    part.pos = (0.0, 0.0, 1.0)
    filled: signorini.Scene = signorini.scene("filled")
    filled.box((0.1, 0.1, 0.1), mass=1.0)
    parameter: signorini.Parameter = signorini.PARAMETERS["body_mass"]
    assert parameter.shape == () and model.parameter("body_mass").shape == (model.nbody,)
    spec.attach(model, pos=(0, 3, 0), prefix="second ")
    removed: list[str] = spec.remove("body", "arm")
    text, left_out = spec.to_mjcf()
    assert "body 'arm'" in removed and text.startswith("<mujoco") and not left_out and spec.compile().nbody == model.nbody + 1


def settling() -> None:
    model = Model.from_string(TEXT.replace('<joint name="hinge" axis="0 1 0" range="-90 90"/>', "").split("<actuator>")[0] + "</mujoco>")
    data = Data(model)
    data.qpos[2] = 0.3
    verdict: signorini.Stability = signorini.stability(model, data, touching=1e-6, tolerance=1e-9, enumeration=0)
    assert verdict.verdict in {"must_move", "stays", "may_do_either", "stands"} and verdict.proved
    assert verdict.forces.shape == verdict.points.shape and isinstance(verdict.residuals, dict) and verdict.problem.nc >= 0
    limit: signorini.Safety = signorini.safety(model, data, what="friction")
    assert limit.falls != limit.holds and len(limit.residuals) == 2
    worst = signorini.safety(model, data, what="horizontal", direction="worst")
    assert worst.at_least is not None and worst.direction is not None and worst.direction.shape == (3,) and worst.circular is None
    assert worst.polygons is None and worst.motion is None and verdict.force_ranges().shape[1] == 2
    for _, (push, towards) in signorini.critical_bodies(model, data, attraction=0.0).items():
        assert (push >= 0 or verdict.verdict == "must_move") and towards.shape == (3,)
    candidates: signorini.Placements = signorini.placements(model, np.tile(data.qpos, (2, 1)), data, hold=False, search=False)
    assert candidates.verdict == [verdict.verdict] * 2 and candidates.proved and candidates.residual.shape == (2,)
    blocks = signorini.Assembly(floor=0.0)
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=np.float64)
    blocks.add("tetrahedron", corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], density=1.0)
    assert len(blocks) == 1 and blocks.stability().verdict == "stays" and blocks.safety(what="friction").holds >= 0
    settled: signorini.SettleReport = signorini.settle(model, data, max_steps=500, momentum=0.4)
    assert settled.steps > 0 and settled.factorizations > 0 and settled.at_rest.contacts == 4 and settled.speed == 0.0 and not data.qvel.any()


def solving(model: Model, data: Data) -> None:
    problem: signorini.ContactProblem = data.problem()
    solution: signorini.ContactSolution = problem.solve("structured")
    result: signorini.LcpResult = signorini.solve_lcp(*problem.lcp(), method=signorini.lcp_methods()[0])
    system: signorini.LinearComplementaritySystem = signorini.linearize(model, data)
    following, _ = system.step()
    slopes: signorini.StepDerivatives = signorini.derivatives(model, data)
    many: list[signorini.StepDerivatives] = signorini.Batch(model, 2).step_with_derivatives(["timestep"])
    margins: list[signorini.Margin] = slopes.margins
    assert slopes.validity in {"exact", "one_sided", "refused"} and all(margin.kind for margin in margins)
    gravity = ("gravity", 2)
    value = signorini.parameter_values(model, [gravity])
    heavier: signorini.Model = signorini.with_parameters(model, [gravity], 2 * value)
    motion = np.array([data.qpos, data.qpos]), np.array([data.qvel, data.qvel])
    unknown = signorini.Unknown(gravity, bounds=(-30.0, 0.0))
    found: signorini.Identification = signorini.identify(heavier, [motion], [unknown], interval=1e-3, iterations=1)
    assert found.names == ("gravity[2]",) and found.values.shape == (1,)
    known: signorini.Parameter = signorini.PARAMETERS["body_mass"]
    assert known.sort == "body"
    runs: list[signorini.StageRun] = problem.solve(record_history=True).history
    stages: dict[str, signorini.StageCount] = data.report.stages
    assert sum(stage.ended for stage in stages.values()) == 1 and runs[-1].outcome == "solved"
    assert solution.solved and result.solved and following.shape == (14,)
    z, exit_code, _ = signorini.lemkelcp(np.eye(1), np.array([-1.0]))
    assert exit_code == 0 and z is not None


def many(model: Model) -> None:
    batch = signorini.Batch(model, 2, nthread=2)
    try:
        qpos, _ = batch.rollout(nstep=3)
        batch.vary(0, friction=0.5, gravity=(0.0, 0.0, -1.62))
        batch.step(2, ids=[1])
        wrenches: NDArray[np.float64] = batch.contact_wrench
        (sensors,) = batch.rollout(nstep=1, record=["sensordata"])
        assert wrenches.shape == (2, model.nbody, 6) and sensors.shape == (2, 1, 0) and batch.sensordata.size == 0
        assert qpos.shape == (2, 3, model.nq)
    except signorini.BatchError as error:
        print(error.ids)


def recording(model: Model, data: Data, folder: pathlib.Path) -> None:
    recorder: signorini.Recorder = data.record(folder / "run.rec")
    signorini.step(model, data)
    kept: signorini.Recording = recorder.stop()
    page: str = kept.to_html()
    again = signorini.load_recording(folder / "run.rec")
    inline: signorini.viewer.InlineReport = signorini.viewer.html(kept)
    assert len(again) == 2 and "<html" in page and inline.recording is kept
    check: signorini.RecordingCheck = again.check(tolerance=1e-9)
    assert check and check.ok and check.steps == 1 and check.worst.holds() and not check.violations
    again.to_csv(folder / "run.csv")
    total: signorini.ContactSum = again.contact(0).between("world", "box")
    force: NDArray[np.float64] = total.force
    assert force[2] > 0 and total.closed <= total.ncon


def pictures(folder: pathlib.Path) -> None:
    model = signorini.Model.from_string(signorini.generate.stack(2))
    data = signorini.Data(model)
    renderer = signorini.Renderer(model, 32, 24, background="white")
    view: signorini.View = renderer.framing(data)
    picture: NDArray[np.uint8] = renderer.render(data, view)
    signorini.save_png(folder / "stack.png", picture)
    film = signorini.Film(32, 24)
    film.add(picture)
    film.save(folder / "stack.mp4")
    assert len(film) == 1 and renderer.depth(data, view).min() > 0 and renderer.segmentation(data, view).max() == 2


def failing(model: Model, data: Data) -> None:
    errors: Tuple[type[signorini.SignoriniError], ...] = (
        signorini.ProblemError,
        signorini.RecordingError,
        signorini.SettingError,
        signorini.SolveError,
        signorini.StateError,
    )
    try:
        data.set_state([0.0])
    except errors as error:
        assert "state" in str(error)


def main() -> None:
    model = models()
    data = stepping(model)
    asking(model, data)
    editing(model)
    settling()
    solving(model, data)
    many(model)
    with tempfile.TemporaryDirectory() as folder:
        recording(model, data, pathlib.Path(folder))
        pictures(pathlib.Path(folder))
    failing(model, data)


if __name__ == "__main__":
    main()
