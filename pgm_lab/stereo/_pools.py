"""Who does the tasks: this process, several, or a cluster; and again on failure.

All three are used as `concurrent.futures.Executor` is, and by the same loop.
"""

import errno
import multiprocessing
import os
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from typing import Any, NamedTuple, Protocol

import cv2


class Outcome(NamedTuple):
    """How a task ended."""

    task: Any
    result: Any
    error: BaseException | None
    attempts: int


class Pool(Protocol):
    """Workers, how many tasks they hold at once, and which error tells of a death.

    And whether a task is tried again that killed its worker all by itself.
    """

    deaths: tuple[type[BaseException], ...]
    again: bool

    @property
    def width(self) -> int:
        """Tasks under way at once."""

    def submit(self, work: Callable, task: Any) -> Future:
        """Hand a task to a worker."""

    def close(self) -> None:
        """Drop what has not begun."""


class Serial:
    """The process that asks, one task after the other."""

    deaths: tuple[type[BaseException], ...] = ()
    again, width = False, 1

    def submit(self, work: Callable, task: Any) -> Future:
        """Do it now."""
        future: Future = Future()
        try:
            future.set_result(work(task))
        except Exception as error:
            traceback.clear_frames(error.__traceback__)  # or photos stay open
            future.set_exception(error)
        return future

    def close(self) -> None:
        """Nothing waits."""


class Processes:
    """Processes of this computer; when one dies, all are started anew."""

    deaths: tuple[type[BaseException], ...] = (BrokenExecutor,)
    again = True

    def __init__(self, workers: int) -> None:
        self.width = workers
        self._start()
        try:
            self.pool.submit(os.getpid).result()
        except BrokenExecutor:
            raise RuntimeError(
                "no worker process could start. In a script, plot_block has to stand"
                ' under `if __name__ == "__main__":`, since each worker imports the'
                " script; or plot with workers=1"
            ) from None

    def _start(self) -> None:
        self.pool = ProcessPoolExecutor(
            self.width,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=cv2.setNumThreads,  # a core each is enough
            initargs=(1,),
        )

    def submit(self, work: Callable, task: Any) -> Future:
        """Hand a task to a process."""
        try:
            return self.pool.submit(work, task)
        except BrokenExecutor:
            self.pool.shutdown()
            self._start()
            return self.pool.submit(work, task)

    def close(self) -> None:
        """Wait for what runs."""
        self.pool.shutdown(cancel_futures=True)


def run(
    work: Callable, tasks: Sequence[Any], pool: Pool, retries: int
) -> Iterator[Outcome]:
    """Do all tasks, a failed one again at the end; yield each when it is done with.

    When a worker dies, nobody knows which of the tasks under way killed it. Each of
    them is tried again by itself, and only there a death counts as a failure.

    Raises
    ------
    OSError
        If the disk is full.
    ConnectionError
        If the cluster is lost.
    """
    waiting = deque((task, 1) for task in tasks)
    running: dict[Future, tuple[Any, int, bool]] = {}
    suspects: deque[tuple[Any, int]] = deque()
    try:
        while waiting or running or suspects:
            if suspects and not running:
                task, attempt = suspects.popleft()
                running[pool.submit(work, task)] = task, attempt, True
            while waiting and not suspects and len(running) < pool.width:
                if any(alone for *_, alone in running.values()):
                    break
                task, attempt = waiting.popleft()
                running[pool.submit(work, task)] = task, attempt, pool.width == 1
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                task, attempt, alone = running.pop(future)
                error = _error(future)
                died = isinstance(error, pool.deaths)
                if died and not alone:
                    suspects.append((task, attempt))
                elif died and pool.again and attempt <= retries:
                    suspects.append((task, attempt + 1))
                elif error is not None and not died and attempt <= retries:
                    waiting.append((task, attempt + 1))
                else:
                    result = None if error else future.result()
                    yield Outcome(task, result, error, attempt)
    finally:
        pool.close()


def _error(future: Future) -> BaseException | None:
    if future.cancelled():
        raise ConnectionError(
            "the cluster was lost. What it has plotted is in the folder: call again to"
            " go on"
        )
    error = future.exception()
    if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
        raise OSError(
            error.errno,
            "the disk is full. What was plotted is in the folder: make room and call"
            " again to go on",
        ) from error
    return error
