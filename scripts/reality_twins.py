"""Recordings of balls and their simulated twins, for scripts/reality: what their events have in common, and the detectors on both."""
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import reality_statistics as statistics
import saccade

OUTLINE_PX = 3.0
INSIDE, BEYOND = 0.7, 2.0  # of the radius
QUANTITIES = ["events of the outline per px²", "width in time, ms", "ON to OFF", "inside, per px² and s", "noise, per px² and s"]


@dataclass
class Recording:
    name: str
    file: str
    size: tuple
    radius_px: tuple
    preset: str
    fall: float  # px/s², of a ball in the air; 0: the path is smooth
    fit_s: float  # of the first half that the twin is fitted to
    image_us: int
    codec: str = "auto"


RECORDINGS = [
    Recording("ball_looming, DVS128", "ball_looming_dvs128_aedat2.aedat", (128, 128), (16, 45), "dvs128", 0.0, 12.0, 10_000),
    Recording("ball_bounce, ATIS", "ball_bounce_atis304x240_yarp.log", (304, 240), (4, 10), "atis", 2450.0, 2.2, 1000),
    Recording("spinning_dot, Gen3 VGA", "spinning_dot_gen3vga_evt2.raw", (640, 480), (12, 25), "gen3_vga", 0.0, 0.008, 20),
]


class Path2D:
    """The circle at any time, from annotated instants: cubic through them, or in free fall between two."""

    def __init__(self, rows, fall):
        self.t = rows[:, 0].astype(float)
        self.circles = rows[:, 1:4]
        seconds = np.diff(self.t) * 1e-6
        steps = np.diff(self.circles, axis=0) / seconds[:, None]
        self.start, self.end = steps.copy(), steps.copy()  # slopes at both ends of each piece, per second
        if fall > 0:
            self.start[:, 1] -= 0.5 * fall * seconds
            self.end[:, 1] += 0.5 * fall * seconds
        else:
            middle = 0.5 * (steps[1:] + steps[:-1])
            self.start[1:], self.end[:-1] = middle, middle
        self.good = seconds < 1.5 * np.median(seconds)
        if fall > 0:  # a bounce breaks the fall: the piece's ends fit neither neighbour
            joins = np.abs(self.end[:-1, 1] - self.start[1:, 1]) < 60.0
            self.good &= np.concatenate([[False], joins]) | np.concatenate([joins, [False]])

    def at(self, t_us):
        """Circles, their change per second, and whether the path is known."""
        t_us = np.asarray(t_us, float)
        k = np.clip(np.searchsorted(self.t, t_us, "right") - 1, 0, len(self.start) - 1)
        length = (self.t[k + 1] - self.t[k]) * 1e-6
        s = np.clip((t_us - self.t[k]) * 1e-6 / length, 0, 1)[..., None]
        length = length[..., None]
        a, b, m, n = self.circles[k], self.circles[k + 1], self.start[k] * length, self.end[k] * length
        value = (2 * s**3 - 3 * s**2 + 1) * a + (s**3 - 2 * s**2 + s) * m + (3 * s**2 - 2 * s**3) * b + (s**3 - s**2) * n
        slope = ((6 * s**2 - 6 * s) * (a - b) + (3 * s**2 - 4 * s + 1) * m + (3 * s**2 - 2 * s) * n) / length
        within = (t_us >= self.t[0]) & (t_us <= self.t[-1])
        return value, slope * within[..., None], self.good[k] & within


def quantities(events, path, size, begin_us, end_us):
    """QUANTITIES of the events from begin to end where the path is known."""
    events = events[(events["t"] >= begin_us) & (events["t"] < end_us)]
    times = np.linspace(begin_us, end_us, 4000, endpoint=False) + 0.5 * (end_us - begin_us) / 4000
    circles, slopes, known = path.at(times)
    circles, slopes = circles[known], slopes[known]
    dt_s = (end_us - begin_us) / 4000 * 1e-6
    angles = np.linspace(0, 2 * math.pi, 72, endpoint=False)
    normal = np.stack([np.cos(angles), np.sin(angles)])
    speed = np.abs(slopes[:, :2] @ normal + slopes[:, 2:3])
    swept = float((speed.mean(axis=1) * 2 * math.pi * circles[:, 2]).sum() * dt_s)
    area_s = float((math.pi * circles[:, 2] ** 2).sum() * dt_s)
    image_s = size[0] * size[1] * len(circles) * dt_s
    c, v, known = path.at(events["t"])
    events, c, v = events[known], c[known], v[known]
    dx, dy = events["x"] - c[:, 0], events["y"] - c[:, 1]
    distance = np.hypot(dx, dy)
    off = distance - c[:, 2]
    outline = np.abs(off) <= OUTLINE_PX
    at = np.maximum(distance, 1e-9)
    outwards = (v[:, 0] * dx + v[:, 1] * dy) / at + v[:, 2]
    fast = outline & (np.abs(outwards) > 0.3 * (np.hypot(v[:, 0], v[:, 1]) + np.abs(v[:, 2])))
    passed_ms = -1e3 * off[fast] / outwards[fast]
    inside, beyond = distance < INSIDE * c[:, 2], distance > BEYOND * c[:, 2]
    on = int(np.count_nonzero(events["p"][outline]))
    return np.array([np.count_nonzero(outline) / swept,
                     float(np.subtract(*np.percentile(passed_ms, [75, 25]))) if len(passed_ms) > 3 else math.nan,
                     on / max(1, np.count_nonzero(outline) - on), np.count_nonzero(inside) / (INSIDE**2 * area_s),
                     np.count_nonzero(beyond) / max(1.0, image_s - BEYOND**2 * area_s)])


