"""Helpers that several families share: walking along a profile, laying an object on its side."""

import numpy as np


def along(profile: np.ndarray) -> np.ndarray:
    """(P,) length walked along a (P, 2) profile, metres."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])


def rotation_to_side(tilt_rad: float, turn_rad: float) -> np.ndarray:
    """(3, 3): turn about the object's axis, then lay it on its -x side, tilted by `tilt_rad`."""
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    c, s = np.cos(np.pi / 2 - tilt_rad), np.sin(np.pi / 2 - tilt_rad)
    # Takes object -x to table -z (down) and object z to table -x.
    lay = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    return lay @ turn
