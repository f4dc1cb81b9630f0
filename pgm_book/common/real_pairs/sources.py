"""Where the pairs come from, and under which licence; what is missing is fetched."""

from dataclasses import dataclass
from pathlib import Path
from urllib.request import urlopen

OPENCV = "https://raw.githubusercontent.com/opencv/opencv/4.x/samples/data/"


@dataclass(frozen=True)
class Source:
    """Files of one pair: where they come from, who made them, what allows their use."""

    name: str
    files: tuple[str, ...]
    origin: str
    licence: str


SOURCES = (
    Source(
        "aloe",
        ("aloeL.jpg", "aloeR.jpg", "aloeGT.png"),
        "Middlebury stereo of 2006 (Scharstein and Pal 2007), as in OpenCV's samples",
        "sample data of OpenCV, Apache 2.0; Middlebury asks to be cited",
    ),
    Source(
        "graffiti",
        ("graf1.png", "graf3.png", "H1to3p.xml"),
        "Affine covariant features (Mikolajczyk et al. 2005), as in OpenCV's samples",
        "sample data of OpenCV, Apache 2.0",
    ),
    Source(
        "leuven",
        ("leuvenA.jpg", "leuvenB.jpg"),
        "castle in Leuven, two hand-held photos without truth, OpenCV's samples",
        "sample data of OpenCV, Apache 2.0",
    ),
    Source(
        "aero",
        ("aero1.jpg", "aero3.jpg"),
        "oblique aerial photos of a town without truth, OpenCV's samples",
        "sample data of OpenCV, Apache 2.0",
    ),
)
# Comes with scikit-image (BSD; Middlebury stereo of 2014, Scharstein et al. 2014)
# and with the project, see data/README.md
AT_HAND = ("motorcycle", "orthophoto")


def fetch(folder: Path) -> None:
    """Get the files that are missing from a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for source in SOURCES:
        for name in source.files:
            if find(folder, name) is None:
                print("fetching", name)
                with urlopen(OPENCV + name, timeout=60) as answer:
                    (folder / name).write_bytes(answer.read())


def find(folder: Path, name: str) -> Path | None:
    """Path of a file somewhere in a folder."""
    return next(iter(sorted(folder.rglob(name))), None)
