"""Keys given in Python as the YAML that the readers of saccade take."""

import json
import numbers

import numpy as np


def _scalar(value):
    if value is None:
        return "null"
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return np.format_float_positional(float(value), trim="0") if np.isfinite(value) else str(value)
    if hasattr(value, "__fspath__"):
        value = value.__fspath__()
    if isinstance(value, str):
        return json.dumps(value)
    raise TypeError(f"found {value!r}, expected a number, a text, True, False, None, a list or a dict of these")


def value_text(value):
    """One value on one line: 0.5, [4, 25], {kind: "events"}."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(key)}: {value_text(item)}" for key, item in value.items()) + "}"
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ", ".join(value_text(item) for item in value) + "]"
    return _scalar(value)


def _key(key):
    if not isinstance(key, str):
        raise TypeError(f"found the key {key!r}, expected a text")
    return key


def keys_text(keys):
    """A block of keys, one a line; empty for none."""
    return "".join(f"{_key(key)}: {value_text(value)}\n" for key, value in keys.items())


def assignments(keys, prefix=""):
    """Nested or dotted keys as `key.path=value`, one for each value."""
    result = []
    for key, value in keys.items():
        path = prefix + _key(key)
        if isinstance(value, dict) and value:
            result += assignments(value, path + ".")
        else:
            result.append(f"{path}={value_text(value)}")
    return result
