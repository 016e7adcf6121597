"""Cut a triangle mesh along boxes, so that what lies inside ends exactly at their sides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Box:
    """A box, turned about its own middle. One unit throughout, that of the vertices it is used with.

    Attributes:
        low, high: opposite corners (x, y, z) before the turn.
        turn_deg: turns about x, then y, then z (axes that stay where they are).
        outward: take only surface that faces away from the box's middle: of a hollow body the outside.
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    turn_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    outward: bool = False

    @property
    def middle(self) -> np.ndarray:
        """(3,)."""
        return (np.array(self.low) + self.high) / 2

    def planes(self) -> tuple[np.ndarray, np.ndarray]:
        """(6, 3) normals pointing inwards and (6,) offsets: normal · p >= offset inside the box."""
        turn = np.eye(3)
        for axis, angle in enumerate(np.radians(self.turn_deg)):
            step = np.eye(3)
            i, j = (axis + 1) % 3, (axis + 2) % 3
            step[i, i] = step[j, j] = np.cos(angle)
            step[i, j], step[j, i] = -np.sin(angle), np.sin(angle)
            turn = step @ turn
        half = (np.array(self.high) - self.low) / 2
        normals = np.concatenate([turn.T, -turn.T])
        return normals, normals @ self.middle - np.concatenate([half, half])


def cut_by_boxes(vertices: np.ndarray, faces: np.ndarray, boxes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Split the faces that cross a box's border, and say which lie inside any box.

    The surface stays the same and as closed as it was: faces that share an edge share its new vertices.

    Args:
        vertices: (V, 3).
        faces: (F, 3) vertex indices.
        boxes: Box objects in the vertices' unit.

    Returns:
        (vertices (V', 3), faces (F', 3), inside (F',) bool); the first V vertices are those given.
    """
    vertices, faces = np.asarray(vertices, float), np.asarray(faces, np.int64)
    inside = np.zeros(len(faces), bool)
    for box in boxes:
        within = np.ones(len(faces), bool)  # not yet found to be outside this box
        for normal, offset in zip(*box.planes()):
            vertices, faces, parent, above = _split(vertices, faces, within, normal, offset)
            inside = inside[parent]
            within = within[parent] & above
        inside |= within & (_facing_away(vertices, faces, box.middle) if box.outward else True)
    return vertices, faces, inside


def _facing_away(vertices, faces, point):
    """(F,) bool whether each face's outside looks away from a point."""
    a, b, c = vertices[faces].swapaxes(0, 1)
    return ((a + b + c - 3 * point) * np.cross(b - a, c - a)).sum(axis=1) > 0


def _split(vertices, faces, chosen, normal, offset):
    """Split the chosen faces along a plane.

    Returns:
        (vertices, faces, parent, above): `parent` is the index of the face that each face was a part of;
        `above` says that it lies on the side the normal points to. Faces in the plane itself count as above.
    """
    height = vertices @ normal - offset
    # Vertices this close to the plane count as in it, for all their faces alike: no slivers.
    height[np.abs(height) < 1e-7 * np.ptp(vertices, axis=0).max()] = 0
    side = np.sign(height)[faces]
    crossing = chosen & (side.max(axis=1) > 0) & (side.min(axis=1) < 0)
    through_corner = crossing & (side == 0).any(axis=1)
    through_edges = crossing & ~through_corner

    first = np.argmax(side == 0, axis=1)[through_corner]
    at, b, c = _starting_at(faces[through_corner], first)
    # The corner that is alone on its side has the sign that the other two together outvote.
    lone = np.argmax(side == -np.sign(side.sum(axis=1, keepdims=True)), axis=1)[through_edges]
    tip, left, right = _starting_at(faces[through_edges], lone)

    ends = np.sort(np.concatenate([np.stack(e, 1) for e in ((b, c), (tip, left), (tip, right))]), axis=1)
    edges, edge_of = np.unique(ends, axis=0, return_inverse=True)
    low, high = edges.T
    share = height[low] / np.where(height[low] == height[high], 1, height[low] - height[high])
    middles = len(vertices) + np.arange(len(edges))
    vertices = np.concatenate([vertices, vertices[low] + share[:, None] * (vertices[high] - vertices[low])])
    height = np.concatenate([height, np.zeros(len(edges))])
    on_bc, on_left, on_right = np.split(
        middles[edge_of.reshape(-1)], np.cumsum([through_corner.sum(), through_edges.sum()])
    )
    pieces = [
        (faces[~crossing], np.flatnonzero(~crossing)),
        (np.stack([at, b, on_bc], 1), np.flatnonzero(through_corner)),
        (np.stack([at, on_bc, c], 1), np.flatnonzero(through_corner)),
        (np.stack([tip, on_left, on_right], 1), np.flatnonzero(through_edges)),
        (np.stack([on_left, left, right], 1), np.flatnonzero(through_edges)),
        (np.stack([on_left, right, on_right], 1), np.flatnonzero(through_edges)),
    ]
    faces = np.concatenate([piece for piece, _ in pieces])
    parent = np.concatenate([parent for _, parent in pieces])
    faces, parent = _split_neighbours(faces, parent, edges, middles)
    return vertices, faces, parent, (height[faces] >= 0).all(axis=1)


def _split_neighbours(faces, parent, edges, middles):
    """Split the neighbours of chosen faces where these were split: no gap opens between them."""
    if not len(edges):
        return faces, parent
    count = max(int(faces.max()), int(edges.max())) + 1
    keys = edges[:, 0] * count + edges[:, 1]  # sorted, as the edges are
    while True:
        ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1), axis=-1)
        wanted = ends[..., 0] * count + ends[..., 1]
        found = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        split = keys[found] == wanted
        rows = np.flatnonzero(split.any(axis=1))
        if not len(rows):
            return faces, parent
        corner = split[rows].argmax(axis=1)
        middle = middles[found[rows, corner]]
        a, b, c = _starting_at(faces[rows], corner)
        faces, parent = faces.copy(), np.concatenate([parent, parent[rows]])
        faces[rows] = np.stack([a, middle, c], axis=1)
        faces = np.concatenate([faces, np.stack([middle, b, c], axis=1)])


def _starting_at(faces, corner):
    """The three columns of (F, 3) faces, rotated so that `corner` (F,) comes first."""
    rows = np.arange(len(faces))
    return tuple(faces[rows, (corner + k) % 3] for k in range(3))
