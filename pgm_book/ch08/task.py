"""The task of chapter 8: a profile of heights from two photos as they were taken."""

from dataclasses import dataclass
from functools import cache

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import gaussian_filter, map_coordinates, uniform_filter

from pgm_book.common.checks import CheckFailed, near, numbers
from pgm_book.task import Part, grey, table
from pgm_lab import datasets, frames, plot
from pgm_lab.rotation import matrix

C, PIXEL, SIZE = 8.0, 0.02, (400, 280)  # mm, mm, and columns and rows
HEIGHT, BASE, GRAIN = 60.0, 18.0, 0.1  # m: of flight and base; a pixel of the texture
SIGMA, NOISE = 0.12, 1.5  # px: of a disparity; grey values
STATIONS = 40  # of the profile
SEARCH = -168, -100  # px: columns from the left pixel to the ends of the right strip
REACH = 3.0  # standard deviations
WHOLE = (
    "Those are whole pixels of disparity: through r beside the summit goes a parabola."
)
SPARE = 4  # heights that may be missing or lie beyond it: blunders of the matching


@dataclass(frozen=True)
class Truth:
    """The two photos, the land below them, and the profile."""

    exteriors: np.ndarray  # (2, 6), m and rad
    hills: np.ndarray  # (3, 4): X, Y, height, width, m
    pixels: np.ndarray  # (n, 2) of the profile, in the left photo
    ground: np.ndarray  # (n, 3), m

    @property
    def base(self) -> float:
        """Length of the base in m."""
        return float(np.linalg.norm(self.exteriors[1, :3] - self.exteriors[0, :3]))

    @property
    def depth(self) -> np.ndarray:
        """How far (n,) the ground lies before the normal case of the photos, m."""
        seen = (self.ground - self.exteriors[0, :3]) @ _normal(self.exteriors).T
        return -seen[:, 2]

    def disparity(self, Z: np.ndarray) -> np.ndarray:
        """Disparities (n,) in px that belong to heights."""
        down = self.exteriors[0, 2] - np.array([self.ground[:, 2], Z])
        return self.base * C / PIXEL / self.depth * down[0] / down[1]

    @property
    def sd(self) -> np.ndarray:
        """Standard deviations (n,) of the heights in m: H/B, times GSD, times SIGMA."""
        depth = self.exteriors[0, 2] - self.ground[:, 2]
        return depth / self.base * depth / C * PIXEL * SIGMA


# --- What is given ---


def make(chance: np.random.RandomState) -> tuple[dict, Truth]:
    """Two tilted photos of hilly land, their orientation, and pixels of a profile."""
    hills = np.column_stack(
        [
            chance.uniform((-14, -14), (14, 14), (3, 2)),
            chance.uniform(2, 4, 3),
            chance.uniform(10, 16, 3),
        ]
    )
    tilt = chance.choice([-5, 5]) * np.array([1, 0]) + chance.uniform(-2, 2, (2, 2))
    turn = np.radians(chance.uniform(6, 16, 2) * chance.choice([-1, 1], 2))
    place = chance.uniform(-0.8, 0.8, (2, 3)) + [(-BASE / 2, 0, HEIGHT)] * 2
    place[1, 0] += BASE
    exteriors = np.column_stack([place.round(3), np.radians(tilt), turn]).round(6)
    corner = chance.randint(0, 600, 2)
    images = [
        _photo(one, hills, corner, gain, chance)
        for one, gain in zip(exteriors, (1.0, 0.85))
    ]
    pixels, ground = _profile(exteriors, hills, images[0], chance)
    head = "photo,X0_m,Y0_m,Z0_m,omega_rad,phi_rad,kappa_rad"
    rows = [(name, *e) for name, e in zip(("left.png", "right.png"), exteriors)]
    numbered = [(k, *pixel) for k, pixel in enumerate(pixels, 1)]
    files = {
        "left.png": images[0],
        "right.png": images[1],
        "orientation.csv": table(head, "{}" + 3 * ",{:.3f}" + 3 * ",{:.6f}", rows),
        "profile.csv": table("number,column,row", "{},{},{}", numbered),
    }
    return files, Truth(exteriors, hills, pixels, ground)


