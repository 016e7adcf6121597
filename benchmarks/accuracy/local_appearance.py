"""The baseline that Bohg and Kragic compare with: the local appearance of patches (III-B, IV; METHOD 5).

The descriptor of Saxena, Driemeyer, Kearns and Ng, "Robotic Grasping of Novel Objects" (NIPS 2006): 17
filters at three scales at a patch, and at the finest scale at the 24 neighbours in a window of 5 by 5
patches: 51 + 408 = 459 numbers. The filters are those of Saxena, Chung and Ng (NIPS 2005): Laws' nine masks
of 3 by 3 and the six oriented edge masks of 5 by 5 of Nevatia and Babu on the intensity, of whose responses
a patch has the energy, and local averages, by the first of Laws' masks, of the two chroma channels. Patches
are those of the shape contexts: same foveal view, same grid, same cells.

What the papers leave open is set so that the baseline is as good as it gets on scenes of the split
validation (README.md beside the benchmarks): the background of the segment is black, and of an energy the
logarithm is taken.
"""

from __future__ import annotations

import functools

import numpy as np

SCALES = (1, 3, 9)  # a filter's taps, and the width of its window in patches, grow with the scale
WINDOW = 5  # patches across, of the neighbours
ENERGIES = 15  # of the filters; the others are averages
FILTERS = 17
DIMENSION = FILTERS * (len(SCALES) + WINDOW**2 - 1)

_LAWS = np.float32([[1, 2, 1], [-1, 0, 1], [-1, 2, -1]])  # level, edge, spot
_EDGE_0 = [[-100] * 5, [-100] * 5, [0] * 5, [100] * 5, [100] * 5]
_EDGE_30 = [
    [-100, -100, -100, -100, -100],
    [-100, -100, -100, -78, 32],
    [-100, -92, 0, 92, 100],
    [-32, 78, 100, 100, 100],
    [100, 100, 100, 100, 100],
]


def laws_masks() -> np.ndarray:
    """Laws' masks: (9, 3, 3) float32, vertical by horizontal of level, edge and spot; the first averages."""
    return np.stack([np.outer(vertical, horizontal) for vertical in _LAWS for horizontal in _LAWS])


@functools.cache
def edge_masks() -> np.ndarray:
    """Nevatia and Babu's masks: (6, 5, 5) float32, edges every 30°, of weights that sum to 0."""
    at_0, at_30 = np.float32(_EDGE_0), np.float32(_EDGE_30)
    at_60 = at_30.T
    # Mirrored left to right, an edge at 60° is one at 120°, one at 30° is one at 150°.
    return np.stack([at_0, at_30, at_60, at_0.T, at_60[:, ::-1], at_30[:, ::-1]])


def intensity_and_chroma(image: np.ndarray) -> np.ndarray:
    """Y, Cb and Cr of JPEG's colour space: (3, H, W) float32, Y in 0 to 255, the others around 0.

    Args:
        image: uint8, RGB (H, W, 3) or grey (H, W), which has no chroma.
    """
    if image.ndim == 2:
        return np.stack([image.astype(np.float32), *np.zeros((2, *image.shape), np.float32)])
    to_ycc = np.float32([[0.299, 0.587, 0.114], [-0.1687, -0.3313, 0.5], [0.5, -0.4187, -0.0813]])
    return np.einsum("cd,hwd->chw", to_ycc, image.astype(np.float32))


def filter_spread(image: np.ndarray, mask: np.ndarray, spread: int) -> np.ndarray:
    """Correlate with a mask whose taps lie `spread` px apart; beyond the image its border goes on: (H, W)."""
    reach = mask.shape[0] // 2 * spread
    padded = np.pad(image, reach, mode="edge")
    height, width = image.shape
    result = np.zeros((height, width), np.float32)
    for row, column in np.argwhere(mask):
        top, left = row * spread, column * spread
        result += mask[row, column] * padded[top : top + height, left : left + width]
    return result


