"""Handles in the plane y = 0: a rounded band swept along a curve, its ends inside the body's wall."""

import numpy as np

from .profile import along


def swept_band(curve_m: np.ndarray, across_m: np.ndarray, through_m: np.ndarray) -> np.ndarray:
    """(R, S, 3) rings around a curve in the plane y = 0, square to it.

    Args:
        curve_m: (R, 2) x and z.
        across_m, through_m: (R, S) or (S,) each ring's points along y and to the curve's right, seen from -y;
            they turn from the right to +y.
    """
    tangent = np.gradient(curve_m, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    return _rings(curve_m, tangent, across_m, through_m)


def _rings(curve_m, tangent, across_m, through_m):
    through_m = np.broadcast_to(through_m, (len(curve_m), np.shape(through_m)[-1]))
    return np.stack(
        [
            curve_m[:, :1] + tangent[:, 1:] * through_m,
            np.broadcast_to(across_m, through_m.shape),
            curve_m[:, 1:] - tangent[:, :1] * through_m,
        ],
        axis=-1,
    )


def band_section(width_m: float, thickness_m: float, roundness: float, sides: int = 20):
    """(across, through) (sides,) each: a superellipse; roundness 2 is an ellipse, more is squarer."""
    angle = 2 * np.pi * np.arange(sides) / sides
    power = 2 / roundness
    across = width_m / 2 * np.sign(np.sin(angle)) * np.abs(np.sin(angle)) ** power
    through = thickness_m / 2 * np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** power
    return across, through


def even_curve(curve: np.ndarray, points: int) -> np.ndarray:
    """(points, 2) the same curve in even steps."""
    walked = along(curve)
    even = np.linspace(0, walked[-1], points)
    return np.stack([np.interp(even, walked, curve[:, k]) for k in range(2)], axis=1)


def side_handle(
    rng, outer_radius_m, seat_m: float, limits_m, *, reach_m: float, width_m: float, thickness_m: float
) -> tuple[np.ndarray, dict[str, float]]:
    """A handle at the side, along +x.

    Args:
        outer_radius_m: the wall's outer radius as a function of the height.
        seat_m: how deep under the wall's surface the ends stop.
        limits_m: (lowest, highest) place on the wall.
        reach_m: how far its middle line stands off the wall.

    Returns:
        (R, S, 3) rings from the upper to the lower end, and its sizes by name.
    """
    low_limit, high_limit = limits_m[0] + thickness_m / 2, limits_m[1] - thickness_m / 2
    span = rng.uniform(0.55, 0.92) * (high_limit - low_limit)
    low = low_limit + rng.uniform(0.15, 0.85) * (high_limit - low_limit - span)
    high = low + span
    power = 2 / rng.uniform(1.7, 3.2)
    skew = rng.uniform(-0.15, 0.45)

    turn = np.linspace(0, np.pi, 400)
    z = (low + high) / 2 + span / 2 * np.sign(np.cos(turn)) * np.abs(np.cos(turn)) ** power
    out = reach_m * np.sin(turn) ** power * (1 + skew * np.cos(turn)) / (1 + abs(skew))
    ends = outer_radius_m(np.array([low, high]))
    curve = even_curve(np.stack([np.interp(z, [low, high], ends) + out, z], axis=1), 56)
    for _ in range(6):  # rounds the corners of square handles so that the band does not fold
        curve[1:-1] = 0.25 * curve[:-2] + 0.5 * curve[1:-1] + 0.25 * curve[2:]

    tangent = np.gradient(curve, axis=0)
    tangent[0], tangent[-1] = (1, 0), (-1, 0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    across, through = band_section(width_m, thickness_m, rng.uniform(2.0, 3.5))
    walked = along(curve)
    from_wall = np.minimum(walked, walked[-1] - walked)
    widen = 1 + rng.uniform(0, 0.35) * np.exp(-from_wall / 0.006)
    rings = _rings(curve, tangent, across * widen[:, None], through)
    for end in (0, -1):
        y, z = rings[end, :, 1], rings[end, :, 2]
        rings[end, :, 0] = np.sqrt((outer_radius_m(z) - seat_m) ** 2 - y**2)
    sizes = {
        "handle_reach": reach_m,
        "handle_low": low,
        "handle_high": high,
        "handle_width": width_m,
        "handle_thickness": thickness_m,
    }
    return rings, sizes
