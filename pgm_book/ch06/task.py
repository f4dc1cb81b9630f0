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
from pgm_book.task import Answer, Part, likeliest, named, table
from pgm_lab import plot, rotation

NAMES = ("c", "x0", "y0", "K1", "K2", "K3", "P1", "P2", "b1", "b2")
NOMINAL, SIGMA = 24.0, 0.0005  # mm: c, and an image coordinate's sd, as stated
SPREAD = 0.5  # per cent of sd: three digits, and the redundancy of all other rays
FORMAT = (12.0, 8.0)  # mm, half of the image
CORNER = np.array([[10.0, 6.0]])  # mm, an image point in its corner
WANTED: dict[str, tuple[str, Any]] = {
    "c": ("one number, in mm", ()),
    "sd": ("its standard deviation in mm, a positive number", ()),
    "ray": ("(photo, point), two numbers", (2,)),
    "parameter": (f"one of {', '.join(NAMES)}", None),
}
OTHERWISE = {
    "ray": "The ray: resect every photo with the camera and the targets that you found,"
    " and look at what remains, ray by ray.",
    "c": "c and sd: use all other rays and all ten parameters, begin with 24 mm, and"
    " hand both in with all their digits.",
    "sd": "sd: take out that one ray alone, and count the redundancy again; three"
    " digits are wanted at least.",
    "parameter": "The parameter: mm, mm⁻² and mm⁻⁶ cannot be compared. How far does one"
    " standard deviation of each move the image point (10, 6) mm?",
}


