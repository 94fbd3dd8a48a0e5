"""Rollouts over a cluster: a local Ray with two workers, of which one is killed."""

import os
import pathlib
import signal
import sys

import numpy as np
import pytest

import signorini
import signorini.ray
from conftest import SCENES

HAVE_RAY = True
try:
    import ray
except ModuleNotFoundError:
    HAVE_RAY = False

needs_ray = pytest.mark.skipif(not HAVE_RAY, reason="needs Ray: pip install 'signorini[ray]'")


def program(batch, seeds):
    """Thrown robots: where they are after every step, and the process that says so."""
    for i, seed in enumerate(seeds):
        rng = np.random.default_rng(seed)
        batch.qvel[i, :6] = 0.3 * rng.normal(size=6)
        batch.ctrl[i] = 0.2 * rng.normal(size=batch.model.nu)
    qpos, qvel = batch.rollout(nstep=40)
    return {"qpos": qpos, "qvel": qvel, "process": np.full(len(seeds), os.getpid())}


@pytest.fixture(scope="module")
def quadruped():
    return signorini.Model.from_file(SCENES / "quadruped.xml")


# A Ray that did not come up in time leaves processes that it complains of when they are collected.
pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")


@pytest.fixture(scope="module")
def cluster():
    """Ray gives its processes 30 s to come up, which a busy machine may not keep: two more attempts."""
    path = [str(pathlib.Path(__file__).parent), *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    environment = {"env_vars": {"PYTHONPATH": os.pathsep.join(path)}}
    for last in (False, False, True):
        try:
            ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, object_store_memory=100_000_000,
                     runtime_env=environment)
            break
        except Exception as error:
            ray.shutdown()
            if last or "timed out during startup" not in str(error):
                raise
    yield
    ray.shutdown()


@needs_ray
def test_any_number_of_workers_gives_the_bits_of_a_local_run(cluster, quadruped):
    seeds = [int(s) for s in np.random.default_rng(0).integers(0, 2**40, 23)]
    local = program(signorini.Batch(quadruped, 23), seeds)
    for workers in (1, 2):
        results = signorini.ray.rollout(quadruped, program, seeds, workers=workers, nsim=4)
        assert np.array_equal(results["qpos"], local["qpos"]) and np.array_equal(results["qvel"], local["qvel"])
        assert len(set(results["process"])) <= workers and os.getpid() not in results["process"]


@needs_ray
def test_a_lost_worker_costs_no_seed_and_no_bit(cluster, quadruped, tmp_path):
    """The worker that first meets seed 11 is killed in the middle of its part."""

    def deadly(batch, seeds):
        results = program(batch, seeds)
        if 11 in seeds and not (tmp_path / "killed").exists():
            (tmp_path / "killed").write_text(str(os.getpid()))
            os.kill(os.getpid(), signal.SIGKILL)
        return results

    seeds = range(24)
    results = signorini.ray.rollout(quadruped, deadly, seeds, workers=2, nsim=4)
    local = program(signorini.Batch(quadruped, 24), seeds)
    assert np.array_equal(results["qpos"], local["qpos"]) and np.array_equal(results["qvel"], local["qvel"])
    assert int((tmp_path / "killed").read_text()) not in results["process"][8:12]


@needs_ray
def test_what_fails_is_said(cluster, quadruped):
    def kills(batch, seeds):
        os.kill(os.getpid(), signal.SIGKILL)

    def raises(batch, seeds):
        batch.qvel[1] = np.nan
        batch.step()

    def wrong(batch, seeds):
        return {"time": np.zeros(3)}

    with pytest.raises(signorini.ray.WorkerLostError, match=r"lost over the seeds \[5, 6\]") as lost:
        signorini.ray.rollout(quadruped, kills, [5, 6], workers=1)
    assert lost.value.seeds == [5, 6]
    with pytest.raises(signorini.BatchError, match="1 of 2 simulations stopped"):
        signorini.ray.rollout(quadruped, raises, [5, 6], workers=1)
    with pytest.raises(ValueError, match=r"'time' has shape \(3,\): expected 2 rows"):
        signorini.ray.rollout(quadruped, wrong, [5, 6], workers=1)


def test_bad_numbers_are_refused(quadruped):
    for name in ("workers", "nsim", "nthread"):
        with pytest.raises(ValueError, match=f"{name} = 0"):
            signorini.ray.rollout(quadruped, program, [1], **{"workers": 1, **{name: 0}})
    assert signorini.ray.rollout(quadruped, program, [], workers=1) == {}


def test_without_ray_it_is_named(quadruped, monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(ModuleNotFoundError, match="signorini\\[ray\\]"):
        signorini.ray.rollout(quadruped, program, [1], workers=1)
