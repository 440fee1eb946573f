"""The input of the network, from events: how new the newest ON and OFF event of each place is."""
import numpy as np

TAU_US = (8e3, 40e3)
CELLS = 64  # the image, 128 pixels, is halved
CHANNELS = 2 * len(TAU_US)


class Surface:
    def __init__(self, size):
        self.scale = max(size) / CELLS
        self.last_us = np.full((2, CELLS, CELLS), -1e12)

    def add(self, events):
        """Events sorted by time."""
        x = (events["x"] / self.scale).astype(np.intp)
        y = (events["y"] / self.scale).astype(np.intp)
        self.last_us[events["p"].astype(np.intp), y, x] = events["t"]

    def image(self, t_us):
        """uint8 of shape (CHANNELS, CELLS, CELLS): 255 for an event now, 94 for one a tau ago."""
        age_us = t_us - self.last_us
        return np.concatenate([255 * np.exp(-age_us / tau) for tau in TAU_US]).astype(np.uint8)
