"""Command line: `python -m graspctx.sim make OUT --scenes N --seed S`."""

from __future__ import annotations

import argparse
import importlib.util
import sys
import time
from pathlib import Path

from .families import FAMILIES
from .splits import SPLITS

EXAMPLES = """examples:
  python -m graspctx.sim make data/mugs --scenes 200 --seed 1 --families mug --workers 4
  python -m graspctx.sim make data/clutter --scenes 50 --seed 2 --objects 3-5 --sheet clutter.png

The same options give the same files, byte for byte, with any number of workers. Scenes that stand in OUT
already are kept: run again to go on after an interruption, or with a larger N.

exit codes: 0 done, 1 internal error, 2 wrong usage, 3 OUT cannot be used
"""


def _at_least(lowest):
    def parse(text):
        try:
            value = int(text)
        except ValueError:
            value = None
        if value is None or value < lowest:
            raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of at least {lowest}")
        return value

    return parse


def _families(text):
    names = text.split(",")
    for name in names:
        if name not in FAMILIES:
            raise argparse.ArgumentTypeError(f"unknown family '{name}'; known: {', '.join(FAMILIES)}")
    return names


def _count_range(text):
    low, _, high = text.partition("-")
    try:
        value = (int(low), int(high or low))
    except ValueError:
        value = (0, 0)
    if not 1 <= value[0] <= value[1] <= 8:
        raise argparse.ArgumentTypeError(f"'{text}' is not N or N-M with 1 <= N <= M <= 8")
    return value


def _resolution(text):
    width, _, height = text.partition("x")
    try:
        value = (int(width), int(height))
    except ValueError:
        value = (0, 0)
    if not (160 <= value[0] <= 4096 and 120 <= value[1] <= 4096):
        raise argparse.ArgumentTypeError(f"'{text}' is not WIDTHxHEIGHT between 160x120 and 4096x4096")
    return value


def build_parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m graspctx.sim", description="Rendered scenes with known truth."
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    make = commands.add_parser(
        "make",
        help="render a data set of stereo pairs, masks, grasp-region labels and depth",
        description="Render a data set of stereo pairs, masks, grasp-region labels and depth.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    make.add_argument("out", metavar="OUT", type=Path, help="folder to write; made if missing")
    make.add_argument("--scenes", metavar="N", type=_at_least(1), required=True, help="number of scenes")
    make.add_argument(
        "--seed", metavar="S", type=_at_least(0), required=True, help="seed of the whole data set"
    )
    make.add_argument(
        "--families",
        metavar="A,B",
        type=_families,
        default=list(FAMILIES),
        help=f"object families, in turn (default: {','.join(FAMILIES)})",
    )
    make.add_argument(
        "--objects", metavar="N[-M]", type=_count_range, default=(1, 1), help="objects a scene (default: 1)"
    )
    make.add_argument(
        "--resolution",
        metavar="WxH",
        type=_resolution,
        default=(640, 480),
        help="image size (default: 640x480)",
    )
    make.add_argument(
        "--split",
        choices=SPLITS,
        default="train",
        help="draw shapes and textures of this split; sets of two splits share none (default: train)",
    )
    make.add_argument("--workers", metavar="W", type=_at_least(1), default=1, help="processes (default: 1)")
    make.add_argument(
        "--sheet", metavar="PNG", type=Path, help="also write a contact sheet of the first scenes"
    )
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = build_parser().parse_args(arguments)
    missing = [name for name in ("mujoco", "PIL", "tqdm") if importlib.util.find_spec(name) is None]
    if missing:
        print(f"graspctx.sim: {', '.join(missing)} missing: pip install 'graspctx[sim]'", file=sys.stderr)
        return 1
    return _make(options)


def _make(options) -> int:
    from tqdm import tqdm

    from .dataset import DatasetError, make_dataset
    from .sheet import write_sheet

    start = time.perf_counter()
    bar = tqdm(total=options.scenes, unit="scene", file=sys.stderr, disable=not sys.stderr.isatty())
    try:
        with bar:
            make_dataset(
                options.out,
                options.scenes,
                options.seed,
                families=options.families,
                objects=options.objects,
                image_size=options.resolution,
                split=options.split,
                workers=options.workers,
                progress=bar.update,
            )
        if options.sheet:
            write_sheet(options.out, options.sheet)
    except DatasetError as error:
        print(f"graspctx.sim: {error}", file=sys.stderr)
        return 3
    except OSError as error:
        print(f"graspctx.sim: {error.filename or options.out}: {error.strerror or error}", file=sys.stderr)
        return 3
    seconds = time.perf_counter() - start
    print(
        f"{options.scenes} scenes in {seconds:.1f} s ({options.scenes / seconds:.1f} scenes/s)",
        file=sys.stderr,
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
