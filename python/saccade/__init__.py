"""saccade from Python: event recordings, detectors, the event camera emulator, scoring and the closed loop.

Events are structured arrays of `event_dtype`: x and y (uint16, pixels), p (bool, True = ON = brighter), t (int64, us) and
camera (uint8, 0 left, 1 right). Functions take any structured array with the fields x, y, p and t (as_events).

Problems with input raise ValueError with place, value and expectation; runs that cannot go on raise RuntimeError.
docs/python.md is the tutorial.
"""

import os as _os

try:
    import numpy as _np
except ImportError as _error:
    raise ImportError("saccade needs NumPy (Debian package python3-numpy)") from _error
try:
    from . import _saccade
except ImportError as _error:
    from .missing_module import reason as _reason
    raise ImportError(_reason(_error)) from _error
from . import plain_errors as _plain_errors

_plain_errors.install()

from ._saccade import Camera, CameraMotion, Detector, Estimate, Recording, joint_names
from ._saccade import version as __version__
from .arrays import as_events, event_dtype, joint_vector as _joint_vector, score
from .dataset import Dataset
from .environment import Env
from .ground_truth import GroundTruth
from .spaces import register as _register
from .yaml_text import keys_text as _keys_text

__all__ = [
    "Camera", "CameraMotion", "Dataset", "Detector", "Emulator", "Env", "Estimate", "GroundTruth", "Recording", "as_events", "camera",
    "camera_motion", "detect", "detector", "detectors", "emulate", "emulator_presets", "event_dtype", "fixation_point", "formats",
    "iterate", "joint_names", "open", "read", "replay", "report", "root_from_eye", "score", "write",
]

_register()


def open(path, *, size=None, camera=None, columns="auto", time_unit=None, yarp_codec="auto", aedat2_layout="auto",
         evt_encoding="auto", event_stream_y="up", format="auto"):
    """Opens a recording; the format follows from its content.

    size: (width, height) where the file has none. camera: only the events of this camera. columns: order of the columns
    of text, arrays and tables; auto: that of the file's names, else txyp. time_unit: s, ms, us or ns, of the times in text,
    NumPy's arrays and HDF5; None: the file's own. yarp_codec, aedat2_layout, evt_encoding: layout of files that do not name
    theirs, and event_stream_y, format, as `saccade info --help` lists them.
    """
    return _saccade.open_recording(_os.fspath(path), size, camera, columns, time_unit, yarp_codec, aedat2_layout,
                                   evt_encoding, event_stream_y, format)


def read(path, **options):
    """All events of a recording, in file order. Options as of open()."""
    return open(path, **options).read(2**62)


def iterate(path, *, count=None, duration_us=None, **options):
    """The events of a recording in pieces, in fixed memory: `count` events each, or windows of `duration_us`.

    Windows begin at the first event's time; window i holds the events with t in [t_0 + i d, t_0 + (i + 1) d), also
    where there are none. Events whose time goes back are in the window in which the file has them.
    """
    if (count is None) == (duration_us is None):
        raise ValueError("iterate: found both or none of count and duration_us, expected one of them")
    step = count if duration_us is None else duration_us
    if step < 1:
        raise ValueError(f"iterate: found {step}, expected a number from 1")
    return _pieces(open(path, **options), count, duration_us)


def _pieces(recording, count, duration_us):
    while True:
        events = recording.read(count) if duration_us is None else recording.read_window(duration_us)
        if events is None or (duration_us is None and len(events) == 0):
            return
        yield events


def write(path, events, *, size):
    """Writes a recording; the extension selects the format. size: (width, height) of the images.

    Events of camera 1 make a recording of two cameras. An event that the format cannot hold is a ValueError, and no
    file appears.
    """
    _saccade.write(_os.fspath(path), events, size)


def formats():
    """The formats of recordings: a list of dicts with name, extensions and written."""
    return _saccade.formats()


def detectors():
    """The detectors by name, with one line of description each."""
    return _saccade.detectors()


def detector(name, size=None, *, camera=None, **keys):
    """A detector of the registry for images of `size` (width, height), or a Python object or class of your own with the
    members of docs/external_detectors.md, in this process; then there are no keys.

    camera: the assumed calibration, a Camera; without it the lens of the default camera, as `saccade detect` uses for a
    recording without a calibration. Keys are those of a scenario's block `detectors`: radius_px=(4, 25),
    window={"events": 700}.
    """
    if (size is None) == (camera is None):
        raise ValueError("detector: found both or none of size and camera, expected one of them")
    if camera is None:
        camera = _saccade.camera_of_size(size)
    if not _is_own(name):
        return Detector(name, _keys_text(keys), camera)
    if keys:
        raise TypeError(f"detector: found the key {next(iter(keys))} for an object of your own, expected none")
    return Detector(name, camera)


def _is_own(detector):
    return hasattr(detector, "process") and hasattr(detector, "estimate") and not isinstance(detector, Detector)


_detection_dtype = _np.dtype([("t_us", "i8"), ("x_px", "f8"), ("y_px", "f8"), ("r_px", "f8"), ("score", "f8"),
                              ("held", "?"), ("covariance_px2", "f8", (6,))])


