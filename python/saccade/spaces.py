"""Gymnasium, where it can be imported, and the spaces of Env."""

import numpy as np

from .arrays import event_dtype

try:
    import gymnasium
    _reason = ""
except Exception as error:  # missing or broken
    gymnasium = None
    _reason = f"{type(error).__name__}: {error}"


def require(what):
    """The module gymnasium; raises ImportError where there is none."""
    if gymnasium is None:
        raise ImportError(f"{what}: needs gymnasium (pip install gymnasium), which cannot be imported here: {_reason}; "
                          "everything else of saccade.Env works without it")
    return gymnasium


def action_space(kind, outline):
    """The space of the actions that an environment of this kind takes."""
    box = require("action_space").spaces.Box
    if kind == "none":
        return box(-1.0, 1.0, (0,), np.float64)
    if kind == "gaze_target":
        return box(np.array([-1.5, -1.0, -0.5]), np.array([-0.25, 1.0, 1.0]), dtype=np.float64)
    if kind == "velocities":
        return box(-1.0, 1.0, outline["reference_min_rad"].shape, np.float64)
    return box(outline["reference_min_rad"], outline["reference_max_rad"], dtype=np.float64)


def observation_space(kind, outline):
    """The space of the observations of this kind."""
    spaces = require("observation_space").spaces
    if kind == "events":
        return Variable(outline["size"], 2 if outline["both_eyes"] else 1, outline["joint_names"])
    width, height = outline["size"]
    shape = (4 if outline["both_eyes"] else 2, height, width)
    image = (spaces.Box(0, 255, shape, np.uint8) if kind == "counts"
             else spaces.Box(0.0, 1.0, shape, np.float32))
    joints = len(outline["joint_names"])
    return spaces.Dict({"image": image, "joints": spaces.Box(-largest_rad, largest_rad, (joints,), np.float64),
                        "joint_velocities": spaces.Box(-largest_rad_s, largest_rad_s, (joints,), np.float64)})


largest_rad = 3.2  # the values of observations are clipped to these
largest_rad_s = 50.0


if gymnasium is not None:
    class Variable(gymnasium.spaces.Space):
        """Observations with the events of a step, as many as there are: dicts with t_us, events, joints, ..."""

        def __init__(self, size, cameras, joints):
            super().__init__(None, None)
            self._of = (tuple(size), cameras, tuple(joints))

        @property
        def is_np_flattenable(self):
            return False

        def contains(self, x):
            (width, height), cameras, joints = self._of
            if not (isinstance(x, dict) and {"t_us", "events", "joints", "joint_velocities", "camera"} <= set(x)):
                return False
            events = x["events"]
            return (isinstance(events, np.ndarray) and events.dtype == event_dtype and events.ndim == 1
                    and (len(events) == 0 or bool(events["x"].max() < width and events["y"].max() < height
                                                  and events["camera"].max() < cameras))
                    and tuple(x["joints"]) == joints and tuple(x["joint_velocities"]) == joints)

        def sample(self, mask=None, probability=None):
            (width, height), cameras, joints = self._of
            random = self.np_random
            events = np.zeros(random.integers(1, 100), event_dtype)
            for field, end in (("x", width), ("y", height), ("p", 2), ("camera", cameras)):
                events[field] = random.integers(0, end, len(events))
            events["t"] = np.sort(random.integers(0, 1000, len(events)))
            return {"t_us": 1000, "events": events, "camera": {"size": (width, height)},
                    **{key: {name: float(random.uniform(-0.1, 0.1)) for name in joints}
                       for key in ("joints", "joint_velocities")}}

        def __eq__(self, other):
            return isinstance(other, Variable) and self._of == other._of

        def __repr__(self):
            (width, height), cameras, joints = self._of
            return f"Variable({width}x{height}, {cameras} cameras, {len(joints)} joints)"


def register():
    """Registers saccade's environments with gymnasium."""
    if gymnasium is None:
        return
    for name, scenario in registered.items():
        identity = f"saccade/{name}-v0"
        if identity not in gymnasium.registry:
            gymnasium.register(identity, entry_point="saccade.environment:Env", kwargs={
                "scenario": scenario, "observation": "counts", "action": "velocities", "reward": "on_target",
                "step_ms": 10, "vary": True, "overrides": {"expect": {}}})


registered = {
    "LookAtBall": "scenarios/look_at_ball.yaml",
    "GazeSquare": "scenarios/gaze_square_45cm.yaml",
    "GazeCircle": "scenarios/gaze_circle.yaml",
    "GazeThrow": "scenarios/gaze_throw.yaml",
    "GazeDistractors": "scenarios/gaze_distractors.yaml",
    "GazeOcclusion": "scenarios/gaze_occlusion.yaml",
}
