"""Trains the recurrent network (docs/training.md).

    python3 -m training.train --sequences SEQUENCES --checkpoint FILE --steps 4000

The checkpoint has weights, their running means, the optimiser, the number of steps and the recipe. If it is there, training
goes on from it. --steps is the total, so the same command continues after an interruption; the rate falls over the last of them.
One of HELD_BACK worlds is held back to be judged.
"""
import argparse
import ctypes
import os
import time
from pathlib import Path

import numpy as np
import torch
from torch.nn import functional

from . import sequences, surface
from .network import Network, Shape, load_weights

INLIER_CENTRE_PX, INLIER_RADIUS_PX = 6.0, 2.0
MEAN_OF_STEPS = 0.2  # time constant of the running means of the weights, as a share of the steps so far
COOLING = 0.3  # share of the steps at the end in which the rate falls linearly to a hundredth
BEST = 3  # circles per instant that the inlier's log odds are trained on
REPORT_STEPS, JUDGE_STEPS = 100, 500
HELD_BACK = 9


def inlier_loss(out, truth, cell):
    """Cross entropy of the last output at the strongest local maxima of each instant; the circles are those found."""
    out, truth = out.flatten(0, 1), truth.flatten(0, 1)
    cell = cell.repeat_interleave(len(out) // len(cell))
    log_odds = out[:, 0].contiguous()
    peak = functional.max_pool2d(log_odds[:, None], 3, 1, 1)[:, 0] == log_odds
    strength = torch.where(peak, log_odds, torch.full_like(log_odds, -20.0)).flatten(1)
    place = strength.topk(BEST).indices
    at = out.flatten(2).gather(2, place[:, None].expand(-1, out.shape[1], -1))
    columns = out.shape[3]
    x = (place % columns + at[:, 1]) * surface.SQUARE + 1.5
    y = (torch.div(place, columns, rounding_mode="floor") + at[:, 2]) * surface.SQUARE + 1.5
    r = surface.MEAN_CELLS * 2 ** at[:, 3].clamp(-1, 1)
    off = torch.hypot(x - truth[:, 0, None], y - truth[:, 1, None]) * cell[:, None]
    good = (off <= INLIER_CENTRE_PX) & ((r - truth[:, 2, None]).abs() * cell[:, None] <= INLIER_RADIUS_PX)
    good &= truth[:, 3, None] >= 0.5
    counts = ((truth[:, 3] == 0) | (truth[:, 3] >= 0.5)).float()[:, None]
    loss = functional.binary_cross_entropy_with_logits(at[:, 8], good.float(), reduction="none")
    return (loss * counts).sum() / len(out)


def loss_of(out, batch):
    truth = batch["truth"]
    positive, weight, shape = sequences.targets(truth, batch["shown"])
    frames = truth.shape[0] * truth.shape[1]
    log_odds = out[:, :, 0]
    missed = (positive - torch.sigmoid(log_odds)).abs().detach()
    found = functional.binary_cross_entropy_with_logits(log_odds, positive, reduction="none")
    error = out[:, :, 1:4] - shape[:, :, :3]
    where = functional.smooth_l1_loss(out[:, :, 1:4], shape[:, :, :3], reduction="none", beta=0.1)
    where = where[:, :, 0] + where[:, :, 1] + 3 * where[:, :, 2]
    speed = functional.smooth_l1_loss(out[:, :, 4:6], shape[:, :, 3:].clamp(-12, 12), reduction="none", beta=0.5).sum(2)
    error = error.detach() ** 2
    sd = out[:, :, 6:8].clamp(-5, 2)
    spread = 0.5 * (error[:, :, 0] + error[:, :, 1]) * torch.exp(-2 * sd[:, :, 0]) + 2 * sd[:, :, 0]
    spread = spread + 0.5 * error[:, :, 2] * torch.exp(-2 * sd[:, :, 1]) + sd[:, :, 1]
    parts = {
        "found": (missed * found * weight).sum() / frames,
        "where": 2 * (where * positive).sum() / frames,
        "speed": 0.2 * (speed * positive).sum() / frames,
        "spread": 0.05 * (spread * positive).sum() / frames,
        "inlier": inlier_loss(out, truth, batch["cell"]),
    }
    return sum(parts.values()), {k: v.detach() for k, v in parts.items()}


def keep_memory():
    """Large arrays are reused instead of being given back to the system each time (M_MMAP_MAX 0, M_TRIM_THRESHOLD)."""
    libc = ctypes.CDLL(None)
    libc.mallopt(-4, 0)
    libc.mallopt(-1, 2**31 - 1)


def on(device, batch):
    return {k: v.to(device) for k, v in batch.items()}


def outputs(network, batch):
    """From an empty memory on."""
    squares = sequences.CROP // surface.SQUARE
    start = network.start(len(batch["dt_ms"]), squares, squares)
    return network(batch["inputs"], batch["dt_ms"], start, batch["shift"], batch["motion"])[0]


class Training:
    """Network, running means of its weights, optimiser, steps made."""

    def __init__(self, options):
        torch.manual_seed(options.seed)
        self.shape = Shape(options.channels, tuple(options.dilations), tuple(options.recurrent))
        self.network = Network(self.shape)
        if options.start:
            load_weights(self.network, dict(np.load(options.start)))
        self.network.to(options.device)
        self.adam = torch.optim.Adam(self.network.parameters(), lr=options.rate, betas=(0.9, 0.98))
        self.means = {k: v.clone() for k, v in self.network.state_dict().items()}
        self.step, self.seconds, self.seeds = 0, 0.0, []
        if options.checkpoint.exists():
            kept = torch.load(options.checkpoint, map_location=options.device)
            if Shape(**kept["shape"]) != self.shape:
                raise SystemExit(f"training.train: {options.checkpoint} is of another shape: {kept['shape']}")
            self.network.load_state_dict(kept["network"])
            self.adam.load_state_dict(kept["adam"])
            self.means, self.step, self.seconds, self.seeds = kept["means"], kept["step"], kept["seconds"], kept["seeds"]

    def save(self, options):
        part = options.checkpoint.with_suffix(".part")
        recipe = {k: str(v) for k, v in vars(options).items()}
        torch.save(
            {"network": self.network.state_dict(), "adam": self.adam.state_dict(), "means": self.means, "step": self.step,
             "seconds": self.seconds, "seeds": self.seeds, "shape": vars(self.shape), "recipe": recipe}, part)
        os.replace(part, options.checkpoint)

    def advance(self, batch, rate):
        for group in self.adam.param_groups:
            group["lr"] = rate * min(1.0, (self.step + 1) / 200)
        loss, parts = loss_of(outputs(self.network, batch), batch)
        self.adam.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), 5.0)
        self.adam.step()
        self.step += 1
        keep = 1 - 1 / (1 + MEAN_OF_STEPS * self.step)
        with torch.no_grad():
            for name, value in self.network.state_dict().items():
                self.means[name].mul_(keep).add_(value, alpha=1 - keep)
        return parts

    @torch.no_grad()
    def judged(self, held, batch, device):
        """Losses of the running means."""
        network, sums = Network(self.shape).to(device), {}
        network.load_state_dict(self.means)
        for first in range(0, len(held), batch):
            some = on(device, held.batch(range(first, min(first + batch, len(held)))))
            for name, value in loss_of(outputs(network, some), some)[1].items():
                sums[name] = sums.get(name, 0.0) + float(value) * len(some["dt_ms"]) / len(held)
        return sums


