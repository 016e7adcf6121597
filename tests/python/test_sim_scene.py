"""Drawn scenes: what scene.json says of them is what the pictures show."""

import dataclasses
import importlib.util
import itertools
import json
import pickle

import numpy as np
import pytest

if importlib.util.find_spec("mujoco") is None:  # to import it would choose a graphics library for all
    pytest.skip("rendered scenes need the extra 'sim' (mujoco)", allow_module_level=True)

from graspctx.sim import draw_scene
from graspctx.sim.difficulty import CHOICES, DEFAULT, DIFFICULTIES, LIMITS, Difficulty, with_axis
from graspctx.sim.families.solids import Solids
from graspctx.sim.geometry import gap_m, outline, surface_points
from graspctx.sim.placing import visible_shares
from graspctx.sim.render import Renderer
from graspctx.sim.scene import NoViewError
from graspctx.sim.scene_files import encode_scene
from graspctx.sim.scene_json import describe_scene
from graspctx.sim.sensor import Sensor, photograph

FAMILIES = ["mug", "pencil", "wineglass"]


@pytest.fixture(scope="module")
def renderer():
    with Renderer() as renderer:
        yield renderer


def difficulty(*axes, start="default"):
    drawn_from = DIFFICULTIES[start]
    for axis in axes:
        drawn_from = with_axis(drawn_from, axis)
    return drawn_from


def draw(index, *axes, start="default", families=FAMILIES, **options):
    return draw_scene(11, index, families=families, difficulty=difficulty(*axes, start=start), **options)


QUIET = ("noise=0", "blur_px=0", "exposure_ratio=1", "shadow=none", "background=room")


# ---- axes ----


def test_every_axis_has_limits_that_all_difficulties_keep():
    names = {field.name for field in dataclasses.fields(Difficulty)}
    assert names == {*CHOICES, *LIMITS}
    for drawn_from in DIFFICULTIES.values():
        for axis, values in CHOICES.items():
            assert set(getattr(drawn_from, axis)) <= set(values)
        for axis, (lowest, highest) in LIMITS.items():
            low, high = getattr(drawn_from, axis)
            assert lowest <= low <= high <= highest
        assert json.loads(json.dumps(drawn_from.to_dict())) == drawn_from.to_dict()


def test_named_axes_are_drawn_by_their_weights():
    rng = np.random.default_rng(3)
    drawn = [DEFAULT.choose(rng, "table") for _ in range(4000)]
    for value, weight in DEFAULT.table.items():
        assert drawn.count(value) / len(drawn) == pytest.approx(weight, abs=0.03)


@pytest.mark.parametrize(
    "setting, axis, value",
    [
        ("table=faint,uniform", "table", {"faint": 1.0, "uniform": 1.0}),
        ("noise=3", "noise", (3.0, 3.0)),
        ("blur_px=.5-1.25", "blur_px", (0.5, 1.25)),
        ("roll_deg=-20-20", "roll_deg", (-20.0, 20.0)),
        ("roll_deg=-20--5", "roll_deg", (-20.0, -5.0)),
    ],
)
def test_an_axis_can_be_set_and_the_others_stay(setting, axis, value):
    changed = with_axis(DEFAULT, setting)
    assert getattr(changed, axis) == value
    assert dataclasses.replace(changed, **{axis: getattr(DEFAULT, axis)}) == DEFAULT


@pytest.mark.parametrize(
    "setting, message",
    [
        ("colour=red", "unknown axis 'colour'; known: table, background"),
        ("table", "axis table: unknown value ''"),
        ("table=faint,shiny", "unknown value 'shiny'; known: textured, faint, uniform"),
        ("noise=loud", "'loud' is not a number or LOW-HIGH"),
        ("noise=nan", "'nan' is not a number"),
        ("noise=4-2", "not within 0 to 30, low before high"),
        ("elevation_deg=0-40", "not within 5 to 85"),
    ],
)
def test_wrong_axes_are_refused(setting, message):
    with pytest.raises(ValueError, match=message):
        with_axis(DEFAULT, setting)


def test_drawn_scenes_have_what_is_asked_for():
    for index in range(8):
        scene = draw(index, "table=uniform", "background=far", "elevation_deg=30-31", "fov_deg=60", "noise=4")
        assert scene.table.texture == "uniform" and scene.background.kind == "far"
        assert 30 <= scene.viewpoint.elevation_deg <= 31
        assert scene.camera.focal_px == pytest.approx(320 / np.tan(np.radians(30)), abs=0.01)
        assert scene.sensor.noise == 4


