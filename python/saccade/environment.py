"""The closed loop in lockstep, with the conventions of Gymnasium."""

import os

import numpy as np

from . import _saccade
from .plain_errors import shown
from .yaml_text import assignments, keys_text


def _numbers(place, value, shape=None):
    """The value as an array of numbers, of that shape where one is given."""
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        array = None
    if array is None or (shape is not None and array.shape != shape):
        raise ValueError(f"{place}: found {shown(value)}, expected " + ("a number" if shape == () else "numbers"))
    return array


class Env:
    """A scenario in lockstep: one step is one tick of 1 ms of simulated time.

    scenario: path of a scenario file, or a dict with its keys (files that it names are relative to the working
    directory). seed: instead of the scenario's. overrides: keys instead of the scenario's, nested or dotted:
    {"lab": {"density": 0}} or {"lab.density": 0}. reward: a callable (observation, info) -> float; without it the reward
    is 0. truth: whether info has the ground truth. closed_loop: whether the scenario's own detectors and gaze run and
    move the head, as `saccade run` does.

    The same scenario, seed and actions give the same events as `saccade run` with the same commands. Several
    environments may exist in one process; each is used from one thread at a time. A process that was forked from one that
    has made an environment cannot use or make any, because the threads of OpenGL do not exist there: start processes with
    multiprocessing's method "spawn" or "forkserver".

    Raises ValueError for a scenario, override or action that is invalid, RuntimeError where the simulation cannot run.
    """

    metadata = {"render_modes": []}
    render_mode = None
    spec = None

    def __init__(self, scenario, seed=None, overrides=None, *, reward=None, truth=False, closed_loop=False):
        if isinstance(scenario, dict):
            self._source = (os.getcwd(), keys_text(scenario))
        else:
            self._source = (os.fspath(scenario), None)
        if not (overrides is None or isinstance(overrides, dict)):
            raise TypeError(f"overrides: found {shown(overrides)}, expected a dict of keys")
        if not (reward is None or callable(reward)):
            raise TypeError(f"reward: found {shown(reward)}, expected a callable (observation, info) -> number")
        self._process = os.getpid()
        self._assignments = assignments(overrides or {})
        self._seed = seed
        self._reward = reward
        self._truth = truth
        self._closed_loop = closed_loop
        self._next = self._make()  # reports what is wrong with the scenario at once
        self._joints = self._next.joint_names
        self._torso_joints = self._next.torso_joints
        self._head_joints = self._joints[self._torso_joints:]
        self._simulation = None
        self._closed = False

    def _make(self):
        path, yaml = self._source
        return _saccade.Simulation(path, yaml, self._assignments, self._seed, self._closed_loop)

    @property
    def unwrapped(self):
        return self

    @property
    def joint_names(self):
        """The joints of neck and eyes of the scenario's head: those that an action may name, in the order of an array of
        references."""
        return list(self._head_joints)

    @property
    def limits_rad(self):
        """Position limits of the joints: name -> (min, max), rad."""
        low, high = self._running().limits_rad
        return {name: (low[i], high[i]) for i, name in enumerate(self._joints)}

    @property
    def scenario_yaml(self):
        """The scenario with every default, as YAML."""
        return self._running().yaml

    def reset(self, *, seed=None, options=None):
        """Starts the scenario again at 0 and returns (observation, info). seed: from now on instead of the last one."""
        del options
        if self._closed:
            raise RuntimeError("the environment is closed")
        self._require_own_process()
        if seed is not None and seed != self._seed:
            self._seed = seed
            self._next = None
        self._simulation = None  # one simulation at a time
        self._simulation = self._next if self._next is not None else self._make()
        self._next = None
        self._camera = self._camera_of(right=False)
        self._right_camera = self._camera_of(right=True) if self._simulation.both_eyes else None
        self._duration_us = self._simulation.duration_us
        info = {"seed": self._simulation.seed, "scenario": self._simulation.name}
        return self._observation(), self._with_truth(info)

    def step(self, action=None):
        """Applies the action, advances by 1 ms and returns (observation, reward, terminated, truncated, info).

        action: None changes nothing (the last references hold, the last gaze target stays); a dict of references of
        head joints by name, rad, or an array of all of them; {"gaze_target_m": (x, y, z)} or an array of three
        numbers, a point in the root frame that the scenario's gaze controller looks at from now on. An array of three
        numbers for a head of three joints is their references.

        info["rejected"] is the reason where the head or the gaze controller rejected the action, else None.
        truncated: the scenario's duration is over. A further step() raises RuntimeError until the next reset().
        """
        simulation = self._running()
        if simulation.t_us >= self._duration_us:
            raise RuntimeError("the scenario's duration is over: reset() comes before the next step()")
        info = {"rejected": self._apply(action) if action is not None else None}
        simulation.step()
        reference = simulation.reference_rad
        info["reference_rad"] = None if reference is None else dict(zip(self._head_joints, reference.tolist()))
        info["target_m"] = simulation.target_m
        if self._closed_loop:
            info["detectors"] = simulation.detectors()
        self._with_truth(info)
        observation = self._observation()
        reward = 0.0 if self._reward is None else float(self._reward(observation, info))
        return observation, reward, False, simulation.t_us >= self._duration_us, info

    def camera_motion(self):
        """Pose and velocity of the left camera from the joints, for Detector.process()."""
        return self._running().camera_motion()

    def close(self):
        """Frees the simulation; may be called more than once."""
        self._simulation = None
        self._next = None
        self._closed = True

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()

    def _running(self):
        if self._simulation is None:
            raise RuntimeError("the environment is closed" if self._closed else "reset() comes before this")
        self._require_own_process()
        return self._simulation

    def _require_own_process(self):
        if os.getpid() != self._process:
            raise RuntimeError("the environment was made in another process, of which this one is a fork without its "
                               "threads; start processes with multiprocessing.get_context(\"spawn\")")

    def _apply(self, action):
        simulation = self._simulation
        if isinstance(action, dict):
            if "gaze_target_m" in action:
                if len(action) > 1:
                    raise ValueError("action: found a gaze target and joint references, expected one of them")
                return self._look_at(_numbers("gaze_target_m", action["gaze_target_m"]))
            unknown = [name for name in action if name not in self._head_joints]
            if unknown:
                raise ValueError(f"action: found the joint {unknown[0]}, expected some of {', '.join(self._head_joints)}")
            last = simulation.reference_rad
            reference = simulation.position_rad[self._torso_joints:] if last is None else last
            for name, value in action.items():
                reference[self._head_joints.index(name)] = _numbers(name, value, ())
            return None if simulation.command(reference) else "outside_limits"
        values = _numbers("action", action)
        joints = len(self._head_joints)
        if values.shape == (joints,):
            return None if simulation.command(values) else "outside_limits"
        if values.shape == (3,):
            return self._look_at(values)
        raise ValueError(f"action: found an array of shape {values.shape}, "
                         f"expected (3,) for a gaze target or ({joints},) for joint references")

    def _look_at(self, target_m):
        if target_m.shape != (3,):
            raise ValueError(f"action: found a gaze target of shape {target_m.shape}, expected (3,)")
        status = self._simulation.look_at(target_m)
        return None if status == "ok" else status

    def _camera_of(self, right):
        camera = self._simulation.camera(right)
        names = ("fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "p1", "p2",
                 "lens", "k3", "k4")
        return {"size": camera.size, **{name: getattr(camera, name) for name in names}}

    def _observation(self):
        simulation = self._simulation
        observation = {
            "t_us": simulation.t_us,
            "events": simulation.take_events(),
            "joints": dict(zip(self._joints, simulation.position_rad.tolist())),
            "joint_velocities": dict(zip(self._joints, simulation.velocity_rad_s.tolist())),
            "camera": {**self._camera, "root_from_camera": simulation.root_from_camera(False)},
        }
        if self._right_camera is not None:
            observation["right_camera"] = {**self._right_camera, "root_from_camera": simulation.root_from_camera(True)}
        return observation

    def _with_truth(self, info):
        if self._truth:
            info["truth"] = self._simulation.truth()
        return info
