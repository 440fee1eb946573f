"""Detectors and controllers that are Python objects of the same process, and replay()."""

import numpy as np
import pytest
import saccade
from common import SOURCE, circle_events, run_program

SCENARIO = SOURCE / "examples" / "scenario" / "slow_line.yaml"
SHORT = {"run.duration_s": 0.9, "expect": {}, "output.pictures": 0}


class Mean:
    """The mean of the newest events, with a covariance."""

    threshold = 0.5

    def __init__(self, size=None, count=200):
        self.size, self.count, self.newest, self.ticks, self.resets = size, count, np.empty((0, 2)), 0, 0

    def process(self, events, motion):
        assert events.dtype == saccade.event_dtype
        self.newest = np.concatenate([self.newest, np.stack([events["x"], events["y"]], 1)])[-self.count:]
        self.motion = motion

    def advance_to(self, t_us, motion):
        self.ticks += 1

    def estimate(self):
        if len(self.newest) < self.count:
            return None
        x, y = self.newest.mean(0)
        return x, y, 12.0, 0.6, False, (4.0, 0.5, 0.25, 9.0, 0.125, 1.0)


def test_an_object_is_a_detector_with_a_covariance():
    events = circle_events()
    mine = Mean()
    rows = saccade.detect(mine, events)
    assert mine.ticks == 500 and 480 < len(rows) <= 500
    assert np.array_equal(rows["covariance_px2"][0], (4.0, 0.5, 0.25, 9.0, 0.125, 1.0))
    assert (rows["r_px"] == 12).all() and np.abs(rows["x_px"] - (40 + 60e-6 * rows["t_us"])).max() < 8
    wrapped = saccade.detector(Mean, size=(128, 128))  # a class: made with the size
    assert wrapped.name == "type" or wrapped.threshold == 0.5
    assert np.array_equal(saccade.detect(wrapped, events), rows)


def test_an_estimate_of_another_detector_can_be_passed_on():
    class Passed:
        def __init__(self):
            self.inner = saccade.detector("best", size=(128, 128))
            self.threshold = self.inner.threshold
            self.process, self.advance_to, self.estimate = self.inner.process, self.inner.advance_to, self.inner.estimate

    events = circle_events()
    expected = saccade.detect(saccade.detector("best", size=(128, 128)), events)
    assert len(expected) > 100 and np.array_equal(saccade.detect(Passed(), events), expected)


def test_what_an_object_raises_comes_through_and_wrong_answers_are_named():
    events = circle_events()

    class Wrong(Mean):
        answer = (1.0, 2.0, -3.0, 0.5)

        def estimate(self):
            return self.answer

    class Raises(Mean):
        def process(self, events, motion):
            raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        saccade.detect(Raises(), events)
    for answer in [(1.0, 2.0, -3.0, 0.5), (1.0, 2.0), "far", (1, 2, 3, np.nan), (1, 2, 3, 4, False, (1, 2))]:
        wrong = Wrong()
        wrong.answer = answer
        with pytest.raises(ValueError, match="detector Wrong: estimate.*expected None, an Estimate, or"):
            saccade.detect(wrong, events)
    with pytest.raises(TypeError, match="found the class Mean"):
        saccade.detect(Mean, events)
    with pytest.raises(TypeError, match="expected none"):
        saccade.detector(Mean(), size=(128, 128), radius_px=3)

    class Without:
        def process(self, events, motion):
            pass

        def estimate(self):
            pass

    with pytest.raises(ValueError, match="expected an object with threshold"):
        saccade.detect(Without(), events)


class Still:
    """A controller that turns the neck slowly, whatever the targets."""

    def __init__(self, limits):
        assert len(limits.min_rad) == len(limits.max_rad) == len(limits.speed_rad_s) == 6
        self.reference_rad = np.zeros(6)

    def step(self, joints_rad, target_m, dt_s):
        assert len(joints_rad) == 9 and dt_s == pytest.approx(1e-3)
        self.reference_rad[2] += 0.1 * dt_s
        return self.reference_rad


