"""Closed books: hard covers with square or round spines, and paperbacks."""

from dataclasses import replace

import numpy as np

from ..mesh import centre_of_mass_m, join, skin, stops
from .profile import along
from .resting import resting_poses
from .sections import PARTS_APART_M
from .shape import ObjectShape
from .solids import tube_solids

BOOK_REGION = 0.4
"""The grasp region reaches over this share of a book's height, in the middle."""
_SUNK_M = 2e-5  # how deep the pages reach into the cover, so that there is no gap


def _folded_line(inset, fore_edge_x, *, width, thickness, bulge, squareness, cut_x):
    """(P, 2) line parallel to the outside of the cover, from the upper fore edge round the spine at -x.

    It has the same number of points for every inset (but not for every fore edge), also at x = cut_x.
    """
    half = thickness / 2
    start = bulge - width / 2
    flat = stops(start, fore_edge_x, 0.010, cut_x)
    turn = np.linspace(np.pi / 2, -np.pi / 2, 25)[1:-1]
    bend_x = start - (bulge - inset) * np.cos(turn) ** squareness
    bend_y = (half - inset) * np.sign(np.sin(turn)) * np.abs(np.sin(turn)) ** squareness
    upper = np.stack([flat[::-1], np.full(len(flat), half - inset)], axis=1)
    return np.concatenate([upper, np.stack([bend_x, bend_y], axis=1), upper[::-1] * [1, -1]])


def make_book(shape_seed: int) -> ObjectShape:
    """A closed book, its spine at -x; the grasp region is the middle of the spine and of the fore edge.

    As for a carton, the region has a margin on the covers beside them, where the fingers touch when the hand
    closes over the thickness. A book that lies flat is taken over its width.
    """
    rng = np.random.default_rng(shape_seed)
    height = rng.uniform(0.150, 0.255)
    width = min(height * rng.uniform(0.60, 0.78), 0.172)
    thickness = rng.uniform(0.008, 0.052)
    kind = rng.choice(["paperback", "square", "round"]) if thickness > 0.016 else "paperback"
    board = rng.uniform(0.0004, 0.0008) if kind == "paperback" else rng.uniform(0.002, 0.0034)
    overhang = 0.0003 if kind == "paperback" else rng.uniform(0.002, 0.0045)
    bulge = min(0.011, thickness * rng.uniform(0.2, 0.35)) if kind == "round" else board + 0.0012
    margin = min(0.020, 0.15 * width)
    border_x = width / 2 - margin
    border_z = height * (1 + BOOK_REGION * np.array([-1, 1])) / 2

    line = {
        "width": width,
        "thickness": thickness,
        "bulge": bulge,
        "squareness": 1.0 if kind == "round" else 0.25,
        "cut_x": (-border_x, border_x),
    }
    outer, inner = (_folded_line(inset, width / 2, **line) for inset in (0.0, board))
    z = stops(0.0, height, 0.010, border_z)
    # The cover is a ribbon as wide as the book is high: each ring goes down its outside and up its inside.
    rings = np.empty((len(outer), 2 * len(z), 3))
    rings[:, : len(z), :2], rings[:, len(z) :, :2] = outer[:, None], inner[:, None]
    rings[..., 2] = np.concatenate([z[::-1], z])
    # Closed along the middle of the boards' edges, not in a fan: the region ends across them.
    middle = rings[[0, -1], :, :2].reshape(2, 2, len(z), 2).mean(axis=1)
    closing = rings[[0, -1]]
    closing[..., :2] += 0.9 * (np.concatenate([middle, middle], axis=1) - closing[..., :2])
    closing[..., 2] = np.clip(closing[..., 2], board / 2, height - board / 2)
    path = along(outer)
    unrolled = (2 * (height + board), path[-1] + height + 2 * PARTS_APART_M)
    down = height - z[::-1]
    u = np.concatenate([down, height + board + down, [unrolled[0]]]) / unrolled[0]
    cover = skin(
        np.concatenate([closing[:1], rings, closing[1:]]), u, np.pad(path, 1, mode="edge") / unrolled[1]
    )

    page_z = stops(overhang, height - overhang, 0.010, border_z)
    section = _folded_line(board - _SUNK_M, width / 2 - overhang, **line)
    fore_edge = stops(section[-1, 1], section[0, 1], 0.008)[1:-1]
    section = np.concatenate([section, np.stack([np.full(len(fore_edge), section[0, 0]), fore_edge], axis=1)])
    page_rings = np.empty((len(page_z), len(section), 3))
    page_rings[..., :2], page_rings[..., 2] = section, page_z[:, None]
    around = along(np.concatenate([section, section[:1]]))
    pages = skin(page_rings, around / unrolled[0], (path[-1] + PARTS_APART_M + page_z) / unrolled[1])

    mesh = join(cover, pages)
    x, _, z = mesh.vertices_m[mesh.faces].mean(axis=1).T
    region = (np.abs(x) > border_x) & (z > border_z[0]) & (z < border_z[1])
    region[len(cover.faces) - 2 * rings.shape[1] : len(cover.faces)] = False  # the fans
    mesh = replace(mesh, region=region)
    # Books stand more often than they fall so; not on a round spine.
    poses = [
        replace(pose, weight=pose.weight**0.5)
        for pose in resting_poses(mesh.vertices_m, centre_of_mass_m(mesh))
        if np.abs(pose.table_from_object[2]).max() > 0.99
        and not (kind == "round" and pose.table_from_object[2, 0] > 0.5)
    ]
    border = (path[-1] + PARTS_APART_M / 2) / unrolled[1]
    return ObjectShape(
        family="book",
        shape_seed=shape_seed,
        dimensions_m={
            "width": width,
            "thickness": thickness,
            "height": height,
            "board": board,
            "overhang": overhang,
            "bulge": bulge,
            "margin": margin,
        },
        mesh=mesh,
        parts={"outside": (0.0, border), "paper": (border, 1.0)},
        unrolled_m=unrolled,
        resting_poses=tuple(poses),
        region_name="narrow side",
        plain_share=0.3,
        solids_m=(*tube_solids(rings), pages.vertices_m),
    )
