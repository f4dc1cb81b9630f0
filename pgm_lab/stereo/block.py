"""A block of photos: many pairs as tasks, here or on a cluster, and one surface."""

import inspect
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import __version__, _validate
from pgm_lab.camera.photo import Photo
from pgm_lab.stereo._folder import belongs, existing, on_disk
from pgm_lab.stereo._merge import MERGES, merge
from pgm_lab.stereo._pools import Pool, Processes, Serial, run
from pgm_lab.stereo._tasks import Task, plot_pair, plotted
from pgm_lab.stereo.dense import match_dense
from pgm_lab.stereo.grid import Surface
from pgm_lab.stereo.photo_file import PhotoFile, fingerprint, photo_list


@dataclass(frozen=True)
class PlottedPair:
    """How the plotting of one pair ended.

    Attributes
    ----------
    left, right : int
        Indices of the photos.
    status : {"plotted", "found", "failed"}
        "found" was plotted by an earlier run from the same photos and numbers.
    points : int
        Matched points; 0 if it failed.
    seconds : float
        On its worker; NaN unless plotted in this run.
    attempts : int
        How often it was tried in this run.
    reason : str
        Why it failed; empty if it did not.
    file : Path
        Its surface: NPZ with `z`, `weight` and `box`.
    """

    left: int
    right: int
    status: str
    points: int
    seconds: float
    attempts: int
    reason: str
    file: Path


@dataclass(frozen=True, eq=False)
class Block:
    """Surface of a block of photos, and what became of its pairs.

    Attributes
    ----------
    surface : Surface
        Of all pairs that did not fail. More than 10^8 cells stay in the folder and are
        read from there as they are needed.
    pairs : tuple of PlottedPair
        In the order given.
    files : tuple of Path
        Surface files: `z.npy` and `measured.npy`, then those of the pairs.
    """

    surface: Surface = field(repr=False)
    pairs: tuple[PlottedPair, ...] = field(repr=False)
    files: tuple[Path, ...] = field(repr=False)

    @property
    def failed(self) -> tuple[PlottedPair, ...]:
        """The pairs that failed, each with its reason."""
        return tuple(pair for pair in self.pairs if pair.status == "failed")


