"""Training sequences: parts of worlds' images on one level of the pyramid, over a number of steps, with targets; made on the
device that the network is trained on."""
from dataclasses import dataclass

import numpy as np
import torch
from torch.nn import functional

from . import surface
from .network import motion
from .surface import SQUARE, TAU_MS

CROP = 64  # cells
STEP_MS = (5.0, 14.0)
ON_BALL = 0.65  # share of the sequences that show the ball at an instant within them
AT_EVENTS = 0.6  # share of the others whose crop has a place of an event, drawn from all of the world
WITHOUT_JOINTS = 0.25  # share of the sequences whose memory is not moved with the camera
DROPPED = 0.3  # share of the sequences that lose up to half of their events
WITH_HOT_PIXELS, HOT_PIXELS, HOT_RATE_PER_MS = 0.2, 12, 0.5  # share of the sequences; most pixels; highest rate of each
SHOWN = 0.6  # a ball counts from the instant on at which this many times its radius of pixels near it had an event in 270 ms
PLACES = 4096  # of a world's events, for AT_EVENTS
ELEMENTS_AT_ONCE = {"cpu": 2**26, "cuda": 2**28}  # of the maps of pixels


class Worlds:
    """Worlds (training.worlds) on a device: events, ground truth and camera rotation, one world after the other."""

    def __init__(self, device="cpu", capacity=2**20):
        """capacity: events that there is room for at first; it doubles when they do not fit."""
        self.device = torch.device(device)
        self.t_ms = torch.empty(capacity, device=self.device)
        self.place = torch.empty(capacity, dtype=torch.int32, device=self.device)  # x + 2^12 y + 2^24 on
        self.count, self.names, self.worlds = 0, set(), []
        self.truth = torch.empty(0, 4, device=self.device)
        self.eye = torch.empty(0, 4, device=self.device)

    def add(self, world):
        """Its name must not be there yet."""
        size = len(world.x)
        while self.count + size > len(self.t_ms):
            self.t_ms, self.place = (torch.cat([a, torch.empty_like(a)]) for a in (self.t_ms, self.place))
        kept = slice(self.count, self.count + size)
        packed = world.x.astype(np.int32) + (world.y.astype(np.int32) << 12) + (world.on.astype(np.int32) << 24)
        self.t_ms[kept] = torch.from_numpy(world.t_ms).to(self.device)
        self.place[kept] = torch.from_numpy(packed).to(self.device)
        some = np.linspace(0, size - 1, min(size, PLACES)).astype(int)
        self.worlds.append({
            "with_ball": world.with_ball, "width": world.width, "height": world.height, "duration": world.duration_ms,
            "focal": world.camera[2:4], "row": len(self.truth), "truth": world.truth,
            "ms": self.count + np.searchsorted(world.t_ms, np.arange(world.duration_ms + 2)),
            "places": np.stack([world.x[some], world.y[some]], 1)})
        self.truth = torch.cat([self.truth, torch.from_numpy(world.truth).to(self.device)])
        self.eye = torch.cat([self.eye, torch.from_numpy(world.eye.astype(np.float32)).to(self.device)])
        self.names.add(world.name)
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
    mirrored: tuple  # x, y
    transposed: bool
    exchanged: bool  # polarities


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
        chances = random.random(7)
        return Part(
            number, cell, int(corner[0]) * cell, int(corner[1]) * cell, float(first), float(dt), float(scale),
            joints=bool(chances[0] >= WITHOUT_JOINTS),
            dropped=float(random.uniform(0, 0.5)) if chances[1] < DROPPED else 0.0,
            hot_pixels=int(random.integers(1, HOT_PIXELS)) if chances[2] < WITH_HOT_PIXELS else 0,
            mirrored=(bool(chances[3] < 0.5), bool(chances[4] < 0.5)), transposed=bool(chances[5] < 0.5),
            exchanged=bool(chances[6] < 0.5))


def column(parts, name, device, dtype=torch.float32):
    return torch.tensor([getattr(p, name) for p in parts], dtype=dtype, device=device)


