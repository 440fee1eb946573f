"""Trains the recurrent network (docs/training.md).

    python3 -m training.train --data DATA --checkpoint FILE --steps 2000

The checkpoint has weights, their running means, the optimiser, the number of steps and the recipe. If it is there, training
goes on from it. --steps is the total, so the same command continues after an interruption; the rate falls over the last of them.
"""
import argparse
import ctypes
import os
import time
from pathlib import Path

import numpy as np
import torch
from torch.nn import functional

from . import network as network_module
from . import sequences, surface, worlds
from .network import Network

ROOT = Path(__file__).resolve().parent.parent
START = ROOT / "models/recurrent/start.npz"
INLIER_CENTRE_PX, INLIER_RADIUS_PX = 6.0, 2.0
MEAN_OF_STEPS = 0.2  # time constant of the running means of the weights, as a share of the steps so far
COOLING = 0.3  # share of the steps at the end in which the rate falls linearly to a twentieth
NEW = ("memory", "motion", "output")  # parameters that start.npz does not have, or not all of
BEST = 3  # circles per instant that the inlier's log odds are trained on


def inlier_loss(out, truth, cell):
    """Cross entropy of the last output at the strongest local maxima of each instant; the circles are those found."""
    out, truth = out.flatten(0, 1), truth.flatten(0, 1)
    cell = cell.repeat_interleave(len(out) // len(cell))
    log_odds = out[:, 0]
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
    truth, shown = batch["truth"], batch["shown"]
    positive, weight, shape = map(torch.from_numpy, sequences.targets(truth, shown))
    frames = truth.shape[0] * truth.shape[1]
    log_odds = out[:, :, 0]
    missed = (positive - torch.sigmoid(log_odds)).abs().detach()
    found = functional.binary_cross_entropy_with_logits(log_odds, positive, reduction="none")
    error = out[:, :, 1:4] - shape[:, :, :3]
    where = functional.smooth_l1_loss(out[:, :, 1:4], shape[:, :, :3], reduction="none", beta=0.1)
    where = (where * torch.tensor([1.0, 1.0, 3.0])[:, None, None]).sum(2)
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
        "inlier": inlier_loss(out, torch.from_numpy(truth), torch.from_numpy(batch["cell"])),
    }
    return sum(parts.values()), {k: float(v) for k, v in parts.items()}


def keep_memory():
    """Large arrays are reused instead of being given back to the system each time (M_MMAP_MAX 0, M_TRIM_THRESHOLD)."""
    libc = ctypes.CDLL(None)
    libc.mallopt(-4, 0)
    libc.mallopt(-1, 2**31 - 1)


def drawn(data, random, batch, length):
    parts = [sequences.draw(data, random, length) for _ in range(batch)]
    return {k: np.stack([p[k] for p in parts]) for k in parts[0]}


