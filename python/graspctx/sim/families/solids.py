"""Convex pieces that fill a body and leave its hollows free: physics collides the hulls of meshes only."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Sequence

import numpy as np


class Solids(Sequence):
    """Convex pieces that are cut when they are first asked for: physics needs them, pictures do not."""

    def __init__(self, cut: Callable[[], Iterable[np.ndarray]]):
        self._cut = cut

    @functools.cached_property
    def _pieces(self) -> tuple[np.ndarray, ...]:
        return tuple(self._cut())

    def __getitem__(self, index):
        return self._pieces[index]

    def __len__(self) -> int:
        return len(self._pieces)

    def __add__(self, others: Sequence[np.ndarray]) -> Solids:
        return Solids(lambda: (*self, *others))

    def __reduce__(self):
        return tuple, (self._pieces,)


def lathe_solids(
    radius_m, height_m, *, sides: int, turn_rad: float = 0.0, tolerance_m: float = 0.0004
) -> Solids:
    """Cut a turned body into convex pieces: bands of its height, where it is hollow also sectors around.

    Args:
        radius_m, height_m, sides, turn_rad: as `mesh.lathe` takes them; a straight line closes the profile.
        tolerance_m: how far a piece may reach over the surface, into a hollow or a waist.

    Returns:
        (V, 3) vertices of each piece, metres.
    """
    return Solids(lambda: _cut_lathe(radius_m, height_m, sides, turn_rad, tolerance_m))


def _cut_lathe(radius_m, height_m, sides, turn_rad, tolerance_m):
    profile = np.stack([np.asarray(radius_m, float), np.asarray(height_m, float)], axis=1)
    pieces = []
    for inner, outer in _chains(profile):
        for inner_line, outer_line in _convex_bands(inner, outer, tolerance_m):
            pieces += _turned_pieces(inner_line, outer_line, sides, turn_rad, tolerance_m)
    return tuple(pieces)


def tube_solids(rings_m: np.ndarray, *, tolerance_m: float = 0.0005) -> tuple[np.ndarray, ...]:
    """Cut a tube of convex rings into convex pieces, as few as its bends allow.

    Args:
        rings_m: (R, S, 3) as `mesh.tube` takes them.
        tolerance_m: how far the lines from ring to ring may bend within a piece.

    Returns:
        (V, 3) vertices of each piece, metres.
    """
    pieces, first = [], 0
    while first < len(rings_m) - 1:
        last = first + 1
        while last + 1 < len(rings_m) and _bend_m(rings_m[first : last + 2]) <= tolerance_m:
            last += 1
        pieces.append(np.unique(rings_m[first : last + 1].reshape(-1, 3), axis=0))
        first = last
    return tuple(pieces)


def _bend_m(rings_m):
    """Largest distance of the rings' points from the straight lines between the first and the last ring."""
    chord = rings_m[-1] - rings_m[0]
    chord /= np.maximum(np.linalg.norm(chord, axis=-1, keepdims=True), 1e-12)
    off = rings_m[1:-1] - rings_m[0]
    return np.linalg.norm(off - (off * chord).sum(-1, keepdims=True) * chord, axis=-1).max()


def _slabs(profile):
    """The section between each two heights of the profile's points: a list of trapezoids for each slab.

    A trapezoid is (2, 2, 2): bottom and top, inner and outer side, (radius, height).
    """
    start, end = profile, np.roll(profile, -1, axis=0)
    low, high = np.minimum(start[:, 1], end[:, 1]), np.maximum(start[:, 1], end[:, 1])
    levels = np.unique(np.round(profile[:, 1], 9))
    for bottom, top in zip(levels[:-1], levels[1:]):
        middle = (bottom + top) / 2
        crossing = (low < middle) & (high > middle)
        first, second = start[crossing], end[crossing]
        slope = (second[:, 0] - first[:, 0]) / (second[:, 1] - first[:, 1])
        radii = np.stack([first[:, 0] + slope * (z - first[:, 1]) for z in (bottom, top)])
        radii = np.maximum(radii[:, np.argsort(radii.sum(axis=0), kind="stable")], 0)
        heights = np.broadcast_to([[bottom], [top]], (2, 2))
        yield [np.stack([radii[:, k : k + 2], heights], axis=-1) for k in range(0, radii.shape[1], 2)]


def _is_hollow(trapezoid):
    return trapezoid[:, 0, 0].max() > 1e-9


