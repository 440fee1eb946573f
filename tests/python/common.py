"""What the tests of the module share."""

import os
import pathlib
import subprocess

import numpy as np
import saccade

SOURCE = pathlib.Path(os.environ["SACCADE_SOURCE"])
PROGRAM = os.environ["SACCADE_BINARY"]


def run_program(*arguments):
    """Runs the command `saccade` and returns what it printed; fails where its status is not 0."""
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def circle_events(seconds=0.5, radius_px=12.0, per_ms=20, size=(128, 128), seed=1):
    """Events on the outline of a disc that moves to the right, sorted by time."""
    rng = np.random.default_rng(seed)
    count = int(seconds * 1000) * per_ms
    events = np.zeros(count, saccade.event_dtype)
    events["t"] = np.arange(1, count + 1) * 1000 // per_ms
    centre_x = 40 + 60e-6 * events["t"]
    angle = rng.uniform(0, 2 * np.pi, count)
    events["x"] = np.clip(np.rint(centre_x + radius_px * np.cos(angle)), 0, size[0] - 1)
    events["y"] = np.clip(np.rint(64 + radius_px * np.sin(angle)), 0, size[1] - 1)
    events["p"] = np.cos(angle) > 0
    return events