@pytest.mark.parametrize("index", range(4))
def test_the_camera_stands_where_the_viewpoint_says(index):
    scene = draw(index, start="hard", objects=(1, 3))
    view = scene.viewpoint
    rotation, place = scene.cam_from_table[:3, :3], scene.cam_from_table[:3, 3]
    assert np.allclose(rotation @ rotation.T, np.eye(3)) and np.linalg.det(rotation) > 0
    assert np.degrees(np.arcsin(-rotation[2, 2])) == pytest.approx(view.elevation_deg)
    up = rotation[:, 2]
    assert np.degrees(np.arctan2(-up[0], -up[1])) == pytest.approx(-view.roll_deg)
    points = np.concatenate([placed.points_m for placed in scene.objects])
    middle = rotation @ ((points.min(axis=0) + points.max(axis=0)) / 2) + place
    from_both = middle - [scene.camera.baseline_m / 2, 0, 0]
    assert np.linalg.norm(from_both) == pytest.approx(view.distance_m)
    seen = points @ rotation.T + place
    for shift in (0, scene.camera.baseline_m):
        pixels = scene.camera.project(seen - [shift, 0, 0])
        assert pixels.min() >= 0 and (pixels <= np.array(scene.camera.image_size) - 1).all()


def test_objects_that_fit_no_view_are_refused_in_one_line():
    with pytest.raises(NoViewError, match="6 objects at distance_m") as refused:
        draw(0, "distance_m=0.3", "fov_deg=20", objects=(6, 6))
    assert "\n" not in str(refused.value)


# ---- what stands on the table ----


@pytest.fixture(scope="module")
def crowds():
    return [
        draw(index, f"spacing={spacing}", objects=(3, 5))
        for spacing, index in itertools.product(CHOICES["spacing"], range(5))
    ]


def test_objects_on_the_table_keep_apart_and_touch_where_they_are_asked_to(crowds):
    touching = 0
    for scene in crowds:
        outlines = [outline(placed.points_m[:, :2]) for placed in scene.objects]
        gaps = [gap_m(first, second) for first, second in itertools.combinations(outlines, 2)]
        assert min(gaps) > (0.012 if scene.spacing == "apart" else 0.0005)
        touching += scene.spacing == "touching" and min(gaps) < 0.002
        for placed in scene.objects:
            assert placed.points_m[:, 2].min() == pytest.approx(0, abs=1e-9)
            reach = np.abs(placed.points_m[:, :2]).max(axis=0)
            assert (reach < np.array(scene.table.half_size_m) * np.sqrt(2)).all()
    assert touching >= 4
    assert draw(0, "spacing=touching").spacing == "apart"


def test_gap_of_outlines():
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    assert gap_m(square, square + np.array([1.5, 0.3])) == pytest.approx(0.5)
    assert gap_m(square, square + np.array([0.9, 0.2])) == pytest.approx(-0.1)
    turned = (square - 0.5) @ np.array([[1, 1], [-1, 1]]) / np.sqrt(2)  # a corner points at the square
    assert gap_m(square, turned + np.array([2, 0.5])) == pytest.approx(1 - np.sqrt(0.5))


@pytest.fixture(scope="module")
def leaning():
    scenes = [draw(index, "pose=leaning", objects=(2, 3)) for index in range(6)]
    found = [(s, placed) for s in scenes for placed in s.objects if placed.pose == "leaning"]
    assert len(found) >= 4
    return found


def test_leaning_objects_touch_table_and_prop_without_sinking_into_either(leaning):
    from scipy.spatial import cKDTree

    for scene, placed in leaning:
        prop = scene.objects[placed.leans_on - 1]
        assert prop.id == placed.leans_on and prop is not placed
        assert placed.points_m[:, 2].min() == pytest.approx(0, abs=1e-9)
        assert placed.points_m[:, 2].max() > 0.015
        surfaces = []
        for item in (placed, prop):
            pose = item.table_from_object
            surfaces.append(surface_points(item.shape.mesh, 60000) @ pose[:3, :3].T + pose[:3, 3])
        # Points lie half a millimetre apart; solids follow the mesh to about one.
        assert cKDTree(surfaces[1]).query(surfaces[0])[0].min() < 0.003


def test_what_leans_would_fall_without_its_prop(leaning):
    """An independent look: the centre of the outline's contact with the table is not under the middle."""
    for _, placed in leaning:
        points = placed.points_m
        foot = points[points[:, 2] < 0.0006][:, :2]
        solids = [corners.mean(axis=0) for corners in placed.shape.solids_m]
        middle = (
            np.mean(solids, axis=0) @ placed.table_from_object[:3, :3].T + placed.table_from_object[:3, 3]
        )
        spread = np.ptp(foot, axis=0).max() if len(foot) > 1 else 0.0
        # Either it stands on an edge or a point, or the middle is beyond what it stands on.
        assert spread < 0.02 or np.linalg.norm(foot - middle[:2], axis=1).min() > 0.002


