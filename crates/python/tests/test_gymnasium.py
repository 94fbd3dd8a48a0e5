"""Environments for Gymnasium, against Gymnasium's own checks and its vector environments."""

import pickle
import subprocess
import sys

import numpy as np
import pytest

import signorini

gymnasium = pytest.importorskip("gymnasium", reason="needs Gymnasium: pip install 'signorini[gymnasium]'")

import signorini.gymnasium as environments  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AutoresetMode, SyncVectorEnv  # noqa: E402

NAMES = sorted(environments.TASKS)


def native(name, count, **options):
    return gymnasium.make_vec(f"signorini/{name}-v0", num_envs=count, vectorization_mode="vector_entry_point", **options)


def same(a, b):
    """Whether two results agree bit for bit, with types and shapes."""
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    a, b = np.asarray(a), np.asarray(b)
    if a.dtype == object:
        return a.shape == b.shape and all((x is None and y is None) or same(x, y) for x, y in zip(a.flat, b.flat))
    return a.dtype == b.dtype and a.shape == b.shape and np.array_equal(a, b)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.filterwarnings("ignore:.*A Box observation space (minimum|maximum) value is:UserWarning")
def test_gymnasiums_checker_is_content(name):
    env = gymnasium.make(f"signorini/{name}-v0")
    check_env(env.unwrapped)


@pytest.mark.parametrize("name, observation, action", [("Ant", 105, 8), ("HalfCheetah", 17, 6), ("Hopper", 11, 3)])
def test_shapes_are_the_customary_ones(name, observation, action):
    """Those that Gymnasium's documentation gives for Ant-v5, HalfCheetah-v5 and Hopper-v5."""
    env = gymnasium.make(f"signorini/{name}-v0")
    assert env.observation_space.shape == (observation,) and env.action_space.shape == (action,)
    assert env.spec.max_episode_steps == 1000
    assert env.unwrapped.task.dt == pytest.approx({"Hopper": 0.008}.get(name, 0.05))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("mode", AutoresetMode)
def test_a_vector_environment_is_many_single_ones(name, mode):
    """Observations, rewards, ends and infos of Gymnasium's own vector of single environments, over several episodes."""
    steps = 45
    singles = SyncVectorEnv(
        [lambda: gymnasium.make(f"signorini/{name}-v0", max_episode_steps=20) for _ in range(3)], autoreset_mode=mode
    )
    envs = native(name, 3, max_episode_steps=20, autoreset_mode=mode.value, nthread=2)
    assert envs.observation_space == singles.observation_space and envs.action_space == singles.action_space
    assert envs.metadata["autoreset_mode"] is mode
    assert same(envs.reset(seed=[7, 8, 11]), singles.reset(seed=[7, 8, 11]))
    envs.action_space.seed(3)
    ended = 0
    for _ in range(steps):
        actions = envs.action_space.sample()
        ours, theirs = envs.step(actions), singles.step(actions)
        assert same(ours, theirs)
        done = ours[2] | ours[3]
        ended += int(done.sum())
        if mode is AutoresetMode.DISABLED and done.any():
            assert same(envs.reset(options={"reset_mask": done}), singles.reset(options={"reset_mask": done.copy()}))
    assert ended >= 6


def test_seeds_and_threads_leave_every_bit():
    runs = []
    for threads in (1, 3):
        envs = native("Hopper", 4, nthread=threads)
        first, _ = envs.reset(seed=5)
        envs.action_space.seed(1)
        runs.append([first] + [envs.step(envs.action_space.sample())[:4] for _ in range(60)])
        again, _ = envs.reset()
        assert not np.array_equal(first, again) and np.array_equal(first, envs.reset(seed=5)[0])
    assert all(same(a, b) for a, b in zip(*runs))
    single = environments.Env("Hopper")
    assert np.array_equal(single.reset(seed=7)[0], runs[0][0][2])


