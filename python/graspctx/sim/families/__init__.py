"""The object families: one module each, in wide proportions.

Object frame: z is the axis of the lathe, upwards when the object stands; the origin is the middle of its foot
(for the pencil, its tip). A mug's handle points along +x.
"""

from __future__ import annotations

from .mug import make_mug
from .pencil import make_pencil
from .shape import ObjectShape, RestingPose
from .wineglass import make_wineglass

__all__ = ["FAMILIES", "ObjectShape", "RestingPose", "make_object"]

FAMILIES = {"mug": make_mug, "pencil": make_pencil, "wineglass": make_wineglass}
"""Families by name: each makes an ObjectShape from a shape seed."""


def make_object(family: str | ObjectShape, shape_seed: int) -> ObjectShape:
    """The object that `shape_seed` stands for in a family; always the same one.

    A given object (a user's mesh) stands for itself, whatever the seed.
    """
    if isinstance(family, ObjectShape):
        return family
    if family not in FAMILIES:
        raise ValueError(f"unknown family '{family}'; known: {', '.join(FAMILIES)}")
    return FAMILIES[family](shape_seed)
