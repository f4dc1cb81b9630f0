"""Pairs of photos, each with the truth as far as it is known: real ones, and made ones.

Real photos are fetched from where `SOURCES` says; or they are photographed again: a
made photo sees its subject through a lens and a sensor. Each pixel is the mean over its
area, the corners are darker, the exposure differs, the three colours are measured at
different pixels and interpolated, grey values are noisy and stored as JPEG.
"""

from dataclasses import dataclass
from pathlib import Path
from urllib.request import urlopen

import cv2
import numpy as np
import skimage.data

from pgm_lab import datasets

# --- Where real photos come from, and under which licence ---

OPENCV = "https://raw.githubusercontent.com/opencv/opencv/4.x/samples/data/"


@dataclass(frozen=True)
class Source:
    """Files of one pair: where they come from, who made them, under which licence."""

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
# "motorcycle" comes with scikit-image (BSD; Middlebury stereo of 2014, Scharstein et
# al. 2014), "orthophoto" with the project, see data/README.md


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


# --- Photos made of a subject ---

FINER = 3  # samples along a pixel
WHITE = (0.6, 1.0, 0.75)  # share of blue, green, red that the sensor receives


@dataclass(frozen=True)
class Camera:
    """What degrades a photo."""

    gain: float = 1.0
    vignetting: float = 0.15  # of the light is missing in the corners
    noise: float = 2.0  # grey values, standard deviation at the sensor
    quality: int = 92  # of the JPEG
    seed: int = 0


