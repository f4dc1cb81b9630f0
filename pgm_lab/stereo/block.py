"""A block of photos: many pairs as tasks, here or on a cluster, and one surface.

`plot_pair` plots one pair into a file of a folder. It runs in this process, in several,
or on a dask cluster; pairs already in the folder are not plotted again. In the end the
files are merged, in the order given.
"""

import contextlib
import errno
import functools
import hashlib
import itertools
import json
import multiprocessing
import os
import queue
import shutil
import socket
import threading
import time
import traceback
import warnings
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent import futures
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import __version__, _validate
from pgm_lab.camera.photo import Photo
from pgm_lab.io import files as _files
from pgm_lab.stereo import slips
from pgm_lab.stereo.dense import match_dense, match_rows
from pgm_lab.stereo.grid import Surface, gap_width, surface
from pgm_lab.stereo.heights import intersect
from pgm_lab.stereo.normal import epipolar_pair
from pgm_lab.stereo.parallax import y_parallax
from pgm_lab.stereo.photo_file import PhotoFile, fingerprint, photo_list

MIN_POINTS = 10  # at least, for a pair to give a surface
MOST_OUTSIDE = 0.1  # of the points of a pair, more are no blunders
MIN_SD = 0.001  # m, lower limit, so that no match outweighs all others
TILE = 1024  # cells on a side of a tile that is merged at once
LIST = "block.json"  # numbers, and a fingerprint of each photo
PATIENCE = 10  # seconds: for a scheduler, for a first worker
DISK = "the disk is full. What was plotted is in the folder: make room and call again"


