"""Command line: `python -m graspctx.sim make OUT --scenes N --seed S`, and what one asks of a data set."""

from __future__ import annotations

import argparse
import importlib.util
import sys
import time
from pathlib import Path

from .difficulty import CHOICES, DIFFICULTIES, LIMITS, with_axis
from .families import FAMILIES
from .mesh_command import MESHES_HELP, add_mesh_command
from .splits import SPLITS
from .user_mesh import is_object_file, load_object

EXAMPLES = """examples:
  python -m graspctx.sim make data/mugs --scenes 200 --seed 1 --families mug --workers 4
  python -m graspctx.sim make data/clutter --scenes 50 --seed 2 --objects 3-5 --sheet clutter.png
  python -m graspctx.sim make data/test --scenes 300 --seed 1 --split test
  python -m graspctx.sim make data/mine --scenes 50 --seed 3 --families mug,my_mug.json

on a Dask cluster (pip install 'graspctx[sim,dask]'; its scheduler runs what its clients send, so keep it in a
network that you trust):
  dask scheduler --host 127.0.0.1 &
  dask worker 127.0.0.1:8786 --nworkers 2 --nthreads 1 &
  python -m graspctx.sim make data/mugs --scenes 200 --seed 1 --scheduler 127.0.0.1:8786
A worker process renders one scene at a time. Workers send the files back to this process, which writes them:
they need no shared folder.

The same options give the same files, byte for byte, with any number of workers, here or on a cluster of the
same kind of machines. Scenes that stand in OUT already are kept: run the same command again to go on after an
interruption, or with a larger N. OUT gets a data card as well, README.md; stdout gets the checksums.

exit codes: 0 done, 1 internal error, 2 wrong usage, 3 OUT, PNG or ADDRESS cannot be used, 130 interrupted
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
        if name not in FAMILIES and not is_object_file(name):
            raise argparse.ArgumentTypeError(
                f"unknown family '{name}'; known: {', '.join(FAMILIES)}, or the .json file of a mesh"
            )
    return names


def _count_range(text):
    low, _, high = text.partition("-")
    try:
        value = (int(low), int(high or low))
    except ValueError:
        value = (-1, -1)
    if not 0 <= value[0] <= value[1] <= 8:
        raise argparse.ArgumentTypeError(f"'{text}' is not N or N-M with 0 <= N <= M <= 8")
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


def _axis(text):
    try:
        with_axis(DIFFICULTIES["default"], text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return text


def build_parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m graspctx.sim", description="Rendered scenes with known truth."
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_make(commands)
    _add_readers(commands)
    add_mesh_command(commands)
    return parser


def _add_make(commands):
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
        help=f"object families, or object files of meshes (.json), in turn (default: {','.join(FAMILIES)})",
    )
    make.add_argument("--meshes", metavar="DIR", type=Path, help=MESHES_HELP)
    make.add_argument(
        "--objects",
        metavar="N[-M]",
        type=_count_range,
        default=(1, 1),
        help="objects a scene, 0 for an empty table (default: 1)",
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
    make.add_argument(
        "--difficulty",
        choices=list(DIFFICULTIES),
        default="default",
        help="what tables, poses, cameras and sensors are drawn from (default: default)",
    )
    make.add_argument(
        "--axis",
        metavar="AXIS=VALUE",
        type=_axis,
        action="append",
        default=[],
        help="change one axis of it: names with commas between them, a number or a range, such as "
        "table=faint,uniform or occlusion=0.3-0.7; again for another axis. Axes: "
        + ", ".join([*CHOICES, *LIMITS]),
    )
    where = make.add_mutually_exclusive_group()
    where.add_argument("--workers", metavar="W", type=_at_least(1), default=1, help="processes (default: 1)")
    where.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="render on the workers of this Dask scheduler, such as 10.0.0.1:8786, instead of here",
    )
    make.add_argument("--sheet", metavar="PNG", type=Path, help="also write a contact sheet")
    make.set_defaults(run=_make, needs=("mujoco", "PIL", "tqdm", "scipy", "trimesh"))


def _add_readers(commands):
    def add(name, needs, run, text):
        command = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        command.set_defaults(run=run, needs=needs)
        return command

    sheet = add("sheet", ("PIL",), _sheet, "write a contact sheet of a data set")
    sheet.add_argument("dataset", metavar="DATASET", type=Path)
    sheet.add_argument("png", metavar="PNG", type=Path)
    card = add("card", (), _card, "count what a data set holds and write DATASET/README.md")
    card.add_argument("dataset", metavar="DATASET", type=Path)
    checksum = add("checksum", (), _checksum, "print the SHA-256 of a data set's files and of what was drawn")
    checksum.add_argument("dataset", metavar="DATASET", type=Path)
    disjoint = add(
        "disjoint", (), _disjoint, "print the shapes and textures that two data sets share; exit 3 if any"
    )
    disjoint.add_argument("first", metavar="A", type=Path)
    disjoint.add_argument("second", metavar="B", type=Path)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = build_parser().parse_args(arguments)
    missing = [name for name in options.needs if importlib.util.find_spec(name) is None]
    if missing:
        print(f"graspctx.sim: {', '.join(missing)} missing: pip install 'graspctx[sim]'", file=sys.stderr)
        return 1
    from .stored import DatasetError

    try:
        return options.run(options)
    except DatasetError as error:
        print(f"graspctx.sim: {error}", file=sys.stderr)
        return 3
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        print(f"graspctx.sim: {where}{error.strerror or error}", file=sys.stderr)
        return 3


def _make(options) -> int:
    from .card import write_card
    from .dataset import make_dataset
    from .scene import NoViewError
    from .workers import WorkerError

    if options.sheet:
        _check_place(options.sheet)
    families = [
        load_object(name, options.meshes) if is_object_file(name) else name for name in options.families
    ]
    progress = _Progress(options.scenes)
    try:
        with progress:
            make_dataset(
                options.out,
                options.scenes,
                options.seed,
                families=families,
                objects=options.objects,
                image_size=options.resolution,
                split=options.split,
                difficulty=options.difficulty,
                axes=options.axis,
                workers=options.workers,
                scheduler=options.scheduler,
                progress=progress,
            )
    except KeyboardInterrupt:
        print(f"graspctx.sim: interrupted: {progress.state(options.out)}", file=sys.stderr)
        return 130
    except NoViewError as error:
        print(f"graspctx.sim: {error}", file=sys.stderr)
        return 2
    except WorkerError as error:
        state = f": {progress.state(options.out)}" if progress.finished else ""
        print(f"graspctx.sim: {error}{state}", file=sys.stderr)
        return 3
    print(progress.summary(), file=sys.stderr)
    write_card(options.out)
    if options.sheet:
        from .sheet import write_sheet

        write_sheet(options.out, options.sheet)
    options.dataset = options.out
    return _checksum(options)


class _Progress:
    """A bar where stderr is a terminal; elsewhere a line every half minute."""

    LINE_SECONDS = 30

    def __init__(self, total):
        from tqdm import tqdm

        self.finished, self.kept, self.total = 0, 0, total
        self._bar = tqdm(total=total, unit="scene", file=sys.stderr, disable=not sys.stderr.isatty())
        self._start = self._last_line = time.perf_counter()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._bar.close()

    def __call__(self, finished, kept):
        if finished == kept:  # the start: scenes that stood there took no time
            self._start = self._last_line = time.perf_counter()
            self._bar.initial = kept
            self._bar.reset()
        self.finished, self.kept = finished, kept
        self._bar.update(finished - self._bar.n)
        now = time.perf_counter()
        if self._bar.disable and now - self._last_line > self.LINE_SECONDS:
            self._last_line = now
            seconds_left = (self.total - finished) * (now - self._start) / (finished - kept)
            print(
                f"{finished} of {self.total} scenes, {self._per_second():.1f} scenes/s, "
                f"{seconds_left / 60:.1f} min left",
                file=sys.stderr,
                flush=True,
            )

    def _per_second(self):
        return (self.finished - self.kept) / max(time.perf_counter() - self._start, 1e-9)

    def summary(self):
        if self.finished == self.kept:
            return f"all {self.total} scenes stood there already"
        before = f" ({self.kept} stood there already)" if self.kept else ""
        seconds = time.perf_counter() - self._start
        return (
            f"{self.finished - self.kept} scenes in {seconds:.1f} s "
            f"({self._per_second():.1f} scenes/s){before}"
        )

    def state(self, out):
        return f"{self.finished} of {self.total} scenes stand in {out}; run the same command again to go on"


def _check_place(file):
    """Refuse a place for a file before the work is done that it is to hold."""
    from .stored import DatasetError

    if not file.parent.is_dir() or file.is_dir():
        raise DatasetError(f"{file}: cannot be written; expected a file name in a folder that exists")


def _sheet(options) -> int:
    from .sheet import write_sheet

    write_sheet(options.dataset, options.png)
    return 0


def _card(options) -> int:
    from .card import write_card

    print(write_card(options.dataset))
    return 0


def _checksum(options) -> int:
    from .checksum import files_checksum, scenes_checksum

    print(f"files   {files_checksum(options.dataset)}")
    print(f"scenes  {scenes_checksum(options.dataset)}")
    return 0


def _disjoint(options) -> int:
    from .splits import shared_seeds
    from .stored import read_scenes

    shared = shared_seeds(read_scenes(options.first), read_scenes(options.second))
    for family, seed in shared["shapes"]:
        print(f"shape    {family} {seed}")
    for seed in shared["textures"]:
        print(f"texture  {seed}")
    if any(shared.values()):
        print(
            f"graspctx.sim: {options.first} and {options.second}: share {len(shared['shapes'])} shapes and "
            f"{len(shared['textures'])} textures; expected none",
            file=sys.stderr,
        )
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
