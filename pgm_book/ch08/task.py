"""The task of chapter 8: a profile of heights from two photos as they were taken."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import gaussian_filter, map_coordinates

from pgm_book.common.checks import CheckFailed, numbers
from pgm_book.task import Part, grey, table
from pgm_lab import datasets, frames, plot
from pgm_lab.rotation import matrix

C, PIXEL, SIZE = 8.0, 0.02, (400, 280)  # mm, mm, and columns and rows
HEIGHT, BASE, GRAIN = 60.0, 18.0, 0.1  # m: of flight and base; a pixel of the texture
SIGMA, NOISE = 0.12, 1.0  # px: of a disparity; grey values
STATIONS = 40  # of the profile
SEARCH = -168, -100  # px: columns from the left pixel to the ends of the right strip
REACH = 3.0  # standard deviations
SPARE = 4  # heights that may be missing or lie beyond it: blunders of the matching


@dataclass(frozen=True)
class Truth:
    """The land along the profile, and what its precision depends on."""

    ground: np.ndarray  # (n, 3), m
    depth: np.ndarray  # (n,) below the left station in the normal case, m
    station: float  # height of the left one, m
    base: float  # m

    @property
    def sd(self) -> np.ndarray:
        """Standard deviations (n,) of the heights in m: H/B, times GSD, times SIGMA."""
        down = self.station - self.ground[:, 2]
        return down / self.base * self.depth / C * PIXEL * SIGMA


# --- What is given ---


def make(chance: np.random.RandomState) -> tuple[dict, Truth]:
    """Two tilted photos of hilly land, their orientation, and pixels of a profile."""
    hills = chance.uniform((-14, -14, 2, 12), (14, 14, 3.5, 18), (3, 4))
    tilt = (chance.choice([-5, 5]), 0) + chance.uniform(-2, 2, (2, 2))
    turn = chance.uniform(6, 16, (2, 1)) * chance.choice([-1, 1], (2, 1))
    stations = chance.uniform(-0.8, 0.8, (2, 3)) + (-BASE / 2, 0, HEIGHT)
    stations[1, 0] += BASE
    angles = np.radians(np.hstack([tilt, turn]))
    exteriors = np.hstack([stations.round(3), angles.round(6)])
    rotations = np.array([matrix(*one) for one in exteriors[:, 3:]])
    first, second = exteriors[:, :3]
    N = _normal(rotations, second - first)
    corner = chance.randint(450, 1050, 2)
    images = {}
    for name, e, M, gain in zip(
        ("left.png", "right.png"), exteriors, rotations, (1.0, 0.85)
    ):
        X, Y, _ = np.moveaxis(_ground(e[:3], M, hills, _pixels()), -1, 0)
        place = [corner[0] - Y / GRAIN, corner[1] + X / GRAIN]
        values = gain * map_coordinates(_texture(), place, order=3) + 10
        images[name] = grey(values + NOISE * chance.standard_normal(values.shape))
    pixels = _profile(rotations @ N.T, chance)
    ground = _ground(first, N, hills, pixels)
    head = "photo,X0_m,Y0_m,Z0_m,omega_rad,phi_rad,kappa_rad"
    rows = [(name, *e) for name, e in zip(images, exteriors)]
    numbered = [(k, *pixel) for k, pixel in enumerate(pixels, 1)]
    files = images | {
        "orientation.csv": table(head, "{}" + 3 * ",{:.3f}" + 3 * ",{:.6f}", rows),
        "profile.csv": table("number,column,row", "{},{},{}", numbered),
    }
    depth, base = (first - ground) @ N[2], float(np.linalg.norm(second - first))
    return files, Truth(ground, depth, float(first[2]), base)


@cache
def _texture() -> np.ndarray:
    """An aerial photo of a meadow, with the same contrast everywhere."""
    fine = gaussian_filter(datasets.yellowstone().grey.astype(float), 0.7)
    away = fine - gaussian_filter(fine, 10)
    return 120 + 25 * away / np.sqrt(gaussian_filter(away**2, 10))


def _normal(rotations: np.ndarray, base: np.ndarray) -> np.ndarray:
    """Rotation (3, 3) from object space into the normal case of two photos."""
    across = np.cross(rotations[:, 2].sum(axis=0), base)
    axes = base, across, np.cross(base, across)
    return np.array([axis / np.linalg.norm(axis) for axis in axes])


def _pixels() -> np.ndarray:
    return np.stack(np.meshgrid(*map(np.arange, SIZE)), -1)


def _rays(pixels: np.ndarray) -> np.ndarray:
    """Rays (..., 3) of pixels (..., 2) in the frame of their image."""
    xy = frames.pixel_to_photo(pixels, SIZE, PIXEL)
    return np.insert(xy, 2, -C, axis=-1)


def _ground(
    station: np.ndarray, M: np.ndarray, hills: np.ndarray, pixels: np.ndarray
) -> np.ndarray:
    """Points (..., 3) at which the rays of pixels meet the land."""
    rays = _rays(pixels) @ M
    rays /= -rays[..., 2:]
    depth = np.full(rays.shape[:-1], station[2])
    for _ in range(12):  # each time nearer by the slope of the land
        points = station + rays * depth[..., None]
        away = [(points[..., k, None] - hills[:, k]) / hills[:, 3] for k in (0, 1)]
        land = np.exp(-np.square(away).sum(axis=0) / 2) @ hills[:, 2]
        depth = station[2] - land
    return points


def _profile(turns: np.ndarray, chance: np.random.RandomState) -> np.ndarray:
    """Pixels (n, 2) in a straight line through the left image of the normal case.

    Both photos show them, and the left and right ends of a search; `turns` are the
    rotations (2, 3, 3) from the normal case into the photos.
    """
    searched = [(x, y) for x in SEARCH for y in (-8, 8)]
    while True:
        ends = chance.uniform((SIZE[0] - 220, 30), np.subtract(SIZE, 30), (2, 2))
        pixels = np.linspace(ends[0], ends[1], STATIONS).round().astype(int)
        strips = pixels[:, None] + searched
        seen = [_rotated(pixels, turns[0]), strips, _rotated(strips, turns[1])]
        inside = all(np.all((p > 5) & (p < np.subtract(SIZE, 6))) for p in seen)
        if inside and np.hypot(*(ends[1] - ends[0])) > 140:
            return pixels


def _rotated(pixels: np.ndarray, R: np.ndarray) -> np.ndarray:
    """Pixels (..., 2) of the same rays for a camera that turned by R (3, 3)."""
    U, V, W = np.moveaxis(_rays(pixels) @ R.T, -1, 0)
    return frames.photo_to_pixel(np.stack([-C * U / W, -C * V / W], -1), SIZE, PIXEL)


def given(folder: Path) -> tuple:
    """Both photos, their stations, M of each, N of the normal case, and the profile."""
    orientation, profile = (
        np.loadtxt(folder / name, delimiter=",", skiprows=1, usecols=columns)
        for name, columns in (("orientation.csv", range(1, 7)), ("profile.csv", (1, 2)))
    )
    images = [plt.imread(folder / name) for name in ("left.png", "right.png")]
    stations, angles = orientation[:, :3], orientation[:, 3:]
    M = np.array([matrix(*one) for one in angles])
    N = _normal(M, stations[1] - stations[0])
    return images, stations, M, N, profile.astype(int)


# --- What is handed in ---


def judge(truth: Truth, result: object) -> list[Part]:
    """Count the heights that are wrong or missing, and compare their precision."""
    Z, sd = _read(truth, result)
    wrong = np.sum(~(np.abs(Z - truth.ground[:, 2]) <= REACH * truth.sd))  # or NaN
    factor = np.exp(np.abs(np.nanmedian(np.log(sd / truth.sd))))
    name = f"heights missing, or off by over {REACH:g} standard deviations"
    return [
        Part(name, wrong, SPARE, ""),
        Part("standard deviations off by a factor of", factor, 1.2, ""),
    ]


def _read(truth: Truth, result: object) -> np.ndarray:
    """Return heights and standard deviations (2, n), NaN where a height is missing."""
    n = len(truth.ground)
    wanted = f"{n} rows, each a height and its standard deviation in m"
    try:
        array = np.array(result, dtype=float)
    except (TypeError, ValueError):
        raise CheckFailed(f"the result must be {wanted}") from None
    numbers("the result", np.nan_to_num(array), (n, 2), wanted)
    Z, sd = array.T
    if np.isnan(Z).all() or not np.all(sd[np.isfinite(Z)] > 0):
        raise CheckFailed(f"the result must be {wanted}, which is positive")
    return np.array([Z, np.where(np.isfinite(Z), sd, np.nan)])


def slips(truth: Truth) -> dict[str, np.ndarray]:
    """Return what the likeliest wrong programs give."""
    Z, Z0, sd = truth.ground[:, 2], truth.station, truth.sd
    wrong = {
        "Those are heights above the left station, which lies at Z0.": (Z - Z0, sd),
        "A model point lies in the frame of the base: rotate it into object space.": (
            Z0 - truth.depth,
            sd,
        ),
        "The standard deviation is that of a position across the ray: what does the"
        " ratio of height and base do to it?": (Z, sd * truth.base / (Z0 - Z)),
        "The standard deviation is that of a whole pixel of parallax.": (Z, sd / SIGMA),
    }
    return {words: np.column_stack(both) for words, both in wrong.items()}


def hint(truth: Truth, result: object) -> str:
    """Return the hint to the slip that explains most of the heights, and their sd."""
    Z, sd = _read(truth, result)
    for words, wrong in slips(truth).items():
        explained = np.sum(np.abs(Z - wrong[:, 0]) <= REACH * truth.sd)
        factor = np.abs(np.log(np.nanmedian(sd / wrong[:, 1])))
        if explained >= len(Z) - SPARE and factor < 0.1:
            return words
    if judge(truth, result)[0].holds:
        return (
            "The heights are right. The sd of each, in m, follows from H/B, the GSD"
            " and 0.12 px, with the depth of the point for H."
        )
    return (
        "Show your two normal images, one above the other: does every row show the same"
        " things? If they do, the slip comes after the search: parallax in mm, the"
        " station and the signs of the model point, N transposed."
    )


def picture(truth: Truth, result: object) -> tuple[Figure, str]:
    """Draw the profile with its standard deviations on the land as it is."""
    Z, sd = _read(truth, result)
    X, Y, land = truth.ground.T
    along = np.hypot(X - X[0], Y - Y[0])
    fig, ax = plt.subplots(figsize=(10, 4.5))
    ax.plot(along, land, color=plot.ORANGE, label="the land")
    ax.errorbar(along, Z, REACH * sd, fmt="o", label="yours, ± 3 standard deviations")
    ax.set(xlabel="along the profile (m)", ylabel="height (m)")
    ax.set_ylim(land.min() - 1, land.max() + 1)
    ax.legend()
    return fig, (
        f"A profile {along[-1]:.0f} m long: your heights, with bars of three standard"
        " deviations, and the land as a line."
    )
