"""What the benchmarks share: their options, 95 % intervals, rows and their JSON, tables, progress, processes.

A benchmark is a file of its own, `accuracy/NAME.py` or `runtime/NAME.py`, that anyone can run with the
project's Python. It takes `add_options`, makes rows with `row`, prints `table`s under a line of `ran_on`,
writes `write_json`, and ends by `run`. README.md beside this file says what the benchmarks have in common.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import platform
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures.process import BrokenProcessPool, ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import graspctx as gc
import numpy as np

EXIT_CODES = (
    "exit codes: 0 done, 1 internal error, 2 wrong usage, 3 a file or folder cannot be used, 130 interrupted"
)
_RESAMPLES = 1000
_LINE_SECONDS = 30


class BadInputError(Exception):
    """A file or folder that the user named cannot be used; the message names it and says why."""


# ---- Options and exit codes --------------------------------------------------------------------------------


def at_least(lowest: int) -> Callable[[str], int]:
    """A type for argparse: whole numbers of at least `lowest`."""

    def parse(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = None
        if value is None or value < lowest:
            raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of at least {lowest}")
        return value

    return parse


def parser(program: str, description: str, definitions: str) -> argparse.ArgumentParser:
    """The parser of a benchmark's command line, without options; its help ends with what is measured."""
    return argparse.ArgumentParser(
        prog=program,
        description=description,
        epilog=f"{definitions}\n{EXIT_CODES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def add_options(parser: argparse.ArgumentParser, *, scenes: int, scenes_help: str) -> None:
    """Add what every accuracy benchmark takes: --seed, --scenes, --json, --workers.

    Args:
        scenes: how many are rendered where --scenes does not say.
        scenes_help: what they are counted per.
    """
    parser.add_argument(
        "--seed", metavar="S", type=at_least(0), required=True, help="a fresh seed gives a fresh test set"
    )
    parser.add_argument(
        "--scenes",
        metavar="N",
        type=at_least(1),
        default=scenes,
        help=f"{scenes_help} (default: %(default)s)",
    )
    parser.add_argument("--json", metavar="FILE", type=Path, help="also write the rows to this file")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    parser.add_argument(
        "--workers",
        metavar="W",
        type=at_least(1),
        default=cores,
        help="processes, of one thread each (default: one for each core, here %(default)s)",
    )


def check_place(file: Path | None) -> None:
    """Refuse a place for a file before the work is done that it is to hold: BadInputError."""
    if file is not None and (not file.parent.is_dir() or file.is_dir()):
        raise BadInputError(f"{file}: cannot be written; expected a file name in a folder that exists")


def run(program: str, command: Callable[[], None]) -> int:
    """Run a command and return its exit code; what the user can mend is one line on stderr."""
    try:
        command()
    except KeyboardInterrupt:
        print(f"{program}: interrupted", file=sys.stderr)
        return 130
    except (BadInputError, gc.InvalidInput) as error:
        print(f"{program}: {error}", file=sys.stderr)
        return 3
    except BrokenProcessPool:
        print(f"{program}: a worker process died (out of memory?)", file=sys.stderr)
        return 1
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        print(f"{program}: {where}{error.strerror or error}", file=sys.stderr)
        return 3
    return 0


# ---- Figures -----------------------------------------------------------------------------------------------


class Estimate(NamedTuple):
    """A figure, its 95 % interval (None where there is none), and how many things it is taken over."""

    value: float
    low: float | None
    high: float | None
    n: int


def share(count: int, trials: int) -> Estimate:
    """A share with Wilson's interval. trials > 0."""
    low, high = gc.wilson_interval(int(count), int(trials))
    return Estimate(count / trials, low, high, int(trials))


def bootstrap(values: Sequence | np.ndarray, statistic: Callable = np.median) -> Estimate:
    """A statistic with its percentile interval over 1000 seeded resamples: the same for the same values.

    Args:
        values: (n,), or (n, k) where each of n things brings k values and is drawn as a whole. n > 0.
        statistic: of an array, along `axis`.
    """
    values = np.asarray(values, float)
    rng = np.random.default_rng(0)
    if values.ndim == 1:
        drawn = statistic(values[rng.integers(0, len(values), (_RESAMPLES, len(values)))], axis=1)
    else:
        drawn = [
            statistic(values[rng.integers(0, len(values), len(values))].ravel(), axis=0)
            for _ in range(_RESAMPLES)
        ]
    low, high = np.percentile(drawn, [2.5, 97.5])
    return Estimate(float(statistic(values.ravel(), axis=0)), float(low), float(high), len(values))


def rate(counts: Sequence) -> Estimate:
    """The mean of counts, such as false objects, one for each scene; by bootstrap. Where nothing was counted
    at all, the interval's upper end is that of a Poisson count of none: 3.7 / n."""
    mean = bootstrap(counts, np.mean)
    return mean._replace(high=-np.log(0.025) / mean.n) if mean.value == 0 else mean


def percentile_90(values: np.ndarray, axis: int) -> np.ndarray:
    """A statistic for `bootstrap`."""
    return np.percentile(values, 90, axis=axis)


def row(measure: str, estimate: Estimate, **keys: object) -> dict:
    """A row of a benchmark's JSON: the measure, the keys that say of what, the figure."""
    return {"measure": measure, **keys, **estimate._asdict()}


def write_json(file: Path, benchmark: str, seed: int, rows: list[dict], **more: object) -> None:
    """Write a benchmark's result, all or nothing.

    Args:
        more: what else the file is to say, such as ran_on and the options.
    """
    content = {"benchmark": benchmark, "seed": seed, "ran_on": ran_on(), **more, "rows": rows}
    partial = file.with_name(file.name + ".partial")
    try:
        partial.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n")
        partial.replace(file)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise BadInputError(f"{file}: cannot be written ({error.strerror})") from error


# ---- What is printed ---------------------------------------------------------------------------------------


def number(value: float | None, digits: int = 2) -> str:
    """A number for a table, '-' for None."""
    return "-" if value is None else f"{value:.{digits}f}"


def figure(estimate: Estimate | dict | None, digits: int = 2) -> str:
    """A figure with its interval for a table: '0.93 [0.88, 0.96]'; '-' for None."""
    if estimate is None:
        return "-"
    if isinstance(estimate, dict):
        estimate = Estimate(*(estimate[field] for field in Estimate._fields))
    interval = (
        "" if estimate.low is None else f" [{number(estimate.low, digits)}, {number(estimate.high, digits)}]"
    )
    return number(estimate.value, digits) + interval


def table(names: Sequence[str], rows: Sequence[Sequence[object]], left: int = 1) -> str:
    """A Markdown table that is aligned as text, too; all columns but the first `left` to the right."""
    cells = [[str(cell) for cell in line] for line in (names, *rows)]
    widths = [max(3, *(len(line[column]) for line in cells)) for column in range(len(names))]

    def line(parts):
        padded = (
            part.ljust(width) if column < left else part.rjust(width)
            for column, (part, width) in enumerate(zip(parts, widths))
        )
        return "| " + " | ".join(padded) + " |"

    rule = ["-" * width if column < left else "-" * (width - 1) + ":" for column, width in enumerate(widths)]
    return "\n".join([line(cells[0]), line(rule), *map(line, cells[1:])])


def ran_on() -> str:
    """Versions and machine, in one line."""
    processor = platform.processor() or platform.machine()
    try:
        names = [
            text for text in Path("/proc/cpuinfo").read_text().splitlines() if text.startswith("model name")
        ]
        processor = f"{names[0].partition(':')[2].strip()}, {len(names)} cores"
    except (OSError, IndexError):
        pass
    return (
        f"graspctx {gc.__version__}, Python {platform.python_version()}, numpy {np.__version__}, "
        f"{platform.system()} {platform.machine()}, {processor}"
    )


class Progress:
    """What is done of how much, on stderr: in place on a terminal, elsewhere a line every half minute."""

    def __init__(self, what: str, total: int) -> None:
        self._what, self._total = what, total
        self._start = self._last = time.perf_counter()
        self._in_place = sys.stderr.isatty()

    def show(self, done: int) -> None:
        """Say that `done` of all are done."""
        now = time.perf_counter()
        finished = done >= self._total
        if not finished and now - self._last < (0.2 if self._in_place else _LINE_SECONDS):
            return
        self._last = now
        seconds = now - self._start
        text = f"{self._what}: {done} of {self._total}, {seconds:.0f} s"
        if not finished and done:
            text += f", {seconds * (self._total - done) / done:.0f} s left"
        if self._in_place:
            print(f"\r\033[K{text}", end="\n" if finished else "", file=sys.stderr, flush=True)
        else:
            print(text, file=sys.stderr, flush=True)


# ---- Processes ---------------------------------------------------------------------------------------------


def spread(function: Callable, items: Sequence, workers: int, progress: Progress | None = None) -> Iterator:
    """`function` of each item, in the items' order, by worker processes of one thread; 1 works in this one.

    The function and the items must be picklable: a function of a module, not a lambda.
    """
    if workers > 1 and len(items) > 1:
        with _processes(min(workers, len(items))) as executor:
            yield from _counted(executor.map(function, items), progress)
    else:
        use_one_thread()
        yield from _counted(map(function, items), progress)


def _counted(results: Iterable, progress: Progress | None) -> Iterator:
    for done, result in enumerate(results, 1):
        if progress:
            progress.show(done)
        yield result


def _processes(count: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), initializer=_start_process)


def _start_process() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent is interrupted and stops us

    def follow_parent():
        multiprocessing.parent_process().join()
        os._exit(1)  # it was killed: nobody will take our results

    threading.Thread(target=follow_parent, daemon=True).start()
    use_one_thread()


def use_one_thread() -> None:
    """Let the library compute with one thread in this process, so that times compare.

    OpenCV takes as many threads as the process may use cores when it first needs any: so it is made to need
    them while that is one.
    """
    os.environ.setdefault("LP_NUM_THREADS", "1")  # Mesa, where the process renders
    if not hasattr(os, "sched_setaffinity"):
        return
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(cores)})
    try:
        gc.compute_disparity(*(np.zeros((64, 96), np.uint8),) * 2)
    finally:
        os.sched_setaffinity(0, cores)
