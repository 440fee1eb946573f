"""The network's inputs: exponentially decayed maps of the newest ON and OFF event of each pixel, summed over cells."""
import numpy as np

TAU_MS = (4.0, 16.0, 64.0, 256.0)
CHANNELS = 2 * len(TAU_MS)  # ON by tau, then OFF by tau
CELLS_PX = (1, 2, 4, 8)  # levels of the pyramid
SQUARE = 4  # cells of a level per square of the network's output, in each direction
SMALLEST_CELLS, LARGEST_CELLS = 3.6, 9.0  # radii that a level finds
MEAN_CELLS = 5.66  # radius at output 0
HISTORY_MS = 512.0  # older events are left out where a sequence starts


def levels(height):
    """Cell sizes that an image of this height needs; the largest radius is 0.3 of it."""
    return [c for c in CELLS_PX if c == 1 or (height >= 16 * c and 0.3 * height > SMALLEST_CELLS * c)]


def whole_squares(shift_px, cell):
    """Shifts of the image (steps x 2) in whole squares of a level: their sum stays within half a square of the true one."""
    total = np.round(np.cumsum(shift_px, 0) / (SQUARE * cell))
    return np.diff(total, axis=0, prepend=0).astype(np.int64)


class Surface:
    """exp(-age / tau) of the newest event of each pixel and polarity in a part of the image.

    (left, top): its first pixel, may lie outside; time_scale: how often time runs faster than it did."""

    def __init__(self, width, height, left=0, top=0, time_scale=1.0):
        self.width, self.height, self.left, self.top, self.scale = width, height, left, top, time_scale
        self.maps = np.zeros((len(TAU_MS), 2 * height * width), np.float32)
        self.now = None

    def index(self, x, y, on):
        """Index of each event in the part; -1 outside of it."""
        x, y = x.astype(np.int64) - self.left, y.astype(np.int64) - self.top
        place = (y + np.where(on, 0, self.height)) * self.width + x
        return np.where((x >= 0) & (x < self.width) & (y >= 0) & (y < self.height), place, -1)

    def advance(self, now_ms, t_ms, index):
        """Decays the maps to now_ms and adds events, sorted by time, at indices >= 0."""
        if self.now is not None:
            factor = np.exp(-(now_ms - self.now) * self.scale / np.array(TAU_MS)).astype(np.float32)
            self.maps *= factor[:, None]
        self.now = now_ms
        age = (now_ms - t_ms) * self.scale
        for n, tau in enumerate(TAU_MS):
            self.maps[n, index] = np.exp(-age / tau)

    def cells(self, cell):
        """Channels x rows x columns of sums over whole cells of cell x cell px, times cell^-1.5."""
        maps = self.maps.reshape(len(TAU_MS), 2, self.height, self.width)
        halved = cell
        while halved > 1:
            maps = maps[:, :, ::2] + maps[:, :, 1::2]
            maps = maps[..., ::2] + maps[..., 1::2]
            halved //= 2
        maps = maps * np.float32(cell**-1.5)
        return maps.transpose(1, 0, 2, 3).reshape(CHANNELS, self.height // cell, self.width // cell)
