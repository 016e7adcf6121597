"""Rendered scenes: determinism, labels, geometry, and the command line."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

if importlib.util.find_spec("mujoco") is None:  # to import it would choose a graphics library for all
    pytest.skip("rendered scenes need the extra 'sim' (mujoco)", allow_module_level=True)
Image = pytest.importorskip("PIL.Image", reason="rendered scenes need the extra 'sim' (pillow)")

from graspctx.sim import FAMILIES, draw_scene, make_object  # noqa: E402
from graspctx.sim.mesh import corner_normals  # noqa: E402
from graspctx.sim.surfaces import SURFACE_KINDS, surface_texture  # noqa: E402
from graspctx.sim.textures import object_texture  # noqa: E402

SCENES = 9


def run(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "graspctx.sim", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=300,
        env={**os.environ, "COLUMNS": "100"},
    )


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """Nine scenes of all families, with up to two objects; made with two workers."""
    root = tmp_path_factory.mktemp("sim")
    made = run("make", root / "set", "--scenes", SCENES, "--seed", 3, "--objects", "1-2", "--workers", 2)
    assert made.returncode == 0, made.stderr
    return root / "set"


class SceneFiles:
    def __init__(self, folder: Path):
        self.folder = folder
        self.info = json.loads((folder / "scene.json").read_text())
        self.camera = self.info["camera"]
        for side in ("left", "right"):
            setattr(self, side, self.read(side))
            setattr(self, side + "_mask", self.read(side + "_mask"))
            setattr(self, side + "_label", self.read(side + "_label"))
        self.depth_m = self.read("left_depth").astype(float) * 1e-4

    def read(self, name):
        return np.asarray(Image.open(self.folder / f"{name}.png"))

    def points_m(self):
        """(H, W, 3) camera-frame points of the left view's pixels."""
        v, u = np.indices(self.depth_m.shape)
        (cx, cy), f = self.camera["centre_px"], self.camera["focal_px"]
        return np.stack([(u - cx) / f * self.depth_m, (v - cy) / f * self.depth_m, self.depth_m], axis=-1)

    def disparity_px(self):
        with np.errstate(divide="ignore"):
            return self.camera["focal_px"] * self.camera["baseline_m"] / self.depth_m

    def object_points_m(self, entry):
        """(N, 3) camera-frame points of an object's left pixels, and (N,) whether they are grasp region."""
        seen = self.left_mask == entry["id"]
        return self.points_m()[seen], self.left_label[seen] > 0


@pytest.fixture(scope="module")
def scenes(dataset):
    return [SceneFiles(path.parent) for path in sorted(dataset.glob("*/scene.json"))]


def test_another_seed_gives_other_scenes():
    first, second = (draw_scene(seed, 0, families=["mug"]) for seed in (1, 2))
    assert first.objects[0].shape.shape_seed != second.objects[0].shape.shape_seed
    assert not np.allclose(first.cam_from_table, second.cam_from_table)


def test_layout(dataset, scenes):
    header = json.loads((dataset / "dataset.json").read_text())
    assert (header["format"], header["version"], header["seed"], header["scenes"]) == (
        "graspctx-dataset",
        1,
        3,
        SCENES,
    )
    assert header["families"] == list(FAMILIES)
    assert len(scenes) == SCENES
    assert not list(dataset.glob("*.partial"))
    for scene in scenes:
        assert scene.left.shape == scene.right.shape == (480, 640, 3)
        assert scene.left.dtype == scene.left_mask.dtype == scene.left_label.dtype == np.uint8
        assert scene.read("left_depth").dtype == np.uint16
        assert scene.info["schema"] == 1
        assert scene.info["objects"][0]["family"] == list(FAMILIES)[scene.info["index"] % len(FAMILIES)]
        for side in ("left", "right"):
            mask, label = getattr(scene, side + "_mask"), getattr(scene, side + "_label")
            for entry in scene.info["objects"]:
                assert entry["visible_px"][side] == (mask == entry["id"]).sum() > 0
                assert entry["label_px"][side] == ((mask == entry["id"]) & (label > 0)).sum()


