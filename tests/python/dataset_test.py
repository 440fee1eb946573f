"""saccade.Dataset: windows and labels against the files of the runs, in one process and in several."""

import json
import multiprocessing

import numpy as np
import pytest
import saccade
from common import SOURCE, run_program

FILE = f"""
name: tiny
scenario: {SOURCE}/scenarios/look_at_ball.yaml
set:
  run.duration_s: 0.105
  render.max_interval_ms: 5
  output.labels: true
  ball.trajectory.start_s: 0
  output.ground_truth: {{rate_hz: 50, depth: true, format: npz}}
splits:
  train: {{axes: {{seed: {{seeds: 3}}}}}}
  test: {{set: {{eyes: both, ball.present: true}}, axes: {{seed: [9]}}}}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("data")
    (path / "set.yaml").write_text(FILE)
    run_program("dataset", path / "set.yaml", "--out", path / "set")
    return path / "set"


def events_of(data, run):
    return np.load(f"{data.folder}/{data.runs[run]['folder']}/events.npy")


def truth_of(data, run, name="truth.csv"):
    return np.genfromtxt(f"{data.folder}/{data.runs[run]['folder']}/{name}", delimiter=",", names=True)


def same(a, b):
    assert a.keys() == b.keys()
    for key, value in a.items():
        assert np.array_equal(value, b[key]) if isinstance(value, np.ndarray) else value == b[key] or key in ("truth", "ground_truth")


def test_windows_by_time_hold_each_event_once_and_end_with_the_circle_of_that_instant(folder):
    data = saccade.Dataset(folder, split="train", duration_us=10_000)
    assert data.splits == ["train", "test"] and len(data.runs) == 3 and data.size == (128, 128)
    assert len(data) == 3 * 10, "what remains of 105 ms is left out"
    windows = list(data)
    assert len(windows) == len(data)
    for i, window in enumerate(windows):
        same(window, data[i])
        assert window["run"] == i // 10 and window["end_us"] == window["begin_us"] + 10_000 == (i % 10 + 1) * 10_000
        t = window["events"]["t"]
        assert ((t > window["begin_us"]) & (t <= window["end_us"])).all()
        row = truth_of(data, window["run"])[window["end_us"] // 1000 - 1]
        assert window["truth"]["t_us"] == row["t_us"] == window["end_us"]
        for name in ("x_px", "y_px", "r_px", "visible", "x_m", "z_m"):
            assert window["truth"][name] == row[name] and row["r_px"] > 5
    for run in range(3):
        events = events_of(data, run)
        assert len(events) == data.runs[run]["events"] > 1000
        together = np.concatenate([w["events"] for w in windows if w["run"] == run])
        assert np.array_equal(together, events[events["t"] <= 100_000])
    assert windows[-1]["events"].dtype.names == ("x", "y", "t", "p")
    assert data[-1]["run"] == 2 and saccade.as_events(data[-1]["events"]).dtype == saccade.event_dtype


def test_the_events_are_those_of_saccade_run(folder, tmp_path):
    data = saccade.Dataset(folder, split="train", duration_us=1000)
    run_program("run", f"{folder}/{data.runs[1]['folder']}/scenario.yaml", "--out", tmp_path / "run")
    events, expected = events_of(data, 1), saccade.read(tmp_path / "run" / "events.npz")
    assert all(np.array_equal(events[field], expected[field]) for field in ("x", "y", "t", "p"))


def test_windows_by_count_end_at_their_last_event(folder):
    data = saccade.Dataset(folder, split="train", count=500)
    assert len(data) == sum(run["events"] // 500 for run in data.runs)
    for window in data:
        assert len(window["events"]) == 500 and window["end_us"] == window["events"]["t"][-1]
        assert abs(window["truth"]["t_us"] - window["end_us"]) <= 500
    first = [w for w in data if w["run"] == 0]
    assert np.array_equal(np.concatenate([w["events"] for w in first]), events_of(data, 0)[:500 * len(first)])


def test_labels_of_events_and_ground_truth_of_pixels(folder):
    data = saccade.Dataset(folder, split="train", duration_us=10_000, event_labels=True, ground_truth=True)
    assert data.causes[0] == "signal" and data.objects[:2] == ["background", "ball"]
    own = 0
    for window in data:
        assert len(window["cause"]) == len(window["object"]) == len(window["events"])
        depth = window["ground_truth"]
        assert depth is None if window["end_us"] < 20_000 else window["end_us"] - 20_000 < depth["t_us"] <= window["end_us"]
        events, t = window["events"][window["object"] == data.objects.index("ball")], window["truth"]
        own += len(events)
        distance = np.hypot(events["x"] - t["x_px"], events["y"] - t["y_px"])
        assert (distance < t["r_px"] + 4).all(), "events of the ball are at its circle"
    assert own > 100


def test_the_right_camera_has_events_circles_and_labels_of_its_own(folder):
    left, right = (saccade.Dataset(folder, split="test", duration_us=100_000, camera=c, event_labels=True) for c in (0, 1))
    events = events_of(right, 0)
    inside = events["t"] <= 100_000
    for data, camera, table in ((left, 0, "truth.csv"), (right, 1, "truth_right.csv")):
        window = data[0]
        assert np.array_equal(window["events"], events[inside & (events["camera"] == camera)]) and len(window["events"]) > 100
        assert window["truth"]["x_px"] == truth_of(data, 0, table)["x_px"][99]
        assert len(window["cause"]) == len(window["events"])
    assert len(saccade.Dataset(folder, split="test", count=10, camera=1)) == (events["camera"] == 1).sum() // 10
    with pytest.raises(ValueError, match="found one camera, expected the right one too"):
        saccade.Dataset(folder, split="train", duration_us=1000, camera=1)[0]


def figure(window):
    return window["run"], window["end_us"], len(window["events"]), int(window["events"]["x"].astype(int).sum()), float(window["truth"]["x_px"])


def by_index(job):
    data, indices = job
    return [figure(data[i]) for i in indices]


def by_part(job):
    data, worker, workers = job
    part = data.part(worker, workers)
    return [(part.runs[w["run"]]["folder"], *figure(w)[1:]) for w in part]


@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_several_workers_read_what_one_reads(folder, method):
    data = saccade.Dataset(folder, split="train", duration_us=5_000)
    expected = [figure(window) for window in data]
    data[0]  # files that are open here are no hindrance
    order = np.random.default_rng(3).permutation(len(data))
    with multiprocessing.get_context(method).Pool(2) as pool:
        found = sum(pool.map(by_index, [(data, order[0::2]), (data, order[1::2])]), [])
        parts = sum(pool.map(by_part, [(data, 0, 2), (data, 1, 2)]), [])
    assert found == [expected[i] for i in [*order[0::2], *order[1::2]]]
    assert sorted(parts) == sorted((data.runs[run]["folder"], *rest) for run, *rest in expected)


def test_a_run_without_events_has_empty_windows(folder, tmp_path):
    (tmp_path / "set.yaml").write_text(FILE.split("splits")[0] + "  ball.present: false\n  emulator.preset: ideal\n  gaze.detector: none\n"
                                       "splits: {still: {axes: {seed: [1]}}}\n")
    run_program("dataset", tmp_path / "set.yaml", "--out", tmp_path / "set")
    data = saccade.Dataset(tmp_path / "set", duration_us=50_000, event_labels=True)
    assert data.runs[0]["events"] == 0 and [len(w["events"]) for w in data] == [0, 0]
    assert np.isnan(data[0]["truth"]["x_px"]) and data[0]["truth"]["visible"] == 0


def test_bad_arguments_and_folders_raise_with_place_value_and_expectation(folder, tmp_path):
    for arguments, message in (({}, "both or none of count and duration_us"), ({"count": 0}, "count: found 0"),
                               ({"duration_us": 1.5}, "duration_us: found 1.5"), ({"count": 1, "split": "trial"}, "found no split 'trial'"),
                               ({"count": 1, "camera": 2}, "camera: found 2"), ({"duration_us": 10**6}, "expected at most 105000")):
        with pytest.raises(ValueError, match=message):
            saccade.Dataset(folder, **arguments)
    with pytest.raises(ValueError, match="found no card.json, expected the folder of a data set"):
        saccade.Dataset(tmp_path, count=1)
    (tmp_path / "card.json").write_text("{}")
    with pytest.raises(ValueError, match="expected the card of a data set"):
        saccade.Dataset(tmp_path, count=1)
    card = json.loads((folder / "card.json").read_text())
    (tmp_path / "card.json").write_text(json.dumps(card))
    with pytest.raises(ValueError, match="`saccade dataset check` lists what is missing"):
        saccade.Dataset(tmp_path, count=1, split="train")[0]
    with pytest.raises(IndexError):
        saccade.Dataset(folder, count=100)[10**9]
