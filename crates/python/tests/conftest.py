"""Models that several tests share."""

import pathlib

import pytest

import signorini

SCENES = pathlib.Path(__file__).resolve().parents[3] / "scenes"


def mjcf(body: str, option: str = "", rest: str = "") -> signorini.Model:
    text = f"<mujoco model='test'><option timestep='0.002' {option}/><worldbody>{body}</worldbody>{rest}</mujoco>"
    return signorini.Model.from_string(text)


@pytest.fixture
def ball() -> signorini.Model:
    """A ball of 1 kg that rests on a floor."""
    return mjcf("<geom name='floor' type='plane'/><body name='ball' pos='0 0 0.1'><freejoint name='free'/>"
                "<geom name='skin' size='0.1' mass='1'/></body>")


@pytest.fixture
def slope() -> signorini.Model:
    """A box of 2 kg on a floor under gravity that is tilted by 30° in x, μ = 0.3; the polygon has a direction along x."""
    return mjcf("<geom name='floor' type='plane' friction='0.3'/><body name='box' pos='0 0 0.1'><freejoint/>"
                "<geom type='box' size='0.2 0.2 0.1' mass='2' friction='0.3'/></body>",
                option="gravity='4.905 0 -8.495709211124966'")


@pytest.fixture
def pendulum() -> signorini.Model:
    """A point mass of 2 kg on a massless rod of 0.5 m, hanging at q = 0, with a motor; keyframe 'level' is horizontal."""
    return mjcf("<body name='arm'><joint name='hinge' type='hinge' axis='0 1 0' range='-180 170' limited='true'/>"
                "<inertial pos='0 0 -0.5' mass='2' diaginertia='1e-9 1e-9 1e-9'/></body>",
                rest="<actuator><motor name='motor' joint='hinge'/></actuator>"
                     "<keyframe><key name='level' qpos='1.5707963267948966' qvel='0.25' ctrl='3' time='7'/></keyframe>")


@pytest.fixture
def cards() -> signorini.Model:
    return signorini.Model.from_file(SCENES / "house_of_cards.xml")
