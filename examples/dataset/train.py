"""Trains a small network on a data set, runs it as a detector in the loop, and prints its figures beside those of paper_directed.

    saccade dataset examples/dataset/balls.yaml --out balls
    python3 examples/dataset/train.py balls --minutes 10 --out trained

Needs Debian's python3-torch. Writes weights.pt and run folders into --out. docs/dataset.md explains it.
"""
import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import saccade
import torch

from network import SQUARES, STRIDE, Network, circles
from surfaces import CELLS, CHANNELS, Surface

HERE = Path(__file__).resolve().parent
WINDOW_US = 10_000
BATCH = 48
INLIER_PX, INLIER_RADIUS_PX = 6, 2  # docs/scoring.md


def samples(data):
    """Surfaces at the ends of all windows, and the circles there in cells: x, y, r and the visible share (0 without a ball)."""
    images = np.empty((len(data), CHANNELS, CELLS, CELLS), np.uint8)
    truth = np.zeros((len(data), 4), np.float32)
    run = None
    for i, window in enumerate(data):
        if window["run"] != run:
            run, surface = window["run"], Surface(data.size)
        surface.add(window["events"])
        images[i] = surface.image(window["end_us"])
        t = window["truth"]
        if t["visible"] > 0:
            truth[i] = [(t["x_px"] + 0.5) / surface.scale, (t["y_px"] + 0.5) / surface.scale, t["r_px"] / surface.scale, t["visible"]]
    return torch.from_numpy(images), torch.from_numpy(truth), surface.scale


def changed(images, truth, random):
    """Mirrored, transposed, and with the polarities exchanged, by chance."""
    truth = truth.clone()
    if random.random() < 0.5:
        images = images.flip(3)
        truth[:, 0] = CELLS - truth[:, 0]
    if random.random() < 0.5:
        images = images.transpose(2, 3)
        truth[:, :2] = truth[:, [1, 0]]
    if random.random() < 0.5:
        images = images.flip(1).reshape(len(images), 2, 2, CELLS, CELLS).flip(1).flatten(1, 2)
    return images, truth


def loss_of(output, truth):
    """Of the log odds in all squares, and of place and radius in the square with the centre."""
    x, y, r, visible = truth.unbind(1)
    column, row = (x / STRIDE).long(), (y / STRIDE).long()
    inside = (visible > 0) & (column >= 0) & (column < SQUARES) & (row >= 0) & (row < SQUARES)
    there = torch.nonzero(inside & (visible >= 0.5))[:, 0]
    column, row = column.clamp(0, SQUARES - 1), row.clamp(0, SQUARES - 1)
    target, weight = torch.zeros_like(output[:, 0]), torch.ones_like(output[:, 0])
    target[there, row[there], column[there]] = 1
    weight[inside & (visible < 0.5)] = 0  # hidden by half: neither right nor wrong
    odds = torch.nn.functional.binary_cross_entropy_with_logits(output[:, 0], target, weight, reduction="none")
    odds = ((1 - torch.exp(-odds)) ** 2 * odds).sum((1, 2)).mean()  # focal: easy squares count little
    if len(there) == 0:
        return odds
    at = output[there, :, row[there], column[there]]
    place = torch.stack([x[there] / STRIDE - column[there], y[there] / STRIDE - row[there]], 1)
    error = torch.nn.functional.smooth_l1_loss(at[:, 1:3], place, beta=0.1) * 2
    return odds + error + torch.nn.functional.smooth_l1_loss(at[:, 3], r[there].log(), beta=0.1)


def train(images, truth, minutes, seed=1):
    torch.manual_seed(seed)
    network, random = Network(), np.random.default_rng(seed)
    optimiser = torch.optim.Adam(network.parameters(), lr=2e-3)
    begin, steps, mean = time.process_time(), 0, None
    while (done := (time.process_time() - begin) / (60 * minutes)) < 1:
        for group in optimiser.param_groups:
            group["lr"] = 2e-3 * (0.02 + 0.98 * (1 - done))
        chosen = torch.from_numpy(random.integers(len(images), size=BATCH))
        batch, circle = changed(images[chosen], truth[chosen], random)
        loss = loss_of(network(batch), circle)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        mean = loss.item() if mean is None else 0.98 * mean + 0.02 * loss.item()
        steps += 1
        if steps % 200 == 0:
            print(f"{minutes * done:5.1f} min, step {steps}: loss {mean:.3f}", flush=True)
    return network.eval(), steps


