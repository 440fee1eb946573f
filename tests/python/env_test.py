import os
import signal
import subprocess
import sys

import numpy as np
import pytest
import saccade
from common import SOURCE, run_program

SCENARIO = SOURCE / "examples" / "scenario" / "slow_line.yaml"
SHORT = {"run.duration_s": 0.9, "expect": {}, "output.pictures": 0}
EVENT_FILE = "events.csv"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """The events of `saccade run`."""
    folder = tmp_path_factory.mktemp("run") / "run"
    run_program("run", SCENARIO, "--seed", 5, "--out", folder, "--set", "run.duration_s=0.9", "--set", "expect={}",
                "--set", "output.events=csv", "--set", "output.pictures=0")
    return saccade.read(folder / EVENT_FILE, size=(128, 128))


def play(env, actions=None):
    """Steps to the end: events, references and (events, info) of every tick."""
    events, references = [], []
    env.reset()
    truncated, i = False, 0
    while not truncated:
        observation, reward, terminated, truncated, info = env.step(None if actions is None else actions[i])
        events.append(observation["events"])
        references.append(info["reference_rad"])
        i += 1
    return np.concatenate(events), references


def test_the_closed_loop_gives_the_events_of_a_run_and_so_do_its_commands(recorded):
    with saccade.Env(SCENARIO, seed=5, overrides=SHORT, closed_loop=True) as env:
        events, references = play(env)
    assert len(recorded) > 10_000
    assert np.array_equal(events, recorded)
    moved = [r for r in references if r is not None]
    assert len(references) == 900 and np.ptp([r["neck_yaw"] for r in moved]) > 0.01
    # The same references as actions: run sends them after the tick, step() before the next one.
    with saccade.Env(SCENARIO, seed=5, overrides=SHORT) as env:
        again, _ = play(env, [None] + references[:-1])
    assert np.array_equal(again, recorded)


def test_the_seed_decides(recorded):
    with saccade.Env(SCENARIO, seed=6, overrides=SHORT, closed_loop=True) as env:
        other, _ = play(env)
        assert not np.array_equal(other, recorded)
        env.reset(seed=5)
        again, _ = play(env)
    assert np.array_equal(again, recorded)


def test_varied_episodes_have_seeds_of_their_own_that_the_first_one_decides():
    with saccade.Env(SCENARIO, overrides=SHORT, vary=True) as env:
        seeds = [env.reset(seed=7)[1]["seed"], env.reset()[1]["seed"], env.reset()[1]["seed"]]
        again = [env.reset(seed=7)[1]["seed"], env.reset()[1]["seed"], env.reset()[1]["seed"]]
    assert seeds == again and seeds[0] == 7 and len(set(seeds)) == 3
    assert all(100_000 <= seed < 1_000_000 for seed in seeds[1:])


