"""Speeds of the module beside those of the program, in one run on a machine with nothing else to do. Not a test.

usage: PYTHONPATH=build/release/python /usr/bin/python3 tests/python/speed.py [--program build/release/bin/saccade] [--repeat 3]
"""

import argparse
import json
import pathlib
import subprocess
import tempfile
import time

import numpy as np
import saccade

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENARIO = ROOT / "scenarios" / "look_at_ball.yaml"
OVERRIDES = {"run.duration_s": 3.0, "expect": {}, "output.pictures": 0}
EXAMPLE = ROOT / "examples" / "external"


def best_of(repeat, measure):
    return max(measure() for _ in range(repeat))


def run_ticks_per_s(program, folder):
    sets = [word for key, value in OVERRIDES.items() for word in ("--set", f"{key}={json.dumps(value)}")]
    subprocess.run([program, "run", SCENARIO, "--out", folder, "--force", *sets], check=True, capture_output=True)
    return 3000 / json.loads((folder / "metrics.json").read_text())["wall_s"]


def env_ticks_per_s(closed_loop):
    with saccade.Env(SCENARIO, overrides=OVERRIDES, closed_loop=closed_loop) as env:
        env.reset()
        begin = time.perf_counter()
        while not env.step()[3]:
            pass
        return 3000 / (time.perf_counter() - begin)


def processes_ticks_per_s(count):
    """Ticks per second of wall-clock time of `count` environments of gymnasium, each in a process of its own with one thread."""
    import gymnasium
    options = {"overrides": {**OVERRIDES, "run.threads": 1}, "observation": "counts", "action": "velocities", "step_ms": 1}
    envs = gymnasium.make_vec("saccade/LookAtBall-v0", num_envs=count, vectorization_mode="async",
                              vector_kwargs={"context": "spawn"}, **options)
    envs.reset(seed=1)
    still = np.zeros(envs.action_space.shape, np.float32)
    begin = time.perf_counter()
    for _ in range(2000):
        envs.step(still)
    rate = 2000 * count / (time.perf_counter() - begin)
    envs.close()
    return rate


def read_rates(program, folder, events, extension):
    path = folder / ("events" + extension)
    saccade.write(path, events, size=(128, 128))

    def in_python():
        begin = time.perf_counter()
        saccade.read(path, size=(128, 128))
        return len(events) / (time.perf_counter() - begin)

    def in_program():
        begin = time.perf_counter()
        subprocess.run([program, "info", path], check=True, capture_output=True)
        return len(events) / (time.perf_counter() - begin)

    return in_python, in_program


def detect_rates(program, folder, events, name):
    path = folder / "detect.aedat4"
    saccade.write(path, events, size=(128, 128))
    config = folder / "detectors.yaml"
    config.write_text(f"detectors: {{{name}: {{}}}}\n")

    def in_python():
        detector = saccade.detector(name, (128, 128))
        begin = time.perf_counter()
        saccade.detect(detector, events)
        return len(events) / (time.perf_counter() - begin)

    def in_program():
        out = subprocess.run([program, "detect", path, "--config", config, "--json"], check=True, capture_output=True,
                             text=True).stdout
        return 1e6 / json.loads(out)["detectors"][name]["us_per_event"]

    return in_python, in_program


