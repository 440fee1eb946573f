"""The ground truth of every pixel against computations of its own, from poses and the camera alone."""

import numpy as np
import pytest
import saccade
from common import SOURCE, run_program

SCENARIO = SOURCE / "examples" / "scenario" / "slow_line.yaml"
ALL = ("{rate_hz: 1000, images: true, frames: {exposure_ms: 1, shot_noise: 0, read_noise: 0}, depth: true, flow: true, "
       "segmentation: true, poses: true, imu: true, camera: true, format: npz}")


def run(folder, *settings, ground_truth=ALL, duration_s=0.05):
    assignments = [f"run.duration_s={duration_s}", "expect={}", "output.pictures=0", "imu={}", *settings]
    if ground_truth:
        assignments.append(f"output.ground_truth={ground_truth}")
    run_program("run", SCENARIO, "--seed", 5, "--out", folder, *(part for a in assignments for part in ("--set", a)))
    return folder


# Robot and ball move, so that camera and object have a part in the flow.
MOVING = {"ball.trajectory.start_s": 0, "base.ramp_s": 0, "base.pitch.amplitude_deg": 4, "base.pitch.frequency_hz": 4,
          "base.yaw.amplitude_deg": 5, "base.yaw.frequency_hz": 3, "eyes": "both"}


@pytest.fixture(scope="module")
def truth(tmp_path_factory):
    return saccade.GroundTruth(run(tmp_path_factory.mktemp("truth") / "run", *(f"{k}={v}" for k, v in MOVING.items())))


def camera_of(truth, eye):
    matrix, distortion = truth[f"{eye}/camera/matrix"], truth[f"{eye}/camera/distortion"]
    width, height = (int(n) for n in truth[f"{eye}/camera/size_px"])
    return saccade.camera(width_px=width, height_px=height, fx_px=matrix[0, 0], fy_px=matrix[1, 1], cx_px=matrix[0, 2],
                          cy_px=matrix[1, 2], **dict(zip(("k1", "k2", "p1", "p2", "k3"), map(float, distortion))))


def pixel_rays(camera):
    width, height = camera.size
    x, y = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
    rays = camera.rays(np.stack([x.ravel(), y.ravel()], axis=1))
    return rays / rays[:, 2:]


def test_every_array_is_there_for_both_eyes_and_instants_are_a_millisecond_apart(truth):
    assert np.array_equal(truth.t_us, np.arange(1000, 51_000, 1000))
    for eye in ("left", "right"):
        for name, shape, dtype in (("image", (), "f4"), ("frame", (), "u1"), ("depth_m", (), "f4"), ("flow_px_s", (2,), "f4"),
                                   ("camera_flow_px_s", (2,), "f4"), ("segmentation", (), "u1")):
            array = truth[f"{eye}/{name}"]
            assert array.shape == (50, 128, 128, *shape) and array.dtype == dtype, name
    assert not np.array_equal(truth["left/image"], truth["right/image"])
    assert len(truth["imu/t_us"]) == 50 and truth["imu/accelerometer_m_s2"].shape == (50, 3)
    rows = list(truth)
    assert len(rows) == len(truth) == 50 and rows[7]["t_us"] == 8000 and rows[7]["left/depth_m"].shape == (128, 128)
    assert truth.at(8999)["t_us"] == 8000 and truth.at(999) is None


def test_poses_are_those_of_the_loop_and_the_ball_is_where_the_target_is(truth):
    ball = truth["poses/bodies"].index("ball_hand")
    assert np.array_equal(truth["poses/root_from_body"][:, ball, :3, 3], truth["poses/target_m"])
    with saccade.Env(SCENARIO, seed=5, overrides={**MOVING, "run.duration_s": 0.05, "expect": {}, "imu": {}},
                     truth=True, closed_loop=True) as env:
        env.reset()
        for row in truth:
            info = env.step()[-1]["truth"]
            assert info["t_us"] == row["t_us"]
            assert np.array_equal(info["left"]["root_from_camera"], row["left/root_from_camera"])
            assert np.array_equal(info["right"]["root_from_camera"], row["right/root_from_camera"])
            assert np.array_equal(info["ball_m"], row["poses/target_m"])


