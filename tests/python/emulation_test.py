import warnings

import numpy as np
import pytest
import saccade


def images(count=20, size=(64, 48)):
    """A bright bar that moves to the right by one pixel an image."""
    for i in range(count):
        image = np.full((size[1], size[0]), 40.0, np.float32)
        image[:, i:i + 8] = 200.0
        yield image


def events_of(**keys):
    emulator = saccade.Emulator((64, 48), **keys)
    pieces = [emulator.process(image, 1000 * (i + 1)) for i, image in enumerate(images())]
    return np.concatenate(pieces + [emulator.finish()]), emulator


def test_a_moving_bar_makes_events_at_its_edges():
    events, emulator = events_of(preset="ideal")
    assert len(events) > 1000 and set(events.dtype.names) == set(saccade.event_dtype.names)
    assert np.all(np.diff(events["t"]) >= 0) and events["t"].max() <= 20_000
    on, off = events[events["p"]], events[~events["p"]]
    assert on["x"].min() == 8 and off["x"].min() == 0  # the right edge brightens, the left one darkens
    assert emulator.counts["on"] == len(on) and emulator.counts["off"] == len(off)


def test_the_same_seed_gives_the_same_events_with_any_number_of_threads():
    one, _ = events_of(preset="noisy", seed=3)
    two, _ = events_of(preset="noisy", seed=3, threads=2)
    other, _ = events_of(preset="noisy", seed=4)
    assert np.array_equal(one, two) and not np.array_equal(one, other)


def test_the_first_image_makes_no_event_and_a_higher_threshold_fewer():
    emulator = saccade.Emulator((64, 48), preset="ideal")
    assert len(emulator.process(np.full((48, 64), 100.0), 0)) == 0
    few, _ = events_of(preset="ideal", contrast_threshold_on=0.8, contrast_threshold_off=0.8)
    many, _ = events_of(preset="ideal")
    assert 0 < len(few) < len(many)


def test_images_that_are_wrong_are_value_errors():
    emulator = saccade.Emulator((64, 48))
    with pytest.raises(ValueError, match=r"expected \(48, 64\)"):
        emulator.process(np.zeros((64, 48)), 0)
    emulator.process(np.zeros((48, 64)), 1000)
    with pytest.raises(ValueError):
        emulator.process(np.zeros((48, 64)), 1000)
    with pytest.raises(ValueError):
        emulator.process(np.full((48, 64), -1.0), 2000)
    with pytest.raises(ValueError, match="preset"):
        saccade.Emulator((64, 48), preset="unknown")
    assert "dvs128" in saccade.emulator_presets()


def test_a_file_of_images_becomes_the_events_that_the_same_arrays_become(tmp_path):
    np.save(tmp_path / "images.npy", np.stack(list(images())))
    figures = saccade.emulate(tmp_path / "images.npy", tmp_path / "events.aedat4", images_per_s=1000, preset="ideal", seed=2)
    events = saccade.read(tmp_path / "events.aedat4")
    emulator = saccade.Emulator((64, 48), preset="ideal", seed=2)
    expected = np.concatenate([emulator.process(image, 1000 * i) for i, image in enumerate(images())] + [emulator.finish()])
    assert figures["images"] == 20 and figures["size"] == (64, 48) and figures["last_us"] == 19_000
    assert figures["on"] + figures["off"] == len(events) == len(expected)
    for field in ("x", "y", "p", "t"):
        assert np.array_equal(events[field], expected[field]), field


def test_files_that_are_no_images_are_value_errors(tmp_path):
    with pytest.raises(ValueError, match="absent"):
        saccade.emulate(tmp_path / "absent", tmp_path / "events.aedat4", images_per_s=1000)
    assert not (tmp_path / "events.aedat4").exists()


def test_images_in_units_of_one_get_the_warning_of_the_command_once():
    emulator = saccade.Emulator((64, 48))
    with pytest.warns(UserWarning, match="white is at 255; for images in 0..1 use white=1 and dark_current=0.04") as seen:
        for i, image in enumerate(images()):
            emulator.process(image / 250, 1000 * (i + 1))
    assert len(seen) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for keys in ({}, {"preset": "ideal"}, {"white": 1.0, "dark_current": 0.04}):
            other = saccade.Emulator((64, 48), **keys)
            for i, image in enumerate(images()):
                other.process(image / 250 if keys else image, 1000 * (i + 1))


def test_the_times_of_images_have_the_unit_that_is_stated(tmp_path):
    np.save(tmp_path / "bar.npy", np.stack(list(images(10))))
    (tmp_path / "t.txt").write_text("".join(f"{1_000_000 * i}\n" for i in range(10)))
    with pytest.raises(ValueError, match="time_unit"):
        saccade.emulate(tmp_path / "bar.npy", tmp_path / "a.csv", timestamps=tmp_path / "t.txt")
    done = saccade.emulate(tmp_path / "bar.npy", tmp_path / "a.csv", timestamps=tmp_path / "t.txt", time_unit="ns")
    assert (done["first_us"], done["last_us"]) == (0, 9000)
