"""Where scenes are rendered: in this process, in worker processes, or by the workers of a Dask cluster.

Workers hand back the bytes of a scene's files; only the process that asked for them writes. So workers need
no shared folder, and a killed run leaves whole scenes.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import functools
import itertools
import logging
import multiprocessing
import os
import re
import signal
import threading
from collections.abc import Callable, Iterator, Sequence

from .gl import choose_gl
from .render import Renderer
from .scene import draw_scene
from .scene_files import LOOKS, encode_scene

CONNECT_SECONDS = 5
_WAITING_PER_WORKER = 4  # keeps every worker busy while the finished scenes wait to be written


class WorkerError(Exception):
    """No worker can be had, or one was lost; the message says what to do."""


Render = Callable[[dict, Sequence[int]], Iterator[tuple[int, dict[str, bytes]]]]
"""Takes the arguments of draw_scene, all but the index, and indices; yields (index, {file name: content}) of
every scene, in whatever order they are finished."""


@contextlib.contextmanager
def scene_renderer(workers: int = 1, scheduler: str | None = None) -> Iterator[Render]:
    """A context that holds what renders scenes, and gives a Render.

    Args:
        workers: processes; 1 renders in this one.
        scheduler: address of a Dask scheduler, such as "tcp://10.0.0.1:8786"; its workers render instead.

    Raises:
        WorkerError: the cluster cannot be used, or, while rendering, a worker was lost.
    """
    if scheduler is not None:
        with _cluster(scheduler) as (client, executor):
            yield functools.partial(_spread_on_cluster, client, executor)
    elif workers > 1:
        with _processes(workers) as executor:
            yield functools.partial(_spread, executor, workers * _WAITING_PER_WORKER)
    else:
        with Renderer() as renderer:
            yield functools.partial(_render_in_turn, renderer)


def _render_in_turn(renderer, drawn_from, indices):
    for index in indices:
        scene = draw_scene(index=index, **drawn_from)
        yield index, encode_scene(scene, *renderer.render(scene))


def _spread(executor, most_waiting, drawn_from, indices):
    """Keep `most_waiting` scenes in the executor's hands; yield them as they come back."""
    coming, waiting = iter(indices), set()
    try:
        while True:
            for index in itertools.islice(coming, most_waiting - len(waiting)):
                waiting.add(executor.submit(_render_one, drawn_from, LOOKS, index))
            if not waiting:
                return
            done, waiting = concurrent.futures.wait(waiting, return_when=concurrent.futures.FIRST_COMPLETED)
            for future in done:
                yield future.result()
    finally:
        for future in waiting:
            future.cancel()


def _spread_on_cluster(client, executor, drawn_from, indices):
    # Sent once: users' meshes take megabytes.
    sent = client.scatter([drawn_from], broadcast=True)[0]
    return _spread(executor, sum(client.nthreads().values()) * _WAITING_PER_WORKER, sent, indices)


_renderer: Renderer | None = None
_graphics = concurrent.futures.ThreadPoolExecutor(1, thread_name_prefix="graphics")
"""A graphics context belongs to the thread that made it, and Dask runs tasks in threads of its choice: so
every scene that a worker process renders goes through this one."""


def _render_one(drawn_from, looks, index):
    if looks != LOOKS:
        raise WorkerError(f"a worker has another graspctx: it makes looks {LOOKS}; expected {looks}")
    scene = draw_scene(index=index, **drawn_from)
    return index, encode_scene(scene, *_graphics.submit(_render_here, scene).result())


def _render_here(scene):
    global _renderer
    if _renderer is None:
        os.environ.setdefault("LP_NUM_THREADS", "1")
        _renderer = Renderer()
    return _renderer.render(scene)


@contextlib.contextmanager
def _processes(count):
    choose_gl()  # once, for all of them
    # Mesa would start a thread for every core in every process.
    os.environ.setdefault("LP_NUM_THREADS", "1")
    executor = concurrent.futures.ProcessPoolExecutor(
        count, multiprocessing.get_context("spawn"), initializer=_start_process
    )
    try:
        yield executor
    except concurrent.futures.process.BrokenProcessPool as error:
        raise WorkerError("a worker process died (out of memory?)") from error
    finally:
        executor.shutdown(cancel_futures=True)


def _start_process():
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent is interrupted and stops us

    def follow_parent():
        multiprocessing.parent_process().join()
        os._exit(1)  # it was killed: nobody will take our scenes

    threading.Thread(target=follow_parent, daemon=True).start()


@contextlib.contextmanager
def _cluster(address):
    """(client, executor) of a Dask cluster that has workers."""
    try:
        import distributed
    except ImportError as error:
        raise WorkerError(
            "a Dask cluster needs dask.distributed, which is missing: pip install 'graspctx[sim,dask]'"
        ) from error
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # what we raise says it in one line
    if not re.fullmatch(r"((tcp|tls|ucx|ws|wss)://)?[^/\s]+:\d+", address):
        raise WorkerError(f"'{address}': not the address of a Dask scheduler; expected HOST:PORT")
    try:
        client = distributed.Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        raise WorkerError(f"{address}: no Dask scheduler answers there; expected one that runs") from error
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECT_SECONDS)
        except (TimeoutError, asyncio.TimeoutError) as error:  # two before Python 3.11
            raise WorkerError(
                f"{address}: the cluster has no workers; start one: dask worker {address}"
            ) from error
        with client.get_executor(pure=False) as executor:
            try:
                yield client, executor
            except ImportError as error:
                raise WorkerError(
                    f"{address}: a worker cannot render ({error}); install graspctx[sim] for every worker"
                ) from error
            except (concurrent.futures.CancelledError, distributed.scheduler.KilledWorker) as error:
                raise WorkerError(f"{address}: the cluster's scheduler or workers died") from error
