"""What examples/robots/metavision_camera.py uses of OpenEB's module: a camera that sees the ball of practice_head.py."""
import struct, time

import numpy
import practice_head

EVENT = numpy.dtype([("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")])


class EventsIterator:
    def __init__(self, source, mode, delta_t, n_events):
        self.step_us, self.now_us = delta_t, 0

    def get_size(self):
        return practice_head.SIZE, practice_head.SIZE

    def get_current_time(self):
        return self.now_us

    def __iter__(self):
        camera, begin = practice_head.BallCamera(), time.monotonic()
        while True:
            time.sleep(max(0.0, begin + (self.now_us + self.step_us) * 1e-6 - time.monotonic()))
            events = [struct.unpack("<qHHBBH", sent[i:i + 16]) for _, sent in camera.packets(self.now_us * 1e-6, (0.0, 0.0))
                      for i in range(0, len(sent), 16)]
            self.now_us += self.step_us
            yield numpy.array([(x, y, p, t) for t, x, y, p, _, _ in events], EVENT)


LiveReplayEventsIterator = None


def is_live_camera(source):
    return True