def test_calibration_file_agrees_with_the_json(scenes):
    for scene in scenes:
        lines = dict(line.split("=") for line in (scene.folder / "calib.txt").read_text().splitlines())
        (cx, cy), focal = scene.camera["centre_px"], scene.camera["focal_px"]
        rows = [[float(x) for x in row.split()] for row in lines["cam0"].strip("[]").split(";")]
        assert rows == [[focal, 0, cx], [0, focal, cy], [0, 0, 1]]
        assert lines["cam1"] == lines["cam0"]
        assert float(lines["baseline"]) == pytest.approx(scene.camera["baseline_m"] * 1000, abs=1e-9)
        assert float(lines["doffs"]) == scene.camera["doffs_px"] == 0
        assert (int(lines["width"]), int(lines["height"])) == tuple(scene.info["image_size"])
        assert scene.disparity_px()[scene.depth_m > 0].max() < int(lines["ndisp"])


def test_labels_lie_on_objects(scenes):
    assert sum((scene.left_label > 0).any() for scene in scenes) >= SCENES - 2
    for scene in scenes:
        for side in ("left", "right"):
            mask, label = getattr(scene, side + "_mask"), getattr(scene, side + "_label")
            assert set(np.unique(label)) <= {0, 255}
            assert (mask[label > 0] > 0).all()
            assert 0 < (mask > 0).mean() < 0.3


def test_table_pixels_lie_on_the_table_plane(scenes):
    for scene in scenes:
        plane = scene.info["table_plane"]
        assert np.linalg.norm(plane["normal"]) == pytest.approx(1, abs=1e-6)
        points = scene.points_m()
        height = points @ plane["normal"] + plane["offset_m"]
        assert plane["offset_m"] > 0.1
        # The table reaches at least 35 cm from its middle. Depth is stored in steps of 0.1 mm.
        middle = np.array(scene.info["cam_from_table"])[:3, 3]
        seen = scene.depth_m > 0
        down = np.where(seen, points @ plane["normal"], -1.0)
        on_plane = points * (-plane["offset_m"] / down)[..., None]
        away = np.linalg.norm(on_plane - middle, axis=-1)
        # A wall close behind the objects hides a part of it.
        reach = 0.34 if scene.info["axes"]["background"] != "wall" else 0.03
        on_table = seen & (down < 0) & (scene.left_mask == 0) & (away < reach)
        assert on_table.mean() > (0.2 if reach > 0.1 else 0)
        assert np.abs(height[on_table]).max() < 1e-4
        # Around the objects there is table only.
        v, u = np.nonzero(scene.left_mask)
        below = height[v.max() + 1 : v.max() + 4, u.min() : u.max()]
        assert np.abs(below).max() < 0.001
        normal = np.array(scene.info["cam_from_table"])[:3, 2]
        assert np.allclose(normal, plane["normal"], atol=1e-8)


def test_objects_rest_on_the_table(scenes):
    for scene in scenes:
        plane = scene.info["table_plane"]
        for entry in scene.info["objects"]:
            vertices = make_object(entry["family"], entry["shape_seed"]).mesh.vertices_m
            pose = np.array(entry["cam_from_object"])
            height = (vertices @ pose[:3, :3].T + pose[:3, 3]) @ plane["normal"] + plane["offset_m"]
            assert height.min() == pytest.approx(0, abs=1e-6)


