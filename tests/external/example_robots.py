#!/usr/bin/env python3
"""The programs of examples/robots, each driven by deploy for some seconds: the head becomes active, follows the ball, and deploy ends
as planned; where a servo of the Dynamixel falls silent or reports a fault, deploy stops the head.
OpenEB is replaced by stand_in/, a camera that does not turn with the joints.
usage: example_robots.py SACCADE PRACTICE_HEAD_IN_C"""
import json, os, subprocess, sys, tempfile, threading, time

saccade, in_c = sys.argv[1:3]
root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
folder = tempfile.mkdtemp()
address = folder + "/robot"
# Watchdogs that a busy machine keeps.
PATIENT = ["deploy.watchdog.safe_within_ms=1000", "deploy.watchdog.tick_late_ms=490", "deploy.watchdog.camera_silent_ms=500",
           "deploy.watchdog.joints_stale_ms=500", "deploy.watchdog.hang_ms=480", "deploy.guard=none", "external.address=" + address]
failures = 0


def check(holds, what):
    global failures
    if not holds:
        failures += 1
        print("FAILED:", what, flush=True)


def deploy(name, seconds):
    return subprocess.Popen([saccade, "deploy", root + "/scenarios/robots/external.yaml", "--activate", "--duration", str(seconds), "--force",
                             "--out", folder + "/" + name, *sum((["--set", key] for key in PATIENT), [])],
                            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def drive(name, command, during=None, seconds=3):
    """Deploy with a robot; its exit status, log, and the states of deploy.json."""
    robot = subprocess.Popen(command)
    end = time.monotonic() + 20
    while not os.path.exists(address) and robot.poll() is None and time.monotonic() < end:
        time.sleep(0.01)
    program = deploy(name, seconds)
    log = ""
    for line in program.stdout:
        log += line
        if during and "ball found" in line:
            during()
            during = None
    status = program.wait(timeout=60)
    check(robot.poll() is None, name + " runs until it is ended")
    robot.kill()
    robot.wait()
    os.unlink(address)
    with open(f"{folder}/{name}/deploy.json") as file:
        states = json.load(file)["states"]
    print(name, status, [state.get("cause") for state in states], flush=True)
    return status, log, states


def follows(name, command):
    status, log, states = drive(name, command)
    check(status == 0, f"{name}: status 0, found {status}\n{log}")
    check("ball found" in log, f"{name}: the ball is found\n{log}")
    check(states[-1].get("cause") == "the run is over", f"{name}: nothing stopped the head before: {states}")


def bus():
    program = subprocess.Popen([sys.executable, root + "/tests/external/dynamixel_bus.py"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    return program, [sys.executable, root + "/examples/robots/dynamixel_head.py", address, program.stdout.readline().strip(), "1000000"]


def times_of_a_camera_never_go_back():
    """Its first packet comes 10 ms late, the others at once: the least delay, which turns its times into the program's, falls."""
    sys.path[:0] = [root + "/examples/robots", root + "/tests/external/stand_in"]
    import numpy, metavision_camera
    from metavision_core.event_io import EVENT

    class Blocks:
        def get_current_time(self):
            return self.now_us

        def __iter__(self):
            time.sleep(0.01)
            for self.now_us in range(1000, 21000, 1000):
                yield numpy.array([(1, 2, 1, self.now_us - before) for before in (900, 100)], EVENT)

    camera = metavision_camera.MetavisionCamera.__new__(metavision_camera.MetavisionCamera)
    camera.lock, camera.waiting = threading.Lock(), []
    camera.read(Blocks())
    ends, events = zip(*camera.packets(0.0, (0.0, 0.0)))
    times = numpy.concatenate([numpy.frombuffer(sent, metavision_camera.SENT)["t"] for sent in events])
    check((numpy.diff(times) >= 0).all(), f"times of a camera never go back: {times}")
    check((times <= numpy.repeat(ends, 2)).all(), f"no event is later than its packet: {times} {ends}")


times_of_a_camera_never_go_back()
follows("python", [sys.executable, root + "/examples/robots/practice_head.py", address])
follows("c", [in_c, address])
os.environ["PYTHONPATH"] = root + "/tests/external/stand_in"
follows("metavision", [sys.executable, root + "/examples/robots/metavision_camera.py", address])
servos, command = bus()
follows("dynamixel", command)
time.sleep(0.3)  # the servos' own watchdog
counts = servos.communicate("quit\n")[0]
print(counts, end="")
check("'damaged': 0" in counts and "'rejected': 0" in counts and "'goals': 0" not in counts, "the bus received whole packets: " + counts)
check("[2048, 2048]" not in counts, "the servos have moved: " + counts)
check("[True, True]" in counts, "the servos' own watchdog stopped them when the program was killed: " + counts)
for what in ("mute 2", "fault 1"):
    servos, command = bus()

    def happen():
        servos.stdin.write(what + "\n")
        servos.stdin.flush()

    status, log, states = drive(what.replace(" ", "_"), command, happen, 20)
    causes = " ".join(str(state.get("cause")) for state in states)
    check("tilt" in causes if what == "mute 2" else "pan" in causes, f"{what}: deploy stops the head and names the joint: {causes}\n{log}")
    servos.communicate("quit\n")
print(f"{failures} failures")
sys.exit(failures > 0)
