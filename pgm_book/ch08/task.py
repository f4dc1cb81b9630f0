"""The task of chapter 8: a profile of heights from two photos as they were taken."""

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import gaussian_filter, map_coordinates

from pgm_book.common.checks import CheckFailed
from pgm_book.program.stereo import best_disparity
from pgm_book.program.surface import WINDOW, normal_case
from pgm_book.task import Answer, Part, grey, likeliest, table
from pgm_lab import datasets, plot
from pgm_lab.camera import Camera, Photo
from pgm_lab.rotation import angles, matrix
from pgm_lab.stereo.normal import normal_frame

C, PIXEL, SIZE = 8.0, 0.02, (400, 280)  # mm, mm, and columns and rows
HEIGHT, BASE, GRAIN = 70.0, 10.0, 0.1  # m: of flight and base; a pixel of the texture
SIGMA, NOISE = 0.12, 1.0  # px: of a disparity; grey values
SEARCH = 50, 100  # px: between which all disparities lie
POINTS, RELIEF = 40, 8.0  # of the profile: their number, and m that it climbs
PARTS = {  # and how many standard deviations each value may be off
    "Z": ("heights missing, or off by over 3 standard deviations", 3.0),
    "sd": ("standard deviations missing, or off by over 10 %", 0.1),
}
SPARE = 4  # values that may be missing or off by more: blunders of the matching


@dataclass(frozen=True, eq=False)
class Truth:
    """Two photos, the pixels of a profile, and what they show."""

    answer: Answer  # heights (n,) and their standard deviations, m
    sd: np.ndarray  # (n,), m
    photos: list[Photo]
    N: np.ndarray
    pixels: np.ndarray  # (n, 2) in the left image of the normal case
    disparity: np.ndarray  # (n,), px
    model: np.ndarray  # (n, 3), m, in the normal case, seen from the left station
    ground: np.ndarray  # (n, 3), m


def make(chance: np.random.RandomState) -> tuple[dict, Truth]:
    """Two tilted photos of hilly land, their orientation, and pixels of a profile."""
    hills = chance.uniform((-14, -14, 1, 14), (14, 14, 2, 18), (2, 4))
    sea = chance.randint(200, 900)  # m below: the height of a station is no depth
    turn = chance.uniform(6, 16, (2, 1)) * chance.choice([-1, 1], (2, 1))
    # Neither along X nor level: the length of the base and its left end matter
    course, rise = chance.choice([-1, 1], 2) * chance.uniform((12, 0.5), (15, 0.7))
    tilt = np.sort(chance.uniform((3, 0), (7, 2), (2, 2)), axis=0)  # not as N's is
    tilt *= chance.choice([-1, 1]), np.sign(rise)
    along = BASE * matrix(0, 0, np.radians(course))[0] + (0, 0, rise)
    # A slope, so that depth matters, and N differs from N^T along a profile up it
    slope = 28 * np.sign(rise), 28 * np.sign(tilt[0, 0]), 28, 40
    hills = np.vstack([hills, slope, (0, 0, sea, 1e9)])
    middle = np.append(chance.uniform(-0.8, 0.8, 2), sea + HEIGHT)
    stations = (middle + np.outer((-0.5, 0.5), along)).round(3)
    turns = np.radians(np.hstack([tilt, turn + course])).round(6)
    corner, gains = chance.randint(450, 1050, 2), (1.0, 0.85)
    every = np.stack(np.meshgrid(*map(np.arange, SIZE)), -1)
    photos = []
    for exterior, gain in zip(np.hstack([stations, turns]), gains):
        photo = Photo(np.zeros(SIZE[::-1]), Camera(C), exterior, PIXEL)
        X, Y, _ = np.moveaxis(_ground(photo, hills, every), -1, 0)
        place = [corner[0] - Y / GRAIN, corner[1] + X / GRAIN]
        values = gain * map_coordinates(_texture(), place, order=3) + 10
        values += NOISE * chance.standard_normal(values.shape)
        photos.append(replace(photo, grey=grey(values)))
    N = normal_frame(*photos)
    normal = [replace(p, exterior=np.append(p.exterior[:3], angles(N))) for p in photos]
    pixels, ground = _profile(photos, normal, hills, chance)
    model = (ground - stations[0]) @ N.T
    disparity = -C * np.linalg.norm(np.subtract(*stations)) / (model[:, 2] * PIXEL)
    sd = (stations[0, 2] - ground[:, 2]) * SIGMA / disparity  # of Z, not of the depth
    answer = {"Z": ground[:, 2], "sd": sd}
    files = {"left.png": photos[0].grey, "right.png": photos[1].grey}
    head = "photo,X0_m,Y0_m,Z0_m,omega_rad,phi_rad,kappa_rad"
    rows = [(name, *photo.exterior) for name, photo in zip(files, photos)]
    return files | {
        "orientation.csv": table(head, "{}" + 3 * ",{:.3f}" + 3 * ",{:.6f}", rows),
        "profile.csv": table("column,row", "{},{}", pixels),
    }, Truth(answer, sd, photos, N, pixels, disparity, model, ground)


