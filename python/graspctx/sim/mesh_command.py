"""The command `python -m graspctx.sim mesh`: what a user needs to see to get an object file right."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from .user_mesh import MESHES_VARIABLE, build_object, read_object_file, region_share

MESHES_HELP = f"folder of meshes that do not lie beside their object file (default: ${MESHES_VARIABLE})"

EXAMPLES = """examples:
  python -m graspctx.sim mesh my_mug.json --picture my_mug.png
  python -m graspctx.sim mesh my_mug.json --write-solids parts

The picture shows the object from eight sides with the grasp region in red; its rulers count in the mesh's own
unit and axes, those of the boxes in the object file. docs/own-objects.md goes through it step by step.

exit codes: 0 done, 1 internal error, 2 wrong usage, 3 the object file or its mesh cannot be used
"""


def add_mesh_command(commands) -> None:
    """Add `mesh` to the subparsers of the command line."""
    mesh = commands.add_parser(
        "mesh",
        help="look at a mesh of your own: size, grasp region, resting poses",
        description="Look at a mesh of your own: size, grasp region, resting poses.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    mesh.add_argument("object_file", metavar="OBJECT.json", type=Path, help="the object file")
    mesh.add_argument("--meshes", metavar="DIR", type=Path, help=MESHES_HELP)
    mesh.add_argument("--picture", metavar="PNG", type=Path, help="write a picture from eight sides")
    mesh.add_argument(
        "--write-solids",
        metavar="DIR",
        type=Path,
        help="divide the mesh into convex parts for physics (needs coacd) and write them as DIR/part*.stl",
    )
    mesh.set_defaults(run=run_mesh_command, needs=("mujoco", "PIL", "scipy", "trimesh"))


def run_mesh_command(options) -> int:
    """Run `mesh`; returns the exit code."""
    said = read_object_file(options.object_file, options.meshes)
    shape = build_object(said)
    print(describe(said, shape))
    if options.picture:
        from .mesh_picture import write_picture

        write_picture(said, shape, options.picture)
    if options.write_solids:
        from .convex_parts import write_convex_parts

        count = write_convex_parts(said, options.write_solids)
        print(f"{count} convex parts written: name {options.write_solids}/part*.stl as the file's solids")
    return 0


def describe(said, shape) -> str:
    """What an object file leads to, in a few lines."""
    mesh = shape.mesh
    size = ", ".join(f"{name} {1000 * value:.1f} mm" for name, value in shape.dimensions_m.items())
    in_mesh = said.to_mesh(mesh.vertices_m)
    low, high = in_mesh.min(axis=0), in_mesh.max(axis=0)
    share = region_share(mesh.vertices_m, mesh.faces, mesh.region)
    poses = {}
    for pose in shape.resting_poses:
        count, weight = poses.get(pose.name, (0, 0.0))
        poses[pose.name] = (count + 1, weight + pose.weight)
    total = sum(weight for _, weight in poses.values())
    lines = [
        f"{shape.family}  shape_seed {shape.shape_seed}",
        f"size      {size}",
        f"mesh      {len(mesh.faces)} faces, from ({_numbers(low)}) to ({_numbers(high)}) in its own unit",
        f"region    {shape.region_name}: {100 * share:.1f} % of the surface",
        "rests     "
        + ", ".join(
            f"{name} {100 * weight / total:.0f} % ({count} way{'s' if count > 1 else ''})"
            for name, (count, weight) in poses.items()
        ),
        f"solids    {len(shape.solids_m)} convex parts"
        if said.solids
        else "solids    the convex hull: physics sees no hollow or handle (see --write-solids)",
    ]
    open_edges = _open_edges(mesh)
    if open_edges:
        lines.append(
            f"note      the surface is not closed: {open_edges} open edges; it is invisible from behind"
        )
    return "\n".join(lines)


def _numbers(values) -> str:
    return ", ".join(f"{value:.4g}" for value in values)


def _open_edges(mesh) -> int:
    edges = np.sort(mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return int((np.unique(edges, axis=0, return_counts=True)[1] == 1).sum())
