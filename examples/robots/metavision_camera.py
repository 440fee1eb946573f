#!/usr/bin/env python3
"""practice_head.py with a Prophesee camera, read by the Python module of OpenEB: docs/external_robots.md. Without servos the joints are
simulated: the camera does not turn with them, so try it with `saccade deploy --dry-run`. The robot file has the camera's calibration.
usage: metavision_camera.py ADDRESS [SOURCE [DEVICE]]    ADDRESS as of practice_head.py; SOURCE: a camera's serial number, or a RAW
file, which is played in its own time; '' (default): the first camera; DEVICE: serial port of two servos, as of dynamixel_head.py"""
import sys, threading, time

import numpy
from metavision_core.event_io import EventsIterator, LiveReplayEventsIterator, is_live_camera

import practice_head

PACKET_US, PACKET_EVENTS = 1000, 60_000  # a packet ends with the first of both
SENT = numpy.dtype([("t", "<i8"), ("x", "<u2"), ("y", "<u2"), ("p", "u1"), ("camera", "u1"), ("zero", "<u2")])
DRIFT = 1e-4  # largest difference between the rates of the two clocks


class MetavisionCamera:
    def __init__(self, source):
        events = EventsIterator(source, mode="mixed", delta_t=PACKET_US, n_events=PACKET_EVENTS)
        self.size = events.get_size()[::-1]
        self.lock, self.waiting = threading.Lock(), []
        threading.Thread(target=self.read, daemon=True,
                         args=(events if is_live_camera(source) else LiveReplayEventsIterator(events),)).start()

    def read(self, blocks):
        """Times of the camera become times of this program's clock by the packet with the least delay."""
        offset, before, sent = float("inf"), 0, 0
        for block in blocks:
            end = blocks.get_current_time()
            offset = min(offset + DRIFT * (end - before), time.monotonic() * 1e6 - end)
            before, first, sent = end, sent, max(sent, int(end + offset))
            events = numpy.zeros(len(block), SENT)
            for field in ("x", "y", "p"):
                events[field] = block[field]
            events["t"] = numpy.clip(block["t"] + int(offset), first, sent)  # never back in time
            with self.lock:
                self.waiting.append((sent, events.tobytes()))
        print("metavision_camera.py: the events have ended", file=sys.stderr)

    def packets(self, now, position):
        """A camera without events sends no packets; deploy stops the head then."""
        with self.lock:
            packets, self.waiting = self.waiting, []
        return packets


if __name__ == "__main__":
    address, source, device = (sys.argv[1:] + ["", ""])[:3] if 1 < len(sys.argv) < 5 else sys.exit(__doc__)
    if device:
        import dynamixel_head
        joints = dynamixel_head.Servos(device, 57600)
    else:
        joints = practice_head.LaggingJoints()
    practice_head.serve(address, joints, MetavisionCamera(source))
