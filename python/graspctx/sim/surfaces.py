"""Pictures of tables, floors and walls. All of them repeat without a seam in both directions."""

import numpy as np

from .textures import random_colour, smooth_noise, to_bytes

SURFACE_KINDS = ("textured", "faint", "uniform")


def surface_texture(texture_seed: int, kind: str, size_px: int = 1024) -> np.ndarray:
    """A table, floor or wall.

    Args:
        texture_seed: which one.
        kind: "textured"; "faint" (a few grey levels of contrast) or "uniform" (one colour).
        size_px: rows and columns.

    Returns:
        (size_px, size_px, 3) uint8 RGB, periodic.
    """
    if kind not in SURFACE_KINDS:
        raise ValueError(f"unknown surface '{kind}'; known: {', '.join(SURFACE_KINDS)}")
    rng = np.random.default_rng(texture_seed)
    base = random_colour(rng)
    # Tables are duller than what stands on them.
    base = np.clip(base.mean() + (base - base.mean()) * np.float32(rng.uniform(0.1, 0.8)), 0.15, 0.8)
    if kind == "uniform":
        return to_bytes(np.broadcast_to(base, (8, 8, 3)))
    other = np.clip(
        base * rng.uniform(0.3, 0.8) if base.mean() > 0.35 else base + rng.uniform(0.15, 0.5), 0, 1
    )
    if rng.random() < 0.25:
        other = random_colour(rng)
    scale = size_px / 1024
    fine = smooth_noise(rng, (size_px, size_px), rng.uniform(2, 8) * scale, power=2)
    style = rng.choice(list(_STYLES))
    if style == "wood" or (style == "planks" and rng.random() < 0.5):
        base = np.array([0.72, 0.5, 0.3]) * rng.uniform(0.5, 1.15) * rng.uniform(0.92, 1.08, 3)
        other = base * rng.uniform(0.45, 0.75)
    field = _STYLES[style](rng, fine, scale)
    fine *= np.float32(rng.uniform(0.02, 0.06))  # what stereo holds on to
    base, other = np.asarray(base, np.float32), np.asarray(other, np.float32)
    image = np.empty((size_px, size_px, 3), np.float32)
    for channel in range(3):
        np.multiply(field, other[channel] - base[channel], out=image[..., channel])
        image[..., channel] += fine
        image[..., channel] += base[channel]
    np.clip(image, 0, 1, out=image)
    if kind == "faint":
        sample = image[::4, ::4]
        mean = sample.mean(axis=(0, 1))
        shrink = rng.uniform(0.008, 0.025) / max(float(sample.std(axis=(0, 1)).mean()), 1e-3)
        image = mean + (image - mean) * np.float32(shrink)
    return to_bytes(image)


def _grid(size_px):
    """Rows as a column and columns as a row, from 0 to 1."""
    at = np.arange(size_px, dtype=np.float32) / size_px
    return at[:, None], at[None, :]


def _wood(rng, fine, scale):
    size = fine.shape
    rings = smooth_noise(rng, size, rng.uniform(60, 200) * scale, stretch=(1.0, rng.uniform(6, 14)), power=3)
    fibre = smooth_noise(rng, size, 3 * scale, stretch=(1.0, rng.uniform(20, 60)), power=2)
    field = np.float32(0.5) + np.float32(0.3) * np.sin(np.float32(rng.uniform(2, 7)) * rings)
    field += np.float32(0.2) * fibre
    return np.ascontiguousarray(field.T) if rng.random() < 0.5 else field


def _planks(rng, fine, scale):
    field = _wood(rng, fine, scale)
    y, _ = _grid(len(fine))
    y = np.ascontiguousarray(y[:, 0])
    count = int(rng.integers(6, 15))
    shade = rng.uniform(-0.4, 0.4, count).astype(np.float32)
    field = field + shade[np.floor(y * count).astype(int)][:, None]
    field[(y * count) % 1 < 0.03] = 1.2
    return field


def _stone(rng, fine, scale):
    clouds = smooth_noise(rng, fine.shape, rng.uniform(20, 90) * scale, power=2)
    return np.float32(0.5) + np.float32(0.2) * clouds + np.float32(0.25) * fine


def _cloth(rng, fine, scale):
    y, x = _grid(len(fine))
    a, b = rng.integers(10, 50, 2)
    warp = np.where((x * a) % 1 < 0.5, np.float32(0.5), np.float32(0))
    weft = np.where((y * b) % 1 < rng.uniform(0.3, 0.6), np.float32(0.5), np.float32(0))
    return np.float32(0.12) * fine + warp + weft


def _tiles(rng, fine, scale):
    y, x = _grid(len(fine))
    count = int(rng.integers(8, 24))
    shade = rng.uniform(0.0, 0.55, (count, count)).astype(np.float32)
    field = shade[np.floor(y * count).astype(int), np.floor(x * count).astype(int)]
    field[((x * count) % 1 < 0.05) | ((y * count) % 1 < 0.05)] = 1.0
    field += np.float32(0.08) * smooth_noise(rng, fine.shape, 30 * scale, power=2)
    field += np.float32(0.05) * fine
    return field


def _print(rng, fine, scale):
    """Blocks on top of each other, as on newspapers and leaflets."""
    field = np.float32(0.1) * fine
    count = int(rng.integers(400, 1500))
    size = rng.integers(4, np.where(rng.random(count) < 0.5, 14, 60)[:, None], (count, 2))
    start = rng.integers(0, len(fine), (count, 2))
    end = start + np.ceil(size * scale).astype(int)
    for (row, column), (last_row, last_column), shade in zip(start, end, rng.random(count)):
        field[row:last_row, column:last_column] = shade
    return field


def _carpet(rng, fine, scale):
    tufts = smooth_noise(rng, fine.shape, rng.uniform(2, 8) * scale, power=2.5)
    shades = smooth_noise(rng, fine.shape, 120 * scale, power=3)
    return np.float32(0.5) + np.float32(0.28) * tufts + np.float32(0.15) * shades


_STYLES = {
    "wood": _wood,
    "planks": _planks,
    "stone": _stone,
    "cloth": _cloth,
    "tiles": _tiles,
    "print": _print,
    "carpet": _carpet,
}
