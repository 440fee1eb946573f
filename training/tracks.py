"""Logs the circles that `best` follows in the worlds of training.worlds, and the inputs of the network over them.

    python3 -m training.tracks --data DATA --log build/release/bin/track_log --out TRACKS

A log is TRACKS/WORLD.npz, by the program track_log, which has no ground truth: rows of FIELDS, one for each followed circle every
2 ms; STEP and the inputs (TrackInputs) of each step of its network; and the label of each row, from the ground truth. With
--variants N each training world has N more logs, WORLD_vK.npz, as another sensor and another speed would give them (varied()).
With --patches FOLDER every third polar patch that PatchNetwork judged is written to FOLDER/WORLD.npz (training.patch_network).
"""
import argparse
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from .worlds import World, seed_of

FIELDS = ("t_ms", "number", "x_px", "y_px", "r_px", "vx_px_s", "vy_px_s", "probability", "leaves_per_s", "moved_most_share", "silent_s")
STEP = ("t_ms", "number")
INPUTS = 185
PATCH = ("t_ms", "x_px", "y_px", "r_px", "disc_x", "disc_y", "background_x", "background_y", "log_r", "log_disc", "log_background",
         "log_relative", "log_growth", "density")  # shares of the speeds along the normal at 0 and 90 deg; PolarPatch's figures
DIRECTIONS, RINGS, DENSITIES = 24, 14, 9  # of a patch: events by polarity, motion and age; share inside the image
EVERY_PATCH = 3
VELOCITY_WINDOW_MS = 10  # of the encoders
INLIER_PX, INLIER_RADIUS_PX, LEAST_VISIBLE = 6.0, 2.0, 0.5  # docs/scoring.md
FALSE, INLIER, IGNORED = 0, 1, 2
LONGEST_MS = 5000
WITHOUT_JOINTS = 0.25  # share of the variants
EVENT = np.dtype([("t", "<i8"), ("x", "<u2"), ("y", "<u2"), ("on", "u1")])


def rotation_rad_s(eye):
    """Angular velocity of the camera in its own frame, each ms, from the quaternions (w, x, y, z)."""
    before = eye[np.maximum(np.arange(len(eye)) - VELOCITY_WINDOW_MS, 0)]
    seconds = np.minimum(np.arange(len(eye)), VELOCITY_WINDOW_MS)[:, None] * 1e-3
    w = (before * eye).sum(1, keepdims=True)
    v = before[:, :1] * eye[:, 1:] - eye[:, :1] * before[:, 1:] - np.cross(before[:, 1:], eye[:, 1:])
    return np.divide(2 * v * np.sign(w), seconds, out=np.zeros_like(v), where=seconds > 0)


def stream_of(world, only=None):
    """Events, eye quaternions and truth each ms, and whether the joints are known. only: of a development world, the events of the
    `ball` or of the `signal` (without noise)."""
    events = np.load(world.folder / "events.npz")["events"]
    if only:
        if world.noise is None:
            sys.exit(f"training.tracks: {world.folder}/world.npz: found no `noise`, expected it for --only; make the world anew")
        events = events[world.own if only == "ball" else ~world.noise]
    packed = np.empty(len(events), EVENT)
    packed["t"], packed["x"], packed["y"], packed["on"] = events["t"], events["x"], events["y"], events["p"]
    return packed, world.eye, world.truth, True


def varied(stream, size, random):
    """The same world at another speed (1/4 to 4 times, most near 1), by another sensor: polarities exchanged, events dropped, noise
    of all pixels and of a few, no joints."""
    events, eye, truth, _ = stream
    stretch = 2.0 ** np.clip(random.normal(0, 0.8), -2, 2)
    duration_ms = int(min(len(truth) * stretch, LONGEST_MS))
    events = events.copy()
    events["t"] = np.round(events["t"] * stretch)
    events = events[events["t"] <= duration_ms * 1000]
    at = np.clip((np.arange(1, duration_ms + 1) / stretch) - 1, 0, len(truth) - 1)
    truth = truth[np.round(at).astype(int)]
    eye = np.stack([np.interp(at, np.arange(len(eye)), q) for q in eye.T], 1)
    eye /= np.linalg.norm(eye, axis=1, keepdims=True)
    if random.random() < 0.5:
        events["on"] ^= 1
    if random.random() < 0.5:
        events = events[random.random(len(events)) > random.uniform(0, 0.6)]
    pixels = size[0] * size[1]
    rates_hz = []  # of pixels, with their share
    if random.random() < 0.3:
        rates_hz.append((10 ** random.uniform(-1, 1), np.arange(pixels)))
    if random.random() < 0.3:
        rates_hz.append((10 ** random.uniform(1, 2.7), random.integers(pixels, size=random.integers(1, 40))))
    for rate_hz, of in rates_hz:
        more = np.empty(random.poisson(rate_hz * len(of) * duration_ms * 1e-3), EVENT)
        pixel = of[random.integers(len(of), size=len(more))]
        more["t"], more["x"], more["y"] = random.integers(1, duration_ms * 1000, len(more)), pixel % size[0], pixel // size[0]
        more["on"] = random.integers(2, size=len(more))
        events = np.concatenate([events, more])
    return events[np.argsort(events["t"], kind="stable")], eye, truth, random.random() >= WITHOUT_JOINTS


