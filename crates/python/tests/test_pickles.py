"""What a step gives can be copied and pickled: every attribute is the same after."""

import copy
import pickle

import numpy as np
import pytest

import signorini
from conftest import mjcf

COPIES = [copy.copy, copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))]


def attributes(thing):
    return {name: getattr(thing, name) for name in dir(thing) if not name.startswith("_") and not callable(getattr(thing, name))}


def same(a, b):
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b)
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    if isinstance(a, (signorini.Certificate, signorini.StageCount)):
        return same(attributes(a), attributes(b))
    return bool(type(a) is type(b) and a == b)


@pytest.fixture
def slid():
    """After a step of a box that slides and overlaps the floor by 1 mm, beside a door."""
    model = mjcf("<geom name='floor' type='plane' friction='0.3'/><body name='box' pos='0 0 0.099'><freejoint/>"
                 "<geom type='box' size='0.2 0.2 0.1' mass='2' friction='0.3'/></body>"
                 "<body name='door' pos='2 0 1'><joint axis='0 0 1'/><geom size='.1' mass='1'/></body>")
    data = signorini.Data(model, signorini.Settings(solver=signorini.SolverSettings(time_stages=True)))
    data.qvel[0] = 1.0
    with pytest.warns(signorini.OverlapWarning):
        signorini.step(model, data)
    assert data.ncon == 4 and np.abs(data.contact.stabilization).max() > 0.0
    return data


@pytest.mark.parametrize("again", COPIES)
def test_what_a_step_gives_is_the_same_again(slid, again):
    for thing in (slid.certificate, slid.report, slid.contact):
        copied = again(thing)
        assert type(copied) is type(thing) and same(attributes(thing), attributes(copied))
        assert repr(copied) == repr(thing)
    assert slid.report.stages and again(slid.certificate).holds() == slid.certificate.holds()
    ours, theirs = (contacts.between("world", "box") for contacts in (slid.contact, again(slid.contact)))
    assert (ours.ncon, ours.closed) == (theirs.ncon, theirs.closed) and np.array_equal(ours.impulse, theirs.impulse)


@pytest.mark.parametrize("again", COPIES)
def test_a_problem_is_the_same_again(slid, again):
    door = mjcf("<body name='door' pos='0 0 1'><joint axis='0 1 0' frictionloss='0.3'/><geom size='.1' pos='1 0 0' mass='1'/></body>"
                "<body name='a' pos='3 0 1'><freejoint/><geom size='.1'/></body>",
                rest="<equality><connect body1='a' anchor='0 0 0'/></equality>")
    held = signorini.Data(door)
    signorini.step(door, held)
    for problem in (slid.problem(), held.problem()):
        copied = again(problem)
        assert same(attributes(problem), attributes(copied))
        assert np.array_equal(problem.solve().v, copied.solve().v)


def test_contacts_of_a_recording_are_the_same_again(slid):
    with slid.record() as recorder:
        signorini.step(slid.model, slid)
    contacts = recorder.recording.contact(0)
    copied = copy.deepcopy(contacts)
    assert np.array_equal(contacts.impulse, copied.impulse) and len(copied) == 4
    with pytest.raises(RuntimeError, match="a recording does not hold it"):
        copied.stabilization
