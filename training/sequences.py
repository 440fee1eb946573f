"""Training sequences: parts of worlds' images on one level of the pyramid, over LENGTH steps, with ground truth.

    python3 -m training.sequences --data DATA --out SEQUENCES

SEQUENCES/GROUP.npy and .npz are those of up to GROUP worlds whose seeds follow each other. Started again, it continues where it
stopped; a group that is there does not get the worlds that DATA has got since.
"""
import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch.nn import functional

from . import surface, worlds
from .network import motion
from .surface import SQUARE, TAU_MS

CROP = 64  # cells
LENGTH = 60
GROUP, PER_WORLD, AT_ONCE = 50, 3.2, 8
EVERY = (1, 2, 1, 3)  # n-th instant of the sequences of a batch, by its number: large images have longer steps
STEP_MS = (5.0, 14.0)
ON_BALL = 0.65  # share of the sequences that show the ball at an instant within them
AT_EVENTS = 0.6  # share of the others whose crop has a place of an event, drawn from all of the world
WITHOUT_JOINTS = 0.25  # share of the sequences whose memory is not moved with the camera
DROPPED = 0.3  # share of the sequences that lose up to half of their events
WITH_HOT_PIXELS, HOT_PIXELS, HOT_RATE_PER_MS = 0.2, 12, 0.5  # share of the sequences; most pixels; highest rate of each
SHOWN = 0.6  # a ball counts from the instant on at which this many times its radius of pixels near it had an event in 270 ms
PLACES = 4096  # of a world's events, for AT_EVENTS
ELEMENTS_AT_ONCE = 2**26  # of the maps of pixels


class Worlds:
    """Worlds (training.worlds): events, ground truth and camera rotation, one world after the other."""

    def __init__(self, capacity=2**20):
        """capacity: events that there is room for at first; it doubles when they do not fit."""
        self.t_ms = torch.empty(capacity)
        self.place = torch.empty(capacity, dtype=torch.int32)  # x + 2^12 y + 2^24 on
        self.count, self.worlds = 0, []
        self.truth = torch.empty(0, 4)
        self.eye = torch.empty(0, 4)

    def add(self, world):
        size = len(world.x)
        while self.count + size > len(self.t_ms):
            self.t_ms, self.place = (torch.cat([a, torch.empty_like(a)]) for a in (self.t_ms, self.place))
        kept = slice(self.count, self.count + size)
        packed = world.x.astype(np.int32) + (world.y.astype(np.int32) << 12) + (world.on.astype(np.int32) << 24)
        self.t_ms[kept] = torch.from_numpy(world.t_ms)
        self.place[kept] = torch.from_numpy(packed)
        some = np.linspace(0, size - 1, min(size, PLACES)).astype(int)
        self.worlds.append({
            "with_ball": world.with_ball, "width": world.width, "height": world.height, "duration": world.duration_ms,
            "focal": world.camera[2:4], "row": len(self.truth), "truth": world.truth,
            "ms": self.count + np.searchsorted(world.t_ms, np.arange(world.duration_ms + 2)),
            "places": np.stack([world.x[some], world.y[some]], 1)})
        self.truth = torch.cat([self.truth, torch.from_numpy(world.truth)])
        self.eye = torch.cat([self.eye, torch.from_numpy(world.eye.astype(np.float32))])
        self.count += size


@dataclass
class Part:
    """Where and how a sequence is taken from a world."""
    world: int
    cell: int  # px
    left: int  # first pixel of the crop, may lie outside of the image
    top: int
    first_ms: float  # first instant, in the world's time
    dt_ms: float  # between steps, as the network is told
    scale: float  # how often time runs faster than it did
    joints: bool
    dropped: float
    hot_pixels: int


