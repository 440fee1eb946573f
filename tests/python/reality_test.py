"""The pieces of scripts/reality: distances, likelihoods, rank correlations, models of noise; and the noise of silicon, if it is there."""
import importlib.machinery
import importlib.util
import os
import pathlib
import sys

import numpy as np
import pytest

SOURCE = pathlib.Path(os.environ["SACCADE_SOURCE"])
sys.path.insert(0, str(SOURCE / "scripts"))

import reality_robot as robot  # noqa: E402
import reality_statistics as statistics  # noqa: E402
import reality_twins as twins  # noqa: E402

DATA = SOURCE.parent / "shared/data"


def script():
    loader = importlib.machinery.SourceFileLoader("reality", str(SOURCE / "scripts/reality"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("reality", loader))
    loader.exec_module(module)
    return module


def test_ks_distance():
    assert statistics.ks_distance([1, 2, 3], [1, 2, 3]) == 0
    assert statistics.ks_distance([1, 2], [3, 4]) == 1
    assert statistics.ks_distance([0, 0, 1, 1], [0, 1, 1, 1]) == pytest.approx(0.25)
    assert statistics.ks_of_counts([2, 2], [1, 3]) == pytest.approx(0.25)
    assert statistics.ks_of_counts([0, 0], [1, 3]) == 1
    a, b = np.random.default_rng(1).normal(size=(2, 500))
    fine = np.linspace(-9, 9, 4001)
    counts = [np.histogram(v, fine)[0] for v in (a, b)]
    assert statistics.ks_of_counts(*counts) == pytest.approx(statistics.ks_distance(a, b), abs=0.01)


def test_log_likelihood():
    assert statistics.log_likelihood([3, 1], [29.5, 9.5]) == pytest.approx(0.75 * np.log(0.75) + 0.25 * np.log(0.25))
    right, wrong = statistics.log_likelihood([30, 10], [300, 100]), statistics.log_likelihood([30, 10], [100, 300])
    assert right > wrong


def test_rank_correlations():
    real = [0.1, 0.5, 0.9, 0.4]
    assert statistics.spearman(real, [1, 3, 4, 2]) == pytest.approx(1)
    assert statistics.spearman(real, [-1, -3, -4, -2]) == pytest.approx(-1)
    assert statistics.pearson([0, 1, 2], [1, 3, 5]) == pytest.approx(1)
    assert list(statistics.ranks([5, 1, 5])) == [1.5, 0, 1.5]
    assert statistics.mmrv(real, [1, 3, 4, 2]) == 0
    # The simulation swaps the first two: each violates by .4, the others by nothing.
    assert statistics.mmrv([0.1, 0.5, 0.9], [2, 1, 3]) == pytest.approx((0.4 + 0.4 + 0) / 3)
    low, high = statistics.bootstrap(statistics.spearman, np.arange(30), np.arange(30) + np.tile([0, 3, -3], 10))
    assert 0.7 < low < high <= 1


def test_search_finds_a_minimum():
    found, value = statistics.minimise(lambda x: (x[0] - 3) ** 2 + 10 * (x[1] + x[0]) ** 2, [0, 0], [1, 1], 400)
    assert found == pytest.approx([3, -3], abs=1e-3) and value < 1e-6


def test_models_of_noise():
    rng = np.random.default_rng(1)
    pixels, times = statistics.poisson_noise(2.0, 2000, 10.0, rng)
    intervals, counts = statistics.intervals_of(pixels, times, 2000)
    assert len(pixels) / 2000 / 10 == pytest.approx(2.0, rel=0.02)
    assert counts.sum() == len(intervals) and np.all(intervals >= 0)
    assert intervals.std() / intervals.mean() == pytest.approx(1.0, abs=0.1)
    # Leak alone is regular and ON; shot noise falls to a quarter and has both polarities.
    pixels, times, on = statistics.v2e_noise(0.5, 500, 100.0, rng, leak_hz=0.5, spread_decades=0.0, shot_hz=0.0, mismatch=0.0)
    assert on.all()
    assert statistics.intervals_of(pixels, times, 500)[0] == pytest.approx(2.0)
    for light, factor in ((0.0, 1.0), (1.0, 0.25)):
        pixels, _, on = statistics.v2e_noise(light, 2000, 20.0, rng, leak_hz=0.0, spread_decades=0.0, shot_hz=4.0, mismatch=0.0)
        assert len(pixels) / 2000 / 20 == pytest.approx(4 * factor, rel=0.03)
        assert on.mean() == pytest.approx(0.5, abs=0.02)


def test_fit_finds_the_noise_that_made_the_data():
    module = script()
    made = module.emulated({"leak_rate_hz": 0.3, "leak_spread_decades": 0.2}, 161.0, 20.0, seed=9)["pos"]
    measured = type("M", (), {"counts": made[0], "intervals": made[1]})()
    keys = [("leak_rate_hz", 0.1, 2.3), ("leak_spread_decades", 0.1, 1.0)]
    found = module.fitted(module.emulated, keys, {("pos", "161lux"): measured}, {"161lux": 20.0}, 40, 1)
    assert found["leak_rate_hz"] == pytest.approx(0.3, rel=0.1)
    ks_rates, ks_intervals, *_ = module.judged(measured, module.emulated(found, 161.0, 20.0, seed=3, copies=4)["pos"])
    assert ks_rates < 0.08 and ks_intervals < 0.15


def test_quantities_of_a_twin():
    # A disc of radius 8 that goes to the right at 100 px/s: the swept area is 4 r v t.
    t = np.arange(0, 500_001, 20_000)
    rows = np.stack([t, 20 + 1e-4 * t, np.full(len(t), 32.0), np.full(len(t), 8.0)], axis=1)
    path = twins.Path2D(rows, 0.0)
    circle, slope, known = path.at(250_000)
    assert known and circle == pytest.approx([45, 32, 8]) and slope == pytest.approx([100, 0, 0])
    recording = twins.Recording("made", "", (96, 64), (5, 12), "ideal", 0.0, 1.0, 2000)
    values = dict(twins.PRIOR, contrast=-0.7, refractory_us=0, cutoff_hz=0.0, shot_hz=0.0, leak_hz=0.0)
    events = twins.twin(recording, path, values, 0, 500_001)
    found = dict(zip(twins.QUANTITIES, twins.quantities(events, path, recording.size, 100_000, 400_000)))
    # ln(100 / 50) / .2: three events for every crossing of a pixel.
    assert found["events of the outline per px²"] == pytest.approx(3, rel=0.15)
    assert found["ON to OFF"] == pytest.approx(1, abs=0.15)
    assert found["noise, per px² and s"] == 0
    assert twins.polarity_sign(events, path, 0, 500_000) == -1


def test_loop_with_delay():
    values = {"gain": 3.0, "delay_s": 0.05, "scale": 0.3, "reach_px_s": 500.0}
    slow, late = robot.simulated(values, [240, 240], [0.0, 0.4])
    assert slow[1] > 2 * slow[0] and late[1] > 2 * late[0]
    # A ramp is followed at its speed over the gain.
    quiet, error = robot.simulated(dict(values, gain=2.0, delay_s=0.0), [240], [0.0], duration_s=3.0)
    assert error[0] == pytest.approx(0.3 * 240 / 2.0, rel=0.25)
    assert robot.boundary([0, 5, 10, 15], [False, False, True, True]) == 10
    assert robot.boundary([0, 5, 10], [False, False, False]) == np.inf


def test_outcome_of_a_run():
    t = np.arange(0, 10, 0.01)
    assert not robot.outcome(np.stack([t, 30 * np.sin(5 * t)], axis=1))[0]
    assert robot.outcome(np.stack([t, np.where(t < 5, 30 * np.sin(5 * t), 20.0)], axis=1))[0]
    assert robot.outcome(np.stack([t, 20 * t], axis=1))[0]


def test_sensor_file():
    import saccade

    lines = (SOURCE / "scenarios/sensors/silicon_noise.yaml").read_text().splitlines()
    pairs = [line.split(":") for line in lines if line.startswith("  ")]
    keys = {name.strip(): value.strip() if name.strip() == "preset" else float(value) for name, value in pairs}
    rates = []
    for light in (255 * 0.1 / 3000, 255 * 161 / 3000, 255.0):
        emulator = saccade.Emulator((50, 50), seed=1, readout_rate_hz=0, **keys)
        image = np.full((50, 50), light, np.float32)
        emulator.process(image, t_us=0)
        rates.append(len(emulator.process(image, t_us=10_000_000)) / 2500 / 10)
    assert 9 < rates[0] < 14  # 11.0 measured, both polarities
    assert rates[1] < rates[2] < 0.6


def test_silicon():
    if not DATA.is_dir():
        pytest.skip(f"Skipped: found no measured data in {DATA}")
    module = script()
    measured = {("pos", level): module.Measured(DATA, "pos", level) for level in module.LUX}
    assert {key[1]: int((m.counts > 0).sum()) for key, m in measured.items()} == {"0.1lux": 2499, "161lux": 850, "3klux": 2366}
    seconds = module.durations(measured)
    assert all(8 < s < 25 for s in seconds.values())