def test_left_pixels_project_onto_the_same_instance_in_the_right_view(scenes):
    for scene in scenes:
        for mask_l, mask_r in ((scene.left_mask, scene.right_mask), (scene.left_label, scene.right_label)):
            v, u = np.nonzero(mask_l)
            if len(v) == 0:
                continue
            u_right = np.round(u - scene.disparity_px()[v, u]).astype(int)
            same = mask_r[v, np.clip(u_right, 0, 639)] == mask_l[v, u]
            # The rest is hidden in the right view, or rounded across an outline.
            assert same.mean() > (0.75 if mask_l is scene.left_mask else 0.4)
        shift = np.nonzero(scene.left_mask)[1].mean() - np.nonzero(scene.right_mask)[1].mean()
        if len(scene.info["objects"]) == 1:  # two may hide each other, more in one view than in the other
            assert shift == pytest.approx(scene.disparity_px()[scene.left_mask > 0].mean(), abs=6)


def test_pictures_agree_between_the_views(scenes):
    """Textured surfaces look alike at the disparity that the depth gives, and less alike 3 px beside it."""
    compared = 0
    for scene in scenes:
        if scene.info["table_texture"] != "textured":
            continue
        grey_left, grey_right = scene.left.mean(-1), scene.right.mean(-1)
        v, u = np.indices(grey_left.shape)
        usable = (scene.depth_m > 0) & (u > 150)
        v, u = v[usable], u[usable]
        u_right = u - scene.disparity_px()[usable]

        def difference(offset, left=grey_left, right=grey_right, v=v, u=u, u_right=u_right):
            return np.median(
                np.abs(left[v, u] - right[v, np.clip(np.round(u_right + offset).astype(int), 0, 639)])
            )

        assert difference(0) < 0.9 * min(difference(-3), difference(3))
        compared += 1
    assert compared >= 2


