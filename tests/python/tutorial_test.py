"""The code of docs/python.md, in its order, in an empty folder."""

import os
import re

import pytest
from common import SOURCE

BLOCKS = re.findall(r"^```python\n(.*?)^```$", (SOURCE / "docs" / "python.md").read_text(), re.S | re.M)


def test_the_code_of_the_tutorial_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    os.symlink(SOURCE / "scenarios", tmp_path / "scenarios")
    os.symlink(SOURCE / "examples", tmp_path / "examples")
    names = {}
    for number, block in enumerate(BLOCKS):
        try:
            exec(compile(block, f"docs/python.md, block {number + 1}", "exec"), names)
        except Exception as error:
            pytest.fail(f"block {number + 1} of docs/python.md: {error!r}\n{block}")
    assert len(BLOCKS) >= 6
    assert names["figures"]["best"]["average_precision"] > 0.1  # what the text promises: it finds the ball
    assert names["info"]["rejected"] is None  # the head takes what the text sends