def test_without_autoreset_those_that_ended_must_be_reset():
    envs = native("PushBox", 3, max_episode_steps=2, autoreset_mode="Disabled")
    envs.reset(seed=0)
    rest = np.zeros((3, 2))
    envs.step(rest)
    last, _, _, truncated, _ = envs.step(rest)
    assert truncated.all()
    with pytest.raises(gymnasium.error.ResetNeeded, match=r"simulations \[0, 1, 2\]"):
        envs.step(rest)
    observations, infos = envs.reset(options={"reset_mask": np.array([True, False, True])})
    assert np.array_equal(observations[1], last[1]) and not np.array_equal(observations[0], last[0])
    assert infos["_distance"].tolist() == [True, False, True] and infos["distance"][1] == 0.0
    with pytest.raises(gymnasium.error.ResetNeeded, match=r"simulations \[1\]"):
        envs.step(rest)


def test_rewards_of_the_runners():
    """The formulas of Gymnasium's documentation, from the numbers in info and the state."""
    rng = np.random.default_rng(0)
    for name, weight in (("Ant", 0.5), ("HalfCheetah", 0.1), ("Hopper", 1e-3)):
        env = environments.Env(name)
        _, info = env.reset(seed=1)
        for _ in range(10):
            action, before = rng.uniform(-1, 1, env.action_space.shape), info["x_position"]
            observation, reward, terminated, _, info = env.step(action)
            speed = (info["x_position"] - before) / env.task.dt
            alive = 0.0 if name == "HalfCheetah" else float(not terminated)
            contact = 5e-4 * np.square(observation[27:]).sum() if name == "Ant" else 0.0
            assert reward == pytest.approx(speed - weight * np.square(action).sum() + alive - contact, abs=1e-12)
            assert info["reward_forward"] == pytest.approx(speed) and env.observation_space.contains(observation)


def test_rewards_of_pushing_add_up():
    """But for the costs of actions and the pay at the goal, an episode earns what lies between its first and last observation."""

    def potential(observation):
        to_box, to_goal = observation[4:6], observation[6:8]
        behind = to_box - 0.07 * to_goal / np.linalg.norm(to_goal)
        assert observation[8:10] == pytest.approx(behind)
        return -10.0 * np.linalg.norm(to_goal) - 2.0 * np.linalg.norm(behind)

    env, rng = environments.Env("PushBox"), np.random.default_rng(0)
    first, info = env.reset(seed=3)
    assert info["distance"] == pytest.approx(np.linalg.norm(first[6:8]))
    total = 0.0
    for _ in range(80):
        action = np.clip(8.0 * first[4:6] + rng.normal(size=2), -1, 1)
        last, reward, _, _, info = env.step(action)
        total += reward + 1e-3 * np.square(action).sum() - 0.2 * info["is_success"]
    assert np.linalg.norm(last[6:8] - first[6:8]) > 0.02
    assert total == pytest.approx(potential(last) - potential(first), abs=1e-9)


def test_a_hopper_that_does_nothing_falls():
    env = environments.Env("Hopper")
    env.reset(seed=0)
    for _ in range(400):
        observation, _, terminated, _, info = env.step(np.zeros(3))
        if terminated:
            break
    assert terminated and info["reward_survive"] == 0.0
    assert observation[0] <= 0.7 or abs(observation[1]) >= 0.2
    tough = environments.Env("Hopper", terminate_when_unhealthy=False)
    tough.reset(seed=0)
    assert not any(tough.step(np.zeros(3))[2] for _ in range(200))


@pytest.mark.parametrize("name", ["Ant", "HalfCheetah", "Hopper"])
def test_starts_do_not_penetrate_the_floor(name):
    task = environments.TASKS[name]()
    data = signorini.Data(task.model)
    rng = np.random.default_rng(2)
    lowest = []
    for _ in range(40):
        data.qpos[:], data.qvel[:] = task.start(rng)
        signorini.forward(task.model, data)
        floor = data.contact.gap[data.contact.body1 * data.contact.body2 == 0]
        lowest.append(floor.min(initial=1.0))
    assert min(lowest) > -1e-9


