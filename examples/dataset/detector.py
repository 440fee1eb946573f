"""The trained network as a detector: {python: detector.py:Trained, arguments: weights=FILE.pt} (docs/external_detectors.md)."""
import torch

from network import Network, circles
from surfaces import Surface

EVERY_US = 5000  # between two evaluations


class Trained:
    def __init__(self, size, weights):
        torch.set_num_threads(1)
        saved = torch.load(weights)
        self.threshold = saved["threshold"]
        self.network = Network()
        self.network.load_state_dict(saved["weights"])
        self.network.eval()
        self.surface = Surface(size)
        self.next_us = 0
        self.circle = None

    def process(self, events, motion):
        self.surface.add(events)
        t_us = int(events["t"][-1])
        if t_us < self.next_us:
            return
        self.next_us = t_us + EVERY_US
        with torch.no_grad():
            x, y, r, score = circles(self.network(torch.from_numpy(self.surface.image(t_us))[None]))[0].tolist()
        scale = self.surface.scale
        # The middle of the first cell is at (scale - 1) / 2 px.
        self.circle = (x * scale - 0.5, y * scale - 0.5, r * scale, score)

    def estimate(self):
        return self.circle