@cache
def _texture() -> np.ndarray:
    """An aerial photo of a meadow, as fine as the photos can show it."""
    return gaussian_filter(datasets.yellowstone().grey.astype(float), 0.7)


def _height(hills: np.ndarray, X: np.ndarray, Y: np.ndarray) -> np.ndarray:
    return sum(
        top * np.exp(-((X - x) ** 2 + (Y - y) ** 2) / (2 * width**2))
        for x, y, top, width in hills
    )


def _ground(exterior: np.ndarray, hills: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """Points (..., 3) at which the rays of pixels meet the land."""
    xy = frames.pixel_to_photo(pixels, SIZE, PIXEL)
    rays = np.concatenate([xy, np.full_like(xy[..., :1], -C)], -1)
    rays = rays @ matrix(*exterior[3:])
    Z = np.zeros(rays.shape[:-1])
    for _ in range(30):  # each time nearer by the slope of the land
        points = exterior[:3] + rays * ((Z - exterior[2]) / rays[..., 2])[..., None]
        Z = _height(hills, points[..., 0], points[..., 1])
    return np.concatenate([points[..., :2], Z[..., None]], -1)


def _photo(
    exterior: np.ndarray,
    hills: np.ndarray,
    corner: np.ndarray,
    gain: float,
    chance: np.random.RandomState,
) -> np.ndarray:
    """Grey values of a photo of the land, with the noise of a camera."""
    columns, rows = SIZE
    pixels = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), -1)
    X, Y, _ = np.moveaxis(_ground(exterior, hills, pixels), -1, 0)
    place = [corner[0] + 450 - Y / GRAIN, corner[1] + 450 + X / GRAIN]
    values = gain * map_coordinates(_texture(), place, order=3, mode="reflect")
    return grey(values + 10 + NOISE * chance.standard_normal(values.shape))


def _normal(exteriors: np.ndarray) -> np.ndarray:
    """Rotation (3, 3) from object space into the normal case of two photos."""
    base = exteriors[1, :3] - exteriors[0, :3]
    up = matrix(*exteriors[0, 3:])[2] + matrix(*exteriors[1, 3:])[2]
    axes = [base, np.cross(up, base), np.cross(base, np.cross(up, base))]
    return np.array([axis / np.linalg.norm(axis) for axis in axes])


def _profile(
    exteriors: np.ndarray,
    hills: np.ndarray,
    image: np.ndarray,
    chance: np.random.RandomState,
) -> tuple[np.ndarray, np.ndarray]:
    """Pixels of the left photo in a straight row, and where they are on the ground.

    Of fifteen rows that normal images as large as the photos show, with room for a
    search, the one whose windows have the most contrast where they have least.
    """
    mean, square = (uniform_filter(image.astype(float) ** k, 9) for k in (1, 2))
    variance = square - mean**2
    N = _normal(exteriors)
    turns = [matrix(*one[3:]) @ N.T for one in exteriors]  # normal case to photo
    searched = np.array([(x, y) for x in SEARCH for y in (-8, 8)])
    found: list = []
    while len(found) < 15:
        ends = chance.uniform((100, 30), np.subtract(SIZE, 30), (2, 2))
        if np.hypot(*(ends[1] - ends[0])) < 140:
            continue
        steps = np.linspace(0, 1, STATIONS)[:, None]
        pixels = np.round(ends[0] + steps * (ends[1] - ends[0])).astype(int)
        there = _rotated(pixels, turns[0].T)
        corners = there[:, None] + searched  # of the strips in the right image
        places = [there, corners, _rotated(corners, turns[1])]
        if all(np.all((p > 5) & (p < np.subtract(SIZE, 6))) for p in places):
            low = variance[pixels[:, 1], pixels[:, 0]].min()
            found.append((low, pixels))
    pixels = max(found, key=lambda one: one[0])[1]
    return pixels, _ground(exteriors[0], hills, pixels)


