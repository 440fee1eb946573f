"""A robot's runs with added delay against a loop with the same delay, for scripts/reality.

The runs are results/closed-loop-trans-x-added-latency of event-driven-robotics/four-dof-affine-tracking: an arm moves a camera so that a
shape on a screen, which goes to and fro at constant speed, stays in the middle of the image. A line has the time in s and, fourth, x in px.
"""
import math
import re

import numpy as np

import reality_statistics as statistics

WIDTH_PX, SPEEDS, DELAYS_MS = 640, (240, 480, 720, 960), range(0, 55, 5)
TURN_PX = 768.0  # of the screen: where the shape turns, by the authors' script
STEP_S = 0.0025
FILTER_S = 0.2   # of the commanded velocity, by the authors' controller: 0.005 at 1 kHz
FAR_PX = WIDTH_PX / 4


def read_run(path):
    rows = []
    for line in path.read_text().splitlines():
        fields = line.split()
        if len(fields) >= 4 and re.fullmatch(r"[-+.\deE]+", fields[0]):
            rows.append((float(fields[0]), float(fields[3]) - WIDTH_PX / 2))
    return np.array(rows)


def outcome(run):
    """Whether the shape was lost (far from the middle at some time, or at rest in the last 2 s), and the rms distance."""
    t, x = run[:, 0], run[:, 1]
    grid = np.arange(t[-1] - 2.0, t[-1], 0.1)
    at = np.interp(grid, t, x)
    still = np.mean(np.abs(np.diff(at)) < 0.5) > 0.8
    return bool(np.abs(x).max() > FAR_PX or still), float(np.sqrt(np.mean(x**2)))


