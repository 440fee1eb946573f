"""The whole recipe in about two minutes: makes three small worlds and a gaze run, trains, resumes, judges and exports, and checks each step.

    python3 -m training.tiny --saccade build/release/bin/saccade --out FOLDER
"""
import argparse
import shutil
import sys
from pathlib import Path

import numpy as np
import torch

from . import export, judge, patch_network, sequences, surface, track_network, tracks, train, worlds

SEEDS = ((100000, True), (100003, False), (100004, True))  # 64 and 96 px wide
STEPS = 6
LOG_ODDS = 45  # of a patch, among the inputs of the network over tracks


def check(right, text):
    if not right:
        sys.exit(f"training.tiny: {text}")


def trained(folder, checkpoint, steps):
    arguments = ["--sequences", folder, "--checkpoint", checkpoint, "--steps", steps, "--batch", 2, "--start", worlds.ROOT / "models/recurrent/start.npz"]
    return train.train(train.arguments().parse_args(list(map(str, arguments))))


def check_inputs(data):
    """Sequences have the inputs that judging and exporting compute step by step."""
    world, length = worlds.World(data / "train_ball_100004"), 20
    many, random = sequences.Worlds(), np.random.default_rng(1)
    many.add(world)
    part = sequences.draw(many, random, length)
    part.dropped, part.hot_pixels = 0.0, 0
    inputs = sequences.batch_on_level(many, [part], length, torch.Generator())["inputs"][0].numpy()
    size = sequences.CROP * part.cell
    surface_of_part = surface.Surface(size, size, part.left, part.top, part.scale)
    times = part.first_ms + part.dt_ms / part.scale * np.arange(length)
    bounds = [np.searchsorted(world.t_ms, max(int(times[0] - surface.HISTORY_MS / part.scale), 0)), *np.searchsorted(world.t_ms, times)]
    for k in range(length):
        some = slice(bounds[k], bounds[k + 1])
        index = surface_of_part.index(world.x[some], world.y[some], world.on[some])
        surface_of_part.advance(times[k], world.t_ms[some][index >= 0], index[index >= 0])
        error = np.abs(inputs[k] - surface_of_part.cells(part.cell)).max()
        check(error < 1e-3, f"inputs of step {k} differ by {error:.1e}")


def check_seen_otherwise(folder):
    """A mark at the ball's centre is at its centre after mirroring and transposing, and moves with it."""
    all_of = sequences.Sequences(folder, lambda seed: True)
    for rows in range(len(all_of)):
        batch = all_of.batch([rows], 2)
        truth = batch["truth"][0]
        truth[:, :2] = truth[:, :2].round().clamp(0, sequences.CROP - 1)
        truth[1:, 4:] = truth[1:, :2] - truth[:-1, :2]
        instants = range(len(truth))
        batch["inputs"].zero_()
        batch["inputs"][0, instants, 0, truth[:, 1].long(), truth[:, 0].long()] = 1
        sequences.seen_otherwise(batch, np.random.default_rng(rows))
        truth = batch["truth"][0]
        marks = batch["inputs"][0].sum(1)[instants, truth[:, 1].long(), truth[:, 0].long()]
        check(bool((marks == 1).all()), "a mark is not at the centre of the ball seen otherwise")
        check(torch.equal(truth[1:, 4:], truth[1:, :2] - truth[:-1, :2]), "a ball seen otherwise moves another way")


def check_tracks(options, data):
    """The network over tracks."""
    logs = options.out / "tracks"
    logs.mkdir()
    for folder in sorted(data.iterdir()):
        for variant in (0, 1):
            tracks.make(options.log, folder, logs, variant)
    logged = [track_network.Tracks(path) for path in sorted(logs.glob("*.npz"))]
    for world in logged:
        inliers = (world.label == tracks.INLIER).mean()
        right = inliers > 0.02 if "_ball_" in world.name else inliers == 0
        check(right, f"{inliers:.3f} of the tracks of {world.name} are inliers")
    settings = track_network.arguments().parse_args(["--tracks", str(logs), "--epochs", "2", "--cut", "0"])
    network, again = (track_network.train(settings, logged, []) for _ in range(2))
    for name, value in network.state_dict().items():
        check(torch.equal(value, again.state_dict()[name]), f"{name} differs in a second training")
    model, before = options.out / "best", np.load(worlds.ROOT / "models/best/weights.npz")
    shutil.copytree(worlds.ROOT / "models/best", model)
    track_network.put_into(network, logged[0], model, settings)
    expected = dict(before) | network.arrays()
    found = np.load(model / "weights.npz")
    check(sorted(found) == sorted(before), "the model of best has other arrays")
    for name, value in expected.items():
        check(np.array_equal(found[name], value), f"{name} differs in the model of best")


