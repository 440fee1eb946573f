import pytest
import saccade
from common import SOURCE, circle_events

EXAMPLE = SOURCE / "examples" / "external" / "ring_mean_shift.py"


def test_a_detector_in_a_file_of_its_own_is_made_as_the_others_are():
    detector = saccade.detector("python", (128, 128), python=f"{EXAMPLE}:RingMeanShift", arguments="threshold=0.4")
    events = circle_events()
    rows = saccade.detect(detector, events)
    assert detector.threshold == 0.4 and detector.failure == ""
    # The disc moves to the right at 60 px/s: the estimate lags by half a window of 500 events, 12 ms, 0.75 px.
    assert abs(rows["x_px"][-1] - (40 + 60e-6 * rows["t_us"][-1])) < 1.5 and abs(rows["r_px"][-1] - 12) < 1.0


def test_the_end_of_its_program_is_reported(tmp_path):
    (tmp_path / "mine.py").write_text("class Mine:\n  threshold = 0.5\n  def __init__(self, size): pass\n"
                                      "  def process(self, events, motion): raise KeyError('x')\n"
                                      "  def estimate(self): return None\n")
    detector = saccade.detector("python", (128, 128), python=f"{tmp_path / 'mine.py'}:Mine")
    detector.process(circle_events())
    detector.advance_to(1_000_000)
    assert detector.estimate() is None and "KeyError: 'x' (mine.py, line 4)" in detector.failure


def test_a_file_that_is_missing_is_a_value_error(tmp_path):
    with pytest.raises(ValueError, match="FILE.py:CLASS"):
        saccade.detector("python", (128, 128))
    with pytest.raises(ValueError, match="a file that exists"):
        saccade.detector("command", (128, 128), command=str(tmp_path / "absent"))
    with pytest.raises(RuntimeError, match="AttributeError: module .own. has no attribute .Absent."):
        saccade.detector("python", (128, 128), python=f"{EXAMPLE}:Absent")


def test_a_class_gets_the_motion_and_the_time(tmp_path):
    (tmp_path / "mine.py").write_text("class Mine:\n  threshold = 0.5\n  def __init__(self, size, gain=1): self.gain = gain; self.t = 0\n"
                                      "  def process(self, events, motion): self.motion = motion\n"
                                      "  def advance_to(self, t_us, motion): self.t, self.motion = t_us, motion\n"
                                      "  def estimate(self):\n"
                                      "    return self.t, self.gain * self.motion.root_from_camera[2, 3], 1, 0.9, True, (1, 2, 3, 4, 5, 6)\n")
    detector = saccade.detector("python", (128, 128), python=f"{tmp_path / 'mine.py'}:Mine", arguments="gain=2")
    motion = saccade.camera_motion({"neck_yaw": 0.1})
    detector.process(circle_events()[:5], motion)
    detector.advance_to(5000, motion)
    estimate = detector.estimate()
    assert estimate.x_px == 5000 and estimate.y_px == 2 * motion.root_from_camera[2, 3] and estimate.held
    assert estimate.covariance_px2.tolist() == [[1, 2, 3], [2, 4, 5], [3, 5, 6]]