@dataclass(frozen=True)
class Truth:
    """The camera, what was measured, where to start, and what is wrong with it."""

    camera: np.ndarray
    photo: np.ndarray  # of each ray, from 0
    point: np.ndarray
    xy: np.ndarray  # mm, with the blunder
    start: tuple[np.ndarray, np.ndarray]  # of photos and points
    bad: int  # ray

    @cached_property
    def best(self) -> tuple[np.ndarray, np.ndarray, float]:
        """Camera, its standard deviations and sigma0 without the blunder."""
        return self.adjusted(np.delete(np.arange(len(self.xy)), self.bad))

    @cached_property
    def spoiled(self) -> tuple[float, float]:
        """Principal distance and standard deviation where the blunder takes part."""
        camera, sd, _ = self.adjusted(np.arange(len(self.xy)))
        return camera[0], sd[0]

    @cached_property
    def moved(self) -> np.ndarray:
        """By how many µm one standard deviation of each parameter moves the corner."""
        J = derivatives(lambda some: without_lens(CORNER, some), self.best[0])
        return 1000 * np.hypot(*J) * self.best[1]

    @cached_property
    def answer(self) -> Answer:
        """The true c, what the best adjustment gives for its sd, ray and parameter."""
        c, sd, worst = self.camera[0], self.best[1][0], NAMES[self.moved.argmax()]
        ray = int(self.photo[self.bad]) + 1, int(self.point[self.bad]) + 1
        return dict(zip(WANTED, (c, sd, ray, worst)))

    def adjusted(self, used: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """Camera, its standard deviations and sigma0 from some rays."""
        camera = np.array([NOMINAL, *np.zeros(9)])
        rays = self.photo[used], self.point[used], self.xy[used]
        camera, C, sigma0, _ = adjust(*rays, SIGMA, camera, *self.start)
        return camera, np.sqrt(np.diag(C)), sigma0


def make(chance: np.random.RandomState) -> tuple[dict[str, str], Truth]:
    """Eight photos of 48 targets; one parameter hardly shows in them."""
    size = np.array([0.4, 0.1, 0.1, 2e-5, 1e-7, 3e-10, 1e-5, 1e-5, 3e-4, 3e-4])
    camera = size * chance.uniform(-1, 1, 10)
    camera[0] += 0.1 * np.sign(camera[0])  # or who hands 24 mm in would pass
    camera += (NOMINAL, 0, 0, 6e-5, -3e-7, 6e-10, 0, 0, 0, 0)
    # A wall of 1.6 by 1 m with steps
    X, Y = np.meshgrid(np.linspace(-800, 800, 8), np.linspace(-520, 520, 6))
    points = np.column_stack([X.ravel(), Y.ravel(), 250.0 * chance.randint(0, 2, 48)])
    points += chance.uniform(-60, 60, (48, 3))
    exteriors = _photos(chance, ("b1", "K2", "K3")[chance.randint(3)])
    ideal = np.concatenate([project(e, points, camera[0]) for e in exteriors])
    xy = ideal.copy()
    for _ in range(20):  # each step leaves a hundredth of the error
        xy += ideal - without_lens(xy, camera)
    seen = np.all(np.abs(xy) < FORMAT, axis=1)
    photo, point = np.indices((8, 48)).reshape(2, -1)[:, seen]
    noise = chance.uniform(0.6, 0.75) * SIGMA  # smaller than stated: σ₀ matters
    xy = np.round(xy[seen] + noise * chance.standard_normal(xy[seen].shape), 5)
    often = np.bincount(point)[point] == 8  # or little would control that ray
    bad = int(chance.choice(np.flatnonzero(often & (photo > 0) & (photo != point))))
    far, direction = chance.uniform((0.05, 0), (0.08, 2 * np.pi))
    xy[bad] += np.round(far * np.array([np.cos(direction), np.sin(direction)]), 5)
    near = np.repeat([5, 0.003], 3) * chance.uniform(-1, 1, (8, 6))
    around = 5 * chance.uniform(-1, 1, (48, 3))
    start = np.round(exteriors + near, 4), np.round(points + around, 1)
    truth = Truth(camera, photo, point, xy, start, bad)
    best, sd, _ = truth.best
    *_, second, first = np.sort(truth.moved)
    unlucky = abs(best[0] - camera[0]) > 2.5 * sd[0]  # who is right must pass,
    harmless = abs(truth.spoiled[0] - camera[0]) < 5 * sd[0]  # with the blunder not,
    if unlucky or harmless or first < 1.3 * second:
        return make(chance)
    rays = zip(photo + 1, point + 1, *xy.T)
    photos, targets = ([(k, *v) for k, v in enumerate(s, 1)] for s in start)
    photo_head = "photo,X0_mm,Y0_mm,Z0_mm,omega_rad,phi_rad,kappa_rad"
    return {
        "image_points.csv": table("photo,point,x_mm,y_mm", "{},{},{:.5f},{:.5f}", rays),
        "photos.csv": table(photo_head, "{}" + 6 * ",{:.4f}", photos),
        "targets.csv": table("point,X_mm,Y_mm,Z_mm", "{}" + 3 * ",{:.4f}", targets),
    }, truth


def _photos(chance: np.random.RandomState, worst: str) -> np.ndarray:
    """Photos (8, 6), upright and upside down, that determine one parameter worst."""
    kappa = np.pi * (np.arange(8) % 2)
    if worst == "b1":  # turned about one axis: X and b1 stretch alike
        omega = np.linspace(-0.7, 0.7, 8) + chance.uniform(-0.05, 0.05, 8)
        signs = 2 * chance.randint(0, 2, (2, 8)) - 1
        phi, more = signs * chance.uniform(0.002, 0.003, (2, 8))
        angles = np.array([omega, phi, kappa + more]).T
        photos = _looking(angles, chance.uniform(1900, 2300, 8))
        photos[:, 0] += chance.uniform(-150, 150, 8)
        return photos
    # From all sides; from far away the targets fill little more than the middle
    about = np.arange(8) * np.pi / 4
    angles = np.array([0.6 * np.sin(about), 0.6 * np.cos(about), kappa]).T
    angles += chance.uniform(-0.05, 0.05, (8, 3))
    away = (2100, 2350) if worst == "K2" else (3300, 3700)
    return _looking(angles, chance.uniform(*away, 8))


def _looking(angles: np.ndarray, away: np.ndarray) -> np.ndarray:
    """Exterior orientations (n, 6) at distances from the middle of the targets."""
    axes = np.array([rotation.matrix(*one)[2] for one in angles])
    return np.hstack([away[:, None] * axes, angles])


def judge(truth: Truth, found: Answer) -> list[Part]:
    """Return how far the camera is off, and whether ray and parameter are right."""
    right, sds = truth.answer, truth.best[1]
    return [
        Part("c", abs(found["c"] - right["c"]) / sds[0]),
        Part("sd", 100 * abs(found["sd"] / right["sd"] - 1), SPREAD, "per cent off"),
        Part("ray", float(found["ray"] != right["ray"]), 0),
        Part("parameter", float(found["parameter"] != right["parameter"]), 0),
    ]


def read(result: object) -> Answer:
    """Return the ray in whole numbers and the parameter as in NAMES; or refuse them."""
    found = named(result, WANTED)
    written = str(found["parameter"]).translate(str.maketrans("₀₁₂₃", "0123", "_ "))
    known = {one.casefold(): one for one in NAMES}
    if written.casefold() not in known:
        raise CheckFailed(f"the parameter must be {WANTED['parameter'][0]}")
    return found | {"ray": (*found["ray"],), "parameter": known[written.casefold()]}


def slips(truth: Truth) -> dict[str, Answer]:
    """Return what the likeliest wrong programs give."""
    c, sd, (photo, point), _ = truth.answer.values()
    r = 2 * len(truth.xy) - 2 - (10 + 6 * 8 + 3 * 48 - 7)
    return {
        "The ray: the photo comes first, then the point.": {"ray": (point, photo)},
        "The ray: photo and point as the files number them, from 1.": {
            "ray": (photo - 1, point - 1)
        },
        OTHERWISE["ray"]: {"ray": (photo, point % 48 + 1)},
        "The diagonal of C holds variances.": {"sd": sd**2},
        "The redundancy: the datum adds 7, for it holds seven unknowns.": {
            "sd": sd * np.sqrt(r / (r - 7))
        },
        "σ₀ belongs to the standard deviation.": {"sd": sd / truth.best[2]},
        "C is multiplied by σ₀² already.": {"sd": sd * truth.best[2]},
        "One standard deviation is wanted, no bound of 95 per cent.": {"sd": 1.96 * sd},
        "Both c and its standard deviation are wanted in mm.": {"sd": 1000 * sd},
        "This still contains the blunder: leave that ray out, and adjust once more.": (
            dict(zip(WANTED, truth.spoiled))
        ),
        OTHERWISE["c"]: {"c": c + 10 * sd},
        OTHERWISE["parameter"]: {"parameter": NAMES[np.argmax(truth.best[1])]},
    }


def hint(truth: Truth, found: Answer, wrong: list[str]) -> str:
    """Return the hint to the slip that explains what is wrong; first of all the ray."""
    first = ["ray"] if "ray" in wrong else wrong
    return likeliest(judge, truth, found, first, slips(truth)) or OTHERWISE[first[0]]


def picture(truth: Truth, found: Answer) -> tuple[Figure, str]:
    """Draw c beside the truth, and say what the parameter leaves open."""
    c, sd, ray, name = found.values()
    fig, ax = plt.subplots(figsize=(7, 4), layout="constrained")
    ax.axvline(truth.camera[0], color=plot.BLACK, lw=3, label="truth")
    for y, (value, spread) in enumerate(((c, sd), truth.spoiled)):
        colour = (plot.BLUE, plot.RED)[y]
        ax.errorbar(value, -y, xerr=spread, fmt="o", color=colour, lw=3, capsize=6)
    ax.set_yticks([0, -1], ["yours", "with the blunder"])
    ax.set(ylim=(-1.6, 0.9), title=f"without photo {ray[0]:.0f}, point {ray[1]:.0f}")
    ax.locator_params(axis="x", nbins=5)
    ax.legend(loc="upper left")
    *_, second, first = np.sort(truth.moved)
    ax.set_xlabel(
        "c (mm), ± one standard deviation\n"
        f"One standard deviation of {name} moves\npoint (10, 6) mm by"
        f" {first:.1f} µm,\none of any other by at most {second:.1f} µm"
    )
    return fig, (
        "Your principal distance with its standard deviation beside the truth, and"
        " what came out with the blunder."
    )
