#!/usr/bin/env python3
"""A random search over the two gains of a proportional gaze controller, in gaze_circle at 1 Hz.

usage: random_search.py [--seconds 180] [--processes 2] [--seed 1]

The controller turns the eyes towards the circle of the detector `best`, with a gain for pan and one for tilt, in 1/s. The search
draws gains and keeps those with the largest share of time on target on two seeds. It then shows that share before and after
on two other seeds. It needs the module saccade (docs/gymnasium.md), and neither gymnasium nor a learning library.
"""

import argparse
import multiprocessing
import time

import numpy as np
import saccade

SEARCHED, SHOWN = (11, 12), (21, 22)  # seeds
START = (4.0, 4.0)
FIRST_S = 1.0  # before it the ball gains speed


def on_target(job):
    """Share of the time after FIRST_S in which the left eye looks within 2 deg of the ball."""
    gains, seed, duration_s = job
    overrides = {"ball.trajectory.frequency_hz": 1.0, "run.duration_s": duration_s, "run.threads": 1, "expect": {}}
    detector = saccade.detector("best", size=(128, 128))
    with saccade.Env("scenarios/gaze_circle.yaml", seed=seed, overrides=overrides, reward="on_target",
                     action="velocities", step_ms=5) as env:
        observation, _ = env.reset()
        speeds = np.array([env.speed_rad_s[name] for name in ("eyes_version", "eyes_tilt")])
        pan, tilt = (env.joint_names.index(name) for name in ("eyes_version", "eyes_tilt"))
        rewards, truncated = [], False
        while not truncated:
            motion = env.camera_motion()
            detector.process(observation["events"], motion)
            detector.advance_to(observation["t_us"], motion)
            circle, action = detector.estimate(), np.zeros(len(env.joint_names))
            if circle is not None and circle.score >= detector.threshold:
                camera = observation["camera"]
                error_rad = ((circle.x_px - camera["cx_px"]) / camera["fx_px"],
                             (camera["cy_px"] - circle.y_px) / camera["fy_px"])
                action[[pan, tilt]] = np.clip(np.array(gains) * error_rad / speeds, -1.0, 1.0)
            observation, reward, _, truncated, _ = env.step(action)
            if observation["t_us"] > FIRST_S * 1e6:
                rewards.append(reward)
    return float(np.mean(rewards))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=180.0, help="wall-clock time of the search")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1, help="of the search")
    parser.add_argument("--duration", type=float, default=3.0, help="of an episode, s of simulated time")
    options = parser.parse_args()
    random = np.random.default_rng(options.seed)
    with multiprocessing.get_context("spawn").Pool(options.processes) as pool:
        def share(gains, seeds):
            return float(np.mean(pool.map(on_target, [(gains, seed, options.duration) for seed in seeds], 1)))

        begin = time.monotonic()
        best, best_share, tried = START, share(START, SEARCHED), 1
        print(f"start: gains {START}, {best_share:.3f} of the time on target", flush=True)
        while time.monotonic() - begin < options.seconds:
            gains = tuple(np.round(np.exp(random.uniform(np.log(2.0), np.log(100.0), 2)), 1).tolist())
            tried += 1
            if (found := share(gains, SEARCHED)) > best_share:
                best, best_share = gains, found
                print(f"{tried}: gains {gains}, {found:.3f}", flush=True)
        print(f"{tried} pairs of gains in {time.monotonic() - begin:.0f} s")
        print(f"on other seeds: before {share(START, SHOWN):.3f}, after {share(best, SHOWN):.3f}, gains {best}")


if __name__ == "__main__":
    main()
