"""The object families: surfaces, grasp regions, resting poses, and the convex pieces that physics sees."""

import numpy as np
import pytest

spatial = pytest.importorskip("scipy.spatial", reason="hulls are computed by scipy")

from graspctx.sim.families import FAMILIES, make_object  # noqa: E402
from graspctx.sim.families.solids import lathe_solids, tube_solids  # noqa: E402


def depth_in_solids(solids_m, points_m):
    """(N,) how deep each point lies in the solid that holds it best, metres; negative outside of all."""
    depth = np.full(len(points_m), -np.inf)
    for solid in solids_m:
        planes = spatial.ConvexHull(solid).equations
        depth = np.maximum(depth, -(points_m @ planes[:, :3].T + planes[:, 3]).max(axis=1))
    return depth


def is_inside(mesh, points_m):
    """(N,) whether each point lies in the body that a surface encloses: its winding number."""
    turns = np.zeros(len(points_m))
    for k, corners in enumerate(points_m):
        a, b, c = np.moveaxis(mesh.vertices_m[mesh.faces] - corners, 1, 0)
        length_a, length_b, length_c = (np.linalg.norm(side, axis=1) for side in (a, b, c))
        below = length_a * length_b * length_c
        below += (a * b).sum(1) * length_c + (b * c).sum(1) * length_a + (c * a).sum(1) * length_b
        turns[k] = np.arctan2((a * np.cross(b, c)).sum(1), below).sum() / (2 * np.pi)
    return turns > 0.5


def beside_the_surface(mesh, rng, count, reach_m, faces=slice(None)):
    """(count, 3) points up to `reach_m` off random places of the surface."""
    corners = mesh.vertices_m[mesh.faces[faces]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1)
    chosen = rng.choice(len(corners), count, p=area / area.sum())
    place = (corners[chosen] * rng.dirichlet([1, 1, 1], count)[..., None]).sum(axis=1)
    return place + normal[chosen] / area[chosen, None] * rng.uniform(-reach_m, reach_m, (count, 1))


# ---- Solids ------------------------------------------------------------------------------------------------


def test_solids_of_a_lathe_keep_its_hollow():
    """A round pot whose truth is a formula: outer radius 50 mm, wall 4 mm, floor 6 mm, height 80 mm."""
    profile = np.array([(0, 0), (50, 0), (50, 80), (46, 80), (46, 6), (0, 6)]) * 1e-3
    solids = lathe_solids(*profile.T, sides=80)
    points = np.random.default_rng(0).uniform([-0.06, -0.06, -0.01], [0.06, 0.06, 0.09], (4000, 3))
    radius, z = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
    depth = depth_in_solids(solids, points)
    margin = 0.0006
    in_wall = (radius > 0.046 + margin) & (radius < 0.05 - margin) & (z > 0) & (z < 0.08)
    in_floor = (radius < 0.05 - margin) & (z > 0) & (z < 0.006)
    in_hollow = (radius < 0.046 - margin) & (z > 0.006)
    beyond = (radius > 0.05) | (z < 0) | (z > 0.08)
    assert min(in_wall.sum(), in_floor.sum(), in_hollow.sum()) > 50
    assert (depth[in_wall | in_floor] > -1e-9).all()
    assert (depth[in_hollow | beyond] < 1e-9).all()


def test_solids_of_a_lathe_follow_a_waist():
    z = np.linspace(0, 0.1, 60)
    waist = 0.02 - 0.008 * np.sin(np.pi * z / 0.1)
    solids = lathe_solids([0, *waist, 0], [0, *z, 0.1], sides=64)
    middle = np.array([[r, 0, 0.05] for r in (0.0115, 0.0128)])
    assert (depth_in_solids(solids, middle) > 0).tolist() == [True, False]
    assert len(solids) < 20


def test_solids_of_a_tube_follow_its_bend():
    """A quarter of a torus: points within the thickness of its centre line are covered, no others."""
    turn = np.linspace(0, np.pi / 2, 40)[:, None]
    around = 2 * np.pi * np.arange(24) / 24
    out = 0.04 + 0.005 * np.cos(around)
    up = np.broadcast_to(0.005 * np.sin(around), (40, 24))
    rings = np.stack([out * np.cos(turn), out * np.sin(turn), up], axis=-1)
    solids = tube_solids(rings)
    assert len(solids) < 12
    points = np.random.default_rng(1).uniform([0.02, 0.02, -0.008], [0.05, 0.05, 0.008], (3000, 3))
    off = np.hypot(np.hypot(points[:, 0], points[:, 1]) - 0.04, points[:, 2])
    depth = depth_in_solids(solids, points)
    assert (off < 0.0046).sum() > 50
    assert (depth[off < 0.0046] > 0).all()
    assert (depth[off > 0.0062] < 0).all()


@pytest.mark.parametrize("family", FAMILIES)
def test_solids_fill_the_body_and_nothing_else(family):
    for seed in range(3):
        shape = make_object(family, seed)
        rng = np.random.default_rng(seed)
        points = beside_the_surface(shape.mesh, rng, 60, 0.0015)
        graspable = beside_the_surface(shape.mesh, rng, 40, 0.0015, shape.mesh.region)
        points = np.concatenate([points, graspable])
        inside, depth = is_inside(shape.mesh, points), depth_in_solids(shape.solids_m, points)
        assert 0.1 < inside.mean() < 0.9
        assert depth[inside].min() > -0.0008
        assert depth[~inside].max() < 0.0008