def emulate_rates(program, folder):
    """A bar that moves over 128 x 128 pixels, 400 images at 1 kHz; wall-clock time with start and file of the program."""
    images = np.full((400, 128, 128), 40.0, np.float32)
    for i, image in enumerate(images):
        image[:, i // 4:i // 4 + 24] = 200.0 - 0.2 * i
    path = folder / "images.npy"
    np.save(path, images)

    def in_python():
        emulator = saccade.Emulator((128, 128), threads=2)
        begin = time.perf_counter()
        count = sum(len(emulator.process(image, 1000 * i)) for i, image in enumerate(images)) + len(emulator.finish())
        return count / (time.perf_counter() - begin)

    def in_program():
        out = folder / "emulated.aedat4"
        begin = time.perf_counter()
        subprocess.run([program, "emulate", path, "--fps", "1000", "--out", out, "--force"], check=True, capture_output=True)
        seconds = time.perf_counter() - begin
        return len(saccade.read(out)) / seconds

    return in_python, in_program


def us_per_tick(detector, events, ticks=2000):
    """Wall-clock time of a tick of 1 ms with 100 events."""
    begin = time.perf_counter()
    for k in range(ticks):
        detector.process(events[100 * k:100 * (k + 1)])
        detector.advance_to(1000 * (k + 1))
        detector.estimate()
    return (time.perf_counter() - begin) / ticks * 1e6


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", default=ROOT / "build" / "release" / "bin" / "saccade")
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    folder = pathlib.Path(tempfile.mkdtemp())
    rng = np.random.default_rng(1)
    events = np.zeros(2_000_000, saccade.event_dtype)
    events["t"] = np.arange(1, len(events) + 1) * 10
    angle = rng.uniform(0, 2 * np.pi, len(events))
    events["x"] = np.rint(64 + 12 * np.cos(angle) + 20 * np.sin(1e-6 * events["t"]))
    events["y"] = np.rint(64 + 12 * np.sin(angle))
    events["p"] = np.cos(angle) > 0

    of_run = best_of(options.repeat, lambda: run_ticks_per_s(options.program, folder / "run"))
    of_env = best_of(options.repeat, lambda: env_ticks_per_s(True))
    alone = best_of(options.repeat, lambda: env_ticks_per_s(False))
    print(f"ticks per second: run {of_run:.0f}, Env with its loop {of_env:.0f} ({of_env / of_run:.2f}), "
          f"Env without actions {alone:.0f}")
    try:
        one, two = (best_of(options.repeat, lambda: processes_ticks_per_s(count)) for count in (1, 2))
        print(f"ticks per second of gymnasium's vector environments: one process {one:.0f}, two {two:.0f} ({two / one:.2f})")
    except ImportError:
        print("gymnasium is not installed: vector environments were not measured")
    for extension in (".aedat4", ".aedat", ".csv"):
        ours, theirs = (best_of(options.repeat, rate) / 1e6 for rate in read_rates(options.program, folder, events, extension))
        print(f"read {extension}: Python {ours:.1f}, saccade info {theirs:.1f} Mevent/s")
    ours, theirs = (best_of(options.repeat, rate) / 1e6 for rate in emulate_rates(options.program, folder))
    print(f"emulate: Python {ours:.3f}, saccade emulate {theirs:.3f} Mevent/s")
    part = events[:200_000]
    for name in ("paper_directed", "best"):
        ours, theirs = (best_of(options.repeat, rate) / 1e6 for rate in detect_rates(options.program, folder, part, name))
        print(f"detect {name}: Python {ours:.3f}, saccade detect {theirs:.3f} Mevent/s")

    class_file = folder / "idle.py"
    class_file.write_text("class Idle:\n    threshold = 0.5\n    def __init__(self, size): pass\n"
                          "    def process(self, events, motion): pass\n    def estimate(self): return None\n")
    compiled = folder / "ring_mean_shift"
    subprocess.run(["cc", "-O2", "-o", compiled, EXAMPLE / "ring_mean_shift.c", "-lm"], check=True)
    idle = folder / "idle.c"
    idle.write_text('#include <stdio.h>\nint main(void){char l[4096];long n;long long t;fgets(l,4096,stdin);fgets(l,4096,stdin);'
                    'puts("ready 0.5");fflush(stdout);while(fgets(l,4096,stdin)&&sscanf(l,"tick %lld %ld",&t,&n)==2)'
                    '{while(n-->0)fgets(l,4096,stdin);puts("none");fflush(stdout);}return 0;}\n')
    subprocess.run(["cc", "-O2", "-w", "-o", folder / "idle", idle], check=True)
    for what, keys in (("Python, idle", {"python": f"{class_file}:Idle"}), ("C, idle", {"command": str(folder / "idle")}),
                       ("Python, ring mean shift", {"python": f"{EXAMPLE / 'ring_mean_shift.py'}:RingMeanShift"}),
                       ("C, ring mean shift", {"command": str(compiled)})):
        kind = next(iter(keys))
        measured = min(us_per_tick(saccade.detector(kind, (128, 128), **keys), events) for _ in range(options.repeat))
        print(f"external detector, {what}: {measured:.0f} us per tick of 100 events")


if __name__ == "__main__":
    main()
