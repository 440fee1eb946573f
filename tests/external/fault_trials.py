#!/usr/bin/env python3
"""Random faults of a robot of the backend `external`: deploy moves the practice head beside `saccade guard`, which it requires; one
fault comes at a random instant, on the wire between them or in one of the three programs.
usage: fault_trials.py SACCADE COUNT [SEED] [KIND]
Prints the times, ms, from the fault to the stop and to the last motion of a joint above 1 deg/s. The stop is the first stop or release
frame; of a killed or halted deploy the reading that shows the joints released; of a robot that is gone, or whose connection is lost,
what deploy writes. Status 1 if the head was not stopped in time, if a reference came later, for a wrong cause or status, or if
something stopped it that must not."""
import math, os, random, re, selectors, signal, socket, struct, subprocess, sys, tempfile, threading, time

EVENTS, READING, REFERENCE, STOP, RELEASE, HEARTBEAT = 2, 3, 18, 19, 20, 21
FOLLOWS, HELD, OFF, FAULT = 1, 2, 3, 4
LOST = "lost the connection"
# By name: what deploy says of it (empty: nothing that it could say), or None where the head must not stop.
FAULTS = {
    "camera silent": "no packet from the camera",
    "joint readings stop": "no reading of the joints",
    "nothing comes": "no packet from the camera|no reading of the joints",
    "encoder not a number": "is not a number",
    "joint outside its limits": "outside its limits",
    "joint switched off": "was switched off",
    "joint in hardware fault": "is in hardware fault",
    "joint's mode changed": "no longer follows references",
    "joint stuck": "has not followed its reference",
    "references are lost": "has not followed its reference",
    "all commands are lost": "no longer follows references",
    "readings half a second back": "no reading of the joints",
    "frame of an unknown type": LOST,
    "frame of 2^31 bytes": LOST,
    "event in half": LOST,
    "rubbish": LOST,
    "hello once more": LOST,
    "frame breaks off": "no packet from the camera|no reading of the joints",
    "connection closed": LOST,
    "robot ends as planned": "the run is over",
    "robot killed": LOST,
    "robot halted": "no packet from the camera|no reading of the joints",
    "deploy killed": "",
    "deploy halted, then continued": "",
    "guard killed": "no sign of the guard",
    "guard halted": "no sign of the guard",
    "Ctrl-C": "by a signal",
    "robot's clock set back by 2 s": None,
    "events outside the image": None,
    "strangers": None,
}
GONE = ("robot killed", "robot halted")
PLANNED = ("robot ends as planned", "Ctrl-C")
DEPLOY = ("deploy killed", "deploy halted, then continued")


def frame(kind, payload):
    return struct.pack("<II", kind, len(payload)) + payload


def connect(address):
    client = socket.socket(socket.AF_UNIX)
    client.connect(address)
    return client