def test_a_step_of_several_ticks_has_the_events_of_all():
    with saccade.Env(SCENARIO, seed=5, overrides=SHORT, closed_loop=True) as env:
        ticks, _ = play(env)
    with saccade.Env(SCENARIO, seed=5, overrides=SHORT, closed_loop=True, step_ms=7) as env:
        steps, references = play(env)
    assert len(references) == -(-900 // 7) and np.array_equal(ticks, steps)


def test_images_count_the_events_of_the_step_and_surfaces_have_their_age():
    options = {"seed": 5, "overrides": SHORT, "closed_loop": True, "step_ms": 20}
    with saccade.Env(SCENARIO, **options) as env, saccade.Env(SCENARIO, **options, observation="counts") as counts, \
            saccade.Env(SCENARIO, **options, observation="time_surface", decay_ms=10) as surface:
        for each in (env, counts, surface):
            each.reset()
        newest = np.full((2, 128, 128), -np.inf)
        for _ in range(20):
            observation = env.step()[0]
            events, t_us = observation["events"], observation["t_us"]
            expected = np.zeros((2, 128, 128), int)
            for x, y, p, t in zip(events["x"], events["y"], events["p"], events["t"]):
                expected[int(p), y, x] += 1
                newest[int(p), y, x] = t
            image = counts.step()[0]
            assert image["image"].dtype == np.uint8 and np.array_equal(image["image"], np.minimum(expected, 255))
            assert np.allclose(image["joints"], list(observation["joints"].values()))
            seen = surface.step()[0]["image"]
            assert np.allclose(seen, np.exp((newest - t_us) / 10_000), atol=1e-6)
        assert expected.sum() > 0


def test_velocities_move_the_references_at_shares_of_the_largest_speed_and_stop_at_the_limits():
    with saccade.Env(SCENARIO, overrides=SHORT, action="velocities", step_ms=10) as env:
        start = list(env.reset()[0]["joints"].values())[-6:]
        yaw = env.joint_names.index("neck_yaw")
        share = np.zeros(6)
        share[yaw] = 0.5
        for i in range(1, 60):
            info = env.step(share)[-1]
            expected = start[yaw] + 0.5 * env.speed_rad_s["neck_yaw"] * 0.01 * i
            assert info["reference_rad"]["neck_yaw"] == pytest.approx(min(expected, env.limits_rad["neck_yaw"][1]), abs=1e-3)
        assert info["rejected"] is None
        with pytest.raises(ValueError, match="expected 6 numbers"):
            env.step([np.nan] * 6)


def test_rewards_by_name_follow_the_angle_between_the_optical_axis_and_the_ball():
    with saccade.Env(SCENARIO, overrides=SHORT, truth=True, reward="on_target") as env:
        env.reset()
        rewards = set()
        for i in range(500):
            observation, reward, *_, info = env.step(info["truth"]["ball_m"] if i else None)
            pose = info["truth"]["left"]["root_from_camera"]
            towards = info["truth"]["ball_m"] - pose[:3, 3]
            angle_deg = np.degrees(np.arccos(pose[:3, 2] @ towards / np.linalg.norm(towards)))
            assert info["fixation_error_deg"] == pytest.approx(angle_deg, abs=1e-6)
            assert reward == (1.0 if angle_deg <= 2.0 else 0.0)
            rewards.add(reward)
        assert rewards == {0.0, 1.0}


def test_an_image_of_the_scene_is_drawn_beside_the_events():
    with saccade.Env(SCENARIO, overrides=SHORT, closed_loop=True, step_ms=50, render_mode="rgb_array") as env:
        env.reset()
        before = env.render()
        env.step()
        image = env.render()
    assert image.shape == (480, 640 + 480, 3) and image.dtype == np.uint8
    assert image[:, :640].std() > 10  # a scene, not one colour
    assert set(np.unique(before[:, 640:])) == {96} and set(np.unique(image[:, 640:])) == {0, 96, 255}
    with saccade.Env(SCENARIO, overrides=SHORT) as env, pytest.raises(RuntimeError, match="render_mode"):
        env.reset(), env.render()


def test_two_environments_in_one_process_do_not_disturb_each_other(recorded):
    one = saccade.Env(SCENARIO, seed=5, overrides=SHORT, closed_loop=True)
    two = saccade.Env(SCENARIO, seed=5, overrides=SHORT, closed_loop=True)
    one.reset(), two.reset()
    for _ in range(400):
        a, b = one.step()[0]["events"], two.step()[0]["events"]
        assert np.array_equal(a, b)
    one.close()
    assert len(two.step()[0]["joints"]) == 9
    two.close()


def test_an_observation_has_events_joints_camera_and_time():
    with saccade.Env(SCENARIO, overrides=SHORT) as env:
        observation, info = env.reset()
        assert observation["t_us"] == 0 and len(observation["events"]) == 0 and info["seed"] == 3
        observation, reward, terminated, truncated, info = env.step()
        assert observation["t_us"] == 1000 and reward == 0.0 and not terminated and not truncated
        assert observation["events"].dtype == saccade.event_dtype
        assert list(observation["joints"]) == saccade.joint_names
        camera = observation["camera"]
        assert camera["size"] == (128, 128)
        expected = saccade.root_from_eye(observation["joints"])
        assert np.allclose(camera["root_from_camera"], expected, atol=1e-12)
        assert "truth" not in info and "detectors" not in info


def test_joint_references_by_name_move_these_joints():
    with saccade.Env(SCENARIO, overrides=SHORT) as env:
        start = env.reset()[0]["joints"]
        info = env.step({"neck_yaw": 0.1})[-1]
        assert info["rejected"] is None and info["reference_rad"]["neck_yaw"] == 0.1
        for _ in range(500):
            observation, *_, info = env.step()
        assert abs(observation["joints"]["neck_yaw"] - 0.1) < 0.01
        assert abs(observation["joints"]["eyes_tilt"] - start["eyes_tilt"]) < 0.01


def test_a_gaze_target_is_looked_at_with_the_scenarios_controller():
    target = np.array([-0.5, 0.1, 0.4])
    with saccade.Env(SCENARIO, overrides=SHORT) as env:
        env.reset()
        env.step(target)
        for _ in range(700):
            observation, *_, info = env.step()
        assert info["target_m"] == pytest.approx(target)
        pose = observation["camera"]["root_from_camera"]
        towards = target - pose[:3, 3]
        cosine = pose[:3, 2] @ towards / np.linalg.norm(towards)
        assert np.degrees(np.arccos(cosine)) < 2.0  # "on target" of docs/scoring.md
        same = env.step({"gaze_target_m": target})[-1]
        assert same["rejected"] is None


def test_what_the_head_cannot_do_is_rejected_and_reported():
    with saccade.Env(SCENARIO, overrides=SHORT) as env:
        env.reset()
        assert env.step({"neck_yaw": 3.0})[-1]["rejected"] == "outside_limits"
        assert env.step({"neck_yaw": float("nan")})[-1]["rejected"] == "outside_limits"
        assert env.step((0.5, 0.0, 0.4))[-1]["rejected"] == "behind"
        low, high = env.limits_rad["neck_yaw"]
        assert low < 0 < high < 3.0


def test_truth_comes_only_when_asked_for_and_scores_detections():
    rewards = []

    def reward(observation, info):
        circle = info["truth"]["left"]["circle"]
        rewards.append(circle)
        return -1.0 if circle is None else 0.5

    with saccade.Env(SCENARIO, overrides=SHORT, truth=True, reward=reward) as env:
        info = env.reset()[1]
        assert info["truth"]["t_us"] == 0
        _, value, *_, info = env.step()
        assert value == (0.5 if rewards[0] else -1.0)
        assert info["truth"]["ball_m"].shape == (3,) and 0 <= info["truth"]["left"]["visible"] <= 1


def test_a_scenario_may_be_a_dict():
    scenario = {"name": "from_python", "run": {"duration_s": 0.05}, "lab": {"density": 0},
                "ball": {"trajectory": {"kind": "waypoints", "points_m": [[-0.5, -0.1, 0.4], [-0.5, 0.1, 0.4]],
                                        "profile": "constant_speed", "speed_m_s": 0.15}},
                "detectors": {"best": {}}, "gaze": {"detector": "none"}}
    with saccade.Env(scenario, seed=2) as env:
        _, info = env.reset()
        assert info == {"seed": 2, "scenario": "from_python"}
        steps = 1
        while not env.step()[3]:
            steps += 1
        assert steps == 50


def test_mistakes_are_reported_with_the_messages_of_the_program():
    with pytest.raises(ValueError, match="lab.densty: found an unknown key"):
        saccade.Env(SCENARIO, overrides={"lab": {"densty": 1}})
    with pytest.raises(ValueError, match="no such file"):
        saccade.Env("absent.yaml")
    with saccade.Env(SCENARIO, overrides=SHORT) as env:
        with pytest.raises(RuntimeError, match="reset"):
            env.step()
        env.reset()
        with pytest.raises(ValueError, match="expected some of neck_pitch"):
            env.step({"torso_yaw": 0.1})
        with pytest.raises(ValueError, match="shape"):
            env.step(np.zeros(4))
    with pytest.raises(RuntimeError, match="closed"):
        env.step()
    with saccade.Env(SCENARIO, overrides=SHORT, closed_loop=True) as env:
        env.reset()
        with pytest.raises(ValueError, match="closed_loop"):
            env.step({"neck_yaw": 0.1})


def test_joints_are_those_of_the_scenarios_head():
    scenario = SOURCE / "scenarios" / "gaze_square_pan_tilt.yaml"
    with saccade.Env(scenario, seed=1, overrides={"run.duration_s": 0.2, "expect": {}}) as env:
        assert env.joint_names == ["pan", "tilt"]
        observation, _ = env.reset()
        assert list(observation["joints"]) == ["pan", "tilt"]
        assert set(env.limits_rad) == {"pan", "tilt"}
        for _ in range(150):
            observation, _, _, _, info = env.step({"tilt": 0.1})
        assert set(info["reference_rad"]) == {"pan", "tilt"}
        assert abs(observation["joints"]["tilt"] - 0.1) < 0.02
        assert env.step(np.array([0.05, 0.1]))[4]["rejected"] is None
        with pytest.raises(ValueError, match="expected some of pan, tilt"):
            env.step({"neck_yaw": 0.1})
        with pytest.raises(ValueError, match=r"\(2,\) for joint references"):
            env.step(np.zeros(6))


def test_a_step_after_the_end_is_an_error_until_the_next_reset():
    with saccade.Env(SCENARIO, overrides={**SHORT, "run.duration_s": 0.01}) as env:
        env.reset()
        assert [env.step()[3] for _ in range(10)] == [False] * 9 + [True]
        with pytest.raises(RuntimeError, match="the scenario's duration is over: reset.. comes before"):
            env.step()
        env.reset()
        assert env.step()[0]["t_us"] == 1000


def test_wrong_types_of_arguments_and_actions_are_named():
    with pytest.raises(TypeError, match="overrides: found 5 .int., expected a dict"):
        saccade.Env(SCENARIO, overrides=5)
    for key, value in (("observation", "pictures"), ("action", "forces"), ("reward", "much"), ("render_mode", "ascii"),
                       ("step_ms", 0), ("decay_ms", 0)):
        with pytest.raises(ValueError, match=f"{key}: found {value!r}"):
            saccade.Env(SCENARIO, overrides=SHORT, **{key: value})
    with pytest.raises(TypeError, match="Env: seed: found 'one' .str., expected a whole number, or None"):
        saccade.Env(SCENARIO, seed="one")
    with saccade.Env(SCENARIO, overrides=SHORT) as env:
        env.reset()
        with pytest.raises(ValueError, match="action: found 'left' .str., expected numbers"):
            env.step("left")
        with pytest.raises(ValueError, match="neck_yaw: found 'far' .str., expected a number"):
            env.step({"neck_yaw": "far"})


def in_fork(work):
    """What `work` returns in a forked process, a text, and the status with which it ends; it ends as those of
    multiprocessing do, because Mesa's exit handlers crash in a fork."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        signal.alarm(60)
        try:
            text = str(work())
        except BaseException as error:
            text = f"{type(error).__name__}: {error}"
        os.write(write, text.encode())
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as pipe:
        text = pipe.read()
    return text, os.waitpid(child, 0)[1]


FORKS = """
import os, sys
sys.path.insert(0, os.path.dirname({file!r}))
from env_test import *
env = saccade.Env(SCENARIO, overrides=SHORT)
env.reset(), env.step()
emulator = saccade.Emulator((64, 48), threads=3)
emulator.process(np.full((48, 64), 40.0, np.float32), 0)
def use():
    return len(emulator.process(np.full((48, 64), 200.0, np.float32), 1000))
print(in_fork(lambda: saccade.Env(SCENARIO, overrides=SHORT).reset()))
print(in_fork(env.step))
print(in_fork(env.reset))
print(in_fork(use)[1], in_fork(use)[0] == str(use()))
print(env.step()[0]["t_us"])
"""


def test_a_forked_process_refuses_what_would_wait_for_threads_that_it_does_not_have():
    done = subprocess.run([sys.executable, "-c", FORKS.format(file=__file__)], capture_output=True, text=True, timeout=200)
    lines = done.stdout.splitlines()
    assert len(lines) == 5, done.stdout + done.stderr
    assert "RuntimeError: no OpenGL: this process is a fork of one that has used it" in lines[0] and lines[0].endswith(", 0)")
    for line in lines[1:3]:
        assert "RuntimeError: the environment was made in another process" in line and line.endswith(", 0)")
    assert lines[3] == "0 True"
    assert lines[4] == "2000"
