"""Streams with ground truth that scripts/fit and scripts/fit_patch fit weights to, and how weights are written down."""
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CENTRE_PX, RADIUS_PX = 6.0, 2.0  # of an inlier (docs/scoring.md)
SCENES = [  # name, scenario, seed, settings
    (f"{scenario}_{clutter}_{variation}", scenario, seed, [f"lab.clutter={clutter}", *settings])
    for scenario in ("hand_move", "eye_move")
    for clutter in ("textured", "rectilinear")
    for variation, seed, settings in (
        ("plain", 1, []),
        ("noisy", 2, ["emulator.preset=noisy"]),
        ("small", 3, ["ball.diameter_m=0.05"]),
        ("fast", 4, ["gaze.script.speed_deg_s=300", "gaze.script.dwell_s=0.1"] if scenario == "eye_move" else []),
    )
] + [  # the gaze follows the ball
    (f"{scenario}_{clutter}_{variation}", scenario, seed, [
        f"lab.clutter={clutter}", "detectors={best: {}}", "gaze.continuity_gate.near_score=0.2", *settings])
    for clutter in ("textured", "rectilinear")
    for scenario, variation, seed, settings in (
        ("gaze_circle", "1_hz", 5, ["ball.trajectory.frequency_hz=1"]),
        ("gaze_circle", "1.5_hz", 6, ["ball.trajectory.frequency_hz=1.5"]),
        ("gaze_square_45cm", "plain", 7, []),
        ("gaze_occlusion", "plain", 8, []),
    )
]


def run(command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        sys.exit(f"{sys.argv[0]}: {' '.join(map(str, command))}\n{done.stderr[-2000:]}")


def make_scenes(options, later_seeds=0):
    """Runs the scenes that options.out does not hold yet, with seeds that are later by so many."""
    def make(scene):
        name, scenario, seed, settings = scene
        folder = options.out / "scenes" / name
        if (folder / "truth.csv").exists():
            return
        command = [options.saccade, "run", ROOT / f"scenarios/{scenario}.yaml", "--seed", seed + later_seeds]
        command += ["--out", folder, "--force"]
        for setting in (
            "detectors={}", "run.duration_s=3", "run.threads=1", "output.pictures=0", "render.keyframe_samples=3",
            *settings,
        ):
            command += ["--set", setting]
        run(command)

    with ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(make, SCENES))


def streams(options, recordings=None):
    """(kind, name, recording, truth, radius_px) of the worlds and scenes of options.out, and of a folder of recordings."""
    for folder in sorted((options.out / "worlds").glob("*/truth.csv")):
        height = int(next(line.split(":")[1] for line in (folder.parent / "scenario.yaml").open() if "height_px" in line))
        yield "worlds", folder.parent.name, folder.parent, folder, [4, int(0.3 * height)]
    for scene in SCENES:
        folder = options.out / "scenes" / scene[0]
        yield "scenes", scene[0], folder, folder / "truth.csv", [4, 14]
    if recordings:
        for recording in sorted(recordings.glob("stream_*.aedat4")):
            yield "recordings", recording.stem, recording, recording.with_suffix(".truth.csv"), [4, 25]


def numbers(values, digits=4):
    """A list of float literals, in lines."""
    lines, line = [], "   "
    for value in np.ravel(values):
        text = f"{value:.{digits}g}"
        text += ("" if "." in text or "e" in text else ".0") + "F,"
        if len(line) + len(text) > 108:
            lines.append(line)
            line = "   "
        line += " " + text
    return "\n".join([*lines, line]).rstrip(",")