def test_leaning_is_the_same_every_time(leaning):
    scene = leaning[0][0]
    again = draw(scene.index, "pose=leaning", objects=(2, 3))
    for first, second in zip(scene.objects, again.objects):
        assert (first.table_from_object == second.table_from_object).all()


def test_poses_can_be_asked_for():
    for index in range(4):
        scene = draw(index, "pose=lying", families=["mug", "wineglass"])
        names = {pose.name for pose in scene.objects[0].shape.resting_poses}
        assert scene.objects[0].pose == ("lying" if "lying" in names else "standing")


# ---- what the pictures show ----


@pytest.fixture(scope="module")
def hidden(renderer):
    scenes = [draw(index, "occlusion=0.2-0.7", objects=(2, 3)) for index in range(4)]
    return [(scene, *renderer.render(scene)) for scene in scenes]


def test_visible_shares_are_those_of_the_masks_with_and_without_the_others(hidden, renderer):
    for scene, left, right in hidden[:2]:
        described = describe_scene(scene, left, right)
        for placed, entry in zip(scene.objects, described["objects"]):
            alone = dataclasses.replace(scene, objects=(dataclasses.replace(placed),))
            for side, view, single in zip(("left", "right"), (left, right), renderer.render(alone)):
                share = (view.instances == placed.id).sum() / (single.instances == placed.id).sum()
                assert entry["visible_share"][side] == pytest.approx(share, abs=1e-4)
                region = (view.region & (view.instances == placed.id)).sum()
                label_share = region / max((view.instances == placed.id).sum(), 1)
                assert entry["visible_label_share"][side] == pytest.approx(label_share, abs=1e-4)
        shares = [entry["visible_share"]["left"] for entry in described["objects"]]
        assert described["axes"]["occlusion"] == pytest.approx(1 - min(shares), abs=1e-4)
        assert described["axes"]["objects"] == len(scene.objects)


def test_occlusion_is_about_what_is_asked_for_and_the_estimate_about_what_is_seen(hidden):
    for scene, left, right in hidden:
        described = describe_scene(scene, left, right)
        assert 0.1 < described["axes"]["occlusion"] < 0.8
        estimated = visible_shares(scene.camera, scene.cam_from_table, scene.objects)
        measured = [entry["visible_share"]["left"] for entry in described["objects"]]
        assert np.abs(estimated - measured).max() < 0.15


def test_labels_lie_on_masks_only(hidden):
    for scene, *views in hidden:
        for view in views:
            assert (view.instances[view.region] > 0).all()
            assert set(np.unique(view.instances)) <= {0, *(placed.id for placed in scene.objects)}


def test_depth_of_the_left_view_lands_on_the_depth_of_the_right_view(hidden):
    for scene, left, right in hidden:
        camera = scene.camera
        v, u = np.indices(left.depth_m.shape)
        u_right = np.round(u - camera.focal_px * camera.baseline_m / left.depth_m).astype(int)
        inside = (u_right >= 0) & (left.depth_m < 3)
        there = right.depth_m[v[inside], u_right[inside]]
        off = left.depth_m[inside] - there
        # What the left view sees is hidden in the right view, or seen there; but for rounding at borders.
        assert (np.abs(off) < 0.004).mean() > 0.85
        assert (off < -0.01).mean() < 0.02


@pytest.mark.parametrize("offset_px", [-3.0, 2.5])
def test_vertical_offset_moves_everything_in_the_right_view(renderer, offset_px):
    straight = draw(0, *QUIET, "table=textured")
    moved = dataclasses.replace(
        straight, sensor=dataclasses.replace(straight.sensor, vertical_offset_px=offset_px)
    )
    (left, right), (moved_left, moved_right) = renderer.render(straight), renderer.render(moved)
    assert (left.colour == moved_left.colour).all() and (left.depth_m == moved_left.depth_m).all()
    grey, moved_grey = (view.colour.mean(axis=-1) for view in (right, moved_right))
    window = np.hanning(grey.shape[0])[:, None] * np.hanning(grey.shape[1])
    first, second = (np.fft.rfft2((g - g.mean()) * window) for g in (grey, moved_grey))
    cross = np.conj(first) * second
    correlation = np.fft.irfft2(cross / np.maximum(np.abs(cross), 1e-9), grey.shape)[:, :3].max(axis=1)
    peak = int(correlation.argmax())
    assert (peak + 240) % 480 - 240 == pytest.approx(offset_px, abs=0.6)
    rows = [np.nonzero(view.instances)[0].mean() for view in (right, moved_right)]
    assert rows[1] - rows[0] == pytest.approx(offset_px, abs=0.3)
    assert describe_scene(moved, moved_left, moved_right)["axes"]["vertical_offset_px"] == offset_px