class Wire(threading.Thread):
    """Carries frames between clients and the robot, and changes those of deploy where a fault says so."""

    def __init__(self, address, robot):
        super().__init__(daemon=True)
        self.robot, self.fault = robot, None
        self.listening = socket.socket(socket.AF_UNIX)
        self.listening.bind(address)
        self.listening.listen()
        self.references, self.referenced, self.stopped = 0, 0.0, None
        self.selector = selectors.DefaultSelector()
        self.selector.register(self.listening, selectors.EVENT_READ)
        self.others, self.buffers, self.deploy = {}, {}, None  # deploy: the robot's end of its connection
        self.frozen = None

    def drop(self, one):
        for end in (one, self.others.pop(one, None)):
            if end in self.buffers:
                self.others.pop(end, None)
                del self.buffers[end]
                self.selector.unregister(end)
                end.close()

    def run(self):
        while True:
            for key, _ in self.selector.select():
                if key.fileobj is not self.listening:
                    self.carry(key.fileobj)
                    continue
                client = self.listening.accept()[0]
                try:
                    robot = connect(self.robot)
                except OSError:
                    client.close()
                    continue
                self.others.update({client: robot, robot: client})
                for end in (client, robot):
                    self.buffers[end] = b""
                    self.selector.register(end, selectors.EVENT_READ)

    def carry(self, end):
        if end not in self.buffers:
            return  # closed by another of this round
        try:
            received = end.recv(1 << 16)
        except OSError:
            received = b""
        if not received:
            return self.drop(end)
        waiting, out = self.buffers[end] + received, []
        while len(waiting) >= 8:
            kind, size = struct.unpack_from("<II", waiting)
            if len(waiting) < 8 + size:
                break
            payload, waiting = waiting[8:8 + size], waiting[8 + size:]
            if kind == 16 and struct.unpack_from("<I", payload, 4)[0] == 1:
                self.deploy = self.others[end]
            if self.deploy is self.others[end]:
                out.append(self.from_deploy(kind, payload))
            elif self.deploy is end:
                out.append(self.to_deploy(kind, payload))
            else:
                out.append(frame(kind, payload))
        self.buffers[end] = waiting
        try:
            if None in out:
                self.drop(end)
            else:
                self.others[end].sendall(b"".join(out))
        except OSError:
            self.drop(end)

    def from_deploy(self, kind, payload):
        now = time.monotonic()
        if kind == REFERENCE:
            self.references += 1
            self.referenced = now
        if kind in (STOP, RELEASE) and self.stopped is None:
            self.stopped = now
        if self.fault == "references are lost" and kind == REFERENCE:
            return frame(HEARTBEAT, payload[:8])  # the robot's own watchdog is content
        return b"" if self.fault == "all commands are lost" else frame(kind, payload)

    def to_deploy(self, kind, payload):
        """What deploy gets instead of this frame; None closes the connection."""
        fault, whole = self.fault, frame(kind, payload)
        if fault == "nothing comes" or (fault == "camera silent" and kind == EVENTS) or (fault == "joint readings stop" and kind == READING):
            return b""
        if fault == "connection closed":
            return None
        once = {"frame of an unknown type": frame(77, b"12345678"), "frame of 2^31 bytes": struct.pack("<II", 2, 1 << 31),
                "event in half": frame(EVENTS, payload[:8] + b"12345678"), "rubbish": random.randbytes(4000),
                "hello once more": frame(1, bytes(48)), "robot ends as planned": frame(6, b""), "frame breaks off": whole[:-3]}
        if fault in once and kind == EVENTS:
            self.fault = "nothing comes"
            return once[fault]
        if fault == "events outside the image" and kind == EVENTS:
            stamp = struct.unpack_from("<q", payload)[0]
            return frame(EVENTS, payload + struct.pack("<qHHBBH", stamp, 60000, 5, 1, 0, 0) * 20)
        if fault == "robot's clock set back by 2 s" and kind == EVENTS:
            return frame(EVENTS, struct.pack("<q", struct.unpack_from("<q", payload)[0] - 2000000) + b"".join(
                struct.pack("<qQ", stamp - 2000000, rest) for stamp, rest in struct.iter_unpack("<qQ", payload[8:])))
        if kind != READING:
            return whole
        stamp, number = struct.unpack_from("<qQ", payload)
        joints = [list(joint) for joint in struct.iter_unpack("<ddQ", payload[16:])]
        if fault == "readings half a second back":
            stamp -= 500000
        elif fault == "robot's clock set back by 2 s":
            stamp -= 2000000
        elif fault == "encoder not a number":
            joints[1][0] = math.nan
        elif fault == "joint outside its limits":
            joints[0][0] = math.radians(93)
        elif fault == "joint switched off":
            joints[1][2] = OFF
        elif fault == "joint in hardware fault":
            joints[0][2] = FAULT
        elif fault == "joint's mode changed":
            joints[1][2] = HELD
        elif fault == "joint stuck":
            self.frozen = self.frozen or [joint[0] for joint in joints]
            joints = [[position, 0.0, joint[2]] for position, joint in zip(self.frozen, joints)]
        return frame(READING, struct.pack("<qQ", stamp, number) + b"".join(struct.pack("<ddQ", *joint) for joint in joints))


