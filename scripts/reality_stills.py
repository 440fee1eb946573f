"""Scenes at rest: `saccade fit-sensor --still` on emulated sensors of known thresholds, on recordings and on silicon's noise."""
import json
import math
import subprocess
import tempfile
from pathlib import Path

import numpy as np

import saccade

NOISE = 0.05  # standard deviation of log luminance of the emulated light
SIDE = 12
SECONDS = 4.0
RECORDINGS = [  # name, file, region at rest
    ("hand_wave, top", "hand_wave_dvs128_lz4.aedat4", (0, 0, 128, 30)),
    ("hand_wave, top left", "hand_wave_dvs128_lz4.aedat4", (0, 0, 64, 30)),
    ("hand_wave, top right", "hand_wave_dvs128_lz4.aedat4", (64, 0, 64, 30)),
    ("hand_wave, bottom right", "hand_wave_dvs128_lz4.aedat4", (60, 112, 68, 16)),
    ("ball_looming, top", "ball_looming_dvs128_aedat2.aedat", (0, 0, 128, 12)),
]


def made_sensor(seed):
    rng = np.random.default_rng(seed)
    draw = lambda low, high: float(np.exp(rng.uniform(np.log(low), np.log(high))))
    ratio, both, time_constant_s = draw(0.8, 1.25), draw(3.0, 4.0), draw(1e-3, 3e-3)
    return {"on": both * math.sqrt(ratio), "off": both / math.sqrt(ratio), "on_over_off": ratio, "refractory_s": round(draw(1e-4, 2e-3), 6),
            "cutoff_hz": 1 / (2 * math.pi * time_constant_s)}


def record(sensor, seed, path):
    """Events of the emulator before light with Gaussian noise behind a low-pass, in steps of a hundredth of its time constant."""
    rng = np.random.default_rng(seed)
    step_us = max(1, round(1e6 / (2 * math.pi * sensor["cutoff_hz"]) / 100))
    kept = np.float32(math.exp(-1e-6 * step_us * 2 * math.pi * sensor["cutoff_hz"]))
    fresh = np.float32(math.sqrt(1 - kept**2))
    emulator = saccade.Emulator((SIDE, SIDE), seed=seed, preset="ideal", contrast_threshold_on=sensor["on"] * NOISE,
                                contrast_threshold_off=sensor["off"] * NOISE, refractory_us=round(1e6 * sensor["refractory_s"]),
                                leak_rate_hz=0.05)
    level, found = rng.standard_normal((SIDE, SIDE), np.float32), []
    for t_us in range(0, round(1e6 * SECONDS), step_us):
        events = emulator.process(np.exp(NOISE * level) * np.float32(100), t_us=t_us)
        if len(events):
            found.append(events.copy())
        level = kept * level + fresh * rng.standard_normal((SIDE, SIDE), np.float32)
    events = np.concatenate(found)
    lines = [f"{t},{x},{y},{int(p)}\n" for t, x, y, p in zip(events["t"], events["x"], events["y"], events["p"])]
    path.write_text("t_us,x,y,p\n" + "".join(lines))


def fitted(program, recording, folder, stimulus=None, size=None):
    """The block `still` of fit.json."""
    words = [program, "fit-sensor", recording, "--still", "--out", folder, "--force"]
    words += ["--stimulus", stimulus] if stimulus else []
    words += ["--size", size] if size else []
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    if done.returncode:
        raise ValueError(done.stderr.strip())
    return next(iter(json.loads((folder / "fit.json").read_text())["still"].values()))


def text(quantity, digits=2):
    if quantity is None:
        return "not identifiable"
    return f"{quantity['value']:.{digits}f} ({quantity['low']:.{digits}f} to {quantity['high']:.{digits}f})"


