"""Makes and loads random worlds: events, ground truth and camera rotation (docs/training.md).

    python3 -m training.worlds train --saccade build/release/bin/saccade --out DATA --first 100000 --count 200
    python3 -m training.worlds development --saccade build/release/bin/saccade --out DATA
    python3 -m training.worlds gaze --saccade build/release/bin/saccade --out DATA

Started again, it continues where it stopped. A world is a folder with events.npz (as saccade writes it), scenario.yaml and
world.npz (ground truth and camera; for development worlds also which events are the ball's and
which are noise, and what `best` reports). Worlds of the kind `gaze` are training worlds too: in them the gaze
follows the ball, by `best`.
"""
import argparse
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
TRAINING_SEEDS = 100_000  # and above
DEVELOPMENT_SEEDS = range(1000, 1060)
TRAINING_S, DEVELOPMENT_S = 2.0, 3.0
WITHOUT_BALL = 4  # one training seed of so many has no ball
SETTINGS = ("output.pictures=0", "run.threads=1", "output.events=npz")
GAZE_SEEDS = range(101_400, 101_500)  # of random worlds whose gaze follows the ball
GAZE_SCENARIO_SEEDS, GAZE_SCENARIOS_FROM = range(1, 13), 200_001
BEST, FOLLOW = "detectors={best: {}}", ("gaze.detector=best", "expect={}")
LENS = ("k1", "k2", "p1", "p2")


def table(path):
    return np.genfromtxt(path, delimiter=",", names=True, encoding="utf-8")


def camera_of(text):
    """Width, height, fx, fy, cx, cy and LENS of the camera of a resolved scenario."""
    block = text.split("\ncamera:")[1].split("\ncalibration:")[0]
    values = dict(re.findall(r"^  (\w+): (.+)$", block, re.MULTILINE))
    return np.array([float(values[k]) for k in ("width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px", *LENS)])


def run(saccade, scenario, seed, folder, settings):
    shutil.rmtree(folder, ignore_errors=True)
    command = [saccade, "run", scenario, "--seed", seed, "--out", folder]
    for setting in (*SETTINGS, *settings):
        command += ["--set", setting]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"training.worlds: {' '.join(map(str, command))}\n{done.stderr[-2000:]}")


def skipped(saccade, scenario, seed, folder):
    """The rule that draws more large images and moving eyes: of the worlds with a head at rest and an image below 128 px,
    odd seeds are left out. The first 10 ms of the world tell."""
    run(saccade, scenario, seed, folder, ["run.duration_s=0.01", "detectors={}"])
    text = (folder / "scenario.yaml").read_text()
    moves = "\n  script:" in text.split("\ngaze:")[1]
    return seed % 2 == 1 and camera_of(text)[0] < 128 and not moves


def gaze_scenarios():
    """Scenario, seed and settings of each."""
    metre = ("ball.trajectory.centre_m=[-1.056, 0, 0.347]", "ball.trajectory.radius_a_m=[0, -0.156, 0]", "ball.trajectory.radius_b_m=[0, 0, 0.156]")
    for seed in GAZE_SCENARIO_SEEDS:
        for lab in ("rectilinear", "textured"):
            for scenario, settings in (
                ("gaze_square_45cm", (BEST, f"emulator.shot_noise_rate_hz={(0, 10, 5, 20)[seed % 4]}", "run.duration_s=4")),
                ("gaze_circle", (BEST, f"ball.trajectory.frequency_hz={(0.5, 1, 2, 1.5)[seed % 4]}", "run.duration_s=3")),
                ("gaze_circle", (*metre, "detectors={best: {radius_px: [2, 24]}}", "run.duration_s=3")),
                (("gaze_occlusion", "gaze_distractors")[seed % 2], (BEST, "run.duration_s=4")),
            ):
                yield ROOT / f"scenarios/{scenario}.yaml", seed, (f"lab.clutter={lab}", *settings)


def make(saccade, scenario, seed, kind, ball, out):
    """A random world whose head follows its script. True if it was made now."""
    name = f"{kind}_{'ball' if ball else 'none'}_{seed}"
    settings = [f"world.with_ball={'always' if ball else 'never'}"]
    if kind == "train":
        settings += [f"run.duration_s={TRAINING_S}", "detectors={}"]
    else:
        settings += [f"run.duration_s={DEVELOPMENT_S}", BEST, "output.labels=true"]
    return make_run(saccade, scenario, seed, kind, ball, out / name, settings)


def make_gaze(saccade, scenario, out):
    """The worlds of the kind `gaze`."""
    jobs = [(seed, scenario, seed, ("world.with_ball=always", f"run.duration_s={TRAINING_S}", BEST)) for seed in GAZE_SEEDS]
    jobs += [(GAZE_SCENARIOS_FROM + i, *job) for i, job in enumerate(gaze_scenarios())]
    for number, of, seed, settings in jobs:
        folder = out / f"train_ball_{number}"
        if make_run(saccade, of, seed, "gaze", True, folder, (*settings, *FOLLOW)):
            print(folder.name, flush=True)