@cache
def _texture() -> np.ndarray:
    """An aerial photo of a meadow, with the same contrast everywhere."""
    fine = gaussian_filter(datasets.yellowstone().grey.astype(float), 0.7)
    away = fine - gaussian_filter(fine, 10)
    return 120 + 25 * away / np.sqrt(gaussian_filter(away**2, 10))


def _ground(photo: Photo, hills: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """Points (..., 3) at which the rays of pixels meet the land."""
    station, rays = photo.exterior[:3], photo.rays(pixels)
    points = station + rays * -station[2] / rays[..., 2:]
    for _ in range(12):  # each time nearer by the slope of the land
        away = [(points[..., k, None] - hills[:, k]) / hills[:, 3] for k in (0, 1)]
        land = np.exp(-np.square(away).sum(axis=0) / 2) @ hills[:, 2:3]
        points = station + rays * (land - station[2]) / rays[..., 2:]
    return points


def _profile(
    photos: list, normal: list, hills: np.ndarray, chance: np.random.RandomState
) -> tuple[np.ndarray, np.ndarray]:
    """Pixels in a straight line through the left normal image, and what they show.

    Both photos show them, and the left and right ends of a search.
    """
    searched = [(-d, y) for d in SEARCH for y in (-8, 8)]
    while True:
        ends = chance.uniform((SIZE[0] - 270, 30), np.subtract(SIZE, 30), (2, 2))
        pixels = np.linspace(ends[0], ends[1], POINTS).round().astype(int)
        strips = pixels[:, None] + searched
        seen = [
            p.of_rays(n.rays(s)) for p, n, s in zip(photos, normal, (pixels, strips))
        ]
        inside = [np.all((p > 5) & (p < np.subtract(SIZE, 6))) for p in (*seen, strips)]
        ground = _ground(normal[0], hills, pixels)
        if all(inside) and np.ptp(ground[:, 2]) > RELIEF:
            return pixels, ground


def given(folder: Path) -> tuple:
    """Both photos, their stations, M of each, N and base of the normal case; pixels."""
    orientation, profile = (
        np.loadtxt(folder / name, delimiter=",", skiprows=1, usecols=columns)
        for name, columns in (("orientation.csv", range(1, 7)), ("profile.csv", (0, 1)))
    )
    images = [plt.imread(folder / name) for name in ("left.png", "right.png")]
    photos = [Photo(i, Camera(C), e, PIXEL) for i, e in zip(images, orientation)]
    turns = np.array([matrix(*e[3:]) for e in orientation])
    stations = orientation[:, :3]
    base = np.linalg.norm(stations[1] - stations[0])
    return images, stations, turns, normal_frame(*photos), base, profile.astype(int)


def judge(truth: Truth, found: Answer) -> list[Part]:
    """Count the heights and the standard deviations that are wrong or missing."""
    parts = []
    for name, (words, reach) in PARTS.items():
        pair, allowed = (found[name], truth.answer[name]), reach * truth.sd
        wrong = ~np.isclose(*pair, 0, allowed, equal_nan=True)  # NaN: of a slip
        parts.append(Part(words, wrong.sum(), SPARE, ""))
    return parts


def read(result: object) -> Answer:
    """Return heights and standard deviations (n,), NaN where a height is missing."""
    wanted = f"{POINTS} rows of height and standard deviation (> 0), m, not all NaN"
    try:
        Z, sd = np.array(result, dtype=float).T
    except (TypeError, ValueError):
        raise CheckFailed(f"the result must be {wanted}; is B one number?") from None
    there = np.isfinite(Z)
    if Z.shape != (POINTS,) or not there.any() or not np.all(sd[there] > 0):
        raise CheckFailed(f"the result must be {wanted}")
    return {"Z": Z, "sd": np.where(there, sd, np.nan)}


@lru_cache(maxsize=1)  # for each hint to one answer
def slips(truth: Truth) -> dict[str, Answer]:
    """Return what the likeliest wrong programs give: first wrong heights, then sd."""
    first, second = (photo.exterior for photo in truth.photos)
    M, base = [matrix(*e[3:]) for e in (first, second)], (second - first)[:3]
    m, N, B, d = truth.model, truth.N, np.linalg.norm(base), truth.disparity
    Z0, up, high, sd = first[2], N[:, 2], truth.answer["Z"] - first[2], truth.sd

    def searched(turns: list, N: np.ndarray, order: int = 1) -> np.ndarray:
        """Heights from images whose rows show different things."""
        photos = zip(truth.photos, turns)
        pair = [normal_case(p.grey * 1.0, M, N, C, PIXEL) for p, M in photos]
        left, right, found = *pair[::order], np.full(POINTS, np.nan)
        for k, (column, row) in enumerate(truth.pixels):
            with suppress(ValueError):  # where one shows nothing
                found[k], _ = best_disparity(left, right, column, row, WINDOW, *SEARCH)
        return Z0 + high * d / found

    heights = {
        "Those are depths: m stands at O' + N^T m, and its Z is wanted.": -m[:, 2],
        "That is the third of m, which stands at O' + N^T m.": m[:, 2],
        "m lies in the frame of the base: N^T rotates it.": Z0 + m[:, 2],
        "m lies in the normal case: N^T rotates it, not M.": Z0 + m @ M[0][:, 2],
        "Those are heights above the left station: add its Z.": high,
        "N^T leads into object space, and N out of it.": Z0 + m @ N[2],
        "m is seen from O', the left station.": high + second[2],
        "B is given: the stations differ in Y, too.": Z0 + high * abs(base[0]) / B,
        "B is a length, not a vector.": Z0 + m * base / B @ up,
        "The ground lies below the camera: m has -c.": Z0 + m * (1, 1, -1) @ up,
        "c is 8 mm here, not 24 mm.": Z0 + m * (1, 1, 3) @ up,
        "y points up, and rows count downwards.": Z0 + m * (1, -1, 1) @ up,
        "A parallax is wanted in mm, not in pixels.": Z0 + high * PIXEL,
        "Here column 0 has the same x in both photos: `normal` is another pair.": (
            Z0 + high * d * PIXEL / (9.47 + 0.00549 * d)
        ),
        "Add the peak of the parabola to a whole pixel.": Z0 + high * d / d.round(),
        "Both photos have to be rotated into the normal case.": searched([N, N], N),
        "Each photo has its own M.": searched(M[:1] * 2, N),
        "Your normal case has M transposed.": searched([one.T for one in M], N),
        "Your normal case has N for its transpose.": searched(M, N.T),
        "The pixels lie in the left image: it comes first.": searched(M, N, -1),
    }
    precisions = {
        "H is the depth of each point below the camera.": sd * (Z0 / m[:, 2]) ** 2,
        "sd needs H/B, and the GSD: 0.02 mm on the ground.": -sd * B / m[:, 2],
        "That is the sd for a whole pixel of parallax.": sd / SIGMA,
    }
    wrong = {words: {"Z": Z} for words, Z in heights.items()}
    return wrong | {words: {"sd": sd} for words, sd in precisions.items()}


def hint(truth: Truth, found: Answer, wrong: list[str]) -> str:
    """Return the hint to the slip that explains the heights or, if they hold, sd."""
    if words := likeliest(judge, truth, found, wrong[:1], slips(truth)):
        return words
    if wrong[0] == PARTS["sd"][0]:
        return "The heights hold. sd is H/B times GSD times 0.12 px, by each depth."
    return (
        f"Does the search go from {SEARCH[0]} to {SEARCH[1]} px, with a window of 9 px,"
        " and are B and c those of the task? If so, show both normal images, one above"
        " the other: each row has to show the same things. chapter8.normal_case names"
        " slips in them."
    )


def picture(truth: Truth, found: Answer) -> tuple[Figure, str]:
    """Draw the profile with its standard deviations on the land as it is."""
    Z, sd = found.values()
    X, Y, land = truth.ground.T
    along = np.hypot(X - X[0], Y - Y[0])
    fig, ax = plt.subplots(figsize=(10, 4.5))
    ax.plot(along, land, color=plot.ORANGE, label="the land")
    ax.errorbar(along, Z, 3 * sd, fmt="o", label="yours, ± 3 standard deviations")
    ax.set(xlabel="along the profile (m)", ylabel="height (m)")
    ax.set_ylim(land.min() - 1, land.max() + 1)
    ax.legend()
    alt = f"A profile {along[-1]:.0f} m long: your heights with bars, and the land."
    return fig, alt
