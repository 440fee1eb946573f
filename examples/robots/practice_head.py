#!/usr/bin/env python3
"""A head of two joints that sees a ball: a robot in a program of its own, docs/external_robots.md.
usage: practice_head.py ADDRESS    HOST:PORT, or the path of a Unix socket; scenarios/robots/external.yaml goes with it"""
import math, os, select, socket, struct, sys, time

SIZE, FOCAL, LAG, WATCHDOG = 128, 99.0, 0.03, 0.06  # px, px, s, s
JOINTS = ((b"pan", math.radians(90), 4.3), (b"tilt", math.radians(60), 4.3))  # +- limit, rad; rad/s
HELLO, EVENTS, READING, CLIENT, ACTIVATE, REFERENCE, STOP, RELEASE, HEARTBEAT = 1, 2, 3, 16, 17, 18, 19, 20, 21


def frame(kind, payload):
    return struct.pack("<II", kind, len(payload)) + payload


def hello(size, now):
    joints = b"".join(struct.pack("<32s3d", name, -limit, limit, speed) for name, limit, speed in JOINTS)
    return frame(HELLO, b"saccade\0" + struct.pack("<4Iq3I", 1, *size, round(WATCHDOG * 1e3), int(now * 1e6), 0,
                                                   0, len(JOINTS)) + joints)


def ball(now, pan, tilt):
    """Centre and radius of the ball in the image, px. The camera turns with pan (right) and tilt (up)."""
    turn = math.tau * now / 4
    x, y, z = 0.04 * math.cos(turn), 0.04 * math.sin(turn), 0.45  # right, up, forward of the resting camera, m
    x, z = x * math.cos(pan) - z * math.sin(pan), x * math.sin(pan) + z * math.cos(pan)
    y, z = y * math.cos(tilt) - z * math.sin(tilt), y * math.sin(tilt) + z * math.cos(tilt)
    return SIZE / 2 + FOCAL * x / z, SIZE / 2 - FOCAL * y / z, FOCAL * 0.0475 / z


def pixels(disc):
    cx, cy, r = disc
    rows = range(max(0, math.ceil(cy - r)), min(SIZE - 1, math.floor(cy + r)) + 1)
    half = {y: math.sqrt(max(0.0, r * r - (y - cy) ** 2)) for y in rows}
    return {(x, y) for y, h in half.items()
            for x in range(max(0, math.ceil(cx - h)), min(SIZE - 1, math.floor(cx + h)) + 1)}


def listen(address):
    if "/" not in address:
        host, port = address.rsplit(":", 1)
        return socket.create_server((host, int(port)))
    if os.path.exists(address):
        os.unlink(address)
    listening = socket.socket(socket.AF_UNIX)
    listening.bind(address)
    listening.listen()
    return listening


class BallCamera:
    """A camera that sees the ball. Other cameras have a class of their own with size and packets()."""

    def __init__(self):
        self.size, self.seen = (SIZE, SIZE), set()

    def packets(self, now, position):
        """What was seen since the call before: (time up to which all events are in it, us; events) for each packet."""
        sees, t = pixels(ball(now, *position)), int(now * 1e6)
        events = b"".join(struct.pack("<qHHBBH", t, x, y, (x, y) in sees, 0, 0) for x, y in sees ^ self.seen)
        self.seen = sees
        return [(t, events)]


class LaggingJoints:
    """Joints that approach their references with a lag. Other heads have a class of their own with move()."""

    def __init__(self):
        self.position = [0.0] * len(JOINTS)

    def move(self, reference, dt):
        """Towards the references, rad, for dt seconds; returns positions and whether each joint is sound."""
        share = 1 - math.exp(-dt / LAG)
        self.position = [p + share * (r - p) for p, r in zip(self.position, reference)]
        return self.position, [True] * len(JOINTS)


def serve(address, head, camera):
    listening = listen(address)
    clients, owner, number, heard = {}, None, 0, 0.0  # clients: what came from each; owner: who moves the head
    position, sound = head.move([0.0] * len(JOINTS), 0.0)
    reference, then = position[:], time.monotonic()
    while True:
        for ready in select.select([listening, *clients], [], [], 0.001)[0]:
            if ready is listening:
                client = listening.accept()[0]
                clients[client] = b""
                client.sendall(hello(camera.size, time.monotonic()))
                client.setblocking(False)
                continue
            try:
                received = ready.recv(65536)
            except OSError:
                received = b""
            clients[ready] += received
            while len(clients[ready]) >= 8:
                kind, size = struct.unpack_from("<II", clients[ready])
                payload, rest = clients[ready][8:8 + size], clients[ready][8 + size:]
                if not CLIENT <= kind <= HEARTBEAT or size > 1000:
                    received = b""  # not the protocol
                    break
                if len(payload) < size:
                    break
                clients[ready] = rest
                if kind == ACTIVATE and owner in (None, ready):
                    owner, number, heard = ready, struct.unpack("<Q", payload)[0], time.monotonic()
                    reference = position[:]
                if ready is owner:
                    heard = time.monotonic()
                    if kind == REFERENCE and struct.unpack_from("<Q", payload)[0] == number:
                        wanted = struct.unpack_from("<2d", payload, 8)
                        if all(abs(w) <= joint[1] for w, joint in zip(wanted, JOINTS)):
                            reference = list(wanted)
                    if kind == STOP:
                        reference = position[:]
                if kind == RELEASE:
                    owner, number, reference = None, 0, position[:]
            if not received:
                clients.pop(ready)
                ready.close()
                if ready is owner:
                    owner, number, reference = None, 0, position[:]
        now = time.monotonic()
        if owner and now - heard > WATCHDOG:
            owner, number, reference = None, 0, position[:]
        if now - then < 0.001:
            continue
        before, dt, then = position, now - then, now
        position, sound = head.move(reference, dt)
        joints = b"".join(struct.pack("<ddQ", p, (p - b) / dt, (1 if owner else 2) if ok else 4)
                          for p, b, ok in zip(position, before, sound))
        message = b"".join(frame(EVENTS, struct.pack("<q", t) + events) for t, events in camera.packets(now, position))
        message += frame(READING, struct.pack("<qQ", int(now * 1e6), number) + joints)
        for client in list(clients):
            try:
                client.sendall(message)
            except OSError:  # gone, or it does not read
                clients.pop(client)
                client.close()
                if client is owner:
                    owner, number, reference = None, 0, position[:]


if __name__ == "__main__":
    serve(sys.argv[1], LaggingJoints(), BallCamera())
