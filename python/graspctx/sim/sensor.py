"""What the cameras do to the picture: exposure, blur, noise."""

from dataclasses import dataclass

import numpy as np
from PIL import Image


@dataclass(frozen=True)
class Sensor:
    """Both cameras' sensors.

    Attributes:
        brightness: mean grey level of the left view that the exposure aims at.
        exposure_ratio: of the right view to the left one.
        blur_px, noise: standard deviations, pixels and grey levels.
        vertical_offset_px: how much lower everything lies in the right view than in a rectified pair.
    """

    brightness: float
    exposure_ratio: float
    blur_px: float
    noise: float
    vertical_offset_px: float


def exposure_factor(colour: np.ndarray, brightness: float) -> float:
    """The factor that brings the mean to `brightness` as far as highlights do not burn out.

    Args:
        colour: (H, W, 3) uint8.
        brightness: grey level.
    """
    highlights = max(float(np.quantile(colour, 0.995)), 1.0)
    most = min(2.5, max(0.8, 245 / highlights))
    return float(np.clip(brightness / max(float(colour.mean()), 1.0), 0.2, most))


def photograph(
    light: np.ndarray, image_size: tuple[int, int], sensor: Sensor, exposure: float, rng
) -> np.ndarray:
    """Average over each pixel's area, expose, blur, add noise.

    Args:
        light: (h, w, 3) uint8, finer than the image.
        image_size: (width, height) px.
        exposure: factor on grey levels.
        rng: of the noise.

    Returns:
        (height, width, 3) uint8.
    """
    image = np.asarray(Image.fromarray(light).resize(image_size, Image.Resampling.BOX), np.float32)
    image *= np.float32(exposure)
    if sensor.blur_px > 0.1:
        for axis in (0, 1):
            image = _blur(image, sensor.blur_px, axis)
    noise = rng.standard_normal(image.shape, dtype=np.float32)
    noise *= np.float32(sensor.noise)
    noise += image
    noise += np.float32(0.5)
    return np.clip(noise, 0, 255, out=noise).astype(np.uint8)


def _blur(image, stddev_px, axis):
    """Gaussian blur along an axis; the image's edge repeats outside."""
    reach = max(1, int(np.ceil(2.5 * stddev_px)))
    weights = np.exp(-0.5 * (np.arange(reach + 1) / stddev_px) ** 2)
    weights = (weights / (2 * weights.sum() - 1)).astype(np.float32)
    image = np.moveaxis(image, axis, 0)
    padded = np.pad(image, ((reach, reach), (0, 0), (0, 0)), mode="edge")
    size = len(image)
    total = image * weights[0]
    for step in range(1, reach + 1):
        both = padded[reach - step : reach - step + size] + padded[reach + step : reach + step + size]
        both *= weights[step]
        total += both
    return np.moveaxis(total, 0, axis)
