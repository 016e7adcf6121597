#!/usr/bin/env python3
"""The fixed sets of rendered scenes that the benchmarks measure on: made again from their seeds, and proved.

Each set is a command of `python -m graspctx.sim make`. `make` makes it anew, `verify` compares it with the
checksums in datasets.json, `record` writes them there after the generator has changed.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import sys
from dataclasses import dataclass
from pathlib import Path

from graspctx.sim.__main__ import main as graspctx_sim
from graspctx.sim.checksum import files_checksum, scenes_checksum
from graspctx.sim.stored import DatasetError, read_header, scene_folders

RECORDS = Path(__file__).with_suffix(".json")
TRAINED = "mug,pencil,wineglass,bowl,eraser,box,book"
TRAINING_SEEDS = {
    "mug": 7771348,
    "pencil": 7771302,
    "wineglass": 7771736,
    "bowl": 7771173,
    "eraser": 7771166,
    "box": 7771350,
    "book": 7771182,
}
UNTRAINED = "cup,can,bottle,teapot,hammer,screwdriver,spoon,fryingpan"
LOW = "pencil,eraser,spoon,screwdriver"
MESHES = ",".join(sorted(map(str, Path(__file__).parent.glob("new_shapes/*.json"))))


@dataclass(frozen=True)
class FixedSet:
    """What a set is for, and the options of `make` that make it."""

    purpose: str
    scenes: int
    seed: int
    families: str
    options: str = "--split test"


SETS = {
    "smoke": FixedSet(
        "a few small scenes, to see that everything runs",
        scenes=6,
        seed=101,
        families="mug,pencil,wineglass",
        options="--objects 1-3 --resolution 320x240 --split test",
    ),
    **{
        f"training_{family}": FixedSet(
            f"what the shipped model {family} is trained on",
            scenes=1000 if family == "mug" else 600,  # mugs are the hardest
            seed=seed,
            families=family,
            options="--split train",
        )
        for family, seed in TRAINING_SEEDS.items()
    },
    "validation": FixedSet(
        "for choices, so that the test sets stay unseen",
        scenes=210,
        seed=103,
        families=TRAINED,
        options="--split validation",
    ),
    "grasp_points": FixedSet(
        "grasp points on new instances of trained classes, 60 of each",
        scenes=420,
        seed=104,
        families=TRAINED,
    ),
    "new_shapes": FixedSet(
        "grasp points on classes that no model is trained on, 30 of each",
        scenes=240,
        seed=105,
        families=UNTRAINED,
    ),
    "new_meshes": FixedSet(
        "the same on meshes, 10 of each; the variable GRASPCTX_MESHES names their folder",
        scenes=120,
        seed=109,
        families=MESHES,
    ),
    "segmentation": FixedSet(
        "one object, 10 of every class, on as many textured, faint and uniform tables",
        scenes=150,
        seed=106,
        families=f"{TRAINED},{UNTRAINED}",
        options="--axis table=textured,faint,uniform --split test",
    ),
    "clutter": FixedSet(
        "three to six objects, some hiding others",
        scenes=90,
        seed=107,
        families=f"{TRAINED},{UNTRAINED}",
        options="--objects 3-6 --split test",
    ),
    "hard": FixedSet(
        "one to four objects where everything that makes stereo fail happens",
        scenes=90,
        seed=110,
        families=f"{TRAINED},{UNTRAINED}",
        options="--difficulty hard --objects 1-4 --split test",
    ),
    "low": FixedSet("objects that lie lower than 2 cm, 20 of each", scenes=80, seed=108, families=LOW),
}


def build_parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    parser = argparse.ArgumentParser(
        description="Make and prove the fixed sets of rendered scenes.",
        epilog="exit codes: 0 done, 2 wrong usage, 3 OUT cannot be used or is not the set that was recorded",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    commands.add_parser("list", help="print the sets and the commands that make them")
    for name, text in (
        ("make", "render a set; goes on with one that was interrupted"),
        ("verify", "compare a set with what was recorded"),
        ("record", "write a set's checksums to datasets.json"),
    ):
        command = commands.add_parser(name, help=text)
        command.add_argument("name", metavar="NAME", choices=SETS, help=", ".join(SETS))
        command.add_argument("out", metavar="OUT", type=Path, help="the set's folder")
        if name == "make":
            command.add_argument("--scenes", metavar="N", type=int, help="another number of scenes")
            command.add_argument(
                "--seed", metavar="S", type=int, help="fresh scenes, of which nothing is recorded"
            )
            command.add_argument("--workers", metavar="W", default="1", help="processes (default: 1)")
            command.add_argument("--scheduler", metavar="ADDRESS", help="render on this Dask cluster instead")
            command.add_argument("--sheet", metavar="PNG", help="also write a contact sheet")
    return parser


def make_arguments(name: str, out: Path, *, scenes: int | None = None, seed: int | None = None) -> list[str]:
    """Arguments of `python -m graspctx.sim` that make a set."""
    fixed = SETS[name]
    scenes, seed = (fixed.scenes if scenes is None else scenes), (fixed.seed if seed is None else seed)
    drawn = ["--scenes", str(scenes), "--seed", str(seed), "--families", fixed.families]
    return ["make", str(out), *drawn, *fixed.options.split()]


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = build_parser().parse_args(arguments)
    if options.command == "list":
        for name, fixed in SETS.items():
            print(f"{name}: {fixed.purpose}")
            print(f"  python -m graspctx.sim {' '.join(make_arguments(name, Path('OUT')))}")
        return 0
    if options.command == "make":
        where = ["--scheduler", options.scheduler] if options.scheduler else ["--workers", options.workers]
        sheet = ["--sheet", options.sheet] if options.sheet else []
        made = make_arguments(options.name, options.out, scenes=options.scenes, seed=options.seed)
        return graspctx_sim([*made, *where, *sheet])
    try:
        found = _describe(options.name, options.out)
        if options.command == "record":
            RECORDS.write_text(
                json.dumps({**_records(), options.name: found}, indent=1, sort_keys=True) + "\n"
            )
            return 0
        return _verify(options.name, options.out, found)
    except (DatasetError, OSError) as error:
        print(f"datasets.py: {error}", file=sys.stderr)
        return 3


def _records() -> dict:
    return json.loads(RECORDS.read_text()) if RECORDS.exists() else {}


def _describe(name: str, out: Path) -> dict:
    """The checksums of a set; DatasetError if it is not the one that the name stands for."""
    fixed, header, scenes = SETS[name], read_header(out), len(scene_folders(out))
    if (header.get("seed"), header.get("scenes"), scenes) != (fixed.seed, fixed.scenes, fixed.scenes):
        raise DatasetError(
            f"{out}: seed {header.get('seed')} and {scenes} of {header.get('scenes')} scenes; "
            f"expected seed {fixed.seed} and {fixed.scenes} scenes, as {name} has"
        )
    return {
        "files": files_checksum(out),
        "scenes": scenes_checksum(out),
        "looks": header.get("looks"),
        "made_with": {
            package: importlib.metadata.version(package) for package in ("mujoco", "numpy", "pillow")
        },
    }


def _verify(name: str, out: Path, found: dict) -> int:
    expected = _records().get(name)
    if expected is None:
        raise DatasetError(
            f"{RECORDS.name}: nothing is recorded of {name}; expected: {Path(__file__).name} record"
        )
    for key in ("files", "scenes"):
        same = found[key] == expected[key]
        print(f"{key:7} {found[key]}  {'as recorded' if same else f'recorded: {expected[key]}'}")
    if found["files"] == expected["files"]:
        return 0
    if found["scenes"] == expected["scenes"]:
        reason = (
            "the scenes that were recorded, but other bytes: rendered or compressed by other versions than "
            f"{', '.join(' '.join(item) for item in expected['made_with'].items())}, or altered"
        )
    else:
        reason = f"other scenes than recorded (looks {found['looks']}, recorded {expected['looks']})"
    print(f"datasets.py: {out}: {reason}", file=sys.stderr)
    return 3


if __name__ == "__main__":
    sys.exit(main())
