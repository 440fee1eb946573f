"""A gaze controller of one's own in Python: eyes alone, speed proportional to the gaze error (docs/external_controllers.md).

It needs the Python module `saccade` for the kinematics of the head.
"""

import numpy as np
import saccade

TILT, VERSION = 3, 4  # of the six joints: neck pitch, roll, yaw, eyes tilt, version, vergence


class Proportional:
    """Turns tilt and version of the eyes towards the newest target of the left eye.

    limits: min_rad, max_rad and speed_rad_s of the six joints of neck and eyes. gain_per_s: share of the gaze error that
    the eyes correct per second.
    """

    def __init__(self, limits, gain_per_s=8.0):
        self.limits = limits
        self.gain_per_s = gain_per_s
        self.reference_rad = np.zeros(6)
        self.target_m = None

    def step(self, joints_rad, target_m, dt_s):
        """joints_rad: positions of the nine joints of torso, neck and eyes. target_m: a new point to look at in the root
        frame, or None. dt_s: time since the last step. Returns references of the six joints of neck and eyes, rad."""
        if target_m is not None:
            self.target_m = target_m
        if self.target_m is not None:
            root_from_eye = saccade.root_from_eye(joints_rad, "left")
            in_eye = np.linalg.inv(root_from_eye) @ np.append(self.target_m, 1.0)
            step = self.gain_per_s * dt_s
            self.reference_rad[VERSION] += step * np.arctan2(in_eye[0], in_eye[2])
            self.reference_rad[TILT] += step * np.arctan2(-in_eye[1], in_eye[2])
            self.reference_rad = np.clip(self.reference_rad, self.limits.min_rad, self.limits.max_rad)
        return self.reference_rad

    def rest(self):
        """The target is lost for good: forget it."""
        self.target_m = None
