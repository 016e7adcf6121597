"""Pictures on objects, and what all procedural textures are made of: noise and colours."""

import colorsys

import numpy as np

from .families import ObjectShape

OBJECT_TEXTURE_PX = 512
_FAINTEST_FREQUENCY = 0.004  # of the strongest; what is fainter is left out


def smooth_noise(rng, size_px, scale_px, *, stretch=(1.0, 1.0), power=2.0) -> np.ndarray:
    """Periodic random field of mean 0 and standard deviation 1.

    Args:
        size_px: (rows, columns).
        scale_px: features larger than this are damped.
        stretch: (rows, columns) how much longer the features are in each direction.
        power: how fast the spectrum falls; large is smooth.

    Returns:
        (rows, columns) float32.
    """
    rows, columns = size_px
    along_rows = (np.fft.fftfreq(rows) * stretch[0] * scale_px).astype(np.float32) ** 2
    along_columns = (np.fft.rfftfreq(columns) * stretch[1] * scale_px).astype(np.float32) ** 2
    damping = (1 + along_rows[:, None] + along_columns) ** np.float32(-power / 2)
    damping[0, 0] = 0
    # Many random frequencies sum up to a normal distribution, whatever each is drawn from.
    kept_rows = damping.max(axis=1) > _FAINTEST_FREQUENCY
    kept_columns = int(np.flatnonzero(damping.max(axis=0) > _FAINTEST_FREQUENCY)[-1]) + 1
    damping = damping[kept_rows, :kept_columns]
    parts = rng.random((*damping.shape, 2), dtype=np.float32)
    parts -= np.float32(0.5)
    spectrum = np.zeros((rows, columns // 2 + 1), np.complex64)
    spectrum[kept_rows, :kept_columns] = parts.view(np.complex64)[..., 0] * damping
    field = np.fft.irfft2(spectrum, (rows, columns))
    field /= np.float32(max(float(field[::2, ::2].std()), 1e-12))
    return field


def random_colour(rng) -> np.ndarray:
    """(3,) float32 RGB in [0, 1]: often white or dark, else any hue."""
    return _draw_colour(rng).astype(np.float32)


def _draw_colour(rng):
    draw = rng.random()
    if draw < 0.22:
        return np.clip(rng.uniform(0.78, 0.95) + rng.uniform(-0.05, 0.05, 3), 0, 1)
    if draw < 0.34:
        return np.clip(rng.uniform(0.08, 0.25) + rng.uniform(-0.04, 0.04, 3), 0, 1)
    return np.array(colorsys.hsv_to_rgb(rng.random(), rng.uniform(0.15, 0.9), rng.uniform(0.3, 0.95)))


def _mix(mask, first, second):
    first, second = np.asarray(first, np.float32), np.asarray(second, np.float32)
    return first + mask[..., None].astype(np.float32) * (second - first)


def _other_colour(rng, colour):
    while True:
        other = random_colour(rng)
        if np.abs(other - colour).sum() > 0.5:
            return other


def _stripes(rng, x, y):
    """Bands or stripes as a mask in [0, 1]; x and y run from 0 to 1 over the texture."""
    duty = rng.uniform(0.2, 0.7)
    kind = rng.choice(["bands", "stripes", "spiral", "checks"])
    if kind == "bands":
        centres = rng.uniform(0, 1, int(rng.integers(1, 5)))
        return (
            (np.abs(y[..., None] - centres) < rng.uniform(0.01, 0.07, len(centres)))
            .any(-1)
            .astype(np.float32)
        )
    around = int(rng.integers(3, 20))
    if kind == "stripes":
        return ((x * around) % 1 < duty).astype(np.float32)
    if kind == "spiral":
        return ((x * int(rng.integers(1, 6)) + y * rng.uniform(2, 10)) % 1 < duty).astype(np.float32)
    return (((x * around) % 1 < duty) ^ ((y * rng.uniform(4, 12)) % 1 < duty)).astype(np.float32)


def _dots(rng, x, y, aspect):
    """Dots on a staggered grid; aspect = along / around."""
    around = int(rng.integers(4, 16))
    rows = max(2, round(around * aspect))
    row = np.floor(y * rows)
    dx = ((x * around + 0.5 * (row % 2)) % 1) - 0.5
    dy = (y * rows) % 1 - 0.5
    return (np.hypot(dx, dy) < rng.uniform(0.15, 0.42)).astype(np.float32)


def _stickers(rng, image, x, y, aspect):
    """Ellipses, boxes and bars in any colour, here and there."""
    for _ in range(int(rng.integers(2, 14))):
        cx, cy = rng.random(2)
        dx = (x - cx + 0.5) % 1 - 0.5
        dy = (y - cy) * aspect
        turn = rng.uniform(0, np.pi)
        along = dx * np.cos(turn) + dy * np.sin(turn)
        across = dy * np.cos(turn) - dx * np.sin(turn)
        a, b = rng.uniform(0.01, 0.11, 2)
        if rng.random() < 0.5:
            inside = (along / a) ** 2 + (across / b) ** 2 < 1
        else:
            inside = (np.abs(along) < a) & (np.abs(across) < b)
        image[inside] = random_colour(rng)


def _pattern(rng, shape, x, y):
    """(rows, columns, 3) the outside of an object."""
    size = x.shape
    base = random_colour(rng)
    image = np.broadcast_to(base, (*size, 3)).copy()
    aspect = shape.unrolled_m[1] / shape.unrolled_m[0]
    if rng.random() > shape.plain_share:
        other = _other_colour(rng, base)
        kind = rng.choice(["stripes", "dots", "stickers", "marble", "speckle", "camouflage", "fade"])
        # Isotropic on the object although the texture is square.
        stretch = (1 / aspect, 1.0) if aspect > 1 else (1.0, aspect)
        if kind == "stripes":
            image = _mix(_stripes(rng, x, y), base, other)
        elif kind == "dots":
            image = _mix(_dots(rng, x, y, aspect), base, other)
        elif kind == "stickers":
            _stickers(rng, image, x, y, aspect)
        elif kind == "marble":
            field = smooth_noise(rng, size, rng.uniform(40, 250), stretch=stretch, power=3)
            image = _mix(0.5 + 0.5 * np.sin(rng.uniform(1, 4) * field), base, other)
        elif kind == "speckle":
            field = smooth_noise(rng, size, rng.uniform(3, 12), stretch=stretch, power=3)
            image = _mix((field > rng.uniform(1, 2)).astype(np.float32), base, other)
        elif kind == "camouflage":
            field = smooth_noise(rng, size, rng.uniform(30, 120), stretch=stretch, power=4)
            image = _mix((field > rng.uniform(-0.5, 0.8)).astype(np.float32), base, other)
            if rng.random() < 0.5:
                again = smooth_noise(rng, size, rng.uniform(30, 120), stretch=stretch, power=4)
                image[again > 0.7] = random_colour(rng)
        else:
            start = rng.uniform(0, 0.6)
            image = _mix(np.clip((y - start) / rng.uniform(0.05, 0.5), 0, 1), base, other)
    return image, base


def _inside_colour(rng, base):
    """Of a hollow: often as outside, or pale as glaze; else the outside's pattern goes on."""
    draw = rng.random()
    if draw < 0.4:
        return base
    if draw < 0.75:
        return rng.uniform(0.8, 0.95) + rng.uniform(-0.04, 0.04, 3)
    return random_colour(rng) if draw < 0.9 else None


def _metal_colour(rng, _base):
    """Steel or brass."""
    tone = (0.75, 0.70, 0.55) if rng.random() < 0.4 else (0.70, 0.71, 0.73)
    return np.array(tone) * rng.uniform(0.6, 1.2)


_PAINTS = {
    "inside": _inside_colour,
    "wood": lambda rng, _base: np.array([0.80, 0.62, 0.42]) * rng.uniform(0.55, 1.15),
    "lead": lambda rng, base: base if rng.random() < 0.4 else rng.uniform(0.1, 0.25),
    "metal": _metal_colour,
    "rubber": lambda rng, _base: np.array([0.85, 0.45, 0.45]) if rng.random() < 0.6 else random_colour(rng),
    "paper": lambda rng, _base: np.array([0.93, 0.91, 0.85]) * rng.uniform(0.75, 1.05),
    "cap": lambda rng, base: _other_colour(rng, base),
    "lid": lambda rng, base: random_colour(rng) if rng.random() < 0.25 else None,
    "base": _metal_colour,
    "top": _metal_colour,
}
"""Parts that are not simply a piece of the outside: the colour of each, or None to let the pattern run on.

Their order is that of the random draws.
"""


_TOOL_PAINTS = {
    "whole": lambda rng: _metal_colour(rng, None) if rng.random() < 0.6 else _wood_colour(rng),
    "handle": lambda rng: _wood_colour(rng) if rng.random() < 0.5 else random_colour(rng),
    "head": lambda rng: _metal_colour(rng, None) * rng.uniform(0.3, 1.0),
    "shaft": lambda rng: _metal_colour(rng, None),
    "grip": random_colour,
}
"""The parts of tools. Half of all tools have one pattern all over: materials do not tell the region."""


def _wood_colour(rng):
    return np.array([0.80, 0.62, 0.42]) * rng.uniform(0.55, 1.15)


def _printed_label(rng, shape, x, y):
    """(rows, columns, 3) a paper label: one colour with printed shapes on it."""
    image = np.broadcast_to(random_colour(rng), (*x.shape, 3)).copy()
    for _ in range(int(rng.integers(1, 4))):
        _stickers(rng, image, x, y, shape.unrolled_m[1] / shape.unrolled_m[0])
    return image


def object_texture(shape: ObjectShape, texture_seed: int) -> np.ndarray:
    """The texture of an object: one picture for its whole surface, so that no part is set apart by it.

    Returns:
        (512, 512, 3) uint8 RGB; row 0 is v = 0, column 0 is u = 0; periodic in u.
    """
    rng = np.random.default_rng(texture_seed)
    size = (OBJECT_TEXTURE_PX, OBJECT_TEXTURE_PX)
    y, x = np.meshgrid(*((np.arange(n, dtype=np.float32) + 0.5) / n for n in size), indexing="ij")
    image, base = _pattern(rng, shape, x, y)

    def paint(part, colour):
        low, high = shape.parts[part]
        image[(y >= low) & (y < high)] = colour

    for part, draw in _PAINTS.items():
        if part in shape.parts:
            colour = draw(rng, base)
            if colour is not None:
                paint(part, colour)
    tool_parts = [part for part in _TOOL_PAINTS if part in shape.parts]
    if tool_parts and rng.random() < 0.5:
        for part in tool_parts:
            paint(part, _TOOL_PAINTS[part](rng))
    if "label" in shape.parts and rng.random() < 0.7:
        low, high = shape.parts["label"]
        inside = (y >= low) & (y < high)
        image[inside] = _printed_label(rng, shape, x, y)[inside]
    grain = smooth_noise(rng, size, rng.uniform(1, 30), power=2) * np.float32(rng.uniform(0.002, 0.02))
    return to_bytes(image + grain[..., None])


def to_bytes(image: np.ndarray) -> np.ndarray:
    """RGB in [0, 1] to uint8."""
    return np.clip(np.asarray(image, np.float32) * np.float32(255) + np.float32(0.5), 0, 255).astype(np.uint8)
