"""Logs the circles that `best` follows in the worlds of training.worlds, with what its score is made of.

    python3 -m training.tracks --data DATA --log build/release/bin/track_log --out TRACKS

A log is TRACKS/WORLD.npz: rows of FIELDS and the inputs of the score (DiscInputs), one for each followed circle every 2 ms,
by the program track_log, which has no ground truth; and the label of each row, from the ground truth.
"""
import argparse
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from .worlds import World

FIELDS = ("t_ms", "number", "steps", "x_px", "y_px", "r_px", "vx_px_s", "vy_px_s", "probability", "moved_most_share", "silent_s")
INPUTS = 39
VELOCITY_WINDOW_MS = 10  # of the encoders
INLIER_PX, INLIER_RADIUS_PX, LEAST_VISIBLE = 6.0, 2.0, 0.5  # docs/scoring.md
FALSE, INLIER, IGNORED = 0, 1, 2
EVENT = np.dtype([("t", "<i8"), ("x", "<u2"), ("y", "<u2"), ("on", "u1")])


def rotation_rad_s(eye):
    """Angular velocity of the camera in its own frame, each ms, from the quaternions (w, x, y, z)."""
    before = eye[np.maximum(np.arange(len(eye)) - VELOCITY_WINDOW_MS, 0)]
    seconds = np.minimum(np.arange(len(eye)), VELOCITY_WINDOW_MS)[:, None] * 1e-3
    w = (before * eye).sum(1, keepdims=True)
    v = before[:, :1] * eye[:, 1:] - eye[:, :1] * before[:, 1:] - np.cross(before[:, 1:], eye[:, 1:])
    return np.divide(2 * v * np.sign(w), seconds, out=np.zeros_like(v), where=seconds > 0)


def replay(log, world):
    """The rows of track_log."""
    radius = (4, int(np.floor(0.3 * world.height)))  # the rule of random worlds
    events = np.load(world.folder / "events.npz")["events"]
    packed = np.empty(len(events), EVENT)
    packed["t"], packed["x"], packed["y"], packed["on"] = events["t"], events["x"], events["y"], events["p"]
    head = " ".join(map(str, (world.width, world.height, *world.camera[2:], *radius, world.duration_ms, len(packed))))
    done = subprocess.run([log], input=head.encode() + b"\n" + rotation_rad_s(world.eye).astype("<f8").tobytes() + packed.tobytes(),
                          capture_output=True)
    if done.returncode != 0:
        sys.exit(f"training.tracks: {world.folder}: {done.stderr.decode()[-2000:]}")
    return np.frombuffer(done.stdout, "<f4").reshape(-1, len(FIELDS) + INPUTS)


def labels(rows, truth):
    """FALSE, INLIER or IGNORED for each row, by docs/scoring.md."""
    true = truth[rows[:, 0].astype(int) - 1]
    apart = np.hypot(rows[:, 3] - true[:, 0], rows[:, 4] - true[:, 1])
    inlier = (apart <= INLIER_PX) & (np.abs(rows[:, 5] - true[:, 2]) <= INLIER_RADIUS_PX)
    visible = true[:, 3]
    return np.where(visible >= LEAST_VISIBLE, inlier, np.where(visible > 0, IGNORED, FALSE)).astype(np.uint8)


def make(log, folder, out):
    path = out / f"{folder.name}.npz"
    if path.exists():
        return
    world = World(folder)
    rows = replay(log, world)
    part = path.with_suffix(".part.npz")
    np.savez_compressed(part, rows=rows, label=labels(rows, world.truth), truth=world.truth)
    part.rename(path)
    print(folder.name, len(rows), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of the worlds (training.worlds)")
    parser.add_argument("--log", type=Path, default=Path("build/release/bin/track_log"), help="the program")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    folders = sorted(p.parent for p in options.data.glob("*/world.npz") if not p.parent.name.endswith(".part"))
    with ThreadPoolExecutor(options.threads) as pool:
        list(pool.map(lambda folder: make(options.log, folder, options.out), folders))


if __name__ == "__main__":
    main()