def test_contacts_are_felt_by_the_ant():
    """At rest, but for a creep of its joints, they carry its weight."""
    env = environments.Env("Ant", contact_force_range=(-np.inf, np.inf))
    observation, _ = env.reset(seed=0)
    assert not observation[27:].any()
    for _ in range(200):
        observation, *_ = env.step(np.zeros(8))
    model = env.task.model
    weight = 9.81 * sum(model.body(i).mass for i in range(1, model.nbody))
    forces = observation[27:].reshape(13, 6)[:, 3:].sum(axis=0)
    assert np.allclose(forces, [0.0, 0.0, weight], rtol=1e-3, atol=1e-2)
    assert environments.Env("Ant", include_cfrc_ext_in_observation=False).observation_space.shape == (27,)


def test_a_finger_that_steers_by_hand_brings_the_box_home():
    """Behind the box, seen from the goal, then towards it: a third of the boxes arrive at least, untouched ones do not."""
    envs = native("PushBox", 16)
    arrived = {}
    for hand in (True, False):
        observations, infos = envs.reset(seed=4)
        for _ in range(99):
            box, goal = observations[:, 4:6], observations[:, 6:8]
            aim = goal / np.linalg.norm(goal, axis=1, keepdims=True)
            behind = box - 0.11 * aim
            side = box[:, 0] * aim[:, 1] - box[:, 1] * aim[:, 0]
            lined = (np.abs(side) < 0.02) & ((box * aim).sum(axis=1) > 0)
            around = np.stack([-aim[:, 1], aim[:, 0]], axis=1) * np.where(side > 0, -1.0, 1.0)[:, None] * 0.12
            ahead = (box * aim).sum(axis=1) < 0.05
            target = np.where(lined[:, None], goal + box, np.where(ahead[:, None], behind + around, behind))
            speed = np.where(np.linalg.norm(goal, axis=1) < 0.02, 0.0, 8.0)[:, None]
            actions = np.clip(speed * target, -1, 1) if hand else np.zeros((16, 2))
            observations, _, _, _, infos = envs.step(actions.astype(np.float32))
        arrived[hand] = int(infos["is_success"].sum())
    assert arrived[True] >= 6 and arrived[False] == 0, arrived


def test_an_episode_is_recorded_bit_for_bit():
    envs = native("Hopper", 2, render_mode="html")
    envs.reset(seed=0)
    envs.action_space.seed(0)
    for k in range(1, 40):
        observations, _, terminated, _, _ = envs.step(envs.action_space.sample())
        if terminated.any():
            break
    i = int(np.flatnonzero(terminated)[0])
    recording = envs.unwrapped.recording(i)
    assert len(recording) == 4 * k + 1 and recording.residuals.max() < 1e-9
    assert np.array_equal(recording.qpos[-1, 1:], observations[i, :5])
    envs.step(envs.action_space.sample())
    assert len(envs.unwrapped.recording(i)) == 1


def test_an_episode_as_a_page():
    env = gymnasium.make("signorini/PushBox-v0", render_mode="html")
    env.reset(seed=0)
    for _ in range(3):
        env.step(np.array([1.0, 0.5], dtype=np.float32))
    page = env.render()
    assert "<html" in page and "PushBox" in page
    assert environments.Env("PushBox").render() is None
    with pytest.raises(ValueError, match="render_mode='html'"):
        environments.Env("PushBox").recording()
    with pytest.raises(ValueError, match="'rgb_array'"):
        environments.Env("PushBox", render_mode="human")
    envs = native("PushBox", 2, render_mode="html")
    envs.reset(seed=0)
    assert len(envs.render()) == 2


def test_pictures_of_the_present_state():
    env = gymnasium.make("signorini/Hopper-v0", render_mode="rgb_array")
    env.reset(seed=0)
    first = env.render()
    assert first.shape == (480, 480, 3) and first.dtype == np.uint8
    for _ in range(10):
        env.step(env.action_space.sample())
    assert not np.array_equal(first, env.render())
    envs = native("PushBox", 2, render_mode="rgb_array")
    envs.reset(seed=0)
    one, other = envs.render()
    assert one.shape == (480, 480, 3) and not np.array_equal(one, other)


