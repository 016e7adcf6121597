"""The object families: one module each, in wide proportions.

Object frame: z is the axis of the lathe, upwards when the object stands; the origin is the middle of its foot
(for the pencil, its tip). The handle of a mug, a teapot or a frying pan points along +x, the
teapot's spout along -x. Of what is no lathe, z is the longest axis; a tool's handle starts at the origin.
"""

from __future__ import annotations

from .book import make_book
from .bottle import make_bottle
from .bowl import make_bowl
from .box import make_box
from .can import make_can
from .cup import make_cup
from .eraser import make_eraser
from .fryingpan import make_fryingpan
from .hammer import make_hammer
from .mug import make_mug
from .pencil import make_pencil
from .screwdriver import make_screwdriver
from .shape import ObjectShape, RestingPose
from .spoon import make_spoon
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
    "box": make_box,
    "eraser": make_eraser,
    "book": make_book,
    "hammer": make_hammer,
    "screwdriver": make_screwdriver,
    "spoon": make_spoon,
    "fryingpan": make_fryingpan,
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