class Training:
    """Network, running means of its weights, optimiser, steps made."""

    def __init__(self, options):
        torch.manual_seed(options.seed)
        self.network = Network().to(memory_format=torch.channels_last)
        if not options.from_nothing:
            network_module.load_weights(self.network, dict(np.load(options.start)))
        if options.keep_first:
            for layer in (self.network.first, self.network.second_depth, self.network.second_point):
                layer.requires_grad_(False)
        fresh = [p for n, p in self.network.named_parameters() if n.startswith(NEW)]
        known = [p for n, p in self.network.named_parameters() if not n.startswith(NEW)]
        known_rate = 1.0 if options.from_nothing else 0.5
        self.adam = torch.optim.Adam([{"params": fresh, "share": 1.0}, {"params": known, "share": known_rate}], lr=options.rate)
        self.means = {k: v.clone() for k, v in self.network.state_dict().items()}
        self.step, self.seconds, self.seeds = 0, 0.0, []
        if options.checkpoint.exists():
            kept = torch.load(options.checkpoint)
            self.network.load_state_dict(kept["network"])
            self.adam.load_state_dict(kept["adam"])
            self.means, self.step, self.seconds, self.seeds = kept["means"], kept["step"], kept["seconds"], kept["seeds"]

    def save(self, options):
        part = options.checkpoint.with_suffix(".part")
        recipe = {k: str(v) for k, v in vars(options).items()}
        torch.save(
            {"network": self.network.state_dict(), "adam": self.adam.state_dict(), "means": self.means, "step": self.step,
             "seconds": self.seconds, "seeds": self.seeds, "recipe": recipe}, part)
        os.replace(part, options.checkpoint)

    def advance(self, batch, length, rate):
        for group in self.adam.param_groups:
            group["lr"] = rate * group["share"] * min(1.0, (self.step + 1) / 50)
        squares = sequences.CROP // surface.SQUARE
        state = self.network.start(len(batch["dt_ms"]), squares, squares)
        inputs, dt_ms, shift, motion = (torch.from_numpy(batch[k]) for k in ("inputs", "dt_ms", "shift", "motion"))
        history = inputs.shape[1] - length
        if history:  # the memory of earlier instants, without gradients
            with torch.no_grad():
                _, state = self.network(inputs[:, :history], dt_ms, state, shift[:, :history], motion[:, :history])
        out, _ = self.network(inputs[:, history:], dt_ms, state, shift[:, history:], motion[:, history:])
        loss, parts = loss_of(out, {k: batch[k][:, history:] if k in ("truth", "shown") else batch[k] for k in batch})
        self.adam.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), 5.0)
        self.adam.step()
        self.step += 1
        keep = 1 - 1 / (1 + MEAN_OF_STEPS * self.step)
        for name, value in self.network.state_dict().items():
            self.means[name].mul_(keep).add_(value, alpha=1 - keep)
        return parts


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of the worlds (training.worlds)")
    parser.add_argument("--checkpoint", type=Path, required=True)
    parser.add_argument("--steps", type=int, required=True, help="in total")
    parser.add_argument("--batch", type=int, default=6, help="sequences in a step (6)")
    parser.add_argument("--length", type=int, default=40, help="instants in a sequence (40)")
    parser.add_argument("--history", type=int, default=40, help="instants before every other sequence, without gradients (40)")
    parser.add_argument("--rate", type=float, default=2e-3, help="of Adam (2e-3)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep-first", action="store_true", help="leave the layers before the blocks as they are: a fifth faster")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--start", type=Path, default=START, help="first weights: start.npz or exported ones (start.npz)")
    parser.add_argument("--from-nothing", action="store_true", help="random weights at first")
    return parser


def train(options):
    torch.set_num_threads(options.threads)
    keep_memory()
    training = Training(options)
    data, names = [], set()
    sums, count = {}, 0
    while training.step < options.steps:
        if training.step % 50 == 0 or not data:  # worlds may have been added
            for folder in sorted(p.parent for p in options.data.glob("train_*/world.npz")):
                if folder.name not in names and not folder.name.endswith(".part"):
                    names.add(folder.name)
                    data.append(worlds.World(folder))
            training.seeds = sorted(names)
        begin = time.process_time()
        random = np.random.default_rng([options.seed, training.step])  # the same draws after an interruption
        history = options.history * int(random.integers(2))
        rate = options.rate * min(1.0, max(0.05, (1 - training.step / options.steps) / COOLING))
        parts = training.advance(drawn(data, random, options.batch, history + options.length), options.length, rate)
        training.seconds += time.process_time() - begin
        for k, v in parts.items():
            sums[k] = sums.get(k, 0.0) + v
        count += 1
        if training.step % 20 == 0 or training.step == options.steps:
            text = ", ".join(f"{k} {v / count:.3f}" for k, v in sums.items())
            print(f"step {training.step}, {len(data)} worlds, {training.seconds:.0f} s of processor: {text}", flush=True)
            sums, count = {}, 0
            training.save(options)
    return training


if __name__ == "__main__":
    train(arguments().parse_args())
