"""The convex pieces of the object families under physics: they compile, and rest as they are said to."""

import importlib.util

import numpy as np
import pytest

if importlib.util.find_spec("mujoco") is None:
    pytest.skip("MuJoCo is not installed", allow_module_level=True)
pytest.importorskip("scipy", reason="resting poses are computed by scipy")

from graspctx.sim.families import FAMILIES, make_object
from graspctx.sim.gl import load_mujoco

STEP_S, SECOND = 0.002, 500


def settle(shape, pose, height_m):
    """(turned_rad, moved_m) of a shape that is let go `height_m` over a table in a pose, after a second."""
    mujoco = load_mujoco()
    rotation = np.ascontiguousarray(pose.table_from_object)
    lowest_m = (shape.mesh.vertices_m @ rotation.T)[:, 2].min()
    start = np.empty(4)
    mujoco.mju_mat2Quat(start, rotation.ravel())
    spec = mujoco.MjSpec()
    spec.option.timestep = STEP_S
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 0.1])
    body = spec.worldbody.add_body(pos=[0, 0, height_m - lowest_m], quat=start)
    body.add_freejoint()
    for index, solid_m in enumerate(shape.solids_m):
        spec.add_mesh(name=f"solid{index}").uservert = np.asarray(solid_m, np.float32).ravel()
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=f"solid{index}", density=700)
    model = spec.compile()
    data = mujoco.MjData(model)
    for _ in range(SECOND):
        mujoco.mj_step(model, data)
    cosine = abs(data.qpos[3:7] @ start) / np.linalg.norm(data.qpos[3:7])
    return 2 * np.arccos(min(1.0, cosine)), np.linalg.norm(data.qpos[:2])


@pytest.mark.parametrize("family", FAMILIES)
def test_objects_stay_in_their_most_frequent_pose(family):
    for seed in (1, 2):
        shape = make_object(family, seed)
        pose = max(shape.resting_poses, key=lambda pose: pose.weight)
        turned_rad, moved_m = settle(shape, pose, height_m=0.001)
        assert turned_rad < np.radians(3), (seed, pose.name)
        assert moved_m < 0.005, (seed, pose.name)


def test_a_mug_does_not_stand_on_its_corner():
    shape = make_object("mug", 1)
    c, s = np.cos(0.6), np.sin(0.6)
    tipped = type(shape.resting_poses[0])("tipped", 1.0, np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]))
    turned_rad, _ = settle(shape, tipped, height_m=0.001)
    assert turned_rad > np.radians(15)
