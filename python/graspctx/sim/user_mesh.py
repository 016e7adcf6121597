"""A user's mesh as an object: one small JSON file says its unit, its grasp region and what to call it.

docs/own-objects.md describes the file, step by step.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .families.resting import resting_poses, rotation_downwards
from .families.shape import ObjectShape, RestingPose
from .mesh import Mesh
from .mesh_cut import Box, cut_by_boxes
from .stored import DatasetError
from .unwrap import unwrap

MESHES_VARIABLE = "GRASPCTX_MESHES"
"""Environment variable: a folder in which meshes are looked up that do not lie beside their object file."""
MESH_SUFFIXES = (".stl", ".obj", ".ply")
LENGTH_LIMITS_M = (0.01, 0.45)
"""Shortest and longest an object may be: what fits a table, a hand and both views."""
MOST_FACES = 200_000
COLOUR_TOLERANCE = 48
"""Vertices whose red, green and blue are each this near to the region's colour are painted."""
PLAIN_SHARE = 0.4
DIRECTIONS = {
    s + a: tuple((1 if s == "+" else -1) * float(b == a) for b in "xyz") for s in "+-" for a in "xyz"
}
POSES = ("standing", "lying", "upside_down")
_FAMILY_NAME = re.compile(r"[a-z][a-z0-9_-]{0,31}")


class MeshError(DatasetError):
    """An object file or its mesh cannot be used; the message names the file and says what was expected."""


@dataclass(frozen=True)
class ObjectFile:
    """What an object file says.

    Attributes:
        path: the object file itself.
        family: what the object is called in the data set, such as "mug".
        mesh: file of the surface.
        unit_m: metres that one unit of the mesh stands for.
        up: direction in the mesh that points up when the object stands.
        region_name: what the grasp region is called.
        boxes: the region's boxes, in the mesh's unit and axes; or
        material: its OBJ material; or
        colour: its vertex colour, red, green and blue from 0 to 255.
        solids: files of the convex parts; empty for the convex hull.
        resting: ((pose name, weight), …), or None for what the shape itself suggests.
    """

    path: Path
    family: str
    mesh: Path
    unit_m: float
    up: tuple[float, float, float]
    region_name: str
    boxes: tuple[Box, ...]
    material: str | None
    colour: tuple[float, float, float] | None
    solids: tuple[Path, ...]
    resting: tuple[tuple[str, float], ...] | None

    def from_mesh(self, points: np.ndarray) -> np.ndarray:
        """(N, 3) points in the mesh's unit and axes to metres in the object's frame, where z is up."""
        return points @ rotation_downwards(-np.array(self.up)).T * self.unit_m

    def to_mesh(self, points_m: np.ndarray) -> np.ndarray:
        """(N, 3) points in the object's frame to the mesh's unit and axes."""
        return points_m @ rotation_downwards(-np.array(self.up)) / self.unit_m


def is_object_file(name: str) -> bool:
    """Whether a family's name is the path of an object file."""
    return str(name).endswith(".json")


def load_object(path: str | os.PathLike, meshes: str | os.PathLike | None = None) -> ObjectShape:
    """The object that an object file describes.

    The object's frame is the mesh's own, in metres, turned so that z is up. `shape_seed` is made from the
    shape itself: the same one under two names has one seed.

    Args:
        path: the object file.
        meshes: folder in which meshes are looked up that do not lie beside the object file; by default that
            of the environment variable GRASPCTX_MESHES.

    Raises:
        MeshError: the object file, the mesh, its region or its solids cannot be used.
    """
    return build_object(read_object_file(path, meshes))


