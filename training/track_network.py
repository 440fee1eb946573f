"""Trains the network of `best` over each followed circle (core/tracker/track_network.h) on the logs of training.tracks.

    python3 -m training.track_network --tracks TRACKS --out WEIGHTS.npz
    python3 -m training.track_network --tracks TRACKS --judge [WEIGHTS.npz]
    python3 -m training.track_network --tracks TRACKS --weights WEIGHTS.npz --into models/best

The network estimates the log odds that a circle is the ball's, and how fast that ceases to be so once the circle's outline makes no
events (rate, 1/s): probability(). One of HELD_BACK training worlds is held back to judge each epoch; development worlds are only
judged, by the network of the log where no weights are given. --into replaces the network of `best`, with golden values for tests.
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
from .tracks import FIELDS, IGNORED, INLIER, INPUTS, STEP

SHOWN = 3  # rows of a step that the loss looks at: the first, the last, one between
MOST_ROWS = 50  # that one step counts for in the loss
HELD_BACK = 9
STAYS_S, AT_REST_SHARE, THRESHOLD = 1.0, 0.6, 0.5  # core/tracker/ball_tracker_constants.h
LEAVES_PER_S = (0.1, 30.0)
MOST_DEVIATIONS = 4.0
CHUNK, LANES = 48, 96
COLUMN = {name: i for i, name in enumerate(FIELDS)}
BEST_WEIGHT = 5.0  # beside 1, for steps of the best circle
GOLDEN_STEPS = 12
AT_INSTANT = 50  # of the inputs: log odds of disc_probability()


class Tracks:
    """The log of one world, circle by circle: rows every 2 ms, and the network's steps, from each of which on its rows are."""

    def __init__(self, path):
        arrays = np.load(path)
        rows, steps = arrays["rows"], arrays["steps"]
        order = np.lexsort((rows[:, COLUMN["t_ms"]], rows[:, COLUMN["number"]]))
        self.name, self.rows, self.label, self.truth = path.stem, rows[order], arrays["label"][order], arrays["truth"]
        steps = steps[np.lexsort((steps[:, 0], steps[:, 1]))]
        self.inputs = np.ascontiguousarray(steps[:, len(STEP):])
        number = steps[:, 1]
        self.first = np.r_[True, number[1:] != number[:-1]] if len(steps) else np.zeros(0, bool)

        def key(t_ms, of):
            return of.astype(np.float64) * 1e7 + t_ms

        self.step_of_row = np.searchsorted(key(steps[:, 0], number), key(self.rows[:, 0], self.rows[:, 1]), "right") - 1
        count, rank = len(steps), self.rank(self.rows[:, COLUMN["probability"]])
        begin, end = (np.searchsorted(self.step_of_row, np.arange(count), side) for side in ("left", "right"))
        has = end > begin
        shown = np.stack([begin, begin + (end - begin) // 2, end - 1], 1) * has[:, None]
        if not len(self.rows):
            shown, has = np.zeros((0, SHOWN), int), np.zeros(0, bool)
            self.inputs, self.first = self.inputs[:0], self.first[:0]
        self.silent_s = self.rows[shown, COLUMN["silent_s"]].astype(np.float32)
        self.share = (self.label[shown] == INLIER).astype(np.float32)
        weight = (np.minimum(end - begin, MOST_ROWS) / SHOWN * has)[: len(has), None]
        # Steps of the circle that was the best one count more: its score is the detector's.
        t = self.rows[:, 0].astype(int)
        most = np.zeros(t.max(initial=0) + 1)
        np.maximum.at(most, t, rank)
        self.weight = (weight * (self.label[shown] != IGNORED) * (1 + BEST_WEIGHT * (rank >= most[t])[shown])).astype(np.float32)

    def sequences(self):
        bounds = [*np.flatnonzero(self.first), len(self.first)]
        return list(zip(bounds[:-1], bounds[1:]))

    def score_of_row(self, probability, leaves_per_s):
        return probability * np.exp(-self.rows[:, COLUMN["silent_s"]] * leaves_per_s)

    def rank(self, probability):
        """Of each row: best() of core/tracker/ball_tracker.cpp takes the largest."""
        moved = self.rows[:, COLUMN["moved_most_share"]]
        return self.score_of_row(probability, 1 / STAYS_S) * (AT_REST_SHARE + (1 - AT_REST_SHARE) * moved)

    def scores(self, probability, leaves_per_s):
        """t, score and label of the best circle of each instant that has one; the arguments for each row."""
        score, rank = self.score_of_row(probability, leaves_per_s), self.rank(probability)
        t = self.rows[:, 0].astype(int)
        order = np.lexsort((rank, t))
        last = np.r_[t[order][1:] != t[order][:-1], True] if len(t) else np.zeros(0, bool)
        best = order[last]
        return t[best], score[best], self.label[best]


class Network(nn.Module):
    def __init__(self, inputs=INPUTS, features=64, memory=32):
        super().__init__()
        self.register_buffer("mean", torch.zeros(inputs))
        self.register_buffer("scale", torch.ones(inputs))
        self.features = nn.Linear(inputs, features)
        self.gates = nn.Linear(features, 3 * memory)
        self.recurrent = nn.Linear(memory, 3 * memory, bias=False)
        self.direct = nn.Linear(inputs, 2)
        self.from_features = nn.Linear(features, 2, bias=False)
        self.from_memory = nn.Linear(memory, 2, bias=False)
        self.memory = memory
        with torch.no_grad():
            self.recurrent.weight.mul_(0.5)
            self.gates.bias[memory : 2 * memory] += 1.0  # keeps most of its memory at first

    def set_scale(self, inputs):
        self.mean.copy_(torch.from_numpy(inputs.mean(0)))
        self.scale.copy_(torch.from_numpy(1 / (inputs.std(0) + 1e-3)))

    def forward(self, x, h, first=None):
        """time x batch x inputs -> time x batch x (log odds, ln of the rate of leaving in 1/s); and the memory after the last step."""
        z = ((x - self.mean) * self.scale).clamp(-MOST_DEVIATIONS, MOST_DEVIATIONS)
        f = functional.softsign(self.features(z))
        g = self.gates(f)
        m, out = self.memory, []
        for t in range(x.shape[0]):
            if first is not None:
                h = h * (1 - first[t])[:, None]
            u = self.recurrent(h)
            rz = 0.5 + 0.5 * functional.softsign(g[t, :, : 2 * m] + u[:, : 2 * m])
            n = functional.softsign(g[t, :, 2 * m :] + rz[:, :m] * u[:, 2 * m :])
            h = n + rz[:, m:] * (h - n)
            out.append(h)
        hs = torch.stack(out)
        return self.direct(z) + self.from_features(f) + self.from_memory(hs), h

    @torch.no_grad()
    def blend(self, share):
        """Log odds become this share of the network's and the rest of the judgement at an instant, which is one of the inputs."""
        rest = 1 - share
        for weight in (self.direct.weight, self.from_features.weight, self.from_memory.weight):
            weight[0] *= share
        self.direct.weight[0, AT_INSTANT] += rest / self.scale[AT_INSTANT]
        self.direct.bias[0] = share * self.direct.bias[0] + rest * self.mean[AT_INSTANT]

    def arrays(self):
        """As core/tracker/best_model.h has them: inputs first, then outputs."""
        of = {"input_mean": self.mean, "input_scale": self.scale, "features": self.features.weight.T, "features_bias": self.features.bias,
              "gates": self.gates.weight.T, "gates_bias": self.gates.bias, "recurrent": self.recurrent.weight.T,
              "output_direct": self.direct.weight.T, "output_features": self.from_features.weight.T,
              "output_memory": self.from_memory.weight.T, "output_bias": self.direct.bias}
        return {f"track.{k}": np.ascontiguousarray(v.detach().numpy(), dtype="<f4") for k, v in of.items()}


def leaves_per_s(out):
    return out[..., 1].clamp(*np.log(LEAVES_PER_S)).exp()


def probability(out, silent_s):
    """That the circle is the ball's, from the network's outputs, silent_s after the last event of its outline."""
    return torch.sigmoid(out[..., 0])[..., None] * torch.exp(-leaves_per_s(out)[..., None] * silent_s)


@torch.no_grad()
def outputs_of(network, world):
    """Of each step."""
    found = np.zeros((len(world.first), 2), np.float32)
    spans = sorted(world.sequences(), key=lambda s: s[0] - s[1])
    for begin in range(0, len(spans), 256):
        part = spans[begin : begin + 256]
        longest = part[0][1] - part[0][0]
        x = torch.zeros(longest, len(part), world.inputs.shape[1])
        for k, (a, b) in enumerate(part):
            x[: b - a, k] = torch.from_numpy(world.inputs[a:b])
        out, _ = network(x, torch.zeros(len(part), network.memory))
        for k, (a, b) in enumerate(part):
            found[a:b] = out[: b - a, k].numpy()
    return found


def figures(world, of_row):
    """As docs/scoring.md, at every second ms. reached: share of the instants with a visible ball at which the best circle is right
    (average precision with perfect probabilities); followed: at which one of the followed circles is (with perfect choice too)."""
    t, score, label = world.scores(*of_row)
    truth = world.truth[1::2]
    chances = int((truth[:, 3] >= 0.5).sum())
    kept = label != IGNORED
    score, inlier = score[kept], label[kept] == INLIER
    above = score >= THRESHOLD
    found = {"above": int(above.sum()), "inliers": int((above & inlier).sum()), "chances": chances, "instants": len(truth),
             "score": score, "inlier": inlier}
    if chances:
        order = np.argsort(-score, kind="stable")
        hits = np.cumsum(inlier[order])
        s = score[order]
        last = np.r_[s[1:] != s[:-1], True] if len(s) else np.zeros(0, bool)
        precision, recall = hits[last] / (np.flatnonzero(last) + 1), hits[last] / chances
        found["ap"] = float((precision * np.diff(recall, prepend=0)).sum())
        found["recall"] = found["inliers"] / chances
        found["reached"] = float(inlier.sum() / chances)
        right = np.unique(world.rows[world.label == INLIER, 0])
        found["followed"] = len(right) / chances
    return found


def summary(results):
    ball = [r for n, r in results if "_ball_" in n and r["chances"]]
    none = [r for n, r in results if "_none_" in n]
    scores, inlier = (np.concatenate([r[k] for _, r in results]) for k in ("score", "inlier"))
    bins = np.minimum((scores * 10).astype(int), 9)
    reliability = [(round(float(scores[bins == b].mean()), 2), round(float(inlier[bins == b].mean()), 2), int((bins == b).sum()))
                   for b in range(10) if (bins == b).any()]
    p = np.clip(scores, 1e-6, 1 - 1e-6)
    return {
        "ap": np.mean([r["ap"] for r in ball]), "recall": np.mean([r["recall"] for r in ball]),
        **{k: np.mean([r[k] for r in ball]) for k in ("reached", "followed")},
        "precision": np.mean([r["inliers"] / r["above"] for r in ball if r["above"]]),
        "pooled_precision": sum(r["inliers"] for r in ball) / max(1, sum(r["above"] for r in ball)),
        "alarms": np.mean([r["above"] / r["instants"] for r in none]) if none else None,
        "alarm_threshold": (th := matched(none)),
        "recall_there": np.mean([(r["inlier"] & (r["score"] >= th)).sum() / r["chances"] for r in ball]),
        "precision_there": sum((r["inlier"] & (r["score"] >= th)).sum() for r in ball) / max(1, sum((r["score"] >= th).sum() for r in ball)),
        "log_loss": float(-(np.where(inlier, np.log(p), np.log1p(-p))).mean()), "reliability": reliability,
    }


def matched(none, alarms=0.02):
    """The least threshold with so many alarms."""
    for th in np.arange(0.05, 1.0, 0.01):
        if not none or np.mean([(r["score"] >= th).sum() / r["instants"] for r in none]) <= alarms:
            return float(th)
    return 1.0


def line(s):
    return ", ".join(f"{k} {v:.3f}" for k, v in s.items() if k != "reliability" and v is not None)


def logged(world):
    return world.rows[:, COLUMN["probability"]], world.rows[:, COLUMN["leaves_per_s"]]


def remembered(network, world):
    out = torch.from_numpy(outputs_of(network, world))
    return torch.sigmoid(out[:, 0]).numpy()[world.step_of_row], leaves_per_s(out).numpy()[world.step_of_row]


def judged(network, tracks):
    return [(w.name, figures(w, logged(w) if network is None else remembered(network, w))) for w in tracks]


ARRAYS = ("inputs", "silent_s", "share", "weight")


class Lanes:
    """All sequences in random order, one after the other in LANES lanes of equal length: time x lanes."""

    def __init__(self, tracks, random, options):
        spans = [(n, a, b) for n, w in enumerate(tracks) for a, b in w.sequences()]
        parts = {k: [] for k in (*ARRAYS, "first")}
        for i in random.permutation(len(spans)):
            n, a, b = spans[i]
            if random.random() < options.cut and b - a > 1:  # a track that began later
                a = int(random.integers(a, b))
            w = tracks[n]
            kept = np.arange(a, b)
            if random.random() < options.skip:
                kept = kept[random.random(len(kept)) < random.uniform(0.4, 1.0)]
            if not len(kept):
                continue
            for k in ARRAYS:
                parts[k].append(getattr(w, k)[kept])
            first = np.zeros(len(kept), np.float32)
            first[0] = 1
            parts["first"].append(first)
        for k, v in parts.items():
            v = np.concatenate(v)
            v = v[: len(v) // (LANES * CHUNK) * LANES * CHUNK]
            setattr(self, k, torch.from_numpy(v.reshape(LANES, -1, *v.shape[1:]).swapaxes(0, 1).copy()))


def train(options, tracks, held):
    torch.set_num_threads(1)
    torch.manual_seed(options.seed)
    random = np.random.default_rng(options.seed)
    network = Network(tracks[0].inputs.shape[1], options.features, options.memory)
    network.set_scale(np.concatenate([w.inputs for w in tracks]))
    mean = copy.deepcopy(network)  # of the weights
    adam = torch.optim.AdamW(network.parameters(), lr=options.rate, weight_decay=options.decay, betas=(0.9, 0.98))
    total = sum(len(w.first) for w in tracks) // (LANES * CHUNK) * options.epochs
    if total == 0:
        sys.exit(f"training.track_network: found {sum(len(w.first) for w in tracks)} steps, expected {LANES * CHUNK} or more")
    done, begin = 0, time.process_time()
    for epoch in range(options.epochs):
        loss_sum, weight_sum = 0.0, 0.0
        lanes = Lanes(tracks, random, options)
        h = torch.zeros(LANES, network.memory)
        for a in range(0, len(lanes.first), CHUNK):
            for g in adam.param_groups:
                g["lr"] = options.rate * min(1.0, (done + 1) / 100, 1.5 * max(0.01, 1 - done / total))
            x, silent, y, w, first = (v[a : a + CHUNK] for v in (*(getattr(lanes, k) for k in ARRAYS), lanes.first))
            x = x + (options.noise * torch.randn(x.shape) + options.offset * torch.randn(1, *x.shape[1:])) / network.scale
            out, h = network(x, h.detach(), first)
            losses = functional.binary_cross_entropy(probability(out, silent).clamp(1e-6, 1 - 1e-6), y, reduction="none")
            loss = (losses * w).sum() / w.sum()
            adam.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(network.parameters(), 1.0)
            adam.step()
            done += 1
            with torch.no_grad():
                for to, of in zip(mean.parameters(), network.parameters()):
                    to.lerp_(of, max(1 / done, 1 / 300))
            loss_sum, weight_sum = loss_sum + float(loss), weight_sum + 1
        if epoch % options.every == options.every - 1 or epoch == options.epochs - 1:
            text = line(summary(judged(mean, held))) if held else ""
            print(f"epoch {epoch + 1}, {time.process_time() - begin:.0f} s of processor: loss {loss_sum / max(weight_sum, 1):.4f}; held back: {text}", flush=True)
    return mean


def load(path, share=1.0):
    arrays = np.load(path)
    network = Network(len(arrays["mean"]), len(arrays["features.bias"]), arrays["recurrent.weight"].shape[1])
    network.load_state_dict({k: torch.from_numpy(arrays[k]) for k in arrays.files})
    network.blend(share)
    return network


@torch.no_grad()
def put_into(network, world, folder, options):
    """Replaces the network in models/best, with the longest track's first steps as golden values."""
    a, b = max(world.sequences(), key=lambda s: s[1] - s[0])
    x = torch.from_numpy(world.inputs[a : min(b, a + GOLDEN_STEPS)])
    out, _ = network(x[:, None], torch.zeros(1, network.memory))
    golden = {"track.inputs": x.numpy(), "track.probability": torch.sigmoid(out[:, 0, 0]).numpy(),
              "track.leaves_per_s": leaves_per_s(out[:, 0]).numpy()}
    best_model.replace(folder, "track", network.arrays(), golden, {
        "input": f"{INPUTS} figures of a circle at each patch (track_inputs(), core/tracker/track_network.h)",
        "output": "log odds of existence; ln of the rate of leaving without events, 1/s",
        "recipe": f"training.worlds, training.tracks, training.track_network --share {options.share:g} (docs/training.md)",
        "training_seeds": options.seeds, "steps": None, "duration": options.duration})


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tracks", type=Path, required=True, help="folder of the logs (training.tracks)")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--weights", type=Path, help="for --into")
    parser.add_argument("--into", type=Path, help="folder of the model of `best`, which gets --weights")
    parser.add_argument("--share", type=float, default=1.0, help="--into, --judge: of the network in the log odds; the rest is the judgement at an instant")
    parser.add_argument("--seeds", help="--into: training seeds, for the manifest")
    parser.add_argument("--duration", help="--into: of the training, for the manifest")
    parser.add_argument("--judge", nargs="?", const="", help="judge these weights, or the score of the log, on development worlds")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--epochs", type=int, default=7)
    parser.add_argument("--every", type=int, default=2, help="epochs between judgements of the worlds held back")
    parser.add_argument("--rate", type=float, default=3e-3)
    parser.add_argument("--decay", type=float, default=0.2)
    parser.add_argument("--noise", type=float, default=0.2, help="of the inputs, standard deviations")
    parser.add_argument("--offset", type=float, default=0.3, help="the same, equal for all steps of a chunk")
    parser.add_argument("--cut", type=float, default=0.3, help="share of tracks that begin later")
    parser.add_argument("--skip", type=float, default=0.3, help="share of tracks that lack some steps")
    parser.add_argument("--features", type=int, default=64)
    parser.add_argument("--memory", type=int, default=32)
    parser.add_argument("--all", action="store_true", help="hold no world back")
    return parser


def main():
    options = arguments().parse_args()
    if options.into:
        worlds = [Tracks(p) for p in sorted(options.tracks.glob("train_ball_*.npz"))[:3]]
        put_into(load(options.weights, options.share), max(worlds, key=lambda w: len(w.first)), options.into, options)
        return
    if options.judge is not None:
        tracks = [Tracks(p) for p in sorted(options.tracks.glob("development_*.npz"))]
        network = load(options.judge, options.share) if options.judge else None
        results = judged(network, tracks)
        for name, r in results:
            print(name, " ".join(f"{r.get(k, float('nan')):.3f}" for k in ("ap", "recall", "reached", "followed")), r["inliers"], r["above"])
        s = summary(results)
        print(line(s), s["reliability"])
        return
    paths = sorted(options.tracks.glob("train_*.npz"))
    paths = [p for p in paths if not p.name.endswith(".part.npz")]
    every = [Tracks(p) for p in paths]
    every = [w for w in every if len(w.first)]
    back = [] if options.all else [w for w in every if int(w.name.split("_")[2]) % HELD_BACK == 0]
    kept = [w for w in every if w not in back]
    if not kept:
        sys.exit(f"training.track_network: no train_*.npz in {options.tracks}")
    print(f"{len(kept)} worlds, {sum(len(w.first) for w in kept)} steps; {len(back)} held back")
    if back:
        print("network of the log, held back:", line(summary(judged(None, back))))
    network = train(options, kept, back)
    if options.out:
        np.savez_compressed(options.out, **{k: v.numpy() for k, v in network.state_dict().items()})


if __name__ == "__main__":
    main()