def line(losses):
    return ", ".join(f"{k} {v:.3f}" for k, v in losses.items()) + f"; sum {sum(losses.values()):.3f}"


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sequences", type=Path, required=True, help="folder of training.sequences")
    parser.add_argument("--checkpoint", type=Path, required=True)
    parser.add_argument("--steps", type=int, required=True, help="in total")
    parser.add_argument("--batch", type=int, default=8, help="sequences in a step, more where these have fewer instants (8)")
    parser.add_argument("--rate", type=float, default=2e-3, help="of Adam (2e-3)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--start", type=Path, help="first weights: models/recurrent/start.npz or exported ones (random)")
    parser.add_argument("--channels", type=int, default=Shape.channels)
    parser.add_argument("--dilations", type=int, nargs="+", default=Shape.dilations, help="of the blocks")
    parser.add_argument("--recurrent", type=int, nargs="+", default=Shape.recurrent, help="blocks with memory")
    parser.add_argument("--device", default="cpu", help="cpu or cuda (cpu)")
    parser.add_argument("--threads", type=int, default=1)
    return parser


def train(options):
    torch.set_num_threads(options.threads)
    torch.set_flush_denormal(True)  # memories decay
    keep_memory()
    training = Training(options)
    kept = sequences.Sequences(options.sequences, lambda seed: seed % HELD_BACK != 0)
    held = sequences.Sequences(options.sequences, lambda seed: seed % HELD_BACK == 0)
    if not len(kept):
        raise SystemExit(f"training.train: found no sequences in {options.sequences}")
    training.seeds = sorted(set(kept.arrays["world"].tolist()))
    print(f"{len(kept)} sequences of {len(training.seeds)} worlds; {len(held)} held back", flush=True)
    begin, before = time.monotonic(), training.seconds
    sums, count = {}, 0
    while training.step < options.steps:
        random = np.random.default_rng([options.seed, training.step])  # the same draws after an interruption
        every = sequences.EVERY[training.step % len(sequences.EVERY)]
        rows = random.integers(len(kept), size=options.batch * every)
        batch = on(options.device, sequences.seen_otherwise(kept.batch(rows, every), random))
        rate = options.rate * min(1.0, max(0.01, (1 - training.step / options.steps) / COOLING))
        for k, v in training.advance(batch, rate).items():
            sums[k] = sums.get(k, 0.0) + float(v)
        count += 1
        if training.step % REPORT_STEPS == 0:
            training.seconds = before + time.monotonic() - begin
            print(f"step {training.step}, {training.seconds:.0f} s: {line({k: v / count for k, v in sums.items()})}", flush=True)
            sums, count = {}, 0
            training.save(options)
            if len(held) and training.step % JUDGE_STEPS == 0:
                print(f"held back: {line(training.judged(held, options.batch, options.device))}", flush=True)
    training.seconds = before + time.monotonic() - begin
    training.save(options)
    return training


if __name__ == "__main__":
    train(arguments().parse_args())