def read_object_file(path: str | os.PathLike, meshes: str | os.PathLike | None = None) -> ObjectFile:
    """Read and check an object file, and find its meshes; arguments as in load_object.

    Raises:
        MeshError: it is missing, is not JSON, or says something that is not understood.
    """
    path = Path(path)
    try:
        content = json.loads(path.read_bytes())
    except OSError as error:
        raise MeshError(f"{path}: {error.strerror}; expected an object file (JSON)") from error
    except (ValueError, RecursionError) as error:  # JSON and UTF-8 errors alike, and deep nesting
        raise MeshError(f"{path}: not JSON ({error})") from error
    meshes = meshes or os.environ.get(MESHES_VARIABLE)
    reader = _Reader(path, [path.parent, *([Path(meshes)] if meshes else [])])
    known = {"family", "mesh", "unit_m", "up", "region", "solids", "resting"}
    reader.keys(content, "the file", known, required={"family", "mesh", "region"})
    family = reader.text(content["family"], "family")
    if not _FAMILY_NAME.fullmatch(family):
        raise MeshError(f"{path}: family '{family}'; expected small letters, digits, - and _, such as 'mug'")
    unit_m = reader.number(content.get("unit_m", 1.0), "unit_m")
    if unit_m <= 0:
        raise MeshError(f"{path}: unit_m {unit_m:g}; expected a length, such as 0.001 for millimetres")
    up = content.get("up", "+z")
    if up not in DIRECTIONS:
        raise MeshError(f"{path}: up {json.dumps(up)}; expected one of {', '.join(DIRECTIONS)}")
    region = content["region"]
    reader.keys(region, "region", {"name", "boxes", "material", "colour"}, required={"name"})
    if sum(key in region for key in ("boxes", "material", "colour")) != 1:
        raise MeshError(f"{path}: region; expected one of boxes, material and colour")
    mesh = Path(reader.text(content["mesh"], "mesh"))
    if mesh.suffix.lower() not in MESH_SUFFIXES:
        raise MeshError(f"{path}: mesh '{mesh}': unknown kind; expected {', '.join(MESH_SUFFIXES)}")
    mesh = reader.file(mesh)
    material = reader.text(region["material"], "region.material") if "material" in region else None
    if material and mesh.suffix.lower() != ".obj":
        raise MeshError(f"{path}: region.material with {mesh.name}; expected an OBJ, which has materials")
    solids = reader.solids(content.get("solids", []))
    return ObjectFile(
        path=path,
        family=family,
        mesh=mesh,
        unit_m=unit_m,
        up=DIRECTIONS[up],
        region_name=reader.text(region["name"], "region.name"),
        boxes=reader.boxes(region["boxes"]) if "boxes" in region else (),
        material=material,
        colour=reader.colour(region["colour"]) if "colour" in region else None,
        solids=solids,
        resting=reader.resting(content["resting"]) if "resting" in content else None,
    )


