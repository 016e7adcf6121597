"""The whole method from Python: its contract, its JSON, its determinism, its pictures."""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import graspctx as gc
import numpy as np
import pytest
import scenes

TOP_KEYS = ["schema", "graspctx", "frame", "image_size", "model", "table_plane", "objects", "timings_ms"]
OBJECT_KEYS = ["id", "bounding_box_px", "centroid_px", "pose", "grasps"]
POSE_KEYS = ["centroid_m", "major_axis_m", "minor_axis_m", "normal", "source"]
GRASP_KEYS = [
    "rank",
    "probability",
    "probability_left",
    "probability_right",
    "left_px",
    "right_px",
    "position_m",
    "position_stddev_m",
    "rule",
    "approach",
    "closing",
    "cam_from_hand",
    "opening_m",
    "feasible",
    "infeasible_because",
]


def without_timings(detection: gc.Detection) -> str:
    found = detection.to_dict()
    assert found.pop("timings_ms")
    return json.dumps(found)


def numbers(value):
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return [number for item in value for number in numbers(item)]
    return [value] if isinstance(value, (int, float)) else []


def test_the_disc_is_found_where_it_is(detection):
    (item,) = detection.objects
    assert item.id == 1
    np.testing.assert_allclose(item.centroid_px, scenes.DISC_CENTRE_PX, atol=0.5)
    assert item.bounding_box_px == (128, 78, 85, 85)
    assert item.grasps
    depth_m = scenes.FOCAL_PX * scenes.BASELINE_M / scenes.OBJECT_PX
    errors_px = [abs(grasp.left_px[0] - grasp.right_px[0] - scenes.OBJECT_PX) for grasp in item.grasps]
    assert np.median(errors_px) < 0.5
    assert max(errors_px) < 2  # at the rim the window sees the wall, too
    for grasp in item.grasps:
        # On the disc, or inside it by half the width of the part.
        assert abs(grasp.position_m[2] - depth_m) < 0.15
    assert item.pose.source in ("stereo", "segment_depth")
    assert item.pose.centroid_m[2] == pytest.approx(depth_m, rel=0.05)


def test_json_keys_and_values(detection, model):
    text = detection.to_json()
    found = json.loads(text)
    assert found == detection.to_dict()
    assert list(found) == TOP_KEYS
    assert (found["schema"], found["graspctx"], found["frame"]) == (
        1,
        gc.__version__,
        "left_rectified_optical",
    )
    assert found["image_size"] == [scenes.WIDTH, scenes.HEIGHT] == list(detection.image_size)
    assert found["model"] == {"name": "disc", "sha256": hashlib.sha256(model.to_bytes()).hexdigest()}
    for item, object_ in zip(found["objects"], detection.objects):
        assert list(item) == OBJECT_KEYS
        assert list(item["pose"]) == POSE_KEYS
        np.testing.assert_array_equal(item["pose"]["normal"], object_.pose.normal)
        for entry, grasp in zip(item["grasps"], object_.grasps):
            assert list(entry) == GRASP_KEYS
            for key in GRASP_KEYS:
                np.testing.assert_array_equal(entry[key], getattr(grasp, key), err_msg=key)
    assert np.isfinite(numbers(found)).all()
    assert "\n" not in detection.to_json(indent=-1).strip()
    assert json.loads(detection.to_json(indent=-1)) == found
    assert [*found["timings_ms"]] == [*detection.timings_ms]


def test_grasps_are_frames_and_ranked(detection):
    for item in detection.objects:
        assert np.linalg.norm(item.pose.normal) == pytest.approx(1, abs=1e-6)
        grasps = item.grasps
        assert [grasp.rank for grasp in grasps] == list(range(1, len(grasps) + 1))
        key = [(not grasp.feasible, -grasp.probability) for grasp in grasps]
        assert key == sorted(key)
        for grasp in grasps:
            rotation = grasp.cam_from_hand[:3, :3]
            np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=1e-6)
            assert np.linalg.det(rotation) == pytest.approx(1, abs=1e-6)
            np.testing.assert_array_equal(grasp.cam_from_hand[3], [0, 0, 0, 1])
            np.testing.assert_allclose(rotation[:, 0], grasp.closing, atol=1e-12)
            np.testing.assert_allclose(rotation[:, 2], grasp.approach, atol=1e-12)
            np.testing.assert_allclose(rotation[:, 1], np.cross(grasp.approach, grasp.closing), atol=1e-12)
            assert grasp.probability == pytest.approx(grasp.probability_left * grasp.probability_right)
            assert 0 <= grasp.probability <= 1
            assert grasp.rule in ("plane_normal", "major_axis", "minor_axis")
            assert (grasp.infeasible_because is None) == grasp.feasible