def check_patches(options, data):
    """The network over polar patches."""
    logs, patches = options.out / "tracks_2", options.out / "patches"
    logs.mkdir()
    patches.mkdir()
    for folder in sorted(data.iterdir()):
        tracks.make(options.log, folder, logs, 0, patches)
    logged, shipped = patch_network.Patches(sorted(patches.glob("*.npz"))), patch_network.load()
    check(bool(torch.isfinite(logged.patch).all()), "a patch has values that are not finite")
    # They are those that the program judged: the log odds of each step are those of a patch of the ms before, but for the rounding.
    world = worlds.World(data / "train_ball_100004")
    _, steps, patch, densities = tracks.replay(options.log, world, tracks.stream_of(world), every_patch=1)
    with torch.no_grad():
        log_odds = shipped(*patch_network.inputs(*map(torch.tensor, (patch, densities))))[0].clamp(-8, 8).numpy()
    found = [np.abs(log_odds[patch[:, 0] == step[0] - 1] - step[len(tracks.STEP) + LOG_ODDS]).min(initial=9) < 0.3 for step in steps]
    check(np.mean(found) > 0.95, f"log odds of {np.mean(found):.3f} of the steps are those of a patch")
    settings = patch_network.arguments().parse_args(["--steps", "40", "--batch", "128", "--threads", "1"])
    before = patch_network.judged(shipped, logged)["log_loss"]
    network, again = (patch_network.train(settings, logged, None) for _ in range(2))
    for name, value in network.state_dict().items():
        check(torch.equal(value, again.state_dict()[name]), f"{name} differs in a second training")
    after = patch_network.judged(network, logged)["log_loss"]
    check(after < before, f"the log loss of the patches it was trained on was {before:.4f} before and {after:.4f} after it")
    model = options.out / "best"
    patch_network.put_into(network, model, settings)
    for name, value in patch_network.load(model / "weights.npz").state_dict().items():
        check(torch.equal(value, network.state_dict()[name]), f"{name} differs in the model of best")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--saccade", type=Path, default=worlds.ROOT / "build/release/bin/saccade", help="the program")
    parser.add_argument("--log", type=Path, default=worlds.ROOT / "build/release/bin/track_log", help="the program")
    parser.add_argument("--scenario", type=Path, default=worlds.ROOT / "scenarios/random_world.yaml")
    parser.add_argument("--out", type=Path, required=True, help="folder for worlds, checkpoints and weights; emptied first")
    options = parser.parse_args()
    shutil.rmtree(options.out, ignore_errors=True)
    data = options.out / "worlds"
    data.mkdir(parents=True)
    for seed, ball in SEEDS:
        worlds.make(options.saccade, options.scenario, seed, "train", ball, data)
    scenario, seed, settings = next(worlds.gaze_scenarios())
    folder = data / f"train_ball_{worlds.GAZE_SCENARIOS_FROM}"
    worlds.make_run(options.saccade, scenario, seed, "gaze", True, folder, (*settings, *worlds.FOLLOW, "run.duration_s=1"))

    check_inputs(data)
    folder = options.out / "sequences"
    folder.mkdir()
    sequences.write(sorted(data.iterdir()), np.random.default_rng(1), folder / "100000.npy")
    check_seen_otherwise(folder)
    whole = trained(folder, options.out / "whole.pt", STEPS)
    trained(folder, options.out / "resumed.pt", STEPS // 2)
    resumed = trained(folder, options.out / "resumed.pt", STEPS)
    for name, value in whole.network.state_dict().items():
        check(torch.equal(value, resumed.network.state_dict()[name]), f"{name} differs after resuming")

    found, _ = judge.of_network(judge.load_network(options.out / "whole.pt"), worlds.World(data / "train_ball_100004"), 8.0)
    check(found["among"] > 0.3, f"found the ball of world 100004 in {found['among']:.2f} of the instants, expected more than 0.3")

    export.export(options.out / "whole.pt", data, None, options.out / "model")
    golden = np.load(options.out / "model/golden.npz")
    network = judge.load_network(options.out / "model/weights.npz")
    squares = export.GOLDEN_CELLS // surface.SQUARE
    state, outputs = network.start(1, squares, squares), []
    with torch.no_grad():
        for inputs, shift, motion in zip(golden["inputs"], golden["shift"], golden["motion"]):  # step by step, as the program does; golden.npz has all steps at once
            step = (torch.from_numpy(inputs)[None, None], torch.tensor([float(golden["dt_ms"])]), state)
            out, state = network(*step, torch.from_numpy(shift.astype(np.int64))[None, None], torch.from_numpy(motion)[None, None])
            outputs.append(out[0, 0].numpy())
    error = np.abs(np.stack(outputs) - golden["outputs"]) / np.maximum(1, np.abs(golden["outputs"]))
    check(error.max() <= 1e-5, f"outputs differ by {error.max():.1e} from golden.npz")
    check_tracks(options, data)
    check_patches(options, data)
    print(f"training.tiny: trained {STEPS} steps, right circle among those found in {found['among']:.2f} of the instants")


if __name__ == "__main__":
    main()