@dataclass(frozen=True)
class PlottedPair:
    """How the plotting of one pair ended.

    Attributes
    ----------
    left, right : int
        Indices of the photos.
    status : {"plotted", "found", "failed"}
        "found" was plotted by an earlier run, from the same photos and settings.
    points : int
        Matched points; 0 if it failed.
    seconds : float
        Time on its worker; NaN unless plotted in this run.
    attempts : int
        Number of attempts in this run.
    reason : str
        Reason why it failed; empty if it did not.
    remark : str
        Why its heights are in doubt: a wrong orientation (`y_parallax`), or many points
        beyond the limits; else empty.
    file : Path
        Its surface: NPZ with `z`, `weight` and `box`.
    """

    left: int
    right: int
    status: str
    points: int = 0
    seconds: float = np.nan
    attempts: int = 0
    reason: str = ""
    remark: str = ""
    file: Path = Path()


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
    largest_gap: float | None = None,
    workers: int | None = None,
    client: Any = None,
    retries: int = 1,
    overwrite: bool = False,
    progress: bool = True,
) -> Block:
    """Plot many pairs, each once, and merge their surfaces.

    Each pair is a task: `epipolar_pair`, `match_dense`, `intersect` and `surface`, and
    the heights go into a file of the folder. If a run is interrupted, the same call
    plots what is missing. (If you change `pgm_lab` itself, take a new folder.) All
    cells lie on one grid, with edges at whole multiples of `cell`. The result is the
    same to the last bit, whichever worker does a task and whichever is ready first.

    Photos in memory are written into the folder first; a `PhotoFile` saves this copy.
    Workers of a cluster have to see folder and photos under the same names.

    Parameters
    ----------
    photos : sequence of Photo or PhotoFile
        Oriented photos.
    pairs : array_like (n, 2) of int
        Indices of left and right photo of each pair, as of `neighbours`.
    folder : path
        Where the files go; it has to exist.
    heights : (low, high)
        Smallest and largest Z of ground and objects, in m; points beyond are dropped.
    cell : float
        Side of a cell, in m.
    matching : mapping, optional
        Options of `match_dense`, such as ``{"window": 9}``.
    merging : {"mean", "median"}
        Of the measured heights where pairs overlap; the mean is weighted by 1 / sd^2.
    largest_gap : float, optional
        Width in m of the widest gap of a pair that is interpolated, as in `surface`.
    workers : int, optional
        Processes of this computer; default: one a core; 1 is this process alone.
        Each needs the memory of a pair.
    client : dask.distributed.Client or str, optional
        A cluster, or the address of its scheduler, instead of processes.
    retries : int
        How often a pair that failed is tried again.
    overwrite : bool
        Take a folder of other photos or settings, and plot anew what differs.
    progress : bool
        Show a bar.

    Returns
    -------
    Block

    Raises
    ------
    ValueError
        If an argument is not as described here, or all pairs failed.
    FileNotFoundError, FileExistsError
        If the folder is missing, also for a worker of the cluster; or it contains other
        files, or a block of other photos or settings.
    ConnectionError, ImportError
        If the cluster does not answer, has no worker, or is lost; if dask is missing.
    OSError
        If the disk is full.

    Warns
    -----
    UserWarning
        If pairs were plotted whose heights are in doubt, each with its `remark`.
    """
    from tqdm.auto import tqdm

    photos = photo_list(photos)
    indices = _indices(pairs, len(photos))
    cell = _validate.positive_number(cell, "cell", "m")
    low, high = _validate.of_shape(heights, (2,), "heights").tolist()
    if not low < high:
        raise ValueError(
            f"heights must be (low, high) with low < high; got ({low:g}, {high:g})"
        )
    _validate.choice(merging, "merging", ("mean", "median"))
    largest_gap = gap_width(largest_gap)
    retries = _validate.whole(retries, "retries", 0)
    cores = os.cpu_count() or 1
    workers = _validate.whole(cores if workers is None else workers, "workers", 1)
    matching = dict(_validate.mapping({} if matching is None else matching, "matching"))
    try:  # or each pair would fail of its own
        match_rows(*np.zeros((2, 50, 50)), **matching)
    except (TypeError, ValueError) as error:
        raise ValueError(f"matching: {error}") from None
    folder = Path(folder).absolute()
    if not folder.is_dir():
        raise FileNotFoundError(
            f"{_files.printable(folder)} is not a folder: make it first"
        )

    # What the folder belongs to, and which pairs it contains already
    numbers = {
        "heights": [low, high],
        "cell": cell,
        "matching": matching,
        "largest_gap": largest_gap,
        "pgm_lab": __version__,
    }
    files = {k: _on_disk(photos[k], folder) for k in np.unique(indices).tolist()}
    prints = {k: file.fingerprint() for k, file in files.items()}
    known = numbers | {f"photos[{k}]": one for k, one in prints.items()}
    _belongs(folder, known, _validate.flag(overwrite, "overwrite"))
    tasks = [
        Task(
            (i, j),
            files[i],
            files[j],
            (low, high),
            cell,
            matching,
            largest_gap,
            fingerprint(numbers, prints[i], prints[j]),
            folder / f"pair_{i:05d}_{j:05d}.npz",
        )
        for i, j in indices.tolist()
    ]
    done = {task.pair: row for task in tasks if (row := _found(task))}
    missing = [task for task in tasks if task.pair not in done]
    bar = tqdm(
        total=len(tasks),
        initial=len(done),
        unit="pair",
        disable=not _validate.flag(progress, "progress"),
    )
    with bar, _workers(client, workers, folder) as plot:
        for row in _plot(missing, plot, retries):
            done[row.left, row.right] = row
            bar.update()

    table = tuple(done[task.pair] for task in tasks)
    good = [pair.file for pair in table if pair.status != "failed"]
    if not good:
        raise ValueError(
            f"none of the {len(table)} pair(s) could be plotted; the first,"
            f" ({table[0].left}, {table[0].right}): {table[0].reason}"
        )
    if doubtful := [pair for pair in table if pair.remark]:
        first = doubtful[0]
        warnings.warn(
            f"the heights of {len(doubtful)} of {len(table)} pair(s) are in doubt; the"
            f" first, ({first.left}, {first.right}): {first.remark}",
            stacklevel=2,
        )
    named = {file.system() for file in files.values()}
    crs = named.pop() if len(named) == 1 else None
    merged = merge(good, cell, folder, merging)
    merged = replace(merged, largest_gap=largest_gap, crs=crs)
    return Block(merged, table, (folder / "z.npy", folder / "measured.npy", *good))


