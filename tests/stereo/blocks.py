"""A strip of tiny photos, and photos that make trouble where they are read."""

import errno
import os
import signal
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pgm_lab import simulate
from pgm_lab.stereo import PhotoFile

HEIGHTS = (-5.0, 65.0)
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


def on_disk(photo, path, kind=PhotoFile, **more):
    """Save the grey values of a photo; its name with its orientation."""
    np.save(path, photo.grey)
    return kind(
        path,
        photo.camera,
        tuple(photo.exterior),
        photo.pixel_size,
        photo.image_size,
        photo.corner,
        **more,
    )


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
