"""The object families: one module each, in wide proportions.

Object frame: z is the axis of the lathe, upwards when the object stands; the origin is the middle of its foot
(for the pencil, its tip). The handle of a mug or a teapot points along +x, the teapot's spout along -x.
"""

from __future__ import annotations

from .bottle import make_bottle
from .bowl import make_bowl
from .can import make_can
from .cup import make_cup
from .mug import make_mug
from .pencil import make_pencil
from .shape import ObjectShape, RestingPose
from .teapot import make_teapot
from .wineglass import make_wineglass

__all__ = ["FAMILIES", "ObjectShape", "RestingPose", "make_object"]

FAMILIES = {
    "mug": make_mug,
    "cup": make_cup,
    "pencil": make_pencil,
    "wineglass": make_wineglass,
    "bowl": make_bowl,
    "can": make_can,
    "bottle": make_bottle,
    "teapot": make_teapot,
}
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