def test_seen_points_lie_on_the_mesh_and_labels_on_the_region(scenes):
    """Pixels back-projected into the object frame meet the mesh; labelled ones its region."""
    for scene in scenes:
        for entry in scene.info["objects"]:
            shape = make_object(entry["family"], entry["shape_seed"])
            centres = shape.mesh.vertices_m[shape.mesh.faces].mean(axis=1)
            points, labelled = scene.object_points_m(entry)
            object_from_cam = np.linalg.inv(np.array(entry["cam_from_object"]))
            points = points @ object_from_cam[:3, :3].T + object_from_cam[:3, 3]
            step = max(1, len(points) // 150)
            points, labelled = points[::step], labelled[::step]
            distance = np.linalg.norm(points[:, None] - centres[None], axis=-1)
            assert np.median(distance.min(axis=1)) < 0.004
            if labelled.any():
                to_region = distance[:, shape.mesh.region].min(axis=1)
                assert np.percentile(to_region[labelled], 95) < 0.006


@pytest.mark.parametrize("family", FAMILIES)
def test_shapes_are_closed_and_turned_outwards(family):
    for seed in range(6):
        shape = make_object(family, seed)
        mesh = shape.mesh
        assert np.isfinite(mesh.vertices_m).all()
        assert mesh.faces.max() < len(mesh.vertices_m)
        # The signed volume of a closed surface turned outwards is positive, and less than its bounding box's.
        a, b, c = (mesh.vertices_m[mesh.faces[:, k]] for k in range(3))
        volume = (a * np.cross(b, c)).sum() / 6
        assert 0 < volume < np.prod(np.ptp(mesh.vertices_m, axis=0))
        # Every edge has two faces, apart from the ends of handles and spouts, which stop inside the wall.
        edges = np.sort(mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        _, corner = np.unique(np.round(mesh.vertices_m, 9), axis=0, return_inverse=True)
        edges = np.sort(corner.reshape(-1)[edges], axis=1)
        _, count = np.unique(edges, axis=0, return_counts=True)
        assert (count == 1).sum() == {"mug": 40, "teapot": 40 + 24}.get(family, 0)
        normals = corner_normals(mesh.vertices_m, mesh.faces)
        assert np.allclose(np.linalg.norm(normals, axis=-1), 1, atol=1e-6)
        for pose in shape.resting_poses:
            assert np.allclose(pose.table_from_object @ pose.table_from_object.T, np.eye(3), atol=1e-12)
            assert np.linalg.det(pose.table_from_object) == pytest.approx(1)


def test_grasp_regions():
    for seed in range(20):
        mug, pencil, glass = (make_object(family, seed) for family in ("mug", "pencil", "wineglass"))
        region = {
            shape.family: shape.mesh.vertices_m[np.unique(shape.mesh.faces[shape.mesh.region])]
            for shape in (mug, pencil, glass)
        }
        size = mug.dimensions_m
        radius = np.hypot(region["mug"][:, 0], region["mug"][:, 1])
        body = mug.mesh.vertices_m[np.unique(mug.mesh.faces[~mug.mesh.region])]
        # The handle starts inside the wall, without coming out on its inner side, and reaches well beyond it.
        for x, y, z in region["mug"]:
            assert x > abs(y)
            assert 0 < z < size["height"]
        inner = np.hypot(body[:, 0], body[:, 1])
        inside = mug.mesh.vertices_m[len(body) :]
        assert len(inside) == len(region["mug"])
        assert radius.max() - inner.max() > 0.008
        length = pencil.dimensions_m["length"]
        assert region["pencil"][:, 2].min() == pytest.approx(0.3 * length)
        assert region["pencil"][:, 2].max() == pytest.approx(0.7 * length)
        stem = np.hypot(region["wineglass"][:, 0], region["wineglass"][:, 1])
        assert stem.max() < 2 * glass.dimensions_m["stem_radius"]
        assert np.ptp(region["wineglass"][:, 2]) == pytest.approx(glass.dimensions_m["stem_length"])


def test_mug_handles_stay_out_of_the_inside_and_lying_mugs_touch_the_table_with_them():
    for seed in range(20):
        mug = make_object("mug", seed)
        mesh = mug.mesh
        handle = np.unique(mesh.faces[mesh.region])
        body = np.unique(mesh.faces[~mesh.region])
        rings = mesh.vertices_m[body].reshape(-1, 80, 3)
        profile = np.stack([np.hypot(rings[:, 0, 0], rings[:, 0, 1]), rings[:, 0, 2]], axis=1)
        top = profile[:, 1].argmax()
        inner = profile[top:][::-1]
        outer = profile[np.flatnonzero(profile[:top, 1] < 1e-9)[-1] : top + 1]
        x, y, z = mesh.vertices_m[handle].T
        radius = np.hypot(x, y)
        assert (radius > np.interp(z, inner[:, 1], inner[:, 0]) + 0.0005).all()
        ends = np.concatenate([radius[:20], radius[-20:]])
        wall = np.interp(np.concatenate([z[:20], z[-20:]]), outer[:, 1], outer[:, 0])
        assert (ends < wall - 0.0005).all()
        for pose in (pose for pose in mug.resting_poses if pose.name == "lying"):
            height = mesh.vertices_m @ pose.table_from_object[2]
            assert height[body].min() == pytest.approx(height.min(), abs=1e-4)
            assert height[handle].min() == pytest.approx(height.min(), abs=1e-3)


def test_textures_are_periodic_and_repeatable():
    for family in FAMILIES:
        shape = make_object(family, 4)
        texture = object_texture(shape, 11)
        assert texture.shape == (512, 512, 3) and texture.dtype == np.uint8
        assert (texture == object_texture(shape, 11)).all()
        assert (texture != object_texture(shape, 12)).any()
    contrast = {}
    for kind in SURFACE_KINDS:
        pixels = [surface_texture(seed, kind, 128).astype(float) for seed in range(8)]
        contrast[kind] = np.mean([p.std(axis=(0, 1)).mean() for p in pixels])
    assert contrast["uniform"] == 0
    assert 0.5 < contrast["faint"] < 8 < contrast["textured"]
    with pytest.raises(ValueError, match=r"unknown surface 'shiny'; known: textured"):
        surface_texture(1, "shiny")


def test_unknown_family_is_refused():
    with pytest.raises(ValueError, match=r"unknown family 'unicorn'; known: mug, cup, pencil"):
        make_object("unicorn", 1)