def test_what_was_seen_fits_together(detection, model, camera):
    (item,) = detection.objects
    seen = item.intermediates
    np.testing.assert_array_equal(
        seen.probabilities, model.predict_probability(np.ascontiguousarray(seen.patches.features))
    )
    assert len(seen.contour) == model.descriptor["samples"]
    points = gc.find_grasp_points(seen.patches, seen.probabilities)
    assert points
    assert [p.probability for p in points] == sorted((p.probability for p in points), reverse=True)
    for point in points:
        assert point.probability == seen.probabilities[point.patch]
        np.testing.assert_allclose(point.centre_px, seen.patches.centres[point.patch])
    view = seen.fovea.left
    np.testing.assert_allclose(view.view_from_image(view.image_from_view([[3, 4], [5, 6]])), [[3, 4], [5, 6]])
    np.testing.assert_allclose(view.image_from_view([0, 0]), view.origin_px)
    assert seen.fovea.fixation_disparity_px == pytest.approx(scenes.OBJECT_PX, abs=0.5)
    assert detection.camera.focal_px == camera.focal_px
    assert "[0.] " not in repr(detection) and "1 objects" in repr(detection)


def test_disparity_of_known_shifts(pair, mask):
    disparity = gc.compute_disparity(*pair)
    inner = mask.astype(bool)
    for _ in range(6):
        inner = (
            inner
            & np.roll(inner, 1, 0)
            & np.roll(inner, -1, 0)
            & np.roll(inner, 1, 1)
            & np.roll(inner, -1, 1)
        )
    valid = disparity[inner & np.isfinite(disparity)]
    assert len(valid) > 0.5 * inner.sum()
    assert np.median(np.abs(valid - scenes.OBJECT_PX)) < 0.25
    reliable = gc.compute_disparity(*pair, reliable=True)
    assert (np.isfinite(reliable) <= np.isfinite(disparity)).all()


def test_options_reach_their_stage(pair, camera, model, mask):
    few = gc.detect_grasps(*pair, camera, model, mask=mask, max_grasps=1)
    assert len(few.objects[0].grasps) == 1
    sure = gc.detect_grasps(*pair, camera, model, mask=mask, min_probability=1.0)
    assert sure.objects[0].grasps == []
    ids = mask.copy()
    ids[20:60, 20:60] = 7
    both = gc.detect_grasps(*pair, camera, model, mask=ids)
    assert {item.id for item in both.objects} == {1, 7}
    none = gc.detect_grasps(*pair, camera, model, mask=np.zeros_like(mask))
    assert none.objects == []
    assert none.to_dict()["objects"] == []
    for options in ({"max_grasps": 0}, {"threads": 0}, {"approach_threshold": -1.0}, {"window_px": 4}):
        with pytest.raises(gc.InvalidInput):
            gc.detect_grasps(*pair, camera, model, mask=mask, **options)
    with pytest.raises(gc.InvalidInput):
        gc.detect_grasps(pair[0], pair[1][:-1], camera, model)
    with pytest.raises(TypeError):
        gc.detect_grasps(*pair, camera, "mug")


@pytest.mark.parametrize("cues", ["disparity", "plane", "colour"])
def test_segmentation_agrees_with_itself(pair, camera, cues):
    scene = gc.segment_scene(*pair, camera, cues=cues)
    np.testing.assert_array_equal(gc.segment_objects(*pair, camera, cues=cues), scene.instance_ids)
    assert set(np.unique(scene.instance_ids)) - {0} <= {item.id for item in scene.objects}
    saliencies = [item.saliency for item in scene.objects]
    assert saliencies == sorted(saliencies, reverse=True)


def test_segmentation_says_what_it_knows_of_the_table(mug_pair):
    left, right = gc.read_image(mug_pair.left), gc.read_image(mug_pair.right)
    camera = gc.StereoCamera.load(mug_pair.calibration)
    scene = gc.segment_scene(left, right, camera)
    (mug,) = scene.objects
    heights = scene.heights_m
    assert heights.dtype == np.float32 and heights.shape == scene.instance_ids.shape
    assert not heights.flags.writeable
    known = np.isfinite(heights)
    # From the heights alone: what is the mug's is high, what is around it is table.
    assert np.nanquantile(heights[scene.instance_ids == mug.id], 0.95) == pytest.approx(
        mug.size_m[2], abs=0.01
    )
    assert abs(np.nanmedian(heights[known & (scene.instance_ids == 0)])) < 0.001
    assert mug.size_m[0] >= mug.size_m[1]
    assert 0.3 < mug.depth_m < 1 and not mug.leaves_table and not mug.touches_border
    flat = gc.segment_scene(left, right, camera, cues="disparity")
    assert flat.heights_m is None and flat.table is None
    # The table that was found, given back as what is known of the rig.
    for table in (scene.table, (*scene.table.normal, scene.table.offset_m)):
        again = gc.segment_scene(left, right, camera, table=table)
        np.testing.assert_allclose(again.objects[0].size_m, mug.size_m, atol=1e-3)
    x, y, width, height = mug.bounding_box_px
    inside = gc.segment_objects(left, right, camera, roi_px=(x - 9, y - 9, width + 18, height + 18))
    assert (inside > 0).any() and set(np.unique(inside)) == {0, 1}
    assert gc.segment_scene(left, right, camera, gravity=-scene.table.normal).table is not None


