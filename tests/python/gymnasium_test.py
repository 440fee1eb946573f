"""Env as an environment of Gymnasium: its own check, registration and vector environments. Skipped where it is not installed,
but for what then has to work."""

import os
import shutil
import subprocess
import sys
import warnings

import numpy as np
import pytest
import saccade
from common import SOURCE

SHORT = {"run.duration_s": 0.3, "expect": {}}
SCENARIO = str(SOURCE / "scenarios" / "gaze_circle.yaml")

WITHOUT = """
import sys
sys.modules["gymnasium"] = None
import saccade
env = saccade.Env({scenario!r}, seed=1, overrides={{"run.duration_s": 0.01, "expect": {{}}}}, vary=True)
env.reset(seed=3)
print(env.step()[0]["t_us"], env.reset()[1]["seed"], env.unwrapped is env)
for space in ("action_space", "observation_space"):
    try:
        getattr(env, space)
    except ImportError as error:
        print(error)
"""


def test_without_gymnasium_all_but_the_spaces_works():
    done = subprocess.run([sys.executable, "-c", WITHOUT.format(scenario=SCENARIO)], capture_output=True, text=True)
    lines = done.stdout.splitlines()
    assert len(lines) == 3, done.stderr
    assert lines[0].startswith("1000 ") and lines[0].endswith(" True")
    for line, space in zip(lines[1:], ("action_space", "observation_space")):
        assert line.startswith(f"{space}: needs gymnasium (pip install gymnasium)")


@pytest.fixture
def gymnasium():
    return pytest.importorskip("gymnasium")


@pytest.mark.parametrize("options", [
    {"observation": "counts", "action": "velocities", "reward": "on_target", "step_ms": 10},
    {"observation": "time_surface", "action": "gaze_target", "vary": True, "truth": True},
    {"observation": "counts", "action": "references", "overrides": {**SHORT, "eyes": "both"}, "render_mode": "rgb_array"},
    {"observation": "counts", "closed_loop": True},
])
def test_gymnasiums_own_check_passes(gymnasium, options):
    from gymnasium.utils.env_checker import check_env
    with saccade.Env(SCENARIO, **{"overrides": SHORT, **options}) as env, warnings.catch_warnings():
        assert isinstance(env, gymnasium.Env)
        warnings.simplefilter("error")
        for harmless in (".*normalized space.*", ".*not having a spec.*"):
            warnings.filterwarnings("ignore", harmless)
        check_env(env)


def test_variable_events_are_in_their_space(gymnasium):
    with saccade.Env(SCENARIO, overrides=SHORT, closed_loop=True, step_ms=20) as env:
        space = env.observation_space
        observation, _ = env.reset()
        assert observation in space and space.sample() in space
        observation = env.step()[0]
        assert len(observation["events"]) > 0 and observation in space
        observation["events"]["x"][0] = 128
        assert observation not in space and {} not in space and 5 not in space


def test_environments_are_registered_and_truncate_at_the_scenarios_end(gymnasium):
    names = [name for name in gymnasium.registry if name.startswith("saccade/")]
    assert {"saccade/GazeSquare-v0", "saccade/GazeCircle-v0", "saccade/LookAtBall-v0"} <= set(names)
    for name in names:
        env = gymnasium.make(name, overrides=SHORT)
        _, info = env.reset(seed=4)
        assert info["seed"] == 4
        done, steps = False, 0
        while not done:
            _, reward, terminated, done, _ = env.step(env.action_space.sample())
            steps += 1
            assert reward in (0.0, 1.0) and not terminated
        assert steps == 30, name
        env.close()


VECTORS = """
import sys
import gymnasium, numpy as np, saccade
if __name__ == "__main__":
    for context in ("spawn", "fork"):
        envs = gymnasium.make_vec("saccade/GazeCircle-v0", 2, "async", overrides={{"run.duration_s": 0.1, "expect": {{}}}},
                                  vector_kwargs={{"context": context}})
        envs.reset(seed=[5, 6])
        envs.action_space.seed(1)
        sums = np.zeros(2)
        for _ in range(9):
            observation, *_ = envs.step(np.zeros((2, 6)))
            sums += observation["image"].reshape(2, -1).sum(1)
        print(context, *sums.astype(int))
        envs.close()
"""


def test_vector_environments_in_processes_are_the_same_as_single_ones(gymnasium, tmp_path):
    pytest.importorskip("cloudpickle")
    program = tmp_path / "vectors.py"
    program.write_text(VECTORS.format())
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, timeout=300, cwd=tmp_path)
    sums = []
    for seed in (5, 6):
        with gymnasium.make("saccade/GazeCircle-v0", overrides={"run.duration_s": 0.1, "expect": {}}) as env:
            env.reset(seed=seed)
            sums.append(sum(int(env.step(np.zeros(6))[0]["image"].sum()) for _ in range(9)))
    assert done.stdout.splitlines() == [f"{context} {sums[0]} {sums[1]}" for context in ("spawn", "fork")], done.stderr
    assert sums[0] > 0 and sums[0] != sums[1]


WINDOW = """
import saccade
with saccade.Env({scenario!r}, overrides={{"run.duration_s": 0.05, "expect": {{}}}}, render_mode="human", step_ms=10) as env:
    env.reset()
    print(env.render())
    while not env.step()[3]:
        pass
"""


def test_human_opens_a_window_or_says_that_there_is_no_display():
    without = {key: value for key, value in os.environ.items() if key != "DISPLAY"}
    pytest.importorskip("tkinter")
    code = WINDOW.format(scenario=SCENARIO)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=without)
    assert done.returncode == 1 and "RuntimeError: render_mode: human needs a display" in done.stderr
    if not (shutil.which("xvfb-run") and shutil.which("xauth")):
        pytest.skip("no xvfb-run or no xauth (Debian packages xvfb, xauth)")
    done = subprocess.run(["xvfb-run", "-a", sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout == "None\n" and done.returncode == 0, done.stderr


def test_the_example_of_a_random_search_runs(tmp_path):
    done = subprocess.run([sys.executable, SOURCE / "examples" / "gymnasium" / "random_search.py", "--seconds", "1",
                           "--processes", "1", "--duration", "1.05"], capture_output=True, text=True, cwd=SOURCE)
    assert done.returncode == 0, done.stderr
    assert "on other seeds: before" in done.stdout and "pairs of gains in" in done.stdout
