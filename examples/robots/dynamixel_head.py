#!/usr/bin/env python3
"""practice_head.py with two Dynamixel servos (X series or MX 2.0, protocol 2.0) that turn pan and tilt: docs/external_robots.md.
The ball is still simulated; a camera of one's own, such as metavision_camera.py's, takes the place of BallCamera.
usage: dynamixel_head.py ADDRESS DEVICE [BAUD]    ADDRESS as of practice_head.py; DEVICE: the serial port, such as /dev/ttyUSB0"""
import math, os, select, struct, sys, termios, time, tty

import practice_head

IDS, STEPS_PER_RAD, CENTRE, ANSWER_S = (1, 2), 4096 / math.tau, 2048, 0.008
PING, READ, WRITE, STATUS, SYNC_READ, SYNC_WRITE = 1, 2, 3, 0x55, 0x82, 0x83
TORQUE, HARDWARE_ERROR, WATCHDOG, GOAL, POSITION = 64, 70, 98, 116, 132  # addresses of the control table
BROADCAST, WATCHDOG_STEPS = 0xFE, 5  # the servo stops 5 * 20 ms after the last packet


def crc(data):
    value = 0
    for byte in data:
        value ^= byte << 8
        for _ in range(8):
            value = (value << 1 ^ (0x8005 if value & 0x8000 else 0)) & 0xFFFF
    return value


def packet(servo, kind, parameters=b""):
    parameters = parameters.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
    body = b"\xff\xff\xfd\x00" + struct.pack("<BHB", servo, len(parameters) + 3, kind) + parameters
    return body + struct.pack("<H", crc(body))


def take_packet(data):
    """The first whole packet: (servo, kind, parameters) or None, and what follows it."""
    while True:
        start = data.find(b"\xff\xff\xfd\x00")
        if start < 0:
            return None, data[-3:]
        data = data[start:]
        if len(data) < 7:
            return None, data
        end = 7 + struct.unpack_from("<H", data, 5)[0]
        if len(data) < end:
            return None, data
        if end >= 10 and struct.unpack_from("<H", data, end - 2)[0] == crc(data[:end - 2]):
            return (data[4], data[7], data[8:end - 2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")), data[end:]
        data = data[4:]  # damaged


class Servos:
    def __init__(self, device, baud):
        self.port = os.open(device, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.port)
        speed = getattr(termios, f"B{baud}", None) or sys.exit(f"dynamixel_head.py: found {baud} baud, expected 57600, 1000000 ...")
        settings = termios.tcgetattr(self.port)
        settings[4] = settings[5] = speed
        termios.tcsetattr(self.port, termios.TCSANOW, settings)
        termios.tcflush(self.port, termios.TCIOFLUSH)
        for servo in IDS:
            if servo not in self.ask(packet(servo, PING), [servo]):
                sys.exit(f"dynamixel_head.py: found no answer of servo {servo} on {device}, expected one at {baud} baud")
            for address, value in ((WATCHDOG, 0), (TORQUE, 1), (WATCHDOG, WATCHDOG_STEPS)):
                self.ask(packet(servo, WRITE, struct.pack("<HB", address, value)), [servo])
        self.position = [0.0, 0.0]

    def ask(self, message, servos):
        """Sends a packet; what the servos answer: their parameters after the error byte, by servo."""
        os.write(self.port, message)
        answers, data, end = {}, b"", time.monotonic() + ANSWER_S
        while len(answers) < len(servos) and time.monotonic() < end:
            if not select.select([self.port], [], [], max(0.0, end - time.monotonic()))[0]:
                break
            data += os.read(self.port, 4096)
            found, data = take_packet(data)
            while found:
                servo, kind, parameters = found
                if kind == STATUS and servo in servos and parameters and not parameters[0] & 0x7F:
                    answers[servo] = parameters[1:]
                found, data = take_packet(data)
        return answers

    def move(self, reference, dt):
        """A servo that does not answer, or reports a hardware error, is not sound; its last position is returned. Before time
        passes the servos are read alone."""
        goals = b"".join(struct.pack("<Bi", servo, CENTRE + round(r * STEPS_PER_RAD)) for servo, r in zip(IDS, reference))
        if dt > 0.0:
            os.write(self.port, packet(BROADCAST, SYNC_WRITE, struct.pack("<HH", GOAL, 4) + goals))
        span = POSITION + 4 - HARDWARE_ERROR
        answers = self.ask(packet(BROADCAST, SYNC_READ, struct.pack("<HH", HARDWARE_ERROR, span) + bytes(IDS)), IDS)
        sound = [len(answers.get(servo, b"")) == span and answers[servo][0] == 0 for servo in IDS]
        for i, servo in enumerate(IDS):
            if len(answers.get(servo, b"")) == span:
                self.position[i] = (struct.unpack_from("<i", answers[servo], span - 4)[0] - CENTRE) / STEPS_PER_RAD
        return self.position[:], sound


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    practice_head.serve(sys.argv[1], Servos(sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 57600),
                        practice_head.BallCamera())
