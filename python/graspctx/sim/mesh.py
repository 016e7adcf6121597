"""Triangle meshes: lathes, tubes, rounded boxes, skins over sections; their normals and centre of mass."""

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


def skin(rings_m: np.ndarray, u: np.ndarray, v: np.ndarray, *, region=None) -> Mesh:
    """Skin a sequence of closed rings; each end is closed by a fan to the middle of its ring.

    Args:
        rings_m: (R, S, 3) points; each ring turns counter-clockwise seen against the direction of travel.
        u: (S + 1,) or (R, S + 1) texture coordinate around; the last one closes the ring.
        v: (R,) texture coordinate along; the ends have that of their rim.
        region: (R - 1,) bool for each stretch between two rings, or None for nowhere; an end goes with the
            stretch beside it.

    Returns:
        Closed mesh of the R * S points in the order of the rings, then the two middles.
    """
    count, sides = rings_m.shape[:2]
    u = np.broadcast_to(u, (count, sides + 1))
    region = np.zeros(count - 1, bool) if region is None else np.asarray(region, bool)
    ring, side = (a.reshape(-1) for a in np.meshgrid(np.arange(count - 1), np.arange(sides), indexing="ij"))
    a, b = ring * sides + side, ring * sides + (side + 1) % sides
    c, d = a + sides, b + sides
    uv_a, uv_b, uv_c, uv_d = (
        np.stack([u[ring + after, side + beside], v[ring + after]], -1)
        for after, beside in ((0, 0), (0, 1), (1, 0), (1, 1))
    )
    faces = [np.stack([a, b, d], -1), np.stack([a, d, c], -1)]
    uv = [np.stack([uv_a, uv_b, uv_d], 1), np.stack([uv_a, uv_d, uv_c], 1)]
    first = np.arange(sides)
    for end, middle, turn in ((0, count * sides, -1), (count - 1, count * sides + 1, 1)):
        rim = end * sides + np.stack([first, (first + 1) % sides], -1)
        rim_u = np.stack([u[end, :-1], u[end, 1:]], -1)
        middle_u = rim_u.mean(-1, keepdims=True)
        faces.append(np.column_stack([rim[:, ::turn], np.full(sides, middle)]))
        end_u = np.concatenate([rim_u[:, ::turn], middle_u], axis=1)
        uv.append(np.stack([end_u, np.full_like(end_u, v[end])], -1))
    return Mesh(
        vertices_m=np.concatenate([rings_m.reshape(-1, 3), rings_m[[0, -1]].mean(axis=1)]),
        faces=np.concatenate(faces).astype(np.int32),
        uv=np.concatenate(uv),
        region=np.concatenate([region[ring], region[ring], np.repeat(region[[0, -1]], sides)]),
    )


def rounded_rectangle(
    size_m, radius_m: float, *, step_m: float, cuts_x_m=()
) -> tuple[np.ndarray, np.ndarray]:
    """A rectangle with rounded corners, counter-clockwise, from the lower end of its straight +x side.

    Args:
        size_m: (x, y) size.
        radius_m: of the corners, more than 0 and less than half the shorter side.
        step_m: longest distance of neighbours on the straight sides.
        cuts_x_m: x at which the sides along x have a point too.

    Returns:
        (S, 2) points and (S, 2) unit vectors outwards.
    """
    hx, hy = np.array(size_m) / 2 - radius_m
    across, up = stops(-hx, hx, step_m, cuts_x_m), stops(-hy, hy, step_m)
    turn = np.linspace(0, np.pi / 2, 6)

    def corner(x, y, start):
        angle = turn + start
        return np.stack([x + radius_m * np.cos(angle), y + radius_m * np.sin(angle)], axis=1)

    def side(x, y):
        return np.stack(np.broadcast_arrays(x, y), axis=1)

    points = np.concatenate(
        [
            side(hx + radius_m, up[1:-1]),
            corner(hx, hy, 0),
            side(across[-2:0:-1], hy + radius_m),
            corner(-hx, hy, np.pi / 2),
            side(-hx - radius_m, up[-2:0:-1]),
            corner(-hx, -hy, np.pi),
            side(across[1:-1], -hy - radius_m),
            corner(hx, -hy, 1.5 * np.pi),
        ]
    )
    points = np.roll(points, 1, axis=0)
    return points, (points - np.clip(points, [-hx, -hy], [hx, hy])) / radius_m


def stops(low: float, high: float, step: float, cuts=()) -> np.ndarray:
    """Numbers from low to high, through all the cuts that lie between, in steps of at most `step`."""
    fixed = np.unique([low, high, *(cut for cut in cuts if low < cut < high)])
    pieces = [np.linspace(a, b, int(np.ceil((b - a) / step)) + 1)[:-1] for a, b in zip(fixed, fixed[1:])]
    return np.concatenate([*pieces, [high]])