def test_the_depth_of_the_ball_is_that_of_the_true_sphere(truth):
    radius_m = 0.0475
    for eye in ("left", "right"):
        rays = pixel_rays(camera_of(truth, eye))
        for i in (0, 25, 49):
            is_ball = (truth[f"{eye}/segmentation"][i] == truth["objects"].index("ball")).ravel()
            assert is_ball.sum() > 100
            centre = (np.linalg.inv(truth[f"{eye}/root_from_camera"][i]) @ np.append(truth["poses/target_m"][i], 1))[:3]
            along, ray2 = rays @ centre, (rays**2).sum(1)
            root2 = along**2 - ray2 * (centre @ centre - radius_m**2)
            hit = root2 >= 0
            depth = truth[f"{eye}/depth_m"][i].ravel()
            expected = (along - np.sqrt(np.maximum(root2, 0))) / ray2
            assert np.abs(depth - expected)[is_ball & hit].max() < 1e-6
            # The outline of the segmentation is within a sample, half a pixel, of the true one.
            angle_px = (np.sqrt(np.maximum(ray2 * (centre @ centre) / along**2 - 1, 0)) * np.linalg.norm(centre)
                        - radius_m) / np.linalg.norm(centre) * 120
            assert not is_ball[angle_px > 1.5].any()


def test_the_depth_of_a_wall_lies_on_its_plane_within_the_depth_buffers_resolution(tmp_path):
    truth = saccade.GroundTruth(run(tmp_path / "run", "lab.density=0", "ball.present=false", "gaze.detector=none",
                                    "detectors={blob_filter: {}}", duration_s=0.01))
    camera = camera_of(truth, "left")
    pose = truth["left/root_from_camera"][5]
    points = (pixel_rays(camera) * truth["left/depth_m"][5].reshape(-1, 1)) @ pose[:3, :3].T + pose[:3, 3]
    # Of the planes that axis-parallel walls are, the one with the most pixels.
    best = max(((np.abs(points[:, axis] - np.median(points[:, axis])) < 1e-2).sum(), axis) for axis in range(3))
    assert best[0] > 500
    on_plane = points[np.abs(points[:, best[1]] - np.median(points[:, best[1]])) < 1e-2, best[1]]
    depth_m = truth["left/depth_m"][5].max()
    resolution_m = depth_m**2 / 0.02 / 2**24  # near plane 2 cm, 24 bits
    errors = np.abs(on_plane - np.median(on_plane))  # of which some are of pixels of other surfaces near the plane
    assert np.percentile(errors, 95) < 2 * resolution_m


def test_flow_is_the_finite_difference_of_the_true_projection(truth):
    """A point of the ball and points of the room, a millisecond on and back, within 0.02 px per instant."""
    bodies = truth["poses/bodies"]
    names = truth["objects"]
    for eye in ("left", "right"):
        camera = camera_of(truth, eye)
        rays = pixel_rays(camera)
        for i in (10, 40):
            depth = truth[f"{eye}/depth_m"][i].reshape(-1, 1)
            flow = truth[f"{eye}/flow_px_s"][i].reshape(-1, 2)
            camera_flow = truth[f"{eye}/camera_flow_px_s"][i].reshape(-1, 2)
            numbers = truth[f"{eye}/segmentation"][i].ravel()
            poses = truth[f"{eye}/root_from_camera"]
            for name, body in (("ball", bodies.index("ball_hand")), ("room", 0)):
                chosen = np.flatnonzero(numbers == names.index(name))[::7]
                points = np.c_[rays[chosen] * depth[chosen], np.ones(len(chosen))] @ poses[i].T
                of_body = truth["poses/root_from_body"][:, body]
                moved = [points @ np.linalg.inv(of_body[i]).T @ of_body[i + step].T @ np.linalg.inv(poses[i + step]).T
                         for step in (-1, 1)]
                still = [points @ np.linalg.inv(poses[i + step]).T for step in (-1, 1)]
                for ends, given in ((moved, flow), (still, camera_flow)):
                    first, last = (camera.project(np.ascontiguousarray(end[:, :3])) for end in ends)
                    error_px = np.abs((last - first) - given[chosen] * 2e-3)
                    assert error_px.max() < 0.02, (eye, name)
                assert np.isfinite(flow[chosen]).all()
                assert np.median(np.linalg.norm(camera_flow[chosen], axis=1)) > 50  # the camera turns
                own = np.abs(flow - camera_flow)[chosen].max()
                assert own > 0.1 if name == "ball" else own < 0.01  # px/s


