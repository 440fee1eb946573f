"""Draws a disc on annotated circles, for `saccade emulate`: the twin of a recording of a ball before a plain background.

usage: draw_twin.py CIRCLES.csv WIDTHxHEIGHT LIGHT.npy TIMES.txt

CIRCLES.csv is a table t_us,x_px,y_px,r_px. The disc is dark (40) before light (120), and moves by at most 0.25 px from one image to
the next, in a straight line from circle to circle.
"""
import sys

import numpy as np

DARK, LIGHT = 40, 120
STEP_PX = 0.25


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__.strip())
    circles, size, light, times_file = sys.argv[1:]
    t, *circle = np.genfromtxt(circles, delimiter=",", skip_header=1)[:, :4].T
    width, height = map(int, size.split("x"))
    steps = [max(1, int(np.ceil(max(abs(c[k + 1] - c[k]) for c in circle) / STEP_PX))) for k in range(len(t) - 1)]
    parts = [np.linspace(t[k], t[k + 1], count, endpoint=False) for k, count in enumerate(steps)]
    times = np.unique(np.concatenate([*parts, t[-1:]]).astype(np.int64))
    images = np.lib.format.open_memmap(light, "w+", np.uint8, (len(times), height, width))
    rows, columns = np.mgrid[:height, :width]
    for image, x, y, r in zip(images, *(np.interp(times, t, values) for values in circle)):
        share = np.clip(r - np.hypot(columns - x, rows - y) + 0.5, 0, 1)
        image[:] = np.round(LIGHT + share * (DARK - LIGHT))
    np.savetxt(times_file, times, "%d")


if __name__ == "__main__":
    main()
