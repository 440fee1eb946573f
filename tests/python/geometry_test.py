import numpy as np
import pytest
import saccade


def test_pixels_of_points_have_rays_through_the_points():
    camera = saccade.camera()  # with the lens of the robot's
    points = np.array([[0.02, -0.03, 0.5], [-0.1, 0.05, 0.8], [0.0, 0.0, 1.0]])
    rays = camera.rays(camera.project(points))
    assert np.allclose(rays, points / points[:, 2:], atol=1e-9)
    assert np.all(np.isnan(camera.project(np.array([[0.0, 0.0, -1.0]]))))


def test_a_sphere_on_the_axis_of_a_pinhole_is_a_circle_of_known_radius():
    camera = saccade.camera(size=(200, 100))
    x, y, r = camera.project_sphere((0.0, 0.0, 0.5), 0.05)
    # The outline of a sphere: tan(asin(R / d)).
    assert (x, y) == pytest.approx((camera.cx_px, camera.cy_px))
    assert r == pytest.approx(camera.fx_px * np.tan(np.arcsin(0.1)))


def test_the_eyes_of_the_straight_head_look_forward():
    left, right = saccade.root_from_eye({}), saccade.root_from_eye({}, "right")
    assert left[:3, 2] == pytest.approx([-1, 0, 0], abs=1e-9)  # root: x points backward
    assert right[1, 3] - left[1, 3] == pytest.approx(0.068, abs=1e-9)  # the eyes are 68 mm apart, y to the right
    assert saccade.fixation_point({}) is None


def test_the_eyes_meet_where_their_axes_cross():
    joints = {"eyes_vergence": 0.2, "eyes_tilt": -0.1, "neck_yaw": 0.3}
    point = saccade.fixation_point(joints)
    for eye in ("left", "right"):
        pose = saccade.root_from_eye(joints, eye)
        towards = point - pose[:3, 3]
        assert np.cross(pose[:3, 2], towards) == pytest.approx(np.zeros(3), abs=1e-9)


def test_joints_are_taken_by_name_or_in_order():
    by_name = saccade.root_from_eye({"neck_yaw": 0.3})
    vector = np.zeros(9)
    vector[saccade.joint_names.index("neck_yaw")] = 0.3
    assert np.array_equal(by_name, saccade.root_from_eye(vector))
    with pytest.raises(ValueError, match="expected one of torso_pitch"):
        saccade.root_from_eye({"neck": 0.3})
    with pytest.raises(ValueError, match="left or right"):
        saccade.root_from_eye({}, "middle")