def test_exposure_brightness_and_noise_are_those_in_the_pictures(renderer):
    scene = draw(
        2, "table=uniform", "background_texture=uniform", "background=room", "exposure_ratio=0.8", "noise=5",
        "blur_px=0", "brightness=90", "shadow=none",
    )  # fmt: skip
    left, right = renderer.render(scene)
    axes = describe_scene(scene, left, right)["axes"]
    assert axes["brightness"] == pytest.approx(left.colour.mean(), abs=0.01)
    assert axes["brightness"] == pytest.approx(90, abs=5)
    assert right.colour.mean() / left.colour.mean() == pytest.approx(axes["exposure_ratio"], rel=0.05)
    # On a uniform table a pixel and its neighbour differ by their noise only.
    table = left.instances == 0
    table[:240] = False
    difference = np.diff(left.colour.astype(float), axis=1)[(table[:, 1:] & table[:, :-1])]
    spread = np.median(np.abs(difference)) / 0.6745 / np.sqrt(2)
    assert spread == pytest.approx(axes["noise"], rel=0.12)


def test_blur_spreads_a_point_by_its_standard_deviation():
    light = np.zeros((63, 93, 3), np.uint8)
    light[30:33, 45:48] = 255
    rng = np.random.default_rng(0)
    sensor = Sensor(brightness=0, exposure_ratio=1, blur_px=1.2, noise=0.0, vertical_offset_px=0)
    image = photograph(light, (31, 21), sensor, 4.0, rng)[..., 0].astype(float)
    for axis in (0, 1):
        profile = image.sum(axis=axis)
        at = np.arange(len(profile))
        middle = (profile * at).sum() / profile.sum()
        assert np.sqrt((profile * (at - middle) ** 2).sum() / profile.sum()) == pytest.approx(1.2, abs=0.15)


@pytest.mark.parametrize("background, nearest_m, farthest_m", [("wall", 0.4, 2.0), ("far", 1.0, 9.0)])
def test_walls_stand_where_the_background_says(renderer, background, nearest_m, farthest_m):
    scene = draw(1, f"background={background}", "elevation_deg=20-22", "roll_deg=0")
    left, _ = renderer.render(scene)
    top = left.depth_m[0]
    assert (left.instances[0] == 0).all()
    assert nearest_m < np.median(top) < farthest_m
    if background == "wall":
        assert np.median(top) < 1.6


def test_a_table_can_stand_empty(renderer):
    for index, start in enumerate(["easy", "default", "hard"]):
        scene = draw(index, start=start, objects=(0, 0))
        left, right = renderer.render(scene)
        assert scene.objects == () and not left.instances.any() and not right.region.any()
        described = describe_scene(scene, left, right)
        assert described["objects"] == []
        assert (described["axes"]["objects"], described["axes"]["occlusion"]) == (0, 0)
        # The cameras look at the table, and nothing stands on it.
        camera, (normal, offset_m) = scene.camera, scene.table_plane
        v, u = np.indices(left.depth_m.shape)
        rays = np.stack(
            [(u - camera.centre_px[0]), (v - camera.centre_px[1]), np.full(u.shape, camera.focal_px)]
        )
        height_m = np.tensordot(normal, rays * left.depth_m / camera.focal_px, 1) + offset_m
        assert (np.abs(height_m) < 0.001).mean() > 0.1


def test_one_scene_gives_the_same_bytes_whatever_was_rendered_before(renderer):
    scene = draw(3, start="hard", objects=(2, 3))
    first = encode_scene(scene, *renderer.render(scene))
    renderer.render(draw(4))
    with Renderer() as other:
        again = encode_scene(draw(3, start="hard", objects=(2, 3)), *other.render(scene))
    renderer._gl.make_current()
    assert first == again
    assert {"left_depth.png", "right_depth.png"} <= set(first)


def test_solids_are_cut_when_asked_for_and_survive_a_copy_to_another_process():
    cuts = []
    more = (np.zeros((4, 3)),)
    solids = Solids(lambda: cuts.append(1) or [np.eye(4, 3)]) + more
    assert not cuts
    copied = pickle.loads(pickle.dumps(solids))
    assert len(solids) == len(copied) == 2 and len(cuts) == 1
    assert all((first == second).all() for first, second in zip(solids, copied))
