"""Workers of a dask.distributed cluster."""

import math
import socket
import time
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from pathlib import Path
from typing import Any

from pgm_lab import _validate
from pgm_lab.stereo._folder import LIST
from pgm_lab.stereo._tasks import plotted

PATIENCE = 10  # seconds: for a scheduler, for a first worker, for an answer
RECOUNT = 1.0  # seconds; asking costs more than a task
AHEAD = 2  # tasks for each thread, so that none waits for the next


class Cluster:
    """Workers of a cluster, each task whole on one of them.

    Dask itself gives a task whose worker died to another, three times. A worker may die
    when its task has ended and nobody has fetched the answer yet: then Dask may wait
    for ever, and its own executor too. Here the file of the pair is an answer as well.
    """

    again = False  # after a death

    def __init__(self, client: Any, folder: Path) -> None:
        try:
            from distributed import Client, KilledWorker
        except ImportError:
            raise ImportError(
                "a cluster needs dask.distributed: pip install dask distributed"
            ) from None
        self.deaths: tuple[type[BaseException], ...] = (KilledWorker,)
        self.own = isinstance(client, str)
        self.client = _connected(Client, client) if self.own else client
        try:
            _validate.instance(self.client, Client, "client")
            self._ready(folder)
        except BaseException:
            self._leave()
            raise
        self.running: set[Any] = set()
        self.threads, self.counted = 0, -math.inf

    def _ready(self, folder: Path) -> None:
        """Refuse a cluster without workers, or whose workers do not see the folder."""
        if self.client.status != "running":
            raise ConnectionError("the client of the cluster is closed; make a new one")
        try:
            self.client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise ConnectionError("the cluster has no worker; start one") from None
        try:
            seen = self.client.run(_sees, folder / LIST)
        except ImportError as error:
            raise ImportError(
                f"the workers of the cluster lack what is here: {error}"
            ) from error
        blind = [address for address, sees in seen.items() if not sees]
        if blind:
            raise FileNotFoundError(
                f"worker {blind[0]} does not see {folder}: put folder and photos on a"
                " disk that all workers have under the same name"
            )

    @property
    def width(self) -> int:
        """Tasks to hand out: workers may come and go, so they are counted again."""
        if time.monotonic() - self.counted > RECOUNT:
            self.threads = sum(self.client.nthreads().values())
            self.counted = time.monotonic()
        return max(1, AHEAD * self.threads)

    def submit(self, work: Callable, task: Any) -> Future:
        """Hand a task to the scheduler."""
        answer: Future = Future()
        given = self.client.submit(work, task, pure=False)
        self.running.add(given)
        given.add_done_callback(lambda done: self._pass_on(done, task, answer))
        return answer

    def _pass_on(self, done: Any, task: Any, answer: Future) -> None:
        try:
            answer.set_result(done.result(timeout=PATIENCE))
        except TimeoutError as error:
            if (points := plotted(task)) is not None:
                answer.set_result((points, float("nan")))
            else:
                answer.set_exception(error)
        except CancelledError:
            answer.cancel()
            answer.set_running_or_notify_cancel()
        except BaseException as error:
            answer.set_exception(error)
        self.running.discard(done)

    def close(self) -> None:
        """Take back what has not begun, and leave a cluster that we came to."""
        self.client.cancel(list(self.running))
        self._leave()

    def _leave(self) -> None:
        if self.own:
            self.client.close()


def _connected(Client, address):
    """Client of a scheduler; whether anybody answers is tried first, as it is quick."""
    from distributed.comm import get_address_host_port

    try:
        socket.create_connection(get_address_host_port(address), PATIENCE).close()
        return Client(address, timeout=PATIENCE, set_as_default=False)
    except Exception as error:  # whatever another program answers there
        raise ConnectionError(
            f"no scheduler of dask answers at {address!r} ({type(error).__name__})"
        ) from error


def _sees(path: Path) -> bool:
    """Whether a worker, which runs this, sees a file."""
    return path.is_file()
