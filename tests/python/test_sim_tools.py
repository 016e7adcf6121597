"""Boxes and tools with handles: proportions, grasp regions, resting poses, hollows."""

import numpy as np
import pytest

spatial = pytest.importorskip("scipy.spatial", reason="hulls are computed by scipy")

from graspctx.sim.families import make_object  # noqa: E402
from graspctx.sim.families.sections import HANDLE_REGION  # noqa: E402
from graspctx.sim.mesh import centre_of_mass_m, rounded_box, skin  # noqa: E402

BOXES = ("box", "eraser", "book")
TOOLS = ("hammer", "screwdriver", "spoon", "fryingpan")
SEEDS = range(12)
HAND_OPENING_M = 0.2


@pytest.fixture(scope="module")
def objects():
    return {family: [make_object(family, seed) for seed in SEEDS] for family in BOXES + TOOLS}


def region_points(shape):
    return shape.mesh.vertices_m[np.unique(shape.mesh.faces[shape.mesh.region])]


def face_areas(mesh):
    a, b, c = (mesh.vertices_m[mesh.faces[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


# ---- Primitives --------------------------------------------------------------------------------------------


def test_rounded_box_has_the_volume_of_a_box_without_its_edges():
    size, radius = np.array([0.10, 0.04, 0.20]), 0.004
    mesh = rounded_box(size, radius, unrolled_m=(0.28, 0.2), cuts_x_m=(0.03,), cuts_z_m=(0.07,))
    a, b, c = (mesh.vertices_m[mesh.faces[:, k]] for k in range(3))
    volume = (a * np.cross(b, c)).sum() / 6
    around_z, across = 1.2 * radius, 2 * (size[0] + size[1])
    lost = (4 - np.pi) * around_z**2 * size[2] + 2 * across * (1 - np.pi / 4) * radius**2
    assert volume == pytest.approx(size.prod() - lost, rel=2e-3)
    assert np.ptp(mesh.vertices_m, axis=0) == pytest.approx(size)
    assert centre_of_mass_m(mesh) == pytest.approx([0, 0, 0.1], abs=1e-9)
    assert np.isclose(mesh.vertices_m[:, 0], 0.03).any()
    assert np.isclose(mesh.vertices_m[:, 2], 0.07).any()


def test_rounded_box_texture_is_as_large_as_the_box():
    around, along = 0.31, 0.17
    mesh = rounded_box((0.10, 0.06, 0.15), 0.002, unrolled_m=(around, along))
    on_picture = mesh.uv * [around, along]
    first, second = on_picture[:, 1] - on_picture[:, 0], on_picture[:, 2] - on_picture[:, 0]
    area = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / 2
    corners = mesh.vertices_m[mesh.faces]
    flat = np.isclose(np.ptp(corners, axis=1), 0, atol=1e-9).any(axis=1)  # the rounding is stretched a little
    assert 0.9 < face_areas(mesh)[flat].sum() / face_areas(mesh).sum() < 1
    assert area[flat] == pytest.approx(face_areas(mesh)[flat], rel=1e-6)


def test_skin_of_a_prism():
    square = np.array([[1, -1], [1, 1], [-1, 1], [-1, -1.0]]) / 2
    rings = np.stack([np.column_stack([square, np.full(4, z)]) for z in (0.0, 1.0, 3.0)])
    mesh = skin(rings, np.linspace(0, 1, 5), np.array([0, 0.5, 1]), region=[True, False])
    assert face_areas(mesh).sum() == pytest.approx(2 + 4 * 3)
    assert centre_of_mass_m(mesh) == pytest.approx([0, 0, 1.5])
    assert face_areas(mesh)[mesh.region].sum() == pytest.approx(4 + 1)


# ---- Families ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("family", BOXES + TOOLS)
def test_same_seed_same_object(family):
    first, second, other = (make_object(family, seed) for seed in (3, 3, 4))
    assert first.mesh.vertices_m.tobytes() == second.mesh.vertices_m.tobytes()
    assert first.mesh.uv.tobytes() == second.mesh.uv.tobytes()
    assert [pose.weight for pose in first.resting_poses] == [pose.weight for pose in second.resting_poses]
    assert first.dimensions_m != other.dimensions_m


@pytest.mark.parametrize(
    "family, longest_m, shortest_m",
    [
        ("box", (0.05, 0.295), (0.01, 0.13)),
        ("eraser", (0.03, 0.08), (0.006, 0.03)),
        ("book", (0.15, 0.26), (0.007, 0.053)),
        ("hammer", (0.2, 0.39), (0.02, 0.08)),
        ("screwdriver", (0.13, 0.31), (0.018, 0.037)),
        ("spoon", (0.12, 0.33), (0.004, 0.06)),
        ("fryingpan", (0.24, 0.45), (0.028, 0.13)),
    ],
)
def test_objects_have_the_size_of_real_ones(objects, family, longest_m, shortest_m):
    extents = np.array([np.sort(np.ptp(shape.mesh.vertices_m, axis=0)) for shape in objects[family]])
    assert longest_m[0] < extents[:, 2].min() and extents[:, 2].max() < longest_m[1]
    assert shortest_m[0] < extents[:, 0].min() and extents[:, 0].max() < shortest_m[1]
    assert extents.std(axis=0).min() > 0.05 * extents.mean(axis=0).min()  # no two alike


@pytest.mark.parametrize("family", BOXES)
def test_regions_of_boxes_are_two_opposite_sides_that_a_hand_closes_over(objects, family):
    for shape in objects[family]:
        points = shape.mesh.vertices_m
        low, high = points.min(axis=0), points.max(axis=0)
        assert np.ptp(points[:, 0]) < HAND_OPENING_M - 0.02
        assert np.ptp(points[:, 1]) < 0.85 * np.ptp(points[:, 0]) < np.ptp(points[:, 2])
        region = region_points(shape)
        length = np.ptp(points[:, 2])
        assert region[:, 2].min() - low[2] == pytest.approx(0.3 * length, abs=0.002)
        assert high[2] - region[:, 2].max() == pytest.approx(0.3 * length, abs=0.002)
        # Both sides, over their whole width, and the margins beside them; nothing between.
        margin = shape.dimensions_m["margin"]
        middle = (low[0] + high[0]) / 2
        assert np.abs(region[:, 0] - middle).min() == pytest.approx(
            (high[0] - low[0]) / 2 - margin, abs=0.001
        )
        for side in (-1, 1):
            on_side = region[side * (region[:, 0] - middle) > 0]
            assert np.ptp(on_side[:, 1]) == pytest.approx(high[1] - low[1])
        share = face_areas(shape.mesh)[shape.mesh.region].sum() / face_areas(shape.mesh).sum()
        assert 0.05 < share < 0.35


@pytest.mark.parametrize("family", TOOLS)
def test_regions_of_tools_are_their_handles(objects, family):
    for shape in objects[family]:
        size, region = shape.dimensions_m, region_points(shape)
        if family == "fryingpan":
            from_end = shape.mesh.vertices_m[:, 0].max() - region[:, 0]
            handle = size["handle_length"]
            beside = region[:, 1:]
        else:
            from_end = region[:, 2]
            handle = size["length"] - size["bowl_length"] if family == "spoon" else size["handle_length"]
            beside = region[:, :2]
        assert from_end.min() == pytest.approx(0, abs=2e-4)
        assert from_end.max() == pytest.approx(HANDLE_REGION * handle, abs=0.002)
        # It is slim: a hand closes around it. A spoon's and a pan's handle rise along their length.
        assert np.ptp(beside[:, 1 if family != "fryingpan" else 0]) < 0.05


@pytest.mark.parametrize("family", ("hammer", "screwdriver", "spoon", "fryingpan"))
def test_materials_end_elsewhere_than_the_region(objects, family):
    """The border of a part in the texture is not the border of the label: it would give it away."""
    for shape in objects[family]:
        mesh = shape.mesh
        in_region = mesh.uv[mesh.region][..., 1]
        low, high = in_region.min(), in_region.max()
        borders = {edge for interval in shape.parts.values() for edge in interval}
        borders -= {0.0, 1.0}
        ends = {edge for edge in (low, high) if 1e-6 < edge < 1 - 1e-6}
        assert ends
        assert all(abs(edge - border) > 0.01 for edge in ends for border in borders)


@pytest.mark.parametrize("family", BOXES + TOOLS)
def test_resting_poses_touch_and_do_not_tip(objects, family):
    for shape in objects[family]:
        centre = centre_of_mass_m(shape.mesh)
        assert 1 <= len(shape.resting_poses) <= 80
        for pose in shape.resting_poses:
            points = shape.mesh.vertices_m @ pose.table_from_object.T
            low = points[:, 2].min()
            touching = points[points[:, 2] < low + 2e-4][:, :2]
            above = pose.table_from_object @ centre
            assert above[2] > low
            # The centre of mass stands over the convex hull of what touches: no line parts them.
            angle = np.linspace(0, 2 * np.pi, 72)
            way = np.stack([np.cos(angle), np.sin(angle)])
            assert ((touching @ way).max(axis=0) > above[:2] @ way - 1e-4).all()
            assert pose.weight > 0


def test_screwdrivers_lie_and_pans_stand():
    for seed in SEEDS:
        for family, usual in (("screwdriver", "lying"), ("fryingpan", "standing")):
            poses = make_object(family, seed).resting_poses
            share = sum(pose.weight for pose in poses if pose.name == usual)
            assert share > 0.8 * sum(pose.weight for pose in poses)


# ---- Hollows -----------------------------------------------------------------------------------------------


def in_solids(shape, points):
    inside = np.zeros(len(points), bool)
    for solid in shape.solids_m:
        planes = spatial.ConvexHull(solid).equations
        inside |= (points @ planes[:, :3].T + planes[:, 3] < 1e-9).all(axis=1)
    return inside


def test_pans_are_hollow_and_their_handles_are_not():
    for seed in range(6):
        pan = make_object("fryingpan", seed)
        size = pan.dimensions_m
        hollow = np.array(
            [[r * np.cos(t), r * np.sin(t), 0.8 * size["height"]] for r in (0, 0.5, 0.8) for t in range(6)]
        ) * [size["foot_radius"], size["foot_radius"], 1]
        assert not in_solids(pan, hollow).any()
        grip = region_points(pan)
        along = np.linspace(grip[:, 0].min() + 0.01, grip[:, 0].max() - 0.01, 9)
        axis = [grip[np.abs(grip[:, 0] - x) < 0.008].mean(axis=0) * [0, 0, 1] + [x, 0, 0] for x in along]
        assert in_solids(pan, np.array(axis)).all()


def test_bowls_of_spoons_are_hollow():
    for seed in range(6):
        spoon = make_object("spoon", seed)
        size, points = spoon.dimensions_m, spoon.mesh.vertices_m
        middle = size["length"] - size["bowl_length"] / 2
        middle = points[np.abs(points[:, 2] - middle).argmin(), 2]
        bottom = points[(points[:, 2] == middle) & (points[:, 1] == 0)][:, 0]
        over = np.array([[bottom.max() + 0.4 * size["bowl_depth"], 0, middle]])
        within = np.array([[(bottom.max() + bottom.min()) / 2, 0, middle]])
        assert not in_solids(spoon, over).any()
        assert in_solids(spoon, within).all()


def test_covers_of_books_stand_over_their_pages():
    hollow = 0
    for seed in SEEDS:
        book = make_object("book", seed)
        size = book.dimensions_m
        if size["overhang"] < 0.001:
            continue
        fore_edge = np.array([[size["width"] / 2 - size["overhang"] / 2, 0, size["height"] / 2]])
        head = np.array([[0, 0, size["height"] - size["overhang"] / 2]])
        assert not in_solids(book, np.concatenate([fore_edge, head])).any()
        assert in_solids(book, fore_edge - [size["overhang"], 0, 0]).all()
        hollow += 1
    assert hollow >= 3