def _indices(pairs: ArrayLike, n: int) -> np.ndarray:
    """Pairs as indices (k, 2) of n photos."""
    if not _validate.numeric(pairs, "pairs").size:
        raise ValueError("pairs is empty: no photos share enough of the ground")
    _validate.of_shape(pairs, (None, 2), "pairs")
    pairs = _validate.indices(np.ravel(pairs), n, "pairs").reshape(-1, 2)
    if np.any(pairs[:, 0] == pairs[:, 1]):
        raise ValueError("pairs has a photo paired with itself")
    if len(np.unique(pairs, axis=0)) < len(pairs):
        raise ValueError("pairs has the same pair more than once")
    return pairs


# --- The folder: its contents, and the photos and settings it belongs to ---


def _on_disk(photo: Photo | PhotoFile, folder: Path) -> PhotoFile:
    """Write a photo that is in memory, under a name that depends on its content."""
    if isinstance(photo, PhotoFile):
        return photo
    grey = np.ascontiguousarray(photo.grey)
    content = hashlib.sha256(f"{grey.dtype}{grey.shape}".encode() + grey.tobytes())
    path = folder / "photos" / f"{content.hexdigest()[:32]}.npy"
    if not path.is_file():
        path.parent.mkdir(exist_ok=True)
        with _files.atomic(path, overwrite=True) as part, part.open("xb") as file:
            np.save(file, grey)
    own = photo.camera, tuple(photo.exterior.tolist()), photo.pixel_size
    return PhotoFile(path, *own, photo.image_size, photo.corner, photo.crs)


def _belongs(folder: Path, now: dict[str, Any], overwrite: bool) -> None:
    """Refuse a folder of another block; record what it belongs to."""
    path = folder / LIST
    now = json.loads(json.dumps(now, default=lambda number: number.item()))
    try:
        then = dict(json.loads(path.read_text("utf-8"))) if path.exists() else {}
    except (ValueError, TypeError):
        if not overwrite:
            raise FileExistsError(
                f"{_files.printable(path)} is damaged: let overwrite=True write it"
                " anew, which keeps the pairs that fit, or name another folder"
            ) from None
        then = {}
    changed = [name for name in now if then.get(name, now[name]) != now[name]]
    if changed and not overwrite:
        name = changed[0]
        what = f"{name} was {then[name]} and is {now[name]}"
        if name.startswith("photos"):
            what = f"{name} is another, or has another orientation"
        raise FileExistsError(
            f"{_files.printable(folder)} belongs to another block: {what}. Name another"
            " folder, or let overwrite=True plot anew what differs"
        )
    # A block just begun has nothing but photos
    others = (one for one in folder.iterdir() if not one.name.startswith("."))
    if not then and not overwrite and any(one.name != "photos" for one in others):
        raise FileExistsError(
            f"{_files.printable(folder)} has other files in it, not a block. Name an"
            " empty folder, or let overwrite=True put the block beside them"
        )
    _files.save({path: json.dumps(then | now, indent=1) + "\n"}, overwrite=True)


# --- One pair as a task ---


@dataclass(frozen=True, eq=False)
class Task:
    """What a worker needs for a pair, 1 kB in all: it reads the photos itself."""

    pair: tuple[int, int]
    left: PhotoFile
    right: PhotoFile
    heights: tuple[float, float]
    cell: float
    matching: Mapping[str, Any]
    largest_gap: float | None
    fingerprint: str
    file: Path


