#!/usr/bin/env python3
"""Runs a detector or a gaze controller written in Python for saccade (docs/external_detectors.md, external_controllers.md).

usage: saccade-worker [--listen ADDRESS] FILE.py:CLASS [key=value]...

It talks over standard input and output, or with --listen over a socket at HOST:PORT or the path of a Unix socket: each
connection has a process and an instance of its own.
"""

import ast
import importlib.util
import os
import signal
import socket
import sys
import traceback

import numpy as np

EVENT = np.dtype({"names": ["x", "y", "p", "t", "camera"], "formats": ["<u2", "<u2", "?", "<i8", "u1"],
                  "offsets": [8, 10, 12, 0, 13], "itemsize": 16})


class Motion:
    """Pose and velocity of the camera: root_from_camera (4x4), linear_velocity_m_s and angular_velocity_rad_s (3)."""

    def __init__(self, numbers):
        self.root_from_camera = np.vstack([np.reshape(numbers[:12], (3, 4)), (0, 0, 0, 1)])
        self.linear_velocity_m_s = np.array(numbers[12:15])
        self.angular_velocity_rad_s = np.array(numbers[15:18])


class Limits:
    """Of the joints that gaze commands, in the head's order: min_rad, max_rad, speed_rad_s."""

    def __init__(self, numbers):
        self.min_rad, self.max_rad, self.speed_rad_s = np.reshape(numbers, (3, -1))


def load(place, arguments, first):
    """An instance of the class with its first argument and the keyword arguments."""
    here = os.path.dirname(os.path.realpath(__file__))
    for folder in ("../python", "../../lib/python3/dist-packages"):  # the module saccade, where it was built or installed
        sys.path.append(os.path.normpath(os.path.join(here, folder)))
    path, _, name = place.rpartition(":")
    sys.path.insert(0, os.path.dirname(os.path.abspath(path)))
    spec = importlib.util.spec_from_file_location("own", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["own"] = module
    spec.loader.exec_module(module)
    keywords = {}
    for argument in arguments:
        key, _, text = argument.partition("=")
        try:
            keywords[key] = ast.literal_eval(text)
        except (SyntaxError, ValueError):
            keywords[key] = text
    return getattr(module, name)(first, **keywords)


def answer_of(estimate):
    """One line for None, (x, y, r, score), (x, y, r, score, held) or (x, y, r, score, held, covariance)."""
    if estimate is None:
        return b"none\n"
    x, y, r, score, *more = estimate
    word = " held" if more and more[0] else ""
    if len(more) > 1 and more[1] is not None:
        xx, xy, xr, yy, yr, rr = map(float, more[1])
        word += f" covariance {xx!r} {xy!r} {xr!r} {yy!r} {yr!r} {rr!r}"
    return f"circle {float(x)!r} {float(y)!r} {float(r)!r} {float(score)!r}{word}\n".encode()


def run_detector(detector, source, answers):
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


def run_controller(controller, source, answers):
    answers.write(b"ready\n")
    while line := source.readline():
        words = line.split()[1:]
        joints = len(words) - (2 if words[-1] in (b"none", b"rest") else 4)
        dt_s, joints_rad = float(words[0]), np.array([float(w) for w in words[1:1 + joints]])
        target_m = np.array([float(w) for w in words[1 + joints:]]) if len(words) == joints + 4 else None
        if words[-1] == b"rest":
            controller.rest()
        reference_rad = controller.step(joints_rad, target_m, dt_s)
        answers.write(b"reference" + b"".join(b" " + repr(float(a)).encode() for a in reference_rad) + b"\n")


def reason_of(error):
    """One line: what was raised, and where."""
    text = " ".join(f"{type(error).__name__}: {error}".split())[:400]
    frames = traceback.extract_tb(error.__traceback__)
    own = frames and not frames[-1].filename.startswith("<") and frames[-1].filename != os.path.realpath(__file__)
    if own and not isinstance(error, SyntaxError):
        text += f" ({os.path.basename(frames[-1].filename)}, line {frames[-1].lineno})"
    return text


def run(source, answers, place, arguments):
    try:
        answer_all(source, answers, place, arguments)
    except Exception as error:
        traceback.print_exc()
        sys.stderr.flush()  # saccade ends this program once it has the answer
        try:
            answers.write(f"failed {reason_of(error)}\n".encode())
        except OSError:  # nobody listens any more
            pass
        sys.exit(1)


def answer_all(source, answers, place, arguments):
    kind = source.readline().split()[0]  # the protocol's name, then its version
    words = source.readline().split()[1:]
    if kind == b"saccade-detector":
        run_detector(load(place, arguments, (int(words[0]), int(words[1]))), source, answers)
    else:
        run_controller(load(place, arguments, Limits([float(w) for w in words])), source, answers)


def listen(address, place, arguments):
    if "/" in address:
        server = socket.socket(socket.AF_UNIX)
        server.bind(address)
        server.listen()
    else:
        host, _, port = address.rpartition(":")
        host = host.strip("[]")
        server = socket.create_server((host, int(port)), family=socket.AF_INET6 if ":" in host else socket.AF_INET)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # ended processes leave nothing to wait for
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    print("listening at", address, file=sys.stderr, flush=True)
    try:
        while True:
            connection = server.accept()[0]
            if os.fork() == 0:
                serve(server, connection, place, arguments)
            connection.close()
    except KeyboardInterrupt:
        pass
    finally:
        if "/" in address:
            os.unlink(address)


def serve(server, connection, place, arguments):
    """The life of a process of one connection."""
    status = 1
    try:
        for number in (signal.SIGCHLD, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)
        server.close()
        if connection.family != socket.AF_UNIX:
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        run(connection.makefile("rb"), connection.makefile("wb", buffering=0), place, arguments)
        status = 0
    except (KeyboardInterrupt, SystemExit):
        pass
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(status)


def main():
    words = sys.argv[1:]
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)  # what the class prints is not an answer
    if words[0] == "--listen":
        listen(words[1], words[2], words[3:])
    else:
        run(sys.stdin.buffer, answers, words[0], words[1:])


if __name__ == "__main__":
    main()