def chain_rates(on, off, refractory, spacing=0.25):
    """ON and OFF events per time constant of noise with thresholds `on` and `off` deviations from a reference, without leak.

    Mean passages by linear equations; saccade solves them in time by eigenvectors.
    """
    farthest = max(on, off) + 2.5
    references = np.arange(-farthest, farthest + spacing, spacing)
    up, down = math.ceil(on / spacing), math.ceil(off / spacing)
    steps = np.concatenate([off / down * np.arange(-down, 0), on / up * np.arange(up + 1)])
    share, mean = np.empty(len(references)), np.empty(len(references))
    for i, reference in enumerate(references):
        x = reference + steps
        potential = 0.5 * (x**2 - reference**2)
        middle = 0.5 * ((0.5 * (x[1:] + x[:-1]))**2 - reference**2)
        resistance = np.diff(x) * (np.exp(potential[1:]) + 4 * np.exp(middle) + np.exp(potential[:-1])) / 6
        mass = np.exp(-potential[1:-1]) * 0.5 * (x[2:] - x[:-2])
        conductance = 1 / resistance
        matrix = np.diag(conductance[1:] + conductance[:-1]) - np.diag(conductance[1:-1], 1) - np.diag(conductance[1:-1], -1)
        mean[i] = np.linalg.solve(matrix, mass)[down - 1]
        share[i] = resistance[:down].sum() / resistance.sum()
    kept = math.exp(-refractory)
    spread = max(math.sqrt(1 - kept**2), 0.4 * spacing)
    edges = np.concatenate([[-np.inf], 0.5 * (references[1:] + references[:-1]), [np.inf]])
    normal = np.vectorize(lambda z: 0.5 * math.erfc(-z / math.sqrt(2)))
    landing = [np.diff(normal((edges[None, :] - kept * (references + step)[:, None]) / spread), axis=1) for step in (on, -off)]
    chain = share[:, None] * landing[0] + (1 - share)[:, None] * landing[1]
    matrix = chain.T - np.eye(len(references))
    matrix[0] = 1
    after = np.linalg.solve(matrix, np.eye(len(references))[0])
    per_interval = 1 / (refractory + after @ mean)
    return per_interval * (after @ share), per_interval * (after @ (1 - share))


def ratios_of_rates(on_hz, off_hz, cutoff_hz, refractory_s):
    """The thresholds over the noise that give these rates with this bandwidth."""
    time_constant_s = 1 / (2 * math.pi * cutoff_hz)

    def both_of(log_ratio):
        low, high = 1.2, 6.0
        for _ in range(12):
            both = 0.5 * (low + high)
            rates = chain_rates(both * math.exp(0.5 * log_ratio), both * math.exp(-0.5 * log_ratio), refractory_s / time_constant_s)
            low, high = (both, high) if sum(rates) / time_constant_s > on_hz + off_hz else (low, both)
        return both, rates[0] / sum(rates)

    low, high = -0.5, 0.5
    for _ in range(10):
        log_ratio = 0.5 * (low + high)
        both, share = both_of(log_ratio)
        low, high = (log_ratio, high) if share > on_hz / (on_hz + off_hz) else (low, log_ratio)
    return both * math.exp(0.5 * log_ratio), both * math.exp(-0.5 * log_ratio)


def compare(folder, options, silicon):
    """`silicon`: ON and OFF events per pixel and second at .1 lx."""
    made, found = [], []
    with tempfile.TemporaryDirectory(prefix="stills_") as place:
        place = Path(place)
        for seed in range(1, 7):
            sensor, path = made_sensor(seed), place / f"made_{seed}.csv"
            record(sensor, seed, path)
            fit = fitted(options.saccade, path, place / "fit", size=f"{SIDE}x{SIDE}")
            made.append([str(seed)] + [cell for key, digits in (("on", 2), ("off", 2), ("on_over_off", 2), ("cutoff_hz", 0))
                                       for cell in (f"{sensor[key]:.{digits}f}", text(fit[key], digits))])
            print(made[-1], flush=True)
        for name, file, region in RECORDINGS:
            stem = Path(file).stem
            stimulus = place / "shown.yaml"
            stimulus.write_text(f"stimuli:\n  {stem}: {{kind: still, region_px: {list(region)}}}\n")
            fit = fitted(options.saccade, folder / file, place / "fit", stimulus)
            found.append([name, f"{fit['on_events']}, {fit['off_events']}", f"{fit['misfit']:.1f}"]
                         + [text(fit[key], digits) for key, digits in (("on", 2), ("off", 2), ("on_over_off", 2), ("cutoff_hz", 0))])
            print(found[-1], fit["limit"], flush=True)
    rates = [[f"{cutoff_hz:g}", *(f"{r:.2f}" for r in ratios_of_rates(*silicon, cutoff_hz, 5e-4))] for cutoff_hz in (10, 100, 1000)]
    names = ["ON threshold / noise", "OFF threshold / noise", "ON / OFF", "bandwidth, Hz"]
    return {"made": {"columns": ["seed", *(c for n in names for c in (n, "fitted"))], "rows": made},
            "recordings": {"left": True, "columns": ["at rest", "ON, OFF events", "rms residual", *names], "rows": found},
            "silicon": {"columns": ["bandwidth, if it is, Hz", "ON threshold / noise at .1 lx", "OFF"], "rows": rates}}
