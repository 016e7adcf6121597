"""Profiles of turned bodies: drawing their lines, turning them, and laying the body on its side."""

from dataclasses import dataclass

import numpy as np

from ..mesh import Mesh, lathe
from .shape import RestingPose
from .solids import lathe_solids

LONGEST_STEP_M = 0.006
"""Of the points along a turned body: long faces would tell little about where its surface is."""


def along(profile: np.ndarray) -> np.ndarray:
    """(P,) length walked along a (P, 2) profile, metres."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])


def texture_v(share: np.ndarray) -> np.ndarray:
    """Texture coordinate v of a share in [0, 1] of an object's length.

    It keeps off the texture's ends: there its first row and its last, which repeat, would mix.
    """
    margin = 1 / 256
    return margin + (1 - 2 * margin) * np.asarray(share)


def bezier(start, first_handle, second_handle, end, points: int = 20) -> np.ndarray:
    """(points, 2) of a cubic curve."""
    t = np.linspace(0, 1, points)[:, None]
    start, first_handle, second_handle, end = (
        np.asarray(p, float) for p in (start, first_handle, second_handle, end)
    )
    return (
        (1 - t) ** 3 * start
        + 3 * (1 - t) ** 2 * t * first_handle
        + 3 * (1 - t) * t**2 * second_handle
        + t**3 * end
    )


def rounded(corners, radii_m, points: int = 7) -> np.ndarray:
    """(P, 2) the line through `corners` with each corner rounded off.

    Args:
        corners: (C, 2).
        radii_m: radius for all, or (C,) one each; those of both ends are not used. Where neighbours leave too
            little room, the radius shrinks.
        points: on each rounded corner.
    """
    corners = np.asarray(corners, float)
    radii_m = np.broadcast_to(radii_m, len(corners))
    line = [corners[:1]]
    for k in range(1, len(corners) - 1):
        before, after = corners[k - 1] - corners[k], corners[k + 1] - corners[k]
        room = 0.499 * min(np.linalg.norm(before), np.linalg.norm(after))
        before, after = before / np.linalg.norm(before), after / np.linalg.norm(after)
        half_angle = np.arccos(np.clip(before @ after, -1, 1)) / 2
        if radii_m[k] <= 0 or half_angle > np.pi / 2 - 1e-6:
            line.append(corners[k : k + 1])
            continue
        touch = min(radii_m[k] / np.tan(half_angle), room)
        radius = touch * np.tan(half_angle)
        centre = corners[k] + (before + after) / np.linalg.norm(before + after) * np.hypot(touch, radius)
        first = corners[k] + before * touch - centre
        turn = np.linspace(0, np.pi - 2 * half_angle, points)[:, None]
        turn = turn * np.sign(before[1] * after[0] - before[0] * after[1])
        line.append(centre + np.cos(turn) * first + np.sin(turn) * np.array([-first[1], first[0]]))
    return np.concatenate([*line, corners[-1:]])


def even_steps(line: np.ndarray, step_m: float) -> np.ndarray:
    """(Q, 2) the line with points put in wherever two are farther apart than `step_m`."""
    pieces = [line[:1]]
    for start, end in zip(line[:-1], line[1:]):
        count = max(1, int(np.ceil(np.linalg.norm(end - start) / step_m - 1e-9)))
        pieces.append(start + (end - start) * (np.arange(1, count + 1) / count)[:, None])
    return np.concatenate(pieces)


def split_at(line: np.ndarray, heights_m) -> list[np.ndarray]:
    """Cut a line that climbs all the way at some heights: one more line than there are heights.

    A height beyond an end of the line cuts it there; the line beyond is that point alone.
    """
    pieces = []
    for height in np.clip(heights_m, line[0, 1], line[-1, 1]):
        point = np.array([[np.interp(height, line[:, 1], line[:, 0]), height]])
        pieces.append(np.concatenate([line[line[:, 1] < height - 1e-9], point]))
        line = np.concatenate([point, line[line[:, 1] > height + 1e-9]])
    return [*pieces, line]


def foot_line(foot_m: float, side_start, rounding_m: float, recess_m: float = 0.0) -> np.ndarray:
    """(P, 2) the line from the axis under the foot out to where the side starts.

    Args:
        foot_m: radius of the foot.
        side_start: (radius, height), more than the rounding above the table.
        rounding_m: of the foot's edge.
        recess_m: how much higher than the foot its middle is.
    """
    middle = [(0.0, 0.0)]
    if recess_m > 0:
        stand = foot_m - max(0.1 * foot_m, 2 * rounding_m)
        middle = [(0.0, recess_m), (stand - recess_m, recess_m), (stand, 0.0)]
    radii = [0.0, *(0.5 * recess_m for _ in middle[1:]), rounding_m, 0.0]
    return rounded([*middle, (foot_m, 0.0), side_start], radii)


def hollow_side(outer: np.ndarray, wall_m: float, floor_m: float, rounding_m: float):
    """The rim and the inner side of a wall of even thickness.

    Args:
        outer: (P, 2) the wall's outer side, climbing to where the rim starts.
        wall_m: thickness.
        floor_m: height of the floor inside, above the foot.
        rounding_m: of the corner between the wall and the floor.

    Returns:
        (rim, inside): (Q, 2) each; the first starts at the end of `outer`, the second ends on the axis.
    """
    tangent = np.gradient(outer, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    inward = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    angle = np.linspace(0, np.pi, 11)[:, None]
    middle = outer[-1] + wall_m / 2 * inward[-1]
    rim = middle + wall_m / 2 * (np.sin(angle) * tangent[-1] - np.cos(angle) * inward[-1])
    wall = (outer + wall_m * inward)[::-1]
    wall = wall[wall[:, 1] > floor_m + rounding_m]
    slope = (wall[-1] - wall[-2]) / (wall[-1, 1] - wall[-2, 1])
    corner = wall[-1] + slope * (floor_m - wall[-1, 1])
    corner[0] = np.clip(corner[0], 0.25 * wall[-1, 0], wall[-1, 0])
    end = np.array([max(corner[0] - rounding_m, 0.1 * wall[-1, 0]), floor_m])
    turn = bezier(wall[-1], 0.4 * wall[-1] + 0.6 * corner, 0.4 * end + 0.6 * corner, end, 10)
    return rim, np.concatenate([rim[-1:], wall[1:], turn[1:], [[0.0, floor_m]]])


@dataclass(frozen=True)
class Section:
    """A stretch of a profile.

    Attributes:
        part: name of the texture part.
        line: (P, 2) radius and height, metres, with the outside on its right.
        region: whether it is grasp region.
    """

    part: str
    line: np.ndarray
    region: bool = False


@dataclass(frozen=True)
class Turned:
    """A body turned from sections.

    Attributes:
        profile: (P, 2) all of them, one after the other.
        v: (P,) texture coordinate along it.
        parts: interval of v of each texture part.
        length_m: of the profile.
    """

    profile: np.ndarray
    v: np.ndarray
    parts: dict[str, tuple[float, float]]
    length_m: float
    mesh: Mesh
    solids_m: tuple[np.ndarray, ...]

    def v_at(self, height_m: np.ndarray) -> np.ndarray:
        """The texture coordinate v of the outside at some heights, on its way up from the foot."""
        z = self.profile[:, 1]
        top = int(np.argmax(z))
        foot = np.flatnonzero(z[:top] == z.min())[-1]
        return np.interp(height_m, z[foot : top + 1], self.v[foot : top + 1])


def turn_sections(sections, *, sides: int) -> Turned:
    """Turn sections, each starting where the one before ends, around the z axis.

    Sections of one part follow each other; a section of one point is none.
    """
    sections = [section for section in sections if len(section.line) > 1]
    lines, region, ends = [sections[0].line[:1]], [], []
    for section in sections:
        line = section.line if np.allclose(section.line[0], lines[-1][-1], atol=1e-9) else None
        if line is None:
            raise ValueError(f"a section of '{section.part}' does not start where the one before ends")
        steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
        line = even_steps(np.concatenate([line[:1], line[1:][steps > 1e-7]]), LONGEST_STEP_M)[1:]
        lines.append(line)
        region.append(np.full(len(line), section.region))
        ends.append(sum(map(len, lines)) - 1)
    profile = np.concatenate(lines)
    walked = along(profile)
    v = texture_v(walked / walked[-1])
    parts, start = {}, 0
    for section, end in zip(sections, ends):
        first = parts[section.part][0] if section.part in parts else float(v[start])
        parts[section.part] = (first, float(v[end]))
        start = end
    parts[sections[0].part] = (0.0, parts[sections[0].part][1])
    parts[sections[-1].part] = (parts[sections[-1].part][0], 1.0)
    turn_rad = np.pi / sides
    return Turned(
        profile=profile,
        v=v,
        parts=parts,
        length_m=float(walked[-1]),
        mesh=lathe(*profile.T, v, sides=sides, region=np.concatenate(region), turn_rad=turn_rad),
        solids_m=lathe_solids(*profile.T, sides=sides, turn_rad=turn_rad),
    )


def centre_height(profile: np.ndarray) -> float:
    """Height of the centre of mass of a turned body of even density, metres."""
    (r0, z0), (r1, z1) = profile.T, np.roll(profile, -1, axis=0).T
    # Volume between each edge and the axis: a frustum; those walked downwards count negative.
    volume = (z1 - z0) * (r0**2 + r0 * r1 + r1**2)
    moment = (z1 - z0) * (z0 * (3 * r0**2 + 2 * r0 * r1 + r1**2) + z1 * (r0**2 + 2 * r0 * r1 + 3 * r1**2)) / 4
    return float(moment.sum() / volume.sum())


def lying_tilt(profile: np.ndarray, centre_m: float) -> tuple[float, float]:
    """The line that a turned body rests on when it lies: an edge of its profile's convex hull.

    Args:
        profile: (P, 2).
        centre_m: height of its centre of mass.

    Returns:
        (radius of that line at the height of the centre of mass, slope: change of radius with height).
    """
    below, above = profile[profile[:, 1] < centre_m - 1e-6], profile[profile[:, 1] > centre_m + 1e-6]
    slope = (above[None, :, 0] - below[:, None, 0]) / (above[None, :, 1] - below[:, None, 1])
    radius = below[:, None, 0] + slope * (centre_m - below[:, None, 1])
    widest = np.unravel_index(np.argmax(radius), radius.shape)
    return float(radius[widest]), float(slope[widest])


def rotation_to_side(tilt_rad: float, turn_rad: float) -> np.ndarray:
    """(3, 3): turn about the object's axis, then lay it on its -x side, tilted by `tilt_rad`."""
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    c, s = np.cos(np.pi / 2 - tilt_rad), np.sin(np.pi / 2 - tilt_rad)
    # Takes object -x to table -z (down) and object z to table -x.
    lay = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    return lay @ turn


def lying(profile: np.ndarray, weight: float) -> RestingPose:
    """A turned body on its side."""
    _, slope = lying_tilt(profile, centre_height(profile))
    return RestingPose("lying", weight, rotation_to_side(np.arctan(slope), 0.0))


def upside_down(weight: float) -> RestingPose:
    """A body on its rim."""
    return RestingPose("upside_down", weight, np.diag([1.0, -1.0, -1.0]))