def rounded_box(
    size_m,
    rounding_m: float,
    *,
    unrolled_m,
    step_m: float = 0.008,
    cuts_x_m=(),
    cuts_z_m=(),
    band=None,
) -> Mesh:
    """A box with rounded edges, its middle at x = y = 0, from z = 0 up.

    The texture is unrolled round the z axis; the two ends have it flat, as large.

    Args:
        size_m: (x, y, z) size.
        rounding_m: radius of the edges between the sides and the ends; those along z are a little rounder.
        unrolled_m: (around, along) size of the texture.
        step_m: longest distance of neighbouring vertices.
        cuts_x_m, cuts_z_m: where the faces' borders lie too, so that a region can end there.
        band: (z from, z to, thickness) of a band around the sides, metres, or None; it must not reach the
            rounded edges. Its texture is that from v = z size / along on.
    """
    height = size_m[2]
    section, outward = rounded_rectangle(size_m[:2], 1.2 * rounding_m, step_m=step_m, cuts_x_m=cuts_x_m)
    turn = np.linspace(0, np.pi / 2, 5)
    inset = rounding_m * (1 - np.sin(turn))
    foot = rounding_m * (1 - np.cos(turn))
    band_from, band_to, band_thickness = band or (height, height, 0.0)
    walls = stops(rounding_m, height - rounding_m, step_m, (*cuts_z_m, band_from, band_to))[1:-1]
    z = np.concatenate([foot, walls, height - foot[::-1]])
    inset = np.concatenate([inset, 0 * walls, inset[::-1]])
    banded = (z >= band_from) & (z <= band_to)
    if band:  # its two borders are steps: a ring below and a ring above each
        first, last = np.flatnonzero(banded)[[0, -1]]
        twice = np.sort(np.concatenate([np.arange(len(z)), [first, last]]))
        z, inset = z[twice], inset[twice]
        banded = np.zeros(len(z), bool)
        banded[first + 1 : last + 2] = True
        inset[banded] = -band_thickness
    rings = np.empty((len(z), len(section), 3))
    rings[..., :2] = section - inset[:, None, None] * outward
    rings[..., 2] = z[:, None]
    inner = int(np.ceil(min(size_m[:2]) / 2 / step_m))
    shrink = np.linspace(0, 1, inner + 1)[1:-1, None, None] * [1, 1, 0] + [0, 0, 1]
    rings = np.concatenate([shrink * rings[0], rings, shrink[::-1] * rings[-1]])
    banded = np.concatenate([np.zeros(len(shrink), bool), banded, np.zeros(len(shrink), bool)])

    walked = np.linalg.norm(np.diff(section, axis=0, append=section[:1]), axis=1)
    around, along = unrolled_m
    u = np.concatenate([[0], np.cumsum(walked)]) / around
    v = np.where(banded, height + rings[:, 0, 2] - band_from, rings[:, 0, 2]) / along
    mesh = skin(rings, u, v)
    points = mesh.vertices_m[mesh.faces]
    normal = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    end = np.abs(normal[:, 2]) > 0.75 * np.linalg.norm(normal, axis=1)
    at = points[..., 2].mean(axis=1)
    low, high = end & (at < rounding_m), end & (at > height - rounding_m)
    half = size_m[1] / 2
    mesh.uv[low] = np.stack([-points[low, :, 0] / around, (points[low, :, 1] + half) / along], -1)
    mesh.uv[high] = np.stack([points[high, :, 0] / around, (height - points[high, :, 1] - half) / along], -1)
    return mesh


def centre_of_mass_m(mesh: Mesh) -> np.ndarray:
    """(3,) middle of the volume that a closed surface encloses."""
    a, b, c = (mesh.vertices_m[mesh.faces[:, k]] for k in range(3))
    volume = (a * np.cross(b, c)).sum(axis=1)
    return ((a + b + c) * volume[:, None]).sum(axis=0) / (4 * volume.sum())


def corner_normals(vertices_m: np.ndarray, faces: np.ndarray, crease_rad: float = 0.6) -> np.ndarray:
    """Normals for smooth shading that keep edges sharper than `crease_rad`.

    Args:
        vertices_m: (V, 3). Vertices at the same place count as one.
        faces: (F, 3).
        crease_rad: faces that meet at a larger angle are shaded apart.

    Returns:
        (F, 3, 3) unit normals, one for each corner of each face.
    """
    # Places as single numbers: rows take numpy three times as long to sort.
    place = np.round(vertices_m * 1e7).astype(np.int64) @ np.array(
        [1, 6364136223846793005, 1442695040888963407]  # wraps around; no two places meet but by chance
    )
    _, welded = np.unique(place, return_inverse=True)
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
