"""The pairs, each with the truth as far as it is known."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import skimage.data

from pgm_book.common.real_pairs import made
from pgm_book.common.real_pairs.sources import find
from pgm_lab import datasets


@dataclass(frozen=True)
class Stereo:
    """Left and right photo with the disparity of each left pixel, NaN where unknown."""

    name: str
    left: np.ndarray
    right: np.ndarray
    disparity: np.ndarray
    most: int  # px, what the search has to reach

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
        return made.transformed(self.H, points)

    def shape(self, points: np.ndarray) -> np.ndarray:
        """Derivatives (n, 2, 2) of right points by left ones."""
        step = np.eye(2) / 2
        return np.stack(
            [self.truth(points + s) - self.truth(points - s) for s in step], axis=2
        )


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
    layers = [made.Layer(subjects[0], (8, 0.004, 0.01))]
    for i in range(many):
        centre, width = rng.uniform((40, 40), (600, 440)), rng.uniform(20, 60, (6, 1))
        turns = np.sort(rng.uniform(0, 2 * np.pi, 6))
        outline = centre + width * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        dx, dy = rng.uniform(-0.03, 0.03, 2)
        nearer = 15 + i
        d = (nearer - dx * centre[0] - dy * centre[1], dx, dy)
        layers.append(made.Layer(subjects[1 + i % 5], d, outline))
    left, right, disparity = made.stereo(layers, size)
    return Stereo(
        "cards (made)",
        made.photo(left, made.Camera(seed=1)),
        made.photo(right, made.Camera(gain=0.9, seed=2)),
        disparity,
        60,
    )


def rephotographed(name: str, subject: np.ndarray, degrees: float, scale: float):
    """Return two photos of a photo, the right one turned and scaled."""
    rows, columns = subject.shape
    H = made.similarity(degrees, scale, ((columns - 1) / 2, (rows - 1) / 2))
    left = made.photo(
        made.seen(subject, np.eye(3), (columns, rows)), made.Camera(seed=1)
    )
    right = made.photo(
        made.seen(subject, H, (columns, rows)), made.Camera(gain=0.9, seed=2)
    )
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


def aerial(blur: tuple[float, float], noise: float, factor: int = 3) -> Warped:
    """The orthophoto seen from two flights: turned by 4 degrees, each with its blur.

    `blur` is what the lens does, in pixels (standard deviation): with 0.4 fine detail
    is aliased, with 0.8 hardly.
    """
    grey = datasets.yellowstone().grey.astype(np.float32)
    n = min(grey.shape) // factor - 20
    small = np.diag([1 / factor, 1 / factor, 1.0])
    small[:2, 2] = -5 / factor
    turn = made.similarity(4.0, 1.0, ((n - 1) / 2, (n - 1) / 2))
    rng, photos = np.random.default_rng(0), []
    for H, sigma, gain in ((small, blur[0], 1.0), (turn @ small, blur[1], 1.05)):
        light = cv2.GaussianBlur(grey, (0, 0), sigma * factor)
        light = cv2.warpPerspective(
            light, H, (n, n), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT
        )
        light = gain * light + rng.normal(0, noise, light.shape)
        photos.append(np.clip(np.rint(light), 0, 255).astype(np.uint8))
    return Warped(
        f"aerial, blur {blur[0]:g} {blur[1]:g}, noise {noise:g}", *photos, turn
    )


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