@pytest.mark.parametrize("mode", ["html", "rgb_array"])
def test_a_pickled_environment_goes_on_in_the_middle_of_an_episode(mode):
    """With its generator: the episode after the present one is the same, too."""
    rng = np.random.default_rng(5)
    single = gymnasium.make("signorini/Hopper-v0", render_mode=mode, max_episode_steps=30)
    many = native("Hopper", 3, render_mode=mode, max_episode_steps=30, nthread=2)
    for env, shape in [(single, (3,)), (many, (3, 3))]:
        env.reset(seed=3)
        env.step(rng.uniform(-1.0, 1.0, shape))
        picture = env.render()
        other = pickle.loads(pickle.dumps(env))
        assert same(other.render(), picture)
        for _ in range(40):
            action = rng.uniform(-1.0, 1.0, shape)
            own = env.step(action)
            assert same(other.step(action), own)
            if env is single and (own[2] or own[3]):
                assert same(other.reset(), env.reset())


def test_what_is_wrong_is_said():
    with pytest.raises(ValueError, match="'Hoper'.*'Hopper'"):
        environments.Env("Hoper")
    with pytest.raises(TypeError, match="healthy_rewards"):
        environments.Env("Hopper", healthy_rewards=2.0)
    env, envs = environments.Env("Hopper"), native("Hopper", 2)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros(3))
    env.reset()
    with pytest.raises(ValueError, match=r"shape \(2,\), expected \(3,\)"):
        env.step(np.zeros(2))
    with pytest.raises(ValueError, match="not finite"):
        env.step(np.full(3, np.nan))
    with pytest.raises(ValueError, match="'height'.*there are none"):
        env.reset(options={"height": 2.0})
    with pytest.raises(ValueError, match="'height'.*only 'reset_mask'"):
        envs.reset(options={"height": 2.0})
    with pytest.raises(ValueError, match="first reset"):
        envs.reset(options={"reset_mask": np.array([True, False])})
    with pytest.raises(ValueError, match="3 entries"):
        envs.reset(seed=[1, 2, 3])


def test_a_task_of_ones_own():
    """A ball on a slide that is paid for its height; a force of 1 N lifts it with (1 N − weight) / m."""

    class Lift(environments.Task):
        file, frame_skip, observation_size = "", 5, 2
        model = signorini.Model.from_string(
            "<mujoco><option timestep='0.01'/><worldbody><body><joint name='z' type='slide' axis='0 0 1'/>"
            "<geom size='0.1' mass='0.05'/></body></worldbody><actuator><motor joint='z'/></actuator></mujoco>"
        )

        def start(self, rng):
            return np.array([rng.uniform(0.0, 1.0)]), np.zeros(1)

        def observe(self, batch):
            return np.concatenate([batch.qpos, batch.qvel], axis=1)

        def judge(self, batch, before, action):
            return environments.Judgement(batch.qpos[:, 0].copy(), batch.qpos[:, 0] > 2.0, {})

    envs = environments.VectorEnv(Lift(), 2)
    start, _ = envs.reset(seed=0)
    assert (start[:, 0] != start[::-1, 0]).all()
    observations, rewards, *_ = envs.step(np.array([[1.0], [0.0]]))
    assert np.allclose(observations[:, 1], 0.05 * (np.array([1.0, 0.0]) / 0.05 - 9.81))
    assert np.array_equal(rewards, observations[:, 0])


def test_the_example_of_the_modules_docstring():
    import doctest

    result = doctest.testmod(environments)
    assert result.attempted == 7 and not result.failed


def test_without_gymnasium_it_is_named():
    code = ("import importlib.util as util; found = util.find_spec\n"
            "util.find_spec = lambda name, *rest: None if name == 'gymnasium' else found(name, *rest)\n"
            "import signorini.gymnasium")
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert run.returncode == 1 and "pip install 'signorini[gymnasium]'" in run.stderr
