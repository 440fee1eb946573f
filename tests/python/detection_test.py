import numpy as np
import pytest
import saccade
from common import circle_events, run_program


def test_every_detector_of_the_registry_is_made_and_takes_events():
    events = circle_events(seconds=0.2)
    names = saccade.detectors()
    assert {"best", "paper_full", "paper_directed"} <= set(names)
    for name in set(names) - {"python", "command", "socket"}:  # these need a file or an address
        detector = saccade.detector(name, size=(128, 128))
        assert detector.name == name and np.isfinite(detector.threshold)
        detector.process(events)
        detector.advance_to(int(events["t"][-1]))
        detector.estimate()


def test_a_disc_is_found_where_it_is():
    events = circle_events(radius_px=12.0)
    detector = saccade.detector("best", size=(128, 128), radius_px=(4, 25))
    assert detector.estimate() is None
    rows = saccade.detect(detector, events)
    estimate = detector.estimate()
    x, y, r = estimate.circle
    centre_x = 40 + 60e-6 * events["t"][-1]
    # Events lie on whole pixels, uniformly around an outline of 12 px: a pixel and a half in each is far off.
    assert abs(x - centre_x) < 1.5 and abs(y - 64) < 1.5 and abs(r - 12) < 1.5
    assert estimate.score > 0 and not estimate.held
    assert rows.dtype.names == ("t_us", "x_px", "y_px", "r_px", "score", "held", "covariance_px2") and len(rows) > 100


def test_keys_are_those_of_the_files():
    assert saccade.detector("paper_full", (64, 64), window={"events": 700}).window == "700 events"
    assert saccade.detector("paper_full", (64, 64), threshold=0.25).threshold == 0.25


def test_wrong_names_and_keys_are_value_errors():
    with pytest.raises(ValueError, match="expected .*best"):
        saccade.detector("bst", (128, 128))
    with pytest.raises(ValueError, match="radius"):
        saccade.detector("best", (128, 128), radius=(4, 25))
    with pytest.raises(ValueError, match="radius_px"):
        saccade.detector("best", (128, 128), radius_px=(25, 4))
    with pytest.raises(ValueError, match="size"):
        saccade.detector("best", (0, 128))
    with pytest.raises(ValueError, match="size and camera"):
        saccade.detector("best")


def test_detections_are_those_of_the_program(tmp_path):
    events = circle_events()
    saccade.write(tmp_path / "a.aedat4", events, size=(128, 128))
    run_program("detect", tmp_path / "a.aedat4", "--out", tmp_path / "run")
    lines = (tmp_path / "run" / "detections.csv").read_text().splitlines()[1:]
    for name in ("paper_full", "best"):
        ours = saccade.detect(saccade.detector(name, (128, 128)), events)
        theirs = [line.split(",") for line in lines if line.split(",")[1] == name]
        assert len(theirs) > 100
        last_us = ours["t_us"][-1]  # the program ticks on to the end of the last millisecond
        for column, field in ((0, "t_us"), (2, "x_px"), (3, "y_px"), (4, "r_px"), (5, "score"), (6, "held")):
            assert [float(row[column]) for row in theirs if int(row[0]) <= last_us] == ours[field].tolist(), field


def test_the_motion_of_the_camera_is_taken():
    detector = saccade.detector("best", camera=saccade.camera())
    motion = saccade.camera_motion({"neck_yaw": 0.1}, {"neck_yaw": 0.5})
    assert motion.root_from_camera.shape == (4, 4) and np.linalg.norm(motion.angular_velocity_rad_s) > 0.4
    detector.process(circle_events(), motion)
    detector.advance_to(600_000, motion)


def test_rejected_events_are_counted():
    events = circle_events()
    events["x"][7] = 500
    detector = saccade.detector("paper_full", (128, 128))
    detector.process(events)
    assert detector.rejected == {"outside_image": 1, "back_in_time": 0}


def test_instants_of_ones_own_are_those_of_ground_truth_made_by_hand(tmp_path):
    events = circle_events()
    saccade.write(tmp_path / "a.aedat4", events, size=(128, 128))
    at_us = [100_123, 200_456, 204_000, 300_789]
    rows = "".join(f"{t},{40 + 60e-6 * t},64,12\n" for t in at_us)
    (tmp_path / "truth.csv").write_text("t_us,x_px,y_px,r_px\n" + rows)
    run_program("detect", tmp_path / "a.aedat4", "--truth", tmp_path / "truth.csv", "--out", tmp_path / "run")
    lines = (tmp_path / "run" / "detections.csv").read_text().splitlines()[1:]
    theirs = [[float(v) for v in (row[0], *row[2:6])] for row in (line.split(",") for line in lines) if row[1] == "best"]
    ours = saccade.detect(saccade.detector("best", (128, 128)), events, at_us=at_us)
    assert len(theirs) > 2
    assert [list(row)[:5] for row in ours.tolist()] == theirs
    figures = saccade.score(ours, tmp_path / "truth.csv")
    assert figures["mine"]["average_precision"] > 0.5
    with pytest.raises(ValueError, match="at_us.1.: found 5, expected a time after the one before it, 7"):
        saccade.detect(saccade.detector("best", (128, 128)), events, at_us=[7, 5])
    with pytest.raises(ValueError, match="start_us and at_us"):
        saccade.detect(saccade.detector("best", (128, 128)), events, 0, [7])


def test_wrong_types_are_type_errors_that_name_argument_value_and_expectation():
    class Mine:
        pass

    detector = saccade.detector("best", (128, 128))
    wrong = (
        (lambda: saccade.detect(Mine(), circle_events()), "detector: found Mine, expected what saccade.detector.. returns"),
        (lambda: detector.advance_to("soon"), "Detector.advance_to: t_us: found 'soon' .str., expected a whole number"),
        (lambda: detector.process(circle_events(), 3), "process: motion: found 3 .int., expected a saccade.CameraMotion, or N"),
        (lambda: saccade.detector(3, (128, 128)), "Detector: name: found 3 .int., expected a text"),
        (lambda: saccade.detector("best", "big"), "size: found 'big' .str., expected two whole numbers, .width, height."),
        (lambda: saccade.camera().project([1, 2]), r"Camera.project: points_m: found .*, expected an array .* \(N, 3\)"),
        (lambda: saccade.root_from_eye({}, 3), "root_from_eye: eye: found 3 .int., expected a text"),
        (lambda: saccade.Emulator((64, 48), seed="x"), "Emulator: seed: found 'x' .str., expected a whole number"),
        (lambda: detector.estimate(1), "Detector.estimate: found the arguments .1 .int.., expected"),
    )
    for call, message in wrong:
        with pytest.raises(TypeError, match=message) as caught:
            call()
        assert "incompatible" not in str(caught.value) and "Invoked with" not in str(caught.value)
