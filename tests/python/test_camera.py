"""The camera from Python: formulas, shapes, files."""

import graspctx as gc
import numpy as np
import pytest

FIELDS = {
    "focal_px": 520.0,
    "centre_px": (310.5, 240.25),
    "baseline_m": 0.12,
    "doffs_px": 8.5,
    "width_px": 640,
    "height_px": 480,
}


@pytest.fixture
def camera() -> gc.StereoCamera:
    return gc.StereoCamera(**FIELDS)


def test_fields(camera):
    for name, value in FIELDS.items():
        np.testing.assert_array_equal(getattr(camera, name), value)
    assert camera.raw is None
    with pytest.raises(AttributeError):
        camera.focal_px = 3
    assert eval(repr(camera), {"StereoCamera": gc.StereoCamera}).doffs_px == camera.doffs_px


def test_depth_is_f_b_over_d_plus_doffs(camera):
    disparities = np.array([[1.0, 30.0], [60.5, 200.0]])
    expected = 520 * 0.12 / (disparities + 8.5)
    np.testing.assert_allclose(camera.depth_m(disparities), expected)
    np.testing.assert_allclose(camera.disparity_px(expected), disparities)
    assert camera.depth_m(30) == pytest.approx(expected[0, 1])
    assert camera.depth_m(-9) == np.inf


@pytest.mark.parametrize("shape", [(), (7,), (3, 4)])
def test_points_come_back(camera, shape):
    rng = np.random.default_rng(len(shape))
    pixels = rng.uniform(0, 480, (*shape, 2))
    disparities = rng.uniform(5, 90, shape)
    points = camera.triangulate(pixels, disparities)
    assert points.shape == (*shape, 3)
    np.testing.assert_allclose(camera.project(points), pixels)
    np.testing.assert_allclose(points[..., 2], camera.depth_m(disparities))
    rays = camera.ray(pixels)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=-1), 1)
    np.testing.assert_allclose(rays * np.linalg.norm(points, axis=-1, keepdims=True), points)
    # The right camera sees the point at u - d.
    right = points - [0.12, 0, 0]
    np.testing.assert_allclose(camera.project(right)[..., 0] + 8.5, pixels[..., 0] - disparities)


def test_one_disparity_for_all_and_lists(camera):
    pixels = [[10, 20], [30, 40]]
    np.testing.assert_allclose(camera.triangulate(pixels, 25), camera.triangulate(pixels, [25, 25]))
    assert camera.project((0.1, 0.2, 1)).shape == (2,)


def test_bad_arguments(camera):
    with pytest.raises(ValueError, match=r"left_px: expected real numbers of shape \(..., 2\).*\(3,\)"):
        camera.ray([1, 2, 3])
    with pytest.raises(TypeError, match="left_px: expected real numbers"):
        camera.ray("ab")
    with pytest.raises(TypeError, match="point_m: expected real numbers"):
        camera.project([1j, 2, 3])
    with pytest.raises(ValueError, match="disparity_px: expected one number, or one for each pixel"):
        camera.triangulate([[1, 2], [3, 4]], [1, 2, 3])
    with pytest.raises(TypeError):
        gc.StereoCamera(520.0, (310, 240), 0.12)
    with pytest.raises(TypeError):
        gc.StereoCamera(**FIELDS, focal=3)
    for name, value in [("focal_px", -1.0), ("baseline_m", 0.0), ("doffs_px", np.nan), ("width_px", -1)]:
        with pytest.raises(gc.InvalidInput):
            gc.StereoCamera(**{**FIELDS, name: value})
    with pytest.raises(ValueError, match=r"centre_px: expected real numbers of shape \(..., 2\)"):
        gc.StereoCamera(**{**FIELDS, "centre_px": (1, 2, 3)})
    with pytest.raises(ValueError, match="distortion_model"):
        gc.RawView(camera_matrix=np.eye(3), rectified_from_raw=np.eye(3), distortion_model="fov")
    with pytest.raises(ValueError, match=r"camera_matrix: expected real numbers of shape \(3, 3\)"):
        gc.RawView(camera_matrix=np.zeros((2, 3)), rectified_from_raw=np.eye(3))


def test_middlebury_file(tmp_path):
    path = tmp_path / "calib.txt"
    path.write_text(
        "cam0=[1038.02 0 322.037; 0 1038.02 243.393; 0 0 1]\n"
        "cam1=[1038.02 0 375.308; 0 1038.02 243.393; 0 0 1]\n"
        "doffs=53.271\nbaseline=176.252\nwidth=718\nheight=496\nndisp=73\n"
    )
    camera = gc.StereoCamera.load(str(path))
    assert (camera.focal_px, camera.doffs_px, camera.baseline_m) == (1038.02, 53.271, pytest.approx(0.176252))
    assert (camera.width_px, camera.height_px) == (718, 496)


def ros_yaml(shift: float) -> str:
    return f"""image_width: 320
image_height: 240
camera_name: test
camera_matrix: {{rows: 3, cols: 3, data: [300, 0, 160, 0, 300, 120, 0, 0, 1]}}
distortion_model: plumb_bob
distortion_coefficients: {{rows: 1, cols: 5, data: [0.1, -0.05, 0, 0, 0]}}
rectification_matrix: {{rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}}
projection_matrix: {{rows: 3, cols: 4, data: [300, 0, 160, {shift}, 0, 300, 120, 0, 0, 0, 1, 0]}}
"""


def test_ros_files_and_rectification(tmp_path):
    left_file, right_file = tmp_path / "left.yaml", tmp_path / "right.yaml"
    left_file.write_text(ros_yaml(0))
    right_file.write_text(ros_yaml(-24))
    camera = gc.StereoCamera.load(left_file, right_file)
    assert camera.baseline_m == pytest.approx(0.08)
    assert camera.raw[0].distortion[:2] == [0.1, -0.05]
    taken_as_rectified = gc.StereoCamera.load(left_file, right_file, rectified=True)
    assert taken_as_rectified.raw is None

    image = np.zeros((240, 320, 3), np.uint8)
    image[:, 260:] = (200, 100, 50)  # this edge is straight in the raw image, and bent in the rectified one
    rectified, same = gc.rectify(image, image, camera)
    assert rectified.shape == image.shape
    np.testing.assert_array_equal(rectified, same)
    edge = (rectified[..., 0] > 100).argmax(axis=1)
    assert edge[120] != edge[5]
    np.testing.assert_array_equal(gc.rectify(image, image, taken_as_rectified)[0], image)
    with pytest.raises(gc.InvalidInput):
        gc.rectify(image[:100], image[:100], camera)
