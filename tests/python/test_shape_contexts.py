"""Shape contexts and patch descriptors against plain references, and under shifts, scalings and mirrors."""

import math

import graspctx as gc
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst


def naive_shape_contexts(points, angular_bins, radial_bins, inner_radius, outer_radius):
    """III-B in double precision, one pair at a time; and how near any pair comes to the border of a ring."""
    points = [(float(u), float(v)) for u, v in points]
    n = len(points)
    counts = np.zeros((n, angular_bins * radial_bins))
    distances = [[math.dist(p, q) for q in points] for p in points]
    mean = sum(map(sum, distances)) / (n * (n - 1))
    ratio = (outer_radius / inner_radius) ** (1 / max(1, radial_bins - 1))
    borders = [inner_radius * ratio**ring for ring in range(radial_bins - 1)] + [outer_radius]
    nearest = math.inf
    for i, (u, v) in enumerate(points):
        for j, (other_u, other_v) in enumerate(points):
            if i == j:
                continue
            radius = distances[i][j] / (mean or 1.0)
            nearest = min(nearest, min(abs(radius - border) / border for border in borders))
            ring = sum(radius >= border for border in borders)
            if ring == radial_bins:
                continue
            turn = math.atan2(other_v - v, other_u - u) / (2 * math.pi) % 1.0
            angle = min(int(turn * angular_bins), angular_bins - 1)
            counts[i, angle * radial_bins + ring] += 1
    return counts, nearest


def point_sets(elements):
    shapes = st.tuples(st.integers(3, 24), st.just(2))
    return npst.arrays(np.float32, shapes, elements=elements)


BINS = st.sampled_from(
    [(8, 5, 0.125, 2.0), (4, 5, 0.125, 2.0), (12, 5, 0.125, 2.0), (8, 3, 0.2, 1.5), (16, 1, 0.1, 1.0)]
)


@settings(deadline=None, max_examples=150)
@given(point_sets(st.integers(-200, 200).map(float)), BINS)
def test_counts_equal_the_reference_on_integer_points(points, bins):
    """Integer points lie on the borders of the angles: bin 0 starts at +u, borders belong to the next bin."""
    expected, nearest = naive_shape_contexts(points, *bins)
    assume(nearest > 1e-9)
    names = ("angular_bins", "radial_bins", "inner_radius", "outer_radius")
    np.testing.assert_array_equal(gc.shape_contexts(points, **dict(zip(names, bins))), expected)


@settings(deadline=None, max_examples=100)
@given(point_sets(st.floats(0, 640, width=32)), BINS)
def test_counts_equal_the_reference_on_sub_pixel_points(points, bins):
    assume(np.ptp(points, axis=0).max() > 1)
    points = np.round(points * 64) / 64  # differences far below a pixel say nothing about a shape
    expected, nearest = naive_shape_contexts(points, *bins)
    assume(nearest > 1e-9)
    names = ("angular_bins", "radial_bins", "inner_radius", "outer_radius")
    np.testing.assert_array_equal(gc.shape_contexts(points, **dict(zip(names, bins))), expected)


def spread_points(seed: int, count: int = 150) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0, 256, (count, 2)).astype(np.float32)


def test_angle_major_from_plus_u_towards_plus_v():
    one_each = np.array([[0, 0], [10, 1], [-1, 10], [-10, -1], [1, -10]], np.float32)
    histogram = gc.shape_contexts(one_each, angular_bins=4)[0].reshape(4, 5)
    np.testing.assert_array_equal(histogram.sum(axis=1), [1, 1, 1, 1])
    right_below = np.array([[0, 0], [10, 1], [1, 10]], np.float32)
    histogram = gc.shape_contexts(right_below, angular_bins=4)[0].reshape(4, 5)
    np.testing.assert_array_equal(histogram.sum(axis=1), [2, 0, 0, 0])


@pytest.mark.parametrize("seed", range(3))
def test_shifts_and_scales_change_nothing(seed):
    points = np.round(spread_points(seed) * 16) / 16  # shifts and doubling are exact
    expected = gc.shape_contexts(points)
    np.testing.assert_array_equal(gc.shape_contexts(points + np.float32([64, -128])), expected)
    np.testing.assert_array_equal(gc.shape_contexts(points * np.float32(4)), expected)


@pytest.mark.parametrize("seed", range(3))
def test_mirrors_and_turns_move_the_bins(seed):
    points = spread_points(seed)
    histograms = gc.shape_contexts(points).reshape(-1, 8, 5)
    upside_down = gc.shape_contexts(points * np.float32([1, -1])).reshape(-1, 8, 5)
    np.testing.assert_array_equal(upside_down, histograms[:, ::-1])
    quarter_turn = gc.shape_contexts(points[:, ::-1] * np.float32([-1, 1])).reshape(-1, 8, 5)
    np.testing.assert_array_equal(quarter_turn, np.roll(histograms, 2, axis=1))
    order = np.random.default_rng(seed).permutation(len(points))
    np.testing.assert_array_equal(gc.shape_contexts(points[order]).reshape(-1, 8, 5), histograms[order])


def test_relative_to_gradient_turns_with_the_shape():
    points = spread_points(7)
    gradients = np.random.default_rng(7).uniform(-np.pi, np.pi, len(points)).astype(np.float32)
    options = {"relative_to_gradient": True, "angular_bins": 8}
    upright = gc.shape_contexts(points, gradients=gradients, **options)
    angle = 0.3
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    turned = gc.shape_contexts(
        (points @ turn.T).astype(np.float32), gradients=(gradients + angle).astype(np.float32), **options
    )
    # Rounding moves a few of the 22350 pairs over a border.
    assert np.abs(turned - upright).sum() < 40
    fixed_frame = gc.shape_contexts((points @ turn.T).astype(np.float32))
    assert np.abs(fixed_frame - gc.shape_contexts(points)).sum() > 1000