def replay(log, world, stream, every_patch=0):
    """The rows, the steps, the patches and their densities of track_log."""
    events, eye, _, joints = stream
    radius = (4, int(np.floor(0.3 * world.height)))  # the rule of random worlds
    head = " ".join(map(str, (world.width, world.height, *world.camera[2:], *radius, int(joints), every_patch, len(eye), len(events))))
    done = subprocess.run([log], input=head.encode() + b"\n" + rotation_rad_s(eye).astype("<f8").tobytes() + events.tobytes(),
                          capture_output=True)
    if done.returncode != 0:
        sys.exit(f"training.tracks: {world.folder}: {done.stderr.decode()[-2000:]}")
    arrays, at = [], 0
    for kind, columns in (("<f4", len(FIELDS)), ("<f4", len(STEP) + INPUTS), ("<f4", len(PATCH)), ("u1", DIRECTIONS * RINGS * DENSITIES)):
        count = int(np.frombuffer(done.stdout, "<u8", 1, at)[0])
        arrays.append(np.frombuffer(done.stdout, kind, count, at + 8).reshape(-1, columns))
        at += 8 + arrays[-1].nbytes
    return arrays


def labels(rows, truth, fields=FIELDS):
    """FALSE, INLIER or IGNORED for each row, by docs/scoring.md."""
    true = truth[rows[:, 0].astype(int) - 1]
    x, y, r = (rows[:, fields.index(k)] for k in ("x_px", "y_px", "r_px"))
    inlier = (np.hypot(x - true[:, 0], y - true[:, 1]) <= INLIER_PX) & (np.abs(r - true[:, 2]) <= INLIER_RADIUS_PX)
    visible = true[:, 3]
    return np.where(visible >= LEAST_VISIBLE, inlier, np.where(visible > 0, IGNORED, FALSE)).astype(np.uint8)


def save(path, **arrays):
    part = path.with_suffix(".part.npz")
    np.savez(part, **arrays)
    part.rename(path)


def make(log, folder, out, variant, patches=None, only=None):
    name = f"{folder.name}_v{variant}" if variant else folder.name
    path = out / f"{name}.npz"
    if path.exists():
        return
    world = World(folder)
    stream = stream_of(world, only)
    if variant:
        seed = seed_of(folder)
        stream = varied(stream, (world.width, world.height), np.random.default_rng([seed, variant]))
    rows, steps, patch, densities = replay(log, world, stream, EVERY_PATCH if patches else 0)
    truth = stream[2]
    if patches:
        save(patches / path.name, patch=patch, densities=densities, label=labels(patch, truth, PATCH), truth=truth[patch[:, 0].astype(int) - 1])
    save(path, rows=rows, steps=steps, label=labels(rows, truth), truth=truth)
    print(name, len(rows), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of the worlds (training.worlds)")
    parser.add_argument("--log", type=Path, default=Path("build/release/bin/track_log"), help="the program")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--patches", type=Path, help="folder of the patches")
    parser.add_argument("--variants", type=int, default=0, help="further logs of each training world")
    parser.add_argument("--only", choices=("ball", "signal"), help="development worlds alone, with the events of the ball or without noise, to OUT/ball or OUT/signal")
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    if options.only:
        options.out /= options.only
        options.patches = options.patches and options.patches / options.only
    for folder in filter(None, (options.out, options.patches)):
        folder.mkdir(parents=True, exist_ok=True)
    folders = sorted(p.parent for p in options.data.glob("*/world.npz") if not p.parent.name.endswith(".part"))
    if options.only:
        folders = [f for f in folders if f.name.startswith("development_")]
    jobs = [(f, v) for v in range(options.variants + 1) for f in folders if v == 0 or f.name.startswith("train_")]
    with ThreadPoolExecutor(options.threads) as pool:
        list(pool.map(lambda job: make(options.log, job[0], options.out, job[1], options.patches, options.only), jobs))


if __name__ == "__main__":
    main()
