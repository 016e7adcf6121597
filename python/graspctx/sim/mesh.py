"""Triangle meshes made from profiles and curves: lathes, tubes, and their normals."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Mesh:
    """Triangles with texture coordinates and a grasp-region flag.

    Attributes:
        vertices_m: (V, 3) float64, metres.
        faces: (F, 3) int32 vertex indices, counter-clockwise seen from outside.
        uv: (F, 3, 2) float64, texture coordinates of each face's corners; outside [0, 1] the texture repeats.
        region: (F,) bool, True where the face belongs to the grasp region.
    """

    vertices_m: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    region: np.ndarray


def join(*meshes: Mesh) -> Mesh:
    """Put meshes side by side into one."""
    offsets = np.cumsum([0] + [len(mesh.vertices_m) for mesh in meshes[:-1]])
    return Mesh(
        vertices_m=np.concatenate([mesh.vertices_m for mesh in meshes]),
        faces=np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets)]).astype(np.int32),
        uv=np.concatenate([mesh.uv for mesh in meshes]),
        region=np.concatenate([mesh.region for mesh in meshes]),
    )


def lathe(radius_m, height_m, v, *, sides: int, region=None, turn_rad: float = 0.0) -> Mesh:
    """Turn a profile around the z axis.

    Args:
        radius_m, height_m: (P,) the profile, with the outside on its right when walked from first to last
            point (from the middle of the bottom outwards and up). A radius of 0 closes the mesh in a point.
        v: (P,) texture coordinate along the profile; u runs once around.
        sides: number of corners around.
        region: (P - 1,) bool for each piece of the profile, or None for nowhere.
        turn_rad: angle of the first corner.

    Returns:
        Mesh with P * sides vertices.
    """
    radius_m, height_m, v = (np.asarray(a, float) for a in (radius_m, height_m, v))
    pieces = len(radius_m) - 1
    region = np.zeros(pieces, bool) if region is None else np.asarray(region, bool)
    angle = turn_rad + 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    vertices = np.empty((pieces + 1, sides, 3))
    vertices[..., :2] = radius_m[:, None, None] * ring
    vertices[..., 2] = height_m[:, None]

    below, side = np.meshgrid(np.arange(pieces), np.arange(sides), indexing="ij")
    after = (side + 1) % sides
    a, b = below * sides + side, below * sides + after
    c, d = a + sides, b + sides
    u0, u1 = (angle[side] / (2 * np.pi), (angle[side] + 2 * np.pi / sides) / (2 * np.pi))
    v0, v1 = v[below], v[below + 1]
    lower = np.stack([a, b, d], axis=-1)
    upper = np.stack([a, d, c], axis=-1)
    uv_lower = np.stack([np.stack(p, -1) for p in ((u0, v0), (u1, v0), (u1, v1))], axis=-2)
    uv_upper = np.stack([np.stack(p, -1) for p in ((u0, v0), (u1, v1), (u0, v1))], axis=-2)
    keep_lower = np.broadcast_to((radius_m[:-1] > 0)[:, None], a.shape)
    keep_upper = np.broadcast_to((radius_m[1:] > 0)[:, None], a.shape)
    flags = np.broadcast_to(region[:, None], a.shape)
    return Mesh(
        vertices_m=vertices.reshape(-1, 3),
        faces=np.concatenate([lower[keep_lower], upper[keep_upper]]).astype(np.int32),
        uv=np.concatenate([uv_lower[keep_lower], uv_upper[keep_upper]]),
        region=np.concatenate([flags[keep_lower], flags[keep_upper]]),
    )


def tube(rings_m: np.ndarray, uv: np.ndarray, *, region: bool) -> Mesh:
    """Skin a sequence of closed rings, without caps.

    Args:
        rings_m: (R, S, 3) points; each ring turns counter-clockwise seen against the direction of travel.
        uv: (R, S, 2) texture coordinates; they must not wrap within a face.
        region: whether the tube is grasp region.
    """
    count, sides = rings_m.shape[:2]
    ring, side = np.meshgrid(np.arange(count - 1), np.arange(sides), indexing="ij")
    after = (side + 1) % sides
    a, b = ring * sides + side, ring * sides + after
    c, d = a + sides, b + sides
    faces = np.concatenate([np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)])
    return Mesh(
        vertices_m=rings_m.reshape(-1, 3),
        faces=faces.astype(np.int32),
        uv=uv.reshape(-1, 2)[faces],
        region=np.full(len(faces), region),
    )


def corner_normals(vertices_m: np.ndarray, faces: np.ndarray, crease_rad: float = 0.6) -> np.ndarray:
    """Normals for smooth shading that keep edges sharper than `crease_rad`.

    Args:
        vertices_m: (V, 3). Vertices at the same place count as one.
        faces: (F, 3).
        crease_rad: faces that meet at a larger angle are shaded apart.

    Returns:
        (F, 3, 3) unit normals, one for each corner of each face.
    """
    _, welded = np.unique(np.round(vertices_m, 7), axis=0, return_inverse=True)
    corner_vertex = welded.reshape(-1)[faces].reshape(-1)
    points = vertices_m[faces]
    normal = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-18)

    before, after = points[:, [2, 0, 1]] - points, points[:, [1, 2, 0]] - points
    cosine = (before * after).sum(-1) / np.maximum(
        np.linalg.norm(before, axis=-1) * np.linalg.norm(after, axis=-1), 1e-18
    )
    angle = np.arccos(np.clip(cosine, -1, 1)).reshape(-1)

    # All pairs of corners that share a vertex.
    order = np.argsort(corner_vertex, kind="stable")
    count = np.bincount(corner_vertex)
    first = np.cumsum(count) - count
    repeats = count[corner_vertex]
    corner = np.repeat(np.arange(len(corner_vertex)), repeats)
    step = np.arange(len(corner)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    other = order[first[corner_vertex[corner]] + step]

    alike = (normal[corner // 3] * normal[other // 3]).sum(-1) >= np.cos(crease_rad)
    corner, other = corner[alike], other[alike]
    weighted = normal[other // 3] * angle[other][:, None]
    summed = np.stack([np.bincount(corner, weighted[:, k], len(corner_vertex)) for k in range(3)], axis=-1)
    summed /= np.maximum(np.linalg.norm(summed, axis=1, keepdims=True), 1e-18)
    return summed.reshape(-1, 3, 3)
