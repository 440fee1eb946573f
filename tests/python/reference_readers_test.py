"""Written files read by the readers of other projects, and theirs read by saccade: NumPy, @foxglove/rosbag, @mcap/core, and Python's
sqlite3 with a parser of CDR."""

import subprocess

import numpy as np
import pytest
import reference_readers
import saccade


def read_by(script, *arguments):
    """The events that a script read, and its last line."""
    if script.endswith(".cjs") and not reference_readers.are_installed():
        pytest.skip("NOT TESTED: the readers of bags and MCAP files of other projects, node or their packages are missing; "
                    "scripts/setup --all installs them")
    process = reference_readers.start(script, *arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    records, said = process.communicate()
    assert process.returncode == 0, said.decode()
    return reference_readers.events_of(records), (said.decode().splitlines() or [""])[-1]


def random_events(count=60_000):
    rng = np.random.default_rng(1)
    events = np.zeros(count, saccade.event_dtype)
    events["t"] = 1_600_000_000_000_000 + np.cumsum(rng.integers(0, 9, count))
    events["t"][count // 2:] += 20_000_000  # a silence
    events["x"], events["y"] = rng.integers(0, 304, count), rng.integers(0, 240, count)
    events["p"] = rng.random(count) < 0.5
    return events


@pytest.mark.parametrize("name, kind", [("a.bag", "/dvs/events dvs_msgs/EventArray"),
                                        ("a.packets.bag", "/dvs/events event_camera_msgs/EventPacket")])
def test_foxglove_rosbag_reads_our_bags(tmp_path, name, kind):
    events = random_events()
    saccade.write(tmp_path / name, events, size=(304, 240))
    read, last = read_by("read_bag.cjs", tmp_path / name)
    assert np.array_equal(read, events)
    assert last.rsplit(" ", 1)[0] == kind


def test_mcap_core_reads_our_files_by_their_index(tmp_path):
    events = random_events()
    saccade.write(tmp_path / "a.mcap", events, size=(304, 240))
    read, last = read_by("read_mcap.cjs", tmp_path / "a.mcap")
    assert np.array_equal(read, events)
    assert last.startswith("/event_camera/events event_camera_msgs/msg/EventPacket")


def test_pythons_sqlite3_reads_our_ros2_bags(tmp_path):
    events = random_events()
    saccade.write(tmp_path / "a.db3", events, size=(304, 240))
    read, last = read_by("read_ros2_bag.py", tmp_path / "a.db3")
    assert np.array_equal(read, events)
    assert last.startswith("/event_camera/events event_camera_msgs/msg/EventPacket ")


@pytest.mark.parametrize("name, script, topics", [
    ("a.bag", "read_bag.cjs", "/dvs/left/events,/dvs/right/events dvs_msgs/EventArray"),
    ("a.packets.bag", "read_bag.cjs", "/dvs/left/events,/dvs/right/events event_camera_msgs/EventPacket"),
    ("a.mcap", "read_mcap.cjs",
     "/event_camera/left/events,/event_camera/right/events event_camera_msgs/msg/EventPacket"),
    ("a.db3", "read_ros2_bag.py",
     "/event_camera/left/events,/event_camera/right/events event_camera_msgs/msg/EventPacket")])
def test_two_cameras_are_two_topics_for_the_reference_readers(tmp_path, name, script, topics):
    events = random_events()
    events["camera"] = np.arange(len(events)) % 3 == 0
    events = events[np.lexsort((events["camera"], events["t"]))]
    saccade.write(tmp_path / name, events, size=(304, 240))
    read, last = read_by(script, tmp_path / name)
    for camera in (0, 1):
        assert np.array_equal(read[read["camera"] == camera], events[events["camera"] == camera])
    assert last.rsplit(" ", 1)[0] == topics
    assert np.array_equal(saccade.read(tmp_path / name), events)


def test_a_file_of_mcap_core_is_read(tmp_path):
    read_by("write_mcap.cjs", tmp_path / "a.mcap")
    events = saccade.read(tmp_path / "a.mcap")
    i = np.arange(1000)
    assert np.array_equal(events["t"], 1_000_000 + 7 * i)
    assert np.array_equal(events["x"], i % 300) and np.array_equal(events["y"], i % 200)
    assert np.array_equal(events["p"], i % 2 == 0)
    assert saccade.open(tmp_path / "a.mcap").size == (304, 240)


def test_numpy_reads_our_arrays(tmp_path):
    events = random_events()
    saccade.write(tmp_path / "a.npz", events, size=(304, 240))
    saccade.write(tmp_path / "a.npy", events, size=(304, 240))
    with np.load(tmp_path / "a.npz") as file:
        arrays = {name: file[name] for name in file.files}
    assert arrays["sensor_size"].tolist() == [304, 240, 2]
    for array in (arrays["events"], np.load(tmp_path / "a.npy")):
        assert array.dtype.names == ("x", "y", "t", "p")
        for field in array.dtype.names:
            assert np.array_equal(array[field], events[field])


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_numpys_arrays_are_read(tmp_path, save):
    events = random_events(5000)
    tonic = np.zeros(5000, [("x", np.int16), ("y", np.int16), ("t", np.int64), ("p", bool)])
    for field in tonic.dtype.names:
        tonic[field] = events[field]
    save(tmp_path / "records.npz", tonic)
    save(tmp_path / "columns.npz", t=events["t"], x=events["x"].astype(np.float32), y=events["y"].astype(">i4"),
         p=np.where(events["p"], 1, -1), width=304, height=240)
    save(tmp_path / "seconds.npz", ts=(events["t"] - events["t"][0]) * 1e-6, x=events["x"], y=events["y"], polarity=events["p"])
    np.save(tmp_path / "aligned.npy", tonic.astype(np.dtype(tonic.dtype.descr, align=True)))
    for name in ("records.npz", "columns.npz", "seconds.npz", "aligned.npy"):
        read = saccade.read(tmp_path / name)
        start = events["t"][0] if name == "seconds.npz" else 0
        assert np.array_equal(read["t"] + start, events["t"]), name
        for field in ("x", "y", "p"):
            assert np.array_equal(read[field], events[field]), (name, field)
    assert saccade.open(tmp_path / "columns.npz").size == (304, 240)
