"""Trains the network of `best` over polar patches (core/tracker/patch_network.h) further, on the patches of training.tracks.

    python3 -m training.patch_network --patches PATCHES --out WEIGHTS.npz
    python3 -m training.patch_network --patches PATCHES --judge [WEIGHTS.npz]
    python3 -m training.patch_network --weights WEIGHTS.npz --into models/best

The network estimates the log odds that a circle is the ball's, a correction of the circle and its standard deviations. It starts
with the weights of models/best. One of HELD_BACK training worlds is held back to be judged; development worlds are only judged.
--into replaces the network of `best`, with golden values for tests; training.tracks and training.track_network follow.
"""
import argparse
import copy
import sys
import time
from pathlib import Path

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from . import best_model
from .tracks import DENSITIES, DIRECTIONS, IGNORED, INLIER, LEAST_VISIBLE, PATCH, RINGS
from .train import keep_memory

HELD_BACK = 9
SHIPPED = best_model.FOLDER / "weights.npz"
COLUMN = {name: i for i, name in enumerate(PATCH)}
CIRCLE = [COLUMN[k] for k in ("x_px", "y_px", "r_px")]
MOTIONS = [(COLUMN[k + "_x"], COLUMN[k + "_y"]) for k in ("disc", "background")]
FIGURES = 6
RINGS_AROUND = (0, 1)  # zeros within the first and outside the last ring; directions go round
LOG_SD = (-3.5, 1.5)  # core/tracker/patch_network.cpp, ring widths
NEAR_RINGS, NEAR_RADIUS_RINGS = 6.0, 4.0  # circles that the correction is learnt from
FREEDOM = 2.0  # of Student's t: the errors of the correction have heavy tails, and the deviations are those of its core
MOST_DENSITY = 2.55  # core/tracker/patch_network.cpp, per px^2
PLACE, SPREAD = 0.1, 0.3  # weight of the correction beside the log odds, of its likelihood in that
OTHER_POLARITIES = [4, 5, 6, 7, 0, 1, 2, 3, 8]
# Layer of Network: its weights and biases in models/best, and these weights' shape there.
LAYERS = {
    "first": ("first", "first_bias", (3, 3, 11, 16)), "deep_1": ("depth_1", None, (3, 3, 16)), "point_1": ("point_1", "point_bias_1", (16, 32)),
    "deep_2": ("depth_2", None, (3, 3, 32)), "point_2": ("point_2", "point_bias_2", (32, 32)), "deep_3": ("depth_3", None, (3, 3, 32)),
    "point_3": ("point_3", "point_bias_3", (32, 32)), "across": ("across", "across_bias", (7, 32, 48)), "deep_4": ("around_depth", None, (3, 48)),
    "point_4": ("around_point", "around_bias", (48, 48)), "offset": ("offset", "offset_bias", (48, 1)), "hidden": ("hidden", "hidden_bias", (102, 32)),
    "output": ("output", "output_bias", (32, 3)),
}
# From that shape to the layer's: outputs first, then inputs, then places.
ORDER = {(3, 3, 11, 16): (3, 2, 0, 1), (7, 32, 48): (2, 1, 0), (3, 3, 16): (2, 0, 1), (3, 3, 32): (2, 0, 1)}


class Around(torch.autograd.Function):
    """One more direction before and after, of batch x channels x directions (x rings). With its own gradient, since that of torch.cat
    fills the whole map with zeros three times."""

    @staticmethod
    def forward(_, x):
        return torch.cat([x[:, :, -1:], x, x[:, :, :1]], 2)

    @staticmethod
    def backward(_, gradient):
        found = gradient[:, :, 1:-1].clone()
        found[:, :, -1] += gradient[:, :, 0]
        found[:, :, 0] += gradient[:, :, -1]
        return found


around = Around.apply


