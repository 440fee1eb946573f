#!/usr/bin/env python3
"""Verifies stop.pml by Spin: no state violates a property, and one does for each mutant.
usage: check.py    status 0, 1 for a failure; without spin or cc it prints "Skipped" """
import os, re, shutil, subprocess, sys, tempfile

MUTANTS = ((0, 1, "the model, one fault"), (0, 2, "the model, two faults"), (2, 1, "no guard"),
           (3, 1, "the board takes references of any activation"), (4, 1, "the camera's silence is not looked at"),
           (5, 1, "the guard's is not"), (6, 1, "references go on after a stop"),
           (7, 2, "the guard is told of a stop before it is sent"),
           (9, 1, "the head moves again after a stop and an activation (reached)"))
LATER = {1: 0, 2: 4}  # by number of faults
if not (shutil.which("spin") and shutil.which("cc")):
    print("Skipped: found no spin, expected Debian's packages spin and gcc")
    sys.exit(0)
model = os.path.join(os.path.dirname(os.path.abspath(__file__)), "stop.pml")
failures = 0
with tempfile.TemporaryDirectory() as folder:
    for mutant, faults, what in MUTANTS:
        def run(*command):
            return subprocess.run(command, cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        made = run("spin", f"-DMUTANT={mutant}", f"-DFAULTS={faults}", f"-DLATER={LATER[faults]}", "-a", model)
        built = run("cc", "-O2", "-DSAFETY", "-DCOLLAPSE", "-DMEMLIM=3000", "-o", "pan", "pan.c")
        if made.returncode or built.returncode:
            sys.exit(made.stdout + built.stdout)
        text = run("./pan", "-m1000000", "-w24").stdout
        errors, states = re.search(r"errors: (\d+)", text), re.search(r"([\d.e+]+) states, stored", text)
        whole = errors and "Search not completed" not in text and "max search depth too small" not in text
        holds = bool(whole) and errors[1] == "0" and "assertion violated" not in text
        broken = "assertion violated" in text
        passed = holds if mutant == 0 else broken
        failures += not passed
        print("passed" if passed else "FAILED", f"{what}:", "no violation" if holds else "a violation" if broken else text,
              f"in {float(states[1]):.0f} states" if states else "")
sys.exit(failures > 0)