def draw(worlds, random, length):
    """A random part of `length` steps."""
    while True:
        number = int(random.integers(len(worlds.worlds)))
        world = worlds.worlds[number]
        scale = 2.0 ** np.clip(random.normal(0, 0.8), -2, 2)
        dt = random.uniform(*STEP_MS)
        step = dt / scale  # in the world's time
        duration = world["duration"]
        if step * (length + 1) > duration:
            continue
        cells = surface.levels(world["height"])
        moment = random.integers(duration)
        x, y, r, visible = world["truth"][moment]
        if random.random() < ON_BALL and world["with_ball"]:
            if visible < 0.5:
                continue
            cells = [c for c in cells if surface.SMALLEST_CELLS <= r / c <= surface.LARGEST_CELLS]
            if not cells:
                continue
            cell = cells[random.integers(len(cells))]
            corner = [int(round((p + 0.5) / cell - 0.5 - random.uniform(8, CROP - 8))) for p in (x, y)]
            if random.random() < 0.8:  # mostly inside the image
                counts = (-(-world["width"] // cell), -(-world["height"] // cell))
                corner = [max(min(c, max(n - CROP, 0) + 8), -8) for c, n in zip(corner, counts)]
        else:
            cell = cells[random.integers(len(cells))]
            counts = (-(-world["width"] // cell), -(-world["height"] // cell))
            corner = [random.integers(min(-8, n - CROP - 8), max(n - CROP + 8, -7)) for n in counts]
            if random.random() < AT_EVENTS and len(world["places"]):
                place = world["places"][random.integers(len(world["places"]))]
                corner = [int(p // cell - random.uniform(8, CROP - 8)) for p in place]
        first = np.clip(moment - random.uniform(0, length) * step, step, duration - 1 - step * length)
        chances = random.random(3)
        return Part(
            number, cell, int(corner[0]) * cell, int(corner[1]) * cell, float(first), float(dt), float(scale),
            joints=bool(chances[0] >= WITHOUT_JOINTS),
            dropped=float(random.uniform(0, 0.5)) if chances[1] < DROPPED else 0.0,
            hot_pixels=int(random.integers(1, HOT_PIXELS)) if chances[2] < WITH_HOT_PIXELS else 0)


def column(parts, name, dtype=torch.float32):
    return torch.tensor([getattr(p, name) for p in parts], dtype=dtype)


def newest_events(worlds, parts, length, generator):
    """Time of the newest event of each pixel at each instant: parts x length x 2 (ON, OFF) x rows x columns, ms of the network's time
    since the first instant."""
    size = CROP * parts[0].cell
    step = [p.dt_ms / p.scale for p in parts]
    ranges = []
    for p, s in zip(parts, step):
        ms = worlds.worlds[p.world]["ms"]
        begin = max(int(p.first_ms - surface.HISTORY_MS / p.scale), 0)
        ranges.append((ms[begin], ms[min(int(p.first_ms + s * length) + 1, len(ms) - 1)]))
    counts = torch.tensor([e - b for b, e in ranges])
    part = torch.repeat_interleave(torch.arange(len(parts)), counts)
    begin = torch.tensor([b for b, _ in ranges]) - (torch.cumsum(counts, 0) - counts)
    event = torch.arange(len(part)) + begin[part]
    since = (worlds.t_ms[event] - column(parts, "first_ms")[part]) * column(parts, "scale")[part]
    k = torch.ceil(since / column(parts, "dt_ms")[part]).clamp(min=0).long()
    packed = worlds.place[event].long()
    x = (packed & 4095) - column(parts, "left", torch.long)[part]
    y = ((packed >> 12) & 4095) - column(parts, "top", torch.long)[part]
    off = (packed >> 24) == 0
    kept = (k < length) & (x >= 0) & (x < size) & (y >= 0) & (y < size)
    kept &= torch.rand(len(part), generator=generator) >= column(parts, "dropped")[part]
    kept = kept.nonzero()[:, 0]
    x, y, off, k, part, since = (a[kept] for a in (x, y, off, k, part, since))
    index = (((part * length + k) * 2 + off.long()) * size + y) * size + x

    # The newest event of a hot pixel before each instant, where it is after the instant before.
    shape = (len(parts), HOT_PIXELS, length)
    rate = HOT_RATE_PER_MS * (0.1 + 0.9 * torch.rand(shape[:2], generator=generator))
    age = -torch.log(1 - torch.rand(shape, generator=generator)) / rate[:, :, None]
    pixel = torch.randint(2 * size * size, shape[:2], generator=generator)
    hot = torch.arange(HOT_PIXELS) < column(parts, "hot_pixels", torch.long)[:, None]
    dt = column(parts, "dt_ms")
    hot = (hot[:, :, None] & (age < dt[:, None, None])).nonzero(as_tuple=True)
    at = (hot[0] * length + hot[2]) * (2 * size * size) + pixel[hot[0], hot[1]]
    index, since = torch.cat([index, at]), torch.cat([since, hot[2] * dt[hot[0]] - age[hot]])

    newest = torch.full((len(parts) * length * 2 * size * size,), -1e6)
    newest.scatter_reduce_(0, index, since, "amax")
    newest = newest.view(len(parts), length, 2, size, size)
    for k in range(1, length):
        torch.maximum(newest[:, k], newest[:, k - 1], out=newest[:, k])
    return newest


def truth_of(worlds, parts, length):
    """parts x length x (x, y, r, visible, vx, vy), in cells from the crop's first one, per ms of the network's time."""
    step = column(parts, "dt_ms") / column(parts, "scale")
    times = column(parts, "first_ms")[:, None] + step[:, None] * torch.arange(length)
    last = torch.tensor([worlds.worlds[p.world]["duration"] - 1 for p in parts])[:, None]
    rows = torch.minimum((times.round().long() - 1).clamp(min=0), last)
    late, early = torch.minimum(rows + 4, last), (rows - 4).clamp(min=0)
    begin = torch.tensor([worlds.worlds[p.world]["row"] for p in parts])[:, None]
    now, after, before = (worlds.truth[begin + r] for r in (rows, late, early))
    cell = column(parts, "cell")[:, None]
    corner = torch.stack([column(parts, "left"), column(parts, "top")], 1)[:, None]
    place = (now[..., :2] + 0.5 - corner) / cell[..., None] - 0.5
    speed = (after[..., :2] - before[..., :2]) / ((late - early) * column(parts, "scale")[:, None] * cell)[..., None]
    speed = speed * ((after[..., 3:] > 0) & (before[..., 3:] > 0))
    return torch.cat([place, now[..., 2:3] / cell[..., None], now[..., 3:], speed], 2), begin + rows


def image_shift_px(worlds, parts, rows):
    """How far (x, y) the camera's rotation has moved the middle of the image since the previous instant (worlds.World)."""
    w, x, y, z = worlds.eye[rows].unbind(-1)
    root_from_camera = torch.stack([
        torch.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], -1),
        torch.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], -1),
        torch.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], -1)], -2)
    earlier = root_from_camera[:, :, :, 2].roll(1, 1)
    earlier[:, 0] = root_from_camera[:, 0, :, 2]
    axis = (root_from_camera.transpose(2, 3) @ earlier[..., None])[..., 0]
    focal = torch.tensor(np.stack([worlds.worlds[p.world]["focal"] for p in parts]), dtype=torch.float32)
    return axis[..., :2] / axis[..., 2:] * focal[:, None]