class Network(nn.Module):
    def __init__(self):
        super().__init__()
        self.first = nn.Conv2d(DENSITIES + 2, 16, 3, stride=(1, 2), padding=RINGS_AROUND)
        self.deep_1, self.point_1 = nn.Conv2d(16, 16, 3, padding=RINGS_AROUND, groups=16, bias=False), nn.Conv2d(16, 32, 1)
        self.deep_2, self.point_2 = nn.Conv2d(32, 32, 3, stride=(2, 1), padding=RINGS_AROUND, groups=32, bias=False), nn.Conv2d(32, 32, 1)
        self.deep_3, self.point_3 = nn.Conv2d(32, 32, 3, padding=RINGS_AROUND, groups=32, bias=False), nn.Conv2d(32, 32, 1)
        self.across = nn.Conv2d(32, 48, (1, RINGS // 2))
        self.deep_4, self.point_4 = nn.Conv1d(48, 48, 3, groups=48, bias=False), nn.Conv1d(48, 48, 1)
        self.offset = nn.Conv1d(48, 1, 1)
        self.hidden, self.output = nn.Linear(2 * 48 + FIGURES, 32), nn.Linear(32, 3)
        self.register_buffer("mean", torch.zeros(FIGURES))
        self.register_buffer("scale", torch.ones(FIGURES))
        self.to(memory_format=torch.channels_last)  # twice as fast
        angle = torch.arange(DIRECTIONS // 2) * (4 * np.pi / DIRECTIONS)
        self.harmonics = torch.stack([2 * angle.cos(), 2 * angle.sin(), torch.ones_like(angle)])

    def forward(self, x, figures):
        """Log odds; correction (x, y, r) in ring widths; log of the standard deviations of centre and radius in these."""
        relu = functional.relu
        a = relu(self.first(around(x.contiguous(memory_format=torch.channels_last))))
        a = relu(self.point_1(self.deep_1(around(a))))
        a = relu(self.point_2(self.deep_2(around(a))))
        a = relu(a + self.point_3(self.deep_3(around(a))))
        a = relu(self.across(a))[..., 0]
        a = relu(a + self.point_4(self.deep_4(around(a))))
        correction = (self.offset(a) * self.harmonics).mean(2)
        pooled = torch.cat([a.mean(2), a.amax(2), (figures - self.mean) * self.scale], 1)
        out = self.output(relu(self.hidden(pooled)))
        return out[:, 0], correction, out[:, 1:].clamp(*LOG_SD)

    @torch.no_grad()
    def set(self, arrays):
        for name, (weight, bias, shape) in LAYERS.items():
            layer, values = getattr(self, name), arrays["patch." + weight].reshape(shape)
            order = ORDER.get(shape, (1, 0))
            layer.weight.copy_(torch.from_numpy(values.transpose(order).copy()).reshape(layer.weight.shape))
            if bias:
                layer.bias.copy_(torch.from_numpy(arrays["patch." + bias].reshape(-1)))
        self.mean.copy_(torch.from_numpy(arrays["patch.about_mean"]))
        self.scale.copy_(torch.from_numpy(arrays["patch.about_scale"]))

    def arrays(self):
        """As core/tracker/best_model.h has them."""
        of = {"about_mean": self.mean.numpy(), "about_scale": self.scale.numpy()}
        for name, (weight, bias, shape) in LAYERS.items():
            layer, order = getattr(self, name), ORDER.get(shape, (1, 0))
            values = layer.weight.detach().numpy().reshape([shape[i] for i in order])
            of[weight] = values.transpose(np.argsort(order))
            if bias:
                of[bias] = layer.bias.detach().numpy()
        return {f"patch.{k}": np.ascontiguousarray(v, "<f4") for k, v in of.items()}


class Patches:
    """Of several worlds, one after the other."""

    def __init__(self, paths, every=1):
        parts = [np.load(path) for path in paths]
        for name in ("patch", "densities", "label", "truth"):
            setattr(self, name, torch.from_numpy(np.concatenate([part[name][::every] for part in parts])))

    def __len__(self):
        return len(self.label)

    def batch(self, rows):
        return [getattr(self, name)[rows].clone() for name in ("patch", "densities", "label", "truth")]


def seen_otherwise(random, patch, densities, label, truth):
    """The same patches mirrored, turned, and with the other polarities."""
    values = densities.reshape(-1, DIRECTIONS, RINGS, DENSITIES)
    centre, true = patch[:, CIRCLE[:2]], truth[:, :2]
    off = true - centre
    if random.random() < 0.5:
        values = values[..., OTHER_POLARITIES]
    mirror = -1.0 if random.random() < 0.5 else 1.0
    if mirror < 0:
        values = values[:, [0, *range(DIRECTIONS - 1, 0, -1)]]
    turn = int(random.integers(DIRECTIONS))
    values = torch.roll(values, turn, 1)
    angle = 2 * np.pi * turn / DIRECTIONS
    c, s = np.cos(angle), np.sin(angle)
    turned = torch.tensor([[c, s], [-s * mirror, c * mirror]], dtype=torch.float32)  # of row vectors
    for motion in MOTIONS:
        patch[:, motion] = patch[:, motion] @ turned
    truth[:, :2] = centre + off @ turned
    return patch, values.reshape(len(patch), -1), label, truth


def inputs(patch, densities):
    """batch x channels x directions x rings; figures."""
    values = densities.reshape(-1, DIRECTIONS, RINGS, DENSITIES).permute(0, 3, 1, 2).float() * 0.01
    angle = torch.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS)
    normal = torch.stack([angle.cos(), angle.sin()])
    shares = [(patch[:, motion] @ normal)[:, None, :, None].expand(-1, 1, -1, RINGS) for motion in MOTIONS]
    return torch.cat([values, *shares], 1), patch[:, -FIGURES:]


def losses(network, patch, densities, label, truth):
    """Log odds; of each patch: cross entropy, error of the correction, its likelihood; the errors, ring widths; which of these count."""
    ring_px = 0.25 * patch[:, CIRCLE[2:]] ** 0.75
    log_odds, correction, log_sd = network(*inputs(patch, densities))
    kept = (label != IGNORED).float()
    entropy = functional.binary_cross_entropy_with_logits(log_odds, (label == INLIER).float(), reduction="none") * kept
    target = (truth[:, :3] - patch[:, CIRCLE]) / ring_px
    near = (truth[:, 3] >= LEAST_VISIBLE) & (target[:, :2].norm(dim=1) < NEAR_RINGS) & (target[:, 2].abs() < NEAR_RADIUS_RINGS)
    error = correction - target
    log_sd = log_sd[:, [0, 0, 1]]
    tails = (FREEDOM + 1) / 2 * torch.log1p((error * torch.exp(-log_sd)).square() / FREEDOM)
    near_ = near.float()
    return (log_odds, entropy, functional.smooth_l1_loss(correction, target, reduction="none").sum(1) * near_,
            (tails + log_sd).sum(1) * near_, error, kept, near)


@torch.no_grad()
def judged(network, patches):
    """Log loss, area under the curve; of the correction, ring widths: median errors, log likelihood."""
    log_odds, entropy, _, likelihood, error, kept, near = (
        torch.cat(v) for v in zip(*(losses(network, *patches.batch(slice(i, i + 4096))) for i in range(0, len(patches), 4096))))
    kept = kept > 0
    inlier = (patches.label[kept] == INLIER).numpy()
    rank = np.argsort(np.argsort(log_odds[kept].numpy(), kind="stable"), kind="stable")
    count = max(1, inlier.sum())
    error = error[near].abs()
    return {"patches": len(patches), "log_loss": float(entropy[kept].mean()),
            "area": float((rank[inlier].sum() / count - (count - 1) / 2) / max(1, (~inlier).sum())),
            "centre": float(error[:, :2].norm(dim=1).median()), "radius": float(error[:, 2].median()),
            "likelihood": -float(likelihood[near].mean())}


def line(figures):
    return ", ".join(f"{k} {v:.4g}" for k, v in figures.items())


def train(options, patches, held):
    torch.set_num_threads(options.threads)
    keep_memory()
    torch.manual_seed(options.seed)
    random = np.random.default_rng(options.seed)
    network = load()
    mean = copy.deepcopy(network)  # of the weights
    adam = torch.optim.AdamW(network.parameters(), lr=options.rate, weight_decay=options.decay, betas=(0.9, 0.98))
    begin, sums = time.process_time(), []
    if held:
        print(f"held back at first: {line(judged(network, held))}", flush=True)
    order, at = torch.from_numpy(random.permutation(len(patches))), 0
    for step in range(options.steps):
        if at + options.batch > len(order):
            order, at = torch.from_numpy(random.permutation(len(patches))), 0
        rows, at = order[at : at + options.batch], at + options.batch
        for g in adam.param_groups:
            g["lr"] = options.rate * min(1.0, (step + 1) / 100, 1.5 * max(0.01, 1 - step / options.steps))
        _, entropy, place, likelihood, _, kept, near = losses(network, *seen_otherwise(random, *patches.batch(rows)))
        loss = entropy.sum() / kept.sum().clamp(min=1) + PLACE * (place.sum() + SPREAD * likelihood.sum()) / near.sum().clamp(min=1)
        adam.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        adam.step()
        with torch.no_grad():
            for to, of in zip(mean.parameters(), network.parameters()):
                to.lerp_(of, max(1 / (step + 1), 1 / 300))
        sums.append(float(entropy.sum() / kept.sum().clamp(min=1)))
        if step % options.every == options.every - 1 or step == options.steps - 1:
            text = line(judged(mean, held)) if held else ""
            print(f"step {step + 1}, {time.process_time() - begin:.0f} s of processor: log loss {np.mean(sums):.4f}; held back: {text}", flush=True)
            sums = []
    return mean


def load(path=SHIPPED):
    network = Network()
    network.set(dict(np.load(path)))
    return network


@torch.no_grad()
def put_into(network, folder, options):
    """Replaces the network in models/best, with its outputs for the golden patches."""
    golden = dict(np.load(folder / "golden.npz"))
    values = torch.from_numpy(golden["patch.values"]).clamp(max=MOST_DENSITY).permute(0, 3, 1, 2)
    log_odds, correction, log_sd = network(values, torch.from_numpy(golden["patch.about"]))
    px = torch.cat([correction, log_sd.exp()], 1) * torch.from_numpy(golden["patch.ring_px"])[:, None]
    best_model.replace(folder, "patch", network.arrays(), {"patch.output": torch.cat([log_odds[:, None], px], 1).numpy()}, {
        "recipe": "scripts/fit_patch of commit 07f4bb2, then training.worlds, training.tracks --patches, training.patch_network (docs/training.md)",
        "training_seeds": options.seeds, "steps": options.steps, "duration": options.duration})


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patches", type=Path, help="folder of the patches (training.tracks --patches)")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--judge", type=Path, nargs="?", const=SHIPPED, help="judge these weights, or those of models/best, on "
                        "development worlds")
    parser.add_argument("--weights", type=Path, help="for --into")
    parser.add_argument("--into", type=Path, help="folder of the model of `best`, which gets --weights")
    parser.add_argument("--seeds", help="--into: training seeds, for the manifest")
    parser.add_argument("--duration", help="--into: of the training, for the manifest")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--steps", type=int, default=5000)
    parser.add_argument("--batch", type=int, default=512)
    parser.add_argument("--every", type=int, default=1000, help="steps between judgements of the worlds held back")
    parser.add_argument("--rate", type=float, default=1e-3)
    parser.add_argument("--decay", type=float, default=0.05)
    parser.add_argument("--threads", type=int, default=2)
    return parser


def main():
    options = arguments().parse_args()
    if options.into:
        put_into(load(options.weights), options.into, options)
        return
    if options.judge:
        print(line(judged(load(options.judge), Patches(sorted(options.patches.glob("development_*.npz"))))))
        return
    paths = [p for p in sorted(options.patches.glob("train_*.npz")) if not p.name.endswith(".part.npz")]
    back = [p for p in paths if int(p.stem.split("_")[2]) % HELD_BACK == 0]
    kept = [p for p in paths if p not in back]
    if not kept:
        sys.exit(f"training.patch_network: no train_*.npz in {options.patches}")
    print(f"{len(kept)} worlds; {len(back)} held back")
    network = train(options, Patches(kept), Patches(back, 2) if back else None)
    if options.out:
        np.savez_compressed(options.out, **network.arrays())


if __name__ == "__main__":
    main()
