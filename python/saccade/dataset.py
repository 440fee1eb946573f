"""The windows of a data set that `saccade dataset` has made (docs/dataset.md)."""

import json
import os

import numpy as np

from .ground_truth import GroundTruth, npy_array, npz_arrays

_EYES = ("left", "right")
_truth_dtype = np.dtype([("t_us", "i8"), ("x_px", "f8"), ("y_px", "f8"), ("r_px", "f8"), ("visible", "f8"), ("x_m", "f8"),
                         ("y_m", "f8"), ("z_m", "f8")])


class Dataset:
    """The windows of a data set's runs: a sequence, so that len(data), data[i] and iteration work.

    folder: of the data set, with card.json. split: its name, or a list of names; None: all. Windows have `count` events each,
    or are `duration_us` long; what remains at the end of a run is left out. camera: 0 left, 1 right. ground_truth: with the
    newest instant of output.ground_truth. event_labels: with cause and object of each event (output.labels).

    A window is a dict:
      run           number of its run in `runs`
      begin_us, end_us   its events have begin_us < t <= end_us; with `count`, those of two windows may have equal times
      events        structured array with the fields x, y (px), t (us), p (True: brighter), a view of the mapped file
      truth         the row of ground truth nearest to end_us: t_us, x_px, y_px, r_px (the true circle; NaN without a ball),
                    visible (share of its disc, 0 to 1), x_m, y_m, z_m (its centre, root frame)
      ground_truth  dict of arrays by name, as GroundTruth gives them; None before the first instant
      cause, object   a number for each event: the names are in `causes` and `objects`

    Processes: an object may be passed to others, by fork and by spawn; files are opened where they are read. part(i, n)
    gives each of n workers runs of its own.
    """

    def __init__(self, folder, *, split=None, count=None, duration_us=None, camera=0, ground_truth=False, event_labels=False):
        if (count is None) == (duration_us is None):
            raise ValueError("Dataset: found both or none of count and duration_us, expected one of them")
        self._step = _whole("count" if duration_us is None else "duration_us", count if duration_us is None else duration_us)
        self._by_count = duration_us is None
        if camera not in (0, 1):
            raise ValueError(f"Dataset: camera: found {camera!r}, expected 0 (left) or 1 (right)")
        self.folder = os.fspath(folder)
        self.card = _card(self.folder)
        self._camera, self._ground_truth, self._event_labels = int(camera), bool(ground_truth), bool(event_labels)
        self.splits = list(self.card["splits"])
        wanted = self.splits if split is None else [split] if isinstance(split, str) else list(split)
        for name in wanted:
            if name not in self.splits:
                raise ValueError(f"{self.folder}: found no split {name!r}, expected one of {', '.join(self.splits)}")
        self._choose([run for run in self.card["runs"] if run["split"] in wanted])
        if len(self) == 0:
            longest = max((run["events"] if self._by_count else _end_us(run) for run in self.runs), default=0)
            unit = "events" if self._by_count else "us"
            raise ValueError(f"{self.folder}: found windows of {self._step} {unit}, expected at most {longest}, the longest run")

    def _choose(self, runs):
        """runs: entries of the card."""
        self.runs = runs
        self._starts = np.concatenate([[0], np.cumsum([self._windows_of(run) for run in runs], dtype=np.int64)])
        self._opened = {}

    def _windows_of(self, run):
        if not self._by_count:
            return _end_us(run) // self._step
        if run["cameras"] == 1:
            return run["events"] // self._step
        return int((_events(self._path(run))["camera"] == self._camera).sum()) // self._step

    def _path(self, run):
        return os.path.join(self.folder, run["folder"])

    @property
    def size(self):
        """(width, height) of the images, px; of a data set with several sizes the largest width and height."""
        return tuple(max(run["size_px"][i] for run in self.runs) for i in (0, 1))

    @property
    def causes(self):
        """Names of the numbers in a window's `cause`."""
        return _texts(self._labels(self.runs[0], "causes"), "causes")

    @property
    def objects(self):
        """Names of the numbers in a window's `object`."""
        return _texts(self._labels(self.runs[0], "objects"), "objects")

    def part(self, worker, workers):
        """The windows of every workers-th run, from run number `worker` on (0 to workers - 1)."""
        if not 0 <= worker < workers:
            raise ValueError(f"part: found worker {worker} of {workers}, expected 0 to {workers - 1}")
        other = object.__new__(Dataset)
        other.__dict__.update(self.__dict__)
        other._choose(self.runs[worker::workers])
        return other

    def __len__(self):
        return int(self._starts[-1])

    def __getitem__(self, index):
        index = range(len(self))[index]
        if isinstance(index, range):
            raise TypeError("Dataset: found a slice, expected a whole number")
        run = int(np.searchsorted(self._starts, index, side="right")) - 1
        opened = self._opened.get(run)
        if opened is None:
            opened = self._opened[run] = _Run(self, run)
        return opened.window(index - int(self._starts[run]))

    def __iter__(self):
        for number in range(len(self.runs)):
            opened = self._opened.get(number) or _Run(self, number)
            for i in range(int(self._starts[number + 1] - self._starts[number])):
                yield opened.window(i)

    def __getstate__(self):
        return {**self.__dict__, "_opened": {}}

    def _labels(self, run, *names):
        return npz_arrays(os.path.join(self._path(run), "labels.npz"), names)


