#!/usr/bin/env python3
"""Runs a detector written in Python for saccade (docs/external_detectors.md).

usage: saccade-detector-worker FILE.py:CLASS [key=value]...
"""

import ast
import importlib.util
import os
import sys

import numpy as np

EVENT = np.dtype({"names": ["x", "y", "p", "t", "camera"], "formats": ["<u2", "<u2", "?", "<i8", "u1"],
                  "offsets": [8, 10, 12, 0, 13], "itemsize": 16})


class Motion:
    """Pose and velocity of the camera: root_from_camera (4x4), linear_velocity_m_s and angular_velocity_rad_s (3)."""

    def __init__(self, numbers):
        self.root_from_camera = np.vstack([np.reshape(numbers[:12], (3, 4)), (0, 0, 0, 1)])
        self.linear_velocity_m_s = np.array(numbers[12:15])
        self.angular_velocity_rad_s = np.array(numbers[15:18])


def load(place, arguments, size):
    """The detector: an instance of the class with the image size and the arguments."""
    path, _, name = place.rpartition(":")
    sys.path.insert(0, os.path.dirname(os.path.abspath(path)))
    spec = importlib.util.spec_from_file_location("detector", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["detector"] = module
    spec.loader.exec_module(module)
    keywords = {}
    for argument in arguments:
        key, _, text = argument.partition("=")
        try:
            keywords[key] = ast.literal_eval(text)
        except (SyntaxError, ValueError):
            keywords[key] = text
    return getattr(module, name)(size, **keywords)


def answer_of(estimate):
    """One line for None, (x, y, r, score) or (x, y, r, score, held)."""
    if estimate is None:
        return b"none\n"
    x, y, r, score, *held = estimate
    word = " held" if held and held[0] else ""
    return f"circle {float(x)!r} {float(y)!r} {float(r)!r} {float(score)!r}{word}\n".encode()


def main():
    source, answers = sys.stdin.buffer, os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)  # what the detector prints is not an answer
    source.readline()  # the protocol's name and version
    camera = source.readline().split()
    detector = load(sys.argv[1], sys.argv[2:], (int(camera[1]), int(camera[2])))
    answers.write(f"ready {float(detector.threshold)!r} binary motion\n".encode())
    has_advance = hasattr(detector, "advance_to")
    while line := source.readline():
        _, now_us, count = line.split()
        numbers = source.readline().split()[1:]
        motion = Motion([float(n) for n in numbers]) if len(numbers) == 18 else None
        events = np.frombuffer(source.read(EVENT.itemsize * int(count)), EVENT)
        if len(events):
            detector.process(events, motion)
        if has_advance:
            detector.advance_to(int(now_us), motion)
        answers.write(answer_of(detector.estimate()))


if __name__ == "__main__":
    main()