def test_the_outline_is_counted_a_second_time():
    points = spread_points(13, 60)
    distances = np.random.default_rng(13).uniform(0, 9, len(points)).astype(np.float32)
    counts = gc.shape_contexts(points, border_distances=distances, outline_px=3)
    assert counts.shape == (60, 80)
    np.testing.assert_array_equal(counts[:, :40], gc.shape_contexts(points))
    assert (counts[:, 40:] <= counts[:, :40]).all()
    every = gc.shape_contexts(points, border_distances=distances, outline_px=3, outer_radius=50.0)
    is_outline = distances <= 3
    np.testing.assert_array_equal(every[:, 40:].sum(axis=1), is_outline.sum() - is_outline)
    with pytest.raises(gc.InvalidInput, match="distances to the border"):
        gc.shape_contexts(points, outline_px=3)
    with pytest.raises(ValueError, match="border_distances: expected one for each of the 60 points"):
        gc.Contour(points, border_distances=distances[1:])


def test_counts_add_up():
    points = spread_points(11, 80)
    inside_all = gc.shape_contexts(points, outer_radius=50.0)
    np.testing.assert_array_equal(inside_all.sum(axis=1), 79)
    assert (gc.shape_contexts(points, outer_radius=1.0).sum(axis=1) < 79).all()


# ---- Patch descriptors -------------------------------------------------------------------------------------


def naive_patch_descriptors(points, size, windows=(1, 3, 7), patch_px=10, **options):
    """III-B: sums over the samples in three windows centred at each patch that holds one; L1; square root."""
    contexts = gc.shape_contexts(points, **options).astype(np.float64)
    cells = np.floor((points.astype(np.float64) + 0.5) / patch_px).astype(int)
    columns, rows = -(-size[0] // patch_px), -(-size[1] // patch_px)
    centres, features = [], []
    for row in range(rows):
        for column in range(columns):
            if not (cells == (column, row)).all(axis=1).any():
                continue
            centres.append(((column + 0.5) * patch_px - 0.5, (row + 0.5) * patch_px - 0.5))
            parts = []
            for window in windows:
                inside = (np.abs(cells - (column, row)) <= window // 2).all(axis=1)
                total = contexts[inside].sum(axis=0)
                parts.append(np.sqrt(total / total.sum()) if total.sum() else total)
            features.append(np.concatenate(parts))
    return np.array(centres), np.array(features)


@pytest.mark.parametrize(
    "options", [{}, {"angular_bins": 12}, {"windows_patches": (1, 5, 11)}, {"patch_px": 16}]
)
def test_patch_descriptors_equal_the_reference(options):
    size = (263, 257)
    points = spread_points(5, 200)
    patches = gc.patch_descriptors(gc.Contour(points), size, **options)
    windows = options.get("windows_patches", (1, 3, 7))
    naive = {name: value for name, value in options.items() if name != "windows_patches"}
    centres, features = naive_patch_descriptors(points, size, windows, **naive)
    np.testing.assert_allclose(patches.centres, centres)
    np.testing.assert_allclose(patches.features, features, atol=1e-6)
    np.testing.assert_allclose((patches.features.reshape(len(patches), 3, -1) ** 2).sum(axis=2), 1, atol=1e-5)


def test_patch_descriptors_with_the_outline_equal_the_reference():
    size, points = (263, 257), spread_points(5, 200)
    distances = np.random.default_rng(5).uniform(0, 9, len(points)).astype(np.float32)
    patches = gc.patch_descriptors(gc.Contour(points, border_distances=distances), size, outline_px=3)
    _, features = naive_patch_descriptors(points, size, border_distances=distances, outline_px=3)
    assert features.shape[1] == 240
    np.testing.assert_allclose(patches.features, features, atol=1e-6)


def test_descriptors_follow_the_fovea(pair, mask):
    """The same object, moved by whole pixels, is described the same."""
    left, _ = pair
    shifted = np.roll(left, (-13, 27), axis=(0, 1))
    shifted_mask = np.roll(mask, (-13, 27), axis=(0, 1))
    first = gc.describe_view(gc.foveal_view(left, mask))
    second = gc.describe_view(gc.foveal_view(shifted, shifted_mask))
    np.testing.assert_array_equal(first.cells, second.cells)
    np.testing.assert_array_equal(first.features, second.features)


def test_contours_keep_to_the_mask_and_are_even(pair, mask):
    contour = gc.sample_contour(pair[0], mask, samples=0)
    some = gc.sample_contour(pair[0], mask, samples=100)
    assert len(contour) > len(some) == 100
    every = {tuple(point) for point in contour.points}
    assert all(tuple(point) in every for point in some.points)
    columns, rows = contour.points.astype(int).T
    near = np.zeros(mask.shape, bool)
    for dv in range(-3, 4):
        for du in range(-3, 4):
            near |= np.roll(mask > 0, (dv, du), axis=(0, 1))
    assert near[rows, columns].all()
    assert (np.abs(contour.gradients) <= np.pi + 1e-6).all()
    outside = np.argwhere(np.pad(mask == 0, 1, constant_values=True))[:, ::-1] - 1
    nearest = [np.linalg.norm(outside - point, axis=1).min() for point in some.points]
    np.testing.assert_allclose(some.border_distances, nearest, atol=1e-3)