def newest_events(worlds, parts, length, generator):
    """Time of the newest event of each pixel at each instant: parts x length x 2 (ON, OFF) x rows x columns, ms of the network's time
    since the first instant."""
    device, size = worlds.device, CROP * parts[0].cell
    step = [p.dt_ms / p.scale for p in parts]
    ranges = []
    for p, s in zip(parts, step):
        ms = worlds.worlds[p.world]["ms"]
        begin = max(int(p.first_ms - surface.HISTORY_MS / p.scale), 0)
        ranges.append((ms[begin], ms[min(int(p.first_ms + s * length) + 1, len(ms) - 1)]))
    counts = torch.tensor([e - b for b, e in ranges], device=device)
    part = torch.repeat_interleave(torch.arange(len(parts), device=device), counts)
    begin = torch.tensor([b for b, _ in ranges], device=device) - (torch.cumsum(counts, 0) - counts)
    event = torch.arange(len(part), device=device) + begin[part]
    since = (worlds.t_ms[event] - column(parts, "first_ms", device)[part]) * column(parts, "scale", device)[part]
    k = torch.ceil(since / column(parts, "dt_ms", device)[part]).clamp(min=0).long()
    packed = worlds.place[event].long()
    x = (packed & 4095) - column(parts, "left", device, torch.long)[part]
    y = ((packed >> 12) & 4095) - column(parts, "top", device, torch.long)[part]
    off = ((packed >> 24) == 0) ^ column(parts, "exchanged", device, torch.bool)[part]
    kept = (k < length) & (x >= 0) & (x < size) & (y >= 0) & (y < size)
    kept &= torch.rand(len(part), device=device, generator=generator) >= column(parts, "dropped", device)[part]
    kept = kept.nonzero()[:, 0]
    x, y, off, k, part, since = (a[kept] for a in (x, y, off, k, part, since))
    mirrored = torch.tensor([p.mirrored for p in parts], device=device)[part]
    x, y = torch.where(mirrored[:, 0], size - 1 - x, x), torch.where(mirrored[:, 1], size - 1 - y, y)
    transposed = column(parts, "transposed", device, torch.bool)[part]
    x, y = torch.where(transposed, y, x), torch.where(transposed, x, y)
    index = (((part * length + k) * 2 + off.long()) * size + y) * size + x

    # The newest event of a hot pixel before each instant, where it is after the instant before.
    shape = (len(parts), HOT_PIXELS, length)
    rate = HOT_RATE_PER_MS * (0.1 + 0.9 * torch.rand(shape[:2], device=device, generator=generator))
    age = -torch.log(1 - torch.rand(shape, device=device, generator=generator)) / rate[:, :, None]
    pixel = torch.randint(2 * size * size, shape[:2], device=device, generator=generator)
    hot = torch.arange(HOT_PIXELS, device=device) < column(parts, "hot_pixels", device, torch.long)[:, None]
    dt = column(parts, "dt_ms", device)
    hot = (hot[:, :, None] & (age < dt[:, None, None])).nonzero(as_tuple=True)
    at = (hot[0] * length + hot[2]) * (2 * size * size) + pixel[hot[0], hot[1]]
    index, since = torch.cat([index, at]), torch.cat([since, hot[2] * dt[hot[0]] - age[hot]])

    newest = torch.full((len(parts) * length * 2 * size * size,), -1e6, device=device)
    newest.scatter_reduce_(0, index, since, "amax")
    newest = newest.view(len(parts), length, 2, size, size)
    for k in range(1, length):
        torch.maximum(newest[:, k], newest[:, k - 1], out=newest[:, k])
    return newest


def truth_of(worlds, parts, length):
    """parts x length x (x, y, r, visible, vx, vy), in cells from the crop's first one, per ms of the network's time."""
    device = worlds.device
    step = column(parts, "dt_ms", device) / column(parts, "scale", device)
    times = column(parts, "first_ms", device)[:, None] + step[:, None] * torch.arange(length, device=device)
    last = torch.tensor([worlds.worlds[p.world]["duration"] - 1 for p in parts], device=device)[:, None]
    rows = torch.minimum((times.round().long() - 1).clamp(min=0), last)
    late, early = torch.minimum(rows + 4, last), (rows - 4).clamp(min=0)
    begin = torch.tensor([worlds.worlds[p.world]["row"] for p in parts], device=device)[:, None]
    now, after, before = (worlds.truth[begin + r] for r in (rows, late, early))
    cell = column(parts, "cell", device)[:, None]
    corner = torch.stack([column(parts, "left", device), column(parts, "top", device)], 1)[:, None]
    place = (now[..., :2] + 0.5 - corner) / cell[..., None] - 0.5
    speed = (after[..., :2] - before[..., :2]) / ((late - early) * column(parts, "scale", device)[:, None] * cell)[..., None]
    speed = speed * ((after[..., 3:] > 0) & (before[..., 3:] > 0))
    mirrored = torch.tensor([p.mirrored for p in parts], device=device)[:, None]
    place = torch.where(mirrored, CROP - 1 - place, place)
    speed = torch.where(mirrored, -speed, speed)
    transposed = column(parts, "transposed", device, torch.bool)[:, None, None]
    place, speed = (torch.where(transposed, a.flip(-1), a) for a in (place, speed))
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
    focal = torch.tensor(np.stack([worlds.worlds[p.world]["focal"] for p in parts]), dtype=torch.float32, device=worlds.device)
    return axis[..., :2] / axis[..., 2:] * focal[:, None]


