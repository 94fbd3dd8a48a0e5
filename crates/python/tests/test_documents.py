"""What README and guide show, run as it stands there; every row of the tables for those who come from elsewhere."""

import importlib.util
import inspect
import pathlib
import re
import warnings

import numpy as np
import pytest

import signorini
import signorini.ray
from signorini import Settings, viewer

ROOT = pathlib.Path(__file__).resolve().parents[3]

PARTS = """<link name="trunk"><inertial><mass value="2"/><inertia ixx=".02" iyy=".02" izz=".02" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size=".2 .2 .1"/></geometry></collision></link>
<link name="foot"><inertial><mass value=".5"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><sphere radius=".05"/></geometry></collision></link>
<joint name="knee" type="revolute"><parent link="trunk"/><child link="foot"/><origin xyz="0 0 -.3"/><axis xyz="0 1 0"/>
  <limit lower="-1" upper="1" effort="5"/></joint>
<transmission name="t"><type>transmission_interface/SimpleTransmission</type><joint name="knee"/><actuator name="motor"/></transmission>"""
URDF = f"<robot name='robot'>{PARTS}</robot>"
MJCF = """<mujoco><worldbody><geom type="plane"/>
  <body name="trunk" pos="0 0 .5"><freejoint name="floating_base"/><geom type="box" size=".1 .1 .05" mass="2"/>
    <body name="foot" pos="0 0 -.3"><joint name="knee" axis="0 1 0"/><geom size=".05" mass=".5"/></body></body></worldbody>
  <actuator><motor name="motor" joint="knee"/></actuator>
  <keyframe><key name="home" qpos="0 0 1 1 0 0 0 .2"/></keyframe></mujoco>"""

# What the tables call by its MJCF name, as it is written into that model.
MJCF_WORDS = {
    **{f"<{kind}>": ("motor name", f"{kind} {rest} name") for kind, rest in {
        "position": "kp='9'", "velocity": "kv='9'", "intvelocity": "kp='9' actrange='-1 1'", "cylinder": "timeconst='.1'",
        "muscle": "force='9' lengthrange='-1 1'"}.items()},
    **{word: ("motor name", f"general dyntype='integrator' {rest} name") for word, rest in {
        "dyntype": "", "actrange": "actlimited='true' actrange='-1 1'", "actearly": "actearly='true'"}.items()},
    "forcerange": ("motor name", "velocity kv='9' forcerange='-1 1' name"),
    "<adhesion>": ('motor name="motor" joint="knee"', 'adhesion name="motor" body="foot" ctrlrange="0 1"'),
    "margin": ("<geom type=\"box\"", "<geom margin='.01' type=\"box\""),
}


@pytest.fixture
def robots(tmp_path, monkeypatch):
    """A folder with the files that the examples load; nothing opens a browser, and no cluster is started."""
    (tmp_path / "robot.xml").write_text(MJCF)
    (tmp_path / "robot.urdf").write_text(URDF)
    monkeypatch.chdir(tmp_path)
    opened = []
    launch = viewer.launch

    def without_browser(*arguments, **options):
        opened.append(launch(*arguments, **options, open_browser=False))
        return opened[-1]

    def here(*arguments, **options):
        given = inspect.signature(rollout).bind(*arguments, **options).arguments
        return given["program"](signorini.Batch(given["model"], 3), given["seeds"][:3])

    rollout = signorini.ray.rollout
    monkeypatch.setattr(viewer, "launch", without_browser)
    monkeypatch.setattr(signorini.ray, "rollout", here)
    yield tmp_path
    for shown in opened:
        shown.close()


def given_numbers():
    """What the examples take as given: matrices of problems, and the control of 64 simulations with one actuator."""
    return {
        "A": np.eye(2), "b": np.array([-1.0, 1.0]), "q": np.array([-1.0, 1.0, 0.5]), "M": np.eye(3),
        "Jn": np.array([[0.0, 0, 1]]), "Jt": np.eye(3)[:2], "phi": np.zeros(1), "mu": np.array([0.5]), "dt": 0.01,
        "v_free": np.array([1.0, 0, -1]), "ctrl": np.zeros((64, 4, 1)),
    }


def examples(document):
    return re.findall(r"^```python\n(.*?)^```", (ROOT / document).read_text(encoding="utf-8"), re.M | re.S)


@pytest.mark.parametrize("document, least", [("README.md", 1), ("crates/python/README.md", 6), ("docs/src/guide/python.md", 5)])
def test_examples_run_as_they_stand(robots, document, least):
    """The blocks of a document, one after the other, in one program."""
    found = examples(document)
    assert len(found) >= least
    names = given_numbers()
    for module in ("gymnasium", "ray"):
        text = "".join(found)
        assert f"import signorini.{module}" in text or f"signorini.{module}." not in text, "does not come by itself"
    for block in found:
        if "gymnasium" in block and not importable("gymnasium"):
            continue
        if not importable("rerun"):
            block = re.sub(r"^.*to_rerun.*$", "", block, flags=re.M)
        with warnings.catch_warnings():
            # A joint's <limit effort> becomes a range of its motor, which is said.
            warnings.simplefilter("ignore", signorini.ModelWarning)
            warnings.simplefilter("ignore", signorini.OverlapWarning)
            exec(compile(block, document, "exec"), names)
    assert names["model"].nbody > 1 and names["data"].certificate.holds(1e-9)