class Watcher(threading.Thread):
    """A guard that only reads what the robot itself says: the activation that the joints follow, and their speeds."""

    def __init__(self, robot):
        super().__init__(daemon=True)
        self.socket = connect(robot)
        self.socket.sendall(struct.pack("<IIII", 16, 8, 1, 2))
        self.follows, self.changed, self.moved = False, 0.0, 0.0

    def take(self, size):
        data = b""
        while len(data) < size:
            more = self.socket.recv(size - len(data))
            if not more:
                raise OSError
            data += more
        return data

    def run(self):
        try:
            while True:
                kind, size = struct.unpack("<II", self.take(8))
                payload = self.take(size)
                if kind != READING:
                    continue
                now, follows = time.monotonic(), struct.unpack_from("<Q", payload, 8)[0] != 0
                if follows != self.follows:
                    self.follows, self.changed = follows, now
                if any(abs(speed) > math.radians(1) for _, speed, _ in struct.iter_unpack("<ddQ", payload[16:])):
                    self.moved = now
        except OSError:
            pass


def until(holds, limit_s):
    end = time.monotonic() + limit_s
    while not holds() and time.monotonic() < end:
        time.sleep(0.001)
    return holds()


def text_of(path):
    with open(path, errors="replace") as file:
        return file.read()


class Trial:
    def __init__(self, saccade, fault, wait_s):
        self.fault, self.problem, self.stop_ms, self.rest_ms, self.stopped_before, self.late = fault, "", None, None, False, False
        with tempfile.TemporaryDirectory() as self.folder:
            self.programs = []
            try:
                self.run(saccade, wait_s)
            finally:
                for program in self.programs:
                    program.kill()
                    program.wait()

    def start(self, name, command):
        log = open(f"{self.folder}/{name}.log", "w")
        self.programs.append(subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT))
        return self.programs[-1]

    def log(self, name):
        return text_of(f"{self.folder}/{name}.log")

    def fail(self, what):
        self.problem = self.problem or what + "\n" + self.log("deploy")

    def run(self, saccade, wait_s):
        root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
        robot_path, address = self.folder + "/robot", self.folder + "/wire"
        robot = self.start("robot", [sys.executable, root + "/examples/robots/practice_head.py", robot_path])
        if not until(lambda: os.path.exists(robot_path), 10):
            return self.fail("no robot")
        time.sleep(0.05)
        wire, watcher = Wire(address, robot_path), Watcher(robot_path)
        wire.start()
        watcher.start()
        given = [root + "/scenarios/robots/external.yaml", "--set", "external.address=" + address]
        guard = self.start("guard", [saccade, "guard", *given])
        if not until(lambda: "connected to the head" in self.log("guard"), 20):
            return self.fail("no guard: " + self.log("guard"))
        deploy = self.start("deploy", [saccade, "deploy", *given, "--set", "deploy.ramp_in_s=0.1", "--activate", "--force", "--out", self.folder + "/run"])
        until(lambda: wire.references > 50 or deploy.poll() is not None, 30)
        time.sleep(wait_s)
        if deploy.poll() is not None or wire.references <= 50:
            self.stopped_before = deploy.poll() == 1 and ("stopped: " in self.log("deploy") or "not ready" in self.log("deploy"))
            return None if self.stopped_before else self.fail("deploy does not move the head")
        self.judge(wire, watcher, robot, guard, deploy)

    def judge(self, wire, watcher, robot, guard, deploy):
        fault, expected = self.fault, FAULTS[self.fault]
        came = time.monotonic()
        wire.fault = fault
        signals = {"robot killed": (robot, signal.SIGKILL), "robot halted": (robot, signal.SIGSTOP), "deploy killed": (deploy, signal.SIGKILL),
                   "deploy halted, then continued": (deploy, signal.SIGSTOP), "guard killed": (guard, signal.SIGKILL),
                   "guard halted": (guard, signal.SIGSTOP), "Ctrl-C": (deploy, signal.SIGINT)}
        if fault in signals:
            signals[fault][0].send_signal(signals[fault][1])
        if fault == "strangers":
            strangers = [connect(wire.robot) for _ in range(20)]
            for number, stranger in enumerate(strangers):
                stranger.sendall((random.randbytes(300), frame(16, b"1")[:7], b"GET / HTTP/1.1\r\n\r\n", b"")[number % 4])
        if expected is None:
            time.sleep(0.3)
            if "stopped: " in self.log("deploy") or deploy.poll() is not None:
                self.fail("the head was stopped")
            deploy.send_signal(signal.SIGINT)
        if fault in DEPLOY:
            if not until(lambda: not watcher.follows, 1):
                self.fail("no stop")
            self.stop_ms = 1e3 * (watcher.changed - came)
            if fault != "deploy killed":
                time.sleep(0.2)
                deploy.send_signal(signal.SIGCONT)
        try:
            status = deploy.wait(10)
        except subprocess.TimeoutExpired:
            return self.fail("deploy does not end")
        if wire.stopped and wire.stopped < came:
            self.stopped_before = True
            return None
        if fault != "deploy killed" and status != (0 if expected is None or fault in PLANNED else 1):
            self.fail(f"deploy ended with status {status}")
        log = self.log("deploy")
        self.late = "stopped: a tick came" in log  # a stop, but not for the fault
        if expected and not self.late and not re.search("stopped: .*(" + expected + ")", log):
            self.fail("another cause in the log")
        if fault in GONE or expected == LOST:
            written = re.search(r"stop command after ([0-9.]+) ms", log)
            self.stop_ms = float(written[1]) if written else None
        elif expected is not None and fault not in DEPLOY:
            self.stop_ms = 1e3 * (wire.stopped - came) if wire.stopped else None
        if expected is None:
            return None
        if self.stop_ms is None or self.stop_ms > (1100 if "has not followed" in expected else 100):
            self.fail("no stop in time")
        if fault in GONE:
            return None
        references = wire.references
        time.sleep(0.15)
        if wire.references != references or (wire.stopped and wire.referenced > wire.stopped):
            self.fail("a reference after the stop")
        if watcher.follows:
            self.fail("the joints are not released")
        if time.monotonic() - watcher.moved < 0.1:
            self.fail("a joint still moves")
        self.rest_ms = 1e3 * (watcher.moved - came) if watcher.moved > came else None
        return None


