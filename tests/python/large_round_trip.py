"""Writes a long recording of two cameras in the formats of NumPy, ROS and MCAP, reads each file with the reader of another project
and with saccade, and compares every event. Not a test: it takes minutes and gigabytes.

usage: PYTHONPATH=build/release/python /usr/bin/python3 tests/python/large_round_trip.py LEFT RIGHT
           [--events 50000000] [--folder DIR] [--program build/release/bin/saccade] [--names a.npz,a.bag,...]

LEFT and RIGHT are recordings of one image size. Both are repeated, later each time. `scripts/setup --all` installs the readers.
"""

import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import time

import numpy as np
import reference_readers
import saccade

START_US = 1_700_000_000_000_000
BLOCK = 1 << 20  # events that are compared at a time
NAMES = "a.npz,a.npy,a.bag,a.packets.bag,a.mcap,a.db3"


def long_recording(paths, count):
    """`count` events of two cameras, sorted by time and, at equal times, by camera."""
    parts = []
    for camera, path in enumerate(paths):
        events = saccade.read(path)
        events["t"] -= events["t"][0]
        events["camera"] = camera
        parts.append(events)
    once = np.concatenate(parts)
    once = once[np.argsort(once["t"], kind="stable")]
    duration_us = int(once["t"][-1]) + 1
    repeated = np.resize(once, count)
    repeated["t"] += START_US + np.arange(count) // len(once) * duration_us
    return repeated


class Measured:
    """A program that was started, and what it took."""

    def __init__(self, process):
        self.process = process
        self.begin = time.perf_counter()
        self.memory_mb = 0.0
        self.watch = threading.Thread(target=self._watch, daemon=True)
        self.watch.start()

    def _watch(self):
        """The largest memory. (ru_maxrss begins with that of the process that started the program.)"""
        status = pathlib.Path(f"/proc/{self.process.pid}/status")
        while found := re.search(r"VmHWM:\s+(\d+) kB", status.read_text()):
            self.memory_mb = int(found[1]) / 1024
            time.sleep(0.02)

    def finish(self):
        self.watch.join()
        _, status, usage = os.wait4(self.process.pid, 0)
        self.process.returncode = os.waitstatus_to_exitcode(status)
        if status != 0:
            sys.exit(f"large_round_trip: {self.process.args} ended with status {self.process.returncode}")
        return (f"{time.perf_counter() - self.begin:.1f} s wall, {usage.ru_utime + usage.ru_stime:.1f} s processor, "
                f"{self.memory_mb:.0f} MB memory")


class Comparison:
    """Compares pieces of a recording with the events that it must have. The order between cameras counts, if `in_order`."""

    def __init__(self, events, in_order):
        self.streams = [events] if in_order else [events[events["camera"] == camera] for camera in (0, 1)]
        self.in_order = in_order
        self.at = [0] * len(self.streams)

    def add(self, piece):
        for i, stream in enumerate(self.streams):
            read = piece if self.in_order else piece[piece["camera"] == i]
            if not np.array_equal(read, stream[self.at[i]:self.at[i] + len(read)]):
                sys.exit(f"large_round_trip: an event of {self.at[i]} to {self.at[i] + len(read)} differs")
            self.at[i] += len(read)

    def finish(self):
        if self.at != [len(stream) for stream in self.streams]:
            sys.exit(f"large_round_trip: found {self.at} events, expected {[len(stream) for stream in self.streams]}")


def read_by_reference(path, events):
    """The reference readers deliver the messages of two topics in turns, so each camera is compared by itself."""
    script = {".bag": "read_bag.cjs", ".mcap": "read_mcap.cjs", ".db3": "read_ros2_bag.py"}.get(path.suffix, "read_array.py")
    comparison = Comparison(events, in_order=script == "read_array.py")
    process = reference_readers.start(script, path, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    measured = Measured(process)
    while records := process.stdout.read(BLOCK * saccade.event_dtype.itemsize):
        comparison.add(reference_readers.events_of(records))
    figures = measured.finish()
    comparison.finish()
    return figures


def read_by_saccade(path, events):
    comparison = Comparison(events, in_order=True)
    begin = time.perf_counter()
    for piece in saccade.iterate(path, count=BLOCK):
        comparison.add(piece)
    comparison.finish()
    return f"{time.perf_counter() - begin:.1f} s wall, comparison included"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("left")
    parser.add_argument("right")
    parser.add_argument("--events", type=int, default=50_000_000)
    parser.add_argument("--folder", type=pathlib.Path)
    parser.add_argument("--program", default=reference_readers.ROOT / "build" / "release" / "bin" / "saccade")
    parser.add_argument("--names", default=NAMES)
    options = parser.parse_args()
    if not reference_readers.are_installed():
        sys.exit("large_round_trip: node or the packages of the readers are missing; scripts/setup --all installs them")
    folder = options.folder or pathlib.Path(tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    events = long_recording((options.left, options.right), options.events)
    source = folder / "source.aedat4"
    saccade.write(source, events, size=saccade.open(options.left).size)
    print(f"{len(events)} events, {np.count_nonzero(events['camera'])} of the right camera, "
          f"{(events['t'][-1] - events['t'][0]) * 1e-6:.1f} s, source.aedat4 {source.stat().st_size / 1e6:.0f} MB", flush=True)
    for name in options.names.split(","):
        path = folder / name
        measured = Measured(subprocess.Popen([options.program, "convert", source, path, "--force"], stdout=subprocess.DEVNULL))
        print(f"{name}: written by saccade convert in {measured.finish()}; {path.stat().st_size / 1e6:.0f} MB", flush=True)
        print(f"{name}: equal as read by the reference reader in {read_by_reference(path, events)}", flush=True)
        print(f"{name}: equal as read by saccade in {read_by_saccade(path, events)}", flush=True)
        path.unlink()
    source.unlink()


if __name__ == "__main__":
    main()