def test_a_still_camera_has_no_flow_of_its_own_and_the_ball_flows_with_its_circle(tmp_path):
    truth = saccade.GroundTruth(run(tmp_path / "run", "gaze.detector=none", "ball.trajectory.start_s=0", duration_s=0.3,
                                    ground_truth=ALL.replace("rate_hz: 1000", "rate_hz: 20")))
    rows = np.genfromtxt(tmp_path / "run" / "truth.csv", delimiter=",", names=True)
    moved = 0
    for row in truth:
        i = int(row["t_us"]) // 1000 - 1
        assert np.abs(row["left/camera_flow_px_s"][np.isfinite(row["left/camera_flow_px_s"])]).max() < 0.05
        is_ball = row["left/segmentation"] == truth["objects"].index("ball")
        if i + 1 < len(rows) and is_ball.sum() > 100:
            speed = (rows["x_px"][i + 1] - rows["x_px"][i - 1]) / 2e-3
            moved = max(moved, abs(speed))
            assert np.median(row["left/flow_px_s"][is_ball][:, 0]) == pytest.approx(speed, rel=0.1, abs=1.0)
    assert moved > 5


def test_frames_are_the_mean_of_their_exposure_with_noise(tmp_path, truth):
    assert np.abs(truth["left/image"] - truth["left/frame"].astype("f4")).max() <= 0.5  # an exposure of 1 ms, no noise
    long = saccade.GroundTruth(run(
        tmp_path / "run", *(f"{k}={v}" for k, v in MOVING.items()),
        ground_truth="{rate_hz: 100, frames: {exposure_ms: 5, shot_noise: 0, read_noise: 0}, format: npz}"))
    noisy = saccade.GroundTruth(run(
        tmp_path / "noisy", *(f"{k}={v}" for k, v in MOVING.items()),
        ground_truth="{rate_hz: 100, frames: {exposure_ms: 5, shot_noise: 6, read_noise: 3}, format: npz}"))
    assert "left/image" not in long and len(long) == 5
    for i in range(5):
        mean = np.mean([truth["right/image"][10 * i + k] for k in range(5, 10)], axis=0)  # the 5 ms up to 10 (i + 1)
        assert np.abs(long["right/frame"][i] - mean).max() <= 0.5 + 1e-3
        inside = (mean > 30) & (mean < 220)
        scaled = (noisy["right/frame"][i] - mean)[inside] / np.sqrt(9 + 36 * mean[inside] / 255)
        assert abs(scaled.std() - 1) < 0.05 and abs(scaled.mean()) < 0.05


def test_asking_for_ground_truth_changes_nothing_in_the_run_and_nothing_else_is_written(tmp_path):
    plain = run(tmp_path / "plain", ground_truth=None)
    asked = run(tmp_path / "asked", ground_truth="{rate_hz: 50, depth: true, format: npz}")
    again = run(tmp_path / "again", ground_truth="{rate_hz: 50, depth: true, format: npz}")
    for name in ("truth.csv", "detections.csv", "joints.csv", *(p.name for p in plain.glob("events.*"))):
        assert (plain / name).read_bytes() == (asked / name).read_bytes(), name
    assert saccade.GroundTruth(asked).names == ["t_us", "left/depth_m"]
    assert (asked / "ground_truth.npz").read_bytes() == (again / "ground_truth.npz").read_bytes()
    with pytest.raises(ValueError, match="found no ground_truth.npz"):
        saccade.GroundTruth(plain)
    with pytest.raises(KeyError, match="left/flow_px_s: found no such array"):
        saccade.GroundTruth(asked)["left/flow_px_s"]


def test_hdf5_has_the_same_arrays(tmp_path):
    h5py = pytest.importorskip("h5py")
    del h5py
    first = saccade.GroundTruth(run(tmp_path / "a", duration_s=0.01))
    second = saccade.GroundTruth(run(tmp_path / "b", duration_s=0.01, ground_truth=ALL.replace("npz", "hdf5")))
    assert sorted(first.names) == sorted(second.names)
    for name in first.names:
        assert np.array_equal(np.asarray(first[name]), np.asarray(second[name]), equal_nan=first[name].dtype.kind == "f") \
            if not isinstance(first[name], list) else first[name] == second[name], name


@pytest.mark.parametrize("setting, message", [
    ("{rate_hz: 300}", "output.ground_truth.rate_hz: found 300, expected 1000 divided by a whole number"),
    ("{rate_hz: 100, frames: {exposure_ms: 20}}", "frames.exposure_ms: found 20, expected at most the time between instants"),
    ("{imu: true}", "output.ground_truth.imu: found true, expected false, for there is no section `imu`"),
    ("{depht: true}", "output.ground_truth.depht: found an unknown key"),
])
def test_mistakes_are_named(setting, message):
    with pytest.raises(ValueError, match=message.replace("`", ".")):
        saccade.Env(SCENARIO, overrides={"expect": {}, "output.ground_truth": yaml_of(setting)})


def yaml_of(text):
    import re
    return eval(re.sub(r"(\w+):", r"'\1':", text).replace("true", "True"))