def _chains(profile):
    """Trapezoids that continue each other: (N, 2, 2) inner and outer lines, (slab, end, (r, z))."""
    open_chains, done = [], []
    for trapezoids in _slabs(profile):
        continued = []
        overlaps = np.array(
            [
                [
                    min(chain[-1][1, 1, 0], new[0, 1, 0]) - max(chain[-1][1, 0, 0], new[0, 0, 0]) > 1e-9
                    for new in trapezoids
                ]
                for chain in open_chains
            ]
        ).reshape(len(open_chains), len(trapezoids))
        for column, new in enumerate(trapezoids):
            before = np.flatnonzero(overlaps[:, column])
            follows = (
                len(before) == 1
                and overlaps[before[0]].sum() == 1
                and _is_hollow(open_chains[before[0]][-1]) == _is_hollow(new)
            )
            continued.append([*open_chains[before[0]], new] if follows else [new])
        kept = {id(chain[-2]) for chain in continued if len(chain) > 1}
        done += [chain for chain in open_chains if id(chain[-1]) not in kept]
        open_chains = continued
    for chain in done + open_chains:
        stacked = np.stack(chain)
        yield stacked[:, :, 0], stacked[:, :, 1]


def _convex_bands(inner, outer, tolerance_m):
    """Split a chain of slabs until each band's section is convex, to the tolerance; yields its two lines."""
    inner_line, outer_line = inner.reshape(-1, 2), outer.reshape(-1, 2)
    hull = _hull_2d(np.concatenate([inner_line, outer_line]))
    off = np.maximum(_behind_hull(inner_line, hull, -1), _behind_hull(outer_line, hull, 1))
    if len(inner) == 1 or off.max() <= tolerance_m:
        if outer[-1, 1, 1] - outer[0, 0, 1] > 1e-5:  # thinner ones are noise, and no hull for physics
            yield inner_line, outer_line
        return
    # Each inner level stands in the lines twice: as the top of one slab, as the bottom of the next.
    at_level = np.maximum(off[1:-1:2], off[2:-1:2])
    cut = int(np.argmax(at_level)) + 1
    for part in (slice(0, cut), slice(cut, None)):
        yield from _convex_bands(inner[part], outer[part], tolerance_m)


def _hull_2d(points):
    """(H, 2) corners of the convex hull, counter-clockwise."""
    points = np.unique(points, axis=0)

    def half(ordered):
        line = []
        for point in ordered:
            while len(line) > 1:
                a, b = line[-1] - line[-2], point - line[-1]
                if a[0] * b[1] - a[1] * b[0] > 1e-15:
                    break
                line.pop()
            line.append(point)
        return line[:-1]

    return np.array(half(points) + half(points[::-1]))


def _behind_hull(points, hull, side):
    """(N,) how far points inside a hull lie behind its border on the outer (1) or inner (-1) side."""
    edge = np.roll(hull, -1, axis=0) - hull
    facing = side * edge[:, 1] > 1e-12  # the ends of a band are cuts, no surface
    edge, corner = edge[facing], hull[facing]
    edge /= np.linalg.norm(edge, axis=1, keepdims=True)
    off = points[:, None] - corner
    return (edge[:, 0] * off[..., 1] - edge[:, 1] * off[..., 0]).min(axis=1)


def _turned_pieces(inner_line, outer_line, sides, turn_rad, tolerance_m):
    """The band, turned: one piece if it reaches the axis, else sectors."""
    if inner_line[:, 0].max() <= 1e-9:
        hull = _hull_2d(np.concatenate([inner_line, outer_line]))
        return [_revolved(hull, turn_rad + 2 * np.pi * np.arange(sides) / sides)]
    corners = _hull_2d(np.concatenate([inner_line, outer_line]))
    outside = (np.abs(corners[:, None] - outer_line).max(axis=-1) < 1e-12).any(axis=1)
    inner_corners, outer_corners = corners[~outside], corners[outside]
    # A sector's inner side is flat and cuts into the hollow in its middle; its ends take back half of that.
    per_sector = next(
        m
        for m in range(max(1, sides // 6), 0, -1)
        if sides % m == 0
        and (m == 1 or inner_line[:, 0].max() * (1 - np.cos(np.pi * m / sides)) <= 2 * tolerance_m)
    )
    cut = 1 - np.cos(np.pi * per_sector / sides)
    thickness = (outer_line - inner_line)[:, 0].max()
    inner_corners = inner_corners + [1, 0] * np.minimum(inner_corners[:, :1] * cut / 2, 0.3 * thickness)
    pieces = []
    for first in range(0, sides, per_sector):
        angles = turn_rad + 2 * np.pi * np.arange(first, first + per_sector + 1) / sides
        parts = [_revolved(outer_corners, angles), _revolved(inner_corners, angles[[0, -1]])]
        pieces.append(np.unique(np.concatenate(parts), axis=0))
    return pieces


def _revolved(section, angles_rad):
    """(V, 3) the points of a section at each of the angles; those on the axis once."""
    ring = np.stack([np.cos(angles_rad), np.sin(angles_rad)], axis=-1)
    off_axis = section[section[:, 0] > 1e-9]
    points = np.concatenate(
        [
            off_axis[:, None, :1] * ring,
            np.broadcast_to(off_axis[:, None, 1:], (len(off_axis), len(ring), 1)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    on_axis = section[section[:, 0] <= 1e-9, 1]
    tips = np.stack([0 * on_axis, 0 * on_axis, on_axis], axis=-1)
    return np.concatenate([points, tips])
