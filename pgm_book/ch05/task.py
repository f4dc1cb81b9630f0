"""The task of chapter 5: two photos, a scale bar, and a length with its sd."""

from dataclasses import dataclass
from functools import partial

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_book.program import camera as collinearity
from pgm_book.program import orientation as lines
from pgm_book.task import Answer, Part, likeliest, named, table
from pgm_lab import plot, rotation

SIGMA = 0.002  # mm, of an image coordinate
NAMES = ["A", "B", "P", "Q", *map(str, range(1, 13))]  # A to B is the bar
LEFT = np.zeros(6)
WANTED = {
    "exterior": ("X0, Y0, Z0, omega, phi, kappa of the right photo", (6,)),
    "distance": ("one number: from P to Q in metres", ()),
    "sd": ("one number: the standard deviation of the distance, in metres", ()),
}
read = partial(named, wanted=WANTED)
OTHER_UNIT = "X0 of the right photo is 1: it is the unit of the whole model."
SD_ALLOWED = 10.0  # per cent: boxes are not weighted, which changes it by up to 3


@dataclass(frozen=True)
class Truth:
    """The right photo in the frame of the left, the points, and what was measured."""

    answer: Answer
    Q: np.ndarray  # covariance (5, 5) of the right photo, whose X0 is 1
    sd: float  # of the distance, m
    rays: float  # the part of it that comes from the rays, the right photo held
    photo: float  # the part that comes from the right photo, the rays held in it
    model: np.ndarray  # (16, 3), in units of X0
    bar: float  # m
    c: float  # mm
    image: np.ndarray  # (2, 16, 2) in mm, left and right


def make(chance: np.random.RandomState) -> tuple[dict[str, str], Truth]:
    """Two photos of the front of a house, side by side, slightly convergent."""
    c = round(chance.uniform(23, 27), 2)
    bar = round(chance.uniform(1.5, 2.5), 3)
    base = np.array([chance.uniform(3, 4.5), *chance.uniform(-0.4, 0.4, 2)])
    angles = [chance.uniform(-0.1, 0.1), chance.uniform(0.1, 0.25)]
    exterior = np.array([*base, *angles, chance.uniform(-0.15, 0.15)])
    # 15 m before the left camera: the house is 8 m wide, 5 m high and 3 m deep
    grid = np.array([(x, y) for y in (-2, 0, 2) for x in (-2, 0.5, 3, 5.5)])
    points = np.empty((16, 3))
    points[4:, :2] = grid + chance.uniform(-0.7, 0.7, (12, 2))
    points[0, :2] = chance.uniform(0, 2), -1.5
    points[2:4, :2] = chance.uniform([(-2, 1), (3, -2)], [(-1, 2), (5.5, -1)])
    points[:, 2] = -15 + chance.uniform(-1.5, 1.5, 16)
    points[1] = points[0] + (bar, 0, 0)
    points[2:4, 2] = chance.uniform([-14, -17], [-13, -16])  # turns tell on depth
    true = [collinearity.project(e, points, c) for e in (LEFT, exterior)]
    image = np.round(true + SIGMA * chance.standard_normal((2, 16, 2)), 4)
    rows = [(name, *left, *right) for name, left, right in zip(NAMES, *image)]
    head = "point,x_left,y_left,x_right,y_right"
    points_csv = table(head, "{}" + 4 * ",{:.4f}", rows)
    scale = np.array([base[0]] * 3 + [1] * 3)
    exterior, model = exterior / scale, points / base[0]
    Q, sd = _precision(exterior, model, bar, c)

    def length(x: np.ndarray) -> np.ndarray:
        points = _model(x[5:].reshape(2, 16, 2), c, np.insert(x[:5], 0, 1))
        return np.array(_length(points, bar))

    J = collinearity.derivatives(length, np.append(exterior[1:], image))[0]
    rays, photo = SIGMA * np.linalg.norm(J[5:]), np.sqrt(J[:5] @ Q @ J[:5])
    lost = np.abs(lines.relative(image[0], image[1], c) - exterior).max() > 0.1
    if max(rays, photo) > 0.83 * sd or lost:  # it hardly matters that the other moves
        return make(chance)
    answer = dict(zip(WANTED, (exterior, _length(model, bar), sd)))
    truth = Truth(answer, Q, sd, float(rays), float(photo), model, bar, c, image)
    camera_csv = table("c_mm,bar_m", "{:.2f},{:.3f}", [(c, bar)])
    return {"points.csv": points_csv, "camera.csv": camera_csv}, truth


def judge(truth: Truth, found: Answer) -> list[Part]:
    """Return how far the five numbers, the distance and its sd are off."""
    right = truth.answer
    X0, *five = found["exterior"] - right["exterior"]
    return [
        Part("X0", float(abs(X0) > 1e-6), 0.0),
        Part("exterior", float(np.sqrt(five @ np.linalg.solve(truth.Q, five) / 5))),
        Part("distance", abs(found["distance"] - right["distance"]) / truth.sd),
        Part("sd", 100 * abs(found["sd"] / right["sd"] - 1), SD_ALLOWED, "per cent"),
    ]


