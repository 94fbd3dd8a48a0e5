"""Recordings and reports."""

import pathlib

import numpy as np
import pytest

import signorini


def test_a_recording_has_every_step_and_the_last_state(ball):
    data = signorini.Data(ball)
    data.qvel[0] = 0.5
    states = [data.qpos.copy()]
    with data.record() as recorder:
        with pytest.raises(RuntimeError, match="stop"):
            recorder.recording
        for _ in range(4):
            signorini.step(ball, data)
            states.append(data.qpos.copy())
        forces = data.contact.force_world
    recording = recorder.recording
    assert len(recording) == 5 and recording.time == pytest.approx(0.002 * np.arange(5))
    assert np.array_equal(recording.qpos, states) and np.array_equal(recording.xpos[:, 1], np.array(states)[:, :3])
    assert np.array_equal(recording.xquat[:, 1], np.array(states)[:, 3:]) and recording.qvel.shape == (5, 6)
    assert np.array_equal(recording.contact(3).force_world, forces) and recording.ncon.tolist() == [1, 1, 1, 1, 0]
    assert recording.ending == "finished: finished" and recording.status == ["solved"] * 5
    assert recording.model_hash == ball.content_hash and recording.body_names == ["world", "ball"]
    assert recording.residuals.shape == (5, 5) and recording.residuals.max() < 1e-9
    assert recording.energy[0] == pytest.approx([0.125, 0.981]) and recording.energy[4] == pytest.approx(data.energy)
    with pytest.raises(IndexError):
        recording.contact(5)


def test_files_come_back_and_survive_a_crash(ball, tmp_path):
    data = signorini.Data(ball)
    path = tmp_path / "run.rec"
    recorder = data.record(path)
    signorini.step(ball, data, nstep=3)
    assert signorini.load_recording(path).ending == "interrupted" and len(signorini.load_recording(path)) == 3
    finished = recorder.stop("enough")
    assert len(finished) == 4 and finished.ending == "finished: enough"
    finished.save(tmp_path / "copy.rec")
    assert np.array_equal(signorini.load_recording(tmp_path / "copy.rec").qpos, finished.qpos)
    with pytest.raises(signorini.RecordingError, match="absent"):
        signorini.load_recording(tmp_path / "absent.rec")


def test_one_recorder_at_a_time_and_errors_end_it(ball):
    data = signorini.Data(ball)
    with pytest.raises(ZeroDivisionError):
        with data.record() as recorder:
            with pytest.raises(RuntimeError, match="recorded already"):
                data.record()
            1 / 0
    assert recorder.recording.ending == "finished: ZeroDivisionError: division by zero"


def test_a_recording_that_begins_within_a_run_certifies_again():
    """What a run knows of pairs that are far apart, the check of a recording that begins later does not."""
    model = signorini.Model.from_file(pathlib.Path(signorini.__file__).parent / "gymnasium" / "models" / "ant.xml")
    for seed in range(300):
        rng = np.random.default_rng(seed)
        data = signorini.Data(model)
        data.ctrl[:] = 2 * rng.normal(size=model.nu)
        signorini.step(model, data, nstep=int(rng.integers(5, 12)))
        data.ctrl[:] = rng.normal(size=model.nu)
        with data.record() as recorder:
            signorini.step(model, data, nstep=3)
        check = recorder.recording.check()
        assert check and check.steps == 3, f"{seed}: {check.violations}"


def test_the_report_is_one_page(cards, tmp_path):
    data = signorini.Data(cards)
    with data.record() as recorder:
        signorini.step(cards, data, nstep=5)
    page = recorder.recording.to_html(title="cards & more", notes=[("who", "the tests")])
    assert page.startswith("<!doctype html") or "<html" in page[:500]
    assert "<title>cards &amp; more" in page and "the tests" in page
    assert recorder.recording.to_html(tmp_path / "run.html") is None
    assert (tmp_path / "run.html").stat().st_size > 100_000
    assert recorder.recording._repr_html_().startswith("<iframe srcdoc=")
