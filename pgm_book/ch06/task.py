"""The task of chapter 6: calibrate a camera from photos with a blunder."""

from dataclasses import dataclass
from functools import cached_property

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_book.common.checks import CheckFailed
from pgm_book.program.bundle import adjust, without_lens
from pgm_book.program.camera import project
from pgm_book.task import Part, named, table
from pgm_lab import plot, rotation

NOMINAL, SIGMA = 24.0, 0.0005  # mm: of c, and of a measured image coordinate
FORMAT = (12.0, 8.0)  # mm, half of the image
WANTED = {
    "c": ("one number, in mm", ()),
    "sd": ("its standard deviation in mm, a positive number", ()),
    "ray": ("two numbers, photo and point", (2,)),
}

INCLUDED = "This still contains the blunder: leave that ray out, and adjust once more."
OTHER_RAY = (
    "The ray: resect every photo with the camera and the targets that you found, and"
    " look at what remains, ray by ray."
)
FROM_0 = "The ray: photo and point as the files number them, from 1."
VARIANCE = "The diagonal of C holds variances."
UNIT = "Both c and its standard deviation are wanted in mm."
OTHER_C = "c: use all other rays, all ten parameters, and start at 24 mm."


@dataclass(frozen=True)
class Truth:
    """The camera, what was measured without the blunder, and where that lies."""

    c: float
    photo: np.ndarray  # of each ray, from 0
    point: np.ndarray
    xy: np.ndarray  # mm
    start: tuple[np.ndarray, np.ndarray]  # of photos and points
    bad: int  # ray
    blunder: np.ndarray  # mm

    @property
    def ray(self) -> tuple[int, int]:
        """Photo and point of the blunder, from 1."""
        return int(self.photo[self.bad]) + 1, int(self.point[self.bad]) + 1

    @property
    def measured(self) -> np.ndarray:
        """Image points with the blunder, mm."""
        xy = self.xy.copy()
        xy[self.bad] += self.blunder
        return xy

    @cached_property
    def best(self) -> tuple[float, float]:
        """Principal distance without the blunder; its sd for the stated sigma."""
        c, sd, sigma0 = self.adjusted(np.delete(np.arange(len(self.xy)), self.bad))
        return c, sd / sigma0

    @cached_property
    def spoiled(self) -> tuple[float, float]:
        """Principal distance and standard deviation where the blunder takes part."""
        return self.adjusted(np.arange(len(self.xy)))[:2]

    def adjusted(self, used: np.ndarray) -> tuple[float, float, float]:
        """Principal distance, its standard deviation and sigma0 from some rays."""
        camera = np.array([NOMINAL, *np.zeros(9)])
        rays = self.photo[used], self.point[used], self.measured[used]
        camera, C, sigma0, _ = adjust(*rays, SIGMA, camera, *self.start)
        return camera[0], np.sqrt(C[0, 0]), sigma0


def make(chance: np.random.RandomState) -> tuple[dict[str, str], Truth]:
    """Eight photos of 48 targets from all sides; one image point is wrong."""
    size = np.array([0.4, 0.1, 0.1, 2e-5, 1e-7, 3e-10, 1e-5, 1e-5, 3e-4, 3e-4])
    camera = size * chance.uniform(-1, 1, 10)
    camera += (NOMINAL, 0, 0, 6e-5, -3e-7, 6e-10, 0, 0, 0, 0)
    # A wall of 1.6 by 1 m with steps
    X, Y = np.meshgrid(np.linspace(-800, 800, 8), np.linspace(-520, 520, 6))
    points = np.column_stack([X.ravel(), Y.ravel(), 250.0 * chance.randint(0, 2, 48)])
    points += chance.uniform(-60, 60, (48, 3))
    exteriors = _round_about(chance)
    ideal = np.concatenate([project(e, points, camera[0]) for e in exteriors])
    xy = ideal.copy()
    for _ in range(20):  # each step leaves a hundredth of the error
        xy += ideal - without_lens(xy, camera)
    seen = np.all(np.abs(xy) < FORMAT, axis=1)
    photo, point = np.indices((8, 48)).reshape(2, -1)[:, seen]
    xy = np.round(xy[seen] + SIGMA * chance.standard_normal(xy[seen].shape), 5)
    often = np.bincount(point)[point] > 5  # or nothing would control that ray
    bad = int(chance.choice(np.flatnonzero(often & (photo > 0))))
    direction = chance.uniform(0, 2 * np.pi)
    blunder = np.array([np.cos(direction), np.sin(direction)])
    blunder = np.round(chance.uniform(0.02, 0.04) * blunder, 5)
    near = np.array([5, 5, 5, 0.003, 0.003, 0.003])
    start = (
        np.round(exteriors + near * chance.uniform(-1, 1, (8, 6)), 4),
        np.round(points + 5 * chance.uniform(-1, 1, (48, 3)), 1),
    )
    truth = Truth(camera[0], photo, point, xy, start, bad, blunder)
    c, sd = truth.best
    if abs(c - truth.c) > 2.5 * sd:  # who is right must pass
        return make(chance)
    rays = zip(photo + 1, point + 1, *truth.measured.T)
    photos, targets = ([(k, *v) for k, v in enumerate(s, 1)] for s in start)
    photo_head = "photo,X0_mm,Y0_mm,Z0_mm,omega_rad,phi_rad,kappa_rad"
    number = ",{:.4f}"
    return {
        "image_points.csv": table("photo,point,x_mm,y_mm", "{},{},{:.5f},{:.5f}", rays),
        "photos.csv": table(photo_head, "{}" + 6 * number, photos),
        "targets.csv": table("point,X_mm,Y_mm,Z_mm", "{}" + 3 * number, targets),
    }, truth