def plot_block(
    photos: Sequence[Photo | PhotoFile],
    pairs: ArrayLike,
    folder: str | os.PathLike,
    *,
    heights: tuple[float, float],
    cell: float,
    matching: Mapping[str, Any] | None = None,
    merging: str = "mean",
    workers: int | None = None,
    client: Any = None,
    retries: int = 1,
    overwrite: bool = False,
    progress: bool = True,
) -> Block:
    """Plot many pairs, each once, and merge their surfaces.

    Each pair is a task: `epipolar_pair`, `match_dense`, `intersect` and `surface`, and
    the heights go into a file of the folder. It is written whole or not at all, so that
    a run that was stopped goes on where it was: the same call plots what is missing.
    (Whoever changes `pgm_lab` itself takes a new folder.) All cells lie on one grid,
    with edges at whole multiples of `cell`. The result is the same to the last bit,
    whoever does the tasks and whichever is ready first.

    A worker is sent names of files, orientations and a few numbers, 1 kB a pair. Photos
    in memory are written into the folder first; a `PhotoFile` spares the disk a copy.
    Workers of a cluster have to see the folder and the photos under the same names.

    Parameters
    ----------
    photos : sequence of Photo or PhotoFile
        Oriented photos.
    pairs : array_like (n, 2) of int
        Indices of left and right photo of each pair, as of `neighbours`.
    folder : path
        Where the files go; it has to exist.
    heights : (low, high)
        Least and greatest Z of ground and objects, in m; points beyond are dropped.
    cell : float
        Side of a cell, in m.
    matching : mapping, optional
        Arguments of `match_dense`, such as ``{"window": 9}``.
    merging : {"mean", "median"}
        Of the measured heights where pairs overlap; the mean is weighted by 1 / sd^2.
    workers : int, optional
        Processes of this computer, one a core when missing; 1 is this process alone.
        Each needs the memory of a pair.
    client : dask.distributed.Client or str, optional
        A cluster, or the address of its scheduler, instead of processes.
    retries : int
        How often a pair that failed is tried again.
    overwrite : bool
        Take a folder of other photos or numbers, and plot anew what differs.
    progress : bool
        Show a bar.

    Returns
    -------
    Block

    Raises
    ------
    FileNotFoundError
        If the folder is missing.
    FileExistsError
        If the folder holds other things, or a block of other photos or numbers.
    ValueError
        If pairs are none or do not fit, or if all of them failed.
    ImportError
        If a client is given and dask.distributed is not installed.
    ConnectionError
        If the cluster does not answer, has no worker, or is lost.
    OSError
        If the disk is full.
    """
    photos = photo_list(photos)
    indices = _indices(pairs, len(photos))
    cell = _validate.positive_number(cell, "cell", "m")
    low, high = _validate.of_shape(heights, (2,), "heights").tolist()
    if not low < high:
        raise ValueError(
            f"heights must be (low, high) with low < high; got ({low:g}, {high:g})"
        )
    _validate.choice(merging, "merging", MERGES)
    retries = _validate.whole(retries, "retries", 0)
    workers = _cores() if workers is None else _validate.whole(workers, "workers", 1)
    progress = _validate.flag(progress, "progress")
    matching = dict(_validate.mapping({} if matching is None else matching, "matching"))
    if unknown := set(matching) - set(inspect.signature(match_dense).parameters):
        raise ValueError(f"matching has no argument of match_dense: {unknown.pop()}")
    parameters = {
        "heights": [low, high],
        "cell": cell,
        "matching": matching,
        "pgm_lab": __version__,
    }
    folder = existing(folder)
    files, prints = on_disk(photos, np.unique(indices).tolist(), folder)
    belongs(folder, parameters, prints, _validate.flag(overwrite, "overwrite"))
    tasks = [
        Task(
            (i, j),
            files[i],
            files[j],
            (low, high),
            cell,
            matching,
            fingerprint(parameters, prints[i], prints[j]),
            folder / f"pair_{i:05d}_{j:05d}.npz",
        )
        for i, j in indices.tolist()
    ]
    done = _found(tasks)
    missing = [task for task in tasks if task.pair not in done]
    if missing:
        pool = _pool(client, min(workers, len(missing)), folder)
        done |= _plot(missing, pool, retries, progress, len(done))
    table = tuple(done[task.pair] for task in tasks)
    good = [pair.file for pair in table if pair.status != "failed"]
    if not good:
        raise ValueError(
            f"none of the {len(table)} pair(s) could be plotted; the first,"
            f" ({table[0].left}, {table[0].right}): {table[0].reason}"
        )
    merged = merge(good, cell, folder, merging)
    return Block(merged, table, (folder / "z.npy", folder / "measured.npy", *good))


def _cores() -> int:
    """Cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _pool(client: Any, workers: int, folder: Path) -> Pool:
    if client is not None:
        from pgm_lab.stereo._cluster import Cluster

        return Cluster(client, folder)
    return Serial() if workers == 1 else Processes(workers)


def _plot(tasks, pool, retries, progress, found):
    """Rows of the table for tasks, by their pair."""
    from tqdm.auto import tqdm

    rows = {}
    total = found + len(tasks)
    with tqdm(total=total, initial=found, unit="pair", disable=not progress) as bar:
        for task, result, error, attempts in run(plot_pair, tasks, pool, retries):
            if error is None:
                points, seconds = result
                row = _row(task, "plotted", points, seconds, attempts)
            else:
                reason = f"{type(error).__name__}: {error}"
                row = _row(task, "failed", attempts=attempts, reason=reason)
            rows[task.pair] = row
            bar.update()
    return rows


def _found(tasks):
    """Rows of the table for tasks whose file is there, by their pair."""
    points = {task.pair: plotted(task) for task in tasks}
    return {
        task.pair: _row(task, "found", points[task.pair])
        for task in tasks
        if points[task.pair] is not None
    }


def _row(task, status, points=0, seconds=np.nan, attempts=0, reason=""):
    left, right = task.pair
    return PlottedPair(
        left, right, status, points, seconds, attempts, reason, task.file
    )


def _indices(pairs, n):
    pairs = _validate.numeric(pairs, "pairs")
    if not pairs.size:
        raise ValueError("pairs is empty: no photos share enough of the ground")
    if pairs.ndim != 2 or pairs.shape[1] != 2:
        raise ValueError(
            "pairs must have shape (n, 2), (left, right) in each row; got shape"
            f" {pairs.shape}"
        )
    pairs = _validate.indices(pairs.ravel(), n, "pairs").reshape(-1, 2)
    if np.any(pairs[:, 0] == pairs[:, 1]):
        raise ValueError("pairs has a photo paired with itself")
    if len(np.unique(pairs, axis=0)) < len(pairs):
        raise ValueError("pairs has the same pair more than once")
    return pairs
