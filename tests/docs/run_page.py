"""Runs the code of a reader's page (docs/my_*.md) in its order, in an empty folder: usage: run_page.py PAGE PROGRAM EXPECTED...

Blocks ```sh run in bash, where the first command that fails ends the test; after `<!-- status: N -->` the block has to end with
status N. Blocks ```python run in one interpreter. A block after `<!-- save: NAME -->` becomes that file. Other blocks are not run.
EXPECTED are files that have to be there at the end, and after = what has to be true in the interpreter. Bounds of the watchdog are wide: a busy machine is late.
"""
import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
BLOCK = re.compile(r"(?:<!-- (save|status): (\S+) -->\n)?^```(\w*)\n(.*?)^```$", re.S | re.M)
PATIENT = {
    "safe_within_ms": 1000, "tick_late_ms": 490, "camera_silent_ms": 500, "joints_stale_ms": 500, "hang_ms": 480,
}


def main():
    page, program, expected = Path(sys.argv[1]), Path(sys.argv[2]).resolve(), sys.argv[3:]
    blocks = BLOCK.findall(page.read_text())
    if any(language == "python" and kind != "save" for kind, _, language, _ in blocks):
        try:
            __import__("saccade").Env
        except (ImportError, AttributeError) as error:
            print(f"Skipped: this build has no Python module ({error})")
            return 0
    with tempfile.TemporaryDirectory(prefix="page_") as folder:
        os.chdir(folder)
        for name in ("scenarios", "examples"):
            os.symlink(ROOT / name, name)
        os.mkdir("path")
        patient = " ".join(f"--set deploy.watchdog.{key}={value}" for key, value in PATIENT.items())
        Path("path/saccade").write_text(
            f'#!/bin/sh\ncase "$1" in\n  deploy|guard) exec "{program}" "$@" {patient} --set practice.head=page-{os.getpid()} ;;\n'
            f'  *) exec "{program}" "$@" ;;\nesac\n'
        )
        os.chmod("path/saccade", 0o755)
        os.environ["PATH"] = f"{folder}/path:{os.environ['PATH']}"
        names, ran = {}, 0
        for kind, value, language, code in blocks:
            if kind == "save":
                Path(value).write_text(code)
            elif language == "python":
                exec(compile(code, page.name, "exec"), names)
                ran += 1
            elif language == "sh":
                with open("output.txt", "w+") as output:
                    done = subprocess.Popen(
                        ["bash", "-euo", "pipefail", "-c", code], stdout=output, stderr=output, start_new_session=True
                    )
                    try:
                        status = done.wait(500)
                    finally:  # what a failed block left behind, such as a guard
                        with contextlib.suppress(ProcessLookupError):
                            os.killpg(done.pid, signal.SIGTERM)
                    if status != int(value or 0):
                        output.seek(0)
                        print(f"{page.name}: ended with {status}, expected {value or 0}:\n{code}\n{output.read()}")
                        return 1
                ran += 1
        missing = [
            what for what in expected if not (eval(what[1:], names) if what[0] == "=" else list(Path().glob(what)))
        ]
        if missing or ran == 0:
            print(f"{page.name}: {ran} blocks ran, and {missing} do not hold")
            return 1
        print(f"{page.name}: {ran} blocks ran")
    return 0


if __name__ == "__main__":
    sys.exit(main())