def middle(values):
    return f"{sorted(values)[len(values) // 2]:.1f}" if values else "-"


def main():
    if not 3 <= len(sys.argv) <= 5 or not all(number.isdecimal() for number in sys.argv[2:4]):
        sys.exit("usage: fault_trials.py SACCADE COUNT [SEED] [KIND]")
    saccade, count = sys.argv[1], int(sys.argv[2])
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    kinds = [kind for kind in FAULTS if len(sys.argv) < 5 or kind == sys.argv[4]]
    if not kinds:
        sys.exit("fault_trials.py: KIND: expected one of " + ", ".join(FAULTS))
    random.seed(seed)
    trials, before = {kind: [] for kind in kinds}, 0
    interrupted = []  # then the figures so far
    signal.signal(signal.SIGTERM, lambda number, frame: interrupted.append(number))
    for number in range(count):
        if interrupted:
            count = number
            break
        kind = kinds[number % len(kinds)]
        while True:
            trial = Trial(saccade, kind, random.uniform(0.1, 0.5))
            if not trial.stopped_before:
                break
            before += 1
            if before > 20 + count:
                sys.exit("fault_trials.py: deploy is stopped again and again before the fault")
        trials[kind].append(trial)
        if trial.problem:
            print(f"trial {number}, {kind}: {trial.problem}", flush=True)
    print(f"{count} faults of an external robot, seed {seed}; {before} more runs were stopped before their fault, and "
          f"{sum(trial.late for done in trials.values() for trial in done)} by a late tick after it. From the fault, ms.\n")
    print("| fault | trials | stop, median | worst | joints at rest, median | worst | unsafe |\n|---|---|---|---|---|---|---|")
    for kind, done in trials.items():
        stops = [trial.stop_ms for trial in done if trial.stop_ms is not None]
        rests = [trial.rest_ms for trial in done if trial.rest_ms is not None]
        if done:
            print(f"| {kind} | {len(done)} | {middle(stops)} | {f'{max(stops):.1f}' if stops else '-'} | {middle(rests)} | "
                  f"{f'{max(rests):.1f}' if rests else '-'} | {sum(bool(trial.problem) for trial in done)} |")
    return any(trial.problem for done in trials.values() for trial in done)


if __name__ == "__main__":
    sys.exit(main())