def simulated(values, speeds, delays_s, duration_s=10.0):
    """Of each run: the largest speed of the shape in the image in px/s, and the rms distance in px, in steps of 2.5 ms."""
    speeds, delays_s = np.asarray(speeds, float), np.asarray(delays_s, float)
    steps = round(duration_s / STEP_S)
    lag = np.round((values["delay_s"] + delays_s) / STEP_S).astype(int)
    error = np.zeros((steps + 1, len(speeds)))
    velocity = np.zeros(len(speeds))
    fastest, columns = np.zeros(len(speeds)), np.arange(len(speeds))
    for k in range(steps):
        seen = np.where(k >= lag, error[np.maximum(k - lag, 0), columns], 0.0)
        velocity += (values["gain"] * seen - velocity) * STEP_S / FILTER_S
        travelled = speeds * k * STEP_S
        forth = ((travelled + TURN_PX) // (2 * TURN_PX)) % 2 == 0
        slip = np.where(forth, 1.0, -1.0) * values["scale"] * speeds - velocity
        error[k + 1] = np.clip(error[k] + slip * STEP_S, -2000, 2000)
        if k * STEP_S > 0.2:
            fastest = np.maximum(fastest, np.abs(slip))
    return fastest, np.sqrt(np.mean(error**2, axis=0))


def boundary(delays_ms, lost):
    """The delay from which runs are lost: the one that separates lost from kept runs best; infinite where none is lost."""
    best = (len(lost) + 1, math.inf)
    for delay in [*sorted(delays_ms), math.inf]:
        wrong = sum((d >= delay) != bool(l) for d, l in zip(delays_ms, lost))
        best = min(best, (wrong, delay))
    return best[1]


def compare(folder, options):
    runs = {}
    for speed in SPEEDS:
        for delay in DELAYS_MS:
            path = folder / f"{speed:04}hz_{delay:02}ms.txt"
            if path.exists():
                runs[speed, delay] = outcome(read_run(path))
    if len(runs) != len(SPEEDS) * len(DELAYS_MS):
        raise ValueError(f"{folder}: found {len(runs)} runs, expected {len(SPEEDS) * len(DELAYS_MS)} of the form 0240hz_05ms.txt")
    keys = list(runs)
    speeds, delays = np.array([k[0] for k in keys]), np.array([k[1] for k in keys])
    lost, rms = np.array([runs[k][0] for k in keys]), np.array([runs[k][1] for k in keys])
    fits = delays % 10 == 0
    names = ["gain", "delay_s", "scale", "reach_px_s"]
    start = np.log([5.0, 0.05, 0.3, 400.0])

    def cost(x):
        values = dict(zip(names, np.exp(np.clip(x, -8, 9))))
        fastest, distance = simulated(values, speeds[fits], delays[fits] * 1e-3)
        beyond = np.log(np.maximum(fastest, 1e-3) / values["reach_px_s"])
        wrong = np.where(lost[fits], np.minimum(beyond, 0), np.maximum(beyond, 0))
        kept = ~lost[fits]
        return float(np.sum(np.log(distance[kept] / rms[fits][kept]) ** 2) + 20 * np.sum(wrong**2) + 0.2 * np.sum(wrong != 0))

    best = (None, math.inf)
    for delay in (0.02, 0.1):
        first = start.copy()
        first[1] = np.log(delay)
        best = min(best, statistics.minimise(cost, first, np.full(4, 0.4), options.evaluations), key=lambda pair: pair[1])
    values = dict(zip(names, np.exp(best[0])))
    print({k: float(f"{v:.3g}") for k, v in values.items()}, "cost", round(best[1], 2))
    fastest, distance = simulated(values, speeds, delays * 1e-3)
    predicted = fastest > values["reach_px_s"]
    rows = []

    def text(delay_ms):
        return f"{delay_ms:g} ms" if math.isfinite(delay_ms) else "none"

    for speed in SPEEDS:
        chosen = (speeds == speed) & ~fits
        both = chosen & ~lost & ~predicted
        rows.append([f"{speed}", text(boundary(delays[speeds == speed], lost[speeds == speed])),
                     text(boundary(delays[speeds == speed], predicted[speeds == speed])),
                     f"{int(np.sum(lost[chosen] == predicted[chosen]))} of {int(np.sum(chosen))}",
                     f"{rms[both].mean():.1f}, {distance[both].mean():.1f} px" if both.any() else "none kept"])
    both = ~fits & ~lost & ~predicted
    summary = []
    for name, statistic in (("Pearson", statistics.pearson), ("MMRV, px", statistics.mmrv)):
        low, high = statistics.bootstrap(statistic, rms[both], distance[both])
        summary.append([name, f"{statistic(rms[both], distance[both]):.2f} ({low:.2f} to {high:.2f})"])
    return {"loss": {"columns": ["px/s", "lost from: robot", "simulated", "judged runs right", "rms distance: robot, simulated"], "rows": rows},
            "distance": {"left": True, "columns": ["rms distance in the judged runs that both keep", "figure"], "rows": summary}}


def draw(data, path):
    """The boundaries of loss in the table `loss` as a picture; a boundary `none` lies at the upper border."""
    import matplotlib
    matplotlib.use("svg")
    matplotlib.rcParams.update({"svg.hashsalt": "reality", "svg.fonttype": "none", "font.family": "sans-serif"})
    from matplotlib import pyplot
    rows = data["tables"]["loss"]["rows"]
    speeds = [float(row[0]) for row in rows]
    robot, predicted = ([60.0 if row[k] == "none" else float(row[k].split()[0]) for row in rows] for k in (1, 2))
    figure, axes = pyplot.subplots(figsize=(5.5, 3.2), layout="constrained")
    axes.fill_between(speeds, [b - 10 for b in robot], [b + 10 for b in robot], color="#cccccc", linewidth=0, label="within 10 ms")
    axes.plot(speeds, robot, "o-", color="#333333", label="robot")
    axes.plot(speeds, predicted, "s--", color="#d55e00", label="predicted")
    axes.set_xlabel("speed of the target, px/s")
    axes.set_ylabel("added delay from which\nthe target is lost, ms")
    axes.set_xticks(speeds)
    axes.set_ylim(0, 65)
    axes.legend()
    axes.grid(alpha=0.3)
    figure.savefig(path, metadata={"Date": None})
    return path
