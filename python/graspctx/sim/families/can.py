"""Cans: drinks cans and food tins."""

import numpy as np

from .profile import Section, even_steps, lying, rounded, split_at, turn_sections, upside_down
from .shape import ObjectShape, RestingPose

CAN_REGION = 0.5
"""The grasp region of a can: this share of its height, in the middle of the side."""


def make_can(shape_seed: int) -> ObjectShape:
    """A closed can; the grasp region is the side halfway up, all around: its two narrow sides as seen."""
    rng = np.random.default_rng(shape_seed)
    drinks = rng.random() < 0.5
    if drinks:
        height, radius = rng.uniform(0.088, 0.170), rng.uniform(0.026, 0.034)
        base, side, top = _drinks_can(rng, height, radius)
    else:
        radius = rng.uniform(0.030, 0.052)
        height = radius * rng.uniform(0.9, 3.2)
        base, side, top = _tin(rng, height, radius)
    below, grasped, above = split_at(side, height * (1 + CAN_REGION * np.array([-1, 1])) / 2)
    turned = turn_sections(
        [
            Section("base", base),
            Section("outside", below),
            Section("outside", grasped, region=True),
            Section("outside", above),
            Section("top", top),
        ],
        sides=72,
    )
    return ObjectShape(
        family="can",
        shape_seed=shape_seed,
        dimensions_m={"height": height, "radius": radius},
        mesh=turned.mesh,
        parts=turned.parts,
        unrolled_m=(2 * np.pi * radius, turned.length_m),
        resting_poses=(
            RestingPose("standing", 0.70, np.eye(3)),
            upside_down(0.02 if drinks else 0.10),
            lying(turned.profile, 0.25 if height > 2 * radius else 0.04),
        ),
        region_name="middle",
        plain_share=0.15,
        solids_m=turned.solids_m,
    )


def _drinks_can(rng, height, radius):
    """(base, side, top) lines: domed base on a narrow ring, necked shoulder, seam, sunk lid."""
    ring = radius * rng.uniform(0.70, 0.78)
    seam = radius * rng.uniform(0.76, 0.88)
    dome = rng.uniform(0.006, 0.010)
    heel, neck = rng.uniform(0.007, 0.011), rng.uniform(0.010, 0.020)
    lid = height - rng.uniform(0.003, 0.0045)
    angle = np.linspace(np.pi / 2, 0.15, 9)
    inside = np.stack([(ring - 0.0025) * np.cos(angle), dome * np.sin(angle)], axis=1)
    inside[0, 0] = 0.0
    base = np.concatenate(
        [inside, rounded([(ring - 0.0025, 0.0), (ring, 0.0), (radius, heel), (radius, 1.5 * heel)], 0.004)]
    )
    shoulder_top = height - 0.0035
    side = rounded(
        [(radius, 1.5 * heel), (radius, shoulder_top - neck), (seam * 0.97, shoulder_top)], [0, 0.012, 0]
    )
    top = rounded(
        [
            side[-1],
            (seam, shoulder_top + 0.0005),
            (seam, height),
            (seam - 0.0022, height),
            (seam - 0.0035, lid - 0.002),
            (seam - 0.006, lid - 0.002),
            (seam - 0.0065, lid),
            (0.0, lid),
        ],
        [0, 0.0006, 0.001, 0.0009, 0.0008, 0.0008, 0.001, 0],
        points=5,
    )
    return base, side, top


def _tin(rng, height, radius):
    """(base, side, top) lines: straight, seamed at both ends, maybe ribbed."""
    bead, sunk = rng.uniform(0.0008, 0.0016), rng.uniform(0.002, 0.004)
    seam_height, seam_width = rng.uniform(0.0025, 0.0035), 0.0018
    end = [
        (0.0, sunk),
        (radius - seam_width - 0.001, sunk),
        (radius - seam_width, 0.0),
        (radius + bead, 0.0),
        (radius + bead, seam_height),
        (radius, seam_height + 0.001),
    ]
    base = rounded(end, [0, 0.0008, 0.0008, 0.0008, 0.0006, 0], points=5)
    side = even_steps(np.array([base[-1], (radius, height - seam_height - 0.001)]), 0.0008)
    if rng.random() < 0.5:
        s = (side[:, 1] - side[0, 1]) / np.ptp(side[:, 1])
        share, pitch = rng.uniform(0.3, 0.7), rng.uniform(0.0045, 0.007)
        ribs = max(2, round(share * height / pitch))
        within = np.clip((s - 0.5) / share + 0.5, 0, 1)
        side[:, 0] -= rng.uniform(0.0004, 0.0009) * (0.5 - 0.5 * np.cos(2 * np.pi * ribs * within))
    top = np.array([0.0, height]) + base[::-1] * [1, -1]
    return base, side, top