def twin(recording, path, values, begin_us, end_us, crop=False, seed=1):
    """Events of a disc on the path before a uniform background."""
    width, height = recording.size
    left = top = 0
    if crop:
        circles, _, _ = path.at(np.linspace(begin_us, end_us, 200))
        reach = 2.5 * circles[:, 2].max()
        left, top = (max(0, int(circles[:, k].min() - reach)) for k in (0, 1))
        width = min(width, int(circles[:, 0].max() + reach)) - left
        height = min(height, int(circles[:, 1].max() + reach)) - top
    emulator = saccade.Emulator((width, height), seed=seed, preset=recording.preset, refractory_us=round(values["refractory_us"]),
                                cutoff_hz=values["cutoff_hz"], shot_noise_rate_hz=values["shot_hz"],
                                leak_rate_hz=values["leak_hz"], contrast_threshold_off=values["threshold_off"])
    x, y = np.arange(width) + left, np.arange(height) + top
    times = np.arange(begin_us, end_us, recording.image_us)
    circles, _, _ = path.at(times)
    dark = 100.0 * math.exp(-abs(values["contrast"]))
    disc, ground = (dark, 100.0) if values["contrast"] < 0 else (100.0, dark)
    image = np.full((height, width), ground, np.float32)
    made = []
    last = None
    for t_us, (cx, cy, r) in zip(times, circles):
        if last is not None:
            image[last] = ground
        x0, x1 = np.searchsorted(x, [cx - r - 2, cx + r + 2])
        y0, y1 = np.searchsorted(y, [cy - r - 2, cy + r + 2])
        last = (slice(y0, y1), slice(x0, x1))
        share = np.clip(r - np.hypot(x[None, x0:x1] - cx, y[y0:y1, None] - cy) + 0.5, 0, 1)
        image[last] = ground + share * (disc - ground)
        made.append(emulator.process(image, t_us=int(t_us)))
    made.append(emulator.finish())
    events = np.concatenate(made)
    events["x"] += left
    events["y"] += top
    return events


PRIOR = {"contrast": 0.7, "refractory_us": 500.0, "cutoff_hz": 1000.0, "shot_hz": 0.4, "leak_hz": 0.1, "threshold_off": 0.2}


def fitted_twin(recording, path, events, half_us, evaluations, report):
    """Values of the twin from the recording's first half."""
    begin = max(path.t[0], half_us - recording.fit_s * 1e6)
    wanted = quantities(events, path, recording.size, begin, half_us)
    names = ["contrast", "refractory_us", "cutoff_hz", "threshold_off"]
    threshold = {"atis": 0.13}.get(recording.preset, 0.2)
    base = dict(PRIOR, threshold_off=threshold)
    # Far from the ball there is only noise, both polarities of which are counted.
    far = events[(events["t"] >= begin) & (events["t"] < half_us)]
    c, _, known = path.at(far["t"])
    far = far[known & (np.hypot(far["x"] - c[:, 0], far["y"] - c[:, 1]) > BEYOND * c[:, 2])]
    on_share = np.count_nonzero(far["p"]) / max(1, len(far))
    rate = wanted[4]
    base["shot_hz"] = min(1000.0, 2 * rate * (1 - on_share) / 0.6)  # the share of the shot noise at this light
    base["leak_hz"] = min(1000.0, max(0.0, rate * (2 * on_share - 1)))
    sign = polarity_sign(events, path, begin, half_us)

    def values_of(x):
        found = dict(base, **{n: float(np.exp(v)) for n, v in zip(names, x)})
        found["contrast"] = sign * min(found["contrast"], 4.0)
        found["refractory_us"] = min(found["refractory_us"], 2e5)
        found["cutoff_hz"] = min(found["cutoff_hz"], 1e5)
        found["threshold_off"] = float(np.clip(found["threshold_off"], 0.03, 3))
        return found

    prior = np.log([base[n] for n in names])

    def cost(x):
        made = twin(recording, path, values_of(x), int(begin), int(half_us), crop=True)
        got = quantities(made, path, recording.size, begin, half_us)
        error = np.log(np.maximum(got[:3], 1e-3) / np.maximum(wanted[:3], 1e-3)) if np.all(np.isfinite(got[:3])) else np.full(3, 5.0)
        return float(np.sum((error * [3, 1, 1]) ** 2) + 0.01 * np.sum((x - prior) ** 2))

    found, misfit = statistics.minimise(cost, prior, np.full(len(names), 0.7), evaluations)
    report(f"{recording.name}: {values_of(found)}, misfit {misfit:.3f}")
    return values_of(found)


