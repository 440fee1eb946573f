"""The closed loop in lockstep, as an environment of Gymnasium."""

import os

import numpy as np

from . import _saccade, spaces
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


def _choice(place, value, choices):
    if value not in choices:
        raise ValueError(f"{place}: found {shown(value)}, expected one of {', '.join(map(str, choices))}")
    return value


class _PlainEnv:
    """What gymnasium.Env has, where gymnasium cannot be imported."""

    metadata = {"render_modes": []}
    render_mode = None
    spec = None
    _np_random = None

    @property
    def unwrapped(self):
        return self

    @property
    def np_random(self):
        if self._np_random is None:
            self._np_random = np.random.default_rng()
        return self._np_random

    def reset(self, *, seed=None, options=None):
        del options
        if seed is not None:
            self._np_random = np.random.default_rng(seed)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()


_Base = _PlainEnv if spaces.gymnasium is None else spaces.gymnasium.Env

on_target_deg = 2.0  # docs/scoring.md
_rewards = {
    "on_target": lambda error_deg: float(error_deg <= on_target_deg),
    "fixation_error": lambda error_deg: -180.0 if np.isnan(error_deg) else -error_deg,
}


class Env(_Base):
    """A scenario in lockstep: a step is one or more ticks of 1 ms of simulated time. It is a gymnasium.Env where gymnasium
    can be imported; elsewhere observation_space and action_space raise ImportError and all else works.

    scenario: path of a scenario file, or a dict with its keys (files that it names are relative to the working
    directory). seed: instead of the scenario's. overrides: keys instead of the scenario's, nested or dotted:
    {"lab": {"density": 0}} or {"lab.density": 0}.
    reward: a callable (observation, info) -> float; "on_target": 1 while the left eye looks within 2 deg of the ball, else 0;
    "fixation_error": minus that angle in deg; None: 0. truth: whether info has the ground truth.
    closed_loop: whether the scenario's own detectors and gaze run and move the head, as `saccade run` does.
    observation: "events", as many as there are, with joints and camera by name; or of fixed size, images with joints as
    arrays: "counts" of the step's events, or "time_surface", exp(-age / decay_ms) of the newest event of each pixel.
    action: "references" of the joints, rad (and all other forms of step()); "velocities" in shares of the joints' largest
    speeds; or "gaze_target", a point. step_ms: ticks of a step. vary: whether reset() without a seed draws a new one.
    detectors, with closed_loop: {name: object or class} beside the scenario's, controller: an object or class in place of
    its gaze controller, both Python objects of this process (docs/external_detectors.md, external_controllers.md).
    render_mode: "rgb_array" or "human", the scene from outside beside the newest events.

    The same scenario, seed and actions give the same events as `saccade run` with the same commands. Several
    environments may exist in one process; each is used from one thread at a time. The first reset() starts OpenGL; a process
    that was forked from one that has done so cannot use or reset any environment, because the threads of OpenGL do not exist
    there: start processes with multiprocessing's method "spawn" or "forkserver".

    Raises ValueError for a scenario, override or action that is invalid, RuntimeError where the simulation cannot run.
    docs/gymnasium.md has the spaces and the keys of info.
    """

    metadata = {"render_modes": ["rgb_array", "human"], "render_fps": 30}

    def __init__(self, scenario, seed=None, overrides=None, *, reward=None, truth=False, closed_loop=False,
                 observation="events", action="references", step_ms=1, decay_ms=30.0, vary=False, detectors=None,
                 controller=None, render_mode=None):
        if isinstance(scenario, dict):
            self._source = (os.getcwd(), keys_text(scenario))
        else:
            self._source = (os.fspath(scenario), None)
        if not (overrides is None or isinstance(overrides, dict)):
            raise TypeError(f"overrides: found {shown(overrides)}, expected a dict of keys")
        if not (reward is None or callable(reward) or isinstance(reward, str)):
            raise TypeError(f"reward: found {shown(reward)}, expected a callable (observation, info) -> number, "
                            f"or one of {', '.join(_rewards)}")
        if isinstance(reward, str):
            _choice("reward", reward, _rewards)
        if not (detectors is None or isinstance(detectors, dict)):
            raise TypeError(f"detectors: found {shown(detectors)}, expected a dict of detectors by name")
        if (detectors or controller is not None) and not closed_loop:
            raise ValueError("detectors, controller: found some without closed_loop=True, expected them with it")
        self._kind = _choice("observation", observation, ("events", "counts", "time_surface"))
        self._action_kind = "none" if closed_loop else _choice("action", action,
                                                               ("references", "velocities", "gaze_target"))
        if not (isinstance(step_ms, (int, np.integer)) and step_ms >= 1):
            raise ValueError(f"step_ms: found {shown(step_ms)}, expected a whole number from 1")
        if not float(decay_ms) > 0.0:
            raise ValueError(f"decay_ms: found {shown(decay_ms)}, expected a number above 0")
        self.render_mode = _choice("render_mode", render_mode, (None, "rgb_array", "human"))
        self._detectors = dict(detectors or {})
        self._controller = controller
        self._assignments = ([f"detectors.{name}={{}}" for name in self._detectors]
                             + (["gaze.controller=object"] if controller is not None else [])
                             + assignments(overrides or {}))
        self._process = os.getpid()
        self._seed = seed
        self._reward = reward
        self._truth = truth
        self._closed_loop = closed_loop
        self._step_ms = int(step_ms)
        self._decay_us = 1000.0 * float(decay_ms)
        self._vary = vary
        self._outline = _saccade.outline(*self._arguments())  # reports what is wrong with the scenario at once
        self._joints = self._outline["joint_names"]
        self._torso_joints = self._outline["torso_joints"]
        self._head_joints = self._joints[self._torso_joints:]
        self._duration_us = self._outline["duration_us"]
        self._spaces = {}
        self._window = None
        self._simulation = None
        self._closed = False

    def _arguments(self):
        path, yaml = self._source
        return path, yaml, self._assignments, self._seed, self._detectors, self._controller

    def _make(self):
        path, yaml, given, seed, detectors, controller = self._arguments()
        return _saccade.Simulation(path, yaml, given, seed, self._closed_loop, detectors, controller)

    @property
    def observation_space(self):
        """The space of the observations, of gymnasium."""
        return self._space("observation", spaces.observation_space, self._kind)

    @property
    def action_space(self):
        """The space of the actions, of gymnasium."""
        return self._space("action", spaces.action_space, self._action_kind)

    def _space(self, name, make, kind):
        if name not in self._spaces:
            self._spaces[name] = make(kind, self._outline)
        return self._spaces[name]

    @property
    def joint_names(self):
        """The joints of neck and eyes of the scenario's head: those that an action may name, in the order of an array of
        references."""
        return list(self._head_joints)

    @property
    def limits_rad(self):
        """Position limits of the joints: name -> (min, max), rad."""
        return {name: (self._outline["min_rad"][i], self._outline["max_rad"][i])
                for i, name in enumerate(self._joints)}

    @property
    def speed_rad_s(self):
        """Largest speeds of the references of neck and eyes, of the scenario's gaze limits: name -> rad/s. An action 1 of
        `velocities` is this speed."""
        return dict(zip(self._head_joints, self._outline["reference_speed_rad_s"].tolist()))

    @property
    def scenario_yaml(self):
        """The scenario with every default, as YAML."""
        return self._outline["yaml"]

    def reset(self, *, seed=None, options=None):
        """Starts the scenario again at 0 and returns (observation, info). seed: from now on instead of the last one;
        without it the same seed again, or with `vary` one of 100000 to 999999 drawn from np_random."""
        if options:
            raise ValueError(f"options: found {shown(options)}, expected none")
        if self._closed:
            raise RuntimeError("the environment is closed")
        if self._simulation is None:
            self._process = os.getpid()
        self._require_own_process()
        super().reset(seed=seed)
        if seed is not None:
            self._seed = seed
        elif self._vary:
            self._seed = int(self.np_random.integers(100_000, 1_000_000))
        self._simulation = None  # one simulation at a time
        self._simulation = self._make()
        self._camera = self._camera_of(right=False)
        self._right_camera = self._camera_of(right=True) if self._simulation.both_eyes else None
        self._reference_rad = None
        self._newest_us = None
        if self._kind == "time_surface" or self.render_mode:
            width, height = self._outline["size"]
            self._newest_us = np.full((4 if self._outline["both_eyes"] else 2, height, width), -np.inf)
        info = {"seed": self._simulation.seed, "scenario": self._simulation.name}
        observation = self._observation()
        self._with_truth(info)
        self._show()
        return observation, info

    def step(self, action=None):
        """Applies the action, advances by step_ms and returns (observation, reward, terminated, truncated, info).

        action: None changes nothing (the last references hold, the last gaze target stays); with `references` a dict of
        references of head joints by name, rad, or an array of all of them; {"gaze_target_m": (x, y, z)} or an array of three
        numbers, a point in the root frame that the scenario's gaze controller looks at from now on. An array of three
        numbers for a head of three joints is its references.

        info["rejected"] is the reason where the head or the gaze controller rejected the action, else None.
        truncated: the scenario's duration is over. A further step() raises RuntimeError until the next reset().
        """
        simulation = self._running()
        if simulation.t_us >= self._duration_us:
            raise RuntimeError("the scenario's duration is over: reset() comes before the next step()")
        rejected = self._apply(action) if action is not None else None
        simulation.step(self._step_ms)
        observation = self._observation()
        info = self._step_info(rejected)
        truncated = simulation.t_us >= self._duration_us
        self._show()
        return observation, self._reward_of(observation, info), False, truncated, info

    def _step_info(self, rejected):
        simulation = self._simulation
        reference, target_m = simulation.reference_rad, simulation.target_m
        if self._kind == "events":
            info = {"rejected": rejected, "target_m": target_m,
                    "reference_rad": None if reference is None else dict(zip(self._head_joints, reference.tolist()))}
        else:  # vector environments stack them: a key is there where it has a value, of the same type each time
            info = {"rejected": rejected or "", "t_us": simulation.t_us}
            info.update({} if target_m is None else {"target_m": target_m})
            info.update({} if reference is None else {"reference_rad": reference})
        if self._closed_loop:
            info["detectors"] = simulation.detectors()
        return self._with_truth(info)

    def _fixation_error_deg(self):
        """Angle at the left eye between its optical axis and the ball's centre."""
        truth = self._simulation.truth()
        pose = truth["left"]["root_from_camera"]
        towards = truth["ball_m"] - pose[:3, 3]
        cosine = pose[:3, 2] @ towards / np.linalg.norm(towards)
        return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))

    def _reward_of(self, observation, info):
        if self._reward is None:
            return 0.0
        if callable(self._reward):
            return float(self._reward(observation, info))
        return _rewards[self._reward](info["fixation_error_deg"])

    def render(self):
        """With render_mode rgb_array: an array of height x width x 3, the scene from outside beside the events of the last
        20 ms (ON white, OFF black). With human: nothing, step() draws a window."""
        if self.render_mode == "human":
            self._running()
            return None
        if self.render_mode is None:
            raise RuntimeError("render(): found render_mode None, expected Env(..., render_mode=\"rgb_array\")")
        return self._image()

    def _image(self):
        scene = self._running().draw_scene(640, 480)
        width, height = self._outline["size"]
        scale = 480 / height
        rows = np.minimum((np.arange(480) / scale).astype(int), height - 1)
        columns = np.minimum((np.arange(round(width * scale)) / scale).astype(int), width - 1)
        off, on = self._newest_us[:2]
        events = np.full((height, width), 96, np.uint8)
        events[np.maximum(on, off) >= self._simulation.t_us - 20_000] = 0
        events[(on >= self._simulation.t_us - 20_000) & (on >= off)] = 255
        return np.concatenate([scene, np.repeat(events[np.ix_(rows, columns)][:, :, None], 3, axis=2)], axis=1)

    def _show(self):
        if self.render_mode != "human":
            return
        if self._window is None:
            from .window import Window
            self._window = Window(f"saccade: {self._outline['name']}")
        if self._window.is_due():
            self._window.show(self._image())

    def camera_motion(self):
        """Pose and velocity of the left camera from the joints, for Detector.process()."""
        return self._running().camera_motion()

    def close(self):
        """Frees the simulation; may be called more than once."""
        if self._window is not None:
            self._window.close()
            self._window = None
        self._simulation = None
        self._closed = True

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
        if self._closed_loop and np.size(action) == 0 and not isinstance(action, dict):
            return None
        if self._action_kind == "velocities":
            return self._move(_numbers("action", action))
        if self._action_kind == "gaze_target":
            if isinstance(action, dict):
                action = action.get("gaze_target_m", action)
            return self._look_at(_numbers("gaze_target_m", action))
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

    def _move(self, share):
        """Moves the references at shares of the largest speeds, within the limits; they stay at the limits."""
        joints = len(self._head_joints)
        if share.shape != (joints,) or not np.isfinite(share).all():
            raise ValueError(f"action: found {shown(share.tolist())}, expected {joints} numbers in [-1, 1]")
        if self._reference_rad is None:
            self._reference_rad = self._simulation.position_rad[self._torso_joints:]
        low, high = self._outline["reference_min_rad"], self._outline["reference_max_rad"]
        moved = self._reference_rad + (np.clip(share, -1.0, 1.0) * self._outline["reference_speed_rad_s"]
                                       * 1e-3 * self._step_ms)
        self._reference_rad = np.clip(moved, low, high)
        return None if self._simulation.command(self._reference_rad) else "outside_limits"

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
        events = simulation.take_events()
        if self._newest_us is not None or self._kind == "counts":
            channels, height, width = (4 if self._outline["both_eyes"] else 2), *self._outline["size"][::-1]
            pixels = ((events["camera"] * np.int64(2) + events["p"]) * height + events["y"]) * width + events["x"]
        if self._newest_us is not None:
            self._newest_us.reshape(-1)[pixels] = events["t"]
        if self._kind == "events":
            return self._variable_observation(events)
        if self._kind == "counts":
            image = np.minimum(np.bincount(pixels, minlength=channels * height * width), 255).astype(np.uint8)
            image = image.reshape(channels, height, width)
        else:
            image = np.exp((self._newest_us - simulation.t_us) / self._decay_us).clip(0.0, 1.0).astype(np.float32)
        return {"image": image, "joints": np.clip(simulation.position_rad, -spaces.largest_rad, spaces.largest_rad),
                "joint_velocities": np.clip(simulation.velocity_rad_s, -spaces.largest_rad_s, spaces.largest_rad_s)}

    def _variable_observation(self, events):
        simulation = self._simulation
        observation = {
            "t_us": simulation.t_us,
            "events": events,
            "joints": dict(zip(self._joints, simulation.position_rad.tolist())),
            "joint_velocities": dict(zip(self._joints, simulation.velocity_rad_s.tolist())),
            "camera": {**self._camera, "root_from_camera": simulation.root_from_camera(False)},
        }
        if self._right_camera is not None:
            observation["right_camera"] = {**self._right_camera, "root_from_camera": simulation.root_from_camera(True)}
        return observation

    def _with_truth(self, info):
        if self._truth or isinstance(self._reward, str):
            info["fixation_error_deg"] = self._fixation_error_deg()
        if self._truth:
            truth = self._simulation.truth()
            if self._kind != "events":
                for eye in (truth[name] for name in ("left", "right") if name in truth):
                    circle = eye.pop("circle")
                    eye.update({} if circle is None else {"circle": np.array(circle)})
            info["truth"] = truth
        return info
