import numpy as np
import pytest
import saccade
from common import circle_events, run_program

WRITTEN = sorted(f["extensions"][0] for f in saccade.formats() if f["written"])


def test_events_have_the_fields_of_the_ecosystem_and_the_camera():
    dtype = saccade.event_dtype
    assert dtype.names == ("x", "y", "p", "t", "camera")
    assert [dtype[n] for n in dtype.names] == [np.dtype(k) for k in ("u2", "u2", "?", "i8", "u1")]


@pytest.mark.parametrize("extension", WRITTEN)
def test_what_is_written_reads_back_the_same_in_every_format(tmp_path, extension):
    events = circle_events()
    path = tmp_path / ("recording" + extension)
    saccade.write(path, events, size=(128, 128))
    back = saccade.read(path, size=(128, 128))
    for field in events.dtype.names:
        assert np.array_equal(back[field], events[field]), field


def test_the_program_reads_what_python_writes(tmp_path):
    events = circle_events()
    saccade.write(tmp_path / "a.aedat", events, size=(128, 128))
    run_program("convert", tmp_path / "a.aedat", tmp_path / "b.csv")
    table = np.loadtxt(tmp_path / "b.csv", delimiter=",", skiprows=1, dtype=np.int64)
    assert np.array_equal(table[:, 0], events["t"]) and np.array_equal(table[:, 3], events["p"])


def test_pieces_by_count_are_the_recording(tmp_path):
    events = circle_events()
    saccade.write(tmp_path / "a.aedat", events, size=(128, 128))
    pieces = list(saccade.iterate(tmp_path / "a.aedat", count=777))
    assert all(len(piece) == 777 for piece in pieces[:-1]) and 0 < len(pieces[-1]) <= 777
    assert np.array_equal(np.concatenate(pieces)["t"], events["t"])


def test_pieces_by_time_are_half_open_windows_also_where_nothing_happens(tmp_path):
    events = circle_events()
    events["t"][5000:] += 3_000  # a silence of 3 ms
    saccade.write(tmp_path / "a.aedat", events, size=(128, 128))
    start = events["t"][0]
    pieces = list(saccade.iterate(tmp_path / "a.aedat", duration_us=1000))
    for i, piece in enumerate(pieces):
        inside = (events["t"] >= start + 1000 * i) & (events["t"] < start + 1000 * (i + 1))
        assert np.array_equal(piece["t"], events["t"][inside]), i
    assert sum(map(len, pieces)) == len(events) and any(len(piece) == 0 for piece in pieces)


def test_a_recording_longer_than_a_block_is_read_whole(tmp_path):
    events = circle_events(seconds=4.0, per_ms=50)  # 200000 events, blocks of 65536
    saccade.write(tmp_path / "a.aedat", events, size=(128, 128))
    assert np.array_equal(saccade.read(tmp_path / "a.aedat")["t"], events["t"])
    assert sum(map(len, saccade.iterate(tmp_path / "a.aedat", duration_us=50_000))) == len(events)


def test_arrays_of_other_libraries_are_taken():
    ours = circle_events()
    tonic = np.zeros(len(ours), [("x", "i2"), ("y", "i2"), ("t", "i8"), ("p", "?")])
    signed = np.zeros(len(ours), [("t", "i8"), ("x", "i8"), ("y", "i8"), ("p", "i1")])
    for field in ("x", "y", "t"):
        tonic[field] = signed[field] = ours[field]
    tonic["p"] = ours["p"]
    signed["p"] = np.where(ours["p"], 1, -1)
    for other in (tonic, signed):
        assert np.array_equal(saccade.as_events(other), ours)
    assert saccade.as_events(ours) is ours or np.shares_memory(saccade.as_events(ours), ours)


def test_problems_are_value_errors_with_the_messages_of_the_program(tmp_path):
    with pytest.raises(ValueError, match="(?i)no such file"):
        saccade.read(tmp_path / "absent.aedat")
    events = circle_events()
    with pytest.raises(ValueError, match="expected"):
        saccade.write(tmp_path / "a.aedat", events, size=(16, 16))
    assert not (tmp_path / "a.aedat").exists()
    with pytest.raises(ValueError, match="extension|expected"):
        saccade.write(tmp_path / "a.unknown", events, size=(128, 128))
    with pytest.raises(ValueError, match="fields x, y, p and t"):
        saccade.write(tmp_path / "a.aedat", np.zeros(3), size=(128, 128))
    wrong = np.zeros(1, [("x", "i8"), ("y", "i8"), ("p", "?"), ("t", "i8")])
    wrong["x"] = -1
    with pytest.raises(ValueError, match="found x from -1"):
        saccade.as_events(wrong)
    with pytest.raises(ValueError, match="one of them"):
        saccade.iterate(tmp_path / "a.aedat")


