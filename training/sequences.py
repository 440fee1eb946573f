"""Training sequences: a part of a world's image on one level of the pyramid, over a number of steps, with targets."""
import numpy as np

from . import network, surface
from .surface import SQUARE, Surface

CROP = 64  # cells
STEP_MS = (5.0, 14.0)
ON_BALL = 0.65  # share of the sequences that show the ball at an instant within them
AT_EVENTS = 0.6  # share of the others whose crop has a place of an event, drawn from all of the world
WITHOUT_JOINTS = 0.25  # share of the sequences whose memory is not moved with the camera
SHOWN = 0.6  # a ball counts from the instant on at which this many times its radius of pixels near it had an event in 270 ms


def hot_pixels(random, width, height, begin_ms, end_ms, rate_per_ms):
    """Events of a few pixels at constant mean rates: t_ms, index."""
    indices, times = [], []
    for _ in range(random.integers(1, 12)):
        count = random.poisson(rate_per_ms * random.uniform(0.1, 1.0) * (end_ms - begin_ms))
        indices.append(np.full(count, random.integers(2 * width * height)))
        times.append(random.uniform(begin_ms, end_ms, count))
    return np.concatenate(times).astype(np.float32), np.concatenate(indices)


def flipped(inputs, truth, shift, motion, random):
    """Polarity exchanged, mirrored and transposed at random. inputs: time x channels x rows x columns. truth: time x (x, y, r,
    visible, vx, vy), in cells from the crop's first one. shift, motion: time x 2."""
    if random.random() < 0.5:
        half = surface.CHANNELS // 2
        inputs = np.concatenate([inputs[:, half:], inputs[:, :half]], 1)
    for axis, x, v in ((3, 0, 4), (2, 1, 5)):
        if random.random() < 0.5:
            inputs = np.flip(inputs, axis)
            truth[:, x] = CROP - 1 - truth[:, x]
            truth[:, v] *= -1
            shift[:, x] *= -1
            motion[:, x] *= -1
    if random.random() < 0.5:
        inputs, truth = inputs.transpose(0, 1, 3, 2), truth[:, [1, 0, 2, 3, 5, 4]]
        shift, motion = shift[:, ::-1].copy(), motion[:, ::-1]
    return np.ascontiguousarray(inputs), truth, shift, motion


