"""Resting poses against bodies whose answer is known."""

import numpy as np
import pytest

pytest.importorskip("scipy")

from graspctx.sim.families.resting import resting_poses, rotation_downwards

BOX_M = np.array([0.10, 0.05, 0.02])
CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


def solid_angle_of_rectangle(width, height, distance):
    a, b = width / 2, height / 2
    return 4 * np.arcsin(a * b / np.sqrt((a**2 + distance**2) * (b**2 + distance**2)))


def test_box_rests_on_its_six_sides_as_often_as_their_solid_angles_say():
    poses = resting_poses(CORNERS * BOX_M, np.zeros(3))
    assert len(poses) == 6
    assert sum(pose.weight for pose in poses) == pytest.approx(1)
    for pose in poses:
        axis = int(np.abs(pose.table_from_object[2]).argmax())
        sides = np.delete(BOX_M, axis)
        expected = solid_angle_of_rectangle(*sides, BOX_M[axis] / 2) / (4 * np.pi)
        assert pose.weight == pytest.approx(expected, rel=1e-6)
        assert np.ptp((CORNERS * BOX_M) @ pose.table_from_object[2]) == pytest.approx(BOX_M[axis])
        assert (pose.name in ("standing", "upside_down")) == (axis == 2)
    standing = next(pose for pose in poses if pose.name == "standing")
    assert np.allclose(standing.table_from_object, np.eye(3))
    lying = resting_poses(CORNERS * BOX_M, np.zeros(3), up=(1, 0, 0))
    assert next(p for p in lying if p.name == "standing").table_from_object[2] == pytest.approx([1, 0, 0])


def test_box_with_the_weight_outside_a_side_tips_over():
    tall = CORNERS * [0.02, 0.02, 0.2]
    sheared = tall + np.outer(tall[:, 2], [0.5, 0, 0])  # leans 50 mm to the side on a foot of 20 mm
    low = sheared.mean(axis=0) - [0.015, 0, 0]
    assert {pose.name for pose in resting_poses(sheared, low)} == {"lying"}
    # With the weight down in its foot the same hull stands.
    assert "standing" in {pose.name for pose in resting_poses(sheared, [-0.045, 0, -0.09])}


def test_cylinder_with_many_sides_lies_in_few_poses_that_touch_the_table():
    angle = np.linspace(0, 2 * np.pi, 360, endpoint=False)
    ring = np.stack([0.03 * np.cos(angle), 0.03 * np.sin(angle), np.zeros(360)], axis=1)
    points = np.concatenate([ring, ring + np.array([0, 0, 0.1])])
    poses = resting_poses(points, [0, 0, 0.05])
    names = [pose.name for pose in poses]
    assert names.count("standing") == names.count("upside_down") == 1
    assert 20 <= names.count("lying") <= 72
    for pose in poses:
        height = points @ pose.table_from_object[2]
        assert (height - height.min() < 1e-6).sum() >= 4  # an edge or face touches, not a point


def test_ball_rests_every_way():
    trimesh = pytest.importorskip("trimesh")
    poses = resting_poses(trimesh.creation.icosphere(4, 0.05).vertices, np.zeros(3))
    assert len(poses) > 100
    assert sum(pose.weight for pose in poses) == pytest.approx(1)
    # No way is preferred: the mean of the directions is nowhere.
    mean = sum(pose.weight * pose.table_from_object[2] for pose in poses)
    assert np.linalg.norm(mean) < 0.05


@pytest.mark.parametrize("direction", [[0, 0, -1], [0, 0, 1], [1, 0, 0], [0.3, -2, 0.1], [1e-9, 0, 1]])
def test_rotation_downwards(direction):
    rotation = rotation_downwards(np.array(direction, float))
    assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(rotation) == pytest.approx(1)
    assert rotation @ direction / np.linalg.norm(direction) == pytest.approx([0, 0, -1], abs=1e-8)


def test_flat_points_are_refused():
    flat = CORNERS * [1, 1, 0]
    with pytest.raises(ValueError, match="lie in a plane"):
        resting_poses(flat, np.zeros(3))
