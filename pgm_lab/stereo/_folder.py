"""The folder of a block: what it holds, and which photos and numbers it belongs to."""

import hashlib
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pgm_lab import _validate
from pgm_lab.camera.photo import Photo
from pgm_lab.io import files as _files
from pgm_lab.stereo.photo_file import PhotoFile

LIST = "block.json"  # parameters, and a fingerprint of each photo


def existing(folder: Any) -> Path:
    """Return the path of a folder that is there."""
    if not isinstance(folder, str | os.PathLike) or not str(folder).strip():
        raise ValueError(
            f"folder must be the name of a folder; got {_validate.shown(folder)}"
        )
    path = Path(folder).absolute()
    if not path.is_dir():
        raise FileNotFoundError(
            f"{_files.printable(path)} is no folder: make it first, for the surfaces"
        )
    return path


def on_disk(
    photos: Sequence[Photo | PhotoFile], needed: Iterable[int], folder: Path
) -> tuple[dict[int, PhotoFile], dict[int, str]]:
    """Photos that are needed as files, and their fingerprints, by index."""
    files, prints = {}, {}
    for k in needed:
        photo = photos[k]
        file = photo if isinstance(photo, PhotoFile) else _stored(photo, folder)
        files[k], prints[k] = file, file.fingerprint()
    return files, prints


def _stored(photo: Photo, folder: Path) -> PhotoFile:
    """Write a photo that is in memory, under a name that tells its content."""
    grey = np.ascontiguousarray(photo.grey)
    content = hashlib.sha256(f"{grey.dtype}{grey.shape}".encode())
    content.update(grey.tobytes())
    path = folder / "photos" / f"{content.hexdigest()[:32]}.npy"
    if not path.is_file():
        path.parent.mkdir(exist_ok=True)
        with _files.written_whole(path, overwrite=True) as part:
            with part.open("xb") as file:
                np.save(file, grey)
    exterior = tuple(np.asarray(photo.exterior, float).tolist())
    return PhotoFile(
        path, photo.camera, exterior, photo.pixel_size, photo.image_size, photo.corner
    )


def belongs(
    folder: Path, parameters: Mapping[str, Any], prints: dict[int, str], overwrite: bool
) -> None:
    """Refuse a folder of other things; write down what it belongs to."""
    path = folder / LIST
    photos = {str(k): one for k, one in prints.items()}
    now = json.loads(json.dumps(parameters, default=lambda number: number.item()))
    if path.exists():
        then = json.loads(path.read_text("utf-8"))
        changed = [
            f"{name} was {then['parameters'].get(name)} and is {now[name]}"
            for name in now
            if then["parameters"].get(name) != now[name]
        ]
        changed += [
            f"photos[{k}] is another, or has another orientation"
            for k, one in photos.items()
            if then["photos"].get(k, one) != one
        ]
        if changed and not overwrite:
            more = f", and {len(changed) - 1} more" if len(changed) > 1 else ""
            raise FileExistsError(
                f"{_files.printable(folder)} belongs to another block: {changed[0]}"
                f"{more}. Name another folder, or let overwrite=True plot anew what"
                " differs"
            )
        photos = then["photos"] | photos
    elif not overwrite and _others(folder):
        raise FileExistsError(
            f"{_files.printable(folder)} holds other files, and no block. Name an empty"
            " folder, or let overwrite=True put the block beside them"
        )
    text = json.dumps({"parameters": now, "photos": photos}, indent=1) + "\n"
    _files.save({path: text}, overwrite=True)


def _others(folder: Path) -> bool:
    """Whether a folder holds something, photos of a block just begun apart."""
    return any(
        one.name != "photos" and not one.name.startswith(".")
        for one in folder.iterdir()
    )