class _Reader:
    """Checks the values of one object file."""

    def __init__(self, path: Path, folders: list[Path]):
        self._path, self._folders = path, folders

    def _refuse(self, key, value, expected):
        raise MeshError(f"{self._path}: {key} is {json.dumps(value)[:60]}; expected {expected}")

    def keys(self, content, what, known, required):
        if not isinstance(content, dict):
            self._refuse(what, content, "an object {…}")
        for key in sorted(required - content.keys()):
            raise MeshError(f"{self._path}: {what} has no '{key}'")
        for key in sorted(content.keys() - known):
            raise MeshError(f"{self._path}: {what} has unknown '{key}'; known: {', '.join(sorted(known))}")

    def text(self, value, key):
        if not isinstance(value, str) or not value:
            self._refuse(key, value, "text")
        return value

    def number(self, value, key):
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not np.isfinite(value):
            self._refuse(key, value, "a number")
        return float(value)

    def triple(self, value, key):
        if not isinstance(value, list) or len(value) != 3:
            self._refuse(key, value, "three numbers [x, y, z]")
        return tuple(self.number(entry, key) for entry in value)

    def boxes(self, value):
        if not isinstance(value, list) or not value:
            self._refuse("region.boxes", value, "a list of boxes")
        boxes = []
        for index, entry in enumerate(value):
            key = f"region.boxes[{index}]"
            self.keys(entry, key, {"min", "max", "turn_deg", "outward"}, required={"min", "max"})
            low, high = self.triple(entry["min"], key + ".min"), self.triple(entry["max"], key + ".max")
            if not all(a < b for a, b in zip(low, high)):
                raise MeshError(
                    f"{self._path}: {key} from {list(low)} to {list(high)}; expected min < max in x, y and z"
                )
            turn_deg = self.triple(entry.get("turn_deg", [0, 0, 0]), key + ".turn_deg")
            outward = entry.get("outward", False)
            if not isinstance(outward, bool):
                self._refuse(key + ".outward", outward, "true or false")
            boxes.append(Box(low, high, turn_deg, outward))
        return tuple(boxes)

    def colour(self, value):
        colour = self.triple(value, "region.colour")
        if not all(0 <= entry <= 255 for entry in colour):
            self._refuse("region.colour", value, "[red, green, blue] from 0 to 255")
        return colour

    def resting(self, value):
        self.keys(value, "resting", set(POSES), required=set())
        weights = tuple((name, self.number(weight, f"resting.{name}")) for name, weight in value.items())
        if (
            min((weight for _, weight in weights), default=-1) < 0
            or sum(weight for _, weight in weights) <= 0
        ):
            self._refuse("resting", value, 'weights such as {"standing": 0.9, "lying": 0.1}')
        return weights

    def file(self, name) -> Path:
        for folder in self._folders:
            if (folder / name).is_file():
                return folder / name
        looked = " or ".join(str(folder) for folder in self._folders)
        hint = "" if self._folders[1:] else f"; --meshes DIR or ${MESHES_VARIABLE} names another folder"
        raise MeshError(f"{self._path}: mesh '{name}' not found in {looked}{hint}")

    def solids(self, value) -> tuple[Path, ...]:
        if not isinstance(value, list):
            self._refuse("solids", value, 'a list of file names or patterns such as ["part*.stl"]')
        files = []
        for pattern in value:
            try:
                found = [sorted(folder.glob(self.text(pattern, "solids"))) for folder in self._folders]
            except (ValueError, NotImplementedError) as error:  # an absolute pattern
                raise MeshError(f"{self._path}: solids '{pattern}': {error}") from error
            if not any(found):
                raise MeshError(f"{self._path}: solids '{pattern}' matches no file")
            files += next(match for match in found if match)
        return tuple(files)


def build_object(said: ObjectFile) -> ObjectShape:
    """The object of an object file that was read."""
    body, painted = _read_painted_mesh(said.mesh, said.material, said.colour)
    vertices_m = said.from_mesh(body.vertices)
    _check_size(said, vertices_m)
    if said.boxes:
        vertices, faces, region = cut_by_boxes(body.vertices, body.faces, said.boxes)
        vertices_m = said.from_mesh(vertices)
    else:
        faces, region = body.faces, painted
    _check_region(said, body, vertices_m, faces, region)
    uv, unrolled_m = unwrap(vertices_m, faces)
    centre_m = said.from_mesh(body.center_mass if body.is_watertight else body.centroid)
    return ObjectShape(
        family=said.family,
        shape_seed=_shape_seed(body, said.unit_m),
        dimensions_m=_dimensions_m(vertices_m),
        mesh=Mesh(vertices_m, faces.astype(np.int32), uv, region),
        parts={"outside": (0.0, 1.0)},
        unrolled_m=unrolled_m,
        resting_poses=_resting_poses(said, vertices_m, centre_m),
        region_name=said.region_name,
        plain_share=PLAIN_SHARE,
        solids_m=_solids_m(said, vertices_m),
    )


def read_mesh(file: Path):
    """The surface in a file as a clean trimesh.Trimesh: finite, welded, turned outwards; in its own unit.

    Raises:
        MeshError: the file cannot be read, or holds no surface.
    """
    return _read_painted_mesh(file)[0]