def shown_of(recent, truth, cell):
    """From which instant on the ball has made enough events. recent: parts x length x rows x columns, how many polarities of a
    pixel had an event in 270 ms."""
    reach = truth[..., 2] * cell + 3
    pixel = torch.arange(recent.shape[-1])
    near = [(((truth[..., n] + 0.5) * cell)[..., None] - pixel).abs() <= reach[..., None] for n in (0, 1)]
    count = torch.einsum("blyx,bly,blx->bl", recent, near[1].float(), near[0].float())
    seen = (count >= SHOWN * truth[..., 2] * cell) & (truth[..., 3] > 0)
    return torch.cumsum(seen, 1) > 0


def batch_on_level(worlds, parts, length, generator):
    cell = parts[0].cell
    truth, rows = truth_of(worlds, parts, length)
    newest = newest_events(worlds, parts, length, generator)
    dt = column(parts, "dt_ms")
    now = dt[:, None] * torch.arange(length)
    slow = newest.sub_(now[:, :, None, None, None]).mul_(1 / TAU_MS[-1]).exp_()
    shown = shown_of((slow > 0.35).sum(2).float(), truth, cell)
    maps = []
    for tau in TAU_MS:
        value = slow ** (TAU_MS[-1] / tau)
        maps.append(functional.avg_pool2d(value.flatten(0, 1), cell) if cell > 1 else value.flatten(0, 1))
    inputs = torch.stack(maps, 2).flatten(1, 2).unflatten(0, (len(parts), length)) * cell**0.5  # channels as surface.Surface

    shift_px = image_shift_px(worlds, parts, rows)
    joints = column(parts, "joints")[:, None, None]
    whole = torch.round(torch.cumsum(shift_px * joints, 1) / (SQUARE * cell))
    shift = torch.diff(whole, dim=1, prepend=torch.zeros_like(whole[:, :1])).long()
    speed = shift_px / (SQUARE * cell) * (100 / dt)[:, None, None]
    speed[:, 0] = speed[:, 1]  # the first one has no earlier instant
    return {"inputs": inputs, "dt_ms": dt, "cell": column(parts, "cell"), "truth": truth, "shown": shown,
            "shift": shift, "motion": motion(speed, joints)}


