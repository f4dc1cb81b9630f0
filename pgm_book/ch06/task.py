"""The task of chapter 6: calibrate a camera from photos with a blunder and a gap."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_book.common.checks import CheckFailed
from pgm_book.program.bundle import adjust, without_lens
from pgm_book.program.camera import derivatives, project
from pgm_book.task import Part, named, table
from pgm_lab import plot, rotation

NAMES = ("c", "x0", "y0", "K1", "K2", "K3", "P1", "P2", "b1", "b2")
NOMINAL, SIGMA = 24.0, 0.0005  # mm: of c, and of a measured image coordinate
FORMAT = (12.0, 8.0)  # mm, half of the image
CORNER = np.array([[10.0, 6.0]])  # mm, an image point in its corner
WANTED: dict[str, tuple[str, Any]] = {
    "c": ("one number, in mm", ()),
    "sd": ("its standard deviation in mm, a positive number", ()),
    "ray": ("two numbers, photo and point", (2,)),
    "parameter": (f"one of {', '.join(NAMES)}", None),
}

INCLUDED = "This still contains the blunder: leave that ray out, and adjust once more."
OTHER_RAY = (
    "The ray: resect every photo with the camera and the targets that you found, and"
    " look at what remains, ray by ray."
)
FROM_0 = "The ray: photo and point as the files number them, from 1."
VARIANCE = "The diagonal of C holds variances."
ROUNDED = "The standard deviation is rounded: hand it in with all its digits."
EXCHANGED = "The ray: the photo comes first, then the point."
UNIT = "Both c and its standard deviation are wanted in mm."
PARAMETER = (
    "The parameter: mm, mm⁻² and mm⁻⁶ cannot be compared. How far does one standard"
    " deviation of each move the image point (10, 6) mm?"
)
OTHER_C = "c: use all other rays, all ten parameters, and start at 24 mm."


@dataclass(frozen=True)
class Truth:
    """The camera, what was measured without the blunder, and where that lies."""

    camera: np.ndarray
    photo: np.ndarray  # of each ray, from 0
    point: np.ndarray
    xy: np.ndarray  # mm
    start: tuple[np.ndarray, np.ndarray]  # of photos and points
    bad: int  # ray
    blunder: np.ndarray  # mm
    parameter: str

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
    def best(self) -> tuple[np.ndarray, np.ndarray]:
        """Camera and standard deviations without the blunder."""
        return self.adjusted(np.delete(np.arange(len(self.xy)), self.bad))

    @cached_property
    def spoiled(self) -> tuple[float, float]:
        """Principal distance and standard deviation where the blunder takes part."""
        camera, sd = self.adjusted(np.arange(len(self.xy)))
        return camera[0], sd[0]

    @property
    def moved(self) -> np.ndarray:
        """How far one standard deviation of each parameter moves CORNER (10,), mm."""
        camera, sd = self.best
        J = derivatives(lambda some: without_lens(CORNER, some), camera)
        J[:, 0] = CORNER / camera[0]  # of c: all image points go outwards
        return np.hypot(*J) * sd

    def adjusted(self, used: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Camera and its standard deviations from some rays."""
        camera = np.array([NOMINAL, *np.zeros(9)])
        rays = self.photo[used], self.point[used], self.measured[used]
        camera, C, _, _ = adjust(*rays, SIGMA, camera, *self.start)
        return camera, np.sqrt(np.diag(C))


def make(chance: np.random.RandomState) -> tuple[dict[str, str], Truth]:
    """Eight photos of 48 targets; one parameter hardly shows in them."""
    size = np.array([0.4, 0.1, 0.1, 2e-5, 1e-7, 3e-10, 1e-5, 1e-5, 3e-4, 3e-4])
    camera = size * chance.uniform(-1, 1, 10)
    camera += (NOMINAL, 0, 0, 6e-5, -3e-7, 6e-10, 0, 0, 0, 0)
    # A wall of 1.6 by 1 m with steps
    X, Y = np.meshgrid(np.linspace(-800, 800, 8), np.linspace(-520, 520, 6))
    points = np.column_stack([X.ravel(), Y.ravel(), 250.0 * chance.randint(0, 2, 48)])
    points += chance.uniform(-60, 60, (48, 3))
    parameter = ("b1", "K3")[chance.randint(2)]
    exteriors = _turned_about_x(chance) if parameter == "b1" else _far_away(chance)
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
    truth = Truth(camera, photo, point, xy, start, bad, blunder, parameter)
    best, sd = truth.best
    unlucky = abs(best[0] - camera[0]) > 2.5 * sd[0]  # who is right must pass
    if unlucky or NAMES[np.argmax(sd)] == parameter:  # who compares mm with mm⁻⁶ not
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


def _turned_about_x(chance: np.random.RandomState) -> np.ndarray:
    """Photos (8, 6) turned about one axis, upside down too: X and b1 stretch alike."""
    omega = np.linspace(-0.7, 0.7, 8) + chance.uniform(-0.05, 0.05, 8)
    signs = 2 * chance.randint(0, 2, (2, 8)) - 1
    phi, kappa = signs * chance.uniform(0.002, 0.003, (2, 8))
    kappa[1::2] += np.pi
    aside = np.column_stack([chance.uniform(-150, 150, 8), np.zeros((8, 2))])
    return _looking(omega, phi, kappa, chance.uniform(1900, 2300, 8), aside)


