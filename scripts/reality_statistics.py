"""Distances, likelihoods and rank correlations of scripts/reality, and the two models of noise beside the emulator's."""
import numpy as np

# Lower edges of the bins of frequency of the silicon's noise, Hz, and their intervals, s.
FREQUENCIES_HZ = np.concatenate([np.arange(1, 10) * 10.0**d for d in range(-3, 5)])
EDGES_HZ = np.append(FREQUENCIES_HZ, 1e5)
INTERVALS_S = 1.0 / np.sqrt(EDGES_HZ[:-1] * EDGES_HZ[1:])


def ks_distance(a, b):
    """Kolmogorov-Smirnov distance of two samples."""
    a, b = np.sort(a), np.sort(b)
    at = np.concatenate([a, b])
    return float(np.abs(np.searchsorted(a, at, "right") / len(a) - np.searchsorted(b, at, "right") / len(b)).max())


def ks_of_counts(a, b):
    """The same of two histograms with the same bins, at the bins' edges. 1 where only one has entries."""
    if np.sum(a) == 0 or np.sum(b) == 0:
        return float((np.sum(a) == 0) != (np.sum(b) == 0))
    return float(np.abs(np.cumsum(a) / np.sum(a) - np.cumsum(b) / np.sum(b)).max())


def log_likelihood(counts, predicted):
    """Mean over the entries of a histogram of the log of their predicted share, half an entry added to every predicted bin."""
    predicted = np.asarray(predicted, float) + 0.5
    return float(np.sum(counts * np.log(predicted / predicted.sum())) / max(1, np.sum(counts)))


COUNT_EDGES = np.unique(np.concatenate([np.arange(6), np.round(6 * 1.25 ** np.arange(28))]))


def count_histogram(counts):
    return np.histogram(counts, COUNT_EDGES)[0]


def interval_histogram(intervals_s):
    bins = np.searchsorted(EDGES_HZ, 1.0 / np.maximum(intervals_s, 1.01e-5), "right") - 1
    return np.bincount(np.maximum(bins, 0), minlength=72)


def intervals_of(pixels, times_s, pixel_count):
    """Intervals of each pixel's events, and their number per pixel. The times of a pixel rise."""
    small = pixels.astype(np.uint16 if pixel_count <= 65536 else np.int64)
    order = np.argsort(small, kind="stable")
    pixels, times_s = pixels[order], times_s[order]
    same = pixels[1:] == pixels[:-1]
    return np.diff(times_s)[same], np.bincount(pixels[1:][same], minlength=pixel_count)


def poisson_noise(rate_hz, pixel_count, duration_s, rng):
    """(pixels, times) of one Poisson rate for all pixels."""
    counts = rng.poisson(rate_hz * duration_s, pixel_count)
    times_s = np.sort(rng.uniform(0, duration_s, counts.sum()))
    return rng.permutation(np.repeat(np.arange(pixel_count), counts)), times_s


def v2e_noise(light, pixel_count, duration_s, rng, *, leak_hz, spread_decades, shot_hz, mismatch):
    """(pixels, times, on) of the noise that Hu, Liu and Delbruck (CVPRW 2021) describe; light: 0..1.

    The memorised brightness leaks at a rate with a log-normal spread over pixels; noise events of both polarities are Poisson
    processes whose rate falls linearly to a quarter with light and is larger where the threshold is smaller; an event resets its pixel.
    """
    leak = leak_hz * 10 ** (spread_decades * rng.standard_normal(pixel_count))
    rates = [0.5 * shot_hz * (1 - 0.75 * light) / np.maximum(0.05, 1 + mismatch * rng.standard_normal(pixel_count)) for _ in "ab"]
    now = np.zeros(pixel_count)
    phase = rng.uniform(size=pixel_count)  # of the first leakage
    pixels, times, on = [], [], []
    alive = np.arange(pixel_count)
    while len(alive):
        with np.errstate(divide="ignore"):
            leaks = (1 - phase[alive]) / leak[alive]
            shots = [rng.exponential(size=len(alive)) / rate[alive] for rate in rates]
        phase[alive] = 0
        now[alive] += np.minimum(leaks, np.minimum(*shots))
        brighter = np.minimum(leaks, shots[0]) <= shots[1]
        within = now[alive] <= duration_s
        alive, brighter = alive[within], brighter[within]
        pixels.append(alive), times.append(now[alive]), on.append(brighter)
    return tuple(map(np.concatenate, (pixels, times, on)))


def ranks(values):
    """Ranks from 0, ties at their mean."""
    _, inverse, counts = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(counts) - (counts + 1) / 2)[inverse]


def pearson(a, b):
    a, b = np.asarray(a, float) - np.mean(a), np.asarray(b, float) - np.mean(b)
    norm = np.sqrt(np.sum(a * a) * np.sum(b * b))
    return float(np.sum(a * b) / norm) if norm > 0 else float("nan")


def spearman(a, b):
    return pearson(ranks(a), ranks(b))


def mmrv(real, simulated):
    """Mean maximum rank violation (arXiv 2405.05941): mean over i of the largest |real_i - real_j| that the simulation orders wrongly."""
    real, simulated = np.asarray(real, float), np.asarray(simulated, float)
    gaps = np.abs(real[:, None] - real[None, :])
    wrong = (simulated[:, None] < simulated[None, :]) != (real[:, None] < real[None, :])
    return float((gaps * wrong).max(axis=1).mean())


def bootstrap(statistic, a, b, draws=2000, seed=1):
    """95 % interval of statistic(a, b) over resampled pairs."""
    rng = np.random.default_rng(seed)
    a, b = np.asarray(a), np.asarray(b)
    values = [statistic(a[k], b[k]) for k in rng.integers(len(a), size=(draws, len(a)))]
    return tuple(np.nanpercentile(values, [2.5, 97.5]))


def minimise(function, start, scale, evaluations=300):
    """Nelder and Mead's simplex from `start`, first edges `scale`."""
    n = len(start)
    points = [np.array(start, float)] + [np.array(start, float) + scale[k] * np.eye(n)[k] for k in range(n)]
    values = [function(p) for p in points]
    used = n + 1
    while used < evaluations:
        order = np.argsort(values, kind="stable")
        points, values = [points[k] for k in order], [values[k] for k in order]
        middle = np.mean(points[:-1], axis=0)
        step = middle - points[-1]
        reflected = middle + step
        value = function(reflected)
        used += 1
        if value < values[0]:
            further = middle + 2 * step
            far = function(further)
            used += 1
            points[-1], values[-1] = (further, far) if far < value else (reflected, value)
        elif value < values[-2]:
            points[-1], values[-1] = reflected, value
        else:
            inner = middle + 0.5 * step if value < values[-1] else middle - 0.5 * step
            near = function(inner)
            used += 1
            if near < min(value, values[-1]):
                points[-1], values[-1] = inner, near
            else:
                points = [points[0]] + [points[0] + 0.5 * (p - points[0]) for p in points[1:]]
                values = [values[0]] + [function(p) for p in points[1:]]
                used += n
    best = int(np.argmin(values))
    return points[best], values[best]