def plot_pair(task: Task) -> PlottedPair:
    """Plot one pair into its file."""
    start = time.perf_counter()
    left, right = task.left.read(), task.right.read()
    pair = epipolar_pair(left, right, task.heights)
    match = match_dense(pair, **task.matching)
    # About one point a cell: windows of more would overlap
    depth = pair.stations[:, 2].mean() - np.mean(task.heights)
    step = max(1, int(task.cell / (depth * pair.pixel_size / pair.c)))
    points = intersect(pair, match, step=step)
    low, high = task.heights
    inside = (points.xyz[:, 2] >= low) & (points.xyz[:, 2] <= high)
    n = int(inside.sum())
    between = f"{n} of {len(inside)} matched points lie between {low:g} and {high:g} m"
    if n < MIN_POINTS:
        slip = slips.likely((left, right), "heights", np.array(task.heights))
        raise ValueError(f"{between}. {slip}".rstrip(". "))
    remark, checked = "", y_parallax(pair)
    if checked.slip or checked.verdict not in ("well oriented", "no trend"):
        remark = checked.message
    elif n < (1 - MOST_OUTSIDE) * len(inside):
        remark = f"{between}: are these the heights of the ground?"
    z, weight, first = _gridded(
        points.xyz[inside], points.sd[inside, 2], task.cell, task.largest_gap
    )
    box = np.array([*first, *z.shape[::-1]])
    stored: dict[str, Any] = {"fingerprint": task.fingerprint, "points": n}
    stored |= {"remark": remark, "box": box, "z": z, "weight": weight}
    with _files.atomic(task.file, overwrite=True) as part, part.open("xb") as file:
        np.savez(file, **stored)
    seconds = time.perf_counter() - start
    return PlottedPair(*task.pair, "plotted", n, seconds, remark=remark, file=task.file)