def judge(network, images, truth, scale):
    """Scores of the best circles, whether they are inliers, and the number of instants with a ball."""
    with torch.no_grad():
        found = torch.cat([circles(network(part)) for part in images.split(256)])
    near = (found[:, :2] - truth[:, :2]).norm(dim=1) * scale <= INLIER_PX
    right = near & ((found[:, 2] - truth[:, 2]).abs() * scale <= INLIER_RADIUS_PX) & (truth[:, 3] >= 0.5)
    return found[:, 3].numpy(), right.numpy(), int((truth[:, 3] >= 0.5).sum())


def threshold_of(scores, right, chances):
    """The threshold with the largest F measure."""
    order = np.argsort(-scores)
    inliers = np.cumsum(right[order])
    f = 2 * inliers / (np.arange(1, len(order) + 1) + max(chances, 1))
    return float(scores[order[f.argmax()]]), float(f.max())


def in_the_loop(program, out, scenario, detector, seed, settings):
    """Average precision of the detector that drives the gaze, and the share of time with the gaze within 2 deg of the ball."""
    folder = out / f"{scenario}_{detector}_{seed}"
    words = [program, "run", scenario, "--seed", seed, "--force", "--out", folder]
    for setting in (f"gaze.detector={detector}", "frame_30hz=null", "expect={}", "output.pictures=4", *settings):
        words += ["--set", setting]
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr)
    metrics = json.loads((folder / "metrics.json").read_text())
    return metrics["detectors"][detector]["average_precision"] or 0, metrics["gaze"]["on_target_ratio"] or 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path, help="folder of the data set")
    parser.add_argument("--minutes", type=float, default=10, help="of training, on one core (10)")
    parser.add_argument("--out", type=Path, default=Path("trained"))
    parser.add_argument("--saccade", default="saccade", help="the program")
    parser.add_argument("--scenario", default="gaze_square_45cm", help="of the loop")
    parser.add_argument("--seeds", type=int, default=3, help="of the loop (3)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="for the scenario of the loop")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)

    begin = time.monotonic()
    images, truth, scale = samples(saccade.Dataset(options.data, split="train", duration_us=WINDOW_US))
    print(f"{len(images)} windows in {time.monotonic() - begin:.0f} s, {int((truth[:, 3] >= 0.5).sum())} with a ball", flush=True)
    network, steps = train(images, truth, options.minutes)
    some = torch.randperm(len(images))[:4000]
    _, right, chances = judge(network, images[some], truth[some], scale)
    print(f"{steps} steps; right at {right.sum() / max(chances, 1):.2f} of the training instants with a ball", flush=True)
    scores, right, chances = judge(network, *samples(saccade.Dataset(options.data, split="validation", duration_us=WINDOW_US)))
    threshold, f = threshold_of(scores, right, chances)
    print(f"validation: right at {right.sum() / max(chances, 1):.2f} of the instants with a ball; threshold {threshold:.3f}, F {f:.2f}")
    torch.save({"weights": network.state_dict(), "threshold": threshold}, options.out / "weights.pt")

    trained = {"python": f"{HERE / 'detector.py'}:Trained", "arguments": f"weights={(options.out / 'weights.pt').resolve()}",
               "interpreter": sys.executable, "start_limit_s": 120, "answer_limit_s": 10}
    (options.out / "detectors.yaml").write_text(json.dumps({"detectors": {"trained": trained}}) + "\n")  # for saccade detect --config
    block = json.dumps({"trained": trained, "paper_directed": {}})
    print(f"\n{options.scenario}, {options.seeds} seeds     average precision   gaze within 2 deg, share of time")
    for detector in ("trained", "paper_directed"):
        rows = [in_the_loop(options.saccade, options.out, options.scenario, detector, seed, [f"detectors={block}", *options.set])
                for seed in range(1, options.seeds + 1)]
        precision, on_target = np.mean(rows, axis=0)
        print(f"{detector:32}{precision:.3f}               {on_target:.3f}", flush=True)


if __name__ == "__main__":
    main()