def test_the_picture_of_a_segmentation(pair, camera):
    picture = gc.draw_segmentation(*pair, camera, panel_px=320)
    assert picture.dtype == np.uint8 and picture.ndim == 3
    assert 4 * 320 < picture.shape[1] < 4.4 * 320
    # RGB: the first panel holds the left view, where nothing is drawn on it.
    corner = pair[0][:8, :8]
    rows = [v for v in range(60) if (picture[v : v + 8, 7:15] == corner).all()]
    assert len(rows) == 1
    with pytest.raises(gc.InvalidInput, match="panel_px"):
        gc.draw_segmentation(*pair, camera, panel_px=1)


def test_threads_do_not_matter(pair, camera, model, mask):
    ids = np.zeros_like(mask)
    for value, column in enumerate((70, 120, 170, 220), start=1):
        ids[60:180, column : column + 40] = value
    texts = {
        without_timings(gc.detect_grasps(*pair, camera, model, mask=ids, threads=threads))
        for threads in (1, 2, 3, 8)
    }
    assert len(texts) == 1


def test_processes_do_not_matter(detection):
    code = """
import json, scenes, graspctx as gc
left, right, mask = scenes.disc_scene()
found = gc.detect_grasps(left, right, scenes.camera(), scenes.disc_model(), mask=mask)
document = found.to_dict()
document.pop("timings_ms")
print(json.dumps(document), end="")
"""
    for hash_seed in ("1", "2"):
        path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
        environment = {**os.environ, "PYTHONPATH": path, "PYTHONHASHSEED": hash_seed}
        other = subprocess.run(
            [sys.executable, "-c", code], check=True, capture_output=True, text=True, env=environment
        )
        assert other.stdout == without_timings(detection)


def test_pictures(detection):
    picture = detection.draw(min_width_px=scenes.WIDTH)
    assert picture.shape == (scenes.HEIGHT, scenes.WIDTH, 3)
    np.testing.assert_array_equal(gc.draw_detection(detection, min_width_px=scenes.WIDTH), picture)
    nothing = detection.draw(
        min_width_px=scenes.WIDTH, max_grasps=0, contour=False, probabilities=False, pose=False
    )
    changed = (nothing != detection.left).any(axis=2)
    ids = detection.segmentation.instance_ids
    assert changed[ids > 0].mean() > 0.9
    grown = np.zeros_like(changed)
    for dv in (-2, -1, 0, 1, 2):
        for du in (-2, -1, 0, 1, 2):
            grown |= np.roll(ids > 0, (dv, du), axis=(0, 1))
    assert not changed[~grown].any()
    with pytest.raises(gc.InvalidInput):
        detection.draw(max_grasps=-1)


def test_plots(detection, pair, mask, camera):
    matplotlib = pytest.importorskip("matplotlib", reason="plots need the extra 'plot' (matplotlib)")
    matplotlib.use("Agg")
    axes = gc.plot.plot_detection(detection, max_grasps=1)
    np.testing.assert_array_equal(axes.images[0].get_array(), detection.draw(max_grasps=1))
    levels = gc.plot.plot_cue_levels(*pair, camera, max_objects=1)
    assert [axes.get_title().split(":")[0] for axes in levels.axes] == ["disparity", "plane", "colour"]
    gc.plot.plot_descriptor(pair[0], mask, samples=120, outline_px=3)
    figure = gc.plot.plot_descriptor(pair[0], mask, samples=120)
    assert len(figure.axes) == 5
    assert figure.axes[1].get_title().startswith("120 contour samples")
    with pytest.raises(TypeError, match="smaples"):
        gc.plot.plot_descriptor(pair[0], mask, smaples=120)
    matplotlib.pyplot.close("all")


def test_the_bundled_mug_keeps_its_inside_and_its_handle_its_gap(mug_pair):
    load = gc.read_image
    ids = gc.segment_objects(
        load(mug_pair.left),
        load(mug_pair.right),
        gc.StereoCamera.load(mug_pair.calibration),
    )
    body, inside, gap = ids[185, 349], ids[124, 349], ids[160, 397]
    assert body > 0
    assert inside == body  # its red is much like the table's
    assert gap == 0
