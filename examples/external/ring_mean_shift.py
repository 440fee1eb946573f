"""A detector of one's own in Python: a ring that mean shift moves onto the newest events (docs/external_detectors.md)."""

import numpy as np

SECTORS = 24


class RingMeanShift:
    """Moves a ring of events: each event pulls the circle towards itself, weighted by how near to the ring it is.

    size: (width, height) of the image. events: how many of the newest events are used. radius_px: smallest and largest
    radius. width_px: standard deviation of the weight over the distance from the ring.
    """

    def __init__(self, size, events=500, radius_px=(4, 25), width_px=2.0, threshold=0.5):
        self.threshold = threshold
        self.size = size
        self.events = events
        self.radius_px = radius_px
        self.width_px = width_px
        self.points = np.zeros((0, 2))
        self.circle = None

    def process(self, events, motion):
        """events: array with the fields x, y, p, t, camera, sorted by time. motion: pose and velocity of the camera, or
        None where the joints are unknown."""
        new = np.stack([events["x"], events["y"]], axis=1).astype(float)
        self.points = np.concatenate([self.points, new])[-self.events:]

    def estimate(self):
        """None, or (x, y, r, score), or (x, y, r, score, held) with held=True for a circle that is predicted."""
        if len(self.points) < self.events:
            return None
        best = None
        for start in self.starts():
            circle = self.moved(start)
            score = self.score(circle)
            if best is None or score > best[3]:
                best = (*circle, score)
        self.circle = best[:3] if best[3] >= self.threshold else None
        return best

    def starts(self):
        """The last circle while it is good; else circles of three radii around the median of the events."""
        if self.circle is not None:
            return [self.circle]
        x, y = np.median(self.points, axis=0)
        low, high = self.radius_px
        return [(x, y, low + share * (high - low)) for share in (0.2, 0.5, 0.8)]

    def moved(self, circle):
        x, y, r = circle
        for width_px in (3 * self.width_px, 2 * self.width_px, self.width_px, self.width_px):
            offset = self.points - (x, y)
            distance = np.hypot(offset[:, 0], offset[:, 1]) + 1e-9
            error = distance - r
            weight = np.exp(-0.5 * (error / width_px) ** 2)
            total = weight.sum() + 1e-9
            # Half of the directions of a ring lie along an axis, hence twice the mean.
            x += 2 * (weight * error * offset[:, 0] / distance).sum() / total
            y += 2 * (weight * error * offset[:, 1] / distance).sum() / total
            r += (weight * error).sum() / total
            x, y = np.clip(x, 0, self.size[0] - 1), np.clip(y, 0, self.size[1] - 1)
            r = np.clip(r, *self.radius_px)
        return float(x), float(y), float(r)

    def score(self, circle):
        """Share of the outline with events on it, times the share of events on the outline of those on and inside."""
        x, y, r = circle
        offset = self.points - (x, y)
        error = np.hypot(offset[:, 0], offset[:, 1]) - r
        on = np.abs(error) <= self.width_px
        inside = np.count_nonzero(error < -self.width_px)
        sectors = ((np.arctan2(offset[on, 1], offset[on, 0]) / (2 * np.pi) + 0.5) * SECTORS).astype(int) % SECTORS
        covered = np.count_nonzero(np.bincount(sectors, minlength=SECTORS)) / SECTORS
        count = np.count_nonzero(on)
        return float(covered * count / max(count + inside, 1))