def test_objects_run_in_the_closed_loop_and_each_reset_makes_a_new_one_of_a_class():
    with saccade.Env(SCENARIO, overrides={**SHORT, "gaze.start_s": 0.1}, closed_loop=True, detectors={"mine": Mean},
                     controller=Still, step_ms=10) as env:
        assert "mine:" in env.scenario_yaml
        played = []
        for _ in range(2):
            env.reset()
            found, yaw = [], 0.0
            for _ in range(40):
                observation, *_, info = env.step()
                found.append(info["detectors"]["mine"])
                yaw = observation["joints"]["neck_yaw"]
            assert yaw == pytest.approx(0.03, abs=0.01)
            assert set(info["detectors"]) >= {"mine"} and any(f is not None for f in found)
            played.append([f and f.circle for f in found])
        assert played[0] == played[1]


def test_an_object_can_drive_the_gaze_and_its_exceptions_come_through():
    class Breaks(Mean):
        def advance_to(self, t_us, motion):
            if t_us >= 50_000:
                raise OverflowError("at 50 ms")

    options = {"overrides": {**SHORT, "gaze.detector": "mine"}, "closed_loop": True}
    with saccade.Env(SCENARIO, **options, detectors={"mine": Mean()}) as env:
        env.reset()
        for _ in range(50):
            env.step()
    with saccade.Env(SCENARIO, **options, detectors={"mine": Breaks()}) as env:
        env.reset()
        for _ in range(49):
            env.step()
        with pytest.raises(OverflowError, match="at 50 ms"):
            env.step()
    with pytest.raises(ValueError, match="best"):
        saccade.Env(SCENARIO, overrides=SHORT, closed_loop=True, detectors={"best": Mean()})
    with pytest.raises(ValueError, match="without closed_loop=True"):
        saccade.Env(SCENARIO, detectors={"mine": Mean()})


def test_a_replay_yields_the_ticks_of_a_run_with_its_detections(tmp_path):
    run = tmp_path / "run"
    run_program("run", SCENARIO, "--seed", 5, "--out", run, "--set", "run.duration_s=0.6", "--set", "expect={}", "--set",
                "output.pictures=0")
    ticks = list(saccade.replay(run, detectors={"best": {}, "mine": Mean()}))
    events = saccade.read(run / next(p.name for p in run.glob("events.*")))
    events = events[events["t"] > 1000]  # joints.csv begins at 1 ms, and the replay with it
    assert np.array_equal(np.concatenate([tick["events"] for tick in ticks]), events)
    assert all(b["t_us"] - a["t_us"] == 1000 for a, b in zip(ticks, ticks[1:]))
    assert all(tick["t_us"] - 1000 < tick["events"]["t"].min() and tick["events"]["t"].max() <= tick["t_us"]
               for tick in ticks if len(tick["events"]))
    with saccade.Env(SCENARIO, seed=5, overrides={**SHORT, "run.duration_s": 0.6}, closed_loop=True) as env:
        env.reset()
        for _ in range(500):
            observation, *_ = env.step()
    tick = next(tick for tick in ticks if tick["t_us"] == 500_000)
    assert tick["joints"] == pytest.approx(observation["joints"], abs=1e-5)  # joints.csv has six digits
    assert tick["motion"].root_from_camera == pytest.approx(observation["camera"]["root_from_camera"], abs=1e-5)
    assert tick["truth"]["visible"] > 0.5 and 5 < tick["truth"]["r_px"] < 30
    assert set(tick["estimates"]) == {"best", "mine"} and any(t["estimates"]["mine"] is not None for t in ticks)


def test_a_replay_of_a_bare_recording_has_no_joints_and_names_what_is_wrong(tmp_path):
    events = circle_events(0.05)
    saccade.write(tmp_path / "a.aedat4", events, size=(128, 128))
    ticks = list(saccade.replay(tmp_path / "a.aedat4", detectors="best"))
    assert sum(len(tick["events"]) for tick in ticks) == len(events)
    assert ticks[0]["joints"] is None and ticks[0]["motion"] is None and ticks[0]["truth"] is None
    with pytest.raises(ValueError, match="found bset"):
        saccade.replay(tmp_path / "a.aedat4", detectors="bset")
    with pytest.raises(TypeError, match="detectors: mine: found 5"):
        saccade.replay(tmp_path / "a.aedat4", detectors={"mine": 5})
    with pytest.raises(ValueError, match="No such file"):
        saccade.replay(tmp_path / "b.aedat4")
