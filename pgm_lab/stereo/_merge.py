"""Many surfaces of pairs become one, tile by tile, in the order of the pairs."""

import contextlib
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pgm_lab import _validate
from pgm_lab.io import files as _files
from pgm_lab.stereo.grid import Surface

TILE = 1024  # cells on a side of what is merged at once

MERGES = ("mean", "median")


def merge(files: Sequence[Path], cell: float, folder: Path, how: str) -> Surface:
    """One surface of many, written into the folder as `z.npy` and `measured.npy`.

    Measured cells count before interpolated ones. A cell is the same whatever the size
    of the tiles, and whichever pair was ready first.
    """
    boxes = np.array([_read(file, "box")[0] for file in files])
    first = boxes[:, :2].min(0)
    columns, rows = (boxes[:, :2] + boxes[:, 2:]).max(0) - first
    boxes[:, :2] -= first
    names = [folder / "z.npy", folder / "measured.npy"]
    with contextlib.ExitStack() as stack:
        layers = []
        for name, kind in zip(names, (np.float32, np.bool_)):
            part = stack.enter_context(_files.written_whole(name, overwrite=True))
            layers.append(stack.enter_context(_Layer(part, (rows, columns), kind)))
        for row in range(0, rows, TILE):
            for column in range(0, columns, TILE):
                size = min(TILE, columns - column), min(TILE, rows - row)
                tile = np.array([column, row, *size])
                for layer, values in zip(layers, _tile(files, boxes, tile, how)):
                    layer.write(column, row, values)
    large = rows * columns > _validate.MOST
    z, measured = (np.load(name, mmap_mode="r" if large else None) for name in names)
    x, y = (first + 0.5) * cell
    return Surface(z, (float(x), float(-y)), cell, measured)


def _tile(files, boxes, tile, how):
    """Heights of a tile, and which of them were measured."""
    low = np.maximum(boxes[:, :2], tile[:2])
    high = np.minimum(boxes[:, :2] + boxes[:, 2:], tile[:2] + tile[2:])
    shape = tile[3], tile[2]
    combine = _Mean(shape) if how == "mean" else _Median(shape)
    for k in np.nonzero((low < high).all(1))[0]:
        z, weight = _read(files[k], "z", "weight")
        (c0, r0), (c1, r1) = low[k] - boxes[k, :2], high[k] - boxes[k, :2]
        part = slice(r0, r1), slice(c0, c1)
        (c0, r0), (c1, r1) = low[k] - tile[:2], high[k] - tile[:2]
        combine.add((slice(r0, r1), slice(c0, c1)), z[part], weight[part])
    return combine.result()


class _Mean:
    """Running sums: the mean by weights, of interpolated heights the plain one."""

    def __init__(self, shape):
        self.weights, self.heights = np.zeros(shape), np.zeros(shape)
        self.count, self.between = np.zeros(shape), np.zeros(shape)

    def add(self, where, z, weight):
        known = ~np.isnan(z)
        z = np.where(known, z, 0).astype(float)
        self.weights[where] += weight
        self.heights[where] += weight * z
        self.count[where] += known
        self.between[where] += z

    def result(self):
        measured = self.weights > 0
        with np.errstate(invalid="ignore"):  # 0 / 0 is NaN where no pair has a height
            z = np.where(
                measured,
                self.heights / np.where(measured, self.weights, 1),
                self.between / self.count,
            )
        return z, measured


class _Median:
    """Median of measured heights, of interpolated ones where none is measured."""

    def __init__(self, shape):
        self.shape, self.heights, self.measured = shape, [], []

    def add(self, where, z, weight):
        for layers, values, empty in (
            (self.heights, z, np.nan),
            (self.measured, weight > 0, False),
        ):
            layer = np.full(self.shape, empty, values.dtype)
            layer[where] = values
            layers.append(layer)

    def result(self):
        if not self.heights:
            return np.full(self.shape, np.nan), np.zeros(self.shape, bool)
        z, has = np.stack(self.heights), np.stack(self.measured)
        measured = has.any(0)
        z[measured & ~has] = np.nan
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # where all are NaN
            return np.nanmedian(z, axis=0), measured


class _Layer:
    """An array in a file of NumPy, written piece by piece.

    Ordinary writes, since a full disk under a memory map would end the program without
    a word.
    """

    def __init__(self, path, shape, kind):
        self.columns, self.dtype = int(shape[1]), np.dtype(kind)
        self.file = path.open("xb")
        head = {
            "descr": np.lib.format.dtype_to_descr(self.dtype),
            "fortran_order": False,
            "shape": tuple(int(n) for n in shape),
        }
        np.lib.format.write_array_header_1_0(self.file, head)
        self.start = self.file.tell()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.file.close()

    def write(self, column, row, values):
        for k, line in enumerate(values.astype(self.dtype)):
            at = (row + k) * self.columns + column
            self.file.seek(self.start + at * self.dtype.itemsize)
            self.file.write(line.tobytes())


def _read(file, *names):
    with np.load(file) as stored:
        return [stored[name] for name in names]