def importable(package):
    return importlib.util.find_spec(package) is not None


def tables():
    """Rows of "coming from": whom they are for, what is called there, what is called here."""
    text = (ROOT / "docs/src/guide/coming-from.md").read_text(encoding="utf-8")
    for section in text.split("\n## ")[1:]:
        for row in re.findall(r"^\| .* \|.*$", section, re.M)[1:]:
            cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", row)[1:-1]]
            yield section.split("\n")[0], cells[0], cells[1]


ROWS = list(tables())


def test_there_is_a_table_for_each():
    count = {whom: sum(row[0] == whom for row in ROWS) for whom, _, _ in ROWS}
    assert list(count) == ["MuJoCo", "Drake", "PyBullet", "Pinocchio"] and min(count.values()) >= 10


@pytest.mark.parametrize("whom, there, here", ROWS, ids=[f"{whom}: {there[:40]}" for whom, there, _ in ROWS])
def test_what_a_table_says_can_be_written(robots, whom, there, here):
    """Every piece of Python in a row's second column is an expression or a statement that runs."""
    model = signorini.Model.from_file(robots / "robot.xml")
    data = signorini.Data(model)
    signorini.step(model, data)
    body, nv, foot = 2, model.nv, np.zeros(3)
    jacp, jacr = signorini.jacobian(model, data, body)
    names = {
        **{name: getattr(signorini, name) for name in signorini.__all__}, "signorini": signorini, "model": model, "data": data,
        "p": str(robots / ("robot.xml" if whom in ("MuJoCo", "Drake") else "robot.urdf")), "s": MJCF, "nstep": 2, "nsim": 2,
        "ctrl": np.zeros((2, 3, 1)), "qacc": np.zeros(nv), "a": np.zeros(nv), "t": 0.01, "dt": 0.002, "tau": 0.5, "mu": 0.5,
        "body": body, "point": foot, "f": np.ones(3), "jacp": jacp, "jacr": jacr, "Settings": Settings,
        "A": np.eye(2), "b": np.array([-1.0, 1.0]),
    }
    spans = re.findall(r"`([^`]+)`", there if here == "the same" else here)
    assert spans or not re.search(r"[a-z]\(|\.[a-z]", here)
    owner = "data"
    for span in spans:
        if span in MJCF_WORDS:
            with warnings.catch_warnings():
                warnings.simplefilter("error", signorini.ModelWarning)
                assert signorini.Model.from_mjcf(MJCF.replace(*MJCF_WORDS[span])).nu == 1
        elif re.fullmatch(r"\w+=\w+", span):
            signorini.Model.from_urdf(robots / "robot.urdf", **{span.split("=")[0]: span.endswith("True")})
        elif here == "the same":
            assert hasattr(data, span.removeprefix("d."))
        elif span.startswith("."):
            eval(owner + span, names)
        else:
            if span.startswith("data.set_state"):
                names["s"] = data.get_state()
            span = span.replace('body("base")', 'body("trunk")').replace("from_urdf(..., ", "Model.from_urdf(p, ")
            exec(span, names)
            if re.fullmatch(r"[\w.()\"]+\.\w+", span):
                owner = span.rsplit(".", 1)[0]


def test_a_force_at_a_point_is_the_jacobians_transpose_times_it():
    """The row for `xfrc_applied`: a push at a point of a floating body accelerates its centre of mass by force over mass."""
    model = signorini.Model.from_mjcf(MJCF.replace('<geom type="plane"/>', "").replace("<worldbody>", "<option gravity='0 0 0'/><worldbody>"))
    data = signorini.Data(model)
    signorini.kinematics(model, data)
    jacp, _ = signorini.jacobian(model, data, 1, data.body("trunk").xpos + [0.05, 0.0, 0.02])
    data.qfrc_applied += jacp.T @ np.array([2.5, 5.0, -10.0])
    before = momentum(model, data)
    signorini.step(model, data)
    assert momentum(model, data) - before == pytest.approx(np.array([2.5, 5.0, -10.0]) * 0.002, rel=1e-4)


def momentum(model, data):
    """Of all bodies, from their velocities and masses."""
    total = np.zeros(3)
    for body in range(1, model.nbody):
        at_centre, _ = signorini.jacobian(model, data, body, data.xipos[body])
        total += model.body(body).mass * (at_centre @ data.qvel)
    return total
