"""Judges a checkpoint on development worlds as docs/scoring.md does, beside `best` on the same worlds.

    python3 -m training.judge --data DATA --checkpoint FILE [--own] [--pictures FOLDER]
"""
import argparse
import json
from pathlib import Path

import numpy as np
import torch
from torch.nn import functional

from . import surface, worlds
from .network import Network, Shape, load_weights, motion
from .surface import SQUARE, Surface

CHUNK = 8  # steps at once
CIRCLES = 4  # strongest local maxima of each level
RADIUS_BINS = (4, 8, 16, 32, 200)
FIELDS = ("x", "y", "r", "vx", "vy", "log_odds", "inlier_log_odds")  # px, px/ms


@torch.no_grad()
def circles_of(network, world, step_ms, joints=True):
    """Times of the steps, and steps x circles x FIELDS: the strongest circles of all levels, most probable inlier first."""
    cells = surface.levels(world.height)
    block = SQUARE * cells[-1]
    part = Surface(-(-world.width // block) * block, -(-world.height // block) * block)
    index = part.index(world.x, world.y, world.on)
    times = np.arange(step_ms, world.duration_ms + 1e-6, step_ms)
    bounds = np.searchsorted(world.t_ms, times)
    shift_px = world.image_shift_px(times) * joints
    shifts = [torch.from_numpy(surface.whole_squares(shift_px, c))[None] for c in cells]
    motions = [motion(torch.from_numpy(shift_px / (SQUARE * c) * (100 / step_ms)), joints)[None] for c in cells]
    shapes = [(-(-world.height // (SQUARE * c)), -(-world.width // (SQUARE * c))) for c in cells]
    states = [network.start(1, *shape) for shape in shapes]
    found, last = [], 0
    for begin in range(0, len(times), CHUNK):
        inputs = [[] for _ in cells]
        for k in range(begin, min(begin + CHUNK, len(times))):
            part.advance(times[k], world.t_ms[last : bounds[k]], index[last : bounds[k]])
            last = bounds[k]
            for n, (c, (rows, columns)) in enumerate(zip(cells, shapes)):
                inputs[n].append(np.ascontiguousarray(part.cells(c)[:, : rows * SQUARE, : columns * SQUARE]))
        circles = []
        for n, c in enumerate(cells):
            x = torch.from_numpy(np.stack(inputs[n]))[None]
            shift = shifts[n][:, begin : begin + CHUNK]
            out, states[n] = network(x, torch.tensor([step_ms]), states[n], shift, motions[n][:, begin : begin + CHUNK])
            circles.append(decoded(out[0], c))
        found.append(torch.cat(circles, 1))
    found = torch.cat(found).numpy()
    order = np.argsort(-found[:, :, 6], axis=1)
    return times, np.take_along_axis(found, order[:, :, None], 1)


def decoded(out, cell):
    """time x outputs x rows x columns -> time x CIRCLES x FIELDS in pixels of the image."""
    log_odds = out[:, 0].contiguous()
    peak = functional.max_pool2d(log_odds[:, None], 3, 1, 1)[:, 0] == log_odds
    strength = torch.where(peak, log_odds, torch.full_like(log_odds, -20.0)).flatten(1)
    kept = strength.topk(min(CIRCLES, strength.shape[1]))
    at = out.flatten(2).gather(2, kept.indices[:, None].expand(-1, out.shape[1], -1))
    columns = out.shape[3]
    x = ((kept.indices % columns + at[:, 1]) * SQUARE + 2) * cell - 0.5
    y = ((torch.div(kept.indices, columns, rounding_mode="floor") + at[:, 2]) * SQUARE + 2) * cell - 0.5
    r = surface.MEAN_CELLS * 2 ** at[:, 3].clamp(-1, 1) * cell
    speed = at[:, 4:6] * (SQUARE * cell / 100)
    return torch.stack([x, y, r, speed[:, 0], speed[:, 1], kept.values, at[:, 8]], 2)


def every_ms(times, circles, duration_ms):
    """The newest step's circles at every ms from 1 on, moved with their velocity; score -inf before the first step."""
    t = np.arange(1, duration_ms + 1)
    step = np.searchsorted(times, t + 1e-6) - 1
    now = circles[np.maximum(step, 0)].copy()
    age = (t - times[np.maximum(step, 0)])[:, None]
    now[:, :, 0] += now[:, :, 3] * age
    now[:, :, 1] += now[:, :, 4] * age
    now[step < 0, :, 6] = -np.inf
    return now


def inlier(circle, truth, radius_share=0.0):
    """circle: ... x (x, y, r, ...); truth: ... x (x, y, r, visible)."""
    near = np.hypot(circle[..., 0] - truth[..., 0], circle[..., 1] - truth[..., 1]) <= 6.0
    return near & (abs(circle[..., 2] - truth[..., 2]) <= np.maximum(2.0, radius_share * truth[..., 2])) & (truth[..., 3] >= 0.5)


def average_precision(score, good, chances):
    order = np.argsort(-score, kind="stable")
    score, hits = score[order], np.cumsum(good[order])
    last = np.append(score[1:] != score[:-1], True)  # of each distinct score
    hits, counts = hits[last], np.arange(1, len(order) + 1)[last]
    return float((hits / counts * np.diff(hits, prepend=0)).sum() / chances) if chances else None


def figures(circle, score, there, truth):
    """Of one world: circle every ms (x, y, r), its score, whether there is one."""
    chance = truth[:, 3] >= 0.5
    counts = there & (chance | (truth[:, 3] == 0))
    good = inlier(circle, truth) & there
    above = counts & (score >= 0.5)
    result = {"chances": int(chance.sum()), "alarm_share": float(above.mean())}
    if chance.any():
        result |= {
            "average_precision": average_precision(score[counts], good[counts], chance.sum()),
            "loose_radius": average_precision(score[counts], inlier(circle, truth, 0.1)[counts], chance.sum()),
            "recall": float((good & above).sum() / chance.sum()),
            "precision": float((good & above).sum() / above.sum()) if above.any() else None,
            "right": float(good.sum() / chance.sum()),
        }
        for low, high in zip(RADIUS_BINS, RADIUS_BINS[1:]):
            size = chance & (truth[:, 2] >= low) & (truth[:, 2] < high)
            if size.sum() >= 50:
                kept = size | (counts & ~chance)
                result[f"r{low}"] = average_precision(score[kept & counts], (good & size)[kept & counts], size.sum())
    return result


def of_network(network, world, step_ms, joints=True):
    times, circles = circles_of(network, world, step_ms, joints)
    now = every_ms(times, circles, world.duration_ms)
    score = 1 / (1 + np.exp(-now[:, 0, 6]))
    result = figures(now[:, 0], score, np.isfinite(now[:, 0, 6]), world.truth)
    chance = world.truth[:, 3] >= 0.5
    if chance.any():  # the right one among the network's circles, whatever its score
        result["among"] = float(inlier(now, world.truth[:, None]).any(1)[chance].mean())
    return result, now


def of_best(world):
    t = np.round(world.best[:, 0] / 1000).astype(int) - 1
    keep = (t >= 0) & (t < world.duration_ms)
    circle, score, there = np.zeros((world.duration_ms, 3)), np.zeros(world.duration_ms), np.zeros(world.duration_ms, bool)
    circle[t[keep]], score[t[keep]], there[t[keep]] = world.best[keep, 1:4], world.best[keep, 4], True
    return figures(circle, score, there, world.truth)


def mean(values):
    values = [v for v in values if v is not None]
    return f"{np.mean(values):.3f}" if values else "-"


def rows(results, group):
    """A line of means: number of worlds, then network and best by figure."""
    names = ("average_precision", "loose_radius", "recall", "precision", "right", "among")
    line = [group, str(len(results))]
    for name in names:
        line += [mean([r["network"].get(name) for r in results])]
        if name != "among":
            line += [mean([r["best"].get(name) for r in results])]
    return "| " + " | ".join(line) + " |"


def report(results):
    with_ball = [r for r in results if r["ball"]]
    without = [r for r in results if not r["ball"]]
    head = ["worlds", "number"]
    for name in ("AP", "AP, radius 10 %", "recall", "precision", "right circle"):
        head += [name, "`best`"]
    head += ["right among all"]
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head), rows(with_ball, "all")]
    for width in sorted({r["width"] for r in with_ball}):
        lines.append(rows([r for r in with_ball if r["width"] == width], f"{width} px wide"))
    for moves in (False, True):
        lines.append(rows([r for r in with_ball if r["moves"] == moves], "camera " + ("moves" if moves else "at rest")))
    lines += ["", "| radius | worlds | AP | `best` |", "| --- | --- | --- | --- |"]
    for low, high in zip(RADIUS_BINS, RADIUS_BINS[1:]):
        group = [r for r in with_ball if f"r{low}" in r["network"]]
        values = [mean([r[d].get(f"r{low}") for r in group]) for d in ("network", "best")]
        lines.append(f"| {low} to {high} px | {len(group)} | {values[0]} | {values[1]} |")
    for d in ("network", "best"):
        lowest = sorted(r[d]["average_precision"] for r in with_ball)
        tenth = np.mean(lowest[: -(-len(lowest) // 10)]) if lowest else float("nan")
        alarms = mean([r[d]["alarm_share"] for r in without])
        lines.append(f"\n{d}: worst tenth {tenth:.3f}, alarm share {alarms} in {len(without)} worlds without a ball.")
    worst = sorted(with_ball, key=lambda r: r["network"]["average_precision"] - r["best"]["average_precision"])
    lines.append("\nFurthest below `best`: " + ", ".join(
        f"{r['name']} ({r['network']['average_precision']:.2f}, {r['best']['average_precision']:.2f})" for r in worst[:8]))
    return "\n".join(lines)


def pictures(world, now, folder):
    """Events of 20 ms with the true circle (green) and the network's best (red, its score), at eight instants."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(2, 4, figsize=(16, 8))
    for t, axis in zip(np.linspace(200, world.duration_ms - 1, 8).astype(int), axes.flat):
        begin, end = np.searchsorted(world.t_ms, [t - 20, t])
        image = np.full((world.height, world.width, 3), 255, np.uint8)
        on = world.on[begin:end]
        x, y = world.x[begin:end], world.y[begin:end]
        image[y[on], x[on]] = (220, 120, 60)
        image[y[~on], x[~on]] = (60, 120, 220)
        axis.imshow(image)
        tx, ty, r, visible = world.truth[t - 1]
        if visible > 0:
            axis.add_patch(pyplot.Circle((tx, ty), r, fill=False, color="green", lw=2))
        for rank, circle in enumerate(now[t - 1][:3]):
            score = 1 / (1 + np.exp(-circle[6]))
            axis.add_patch(pyplot.Circle(circle[:2], circle[2], fill=False, color="red", lw=2 if rank == 0 else 0.7))
            axis.text(*circle[:2], f"{score:.2f}", color="red", fontsize=8)
        axis.set_title(f"{t} ms, visible {visible:.1f}, r {r:.1f}", fontsize=8)
        axis.set_xticks([]), axis.set_yticks([])
    figure.suptitle(world.name)
    figure.tight_layout()
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / f"{world.name}.png", dpi=60)
    pyplot.close(figure)


def load_network(path):
    """The running means of a checkpoint, or exported weights (.npz)."""
    if path.suffix == ".npz":
        network = Network()
        load_weights(network, dict(np.load(path)))
    else:
        kept = torch.load(path, map_location="cpu")
        network = Network(Shape(**kept["shape"]))
        network.load_state_dict(kept["means"])
    return network.eval()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of the worlds (training.worlds)")
    parser.add_argument("--checkpoint", type=Path, required=True, help=".pt of training.train or .npz of training.export")
    parser.add_argument("--kind", default="development", help="development or train")
    parser.add_argument("--step-ms", type=float, default=8.0, help="between steps of the network (8)")
    parser.add_argument("--no-joints", action="store_true", help="do not move the memory with the camera")
    parser.add_argument("--own", action="store_true", help="with the events that the ball caused alone")
    parser.add_argument("--most", type=int, default=10**6, help="at most so many worlds")
    parser.add_argument("--names", nargs="*", help="these worlds alone")
    parser.add_argument("--pictures", type=Path, help="folder for pictures of every world")
    parser.add_argument("--out", type=Path, help="JSON of the figures of every world")
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    network = load_network(options.checkpoint)
    results = []
    paths = sorted(p.parent for p in options.data.glob(f"{options.kind}_*/world.npz") if not p.parent.name.endswith(".part"))
    for path in [p for p in paths if not options.names or p.name in options.names][: options.most]:
        world = worlds.World(path)
        if options.own and world.own is not None:
            world = world.only_own()
        found, now = of_network(network, world, options.step_ms, not options.no_joints)
        best = of_best(world) if world.best is not None else found
        moves = bool(np.ptp(world.eye, 0).max() > 0.004)
        results.append({"name": world.name, "ball": world.with_ball, "width": world.width, "moves": moves,
                        "network": found, "best": best})
        print(world.name, {k: round(v, 3) for k, v in found.items() if v is not None},
              f"best {best.get('average_precision')}", flush=True)
        if options.pictures:
            pictures(world, now, options.pictures)
    if options.out:
        options.out.write_text(json.dumps(results, indent=1) + "\n")
    print(report(results))
    print(f"\nMultiplications of a step at 128 x 128 on level 1: {network.shape.multiplications(128, 128, [1]) / 1e6:.1f} million.")


if __name__ == "__main__":
    main()
