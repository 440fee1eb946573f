"""The readers of other projects in tests/recording/reference_readers."""

import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np
import saccade

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "tests" / "recording" / "reference_readers"
MODULES = pathlib.Path(os.environ.get("SACCADE_BUILD", ROOT / "build" / "release")).parent / "reference_readers" / "node_modules"


def are_installed():
    return shutil.which("node") is not None and MODULES.exists()


def start(script, *arguments, stdout, stderr):
    interpreter = sys.executable if script.endswith(".py") else "node"
    return subprocess.Popen([interpreter, SCRIPTS / script, *map(str, arguments)], stdout=stdout, stderr=stderr,
                            env={**os.environ, "NODE_PATH": str(MODULES)})


def events_of(records):
    """Events of what a reader wrote (events.cjs): saccade's layout, but times in ns, which must be whole us here."""
    events = np.frombuffer(records, saccade.event_dtype).copy()
    assert np.all(events["t"] % 1000 == 0), "times are not whole us"
    events["t"] //= 1000
    return events