def draw(worlds, random, length):
    """A sequence: dict of inputs (time x channels x CROP x CROP), dt_ms, cell, truth (time x 6, as for flipped), shift,
    shown."""
    while True:
        world = worlds[random.integers(len(worlds))]
        scale = 2.0 ** np.clip(random.normal(0, 0.8), -2, 2)
        dt = random.uniform(*STEP_MS)
        step = dt / scale  # in the world's time
        if step * (length + 1) > world.duration_ms:
            continue
        cells = surface.levels(world.height)
        moment = random.integers(world.duration_ms)
        x, y, r, visible = world.truth[moment]
        if random.random() < ON_BALL and world.with_ball:
            if visible < 0.5:
                continue
            cells = [c for c in cells if surface.SMALLEST_CELLS <= r / c <= surface.LARGEST_CELLS]
            if not cells:
                continue
            cell = cells[random.integers(len(cells))]
            corner = [int(round((p + 0.5) / cell - 0.5 - random.uniform(8, CROP - 8))) for p in (x, y)]
            if random.random() < 0.8:  # mostly inside the image
                counts = (-(-world.width // cell), -(-world.height // cell))
                corner = [max(min(c, max(n - CROP, 0) + 8), -8) for c, n in zip(corner, counts)]
        else:
            cell = cells[random.integers(len(cells))]
            counts = (-(-world.width // cell), -(-world.height // cell))
            corner = [random.integers(min(-8, n - CROP - 8), max(n - CROP + 8, -7)) for n in counts]
            if random.random() < AT_EVENTS and len(world.x):
                event = random.integers(len(world.x))
                corner = [int(p // cell - random.uniform(8, CROP - 8)) for p in (world.x[event], world.y[event])]
        first = moment - random.uniform(0, length) * step
        first = np.clip(first, step, world.duration_ms - 1 - step * length)
        break
    left, top = corner[0] * cell, corner[1] * cell
    part = Surface(CROP * cell, CROP * cell, left, top, scale)
    times = first + step * np.arange(length)
    begin, end = np.searchsorted(world.t_ms, [times[0] - surface.HISTORY_MS / scale, times[-1]])
    index = part.index(world.x[begin:end], world.y[begin:end], world.on[begin:end])
    keep = index >= 0
    if random.random() < 0.3:
        keep &= random.random(len(index)) > random.uniform(0, 0.5)
    t, index = world.t_ms[begin:end][keep], index[keep]
    if random.random() < 0.2:
        more_t, more = hot_pixels(random, part.width, part.height, times[0] - 100 / scale, times[-1], 0.5 * scale)
        t, index = np.concatenate([t, more_t]), np.concatenate([index, more])
        order = np.argsort(t, kind="stable")
        t, index = t[order], index[order]

    rows = np.clip(np.round(times).astype(int) - 1, 0, world.duration_ms - 1)
    late, early = np.minimum(rows + 4, world.duration_ms - 1), np.maximum(rows - 4, 0)
    truth = np.zeros((length, 6), np.float32)
    truth[:, :4] = world.truth[rows]
    truth[:, 4:] = (world.truth[late, :2] - world.truth[early, :2]) / (late - early)[:, None] / scale / cell
    truth[(world.truth[late, 3] == 0) | (world.truth[early, 3] == 0), 4:] = 0
    truth[:, 0] = (truth[:, 0] + 0.5) / cell - 0.5 - corner[0]
    truth[:, 1] = (truth[:, 1] + 0.5) / cell - 0.5 - corner[1]
    truth[:, 2] /= cell

    inputs = np.zeros((length, surface.CHANNELS, CROP, CROP), np.float32)
    shown = np.zeros(length, bool)
    bounds = np.searchsorted(t, times)
    last = 0
    seen = False
    for k, now in enumerate(times):
        part.advance(now, t[last : bounds[k]], index[last : bounds[k]])
        last = bounds[k]
        inputs[k] = part.cells(cell)
        if not seen and truth[k, 3] > 0:
            px, py, reach = ((truth[k, 0] + 0.5) * cell, (truth[k, 1] + 0.5) * cell, truth[k, 2] * cell + 3)
            y0, y1, x0, x1 = (int(max(v, 0)) for v in (py - reach, py + reach + 1, px - reach, px + reach + 1))
            newest = part.maps[3].reshape(2, part.height, part.width)[:, y0:y1, x0:x1]
            seen = (newest > 0.35).sum() >= SHOWN * truth[k, 2] * cell
        shown[k] = seen
    shift_px = world.image_shift_px(times)
    joints = random.random() >= WITHOUT_JOINTS
    shift = surface.whole_squares(shift_px * joints, cell)
    speed = shift_px / (SQUARE * cell) * (100 / dt)
    speed[0] = speed[1]  # the first one has no earlier instant
    inputs, truth, shift, speed = flipped(inputs, truth, shift, speed, random)
    return {"inputs": inputs, "shift": shift, "motion": network.motion(speed, joints), "dt_ms": np.float32(dt), "cell": np.float32(cell), "truth": truth, "shown": shown}


def targets(truth, shown):
    """Of a batch (arrays batch x time ...): positive squares, weights of their log odds, and x, y, log2 radius, vx, vy of every
    square, in the network's units."""
    squares = CROP // SQUARE
    middle = np.arange(squares, dtype=np.float32) * SQUARE + 1.5
    shape = np.zeros((*truth.shape[:2], 5, squares, squares), np.float32)
    shape[:, :, 0] = ((truth[..., 0, None] - middle) / SQUARE)[:, :, None, :]
    shape[:, :, 1] = ((truth[..., 1, None] - middle) / SQUARE)[:, :, :, None]
    r = truth[..., 2]
    shape[:, :, 2] = np.log2(np.maximum(r, 0.1) / surface.MEAN_CELLS)[..., None, None]
    shape[:, :, 3:] = (truth[..., 4:] * 100 / SQUARE)[..., None, None]
    distance = np.maximum(abs(shape[:, :, 0]), abs(shape[:, :, 1]))
    near = (truth[..., 3] > 0) & (r >= 2.8) & (r <= 11.5)
    good = (truth[..., 3] >= 0.5) & (r >= surface.SMALLEST_CELLS) & (r <= surface.LARGEST_CELLS) & shown
    positive = (good[..., None, None] & (distance <= 0.75)).astype(np.float32)
    weight = np.where(near[..., None, None] & (distance <= 1.6), 0, 1).astype(np.float32)
    weight[positive > 0] = 3
    return positive, weight, shape