def box_average(image: np.ndarray, side: int) -> np.ndarray:
    """Mean over the square of `side` px, odd, around each pixel; beyond the image its border goes on."""
    if side == 1:
        return image
    padded = np.pad(image, side // 2, mode="edge")
    height, width = image.shape
    rows, columns = np.mgrid[:height, :width]
    sums = window_sums(padded, rows, rows + side, columns, columns + side)
    return (sums / side**2).astype(np.float32)


def window_sums(values: np.ndarray, top, bottom, left, right) -> np.ndarray:
    """Sums of (H, W) over windows of rows [top, bottom) and columns [left, right), by an integral image."""
    integral = np.zeros((values.shape[0] + 1, values.shape[1] + 1))
    integral[1:, 1:] = values.astype(np.float64).cumsum(0).cumsum(1)
    return integral[bottom, right] - integral[top, right] - integral[bottom, left] + integral[top, left]


def filter_responses(image: np.ndarray, scale: int) -> np.ndarray:
    """What is averaged over a patch at one scale: (17, H, W) float32.

    Squared responses of the 9 Laws and 6 edge masks on intensity, then the local averages of the 2 chroma
    channels.

    Args:
        image: as for intensity_and_chroma.
        scale: the masks see the image averaged over squares of `scale` px, with taps as far apart: a picture
            that is `scale` times smaller, at each of its offsets.
    """
    channels = [box_average(channel, scale) for channel in intensity_and_chroma(image)]
    laws, edges = laws_masks(), edge_masks()
    of_intensity = [filter_spread(channels[0], mask, scale) ** 2 for mask in (*laws, *edges)]
    of_chroma = [filter_spread(channel, laws[0], scale) for channel in channels[1:]]
    return np.stack([*of_intensity, *of_chroma])


def patch_means(responses: np.ndarray, cells: np.ndarray, patch_px: int, patches: int) -> np.ndarray:
    """Means over the square windows around patches, as far as they lie in the view: (K, F) float64.

    Args:
        responses: (F, H, W).
        cells: (K, 2) column and row of each patch; one outside the view counts as the nearest in it.
        patch_px: side of a patch.
        patches: side of the window in patches, odd.
    """
    height, width = responses.shape[1:]
    columns = np.clip(cells[:, 0], 0, (width - 1) // patch_px)
    rows = np.clip(cells[:, 1], 0, (height - 1) // patch_px)
    reach = patches // 2
    left, right = np.maximum(columns - reach, 0), columns + reach + 1
    top, bottom = np.maximum(rows - reach, 0), rows + reach + 1
    left, right = left * patch_px, np.minimum(right * patch_px, width)
    top, bottom = top * patch_px, np.minimum(bottom * patch_px, height)
    area = (bottom - top) * (right - left)
    return np.stack([window_sums(values, top, bottom, left, right) / area for values in responses], 1)


def neighbours() -> np.ndarray:
    """The 24 others of a window of 5 by 5: (24, 2) steps of column and row, row by row."""
    reach = WINDOW // 2
    steps = [(column, row) for row in range(-reach, reach + 1) for column in range(-reach, reach + 1)]
    return np.array([step for step in steps if step != (0, 0)])


def local_appearance(
    image: np.ndarray, mask: np.ndarray, cells: np.ndarray, patch_px: int = 10
) -> np.ndarray:
    """Saxena et al.'s descriptor of patches: (M, 459) float32.

    Columns: the 17 filters at the patch, at scale 1, 3 and 9; then the 17 at scale 1 at each of `neighbours`.
    Of the 17 the first 15 are ln(1 + mean energy).

    Args:
        image: a foveal view, uint8, RGB (H, W, 3) or grey (H, W).
        mask: (H, W), > 0 = object. The rest of the view is black.
        cells: (M, 2) integers, column and row of each patch in the view's grid: PatchDescriptors.cells.
        patch_px: side of a patch.
    """
    cells = np.asarray(cells).reshape(-1, 2)
    figure = image.copy()
    figure[mask == 0] = 0
    finest = filter_responses(figure, SCALES[0])
    parts = [patch_means(finest, cells, patch_px, SCALES[0])]
    parts += [patch_means(filter_responses(figure, scale), cells, patch_px, scale) for scale in SCALES[1:]]
    around = (cells[:, None] + neighbours()[None]).reshape(-1, 2)
    parts.append(patch_means(finest, around, patch_px, 1).reshape(len(cells), FILTERS * len(neighbours())))
    features = np.concatenate(parts, axis=1)
    is_energy = np.arange(DIMENSION) % FILTERS < ENERGIES
    features[:, is_energy] = np.log1p(np.maximum(features[:, is_energy], 0))  # sums may round below 0
    return features.astype(np.float32)