def test_a_file_that_breaks_off_is_a_value_error_with_its_place(tmp_path):
    events = circle_events()
    path = tmp_path / "a.aedat4"
    saccade.write(path, events, size=(128, 128))
    path.write_bytes(path.read_bytes()[:path.stat().st_size // 2])
    with pytest.raises(ValueError, match="a.aedat4"):
        saccade.read(path)


def test_an_open_recording_says_what_it_is(tmp_path):
    saccade.write(tmp_path / "a.aedat4", circle_events(), size=(128, 128))
    recording = saccade.open(tmp_path / "a.aedat4")
    assert recording.size == (128, 128) and "AEDAT 4" in recording.format
    assert len(recording.read(10)) == 10 and recording.skipped == ""


def test_two_cameras_are_written_where_the_format_has_them(tmp_path):
    events = circle_events()
    events["camera"][::3] = 1
    saccade.write(tmp_path / "a.csv", events, size=(128, 128))
    assert np.array_equal(saccade.read(tmp_path / "a.csv"), events)
    assert len(saccade.read(tmp_path / "a.csv", camera=1)) == len(events[::3])


def fields(dtype, events, time=lambda t: t):
    """The events as an array of another dtype, with the fields t, x, y and the polarity in this order."""
    other = np.zeros(len(events), dtype)
    for name, field in zip(other.dtype.names, ("t", "x", "y", "p")):
        other[name] = time(events[field]) if field == "t" else events[field]
    return other


def test_arrays_of_aedat_event_stream_and_faery_are_taken_as_they_make_them():
    events = circle_events()
    titled = fields([("t", "<u8"), ("x", "<u2"), ("y", "<u2"), (("p", "on"), "?")], events)
    on = fields([("t", "<u8"), ("x", "<u2"), ("y", "<u2"), ("on", "?")], events)
    for other in (titled, on):
        assert np.array_equal(saccade.as_events(other), events)
        detector = saccade.detector("best", size=(128, 128))
        assert len(saccade.detect(detector, other[:2000])) == len(
            saccade.detect(saccade.detector("best", size=(128, 128)), events[:2000]))


def test_arrays_may_lie_in_memory_in_any_way(tmp_path):
    events = circle_events()
    big = fields([("t", ">i8"), ("x", ">u2"), ("y", ">i4"), ("p", "?")], events)
    for other in (big, np.repeat(events, 3)[::3], np.repeat(events, 2)[1::2], events[::-1][::-1], np.asfortranarray(big),
                  events.view(np.recarray)):
        assert np.array_equal(saccade.as_events(other)["t"], events["t"])
        assert np.array_equal(saccade.as_events(other)["x"], events["x"])
        assert np.array_equal(saccade.as_events(other)["p"], events["p"])
    table = np.stack([events["t"] * 1e-6 + 1e-7, events["x"], events["y"], events["p"]], axis=1)
    for name, array in (("c.npy", table), ("f.npy", np.asfortranarray(table))):
        np.save(tmp_path / name, array)
        assert np.array_equal(saccade.read(tmp_path / name)["t"], events["t"]), name


def test_times_are_converted_or_refused():
    events = circle_events()
    double = [("t", "f8"), ("x", "i2"), ("y", "i2"), ("p", "?")]
    whole = [("t", "i8"), ("x", "i2"), ("y", "i2"), ("p", "?")]
    assert np.array_equal(saccade.as_events(fields(double, events, lambda t: t * 1e-6)), events)
    assert np.array_equal(saccade.as_events(fields(whole, events, lambda t: t * 1000), time_unit="ns"), events)
    named = [("t_ns", "i8"), ("x", "i2"), ("y", "i2"), ("p", "?")]
    assert np.array_equal(saccade.as_events(fields(named, events, lambda t: t * 1000)), events)
    stamped = [("t", "M8[ns]"), ("x", "i2"), ("y", "i2"), ("p", "?")]
    assert np.array_equal(saccade.as_events(fields(stamped, events, lambda t: t.astype("M8[us]"))), events)
    microseconds = fields(double, events, lambda t: t.astype("f8"))
    with pytest.raises(ValueError, match="without fractions.*time_unit"):
        saccade.as_events(microseconds)
    assert np.array_equal(saccade.as_events(microseconds, time_unit="us"), events)
    with pytest.raises(ValueError, match="time_unit"):
        saccade.as_events(fields(whole, events, lambda t: t + 1_600_000_000_000_000_000))
    with pytest.raises(ValueError, match="time_unit: found fortnights"):
        saccade.as_events(microseconds, time_unit="fortnights")
    broken = fields(double, events, lambda t: t * 1e-6)
    broken["t"][7] = np.nan
    with pytest.raises(ValueError, match="t of event 7: found nan"):
        saccade.as_events(broken)
    huge = fields([("t", "u8"), ("x", "i2"), ("y", "i2"), ("p", "?")], events)
    huge["t"][3] = 2**63 + 5
    with pytest.raises(ValueError, match="9223372036854775813"):
        saccade.as_events(huge)
    with pytest.raises(ValueError, match="numbers"):
        saccade.as_events(fields([("t", "U8"), ("x", "i2"), ("y", "i2"), ("p", "?")], events))


def test_other_numbers_are_refused_where_they_are_no_pixels_or_polarities(tmp_path):
    events = circle_events()
    for field, value in (("x", 2.5), ("y", np.nan), ("p", np.nan)):
        wrong = fields([("t", "i8"), ("x", "f8"), ("y", "f8"), ("p", "f8")], events)
        assert np.array_equal(saccade.as_events(wrong)["x"], events["x"])
        wrong[field][5] = value
        for call in (saccade.as_events, lambda e: saccade.write(tmp_path / "a.aedat", e, size=(128, 128))):
            with pytest.raises(ValueError, match=f"found {field} of {value}"):
                call(wrong)
    assert not (tmp_path / "a.aedat").exists()


def test_a_recording_is_read_in_the_unit_that_is_stated(tmp_path):
    (tmp_path / "a.txt").write_text("1600000000000050000 3 4 1\n")
    with pytest.raises(ValueError, match="time_unit"):
        saccade.read(tmp_path / "a.txt")
    assert saccade.read(tmp_path / "a.txt", time_unit="ns")["t"][0] == 1_600_000_000_000_050
    (tmp_path / "b.csv").write_text("x,y,p,t_ns\n3,4,1,5000\n")
    assert list(saccade.read(tmp_path / "b.csv")[["t", "x"]].tolist()[0]) == [5, 3]