def shown_of(recent, truth, cell):
    """From which instant on the ball has made enough events. recent: parts x length x rows x columns, how many polarities of a
    pixel had an event in 270 ms."""
    reach = truth[..., 2] * cell + 3
    pixel = torch.arange(recent.shape[-1], device=recent.device)
    near = [(((truth[..., n] + 0.5) * cell)[..., None] - pixel).abs() <= reach[..., None] for n in (0, 1)]
    count = torch.einsum("blyx,bly,blx->bl", recent, near[1].float(), near[0].float())
    seen = (count >= SHOWN * truth[..., 2] * cell) & (truth[..., 3] > 0)
    return torch.cumsum(seen, 1) > 0


def batch_on_level(worlds, parts, length, generator):
    device, cell = worlds.device, parts[0].cell
    truth, rows = truth_of(worlds, parts, length)
    newest = newest_events(worlds, parts, length, generator)
    dt = column(parts, "dt_ms", device)
    now = dt[:, None] * torch.arange(length, device=device)
    slow = newest.sub_(now[:, :, None, None, None]).mul_(1 / TAU_MS[-1]).exp_()
    shown = shown_of((slow > 0.35).sum(2).float(), truth, cell)
    maps = []
    for tau in TAU_MS:
        value = slow ** (TAU_MS[-1] / tau)
        maps.append(functional.avg_pool2d(value.flatten(0, 1), cell) if cell > 1 else value.flatten(0, 1))
    inputs = torch.stack(maps, 2).flatten(1, 2).unflatten(0, (len(parts), length)) * cell**0.5  # channels as surface.Surface

    mirrored = torch.tensor([p.mirrored for p in parts], device=device)[:, None]
    transposed = column(parts, "transposed", device, torch.bool)[:, None, None]
    shift_px = image_shift_px(worlds, parts, rows)
    shift_px = torch.where(mirrored, -shift_px, shift_px)
    shift_px = torch.where(transposed, shift_px.flip(-1), shift_px)
    joints = column(parts, "joints", device)[:, None, None]
    whole = torch.round(torch.cumsum(shift_px * joints, 1) / (SQUARE * cell))
    shift = torch.diff(whole, dim=1, prepend=torch.zeros_like(whole[:, :1])).long()
    speed = shift_px / (SQUARE * cell) * (100 / dt)[:, None, None]
    speed[:, 0] = speed[:, 1]  # the first one has no earlier instant
    return {"inputs": inputs, "dt_ms": dt, "cell": column(parts, "cell", device), "truth": truth, "shown": shown,
            "shift": shift, "motion": motion(speed, joints)}


def batch(worlds, random, count, length):
    """count random sequences: inputs (count x length x channels x CROP x CROP), dt_ms, cell, truth (as truth_of), shown, shift,
    motion."""
    parts = [draw(worlds, random, length) for _ in range(count)]
    generator = torch.Generator(worlds.device).manual_seed(int(random.integers(2**62)))
    found = []
    for cell in surface.CELLS_PX:
        of_level = [p for p in parts if p.cell == cell]
        at_once = max(1, ELEMENTS_AT_ONCE[worlds.device.type] // (2 * length * (CROP * cell) ** 2))
        for n in range(0, len(of_level), at_once):
            found.append(batch_on_level(worlds, of_level[n : n + at_once], length, generator))
    return {k: torch.cat([f[k] for f in found]) for k in found[0]}


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
