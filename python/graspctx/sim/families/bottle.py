"""Bottles: wine, beer and water, closed."""

import numpy as np

from .profile import Section, bezier, foot_line, lying, rounded, split_at, turn_sections
from .shape import ObjectShape, RestingPose


def make_bottle(shape_seed: int) -> ObjectShape:
    """A closed, opaque bottle; the grasp region is its neck, from the shoulder up to the lip or the cap."""
    rng = np.random.default_rng(shape_seed)
    kind = str(rng.choice(["wine", "beer", "water"]))
    if kind == "wine":
        height, radius = rng.uniform(0.270, 0.325), rng.uniform(0.035, 0.042)
        neck, rounding = rng.uniform(0.0130, 0.0155), rng.uniform(0.003, 0.006)
        shoulder_share, neck_share = rng.uniform(0.08, 0.34), rng.uniform(0.20, 0.28)
    elif kind == "beer":
        height, radius = rng.uniform(0.170, 0.260), rng.uniform(0.027, 0.034)
        neck, rounding = rng.uniform(0.0120, 0.0140), rng.uniform(0.003, 0.006)
        shoulder_share, neck_share = rng.uniform(0.12, 0.32), rng.uniform(0.20, 0.32)
    else:
        height, radius = rng.uniform(0.165, 0.310), rng.uniform(0.028, 0.044)
        neck, rounding = rng.uniform(0.0115, 0.0150), rng.uniform(0.005, 0.010)
        shoulder_share, neck_share = rng.uniform(0.14, 0.30), rng.uniform(0.06, 0.12)
    cap_height = {"wine": 0.0, "beer": 0.006, "water": rng.uniform(0.011, 0.019)}[kind]
    finish = {
        "wine": rng.uniform(0.005, 0.014),
        "beer": cap_height + rng.uniform(0.006, 0.014),
        "water": cap_height + 0.003,
    }[kind]
    neck_top = height - finish
    neck_bottom = neck_top - max(0.020, neck_share * height)
    shoulder_bottom = neck_bottom - max(0.6 * radius, shoulder_share * height)
    side_start = (radius, 3 * rounding)
    recess = rng.uniform(0.002, 0.012)

    body = np.array([side_start, (radius, shoulder_bottom)])
    labelled = rng.random() < 0.75
    low, high = sorted(
        side_start[1] + (shoulder_bottom - side_start[1]) * rng.uniform([0.05, 0.6], [0.35, 0.98])
    )
    slope = np.array([rng.uniform(0.0, 0.10) * (radius - neck), 0.0])
    taper = rng.uniform(0.0, 0.25) * neck  # the neck widens downwards
    drop = np.array([0.0, neck_bottom - shoulder_bottom])
    start, end = np.array([radius, shoulder_bottom]), np.array([neck + taper, neck_bottom])
    into_neck = np.array([taper / (neck_top - neck_bottom), -1.0])
    shoulder = bezier(
        start,
        start + rng.uniform(0.35, 0.75) * drop - slope,
        end + into_neck * rng.uniform(0.25, 0.6) * drop[1],
        end,
        40,
    )
    # The lower end of the neck, as seen, is where the shoulder has narrowed down to it.
    narrow = neck + taper + 0.18 * (radius - neck)
    narrow_from = float(np.interp(-narrow, -shoulder[:, 0], shoulder[:, 1]))
    shoulder, neck_root = split_at(shoulder, [narrow_from])
    lip = neck + rng.uniform(0.0012, 0.0030)
    neck_line = np.array([end, (neck, neck_top)])
    lip_line, cap_line = _closure(kind, neck, lip, neck_top, height, cap_height)
    body_below, *body_rest = split_at(body, [low, high] if labelled else [])
    sections = [
        Section("outside", foot_line(radius, side_start, rounding, recess)),
        Section("outside", body_below),
        *(Section(part, line) for part, line in zip(("label", "outside"), body_rest)),
        Section("outside", shoulder),
        Section("outside", neck_root, region=True),
        Section("outside", neck_line, region=True),
        Section("outside", lip_line),
        Section("cap", cap_line),
    ]
    turned = turn_sections(sections, sides=72)
    return ObjectShape(
        family="bottle",
        shape_seed=shape_seed,
        dimensions_m={
            "height": height,
            "body_radius": radius,
            "neck_radius": neck,
            "neck_length": neck_top - narrow_from,
            "cap_height": cap_height,
        },
        mesh=turned.mesh,
        parts=turned.parts,
        unrolled_m=(2 * np.pi * radius, turned.length_m),
        resting_poses=(RestingPose("standing", 0.65, np.eye(3)), lying(turned.profile, 0.35)),
        region_name="neck",
        plain_share=0.65,
        solids_m=turned.solids_m,
    )


def _closure(kind, neck, lip, neck_top, height, cap_height):
    """(lip line, cap line) from the top of the neck to the axis."""
    if kind == "wine":
        lip_line = rounded(
            [(neck, neck_top), (lip, neck_top + 0.001), (lip, height - 0.001), (lip - 0.002, height)],
            [0, 0.0006, 0.001, 0],
            points=5,
        )
        cork = height - 0.0015
        cap_line = np.array([lip_line[-1], (0.0095, height), (0.0093, cork), (0.0, cork)])
        return lip_line, cap_line
    cap_from = height - cap_height
    lip_line = np.array(
        [(neck, neck_top), (lip, neck_top + 0.0015), (lip, cap_from - 0.0012), (neck, cap_from)]
    )
    wide = lip + (0.0012 if kind == "beer" else 0.0004)
    cap_line = rounded(
        [(neck, cap_from), (wide, cap_from), (wide - 0.0006, height), (0.0, height)],
        [0, 0.0004, 0.0018, 0],
        points=5,
    )
    return lip_line, cap_line
