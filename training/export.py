"""Writes a checkpoint's weights as weights.npz, with manifest.json and golden.npz, into a folder (models/recurrent).

    python3 -m training.export --data DATA --checkpoint FILE --figures JUDGED.json --out models/recurrent

golden.npz: inputs (time x channels x rows x columns of cells), dt_ms, shift (time x 2: x and y, squares by which the memory moves
before the step), motion (time x 3), outputs (time x outputs x rows x columns of squares) and the memory after the last step (memory_0, memory_1: channels x rows x columns), from PyTorch, of the first training world.
"""
import argparse
import hashlib
import json
from pathlib import Path

import numpy as np
import torch

from . import network as network_module
from . import sequences, surface, worlds
from .judge import load_network
from .surface import Surface

GOLDEN_STEPS, GOLDEN_CELLS, GOLDEN_STEP_MS = 12, 32, 5.0


@torch.no_grad()
def golden(network, world):
    part = Surface(GOLDEN_CELLS, GOLDEN_CELLS, (world.width - GOLDEN_CELLS) // 2, (world.height - GOLDEN_CELLS) // 2)
    index = part.index(world.x, world.y, world.on)
    t, index = world.t_ms[index >= 0], index[index >= 0]
    inputs, last = [], 0
    for k in range(GOLDEN_STEPS):
        now = 500.0 + k * GOLDEN_STEP_MS
        end = np.searchsorted(t, now)
        part.advance(now, t[last:end], index[last:end])
        inputs.append(part.cells(1).copy())
        last = end
    inputs = np.stack(inputs)
    squares = GOLDEN_CELLS // surface.SQUARE
    shift = np.zeros((GOLDEN_STEPS, 2), np.int64)
    shift[3], shift[7], shift[9] = (1, 0), (-1, 2), (0, -1)
    motion = network_module.motion(torch.from_numpy(shift * (100 / GOLDEN_STEP_MS)), True)
    motion[GOLDEN_STEPS // 2 :] = 0  # unknown
    start = network.start(1, squares, squares)
    out, state = network(
        torch.from_numpy(inputs)[None], torch.tensor([GOLDEN_STEP_MS]), start, torch.from_numpy(shift)[None], motion[None])
    memory = {f"memory_{n}": s[0].permute(2, 0, 1).numpy() for n, s in enumerate(state)}
    return {"inputs": inputs, "dt_ms": np.float32(GOLDEN_STEP_MS), "shift": shift.astype(np.float32), "motion": motion.numpy(), "outputs": out[0].numpy(), **memory}


def ranges(numbers):
    """"1 to 3, 7"."""
    numbers, text = np.array(sorted(numbers)), []
    for part in np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1):
        text.append(f"{part[0]} to {part[-1]}" if len(part) > 1 else str(part[0]))
    return ", ".join(text)


def mean(values):
    values = [v for v in values if v is not None]
    return round(float(np.mean(values)), 3) if values else None


def summary(results):
    """Means of judged development worlds."""
    ball, none = [r for r in results if r["ball"]], [r for r in results if not r["ball"]]
    found = {"worlds": len(ball), "worlds_without_ball": len(none)}
    for d in ("network", "best"):
        found[d] = {k: mean([r[d].get(k) for r in ball]) for k in ("average_precision", "loose_radius", "recall", "precision")}
        found[d]["alarm_share"] = mean([r[d]["alarm_share"] for r in none])
    return found


def export(checkpoint, data, figures, out):
    kept = torch.load(checkpoint, map_location="cpu")
    network = load_network(checkpoint)
    out.mkdir(parents=True, exist_ok=True)
    weights = out / "weights.npz"
    np.savez_compressed(weights, **{k: v.numpy() for k, v in network.state_dict().items()})
    first = min(path.parent for path in data.glob("train_ball_*/world.npz"))
    np.savez_compressed(out / "golden.npz", **golden(network, worlds.World(first)))
    manifest = {
        "purpose": "finds the ball in events; recurrent over the image; the same weights on cells of 1, 2, 4 and 8 px",
        "inputs": {
            "channels": [f"{p}, tau {tau:g} ms" for p in ("ON", "OFF") for tau in surface.TAU_MS],
            "unit": "sum over the pixels of a cell of exp(-age of the newest event / tau), times (cell size in px)^-1.5",
            "memory": "moved by whole squares of 4 x 4 cells with the middle of the image, by the camera's rotation",
            "motion": "v = speed of the image's middle by the camera's rotation, squares per 100 ms: sign(v) ln(1 + |v|) of x and y, "
                      "then 1; all 0 where the joints are not known",
            "step_ms": (sequences.STEP_MS[0], sequences.STEP_MS[1] * max(sequences.EVERY)),
        },
        "outputs": {
            "square": "4 x 4 cells; offsets from its middle, in squares",
            "names": network_module.OUTPUTS,
            "units": ["log odds", "squares", "squares", f"log2(radius / {surface.MEAN_CELLS} cells)", "squares per 100 ms",
                      "squares per 100 ms", "ln squares", "ln of log2", "log odds"],
        },
        "architecture": {"dilations": network.shape.dilations, "blocks_with_memory": network.shape.recurrent,
                         "channels": network.shape.channels, "gate_rank": network_module.RANK,
                         "gate_step_ms": network_module.STEP_MS},
        "multiplications_128x128_level_1": network.shape.multiplications(128, 128, [1]),
        "recipe": "docs/training.md",
        "options": {k: v for k, v in kept["recipe"].items() if k in ("steps", "batch", "rate", "seed")},
        "training_seeds": ranges(kept["seeds"]),
        "steps": kept["step"],
        "seconds": round(kept["seconds"]),
        "sha256": hashlib.sha256(weights.read_bytes()).hexdigest(),
        "development": summary(json.loads(figures.read_text())) if figures else None,
    }
    (out / "manifest.json").write_text(json.dumps(manifest, indent=1) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of the worlds (training.worlds)")
    parser.add_argument("--checkpoint", type=Path, required=True)
    parser.add_argument("--figures", type=Path, help="JSON of training.judge --out")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    export(options.checkpoint, options.data, options.figures, options.out)


if __name__ == "__main__":
    main()
