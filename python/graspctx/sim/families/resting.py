"""How an object of any shape comes to rest: the faces of its convex hull that it does not tip over from."""

from __future__ import annotations

import numpy as np

from .shape import RestingPose

SAME_POSE_RAD = np.radians(5)
"""Faces of the hull closer than this are one pose: a smooth cylinder does not lie in a hundred ways."""
LEAST_SHARE = 0.003
"""Poses that an object dropped at random ends in less often are left out."""


def resting_poses(
    vertices_m: np.ndarray, centre_of_mass_m: np.ndarray, up=(0.0, 0.0, 1.0)
) -> tuple[RestingPose, ...]:
    """The ways an object rests on a table by its own weight.

    The object falls without speed on the face of its convex hull that is under its middle, and tips over
    edges until the centre of mass is over the face; a pose's weight is the share of the orientations that end
    in it. Its name says where the upside goes: "standing" (up, within 15 degrees), "upside_down" or "lying".

    Args:
        vertices_m: (V, 3) object frame.
        centre_of_mass_m: (3,) inside the hull.
        up: (3,) direction that points up when the object stands.

    Returns:
        Poses, the most frequent first; weights sum to 1.

    Raises:
        ValueError: the vertices lie in a plane.
    """
    from scipy.spatial import ConvexHull, QhullError

    points = np.asarray(vertices_m, float) - centre_of_mass_m
    try:
        hull = ConvexHull(points)
    except QhullError as error:
        raise ValueError("the vertices lie in a plane; expected a body") from error
    normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
    # Coplanar triangles are one face. Their order is Qhull's: number the faces by first occurrence.
    _, first, face_of = np.unique(np.round(hull.equations, 6), axis=0, return_index=True, return_inverse=True)
    face_of = face_of.reshape(-1)
    share = np.zeros(len(first))
    np.add.at(share, face_of, _solid_angles(points[hull.simplices]))
    normals, offsets = normals[first], offsets[first]
    # A face whose plane is nearer to the centre of mass is lower energy: tipping only ever goes down.
    next_face = _tips_over_to(points, hull, face_of, normals, offsets)
    for face in np.argsort(offsets):  # offset = -distance: the farthest first
        if next_face[face] != face:
            share[next_face[face]] += share[face]
            share[face] = 0
    return _poses(normals, share / share.sum(), np.asarray(up, float))


def _solid_angles(triangles):
    """(T,) solid angles of (T, 3, 3) triangles seen from the origin (Van Oosterom and Strackee)."""
    a, b, c = triangles.swapaxes(0, 1)
    la, lb, lc = (np.linalg.norm(p, axis=1) for p in (a, b, c))
    volume = np.abs((a * np.cross(b, c)).sum(1))
    below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return 2 * np.abs(np.arctan2(volume, below))


def _tips_over_to(points, hull, face_of, normals, offsets):
    """For each face the neighbour it tips over to, or itself if the centre of mass is over it."""
    face = np.repeat(face_of, 3)
    other = face_of[hull.neighbors].reshape(-1)  # a neighbour is across the edge that its corner is not on
    corner = points[hull.simplices].reshape(-1, 3)
    a, b = (points[hull.simplices[:, ends]].reshape(-1, 3) for ends in ([1, 0, 0], [2, 2, 1]))
    outward = np.cross(b - a, normals[face])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    outward *= np.where(((corner - a) * outward).sum(1) > 0, -1.0, 1.0)[:, None]
    foot = -offsets[face, None] * normals[face]
    beyond = ((foot - a) * outward).sum(1)
    falls = (other != face) & (beyond > 0) & (offsets[other] > offsets[face])
    farthest = np.zeros(len(normals))
    np.maximum.at(farthest, face[falls], beyond[falls])
    chosen = np.flatnonzero(falls & (beyond == farthest[face]))[::-1]  # the first of equals comes last
    target = np.arange(len(normals))
    target[face[chosen]] = other[chosen]
    return target


def _poses(normals, share, up):
    """Join faces that are nearly one direction, name them, and turn each downwards."""
    directions, weights = np.empty((0, 3)), np.empty(0)  # of the most frequent face of each group
    for face in np.argsort(-share, kind="stable"):
        if share[face] <= 0:
            break
        near = np.flatnonzero(directions @ normals[face] > np.cos(SAME_POSE_RAD))
        if len(near):
            weights[near[0]] += share[face]
        else:
            directions = np.vstack([directions, normals[face]])
            weights = np.append(weights, share[face])
    # A ball lies in hundreds of ways, each of them seldom.
    kept = weights >= min(LEAST_SHARE, 0.1 * weights.max())
    directions, weights = directions[kept], weights[kept] / weights[kept].sum()
    poses = []
    for place in np.argsort(-weights, kind="stable"):
        down = directions[place]
        rise = -down @ up / np.linalg.norm(up)
        name = "standing" if rise > np.cos(np.radians(15)) else "lying"
        name = "upside_down" if rise < -np.cos(np.radians(15)) else name
        poses.append(RestingPose(name, float(weights[place]), rotation_downwards(down)))
    return tuple(poses)


def rotation_downwards(direction: np.ndarray) -> np.ndarray:
    """(3, 3) rotation that takes a direction (3,) to -z, by the shortest way."""
    down = np.asarray(direction, float) / np.linalg.norm(direction)
    cosine = -down[2]
    if cosine < -1 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    axis = np.cross(down, [0.0, 0.0, -1.0])
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + cross + cross @ cross / (1 + cosine)
