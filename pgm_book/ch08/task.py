"""The task of chapter 8: a profile of heights from two photos as they were taken."""

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import gaussian_filter, map_coordinates

from pgm_book.common.checks import CheckFailed
from pgm_book.program.stereo import best_disparity
from pgm_book.program.surface import WINDOW, normal_case
from pgm_book.task import Answer, Part, grey, table
from pgm_lab import datasets, plot
from pgm_lab.camera import Camera, Photo
from pgm_lab.rotation import angles, matrix
from pgm_lab.stereo.normal import normal_frame

C, PIXEL, SIZE = 8.0, 0.02, (400, 280)  # mm, mm, and columns and rows
HEIGHT, BASE, GRAIN = 60.0, 18.0, 0.1  # m: of flight and base; a pixel of the texture
SIGMA, NOISE = 0.12, 1.0  # px: of a disparity; grey values
SEARCH = 100, 168  # px: between which all disparities lie
POINTS, REACH = 40, 3.0  # of the profile; standard deviations
SPARE = 4  # heights that may be missing or lie beyond it: blunders of the matching


@dataclass(frozen=True)
class Truth:
    """Two photos, the pixels of a profile, and what they show."""

    answer: Answer  # heights (n,) and their standard deviations, m
    photos: list[Photo]
    N: np.ndarray
    base: float  # m
    pixels: np.ndarray  # (n, 2) in the left image of the normal case
    disparity: np.ndarray  # (n,), px
    model: np.ndarray  # (n, 3), m, in the normal case, seen from the left station
    ground: np.ndarray  # (n, 3), m


def make(chance: np.random.RandomState) -> tuple[dict, Truth]:
    """Two tilted photos of hilly land, their orientation, and pixels of a profile."""
    hills = chance.uniform((-14, -14, 2, 12), (14, 14, 3.5, 18), (3, 4))
    sea = chance.randint(200, 900)  # m below: the height of a station is no depth
    hills = np.vstack([hills, (0, 0, sea, 1e9)])
    tilt = (chance.choice([-5, 5]), 0) + chance.uniform(-2, 2, (2, 2))
    turn = chance.uniform(6, 16, (2, 1)) * chance.choice([-1, 1], (2, 1))
    # Neither along X nor level: the length of the base and its left end matter
    course, rise = chance.choice([-1, 1], 2) * chance.uniform((9, 0.5), (13, 0.7))
    along = BASE * matrix(0, 0, np.radians(course))[0] + (0, 0, rise)
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
    pixels = _profile(photos, normal, chance)
    ground = _ground(normal[0], hills, pixels)
    model = (ground - stations[0]) @ N.T
    depth, base = -model[:, 2], float(np.linalg.norm(stations[1] - stations[0]))
    disparity, sd = C * base / (depth * PIXEL), depth**2 / base / C * PIXEL * SIGMA
    answer = {"Z": ground[:, 2], "sd": sd}
    files = {"left.png": photos[0].grey, "right.png": photos[1].grey}
    head = "photo,X0_m,Y0_m,Z0_m,omega_rad,phi_rad,kappa_rad"
    rows = [(name, *photo.exterior) for name, photo in zip(files, photos)]
    return files | {
        "orientation.csv": table(head, "{}" + 3 * ",{:.3f}" + 3 * ",{:.6f}", rows),
        "profile.csv": table("column,row", "{},{}", pixels),
    }, Truth(answer, photos, N, base, pixels, disparity, model, ground)


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
    photos: list[Photo], normal: list[Photo], chance: np.random.RandomState
) -> np.ndarray:
    """Pixels (n, 2) in a straight line through the left image of the normal case.

    Both photos show them, and the left and right ends of a search.
    """
    searched = [(-d, y) for d in SEARCH for y in (-8, 8)]
    while True:
        ends = chance.uniform((SIZE[0] - 220, 30), np.subtract(SIZE, 30), (2, 2))
        pixels = np.linspace(ends[0], ends[1], POINTS).round().astype(int)
        strips = pixels[:, None] + searched
        seen = [
            p.of_rays(n.rays(s)) for p, n, s in zip(photos, normal, (pixels, strips))
        ]
        inside = [np.all((p > 5) & (p < np.subtract(SIZE, 6))) for p in (*seen, strips)]
        if all(inside) and np.hypot(*(ends[1] - ends[0])) > 140:
            return pixels


def given(folder: Path) -> tuple:
    """Both photos, their stations, M of each, N of the normal case, and the profile."""
    orientation, profile = (
        np.loadtxt(folder / name, delimiter=",", skiprows=1, usecols=columns)
        for name, columns in (("orientation.csv", range(1, 7)), ("profile.csv", (0, 1)))
    )
    images = [plt.imread(folder / name) for name in ("left.png", "right.png")]
    photos = [Photo(i, Camera(C), e, PIXEL) for i, e in zip(images, orientation)]
    turns = np.array([matrix(*e[3:]) for e in orientation])
    return images, orientation[:, :3], turns, normal_frame(*photos), profile.astype(int)


def judge(truth: Truth, found: Answer) -> list[Part]:
    """Count the heights that are wrong or missing, and compare their precision."""
    Z, sd = truth.answer.values()
    wrong = np.sum(~(np.abs(found["Z"] - Z) <= REACH * sd))  # or NaN
    factor = np.exp(np.abs(np.nanmedian(np.log(found["sd"] / sd))))
    name = f"heights missing, or off by over {REACH:g} standard deviations"
    return [
        Part(name, wrong, SPARE, ""),
        Part("standard deviations off by a factor of", factor.round(2), 1.2, ""),
    ]


