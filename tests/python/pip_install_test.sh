#!/usr/bin/env bash
# `pip install .` without build isolation and network into a virtual environment that sees the system's packages; then the program
# and the module of that environment. Status 77 where Debian's scikit-build-core or venv is not installed.
# usage: tests/python/pip_install_test.sh FOLDER [BUILD]    the environment, made anew; BUILD: a folder to build in, instead of the
#        one of pyproject.toml, that has compiled files of this checkout
set -euo pipefail

/usr/bin/python3 -c 'import scikit_build_core, venv, ensurepip' 2>/dev/null || {
  echo "Skipped: needs python3-scikit-build-core (Debian 13) and python3-venv"
  exit 77
}
environment=$1
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
rm -rf "$environment"
/usr/bin/python3 -m venv --system-site-packages "$environment"
"$environment/bin/pip" install --no-build-isolation --no-index --no-deps --quiet ${2:+--config-settings=build-dir="$2"} .
cd /
"$environment/bin/python" - <<'PYTHON'
import importlib.metadata, pathlib, subprocess, sys, tempfile
import saccade

prefix = pathlib.Path(sys.prefix)
assert pathlib.Path(saccade.__file__).is_relative_to(prefix), saccade.__file__
about = importlib.metadata.metadata("saccade")
assert about["Version"] == saccade.__version__.split()[0], (about["Version"], saccade.__version__)
assert about["License-Expression"] == "BSD-3-Clause" and about["Summary"] and about["Requires-Python"], dict(about)
env = saccade.Env("look_at_ball", overrides={"run.duration_s": 0.05, "expect": {}})
env.reset()
env.step()
with tempfile.TemporaryDirectory() as folder:
    subprocess.run([prefix / "bin/saccade", "run", "look_at_ball", "--set", "run.duration_s=0.05", "--set", "expect={}",
                    "--out", folder + "/run"], check=True, stdout=subprocess.DEVNULL)
    events = saccade.read(folder + "/run/events.aedat")
    assert len(events) > 0
    assert (pathlib.Path(folder) / "run/report.html").stat().st_size > 10000
print(subprocess.run([prefix / "bin/saccade", "--version"], check=True, capture_output=True, text=True).stdout)
PYTHON
