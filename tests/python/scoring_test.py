import json

import numpy as np
import pytest
import saccade
from common import SOURCE, run_program


def truth_table(count=200):
    t_us = 1000 * np.arange(1, count + 1)
    return {"t_us": t_us, "x_px": 30 + 0.1 * t_us / 1000, "y_px": np.full(count, 60.0), "r_px": np.full(count, 10.0)}


def detections_table(truth):
    """Every second instant exact, every tenth 20 px away with a lower score."""
    detections = {name: values[::2].copy() for name, values in truth.items()}
    detections["score"] = np.full(len(detections["t_us"]), 0.9)
    detections["x_px"][::5] += 20
    detections["score"][::5] = 0.2
    return detections


def test_figures_follow_from_their_definition():
    truth = truth_table()
    figures = saccade.score(detections_table(truth), truth, threshold=0.1)["mine"]
    assert figures["chances"] == 200
    assert figures["precision"] == pytest.approx(80 / 100) and figures["recall"] == pytest.approx(80 / 200)
    assert figures["average_precision"] == pytest.approx(80 / 200)  # all inliers have the higher score


def test_without_a_threshold_its_figures_are_unknown():
    truth = truth_table()
    figures = saccade.score(detections_table(truth), truth)["mine"]
    assert figures["precision"] is None and figures["average_precision"] is not None


def test_figures_are_those_of_the_program(tmp_path):
    truth, detections = truth_table(), detections_table(truth_table())
    with open(tmp_path / "truth.csv", "w") as f:
        f.write("t_us,x_px,y_px,r_px\n")
        f.writelines(f"{t},{x!r},{y!r},{r!r}\n" for t, x, y, r in zip(*(truth[k].tolist() for k in truth)))
    with open(tmp_path / "detections.csv", "w") as f:
        f.write("t_us,detector,x_px,y_px,r_px,score\n")
        columns = (detections[k].tolist() for k in ("t_us", "x_px", "y_px", "r_px", "score"))
        f.writelines(f"{t},mine,{x!r},{y!r},{r!r},{s!r}\n" for t, x, y, r, s in zip(*columns))
    theirs = json.loads(run_program("score", tmp_path / "detections.csv", "--truth", tmp_path / "truth.csv",
                                    "--threshold", "mine=0.5", "--json"))["detectors"]
    assert saccade.score(detections, truth, threshold={"mine": 0.5}) == theirs
    assert saccade.score(tmp_path / "detections.csv", tmp_path / "truth.csv", threshold=0.5) == theirs


def test_rows_may_be_dicts_or_structured_arrays():
    truth, detections = truth_table(), detections_table(truth_table())
    expected = saccade.score(detections, truth, threshold=0.1)
    rows = [dict(zip(detections, values)) for values in zip(*detections.values())]
    array = np.zeros(len(truth["t_us"]), [("t_us", "i8"), ("x_px", "f8"), ("y_px", "f8"), ("r_px", "f8")])
    for field in array.dtype.names:
        array[field] = truth[field]
    assert saccade.score(rows, array, threshold=0.1) == expected


def test_tables_that_are_wrong_are_value_errors(tmp_path):
    truth = truth_table()
    with pytest.raises(ValueError, match="r_px"):
        saccade.score({"t_us": [1], "x_px": [1], "y_px": [1]}, truth)
    with pytest.raises(ValueError, match="no such file|absent.csv"):
        saccade.score(tmp_path / "absent.csv", truth)
    with pytest.raises(ValueError, match="expected one of mine"):
        saccade.score(detections_table(truth), truth, threshold={"other": 0.5})


def test_the_report_of_a_run_folder_is_written_anew_with_figures_for_a_paper(tmp_path):
    run_program("run", SOURCE / "examples" / "scenario" / "slow_line.yaml", "--out", tmp_path / "run", "--set",
                "run.duration_s=0.3", "--set", "expect={}", "--set", "output.pictures=1")
    page = tmp_path / "run" / "report.html"
    before = page.read_bytes()
    page.unlink()
    assert saccade.report(tmp_path / "run", figures=tmp_path / "paper") == str(page)
    assert page.read_bytes() == before
    assert {"svg", "pdf", "csv"} == {path.suffix[1:] for path in (tmp_path / "paper").iterdir()}
    with pytest.raises(ValueError, match="metrics.json"):
        saccade.report(tmp_path)


def test_the_example_of_the_readme_scores_the_events_of_a_run(tmp_path):
    run_program("run", SOURCE / "examples" / "scenario" / "slow_line.yaml", "--out", tmp_path / "run", "--set",
                "run.duration_s=0.8", "--set", "expect={}", "--set", "output.pictures=0", "--set", "output.events=aedat4")
    events = saccade.read(tmp_path / "run" / "events.aedat4")
    best = saccade.detector("best", size=(128, 128))
    truth = tmp_path / "run" / "truth.csv"
    detections = saccade.detect(best, events)
    assert events["t"][0] % 1000 and not np.any(detections["t_us"] % 1000)
    figures = saccade.score(detections, truth, threshold=best.threshold)
    assert figures["mine"]["average_precision"] > 0.3
    between = saccade.detect(saccade.detector("best", size=(128, 128)), events, start_us=500)
    with pytest.raises(ValueError, match="none at an instant of it: the truth has t_us = 1000, 2000, 3000, ..., the det"):
        saccade.score(between, truth)
