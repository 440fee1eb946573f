"""Conversions between arrays and what the compiled part takes."""

import json

import numpy as np

from . import _saccade

event_dtype = _saccade.event_dtype


def as_events(events, time_unit=None):
    """The events as a contiguous array of event_dtype; the same array where it is one.

    `events`: a structured array with the fields x, y, p, t and optionally camera, in any order in memory and of any numbers;
    other names of them, titles, and units in the name of the time (t_ns) as in NumPy files. p is True or greater than 0 for
    ON. time_unit: s, ms, us or ns; without it and without a unit in the name, whole times are us and floating-point ones s,
    where these are plausible. Raises ValueError for other arrays and for values that event_dtype cannot hold.
    """
    array = np.asarray(events)
    if array.dtype == event_dtype and array.ndim == 1 and time_unit in (None, "us"):
        return np.ascontiguousarray(array)
    fields = _event_fields(array.dtype) if array.ndim == 1 else {}
    if not {"x", "y", "p", "t"} <= set(fields):
        raise ValueError(f"events: found an array of shape {array.shape} and dtype {array.dtype}, "
                         "expected one dimension and the fields x, y, p and t")
    result = np.zeros(len(array), event_dtype)
    for field in ("x", "y", "camera"):
        if field in fields:
            result[field] = _whole_numbers(array[fields[field][0]], field)
    name, unit = fields["t"]
    result["t"] = _times(array[name], time_unit or unit)
    polarity = array[fields["p"][0]]
    if polarity.dtype.kind not in "biuf" or (polarity.dtype.kind == "f" and np.isnan(polarity).any()):
        raise ValueError(f"events: found p of {_first_bad(polarity)}, expected truth values or numbers")
    result["p"] = polarity > 0
    return result


def _event_fields(dtype):
    """The fields of an array that are those of events: their names in it, and the unit or \"\"."""
    fields = {}
    for name in dtype.names or ():
        title = dtype.fields[name][2] if len(dtype.fields[name]) > 2 else ""
        known = _saccade.event_column(name) or _saccade.event_column(str(title))
        if known and known[0] not in fields:
            fields[known[0]] = (name, known[1])
    return fields


def _first_bad(values):
    if values.dtype.kind == "f":
        bad = values[~(np.isfinite(values) & (values == np.rint(values)))]
        if len(bad):
            return str(bad[0])
    return f"dtype {values.dtype}"


def _whole_numbers(values, field):
    limits = np.iinfo(event_dtype[field])
    if values.dtype.kind not in "biuf" or (values.dtype.kind == "f" and not (values == np.rint(values)).all()):
        raise ValueError(f"events: found {field} of {_first_bad(values)}, expected whole numbers")
    if len(values) and (values.min() < limits.min or values.max() > limits.max):
        raise ValueError(f"events: found {field} from {values.min()} to {values.max()}, "
                         f"expected values from {limits.min} to {limits.max}")
    return values


def _times(values, unit):
    """Times in us as int64."""
    if values.dtype.kind in "mM":
        stored, step = np.datetime_data(values.dtype)
        if stored not in ("s", "ms", "us", "ns") or step != 1 or np.isnat(values).any():
            raise ValueError(f"events: found t of {values.dtype} or without a time, "
                             "expected times of s, ms, us or ns")
        values, unit = values.astype(values.dtype.newbyteorder("=")).view("i8"), stored
    if values.dtype.kind not in "iuf":
        raise ValueError(f"events: found t of dtype {values.dtype}, expected numbers")
    if values.dtype.kind == "u" and len(values) and int(values.max()) > np.iinfo("i8").max:
        raise ValueError(f"events: found t up to {values.max()}, expected times below 2^63")
    return _saccade.times_in_us(values, unit or "")


def _column(table, names, field, default=None):
    if field in names:
        return np.asarray(table[field])
    if default is None:
        raise ValueError(f"table: found the columns {', '.join(names)}, expected {field} too")
    return default


def _columns(table):
    """Columns by name of a structured array, a dict of columns, or a list of dicts."""
    if isinstance(table, (list, tuple)):
        if not table:
            raise ValueError("table: found no rows, expected at least one")
        table = {name: [row[name] for row in table] for name in table[0]}
    names = list(table.dtype.names or ()) if isinstance(table, np.ndarray) else list(table)
    t_us = np.atleast_1d(_column(table, names, "t_us"))
    circles = np.stack([np.atleast_1d(np.asarray(_column(table, names, f), dtype=float))
                        for f in ("x_px", "y_px", "r_px")], axis=-1)
    if t_us.ndim != 1 or len(circles) != len(t_us):
        raise ValueError("table: found columns of different lengths, expected one value of each a row")
    return table, names, t_us, circles


def _filled(table, names, field, default, count):
    values = np.broadcast_to(_column(table, names, field, default), count)
    return values


def detections_of(table, name):
    if hasattr(table, "__fspath__") or isinstance(table, str):
        return _saccade.Detections(table)
    table, names, t_us, circles = _columns(table)
    count = len(t_us)
    detector = [str(value) for value in _filled(table, names, "detector", name, count)]
    score = np.asarray(_filled(table, names, "score", 1.0, count), dtype=float)
    held = np.asarray(_filled(table, names, "held", 0.0, count), dtype=float)
    return _saccade.Detections(t_us, detector, circles, score, held)


def truth_of(table):
    if hasattr(table, "__fspath__") or isinstance(table, str):
        return _saccade.Truth(table)
    table, names, t_us, circles = _columns(table)
    visible = np.asarray(_filled(table, names, "visible", 1.0, len(t_us)), dtype=float)
    return _saccade.Truth(t_us, circles, visible)


def score(detections, truth, threshold=None, name="mine"):
    """Scores detections against truth; see the stub or docs/python.md."""
    rows = detections_of(detections, name)
    if threshold is None:
        threshold = {}
    elif not isinstance(threshold, dict):
        threshold = {n: float(threshold) for n in rows.names}
    unknown = set(threshold) - set(rows.names)
    if unknown:
        raise ValueError(f"threshold: found {sorted(unknown)[0]}, expected one of {', '.join(rows.names)}")
    return json.loads(_saccade.score(rows, truth_of(truth), threshold, rows.names))["detectors"]


def joint_vector(joints):
    """Nine values in the order of joint_names, rad: of a dict by name (missing joints 0) or a sequence."""
    names = _saccade.joint_names
    if joints is None:
        return np.zeros(len(names))
    if isinstance(joints, dict):
        unknown = [name for name in joints if name not in names]
        if unknown:
            raise ValueError(f"joints: found {unknown[0]}, expected one of {', '.join(names)}")
        return np.array([float(joints.get(name, 0.0)) for name in names])
    vector = np.asarray(joints, dtype=float)
    if vector.shape != (len(names),):
        raise ValueError(f"joints: found an array of shape {vector.shape}, expected ({len(names)},)")
    return vector
