#!/usr/bin/env python3
"""Deploy, and a robot of the backend `external`, killed with SIGKILL while the head moves.
usage: kill_trials.py SACCADE COUNT    prints the times to the stop, ms; status 1 where one was missing or above 100 ms"""
import os, random, re, signal, socket, struct, subprocess, sys, tempfile, time

saccade, count = sys.argv[1], int(sys.argv[2])
root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
folder = tempfile.mkdtemp()
address = folder + "/robot"


class Watcher:
    """A guard that only reads: the activation that the joints follow."""

    def __init__(self):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.connect(address)
        self.socket.sendall(struct.pack("<IIII", 16, 8, 1, 2))

    def take(self, size):
        data = b""
        while len(data) < size:
            data += self.socket.recv(size - len(data)) or sys.exit("the robot is gone")
        return data

    def until(self, follows, limit_s):
        """The time at which the joints follow a client, or none; None after the limit."""
        end = time.monotonic() + limit_s
        while time.monotonic() < end:
            kind, size = struct.unpack("<II", self.take(8))
            payload = self.take(size)
            if kind == 3 and (struct.unpack_from("<Q", payload, 8)[0] != 0) == follows:
                return time.monotonic()
        return None


def start_robot():
    robot = subprocess.Popen([sys.executable, root + "/examples/robots/practice_head.py", address])
    while not os.path.exists(address):
        time.sleep(0.01)
    time.sleep(0.05)
    return robot


def start_deploy():
    return subprocess.Popen([saccade, "deploy", root + "/scenarios/robots/external.yaml", "--set", "external.address=" + address,
                             "--set", "deploy.guard=none", "--set", "deploy.ramp_in_s=0.1", "--activate", "--force",
                             "--out", folder + "/run"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


failures = 0
random.seed(1)
for side in ("deploy", "robot"):
    times = []
    while len(times) < count:
        robot = start_robot()
        watcher = Watcher()
        deploy = start_deploy()
        began = watcher.until(True, 20)
        if began is None:
            sys.exit("deploy does not move the head: " + deploy.communicate()[1])
        time.sleep(random.uniform(0.1, 0.4))
        if deploy.poll() is None:
            killed = time.monotonic()
            if side == "deploy":
                deploy.kill()
                stopped = watcher.until(False, 5)
                times.append(1e3 * (stopped - killed) if stopped else 1e9)
            else:
                robot.kill()
                text = deploy.communicate()[1]
                found = re.search(r"stop command after ([0-9.]+) ms", text) if "lost" in text or "closed" in text else None
                times.append(float(found[1]) if found else 1e9)
                if not found:
                    print(text)
        for process in (deploy, robot):
            process.kill()
            process.wait()
        os.unlink(address)
    times.sort()
    failures += sum(t > 100 for t in times)
    print(f"| {side} | {count} | {times[count // 2]:.1f} | {times[-1]:.1f} |", flush=True)
sys.exit(1 if failures else 0)
