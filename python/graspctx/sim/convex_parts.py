"""Divide a mesh into convex parts, so that physics sees its hollows and handles."""

from __future__ import annotations

from pathlib import Path

from .user_mesh import MeshError, ObjectFile, read_mesh

CONCAVITY = 0.05
"""How deep a hollow may be that is filled, relative to the object: CoACD's own default."""


def write_convex_parts(said: ObjectFile, folder: Path) -> int:
    """Write the parts as part00.stl and so on, in the mesh's own unit; returns their number.

    Raises:
        MeshError: CoACD is not installed, or `folder` holds such files already.
    """
    try:
        import coacd
    except ImportError as error:
        raise MeshError("coacd is missing: pip install coacd") from error
    import trimesh

    if any(folder.glob("part*.stl")):
        raise MeshError(f"{folder}: holds part*.stl already; expected a new or empty folder")
    body = read_mesh(said.mesh)
    coacd.set_log_level("error")
    parts = coacd.run_coacd(coacd.Mesh(body.vertices, body.faces), threshold=CONCAVITY, seed=0)
    folder.mkdir(parents=True, exist_ok=True)
    for index, (vertices, faces) in enumerate(parts):
        trimesh.Trimesh(vertices, faces, process=False).export(folder / f"part{index:02d}.stl")
    return len(parts)
