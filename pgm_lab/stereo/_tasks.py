"""One pair of a block as a task: what goes to a worker, what it writes, what returns.

A task is two names of photos with their orientations and a few numbers, 1 kB in all.
The worker reads the photos itself and writes the surface of the pair into the folder:
no grey value and no height passes through the scheduler of a cluster.
"""

import time
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pgm_lab.io import files as _files
from pgm_lab.stereo.dense import match_dense
from pgm_lab.stereo.grid import surface
from pgm_lab.stereo.heights import Points, intersect
from pgm_lab.stereo.normal import NormalPair, epipolar_pair
from pgm_lab.stereo.photo_file import PhotoFile

FEWEST = 10  # points of a pair that is worth a surface
LEAST_SD = 0.001  # m; no match is better, and none outweighs all others


@dataclass(frozen=True, eq=False)
class Task:
    """What a worker needs for a pair."""

    pair: tuple[int, int]
    left: PhotoFile
    right: PhotoFile
    heights: tuple[float, float]
    cell: float
    matching: Mapping[str, Any]
    fingerprint: str
    file: Path


def plot_pair(task: Task) -> tuple[int, float]:
    """Plot one pair into its file; the number of points and the seconds it took."""
    start = time.perf_counter()
    pair = epipolar_pair(task.left.read(), task.right.read(), task.heights)
    match = match_dense(pair, **task.matching)
    points = intersect(pair, match, step=_step(pair, task))
    low, high = task.heights
    inside = (points.xyz[:, 2] >= low) & (points.xyz[:, 2] <= high)
    n = int(inside.sum())
    if n < FEWEST:
        raise ValueError(f"{n} points between {low:g} and {high:g} m were matched")
    z, weight, first = _gridded(points, inside, task.cell)
    _write(task, z, weight, first, n)
    return n, time.perf_counter() - start


def _step(pair: NormalPair, task: Task) -> int:
    """Take about one point a cell: more of them share their windows anyhow."""
    depth = pair.stations[:, 2].mean() - np.mean(task.heights)
    return max(1, int(task.cell / (depth * pair.pixel_size / pair.c)))


def _gridded(
    points: Points, inside: np.ndarray, cell: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Heights, weights and first (column, row), in cells that all pairs share.

    Cell (column, row) has its middle at ((column + 0.5) cell, -(row + 0.5) cell).
    """
    xyz = points.xyz[inside]
    sd = np.nan_to_num(points.sd[inside, 2], nan=np.inf).clip(LEAST_SD)
    at = np.floor(xyz[:, :2] * (1, -1) / cell).astype(np.int64)
    first, last = at.min(0), at.max(0) + 1
    columns, rows = last - first
    left, right, top, bottom = first[0], last[0], -first[1], -last[1]
    west, south, east, north = (cell * float(v) for v in (left, bottom, right, top))
    z = surface(xyz, cell, extent=(west, south, east, north)).z[:rows, :columns]
    where = (at - first) @ (1, columns)
    weight = np.bincount(where, 1 / sd**2, rows * columns).reshape(rows, columns)
    weight[np.isnan(z)] = 0
    return z.astype(np.float32), weight.astype(np.float32), first


def _write(task, z, weight, first, n):
    box = np.array([*first, *z.shape[::-1]])
    with _files.written_whole(task.file, overwrite=True) as part:
        with part.open("xb") as file:
            np.savez(
                file,
                fingerprint=task.fingerprint,
                box=box,
                points=n,
                z=z,
                weight=weight,
            )


def plotted(task: Task) -> int | None:
    """Points of a pair that is in its file already, None where it is not."""
    try:
        with task.file.open("rb") as file, np.load(file) as stored:
            same = str(stored["fingerprint"]) == task.fingerprint
            return int(stored["points"]) if same else None
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None  # not there, or broken
