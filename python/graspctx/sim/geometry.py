"""Outlines on the table, and points on surfaces."""

import numpy as np

from .mesh import Mesh


def outline(points_m: np.ndarray) -> np.ndarray:
    """(K, 2) corners of the convex hull of (N, 2) points, counter-clockwise."""
    from scipy.spatial import ConvexHull

    return points_m[ConvexHull(points_m).vertices]


def gap_m(first: np.ndarray, second: np.ndarray) -> float:
    """How far two convex outlines are apart, along the sides' normals; negative where they overlap."""
    widest = -np.inf
    for one, other in ((first, second), (second, first)):
        sides = np.roll(one, -1, axis=0) - one
        normals = np.stack([sides[:, 1], -sides[:, 0]], axis=1) / np.linalg.norm(sides, axis=1)[:, None]
        beyond = (other @ normals.T).min(axis=0) - (one * normals).sum(axis=1)
        widest = max(widest, float(beyond.max()))
    return widest


def surface_points(mesh: Mesh, count: int) -> np.ndarray:
    """(about count, 3) points spread evenly over a mesh, the same ones for the same mesh."""
    corners = mesh.vertices_m[mesh.faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    at = (np.arange(count) + 0.5) / count * area.sum()
    face = np.minimum(np.searchsorted(np.cumsum(area), at), len(area) - 1)
    # Steps of irrational length fill each face evenly (Roberts' R2 sequence).
    u, v = (np.outer(np.arange(1, count + 1), [0.7548776662466927, 0.5698402909980532]) % 1).T
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    a, b, c = corners[face].swapaxes(0, 1)
    return a + u[:, None] * (b - a) + v[:, None] * (c - a)
