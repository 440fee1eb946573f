"""The installed program and module, in a folder of their own."""

import os
import subprocess
import sys

from common import SOURCE

STEP = """
import saccade, sys
env = saccade.Env(sys.argv[1], overrides={"run.duration_s": 0.05, "expect": {}})
env.reset()
env.step()
print(saccade.__file__)
"""


def test_the_installed_module_steps_and_uses_the_installed_models(tmp_path):
    prefix = tmp_path / "prefix"
    for component in ("program", "python"):
        subprocess.run(["cmake", "--install", os.environ["SACCADE_BUILD"], "--prefix", prefix, "--component", component],
                       check=True, capture_output=True)
    folder = prefix / "lib" / "python3" / "dist-packages"
    scenario = prefix / "share" / "saccade" / "scenarios" / "look_at_ball.yaml"
    environment = {**os.environ, "PYTHONPATH": str(folder)}

    def step():
        return subprocess.run([sys.executable, "-c", STEP, scenario], env=environment, capture_output=True, text=True,
                              cwd=tmp_path)

    def run():
        return subprocess.run([prefix / "bin" / "saccade", "run", scenario, "--set", "run.duration_s=0.05", "--set",
                               "expect={}", "--set", "output.video=true", "--out", tmp_path / "run", "--force"],
                              capture_output=True, text=True)

    done = step()
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(str(folder))
    assert run().returncode == 0
    codecs = prefix / "libexec" / "saccade" / "saccade-image-codecs.so"
    whole = codecs.read_bytes()
    codecs.write_bytes(b"no library")
    failed = run()
    assert failed.returncode == 1 and str(codecs) in failed.stderr
    codecs.write_bytes(whole)
    model = prefix / "share" / "saccade" / "models" / "icub_head.xml"
    assert model.read_bytes() == (SOURCE / "models" / "icub_head.xml").read_bytes()
    model.unlink()
    for failed in (step(), run()):
        assert failed.returncode != 0 and str(model) in failed.stderr


def test_the_installed_program_has_the_worker_of_classes_in_python(tmp_path):
    subprocess.run(["cmake", "--install", os.environ["SACCADE_BUILD"], "--prefix", tmp_path, "--component", "program"],
                   check=True, capture_output=True)
    worker = tmp_path / "libexec" / "saccade" / "saccade-worker"
    assert os.access(worker, os.X_OK)
