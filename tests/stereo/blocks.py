"""A strip of tiny photos, and photos that make trouble where they are read."""

import errno
import os
import signal
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pgm_lab.simulate import aerial
from pgm_lab.simulate.landscape import landscape
from pgm_lab.stereo import PhotoFile

PART = (160, 120)
BASE = 0.4 * PART[0] * aerial.HEIGHT / aerial.CAMERA.c * aerial.PIXEL  # 60 % overlap
HEIGHTS = (-5.0, 65.0)
NUMBERS = dict(heights=HEIGHTS, cell=1.0, progress=False)


def strip(n=4):
    """Photos of a strip, and the landscape."""
    land = landscape(
        (-40, -30, 40 + BASE * n, 30), cell=0.25, buildings=2, trees=0, seed=3
    )
    corner = tuple((np.array(aerial.SENSOR) - PART) // 2)
    corner = int(corner[0]), int(corner[1])
    photos = []
    for k in range(n):
        exterior = np.array([k * BASE, 0, 1020, 0, 0, 0.0])
        photo, _ = aerial.photograph(
            land,
            aerial.CAMERA,
            exterior,
            aerial.PIXEL,
            aerial.SENSOR,
            corner,
            PART,
            seed=k,
        )
        photos.append(photo)
    return photos, land


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
