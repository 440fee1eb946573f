"""MCAP files of runs for Foxglove, read by @mcap/core and held to Foxglove's own schemas, with the layout that opens them."""

import base64
import csv
import json
import subprocess

import numpy as np
import pytest
import reference_readers
import saccade
from common import PROGRAM, SOURCE, run_program

LAYOUT = SOURCE / "examples" / "foxglove" / "saccade.json"


def read(file, *topics):
    if not reference_readers.are_installed() or not (reference_readers.MODULES / "@foxglove" / "schemas").exists():
        pytest.skip("NOT TESTED: node, @mcap/core or Foxglove's schemas are missing; scripts/setup --all installs them")
    process = reference_readers.start("read_foxglove.cjs", file, *topics, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    out, said = process.communicate()
    assert process.returncode == 0, said.decode()
    return json.loads(out)


def table(file):
    with open(file, newline="") as rows:
        return list(csv.DictReader(rows))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The folder of a run of both eyes with all ground truth."""
    folder = tmp_path_factory.mktemp("foxglove") / "run"
    truth = "{rate_hz: 50, images: true, frames: {exposure_ms: 4}, depth: true, flow: true, segmentation: true, poses: true, format: npz}"
    assignments = ["run.duration_s=0.4", "expect={}", "output.pictures=0", "imu={}", "eyes=both", "gaze.stereo=true",
                   "ball.trajectory.start_s=0", "output.events=npz",
                   "detectors={best: {}, paper_directed: {}, paper_full: {}}", f"output.ground_truth={truth}"]
    run_program("run", SOURCE / "scenarios" / "gaze_square_45cm.yaml", "--seed", 5, "--out", folder,
                *(part for a in assignments for part in ("--set", a)))
    return folder


@pytest.fixture(scope="module")
def mcap(run):
    file = run.parent / "run.mcap"
    assert run_program("view", run, "--mcap", file) == f"{file}\n"
    return file


def test_every_message_is_as_foxglove_demands_and_every_row_of_the_tables_has_one(run, mcap):
    topics = read(mcap)["topics"]
    schemas = {topic["schema"] for topic in topics.values()}
    assert schemas >= {"foxglove.CompressedImage", "foxglove.RawImage", "foxglove.ImageAnnotations", "foxglove.CameraCalibration",
                       "foxglove.FrameTransforms", "foxglove.SceneUpdate"}
    assert all(topic["encoding"] == "json" and topic["messages"] > 0 for topic in topics.values())
    for side, suffix in (("left", ""), ("right", "_right")):
        assert topics[f"/{side}/events"]["messages"] == topics[f"/{side}/circles"]["messages"] == 12
        assert topics[f"/{side}/events"]["last"] == 400_000_000
        assert topics[f"/{side}/event_counts"]["messages"] == 400
        assert topics[f"/{side}/truth"]["messages"] == len(table(run / f"truth{suffix}.csv")) == 400
        rows = table(run / f"detections{suffix}.csv")
        for name in {row["detector"] for row in rows}:
            of_detector = [row for row in rows if row["detector"] == name]
            topic = topics[f"/{side}/detections/{name}"]
            assert topic["messages"] == len(of_detector)
            assert topic["first"] == 1000 * int(of_detector[0]["t_us"])
        for kind in ("luminance", "frame", "depth_m", "flow_px_s", "segmentation"):
            topic = topics[f"/{side}/ground_truth/{kind}"]
            assert (topic["messages"], topic["first"], topic["last"]) == (20, 20_000_000, 400_000_000)
    assert topics["/gaze"]["messages"] == len(table(run / "gaze.csv"))
    assert topics["/imu"]["messages"] == len(table(run / "imu.csv"))


def test_values_are_those_of_the_run(run, mcap):
    messages = read(mcap, "/left/circles", "/left/truth", "/right/event_counts", "/tf", "/left/ground_truth/depth_m")["messages"]
    truth = {int(row["t_us"]): row for row in table(run / "truth.csv")}
    for ns, message in messages["/left/truth"]:
        assert message["x_px"] == float(truth[ns // 1000]["x_px"])
    for ns, message in messages["/left/circles"]:
        row = truth[ns // 1000]
        circle = message["circles"][0]  # the ball is in view throughout
        assert circle["position"] == {"x": float(row["x_px"]) + 0.5, "y": float(row["y_px"]) + 0.5}
        assert circle["diameter"] == 2 * float(row["r_px"])
    events = saccade.read(run / "events.npz")
    right = events[events["camera"] == 1]
    on, _ = np.histogram(right["t"][right["p"]], bins=np.arange(0, 401) * 1000 + 0.5)
    assert [message["on_per_ms"] for _, message in messages["/right/event_counts"]] == on.tolist()
    # Ball and camera are where the tables have them; the ball's pose comes another way from the simulator.
    eye = {int(row["t_us"]): row for row in table(run / "eye.csv")}
    compared = 0
    for ns, message in messages["/tf"]:
        if ns == 0:
            continue
        places = {t["child_frame_id"]: [t["translation"][axis] for axis in "xyz"] for t in message["transforms"]}
        for name, row in (("ball_hand", truth[ns // 1000]), ("left_camera", eye[ns // 1000])):
            assert np.allclose(places[name], [float(row[f"{axis}_m"]) for axis in "xyz"], atol=2e-5), (ns, name)
        compared += 1
    assert compared == 40
    ground_truth = saccade.GroundTruth(run)
    for (_, message), depth in zip(messages["/left/ground_truth/depth_m"], ground_truth["left/depth_m"]):
        found = np.frombuffer(base64.b64decode(message["data"]), "<f4").reshape(message["height"], message["width"])
        assert np.array_equal(found, depth, equal_nan=True)


def panels(layout):
    if isinstance(layout, str):
        return [layout]
    return [panel for side in ("first", "second") for panel in panels(layout[side])]


def test_the_layout_names_topics_and_members_of_the_file(mcap):
    layout = json.loads(LAYOUT.read_text())
    assert set(layout) == {"configById", "globalVariables", "userNodes", "playbackConfig", "layout"}
    shown = panels(layout["layout"])
    for panel in list(shown):
        for tab in layout["configById"][panel].get("tabs", []):
            shown += panels(tab["layout"])
    assert sorted(shown) == sorted(layout["configById"])
    paths = [path["value"].split(".") for config in layout["configById"].values() for path in config.get("paths", [])]
    plotted = sorted({topic for topic, _ in paths})
    content = read(mcap, *plotted)
    for topic, member in paths:
        # A detector without an observation in so short a run has no message.
        assert topic in content["topics"], topic
        assert not content["messages"][topic] or any(member in message for _, message in content["messages"][topic]), topic
    for config in layout["configById"].values():
        image = config.get("imageMode")
        if image:
            assert content["topics"][image["imageTopic"]]["schema"] in ("foxglove.CompressedImage", "foxglove.RawImage")
            for topic in image.get("annotations", {}):
                assert content["topics"][topic]["schema"] == "foxglove.ImageAnnotations"
        for topic in config.get("topics", {}):
            assert topic in content["topics"], topic


def refusal(*arguments):
    done = subprocess.run([PROGRAM, "view", *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 2, done.stderr
    return done.stderr


def test_what_cannot_be_written_is_refused_with_one_message(run, mcap, tmp_path):
    before = mcap.read_bytes()
    assert "a file that exists, expected another name, or --force" in refusal(run, "--mcap", mcap)
    assert mcap.read_bytes() == before
    run_program("view", run, "--mcap", mcap, "--force")
    assert mcap.read_bytes() == before, "the same run gives the same bytes"
    assert "the folder of a run" in refusal(run / "events.npz", "--mcap", tmp_path / "a.mcap")
    assert "the folder of a run" in refusal(SOURCE / "scenarios" / "gaze_square_45cm.yaml", "--mcap", tmp_path / "a.mcap")
    assert "--fps" in refusal(run, "--mcap", tmp_path / "a.mcap", "--fps", 0)
    assert list(tmp_path.iterdir()) == []