def batch(worlds, random, count, length):
    """count random sequences: inputs (count x length x channels x CROP x CROP), dt_ms, cell, truth (as truth_of), shown, shift,
    motion, world (its number)."""
    parts = [draw(worlds, random, length) for _ in range(count)]
    generator = torch.Generator().manual_seed(int(random.integers(2**62)))
    found = []
    for cell in surface.CELLS_PX:
        of_level = [p for p in parts if p.cell == cell]
        at_once = max(1, ELEMENTS_AT_ONCE // (2 * length * (CROP * cell) ** 2))
        for n in range(0, len(of_level), at_once):
            some = of_level[n : n + at_once]
            found.append(batch_on_level(worlds, some, length, generator) | {"world": column(some, "world", torch.long)})
    return {k: torch.cat([f[k] for f in found]) for k in found[0]}


def write(folders, random, path):
    """The sequences of a group of worlds; the inputs as whole numbers, 255 for the largest value that a level's may have."""
    group = Worlds()
    for folder in folders:
        group.add(worlds.World(folder))
    seeds, parts = np.array([worlds.seed_of(f) for f in folders]), []
    for _ in range(-(-int(PER_WORLD * len(folders)) // AT_ONCE)):
        part = batch(group, random, AT_ONCE, LENGTH)
        part["inputs"] = (part["inputs"] * (255 / part["cell"].sqrt())[:, None, None, None, None]).round().to(torch.uint8)
        parts.append({k: v.numpy() for k, v in part.items()})
    arrays = {k: np.concatenate([p[k] for p in parts]) for k in parts[0]}
    inputs, arrays["world"] = arrays.pop("inputs"), seeds[arrays["world"]]
    np.savez(path.with_suffix(".npz"), **arrays)
    part = path.with_suffix(".part.npy")
    np.save(part, inputs)
    part.rename(path)


class Sequences:
    """The files of a folder, of the worlds whose seeds `wanted` takes. Inputs are read when they are asked for."""

    def __init__(self, folder, wanted):
        self.inputs, self.at, kept = [], [], []
        for path in sorted(p for p in folder.glob("*.npy") if not p.name.endswith(".part.npy")):
            arrays = np.load(path.with_suffix(".npz"))
            rows = [i for i, seed in enumerate(arrays["world"]) if wanted(int(seed))]
            self.at += [(len(self.inputs), i) for i in rows]
            self.inputs.append(np.load(path, mmap_mode="r"))
            kept.append({k: arrays[k][rows] for k in arrays.files})
        self.arrays = {k: torch.from_numpy(np.concatenate([a[k] for a in kept])) for k in kept[0]} if self.at else {}

    def __len__(self):
        return len(self.at)

    def batch(self, rows, every=1):
        """As batch() has it; of every n-th instant."""
        found = {k: v[torch.as_tensor(rows)].clone() for k, v in self.arrays.items()}
        inputs = torch.from_numpy(np.stack([self.inputs[file][i, ::every] for file, i in (self.at[r] for r in rows)]))
        found["inputs"] = inputs.float() * (found["cell"].sqrt() / 255)[:, None, None, None, None]
        moved = torch.cumsum(found["shift"], 1)[:, ::every]
        found["shift"] = torch.diff(moved, dim=1, prepend=torch.zeros_like(moved[:, :1]))
        for name in ("truth", "shown", "motion"):
            found[name] = found[name][:, ::every]
        found["dt_ms"] *= every
        return found


def seen_otherwise(batch, random):
    """The same sequences, mirrored, transposed, and with the other polarities."""
    vectors = [(batch["truth"], 4), (batch["shift"], 0), (batch["motion"], 0)]  # and where x and y begin
    for k, inputs in enumerate(batch["inputs"]):
        chances = random.random(4) < 0.5
        for axis in (0, 1):
            if chances[axis]:
                inputs[:] = inputs.flip(3 - axis)
                batch["truth"][k, :, axis] = CROP - 1 - batch["truth"][k, :, axis]
                for values, first in vectors:
                    values[k, :, first + axis] *= -1
        if chances[2]:
            inputs[:] = inputs.transpose(2, 3).clone()
            for values, first in (*vectors, (batch["truth"], 0)):
                values[k, :, first : first + 2] = values[k, :, first : first + 2].flip(1)
        if chances[3]:
            inputs[:] = inputs.roll(surface.CHANNELS // 2, 1)
    return batch


def targets(truth, shown):
    """Of a batch: positive squares, weights of their log odds, and x, y, log2 radius, vx, vy of every square, in the network's
    units."""
    middle = torch.arange(CROP // SQUARE, device=truth.device) * float(SQUARE) + 1.5
    r, visible = truth[..., 2], truth[..., 3]
    shape = truth.new_zeros((*truth.shape[:2], 5, len(middle), len(middle)))
    shape[:, :, 0] = ((truth[..., 0, None] - middle) / SQUARE)[:, :, None, :]
    shape[:, :, 1] = ((truth[..., 1, None] - middle) / SQUARE)[:, :, :, None]
    shape[:, :, 2] = torch.log2(r.clamp(min=0.1) / surface.MEAN_CELLS)[..., None, None]
    shape[:, :, 3:] = (truth[..., 4:] * 100 / SQUARE)[..., None, None]
    distance = torch.maximum(shape[:, :, 0].abs(), shape[:, :, 1].abs())
    near = (visible > 0) & (r >= 2.8) & (r <= 11.5)
    good = (visible >= 0.5) & (r >= surface.SMALLEST_CELLS) & (r <= surface.LARGEST_CELLS) & shown
    positive = (good[..., None, None] & (distance <= 0.75)).float()
    weight = 1.0 - (near[..., None, None] & (distance <= 1.6)).float()
    return positive, torch.where(positive > 0, torch.full_like(weight, 3.0), weight), shape


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of the worlds (training.worlds)")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)
    groups = {}
    for path in sorted(options.data.glob("train_*/world.npz")):
        if not path.parent.name.endswith(".part"):
            groups.setdefault(worlds.seed_of(path.parent) // GROUP * GROUP, []).append(path.parent)
    for group, folders in sorted(groups.items()):
        path = options.out / f"{group}.npy"
        if not path.exists():
            write(folders, np.random.default_rng([options.seed, group]), path)
            print(f"{path}, {len(folders)} worlds", flush=True)


if __name__ == "__main__":
    main()