def _read_painted_mesh(file: Path, material: str | None = None, colour=None):
    """The mesh as a clean trimesh.Trimesh in its own unit, and (F,) bool which faces are painted."""
    import trimesh

    suffix = file.suffix.lower().removeprefix(".")
    parts = []
    try:
        with open(file, "rb") as stream:
            resolver = None
            if suffix == "obj":
                stream, resolver = _materials_by_name(stream.read())
            loaded = trimesh.load_scene(stream, file_type=suffix, resolver=resolver, process=False)
        parts = [part for part in loaded.geometry.values() if isinstance(part, trimesh.Trimesh)]
    except OSError as error:
        raise MeshError(f"{file}: {error.strerror or error}") from error
    except Exception as error:  # the readers raise whatever their parsing stumbles over
        reason = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise MeshError(f"{file}: cannot be read as {suffix.upper()} ({reason})") from error
    parts = [part for part in parts if len(part.faces)]
    if not parts:
        raise MeshError(f"{file}: no faces; expected a triangle mesh")
    painted = np.concatenate([_painted_faces(file, part, material, colour) for part in parts])
    offsets = np.cumsum([0] + [len(part.vertices) for part in parts[:-1]])
    body = trimesh.Trimesh(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.faces + offset for part, offset in zip(parts, offsets)]),
        process=False,
    )
    used = body.vertices[np.unique(body.faces)]
    if not np.isfinite(used).all():
        raise MeshError(
            f"{file}: {int((~np.isfinite(used)).any(axis=1).sum())} vertices are not finite numbers"
        )
    if len(body.faces) > MOST_FACES:
        raise MeshError(
            f"{file}: {len(body.faces)} faces; expected at most {MOST_FACES}: simplify the mesh "
            "(some ten thousand faces show all that a camera sees)"
        )
    if material is not None and not painted.any():
        known = sorted({str(part.metadata.get("material")) for part in parts})
        raise MeshError(f"{file}: no face has the material '{material}'; it has {', '.join(known)}")
    if colour is not None and not painted.any():
        raise MeshError(
            f"{file}: no face has the colour {[int(c) for c in colour]}; expected painted vertices"
        )
    body.merge_vertices(merge_norm=True, merge_tex=True)
    kept = body.nondegenerate_faces()
    body.update_faces(kept)
    body.remove_unreferenced_vertices()
    if not len(body.faces):
        raise MeshError(f"{file}: every face is a line or a point; expected a surface")
    if not body.is_winding_consistent:
        trimesh.repair.fix_winding(body)
    with np.errstate(invalid="ignore"):  # a flat mesh has no volume to divide by
        if body.volume < 0:
            body.invert()
    return body, painted[kept]


def _materials_by_name(content: bytes):
    """An OBJ with a material library of names alone: the reader drops the names of materials it lacks."""
    import io

    import trimesh

    lines = content.decode("utf-8", errors="replace").splitlines()
    names = {
        line.split(None, 1)[1].strip() for line in lines if line.startswith("usemtl ") and line.split()[1:]
    }
    library = "".join(f"newmtl {name}\nKd 1 1 1\n" for name in sorted(names)).encode()

    class Names(trimesh.resolvers.Resolver):
        def __init__(self):
            pass

        def get(self, name):
            return library

        def keys(self):
            return ["names.mtl"]

        def namespaced(self, namespace):
            return self

        def write(self, name, data):
            raise PermissionError("names of materials are only read")

    kept = [line for line in lines if not line.startswith("mtllib")]
    return io.BytesIO("\n".join(["mtllib names.mtl", *kept, ""]).encode()), Names()


def _painted_faces(file, part, material, colour) -> np.ndarray:
    """(F,) bool of one part of a mesh."""
    name = getattr(getattr(part.visual, "material", None), "name", None)
    part.metadata["material"] = name
    if material is not None:
        return np.full(len(part.faces), name == material)
    if colour is None:
        return np.zeros(len(part.faces), bool)
    if part.visual.kind not in ("vertex", "face"):
        raise MeshError(f"{file}: has no vertex colours; expected some for region.colour")
    rgb = np.asarray(part.visual.vertex_colors)[:, :3].astype(float)
    near = (np.abs(rgb - colour) <= COLOUR_TOLERANCE).all(axis=1)
    return near[part.faces].sum(axis=1) >= 2