def _round_about(chance: np.random.RandomState) -> np.ndarray:
    """Photos (8, 6) that look at the middle of the targets from all sides."""
    around = np.arange(8) * np.pi / 4
    kappa = np.array([0, 1.5, 3, -1.5] * 2)
    angles = np.column_stack([0.6 * np.sin(around), 0.6 * np.cos(around), kappa])
    angles += chance.uniform(-0.05, 0.05, (8, 3))
    axes = np.array([rotation.matrix(*one)[2] for one in angles])
    return np.hstack([chance.uniform(2000, 2400, (8, 1)) * axes, angles])


def judge(truth: Truth, result: object) -> list[Part]:
    """Return how far c is off, and whether its precision and the ray are right."""
    c, sd, ray = _answer(result)
    _, best = truth.best
    chance = 1 / np.sqrt(2 * (2 * len(truth.xy) - 2 - 10 - 42 - 144))  # of sigma0
    return [
        Part("c", abs(c - truth.c) / best),
        Part("its standard deviation", abs(np.log(sd / best)) / chance),
        Part("the ray", float(ray != truth.ray), 0),
    ]


def _answer(result: object) -> tuple[float, float, tuple[int, int]]:
    """Return c, its standard deviation and the ray; or say what is wanted."""
    c, sd, ray = named(result, WANTED).values()
    if not sd > 0:
        raise CheckFailed("a standard deviation is positive")
    return c, sd, (int(ray[0]), int(ray[1]))


def slips(truth: Truth) -> dict[str, tuple]:
    """Return what the likeliest wrong programs give."""
    (c, s), ray = truth.best, truth.ray
    return {
        INCLUDED: (*truth.spoiled, ray),
        OTHER_RAY: (c, s, (ray[0], ray[1] % 48 + 1)),
        FROM_0: (c, s, (ray[0] - 1, ray[1] - 1)),
        VARIANCE: (c, s**2, ray),
        UNIT: (c, 1000 * s, ray),
        OTHER_C: (c + 10 * s, s, ray),
    }


def hint(truth: Truth, result: object) -> str:
    """Return the hint to the first part that is wrong."""
    _, sd, ray = _answer(result)
    if ray != truth.ray:
        less = (truth.ray[0] - 1, truth.ray[1] - 1)
        return FROM_0 if ray == less else OTHER_RAY
    best, spoiled = truth.best[1], truth.spoiled[1]
    for value, words in (
        (best**2, VARIANCE),
        (spoiled**2, VARIANCE),
        (1000 * best, UNIT),
        (spoiled, INCLUDED),
    ):
        if abs(sd / value - 1) < 0.1:
            return words
    return OTHER_C


def picture(truth: Truth, result: object) -> tuple[Figure, str]:
    """Draw c beside the truth and beside what came out with the blunder."""
    c, sd, ray = _answer(result)
    fig, ax = plt.subplots(figsize=(7, 3.5), layout="constrained")
    ax.axvline(truth.c, color=plot.BLACK, lw=3, label="truth")
    for y, (value, spread) in enumerate(((c, sd), truth.spoiled)):
        colour = (plot.BLUE, plot.RED)[y]
        ax.errorbar(value, -y, xerr=spread, fmt="o", color=colour, lw=3, capsize=6)
    ax.set_yticks([0, -1], ["yours", "with the blunder"])
    ax.set(ylim=(-1.6, 0.9), xlabel="c (mm), ± one standard deviation")
    ax.locator_params(axis="x", nbins=5)
    ax.legend(loc="upper left")
    size = 1000 * np.hypot(*truth.blunder)
    ax.set_title(f"photo {ray[0]}, point {ray[1]}: {size:.0f} µm off")
    return fig, (
        "Your principal distance with its standard deviation beside the truth, and"
        " what came out with the blunder."
    )