def seen(subject: np.ndarray, H: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Grey values (rows, columns) of a subject under a homography, mean over pixels.

    H (3, 3) takes (column, row, 1) of the subject to the photo of `size` (columns,
    rows), integers at pixel centres.
    """
    n = FINER
    fine = np.array([[n, 0, (n - 1) / 2], [0, n, (n - 1) / 2], [0, 0, 1.0]])
    return cv2.resize(
        cv2.warpPerspective(
            subject.astype(np.float32),
            fine @ H,
            (n * size[0], n * size[1]),
            flags=cv2.INTER_CUBIC,
            borderMode=cv2.BORDER_REFLECT,
        ),
        size,
        interpolation=cv2.INTER_AREA,
    )


def photo(light: np.ndarray, camera: Camera) -> np.ndarray:
    """Grey values of 8 bits that a camera stores of the light (rows, columns)."""
    rows, columns = light.shape
    y, x = np.mgrid[-1 : 1 : rows * 1j, -1 : 1 : columns * 1j]
    light = light * camera.gain * (1 - camera.vignetting * (x**2 + y**2) / 2)
    # Blue, green and red at different pixels (Bayer), then interpolated
    mosaic = light.copy()
    mosaic[0::2, 0::2] *= WHITE[0]
    mosaic[1::2, 1::2] *= WHITE[2]
    rng = np.random.default_rng(camera.seed)
    mosaic = _grey_of_8_bits(mosaic + rng.normal(0, camera.noise, light.shape))
    colours = cv2.cvtColor(mosaic, cv2.COLOR_BayerBGGR2BGR) / np.array(WHITE)
    ok, coded = cv2.imencode(
        ".jpg", _grey_of_8_bits(colours), [cv2.IMWRITE_JPEG_QUALITY, camera.quality]
    )
    if not ok:
        raise ValueError("the photo could not be stored as JPEG")
    return cv2.imdecode(coded, cv2.IMREAD_GRAYSCALE)


def similarity(degrees: float, scale: float, centre: tuple[float, float]) -> np.ndarray:
    """Homography (3, 3) that rotates and scales about a centre, and shifts a little."""
    a = np.radians(degrees)
    A = scale * np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    H = np.eye(3)
    H[:2, :2] = A
    H[:2, 2] = centre - A @ centre + (0.37, -0.21)
    return H


def transformed(H: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (n, 2) under a homography."""
    homogeneous = np.column_stack([points, np.ones(len(points))]) @ H.T
    return homogeneous[:, :2] / homogeneous[:, 2:]


@dataclass(frozen=True)
class Layer:
    """A flat thing in front of two cameras side by side.

    `disparity` (3,) is d = d0 + dx column + dy row, of the left photo; `outline` are
    the corners (n, 2) in the left photo, None for a background.
    """

    subject: np.ndarray
    disparity: tuple[float, float, float]
    outline: np.ndarray | None = None

    def to_right(self) -> np.ndarray:
        """Homography (3, 3) from left to right: column minus disparity."""
        H = np.eye(3)
        d0, dx, dy = self.disparity
        H[0] = 1 - dx, -dy, -d0
        return H


def stereo(
    layers: list[Layer], size: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Light in two photos of layers, the nearest last, and the left disparities."""
    columns, rows = size
    left, right = np.zeros((2, rows, columns))
    y, x = np.indices((rows, columns))
    disparity = np.zeros((rows, columns))
    for layer in layers:
        H = layer.to_right()
        mask = np.ones(layer.subject.shape, np.float32)
        if layer.outline is not None:
            mask = np.zeros((rows, columns), np.float32)
            cv2.fillPoly(mask, [np.round(layer.outline).astype(np.int32)], 1.0)
        sides = []
        for light, side in ((left, np.eye(3)), (right, H)):
            covered = seen(mask, side, size)
            sides.append(light + covered * (seen(layer.subject, side, size) - light))
        left, right = sides
        d0, dx, dy = layer.disparity
        there = seen(mask, np.eye(3), size) > 0.5
        disparity[there] = (d0 + dx * x + dy * y)[there]
    return left, right, disparity


def _grey_of_8_bits(values: np.ndarray) -> np.ndarray:
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


# --- The pairs ---


@dataclass(frozen=True)
class Stereo:
    """Left and right photo with the disparity of each left pixel, NaN where unknown."""

    name: str
    left: np.ndarray
    right: np.ndarray
    disparity: np.ndarray
    most: int  # px, which the search has to reach

    def truth(self, points: np.ndarray) -> np.ndarray:
        """Right points (n, 2) of whole left pixels."""
        column, row = points.astype(int).T
        d = self.disparity[row, column]
        return points - np.stack([d, np.where(np.isnan(d), np.nan, 0)], axis=1)


@dataclass(frozen=True)
class Warped:
    """Two photos of a plane: the truth is a homography."""

    name: str
    left: np.ndarray
    right: np.ndarray
    H: np.ndarray

    def truth(self, points: np.ndarray) -> np.ndarray:
        """Right points (n, 2) of left ones."""
        return transformed(self.H, points)


def stereo_pairs(folder: Path) -> list[Stereo]:
    """Pairs with disparities: of aloe, of a motorcycle, of made things on a table."""
    found = []
    if photos := _read(folder, "aloeL.jpg", "aloeR.jpg", "aloeGT.png"):
        left, right, d = photos
        found.append(
            Stereo("aloe", left, right, np.where(d > 0, d.astype(float), np.nan), 240)
        )
    pair = datasets.motorcycle()
    grey = [np.rint(g).astype(np.uint8) for g in (pair.left, pair.right)]
    found.append(Stereo("motorcycle", *grey, pair.disparity, 80))
    found.append(things())
    return found


def things(seed: int = 1, many: int = 25) -> Stereo:
    """Photos of tilted cards, before a background of gravel, made with truth.

    The cards show real photos: textures and a cup of coffee.
    """
    rng, size = np.random.default_rng(seed), (640, 480)
    subjects = [
        cv2.resize(np.asarray(_grey(getattr(skimage.data, name)())), size)
        for name in ("gravel", "grass", "brick", "coffee", "camera", "rocket")
    ]
    layers = [Layer(subjects[0], (8, 0.004, 0.01))]
    for i in range(many):
        centre, width = rng.uniform((40, 40), (600, 440)), rng.uniform(20, 60, (6, 1))
        turns = np.sort(rng.uniform(0, 2 * np.pi, 6))
        outline = centre + width * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        dx, dy = rng.uniform(-0.03, 0.03, 2)
        nearer = 15 + i
        d = (nearer - dx * centre[0] - dy * centre[1], dx, dy)
        layers.append(Layer(subjects[1 + i % 5], d, outline))
    left, right, disparity = stereo(layers, size)
    return Stereo(
        "cards (made)",
        photo(left, Camera(seed=1)),
        photo(right, Camera(gain=0.9, seed=2)),
        disparity,
        60,
    )


def rephotographed(name: str, subject: np.ndarray, degrees: float, scale: float):
    """Return two photos of a photo, the right one rotated and scaled."""
    rows, columns = subject.shape
    H = similarity(degrees, scale, ((columns - 1) / 2, (rows - 1) / 2))
    left = photo(seen(subject, np.eye(3), (columns, rows)), Camera(seed=1))
    right = photo(seen(subject, H, (columns, rows)), Camera(gain=0.9, seed=2))
    return Warped(name, left, right, H)


def subjects(folder: Path) -> dict[str, np.ndarray]:
    """Real photos that are photographed again: aerial, a stereo pair's, a castle."""
    ortho = datasets.yellowstone().grey
    found = {"orthophoto": cv2.resize(ortho, None, fx=0.5, fy=0.5, interpolation=3)}
    found["motorcycle"] = np.rint(datasets.motorcycle().left).astype(np.uint8)
    for name, file in (("aloe", "aloeL.jpg"), ("castle", "leuvenA.jpg")):
        if photos := _read(folder, file):
            found[name] = photos[0]
    return found


def graffiti(folder: Path) -> list[Warped]:
    """A wall seen from two sides, with its published homography."""
    photos = _read(folder, "graf1.png", "graf3.png")
    path = find(folder, "H1to3p.xml")
    if not photos or path is None:
        return []
    stored = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    H = stored.getNode("H13").mat()
    return [Warped("graffiti", *photos, H)]


def _read(folder: Path, *names: str) -> list[np.ndarray] | None:
    """Grey values of files in a folder; None if one is missing."""
    paths = [find(folder, name) for name in names]
    if any(path is None for path in paths):
        return None
    return [cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) for path in paths]


def _grey(photo: np.ndarray) -> np.ndarray:
    return photo if photo.ndim == 2 else cv2.cvtColor(photo, cv2.COLOR_RGB2GRAY)