def _far_away(chance: np.random.RandomState) -> np.ndarray:
    """Photos (8, 6) from all sides, too far away to fill more than their middle."""
    round_about = np.arange(8) * np.pi / 4
    omega, phi = 0.6 * np.array([np.sin(round_about), np.cos(round_about)])
    omega, phi = omega + chance.uniform(-0.05, 0.05, 8), phi
    kappa = np.array([0, 1.5, 3, -1.5] * 2) + chance.uniform(-0.1, 0.1, 8)
    return _looking(omega, phi, kappa, chance.uniform(5200, 5800, 8), np.zeros((8, 3)))


def _looking(
    omega: np.ndarray,
    phi: np.ndarray,
    kappa: np.ndarray,
    away: np.ndarray,
    aside: np.ndarray,
) -> np.ndarray:
    """Exterior orientations (n, 6) at distances from the middle of the targets."""
    angles = np.column_stack([omega, phi, kappa])
    axes = np.array([rotation.matrix(*one)[2] for one in angles])
    return np.hstack([aside + away[:, None] * axes, angles])


def judge(truth: Truth, result: object) -> list[Part]:
    """Return how far the camera is off, and whether ray and parameter are right."""
    c, sd, ray, name = _answer(result)
    camera, best = truth.best
    chance = 1 / np.sqrt(2 * (2 * len(truth.xy) - 2 - 10 - 42 - 144))  # of sigma0
    return [
        Part("c", abs(c - truth.camera[0]) / best[0]),
        Part("its standard deviation", abs(np.log(sd / best[0])) / chance),
        Part("the ray", float(ray != truth.ray), 0),
        Part("the parameter", float(name != truth.parameter), 0),
    ]


def _answer(result: object) -> tuple[float, float, tuple[int, int], str]:
    """Return c, its standard deviation, the ray and the name; or say what is wanted."""
    c, sd, ray, name = named(result, WANTED).values()
    name = str(name).strip().replace("_", "").translate(str.maketrans("₀₁₂₃", "0123"))
    known = {one.casefold(): one for one in NAMES}
    if name.casefold() not in known:
        raise CheckFailed(f"the parameter must be {WANTED['parameter'][0]}")
    if not sd > 0:
        raise CheckFailed("a standard deviation is positive")
    return c, sd, (int(ray[0]), int(ray[1])), known[name.casefold()]


def slips(truth: Truth) -> dict[str, tuple]:
    """Return what the likeliest wrong programs give."""
    (c, *_), (s, *_) = truth.best
    ray, name = truth.ray, truth.parameter
    return {
        INCLUDED: (*truth.spoiled, ray, name),
        OTHER_RAY: (c, s, (ray[0], ray[1] % 48 + 1), name),
        EXCHANGED: (c, s, ray[::-1], name),
        FROM_0: (c, s, (ray[0] - 1, ray[1] - 1), name),
        VARIANCE: (c, s**2, ray, name),
        UNIT: (c, 1000 * s, ray, name),
        PARAMETER: (c, s, ray, NAMES[np.argmax(truth.best[1])]),
        OTHER_C: (c + 10 * s, s, ray, name),
    }


def hint(truth: Truth, result: object) -> str:
    """Return the hint to the first part that is wrong."""
    _, sd, ray, _ = _answer(result)
    if ray != truth.ray and ray == truth.ray[::-1]:
        return EXCHANGED
    right = [part.holds for part in judge(truth, result)]
    if not right[2]:
        less = (truth.ray[0] - 1, truth.ray[1] - 1)
        return FROM_0 if ray == less else OTHER_RAY
    if all(right[:2]):
        return PARAMETER
    best, spoiled = truth.best[1][0], truth.spoiled[1]
    if right[0] and abs(sd - best) <= 0.0006 and round(sd, 3) == sd:
        return ROUNDED
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
    """Draw c beside the truth, and say what the parameter leaves open."""
    c, sd, ray, name = _answer(result)
    fig, ax = plt.subplots(figsize=(7, 3.5), layout="constrained")
    ax.axvline(truth.camera[0], color=plot.BLACK, lw=3, label="truth")
    for y, (value, spread) in enumerate(((c, sd), truth.spoiled)):
        colour = (plot.BLUE, plot.RED)[y]
        ax.errorbar(value, -y, xerr=spread, fmt="o", color=colour, lw=3, capsize=6)
    ax.set_yticks([0, -1], ["yours", "with the blunder"])
    ax.set(ylim=(-1.6, 0.9))
    ax.locator_params(axis="x", nbins=5)
    ax.legend(loc="upper left")
    size = 1000 * np.hypot(*truth.blunder)
    ax.set_title(f"photo {ray[0]}, point {ray[1]}: {size:.0f} µm off")
    micrometres = 1000 * np.sort(truth.moved)
    ax.set_xlabel(
        "c (mm), ± one standard deviation\n"
        f"One of {name} moves point (10, 6) mm by {micrometres[-1]:.0f} µm,"
        f" of any other by at most {micrometres[-2]:.1f} µm"
    )
    return fig, (
        "Your principal distance with its standard deviation beside the truth, and"
        " what came out with the blunder."
    )
