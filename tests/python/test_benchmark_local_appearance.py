"""The baseline's descriptor, against a naive reference and where its values are known."""

import sys
from pathlib import Path

import graspctx as gc
import numpy as np
import pytest
import scenes

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks" / "accuracy"))
import local_appearance as baseline

ndimage = pytest.importorskip("scipy.ndimage")


def naive_filters(image, cell, scale, patches, patch_px=10):
    """The 17 numbers of one patch at one scale, pixel by pixel, with scipy's correlation."""
    red, green, blue = np.moveaxis(image.astype(float), 2, 0)
    luma = 0.299 * red + 0.587 * green + 0.114 * blue
    blue_difference = -0.1687 * red - 0.3313 * green + 0.5 * blue
    red_difference = 0.5 * red - 0.4187 * green - 0.0813 * blue
    reach, (column, row) = patches // 2, cell
    height, width = luma.shape
    rows = [v for v in range((row - reach) * patch_px, (row + reach + 1) * patch_px) if 0 <= v < height]
    columns = [
        u for u in range((column - reach) * patch_px, (column + reach + 1) * patch_px) if 0 <= u < width
    ]

    def mean(channel, mask, energy):
        smooth = ndimage.uniform_filter(channel, scale, mode="nearest")
        spread = np.zeros([(side - 1) * scale + 1 for side in mask.shape])
        spread[::scale, ::scale] = mask
        response = ndimage.correlate(smooth, spread, mode="nearest")
        response = response**2 if energy else response
        value = np.mean([response[v, u] for v in rows for u in columns])
        return np.log(1 + value) if energy else value

    one_dimensional = ([1, 2, 1], [-1, 0, 1], [-1, 2, -1])
    laws = [np.outer(a, b) for a in one_dimensional for b in one_dimensional]
    of_intensity = [mean(luma, mask, True) for mask in (*laws, *baseline.edge_masks())]
    return of_intensity + [mean(channel, laws[0], False) for channel in (blue_difference, red_difference)]


@pytest.fixture(scope="module")
def image():
    return np.random.default_rng(3).integers(0, 256, (97, 123, 3)).astype(np.uint8)


def everything(image):
    """A mask of the whole view."""
    return np.full(image.shape[:2], 255, np.uint8)


@pytest.mark.parametrize("cell", [(5, 4), (2, 3), (0, 0), (12, 9)])
def test_a_patch_is_described_as_by_a_naive_reference(image, cell):
    (found,) = baseline.local_appearance(image, everything(image), np.array([cell]))
    expected = [naive_filters(image, cell, scale, scale) for scale in (1, 3, 9)]
    for row in range(-2, 3):
        for column in range(-2, 3):
            if (row, column) != (0, 0):
                at = min(max(cell[0] + column, 0), 12), min(max(cell[1] + row, 0), 9)
                expected.append(naive_filters(image, at, 1, 1))
    assert found.shape == (459,) and found.dtype == np.float32
    np.testing.assert_allclose(found, np.concatenate(expected), rtol=2e-4, atol=2e-3)


def test_a_constant_image_has_an_average_and_nothing_else():
    colour = np.array([200, 100, 50])
    image = np.broadcast_to(colour, (80, 90, 3)).astype(np.uint8)
    (found,) = baseline.local_appearance(image, everything(image), np.array([[4, 4]]))
    luma = colour @ [0.299, 0.587, 0.114]
    chroma = colour @ np.array([[-0.1687, -0.3313, 0.5], [0.5, -0.4187, -0.0813]]).T
    once = np.concatenate(
        [[np.log(1 + (16 * luma) ** 2)], np.zeros(14), 16 * chroma]
    )  # Laws' average has weights of 16
    np.testing.assert_allclose(found.reshape(27, 17), np.tile(once, (27, 1)), atol=0.05)


def test_a_shift_by_one_patch_shifts_the_descriptors_by_one_cell(image):
    wide = np.pad(image, ((0, 0), (200, 200), (0, 0)), mode="wrap")
    cells = np.array([[24, 4], [25, 5], [26, 3]])
    before = baseline.local_appearance(wide, everything(wide), cells)
    after = baseline.local_appearance(np.roll(wide, 10, axis=1), everything(wide), cells + np.array([1, 0]))
    np.testing.assert_allclose(after, before, rtol=1e-4, atol=1e-2)
    assert np.abs(before[0] - before[1]).max() > 1


def test_a_larger_scale_looks_farther(image):
    other = image.copy()
    other[:, 90:] = 0  # beyond what scale 3 sees from column 4, not scale 9
    before, after = (
        baseline.local_appearance(view, everything(view), np.array([[4, 4]]))[0] for view in (image, other)
    )
    same = np.isclose(before, after, atol=1e-3)
    assert same[:34].all() and same[51:].all() and not same[34:51].all()


def test_edge_masks_answer_to_their_own_direction_most():
    masks = baseline.edge_masks()
    np.testing.assert_allclose(masks.sum((1, 2)), 0)
    v, u = np.mgrid[-30:31, -30:31]
    for number in range(6):
        angle = np.deg2rad(30 * number)  # of the edge, from +u, v upwards
        step = np.clip(0.5 - np.sin(angle) * u - np.cos(angle) * v, 0, 1).astype(np.float32)
        responses = [abs(baseline.filter_spread(step, mask, 1)[30, 30]) for mask in masks]
        assert np.argmax(responses) == number


def test_the_background_is_not_seen(image):
    mask = np.zeros(image.shape[:2], np.uint8)
    mask[20:70, 20:70] = 255
    other = np.where(mask[..., None] > 0, image, 99).astype(np.uint8)
    before, after = (baseline.local_appearance(view, mask, np.array([[4, 4]])) for view in (image, other))
    np.testing.assert_array_equal(before, after)
    assert np.abs(before - baseline.local_appearance(image, everything(image), np.array([[4, 4]]))).max() > 1


def test_grey_views_have_no_chroma():
    grey = np.random.default_rng(1).integers(0, 256, (60, 60)).astype(np.uint8)
    found = baseline.local_appearance(grey, everything(grey), np.array([[2, 2]])).reshape(27, 17)
    assert (found[:, 15:] == 0).all() and (found[:, 0] > 0).all()


def test_the_patches_are_those_of_the_shape_contexts():
    left, _, mask = scenes.disc_scene()
    view = gc.foveal_view(left, mask)
    patches = gc.describe_view(view)
    found = baseline.local_appearance(view.image, view.mask, patches.cells)
    assert found.shape == (len(patches), baseline.DIMENSION) and np.isfinite(found).all()
    assert baseline.local_appearance(view.image, view.mask, patches.cells[:0]).shape == (0, 459)