def make_run(saccade, scenario, seed, kind, ball, folder, settings):
    """One world. True if it was made now."""
    if folder.exists():
        return False
    part = folder.with_name(f"{folder.name}.part")
    if kind == "train" and ball and skipped(saccade, scenario, seed, part):
        shutil.rmtree(part)
        folder.mkdir()  # an empty folder: left out by the rule
        return False
    run(saccade, scenario, seed, part, settings)
    truth, eye = table(part / "truth.csv"), table(part / "eye.csv")
    arrays = {
        "camera": camera_of((part / "scenario.yaml").read_text()),
        "truth": np.stack([truth[k] for k in ("x_px", "y_px", "r_px", "visible")], 1).astype(np.float32),
        "eye": np.stack([eye[k] for k in ("qw", "qx", "qy", "qz")], 1),
    }
    if kind == "development":
        with open(part / "labels.csv", encoding="utf-8") as file:
            next(file)
            cause, of = np.array([line.rstrip().split(",")[-2:] for line in file]).reshape(-1, 2).T
        arrays["own"], arrays["noise"] = of == "ball", cause != "signal"
        found = np.atleast_1d(table(part / "detections.csv"))
        names = [n for n in ("t_us", "x_px", "y_px", "r_px", "score") if n in (found.dtype.names or ())]
        arrays["best"] = np.stack([found[n] for n in names], 1) if len(found) else np.zeros((0, 5))
        shutil.copy(part / "metrics.json", part / "best.json")
    np.savez_compressed(part / "world.npz", **arrays)
    for path in list(part.iterdir()):
        if path.name not in ("events.npz", "world.npz", "scenario.yaml", "best.json"):
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    part.rename(folder)
    return True


def seed_of(folder):
    return int(folder.name.rsplit("_", 1)[1])


class World:
    """Events sorted by time; truth (x, y, r, visible; visible 0 without a ball) and eye quaternions every ms from 1 ms on."""

    def __init__(self, folder):
        self.folder, self.name = folder, folder.name
        events, arrays = np.load(folder / "events.npz")["events"], np.load(folder / "world.npz")
        self.t_ms = (events["t"] * 1e-3).astype(np.float32)
        self.x, self.y, self.on = events["x"].astype(np.int16), events["y"].astype(np.int16), events["p"].astype(bool)
        self.camera = np.zeros(6 + len(LENS))
        self.camera[: len(arrays["camera"])] = arrays["camera"]  # older worlds have k1 alone
        self.width, self.height = int(self.camera[0]), int(self.camera[1])
        truth = arrays["truth"]
        self.truth = np.where(np.isfinite(truth).all(1, keepdims=True), truth, 0).astype(np.float32)
        self.eye = arrays["eye"]
        self.own, self.noise = (arrays[k] if k in arrays else None for k in ("own", "noise"))
        self.best = arrays["best"] if "best" in arrays else None

    def only_own(self):
        """The same world with the events of the ball alone."""
        kept = object.__new__(World)
        kept.__dict__.update(self.__dict__)
        for name in ("t_ms", "x", "y", "on"):
            setattr(kept, name, getattr(self, name)[self.own])
        return kept

    def image_shift_px(self, times_ms):
        """How far (x, y) the camera's rotation has moved the middle of the image since the previous time; 0 at the first one.
        The translation of the camera and the lens are neglected."""
        rows = np.clip(np.round(times_ms).astype(int) - 1, 0, self.duration_ms - 1)
        w, x, y, z = self.eye[rows].T
        root_from_camera = np.stack([
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], -1),
            np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], -1),
            np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], -1)], -2)
        earlier = root_from_camera[np.maximum(np.arange(len(rows)) - 1, 0), :, 2]
        axis = np.einsum("nji,nj->ni", root_from_camera, earlier)
        return axis[:, :2] / axis[:, 2:] * self.camera[2:4]

    @property
    def with_ball(self):
        return "_ball_" in self.name

    @property
    def duration_ms(self):
        return len(self.truth)


def load(out, kind):
    """All worlds of a kind that are there, by name."""
    folders = sorted(p.parent for p in out.glob(f"{kind}_*/world.npz") if not p.parent.name.endswith(".part"))
    return [World(folder) for folder in folders]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=("train", "development", "gaze"))
    parser.add_argument("--saccade", type=Path, default=ROOT / "build/release/bin/saccade", help="the program")
    parser.add_argument("--scenario", type=Path, default=ROOT / "scenarios/random_world.yaml")
    parser.add_argument("--out", type=Path, required=True, help="folder of the worlds")
    parser.add_argument("--first", type=int, help="first seed (100000; development: 1000)")
    parser.add_argument("--count", type=int, help="number of seeds (200; development: 40)")
    parser.add_argument("--without", type=int, default=15, help="development worlds without a ball (15)")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    if options.kind == "gaze":
        make_gaze(options.saccade, options.scenario, options.out)
        return
    if options.kind == "train":
        first = options.first or TRAINING_SEEDS
        if first < TRAINING_SEEDS:
            sys.exit(f"training.worlds: found --first {first}, expected {TRAINING_SEEDS} or more")
        jobs = [(seed, seed % WITHOUT_BALL != WITHOUT_BALL - 1) for seed in range(first, first + (options.count or 200))]
    else:
        first = options.first or DEVELOPMENT_SEEDS[0]
        seeds = range(first, first + (options.count if options.count is not None else 40))
        without = range(first, first + options.without)
        if not all(seed in DEVELOPMENT_SEEDS for seed in (*seeds, *without)):
            sys.exit(f"training.worlds: expected seeds {DEVELOPMENT_SEEDS[0]} to {DEVELOPMENT_SEEDS[-1]}")
        jobs = [(seed, True) for seed in seeds] + [(seed, False) for seed in without]
    for seed, ball in jobs:
        if make(options.saccade, options.scenario, seed, options.kind, ball, options.out):
            print(f"{options.kind} {seed} {'ball' if ball else 'none'}", flush=True)


if __name__ == "__main__":
    main()