class _Run:
    """The files of one run, mapped, and where its windows begin."""

    def __init__(self, data, number):
        run = data.runs[number]
        path = data._path(run)
        count = int(data._starts[number + 1] - data._starts[number])
        self._number, self._eye = number, _EYES[data._camera]
        if data._camera >= run["cameras"]:
            raise ValueError(f"{path}: found one camera, expected the right one too (eyes: both)")
        self._events = _events(path)
        if run["cameras"] > 1:
            self._events = self._events[self._events["camera"] == data._camera]
        self._edges, self._ends_us = _edges(self._events["t"], count, data._step, data._by_count)
        names = ["t_us", "target_m", *(f"{self._eye}/{name}" for name in ("circle_px", "visible"))]
        if data._event_labels:
            names += [f"{self._eye}/cause", f"{self._eye}/object"]
        labels = data._labels(run, *names)
        self._truth = _rows_at(labels, self._eye, np.asarray(self._ends_us[1:]))
        self._ground_truth = GroundTruth(path) if data._ground_truth else None
        self._labels = None
        if data._event_labels:
            if f"{self._eye}/cause" not in labels:
                raise ValueError(f"{path}: found no labels of events, expected a data set with output.labels: true")
            self._labels = labels[f"{self._eye}/cause"], labels[f"{self._eye}/object"]

    def window(self, i):
        begin, end = self._edges[i], self._edges[i + 1]
        end_us = self._ends_us[i + 1]
        window = {"run": self._number, "begin_us": self._ends_us[i], "end_us": end_us, "events": self._events[begin:end],
                  "truth": self._truth[i]}
        if self._ground_truth is not None:
            window["ground_truth"] = self._ground_truth.at(end_us)
        if self._labels is not None:
            window["cause"], window["object"] = self._labels[0][begin:end], self._labels[1][begin:end]
        return window


def _whole(name, value):
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 1:
        raise ValueError(f"Dataset: {name}: found {value!r}, expected a whole number from 1")
    return int(value)


def _card(folder):
    path = os.path.join(folder, "card.json")
    if not os.path.exists(path):
        begun = os.path.exists(os.path.join(folder, "plan.json"))
        found = "a data set without all of its runs" if begun else "no card.json"
        expected = "a whole one; the command that began it goes on" if begun else "the folder of a data set"
        raise ValueError(f"{folder}: found {found}, expected {expected}")
    try:
        with open(path, encoding="utf-8") as file:
            card = json.load(file)
        if card["schema"] != 1:
            raise ValueError(f"{path}: found schema {card['schema']}, expected 1")
        card["runs"], card["splits"]
    except (KeyError, TypeError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise ValueError(f"{path}: found {error!r}, expected the card of a data set, as saccade wrote it") from error
    return card


def _end_us(run):
    return round(run["duration_s"] * 1e6)


def _events(path):
    try:
        return npy_array(os.path.join(path, "events.npy"))
    except ValueError as error:
        raise ValueError(f"{error}; `saccade dataset check` lists what is missing") from error


def _edges(t_us, count, step, by_count):
    """Numbers of the first events of the windows and of the one after the last window, and the times between them."""
    if by_count:
        edges = np.arange(count + 1) * step
        ends = np.concatenate([[0], t_us[edges[1:] - 1]])
        return edges.tolist(), ends.tolist()
    t_us = np.ascontiguousarray(t_us)
    if len(t_us) > 1 and (t_us[1:] < t_us[:-1]).any():  # an event that comes late is in the window in which it came
        t_us = np.maximum.accumulate(t_us)
    ends = np.arange(count + 1) * step
    edges = np.searchsorted(t_us, ends, side="right")
    edges[0] = 0
    return edges.tolist(), ends.tolist()


def _rows_at(labels, eye, times_us):
    """The rows of ground truth nearest to the times."""
    t_us = labels["t_us"]
    rows = np.searchsorted(t_us, times_us)
    rows = np.clip(rows, 1, len(t_us) - 1) if len(t_us) > 1 else np.zeros(len(times_us), int)
    if len(t_us) > 1:
        rows -= times_us - t_us[rows - 1] < t_us[rows] - times_us
    truth = np.empty(len(times_us), _truth_dtype)
    truth["t_us"], truth["visible"] = t_us[rows], labels[f"{eye}/visible"][rows]
    truth["x_px"], truth["y_px"], truth["r_px"] = labels[f"{eye}/circle_px"][rows].T
    truth["x_m"], truth["y_m"], truth["z_m"] = labels["target_m"][rows].T
    return truth


def _texts(labels, name):
    if name not in labels:
        raise ValueError("found no labels of events, expected a data set with output.labels: true")
    return [text.decode() for text in labels[name]]