def slips(truth: Truth) -> dict[str, Answer]:
    """Return what the likeliest wrong programs give."""
    (left, right), bar, sd = truth.image, truth.bar, truth.sd
    e, exchanged = (lines.relative(*p, truth.c) for p in ((left, right), (right, left)))
    degrees, model = e * np.repeat([1, 180 / np.pi], 3), _model(truth.image, truth.c, e)
    distance, unit = _length(model, bar), bar / np.linalg.norm(model[1] - model[0])
    return {
        OTHER_UNIT: {"exterior": np.append(unit * e[:3], e[3:])},
        "The angles are wanted in radians.": {"exterior": degrees},
        "The left photo stands at the origin, not the right.": {"exterior": exchanged},
        "It is in units of X0: the bar gives the scale.": {"distance": distance / unit},
        "The scale is upside down.": {"distance": distance / unit**2},
        "The bar is not one metre long.": {"distance": distance / bar},
        "That is the bar, from A to B.": {"distance": bar},
        "Millimetres? The standard deviation is wanted in metres.": {"sd": 1000 * sd},
        "The right photo is not free of error: move an image coordinate, and its five"
        " numbers move, too.": {"sd": truth.rays},
        "The points have errors of their own: hand the moved coordinates to `points_of`"
        " as well, not `photos`.": {"sd": truth.photo},
        "An image coordinate is off by 0.002 mm, not by 1 mm.": {"sd": sd / SIGMA},
    }


def hint(truth: Truth, found: Answer, wrong: list[str]) -> str:
    """Return the hint to the slip that explains the first wrong part."""
    general = {
        "X0": OTHER_UNIT,
        "exterior": "Are the boxes flat for what you found? Print all volumes: they"
        " fall by orders of magnitude from step to step, or a sign is wrong.",
        "distance": "The exterior is right. Do the rays meet in front of both photos?",
        "sd": "The distance is right. It is a function of all 64 image coordinates: the"
        " right photo, the points and the scale move with each. How do independent"
        " errors add up? (A simulation needs a thousand runs.)",
    }
    return likeliest(judge, truth, found, wrong[:1], slips(truth)) or general[wrong[0]]


def picture(truth: Truth, found: Answer) -> tuple[Figure, str]:
    """Draw the points as your photos see them beside the true ones, in two views."""
    yours, true = (
        model * truth.bar / np.linalg.norm(model[1] - model[0])
        for model in (_model(truth.image, truth.c, found["exterior"]), truth.model)
    )
    fig, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    views = "from the front; squares: true", "from above"
    for ax, down, view in zip(axes, ([0, 1], [0, 2]), views):
        ax.plot(*true[:, down].T, "s", color=plot.BLACK, mfc="none", ms=10)
        ax.plot(*yours[:, down].T, ".", color=plot.BLUE, ms=8)
        ax.plot(*yours[:2, down].T, color=plot.GREEN, lw=2)
        ax.plot(*yours[2:4, down].T, color=plot.RED, lw=2)
        for name, at, aside in zip(NAMES, true[:, down], (-18, -18, 6, 6)):
            ax.annotate(name, at, (6, aside), textcoords="offset points", size=15)
        ax.set(xlabel="X in m", ylabel=f"{'XYZ'[down[1]]} in m", title=view)
        ax.set_aspect("equal", adjustable="datalim")
    said = f"P to Q: {found['distance']:.3f} m ± {1000 * found['sd']:.0f} mm"
    fig.suptitle(f"{said} (true: {truth.answer['distance']:.3f} m)")
    return fig, (
        "Sixteen points of a house in metres, from the front and from above: a black"
        " square where each is and a blue point, within it, where your rays meet. A"
        " green line is the bar from A to B, a red one leads from P to Q."
    )


def _precision(
    exterior: np.ndarray, model: np.ndarray, bar: float, c: float
) -> tuple[np.ndarray, float]:
    """Covariance (5, 5) of the right photo, and the sd of the distance in metres."""
    at = np.concatenate([exterior[1:], model.ravel()])

    def both(x: np.ndarray) -> np.ndarray:
        photos, points = (LEFT, np.insert(x[:5], 0, 1)), x[5:].reshape(-1, 3)
        return np.array([collinearity.project(e, points, c) for e in photos])

    def length(x: np.ndarray) -> np.ndarray:
        return np.array(_length(x[5:].reshape(-1, 3), bar))

    A = collinearity.derivatives(both, at)
    Q = SIGMA**2 * np.linalg.inv(A.T @ A)
    J = collinearity.derivatives(length, at)[0]
    return Q[:5, :5], float(np.sqrt(J @ Q @ J))


def _model(image: np.ndarray, c: float, exterior: np.ndarray) -> np.ndarray:
    """Where the rays of the points meet (16, 3)."""
    first, second = np.insert(image, 2, -c, axis=2)
    second = second @ rotation.matrix(*exterior[3:])
    stations = np.array([LEFT[:3], exterior[:3]])
    return np.array(
        [lines.intersection(stations, two) for two in np.stack([first, second], 1)]
    )


def _length(model: np.ndarray, bar: float) -> float:
    """From P to Q in metres, where A and B are a bar apart."""
    A, B, P, Q = model[:4]
    return float(bar * np.linalg.norm(Q - P) / np.linalg.norm(B - A))
