#!/usr/bin/env python3
"""Two simulated Dynamixel servos on a pseudo-terminal: protocol 2.0 with a reader and a CRC table of its own.
usage: dynamixel_bus.py    prints the name of the terminal; a line `mute N`, `fault N` or `quit` on its standard input: servo N is
silent, reports a hardware error; at the end it prints what the servos received"""
import os, select, struct, sys, time, tty

LAG, SPEED = 0.03, 4.3 * 4096 / 6.283185307179586  # s; steps/s

table = []
for high in range(256):
    remainder = high << 8
    for _ in range(8):
        remainder = (remainder << 1) ^ 0x18005 if remainder & 0x8000 else remainder << 1
    table.append(remainder)


def crc(data):
    total = 0
    for byte in data:
        total = (total << 8 & 0xFF00) ^ table[total >> 8 ^ byte]
    return total


class Servo:
    def __init__(self, number):
        self.number, self.table, self.then, self.heard = number, bytearray(200), time.monotonic(), time.monotonic()
        self.position, self.silent, self.stopped = 2048.0, False, False
        struct.pack_into("<i", self.table, 116, 2048)

    def advance(self):
        now = time.monotonic()
        dt, self.then = now - self.then, now
        if self.table[98] and now - self.heard > 0.02 * self.table[98]:
            self.stopped = True
        if self.table[64] and not self.stopped:
            error = struct.unpack_from("<i", self.table, 116)[0] - self.position
            self.position += max(-SPEED * dt, min(SPEED * dt, error * min(1.0, dt / LAG)))
        struct.pack_into("<i", self.table, 132, round(self.position))

    def write(self, address, data):
        if address == 116 and not 0 <= struct.unpack("<i", data)[0] <= 4095:
            return 6  # data limit
        if address == 98 and data == b"\0":
            self.stopped = False
        self.table[address:address + len(data)] = data
        return 0

    def status(self, error=0, data=b""):
        if self.silent:
            return b""
        data = bytes([error | (0x80 if self.table[70] else 0)]) + data
        data = data.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
        body = b"\xff\xff\xfd\0" + struct.pack("<BHB", self.number, len(data) + 3, 0x55) + data
        return body + struct.pack("<H", crc(body))


servos = {1: Servo(1), 2: Servo(2)}
counts = {"instructions": 0, "damaged": 0, "goals": 0, "rejected": 0}
master, slave = os.openpty()
tty.setraw(slave)
print(os.ttyname(slave), flush=True)
data, running = b"", True
while running:
    ready = select.select([master, sys.stdin], [], [], 0.001)[0]
    for servo in servos.values():
        servo.advance()
    if sys.stdin in ready:
        words = sys.stdin.readline().split()
        if words[:1] == ["mute"]:
            servos[int(words[1])].silent = True
        elif words[:1] == ["fault"]:
            servos[int(words[1])].table[70] = 0x20  # overload
        else:
            running = False
    if master in ready:
        data += os.read(master, 4096)
    while len(data) >= 10:
        if data[:4] != b"\xff\xff\xfd\0":
            data = data[1:]
            continue
        end = 7 + data[5] + 256 * data[6]
        if len(data) < end:
            break
        message, data = data[:end], data[end:]
        if end < 10 or crc(message[:-2]) != message[-2] + 256 * message[-1]:
            counts["damaged"] += 1
            continue
        counts["instructions"] += 1
        to, kind, parameters = message[4], message[7], message[8:-2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
        for number, servo in servos.items():
            if to not in (number, 0xFE):
                continue
            servo.heard = time.monotonic()
            answer = b""
            if kind == 1:
                answer = servo.status(0, b"\x1e\x00\x2a")
            elif kind == 3:
                answer = servo.status(servo.write(parameters[0] + 256 * parameters[1], parameters[2:]))
            elif kind in (0x82, 0x83):
                address, length = struct.unpack_from("<HH", parameters)
                if kind == 0x82 and number in parameters[4:]:
                    answer = servo.status(0, bytes(servo.table[address:address + length]))
                for at in range(4, len(parameters), length + 1) if kind == 0x83 else ():
                    if parameters[at] == number:
                        counts["goals"] += 1
                        counts["rejected"] += servo.write(address, parameters[at + 1:at + 1 + length]) != 0
            os.write(master, answer)
print(counts, [round(servo.position) for servo in servos.values()], [servo.stopped for servo in servos.values()], flush=True)