def _rotated(pixels: np.ndarray, R: np.ndarray) -> np.ndarray:
    """Pixels (..., 2) of the same rays for a camera that turned by R (3, 3)."""
    middle, up = np.subtract(SIZE, 1) / 2, np.array([PIXEL, -PIXEL])
    xy = (pixels - middle) * up
    rays = np.concatenate([xy, np.full_like(xy[..., :1], -C)], -1) @ R.T
    return -C * rays[..., :2] / rays[..., 2:] / up + middle


# --- What is handed in ---


def judge(truth: Truth, result: object) -> list[Part]:
    """Count the heights that are wrong or missing, and compare their precision."""
    Z, sd = _read(truth, result)
    wrong = np.sum(~(np.abs(Z - truth.ground[:, 2]) <= REACH * truth.sd))  # or NaN
    factor = np.exp(np.abs(np.nanmedian(np.log(sd / truth.sd))))
    return [
        Part(
            f"heights missing, or off by over {REACH:g} standard deviations",
            wrong,
            SPARE,
            "",
        ),
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
    array = array.T if array.shape == (2, n) else array
    numbers("the result", np.nan_to_num(array), (n, 2), wanted)
    Z, sd = array.T
    if np.isnan(Z).all() or not np.all(sd[np.isfinite(Z)] > 0):
        raise CheckFailed(f"the result must be {wanted}, which is positive")
    return np.array([Z, np.where(np.isfinite(Z), sd, np.nan)])


def slips(truth: Truth) -> dict[str, np.ndarray]:
    """Return what the likeliest wrong programs give."""
    Z, Z0 = truth.ground[:, 2], truth.exteriors[0, 2]
    d = truth.disparity(Z)
    wrong = {
        "Those are heights above the left station, which lies at Z0.": (
            Z - Z0,
            truth.sd,
        ),
        "A model point lies in the frame of the base: rotate it into object space.": (
            Z0 - truth.depth,
            truth.sd,
        ),
        "The standard deviation is that of a position across the ray: what does the"
        " ratio of height and base do to it?": (Z, truth.sd * truth.base / (Z0 - Z)),
        "The standard deviation is that of a whole pixel of parallax.": (
            Z,
            truth.sd / SIGMA,
        ),
        WHOLE: (Z0 - (Z0 - Z) * d / np.rint(d), truth.sd),
    }
    return {words: np.column_stack(both) for words, both in wrong.items()}


def hint(truth: Truth, result: object) -> str:
    """Return the hint to the slip that explains most of the heights, and their sd."""
    Z, sd = _read(truth, result)
    d = truth.disparity(Z)
    if np.nanmedian(np.abs(d - np.rint(d))) < 0.02:
        return WHOLE
    for words, wrong in slips(truth).items():
        explained = np.abs(Z - wrong[:, 0]) <= REACH * truth.sd
        if explained.sum() >= len(Z) - SPARE and near(
            np.log(np.nanmedian(sd / wrong[:, 1])), 0, 0.1
        ):
            return words
    if judge(truth, result)[0].holds:
        return (
            "The heights are right. The sd of each, in m, follows from H/B, the GSD"
            " and 0.12 px, with the depth of the point for H."
        )
    return (
        "Show your two normal images, one above the other: does every row show the same"
        " things? The pixels of the profile belong to the photo as it was taken: where"
        " are they in the normal image? Then look at the disparities, and at their r."
    )


def picture(truth: Truth, result: object) -> tuple[Figure, str]:
    """Draw the profile with its standard deviations on the land as it is."""
    Z, sd = _read(truth, result)
    along = np.hypot(*(truth.ground[:, :2] - truth.ground[0, :2]).T)
    fig, ax = plt.subplots(figsize=(10, 4.5))
    ax.plot(along, truth.ground[:, 2], color=plot.ORANGE, label="the land")
    ax.errorbar(along, Z, REACH * sd, fmt="o", label="yours, ± 3 standard deviations")
    low, high = np.min(truth.ground[:, 2]), np.max(truth.ground[:, 2])
    ax.set(
        xlabel="along the profile (m)", ylabel="height (m)", ylim=(low - 1, high + 1)
    )
    ax.legend()
    return fig, (
        f"A profile {along[-1]:.0f} m long: your heights, with bars of three standard"
        " deviations, and the land as a line."
    )