def read(result: object) -> Answer:
    """Return heights and standard deviations (n,), NaN where a height is missing."""
    wanted = f"{POINTS} rows of height and standard deviation (> 0), m, not all NaN"
    try:
        Z, sd = np.array(result, dtype=float).T
    except (TypeError, ValueError):
        raise CheckFailed(f"the result must be {wanted}") from None
    there = np.isfinite(Z)
    if Z.shape != (POINTS,) or not there.any() or not np.all(sd[there] > 0):
        raise CheckFailed(f"the result must be {wanted}")
    return {"Z": Z, "sd": np.where(there, sd, np.nan)}


def slips(truth: Truth) -> dict[str, Answer]:
    """Return what the likeliest wrong programs give: first wrong heights, then sd."""
    first, second = (photo.exterior for photo in truth.photos)
    M = [matrix(*first[3:]), matrix(*second[3:])]
    m, N, Z0, (Z, sd) = truth.model, truth.N, first[2], truth.answer.values()

    def searched(turns: list, N: np.ndarray, order: int = 1) -> np.ndarray:
        """Heights from images whose rows show different things."""
        photos = zip(truth.photos, turns)
        pair = [normal_case(p.grey * 1.0, M, N, C, PIXEL) for p, M in photos]
        left, right, d = *pair[::order], np.full(POINTS, np.nan)
        for k, (column, row) in enumerate(truth.pixels):
            with suppress(ValueError):  # where one shows nothing
                d[k], _ = best_disparity(left, right, column, row, WINDOW, *SEARCH)
        return Z0 + (Z - Z0) * truth.disparity / d

    heights = {
        "Those are depths: m stands at O' + N^T m, and its Z is wanted.": -m[:, 2],
        "That is the third of m, which stands at O' + N^T m.": m[:, 2],
        "m lies in the frame of the base: N^T rotates it.": Z0 + m[:, 2],
        "Those are heights above the left station: add its Z.": Z - Z0,
        "N^T leads into object space, and N out of it.": Z0 + m @ N[2],
        "m is seen from O', the left station.": Z - Z0 + second[2],
        "The stations differ in Y and Z as well: B is their distance.": (
            Z0 + (Z - Z0) * abs(second[0] - first[0]) / truth.base
        ),
        "The ground lies below the camera: m has -c.": Z0 + m * (1, 1, -1) @ N[:, 2],
        "A parallax is wanted in mm, not in pixels.": Z0 + (Z - Z0) * PIXEL,
        "Both photos have to be rotated into the normal case.": searched([N, N], N),
        "Your normal case has M transposed.": searched([one.T for one in M], N),
        "Your normal case has N for its transpose.": searched(M, N.T),
        "The pixels lie in the left image: it comes first.": searched(M, N, -1),
    }
    precisions = {
        "H is the depth of each point below the camera.": sd * (Z0 / m[:, 2]) ** 2,
        "What does H/B do to the sd of a position?": -sd * truth.base / m[:, 2],
        "That is the sd for a whole pixel of parallax.": sd / SIGMA,
    }
    wrong = {words: {"Z": Z} for words, Z in heights.items()}
    return wrong | {words: {"sd": sd} for words, sd in precisions.items()}


def hint(truth: Truth, found: Answer, wrong: list[str]) -> str:
    """Return the hint to the slip that explains the heights or, if they hold, sd."""
    part = "Z" if wrong[0].startswith("heights") else "sd"
    atol = REACH * truth.answer["sd"] if part == "Z" else 0.1 * found["sd"]
    for words, slip in slips(truth).items():
        if part in slip:
            same = np.isclose(found[part], slip[part], 0, atol, equal_nan=True)
            if np.mean(same) > 0.75:
                return words
    if part == "sd":
        return "The heights hold. sd is H/B times GSD times 0.12 px, by each depth."
    Z0, (low, high) = truth.photos[0].exterior[2], SEARCH
    d = truth.disparity * (truth.answer["Z"] - Z0) / (found["Z"] - Z0)
    if np.nanmedian(np.abs(d - (low + high) / 2)) > (high - low) / 2:
        return (
            f"Most heights belong to disparities that are not from {low} to {high} px:"
            " where does the search begin and end, and is each the Z of O' + N^T m?"
        )
    return (
        "Show both normal images, one above the other: does each row show the same"
        " things? chapter8.normal_case names slips in them. If so: the search goes from"
        f" {low} to {high} px, a window of 9 px will do, and each point has its depth."
    )


def picture(truth: Truth, found: Answer) -> tuple[Figure, str]:
    """Draw the profile with its standard deviations on the land as it is."""
    Z, sd = found.values()
    X, Y, land = truth.ground.T
    along = np.hypot(X - X[0], Y - Y[0])
    fig, ax = plt.subplots(figsize=(10, 4.5))
    ax.plot(along, land, color=plot.ORANGE, label="the land")
    ax.errorbar(along, Z, REACH * sd, fmt="o", label="yours, ± 3 standard deviations")
    ax.set(xlabel="along the profile (m)", ylabel="height (m)")
    ax.set_ylim(land.min() - 1, land.max() + 1)
    ax.legend()
    alt = f"A profile {along[-1]:.0f} m long: your heights with bars, and the land."
    return fig, alt
