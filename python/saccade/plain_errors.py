"""Messages about arguments of wrong types, in place of the C++ signatures that pybind11 prints."""

import functools
import numbers
import os
import re

import numpy as np

from . import _saccade

# Functions of the compiled part by the name under which they are called.
_NAMES = {"Simulation": "Env", "outline": "Env", "Replay": "replay", "_detect": "detect", "camera_of_size": "detector", "open_recording": "open",
          "pinhole_camera": "camera"}


def shown(value):
    """A value for a message, short."""
    text = repr(value)
    kind = type(value).__name__
    return kind if len(text) > 40 or text.startswith("<") else f"{text} ({kind})"


def _is_whole(value):
    return isinstance(value, numbers.Integral) and -2**63 <= int(value) < 2**64


def _array_of(kind):
    """Shape (m, 3), (m, 1) or (3, 1) of "numpy.ndarray[numpy.float64[m, 3]]"; none where it has none."""
    shape = re.search(r"\[(\w+), (\w+)\]", kind)
    return None if shape is None else [None if n in ("m", "n") else int(n) for n in shape.groups()]


def _fits_array(value, shape):
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        return False
    if shape is None:
        return True
    if shape[1] == 1:
        return array.ndim in (1, 2) and shape[0] in (None, array.size)
    return array.ndim == 2 and array.shape[1] == shape[1]


def _rule(kind):
    """Whether a value is of a type that pybind11 names, and that type in words."""
    if kind.startswith("Optional["):
        fits, words = _rule(kind[len("Optional["):-1])
        return (lambda value: value is None or fits(value)), f"{words}, or None"
    if kind.startswith("numpy.ndarray"):
        shape = _array_of(kind)
        if shape is None:
            words = "an array of numbers"
        elif shape[1] == 1:
            words = "an array of numbers" if shape[0] is None else f"{shape[0]} numbers"
        else:
            words = f"an array of numbers of shape (N, {shape[1]})"
        return (lambda value: _fits_array(value, shape)), words
    simple = {
        "int": (_is_whole, "a whole number"),
        "float": (lambda value: isinstance(value, numbers.Real), "a number"),
        "bool": (lambda value: isinstance(value, (bool, np.bool_)), "True or False"),
        "str": (lambda value: isinstance(value, str), "a text"),
        "os.PathLike": (lambda value: isinstance(value, (str, bytes, os.PathLike)), "a path"),
        "tuple[int, int]": (lambda value: np.ndim(value) == 1 and len(value) == 2 and all(map(_is_whole, value)),
                            "two whole numbers, (width, height)"),
        "object": (lambda value: True, "an object"),
    }
    kind = kind.replace("Tuple[", "tuple[")  # of pybind11 before 2.13
    if kind in simple:
        return simple[kind]
    name = re.split(r"\.|::", kind)[-1]
    known = getattr(_saccade, name, None)
    if isinstance(known, type):
        return (lambda value: isinstance(value, known)), f"a saccade.{name}"
    return (lambda value: True), kind


def _parameters(documentation):
    """(name, type) of each argument in the signatures of a docstring, `self` left out."""
    signature = re.search(r"\((.*)\) ->", documentation or "")
    parts, depth, start = [], 0, 0
    text = (signature.group(1) if signature else "") + ","
    for i, character in enumerate(text):
        depth += (character == "[") - (character == "]")
        if character == "," and depth == 0:
            parts.append(text[start:i].strip())
            start = i + 1
    pairs = [part.split(" = ")[0].split(": ", 1) for part in parts if ": " in part]
    return [(name, kind) for name, kind in pairs if name != "self"]


def _message(name, documentation, arguments, named):
    parameters = _parameters(documentation)
    given = {**dict(zip([p for p, _ in parameters], arguments)), **named}
    for parameter, kind in parameters:
        fits, words = _rule(kind)
        if parameter in given and not fits(given[parameter]):
            return f"{name}: {parameter}: found {shown(given[parameter])}, expected {words}"
    found = ", ".join([shown(value) for value in arguments] + [f"{key}={shown(value)}" for key, value in named.items()])
    expected = ", ".join(f"{parameter}: {_rule(kind)[1]}" for parameter, kind in parameters)
    return f"{name}: found the arguments ({found}), expected ({expected})"


def _plain(function, name, of_object):
    @functools.wraps(function)
    def call(*arguments, **named):
        try:
            return function(*arguments, **named)
        except TypeError as error:
            if not re.search(r"incompatible (function|constructor) arguments", str(error)):
                raise
        raise TypeError(_message(name, function.__doc__, arguments[of_object:], named))

    return call


def install():
    """Wraps what the compiled part offers."""
    for name, thing in list(vars(_saccade).items()):
        if isinstance(thing, type):
            for member, function in list(vars(thing).items()):
                if type(function).__name__ != "instancemethod":
                    continue
                owner = _NAMES.get(name, name)
                place = _NAMES.get(member, owner if member == "__init__" else f"{owner}.{member}")
                setattr(thing, member, _plain(getattr(thing, member), place, 1))
        elif type(thing).__name__ == "builtin_function_or_method":
            setattr(_saccade, name, _plain(thing, _NAMES.get(name, name), 0))
