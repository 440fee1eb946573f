"""The tutorial of docs/dataset.md at a tenth of its size: tutorial_test.py SACCADE FOLDER."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

EXAMPLE = Path(__file__).resolve().parents[2] / "examples/dataset"


def check(right, text):
    if not right:
        sys.exit(f"tutorial_test: {text}")


def run(*words):
    print("+", *words, flush=True)
    done = subprocess.run(list(map(str, words)), stdout=subprocess.PIPE, text=True)
    print(done.stdout, flush=True)
    check(done.returncode == 0, f"status {done.returncode}")
    return done.stdout


def main():
    saccade, out = sys.argv[1], Path(sys.argv[2])
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    seeds = re.compile(r"seeds: (\d+)")
    text = (EXAMPLE / "balls.yaml").read_text()
    check(len(seeds.findall(text)) == 2, "the file of the data set has not two splits of seeds")
    (out / "tenth.yaml").write_text(seeds.sub(lambda match: f"seeds: {-(-int(match[1]) // 10)}", text))
    run(saccade, "dataset", out / "tenth.yaml", "--out", out / "balls")
    run(saccade, "dataset", "check", out / "balls")
    said = run(sys.executable, EXAMPLE / "train.py", out / "balls", "--minutes", 1, "--out", out / "trained", "--saccade", saccade,
               "--seeds", 1, "--set", "run.duration_s=1.2")
    right = float(re.search(r"right at ([\d.]+) of the training instants", said)[1])
    # 1.00 was measured; a circle by chance is right at less than 0.01.
    check(right > 0.5, f"right at {right} of the training instants, expected more than 0.5")
    for detector in ("trained", "paper_directed"):
        row = re.search(rf"^{detector} +([\d.]+) +([\d.]+)$", said, re.M)
        check(row and all(0 <= float(figure) <= 1 for figure in row.groups()), f"no row of {detector}")
        check((out / f"trained/gaze_square_45cm_{detector}_1/report.html").exists(), f"no report of {detector}")


if __name__ == "__main__":
    main()
