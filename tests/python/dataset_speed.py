"""Prints how many events per second of processor time saccade.Dataset iterates: dataset_speed.py FOLDER."""

import sys
import time

import saccade


def speed(reads, **options):
    data = saccade.Dataset(sys.argv[1], **options)
    best = float("inf")
    for _ in range(2):  # the first time from the disk
        begin, count = time.process_time(), 0
        for window in data:
            events = window["events"]
            count += len(events)
            if reads:
                events["x"].sum(), events["p"].sum()
        best = min(best, time.process_time() - begin)
    print(f"{options}{', x and p summed' if reads else ''}: {count} events, {len(data)} windows, {count / best * 1e-6:.0f} Mevent/s")


for reads in (False, True):
    for options in ({"duration_us": 10_000}, {"duration_us": 1000}, {"count": 5000}):
        speed(reads, **options)
speed(False, duration_us=10_000, event_labels=True)
speed(False, duration_us=10_000, ground_truth=True)