def detect(detector, events, start_us=None, at_us=None):
    """Passes events to a detector and returns its estimates, a structured array with the fields t_us, x_px, y_px, r_px,
    score, held and covariance_px2 (xx, xy, xr, yy, yr, rr; 0: unknown): one row per instant with an estimate and an event, or
    with a held estimate. detector: what detector() returns, or an object of your own with process(), estimate() and threshold.

    Instants are at whole milliseconds, as in `saccade detect`; with start_us 1 ms apart from there on. at_us: the instants
    themselves, sorted, such as those of ground truth made by hand; an estimate needs an event in the 10 ms before its
    instant then, as with `saccade detect --truth`.
    """
    if isinstance(detector, type):
        raise TypeError(f"detector: found the class {detector.__name__}, expected an object of it")
    if _is_own(detector):
        detector = Detector(detector, _saccade.camera_of_size((65535, 65535)))
    if not isinstance(detector, Detector):
        raise TypeError(f"detector: found {_plain_errors.shown(detector)}, expected what saccade.detector() returns, "
                        "or an object with process(), estimate() and threshold")
    if at_us is not None:
        if start_us is not None:
            raise ValueError("detect: found start_us and at_us, expected one of them")
        at_us = _np.asarray(at_us)
        if at_us.ndim != 1 or at_us.dtype.kind not in "iu":
            raise TypeError(f"at_us: found an array of shape {at_us.shape} and dtype {at_us.dtype}, "
                            "expected whole numbers in one dimension, us")
    table = detector._detect(events, start_us, at_us)
    rows = _np.empty(len(table), _detection_dtype)
    for i, field in enumerate(_detection_dtype.names[:-1]):
        rows[field] = table[:, i]
    rows["covariance_px2"] = table[:, 6:]
    return rows


def replay(recording, *, detectors=(), truth=None, joints=None, calibration=None, size=None, camera=None, columns="auto",
           time_unit=None, yarp_codec="auto", aedat2_layout="auto", evt_encoding="auto", event_stream_y="up", format="auto"):
    """The ticks of a recording or run folder, 1 ms each, as `saccade detect` passes them to its detectors: an iterator of dicts
    with t_us, events, joints and motion (None where there are no joints), estimates (of each detector, None without an
    observation) and truth (x_px, y_px, r_px, visible; None where it has no row at that time).

    detectors: names; or a dict of name -> dict of keys, object or class of your own. truth, joints, calibration: files, as
    `saccade detect` takes them; a run folder has its own. The other options are those of open().
    """
    if not isinstance(detectors, dict):
        detectors = {name: {} for name in ([detectors] if isinstance(detectors, str) else detectors)}
    rows = []
    for name, value in detectors.items():
        if _is_own(value):
            rows.append((name, "", "", value))
        elif isinstance(value, dict):
            keys = dict(value)
            rows.append((name, keys.pop("preset", name), _keys_text(keys), None))
        else:
            raise TypeError(f"detectors: {name}: found {_plain_errors.shown(value)}, expected a dict of keys, or an object or "
                            "class with process() and estimate()")
    files = [_os.fspath(path or "") for path in (truth, joints, calibration)]
    return _ticks(_saccade.Replay(_os.fspath(recording), size, camera, columns, time_unit, yarp_codec, aedat2_layout,
                                  evt_encoding, event_stream_y, format, rows, *files))


def _ticks(replay):
    while (tick := replay.next()) is not None:
        yield tick


class Emulator(_saccade.Emulator):
    """An emulator of a dynamic vision sensor: luminance images in, events out.

    size: (width, height). Keys are those of a scenario's block `emulator`: preset="dvs128", contrast_threshold_on=0.15.
    The same images, keys and seed give the same events, with any number of threads.
    """

    def __init__(self, size, *, seed=1, threads=1, **keys):
        super().__init__(size, seed, threads, _keys_text(keys))


def emulate(images, out, *, images_per_s=None, timestamps=None, time_unit=None, seed=1, threads=2, **keys):
    """Runs the emulator over a video, a folder of images or a .npy file, and writes the recording `out`.

    images_per_s: of images without times of their own (timestamps: a file of them, time_unit: their unit); a video has its own. Keys are those of
    Emulator. Returns a dict: images, size, first_us, last_us, and the counts on, off and dropped. `saccade emulate` does
    the same.
    """
    return _saccade.emulate(_os.fspath(images), _os.fspath(out), images_per_s, _os.fspath(timestamps or ""), time_unit, seed,
                            threads, _keys_text(keys))


def report(run, figures=None):
    """Writes report.html into a run folder, anew, and returns its path.

    figures: a folder for each figure as SVG, PDF and CSV at the size of a paper.
    """
    _saccade.report(_os.fspath(run), _os.fspath(figures or ""))
    return _os.path.join(_os.fspath(run), "report.html")


def emulator_presets():
    """Names of the emulator's presets."""
    return _saccade.emulator_presets()


def camera(size=None, **keys):
    """A camera: the exact pinhole of `size`, or with keys (width_px, height_px, fx_px, ..., p2) any other; keys that are
    missing have the values of the left DVS128 of iCubGenova02."""
    if size is not None and keys:
        raise ValueError("camera: found both size and keys, expected one of them")
    return _saccade.pinhole_camera(size) if size is not None else _saccade.camera(_keys_text(keys))


def root_from_eye(joints, eye="left"):
    """Pose of an eye in the root frame, a 4x4 matrix, from the joints' positions (rad; dict by name or nine numbers)."""
    return _saccade.root_from_eye(_joint_vector(joints), eye)


def fixation_point(joints):
    """The point at which the optical axes intersect, root frame, m; None where they are parallel."""
    return _saccade.fixation_point(_joint_vector(joints))


def camera_motion(joints, velocities=None, eye="left"):
    """Pose and velocity of a camera at the eye's centre, for Detector.process(); rad and rad/s."""
    return _saccade.camera_motion(_joint_vector(joints), _joint_vector(velocities), eye)
