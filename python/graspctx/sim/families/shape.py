"""What an object of any family is: surface, grasp region, texture parts, ways to rest."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..mesh import Mesh


@dataclass(frozen=True)
class RestingPose:
    """One way to lie on a table.

    Attributes:
        name: "standing", "lying" or "upside_down".
        weight: how often it is drawn, relative to the object's other poses.
        table_from_object: (3, 3) rotation; the table's z points up. The object also rests when it is turned
            about z or moved along the table.
    """

    name: str
    weight: float
    table_from_object: np.ndarray


@dataclass(frozen=True)
class ObjectShape:
    """One object: its mesh, its grasp region and how it rests.

    Attributes:
        family, shape_seed: what made it.
        dimensions_m: named lengths, metres.
        mesh: the surface, with the grasp region flagged.
        parts: parts of the surface by name, each an interval (v0, v1) of the texture coordinate v.
        unrolled_m: (around, along) size of the texture on the object, metres.
        resting_poses: ways to lie on a table.
        region_name: what the grasp region is called, such as "handle".
        plain_share: how often the outside has one colour.
        solids_m: convex pieces that fill the body and leave its hollows free, for physics: each the (V, 3)
            vertices of its hull, object frame, metres.
    """

    family: str
    shape_seed: int
    dimensions_m: dict[str, float]
    mesh: Mesh
    parts: dict[str, tuple[float, float]]
    unrolled_m: tuple[float, float]
    resting_poses: tuple[RestingPose, ...]
    region_name: str
    plain_share: float
    solids_m: Sequence[np.ndarray] = ()

    def content_name(self) -> str:
        """Family and surface, such as `mug@1a2b3c4d5e6f`: another for every change of shape or region."""
        digest = hashlib.sha256(np.packbits(self.mesh.region).tobytes())
        for values, unit in ((self.mesh.vertices_m, 1e-6), (self.mesh.uv, 1e-3), (self.mesh.faces, 1)):
            digest.update(np.round(np.asarray(values) / unit).astype("<i8").tobytes())
        for pose in self.resting_poses:
            values = np.append(pose.table_from_object, pose.weight)
            digest.update(np.round(values / 1e-4).astype("<i8").tobytes())
        return f"{self.family}@{digest.hexdigest()[:12]}"