def _check_size(said: ObjectFile, vertices_m) -> None:
    length_m = float(np.ptp(vertices_m, axis=0).max())
    low, high = LENGTH_LIMITS_M
    if low <= length_m <= high:
        return
    guess = ""
    for unit_m, name in ((0.001, "millimetres"), (0.01, "centimetres"), (0.0254, "inches"), (1.0, "metres")):
        if unit_m != said.unit_m and 0.03 <= length_m / said.unit_m * unit_m <= high:
            guess = f'; if it is in {name}, set "unit_m": {unit_m:g}'
            break
    raise MeshError(
        f"{said.path}: {said.mesh.name} is {length_m:.3g} m long with unit_m {said.unit_m:g}; "
        f"expected {low:g} to {high:g} m{guess}"
    )


def _check_region(said: ObjectFile, body, vertices_m, faces, region) -> None:
    share = region_share(vertices_m, faces, region)
    low, high = ([float(f"{x:.4g}") for x in corner] for corner in body.bounds)
    if share == 0:
        raise MeshError(f"{said.path}: the region holds no surface; the mesh reaches from {low} to {high}")
    if share > 0.99:
        raise MeshError(
            f"{said.path}: the region is the whole surface; expected a part; "
            f"the mesh reaches from {low} to {high}"
        )


def region_share(vertices_m: np.ndarray, faces: np.ndarray, region: np.ndarray) -> float:
    """Share of the surface's area that is grasp region."""
    a, b, c = vertices_m[faces].swapaxes(0, 1)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return float(area[region].sum() / area.sum())


def _shape_seed(body, unit_m) -> int:
    """48 bits of the shape's size, area and volume, to a tenth of a millimetre.

    Unlike a sum of the vertices it stays the same when another program writes the mesh in another unit, order
    or precision.
    """
    lengths_m = [*sorted(body.extents), body.area**0.5, abs(body.volume) ** (1 / 3)]
    rounded = np.round(np.array(lengths_m) * unit_m / 1e-4).astype("<i8")
    return int(hashlib.sha256(rounded.tobytes()).hexdigest()[:12], 16)


def _dimensions_m(vertices_m) -> dict[str, float]:
    x, y, height = np.ptp(vertices_m, axis=0)
    return {"height": float(height), "length": float(max(x, y)), "width": float(min(x, y))}


def _resting_poses(said: ObjectFile, vertices_m, centre_m) -> tuple[RestingPose, ...]:
    """The poses that physics allows, as often as the file says; by default mostly standing if it can."""
    try:
        poses = resting_poses(vertices_m, centre_m)
    except ValueError as error:
        raise MeshError(f"{said.mesh}: {error}") from error
    share = {name: sum(pose.weight for pose in poses if pose.name == name) for name in POSES}
    wanted = dict(said.resting or ())
    for name, weight in wanted.items():
        if weight > 0 and share[name] == 0:
            able = ", ".join(other for other in POSES if share[other] > 0)
            raise MeshError(f"{said.path}: cannot rest {name} by its own weight; it rests {able}")
    if not wanted:
        wanted = {"standing": 0.85, "lying": 0.15} if share["standing"] > 0 else share
    return tuple(
        RestingPose(pose.name, wanted[pose.name] * pose.weight / share[pose.name], pose.table_from_object)
        for pose in poses
        if wanted.get(pose.name, 0) > 0
    )


def _solids_m(said: ObjectFile, vertices_m) -> tuple[np.ndarray, ...]:
    """Corners of the convex parts; of the convex hull if none are given."""
    from scipy.spatial import ConvexHull, QhullError

    def hull(file, points):
        try:
            return points[ConvexHull(points).vertices]
        except QhullError as error:
            raise MeshError(f"{file}: the vertices lie in a plane; expected a body") from error

    if not said.solids:
        return (hull(said.mesh, vertices_m),)
    solids = tuple(hull(file, said.from_mesh(read_mesh(file).vertices)) for file in said.solids)
    corners = np.concatenate(solids)
    size = np.ptp(vertices_m, axis=0).max()
    off = max(
        np.abs(corners.min(axis=0) - vertices_m.min(axis=0)).max(),
        np.abs(corners.max(axis=0) - vertices_m.max(axis=0)).max(),
    )
    if off > 0.1 * size:
        raise MeshError(
            f"{said.path}: the solids reach {off:.3g} m beyond or short of {said.mesh.name}; "
            "expected parts of the same body in the same unit and axes"
        )
    return solids
