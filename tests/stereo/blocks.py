"""A strip of tiny photos, and photos that make trouble where they are read."""

import dataclasses
import errno
import os
import signal
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pgm_lab import simulate
from pgm_lab.stereo import PhotoFile

HEIGHTS = (-5.0, 65.0)
PAIRS = [(0, 1), (1, 2), (2, 3)]
NUMBERS = dict(heights=HEIGHTS, cell=1.0, progress=False)


def strip():
    """Four photos of a strip, and the landscape."""
    return simulate.aerial_block(1, 4, (160, 120), cell=0.25, buildings=1, trees=0)


def content(folder):
    """All of a folder, byte by byte."""
    return {
        str(p.relative_to(folder)): p.read_bytes()
        for p in sorted(Path(folder).rglob("*"))
        if p.is_file()
    }


def saved(photos, folder):
    """Photos as files, by the names of their numbers."""
    files = []
    for k, p in enumerate(photos):
        np.save(folder / f"{k}.npy", p.grey)
        own = p.camera, tuple(p.exterior), p.pixel_size, p.image_size, p.corner
        files.append(PhotoFile(folder / f"{k}.npy", *own))
    return files


def replaced(photos, k, kind, folder, **more):
    """The photos, one of which makes trouble."""
    given = {f.name: getattr(photos[k], f.name) for f in dataclasses.fields(photos[k])}
    troubled = kind(**given, log=str(folder / "log.txt"), **more)
    return [troubled if i == k else p for i, p in enumerate(photos)]


@dataclass(frozen=True, eq=False)
class Counted(PhotoFile):
    """Leaves a line in a file each time it is read."""

    log: str = ""

    def read(self):
        with open(self.log, "a") as file:
            file.write(f"{Path(self.path).name}\n")
        return super().read()


@dataclass(frozen=True, eq=False)
class Failing(Counted):
    """Fails the first times it is read."""

    times: int = 1

    def read(self):
        photo = super().read()
        if Path(self.log).read_text().count(Path(self.path).name) <= self.times:
            self.fail()
        return photo

    def fail(self):
        raise RuntimeError("a disk was asleep")


class Deadly(Failing):
    """Kills the worker that reads it."""

    def fail(self):
        os.kill(os.getpid(), signal.SIGTERM if os.name == "nt" else signal.SIGKILL)


class Full(Failing):
    """Says what a full disk says."""

    def fail(self):
        raise OSError(errno.ENOSPC, "No space left on device")
