"""The page of everyday tasks: every block runs, in at most ten lines, and says what MuJoCo's says."""

import importlib.util
import pathlib
import re

import numpy as np
import pytest

PAGE = pathlib.Path(__file__).resolve().parents[3] / "docs/src/guide/everyday.md"
TEXT = PAGE.read_text(encoding="utf-8")
TASKS = re.split(r"^## ", TEXT, flags=re.M)[1:]


def blocks(text, label):
    """Code under this label, with the rest of its first line."""
    return re.findall(rf"^```{label}(?: ([^\n]*))?\n(.*?)^```", text, re.M | re.S)


@pytest.fixture(autouse=True)
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in re.findall(r"^```xml (\S+)\n(.*?)^```", TEXT, re.M | re.S):
        (tmp_path / name).write_text(text)


def run(setup, code, what):
    names = {}
    exec(compile(setup, "setup", "exec"), names)
    exec(compile(code, what, "exec"), names)
    return names.get("answer")


def test_there_are_twenty():
    assert len(TASKS) == 20


@pytest.mark.parametrize("task", TASKS, ids=[task.split("\n")[0] for task in TASKS])
def test_task(task):
    title = task.split("\n")[0]
    (setup,) = (code for label, code in blocks(TEXT, "python") if label == "setup")
    ((_, ours),) = ((label, code) for label, code in blocks(task, "python") if not label.startswith("mujoco"))
    assert sum(bool(line.strip()) for line in ours.splitlines()) <= 10
    answer = run(setup, ours, title)
    theirs = [(label, code) for label, code in blocks(task, "python") if label.startswith("mujoco")]
    if not theirs or importlib.util.find_spec("mujoco") is None:
        return
    ((label, code),) = theirs
    if label == "mujoco unrun":  # It draws with a graphics card.
        compile(code, title, "exec")
        return
    (setup,) = (code for label, code in blocks(TEXT, "python") if label == "mujoco-setup")
    expected = run(setup, code, f"{title}, MuJoCo's")
    tolerance = float(label.removeprefix("mujoco").strip() or 1e-9)
    if expected is not None:
        assert np.allclose(np.asarray(answer, float), np.asarray(expected, float), rtol=tolerance, atol=tolerance)
