"""Rendered scenes with known truth: object families, tables, light, a stereo camera, and labels.

Needs the extra `sim` (MuJoCo and Pillow) for rendering. The command is `python -m graspctx.sim make`.
"""

from .families import FAMILIES, ObjectShape, RestingPose, make_object
from .mesh import Mesh
from .scene import Scene, StereoCamera, draw_scene

__all__ = [
    "FAMILIES",
    "Mesh",
    "ObjectShape",
    "RestingPose",
    "Scene",
    "StereoCamera",
    "draw_scene",
    "make_object",
]