def polarity_sign(events, path, begin, end):
    """1 where the ball is brighter than what it covers: ON before it."""
    events = events[(events["t"] >= begin) & (events["t"] < end)]
    c, v, known = path.at(events["t"])
    events, c, v = events[known], c[known], v[known]
    dx, dy = events["x"] - c[:, 0], events["y"] - c[:, 1]
    distance = np.maximum(np.hypot(dx, dy), 1e-9)
    outwards = (v[:, 0] * dx + v[:, 1] * dy) / distance + v[:, 2]
    near = np.abs(distance - c[:, 2]) <= OUTLINE_PX
    return 1.0 if np.sum(np.sign(outwards[near]) * np.where(events["p"][near], 1, -1)) > 0 else -1.0


VARIANTS = {
    "paper_directed, 750 events": ("paper_directed", {"window": {"events": 750}}),
    "paper_directed, 3000 events": ("paper_directed", {"window": {"events": 3000}}),
    "paper_directed, arcs of 20 deg": ("paper_directed", {"arc_deg": 20}),
    "paper_full, 750 events": ("paper_full", {"window": {"events": 750}}),
}


def precisions(recording, events, rows):
    """Average precision of every detector and variant at the annotated instants."""
    kinds = {name: (name, {}) for name in saccade.detectors() if name not in ("python", "command", "socket")} | VARIANTS
    truth = [{"t_us": int(t), "x_px": x, "y_px": y, "r_px": r, "visible": True} for t, x, y, r in rows]
    at = [row["t_us"] for row in truth]
    events = events[events["t"] <= at[-1]]
    found = {}
    for label, (name, keys) in kinds.items():
        detector = saccade.detector(name, size=recording.size, radius_px=recording.radius_px, **keys)
        detections = saccade.detect(detector, events, at_us=at)
        scored = saccade.score(detections, truth, threshold=detector.threshold, name="it") if len(detections) else None
        found[label] = scored["it"]["average_precision"] if scored else 0.0
    return found


def compare(folder, options):
    quantity_rows, precision_rows, real_all, twin_all, recording_of = [], [], [], [], []
    for recording in RECORDINGS:
        file = Path(folder) / recording.file
        events = saccade.read(str(file))
        rows = np.loadtxt(file.with_suffix("").as_posix() + ".truth.csv", delimiter=",", skiprows=1)
        path = Path2D(rows, recording.fall)
        half_us = rows[len(rows) // 2, 0]
        report = lambda text: print(text, flush=True)
        values = fitted_twin(recording, path, events, half_us, options.evaluations, report)
        end_us = rows[-1, 0]
        warm_us = 0.2 * (end_us - half_us) if recording.fit_s < 1 else 1e6
        made = twin(recording, path, values, int(half_us - warm_us), int(end_us) + 1)
        judged = events[events["t"] >= half_us - warm_us]
        real, simulated = (quantities(e, path, recording.size, half_us, end_us) for e in (judged, made))
        error = simulated / real - 1
        quantity_rows.append([recording.name] + [f"{a:.3g}, {b:.3g} ({100 * e:+.0f} %)" for a, b, e in zip(real, simulated, error)])
        print(quantity_rows[-1], flush=True)
        instants = rows[rows[:, 0] >= half_us]
        a, b = precisions(recording, judged, instants), precisions(recording, made, instants)
        for label in a:
            print(f"  {label}: {a[label]:.3f} {b[label]:.3f}", flush=True)
            precision_rows.append([recording.name.split(",")[0], label, a[label], b[label]])
    names = list(dict.fromkeys(row[1] for row in precision_rows))
    folders = list(dict.fromkeys(row[0] for row in precision_rows))
    of = {(row[0], row[1]): row[2:] for row in precision_rows}
    table = [[name.replace("paper", "`paper", 1).replace(",", "`,", 1) if "," in name else f"`{name}`"]
             + [f"{of[f, name][0]:.3f}, {of[f, name][1]:.3f}" for f in folders] for name in names]
    ranks = []
    for title, chosen in [(f, [f]) for f in folders] + [("mean of the three", folders)]:
        a = np.array([np.mean([of[f, n][0] for f in chosen]) for n in names])
        b = np.array([np.mean([of[f, n][1] for f in chosen]) for n in names])
        row = [title]
        for statistic in (statistics.spearman, statistics.pearson, statistics.mmrv):
            low, high = statistics.bootstrap(statistic, a, b)
            row.append(f"{statistic(a, b):.2f} ({low:.2f} to {high:.2f})")
        ranks.append(row)
    return {"twins": {"columns": ["recording: measured, twin", *QUANTITIES], "rows": quantity_rows},
            "precision": {"columns": ["average precision: measured, twin", *[f"`{f}`" for f in folders]], "rows": table},
            "ranks": {"columns": ["detectors", "Spearman", "Pearson", "MMRV"], "rows": ranks}}