def _gridded(
    xyz: np.ndarray, sd: np.ndarray, cell: float, largest_gap: float | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Heights, weights and first (column, row), in cells that all pairs share.

    Cell (column, row) has its centre at ((column + 0.5) cell, -(row + 0.5) cell).
    """
    at = np.floor(xyz[:, :2] * (1, -1) / cell).astype(np.int64)
    first, last = at.min(0), at.max(0) + 1
    columns, rows = last - first
    extent = tuple(cell * np.array([first[0], -last[1], last[0], -first[1]], float))
    z = surface(xyz, cell, extent=extent, largest_gap=largest_gap).z[:rows, :columns]
    where = (at - first) @ (1, columns)
    sd = np.nan_to_num(sd, nan=np.inf).clip(MIN_SD)
    weight = np.bincount(where, 1 / sd**2, rows * columns).reshape(rows, columns)
    weight[np.isnan(z)] = 0
    return z.astype(np.float32), weight.astype(np.float32), first


def _found(task: Task) -> PlottedPair | None:
    """The pair if it is in its file already."""
    try:
        with task.file.open("rb") as file, np.load(file) as stored:
            if str(stored["fingerprint"]) != task.fingerprint:
                return None
            points, remark = int(stored["points"]), str(stored["remark"])
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None  # not there, or broken
    return PlottedPair(*task.pair, "found", points, remark=remark, file=task.file)


# --- Where the tasks run: in this process, in several, or on a cluster ---

Plot = Callable[[Task], futures.Future]


def _plot(tasks: list[Task], plot: Plot, retries: int) -> Iterator[PlottedPair]:
    """Do all tasks; those that failed again, one by one, after the others."""
    # It is unknown which of those that ran together killed a worker
    batches = [tasks]
    for attempt in range(1, retries + 2):
        failed = []
        for batch in batches:
            for task, row in _batch(batch, plot):
                if row.status == "failed" and attempt <= retries:
                    failed.append([task])
                else:
                    yield replace(row, attempts=attempt)
        batches = failed


def _batch(tasks: list[Task], plot: Plot) -> Iterator[tuple[Task, PlottedPair]]:
    """Do tasks at the same time; how each ended, as they are ready."""
    running = {plot(task): task for task in tasks}
    try:
        for future in futures.as_completed(running):
            yield running[future], _ended(running[future], future)
    finally:
        for future in running:
            future.cancel()


def _ended(task: Task, future: futures.Future) -> PlottedPair:
    """The pair, or why it failed; what ends all tasks is raised."""
    try:
        return future.result()
    except futures.CancelledError:
        raise ConnectionError(
            "the cluster was lost. What it has plotted is in the folder: call again"
            " to go on"
        ) from None
    except BrokenProcessPool:
        reason = (
            "BrokenProcessPool: its process died; was there enough memory? (In a"
            " script, plot_block has to be called under"
            ' `if __name__ == "__main__":`, or with workers=1)'
        )
    except Exception as error:
        traceback.clear_frames(error.__traceback__)  # or photos stay open
        if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
            raise OSError(error.errno, DISK) from error
        reason = f"{type(error).__name__}: {error}"
    return PlottedPair(*task.pair, "failed", reason=reason, file=task.file)


@contextlib.contextmanager
def _workers(client: Any, workers: int, folder: Path) -> Iterator[Plot]:
    """A function that plots somewhere; a cluster must see the folder."""
    if client is None:
        with (
            _in_processes(workers) as work,
            futures.ThreadPoolExecutor(workers) as threads,
        ):
            yield lambda task: threads.submit(work, task)
        return
    with _connected(client) as cluster:
        for address, sees in cluster.run(os.path.isfile, str(folder / LIST)).items():
            if not sees:
                raise FileNotFoundError(
                    f"worker {address} does not see {folder}: put folder and photos on"
                    " a disk that all workers have under the same name"
                )
        with cluster.get_executor(pure=False) as executor:
            yield lambda task: executor.submit(plot_pair, task)


@contextlib.contextmanager
def _in_processes(number: int) -> Iterator[Callable[[Task], PlottedPair]]:
    """A function that plots in so many processes; one is this process alone."""
    if number == 1:
        yield plot_pair
        return
    spawn = multiprocessing.get_context("spawn")
    # Pools of one process: if it dies, no other pair is lost
    start = functools.partial(futures.ProcessPoolExecutor, 1, spawn, _alone)
    free: queue.SimpleQueue[futures.ProcessPoolExecutor] = queue.SimpleQueue()
    for _ in range(number):
        free.put(start())

    def plot(task: Task) -> PlottedPair:
        pool = free.get()
        try:
            return pool.submit(plot_pair, task).result()
        except BrokenProcessPool:
            pool.shutdown()
            pool = start()
            raise
        finally:
            free.put(pool)

    try:
        yield plot
    finally:
        for _ in range(number):
            free.get().shutdown()


def _alone() -> None:
    """One thread, and no lock between processes, which one that is killed leaves."""
    from tqdm.auto import tqdm

    cv2.setNumThreads(1)
    tqdm.set_lock(threading.RLock())


@contextlib.contextmanager
def _connected(client: Any) -> Iterator[Any]:
    """The client of a cluster with workers; one made here from an address is closed."""
    try:
        from distributed import Client
        from distributed.comm import get_address_host_port
    except ImportError:
        raise ImportError(
            "a cluster needs dask.distributed: pip install dask distributed"
        ) from None
    with contextlib.ExitStack() as own:
        if isinstance(client, str):
            try:  # quick test whether anything answers at all
                socket.create_connection(
                    get_address_host_port(client), PATIENCE
                ).close()
                cluster = Client(client, timeout=PATIENCE, set_as_default=False)
            except Exception as error:  # whatever another program replies there
                raise ConnectionError(
                    f"no dask scheduler answers at {client!r} ({type(error).__name__})"
                ) from error
            client = own.enter_context(cluster)
        if _validate.instance(client, Client, "client").status != "running":
            raise ConnectionError("the client of the cluster is closed; make a new one")
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise ConnectionError("the cluster has no worker; start one") from None
        yield client


# --- Merging many surfaces into one, tile by tile, in the order of the pairs ---


def merge(files: Sequence[Path], cell: float, folder: Path, how: str) -> Surface:
    """One surface from many, written into the folder as `z.npy` and `measured.npy`.

    Measured cells count before interpolated ones. A cell is the same whatever the size
    of the tiles, and whichever pair was ready first. (`rasterio.merge` goes band by
    band, so that heights would be merged without their weights.)
    """
    boxes = np.array([_read(file, "box")[0].reshape(2, 2) for file in files])
    first = boxes[:, 0].min(0)
    boxes = boxes.cumsum(1) - first  # low, high
    columns, rows = boxes[:, 1].max(0).tolist()
    if shutil.disk_usage(folder).free < 5 * rows * columns:
        raise OSError(errno.ENOSPC, DISK)
    names = [folder / "z.npy", folder / "measured.npy"]
    with (
        _files.atomic(names[0], overwrite=True) as z_part,
        _files.atomic(names[1], overwrite=True) as measured_part,
    ):
        z = np.lib.format.open_memmap(z_part, "w+", np.float32, (rows, columns))
        measured = np.lib.format.open_memmap(measured_part, "w+", bool, z.shape)
        combine = _mean if how == "mean" else _median
        for row, column in itertools.product(*(range(0, n, TILE) for n in z.shape)):
            low = np.array([column, row])
            high = np.minimum(low + TILE, z.shape[::-1])
            parts = _parts(files, boxes, np.stack([low, high]))
            at = _slices(low, high)
            z[at], measured[at] = combine((high - low)[::-1], parts)
        del z, measured  # closed before they get their names
    large = rows * columns > _validate.MAX_NUMBERS
    z, measured = (np.load(name, mmap_mode="r" if large else None) for name in names)
    x, y = (first + 0.5) * cell
    return Surface(z, (float(x), float(-y)), cell, measured)


Part = tuple[tuple[slice, slice], np.ndarray, np.ndarray]  # where, heights, weights


def _parts(
    files: Sequence[Path], boxes: np.ndarray, tile: np.ndarray
) -> Iterator[Part]:
    """Cells that each pair has in a tile, and where; boxes and tile are (low, high)."""
    low, high = np.maximum(boxes[:, 0], tile[0]), np.minimum(boxes[:, 1], tile[1])
    for k in np.flatnonzero((low < high).all(1)).tolist():
        part = _slices(low[k] - boxes[k, 0], high[k] - boxes[k, 0])
        z, weight = _read(files[k], "z", "weight")
        yield _slices(low[k] - tile[0], high[k] - tile[0]), z[part], weight[part]


def _mean(shape: np.ndarray, parts: Iterator[Part]) -> tuple[np.ndarray, np.ndarray]:
    """Mean by weights; where no pair has measured, that of interpolated heights."""
    weights, heights, count, plain = np.zeros((4, *shape))
    for where, z, weight in parts:
        known = ~np.isnan(z)
        z = np.where(known, z, 0).astype(float)
        weights[where] += weight
        heights[where] += weight * z
        count[where] += known
        plain[where] += z
    measured = weights > 0
    with np.errstate(invalid="ignore"):  # 0 / 0 is NaN where no pair has a height
        mean = np.where(
            measured, heights / np.where(measured, weights, 1), plain / count
        )
    return mean, measured


def _median(shape: np.ndarray, parts: Iterator[Part]) -> tuple[np.ndarray, np.ndarray]:
    """Median of measured heights; of interpolated ones where none is measured."""
    layers, of = [np.full(shape, np.nan, np.float32)], [np.zeros(shape, bool)]
    for where, z, weight in parts:
        layers.append(layers[0].copy())
        of.append(of[0].copy())
        layers[-1][where], of[-1][where] = z, weight > 0
    heights, has = np.stack(layers), np.stack(of)
    measured: np.ndarray = np.any(has, axis=0)
    heights[measured & ~has] = np.nan
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # where no pair has a height
        return np.nanmedian(heights, axis=0), measured


def _slices(low: np.ndarray, high: np.ndarray) -> tuple[slice, slice]:
    """Rows and columns from low to high (column, row)."""
    return slice(low[1], high[1]), slice(low[0], high[0])


def _read(file: Path, *names: str) -> list[np.ndarray]:
    with np.load(file) as stored:
        return [stored[name] for name in names]
