"""The task of chapter 5: two photos, a scale bar, and a length with its sd."""

from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_book.program import camera as collinearity
from pgm_book.program import orientation as lines
from pgm_book.task import Part, named, table
from pgm_lab import plot, rotation

SIGMA = 0.002  # mm, of an image coordinate
NAMES = ["A", "B", "P", "Q", *map(str, range(1, 13))]  # A to B is the bar
LEFT = np.zeros(6)
LIKE = {"exterior": 1e-5, "distance": 0.01, "sd": 0.05}  # two answers of one slip
UNIT = "X0 of the right photo is 1: it is the unit of the whole base."
WANTED = {
    "exterior": ("X0, Y0, Z0, omega, phi, kappa of the right photo", (6,)),
    "distance": ("one number: from P to Q in metres", ()),
    "sd": ("one number: the standard deviation of the distance, in metres", ()),
}
SD_ALLOWED = 10.0  # per cent: boxes are not weighted, which changes it by up to 3


@dataclass(frozen=True)
class Truth:
    """The right photo in the frame of the left, the points, and what was measured."""

    exterior: np.ndarray  # (6,), its X0 is 1
    model: np.ndarray  # (16, 3), in units of X0
    bar: float  # m
    c: float  # mm
    image: np.ndarray  # (2, 16, 2) in mm, left and right

    @property
    def distance(self) -> float:
        """From P to Q in metres."""
        return _length(self.model, self.bar)

    def precision(self, turns: bool = True, scale: bool = True) -> tuple:
        """Covariance (5, 5) of the right photo, and the sd of the distance in metres.

        Both are those of an ideal adjustment; with `turns` false as if the photo were
        known, with `scale` false as if the length of the bar in the model were.
        """
        at = np.concatenate([self.exterior[1:], self.model.ravel()])
        unit = self.bar / np.linalg.norm(self.model[1] - self.model[0])

        def both(x: np.ndarray) -> np.ndarray:
            photos, points = (LEFT, np.insert(x[:5], 0, 1)), x[5:].reshape(-1, 3)
            return np.array([collinearity.project(e, points, self.c) for e in photos])

        def length(x: np.ndarray) -> np.ndarray:
            points = x[5:].reshape(-1, 3)
            alone = unit * np.linalg.norm(points[3] - points[2])
            return np.array(_length(points, self.bar) if scale else alone)

        A = collinearity.derivatives(both, at)[:, 0 if turns else 5 :]
        Q = SIGMA**2 * np.linalg.inv(A.T @ A)
        J = collinearity.derivatives(length, at)[0, 0 if turns else 5 :]
        return Q[:5, :5], float(np.sqrt(J @ Q @ J))


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
    points[:2] = (chance.uniform(0, 2), -1.5, 0), (0, -1.5, 0)
    points[1] = points[0] + (bar, 0, 0)
    points[2:4, :2] = chance.uniform([(-2, 1), (3, -2)], [(-1, 2), (5.5, -1)])
    points[:, 2] = -15 + chance.uniform(-1.5, 1.5, 16)
    points[1, 2] = points[0, 2]
    points[2:4, 2] = chance.uniform([-14, -17], [-13, -16])  # turns tell on depth
    true = [collinearity.project(e, points, c) for e in (LEFT, exterior)]
    image = np.round(true + SIGMA * chance.standard_normal((2, 16, 2)), 4)
    rows = [(name, *left, *right) for name, left, right in zip(NAMES, *image)]
    points_csv = table(
        "point,x_left,y_left,x_right,y_right", "{}" + 4 * ",{:.4f}", rows
    )
    scale = np.array([base[0]] * 3 + [1] * 3)
    truth = Truth(exterior / scale, points / base[0], bar, c, image)
    weak = truth.precision(turns=False)[1] > 0.8 * truth.precision()[1]
    lost = np.abs(_solved(truth)["exterior"] - exterior / scale).max() > 0.1
    if weak or lost:  # it hardly matters that the right photo has errors, or is lost
        return make(chance)
    camera_csv = table("c_mm,bar_m", "{:.2f},{:.3f}", [(c, bar)])
    return {"points.csv": points_csv, "camera.csv": camera_csv}, truth


def judge(truth: Truth, result: object) -> list[Part]:
    """Return how far the five numbers, the distance and its sd are off."""
    found = named(result, WANTED)
    Q, sd = truth.precision()
    off = found["exterior"][1:] - truth.exterior[1:]
    held = abs(found["exterior"][0] - 1) < 1e-6
    five = np.sqrt(off @ np.linalg.solve(Q, off) / 5) if held else np.inf
    return [
        Part("exterior", float(five)),
        Part("distance", abs(found["distance"] - truth.distance) / sd),
        Part("sd", 100 * abs(found["sd"] / sd - 1), SD_ALLOWED, "per cent off"),
    ]


def slips(truth: Truth) -> dict[str, dict]:
    """Return what the likeliest wrong programs give."""
    left, right = truth.image
    good = _solved(truth)
    e, there = good["exterior"], slice(3, None)
    exteriors = {
        UNIT: np.array([*(e[:3] / np.linalg.norm(e[:3])), *e[there]]),
        "The angles are wanted in radians.": np.array([*e[:3], *np.degrees(e[there])]),
        "Left and right are exchanged: the left photo is held.": (
            lines.relative(right, left, truth.c)
        ),
        "The camera looks along its minus z axis: so does the ray of an image point.": (
            lines.relative(left, right, -truth.c)
        ),
        "M leads from object space to the image: the rays need the way back.": (
            np.array([*e[:3], *rotation.angles(rotation.matrix(*e[there]).T)])
        ),
    }
    wrong = {words: good | {"exterior": one} for words, one in exteriors.items()}
    A, B = _model(truth, e)[:2]  # as measured
    unit = truth.bar / np.linalg.norm(B - A)  # metres
    metres = {
        "This is the length in the model, whose unit is X0 of the right photo: the bar"
        " gives the scale.": 1 / unit,
        "The scale is upside down.": 1 / unit**2,
        "Millimetres? The distance is wanted in metres.": 1000.0,
    }
    for words, factor in metres.items():
        wrong[words] = good | {"distance": factor * good["distance"]}
    deviations = {
        "Millimetres? The standard deviation is wanted in metres.": 1000 * good["sd"],
        "The bar is measured in the photos, too, and shares errors with P and Q: move"
        " an image coordinate, and the scale moves.": truth.precision(scale=False)[1],
        "The right photo is not free of error: move an image coordinate, and its five"
        " numbers move, too.": truth.precision(turns=False)[1],
        "This is the variance; its root is wanted.": good["sd"] ** 2,
        "An image coordinate is off by 0.002 mm, not by 1 mm.": good["sd"] / SIGMA,
    }
    return wrong | {words: good | {"sd": sd} for words, sd in deviations.items()}


def hint(truth: Truth, result: object) -> str:
    """Return the hint to the slip that explains the first wrong part."""
    found, good = named(result, WANTED), _solved(truth)
    part = next(one.name for one in judge(truth, result) if not one.holds)

    def apart(one: np.ndarray, other: np.ndarray) -> float:
        return float(np.linalg.norm(one - other) / np.linalg.norm(other))

    X0 = found["exterior"][0]
    if part == "exterior" and X0:  # whatever unit it was adjusted in
        scaled = found | {part: found[part] / (X0, X0, X0, 1, 1, 1)}
        if judge(truth, scaled)[0].holds:
            return UNIT
    for words, wrong in slips(truth).items():
        same = apart(found[part], wrong[part]) < LIKE[part]
        if same and apart(wrong[part], good[part]) > LIKE[part]:
            return words
    return {
        "exterior": "Are the boxes flat for what you found? Print all volumes: they"
        " fall by orders of magnitude from step to step, or a sign is wrong.",
        "distance": "The exterior is right. Do the rays meet, in front of both photos?",
        "sd": "The distance is right. It is a function of all 64 image coordinates:"
        " what does each contribute, and how do independent errors add up?",
    }[part]


def picture(truth: Truth, result: object) -> tuple[Figure, str]:
    """Draw the points as your photos see them beside the true ones, in two views."""
    found = named(result, WANTED)
    yours, true = _model(truth, found["exterior"]), truth.model
    fig, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for ax, down, name in zip(axes, (1, 2), ("from the front", "from above")):
        for points, mark, words in ((true, "s", "true"), (yours, ".", "yours")):
            at = points * truth.bar / np.linalg.norm(points[1] - points[0])
            look = {"color": plot.BLACK, "mfc": "none", "ms": 10}
            if words == "yours":
                look = {"color": plot.BLUE, "ms": 8}
                for pair, colour in ((at[:2], plot.GREEN), (at[2:4], plot.RED)):
                    ax.plot(pair[:, 0], pair[:, down], color=colour, lw=2, zorder=1)
            ax.plot(at[:, 0], at[:, down], mark, label=words, ls="", **look)
        for k in range(4):
            place = at[k, 0], at[k, down]
            aside = 6, -18 if k < 2 else 6  # A and B below, P and Q above
            ax.annotate(NAMES[k], place, aside, textcoords="offset points", size=15)
        ax.set(xlabel="X in m", ylabel=f"{'XYZ'[down]} in m", title=name)
        ax.set_aspect("equal", adjustable="datalim")
    fig.legend(
        *axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2
    )
    true_one = f"(true: {truth.distance:.3f} m)"
    distance, sd = found["distance"], 1000 * found["sd"]
    fig.suptitle(f"P to Q: {distance:.3f} m ± {sd:.0f} mm {true_one}")
    return fig, (
        "Sixteen points of a house in metres, from the front and from above: a black"
        " square where each is and a blue point, within it, where your rays meet. A"
        " green line is the bar from A to B, a red one leads from P to Q."
    )


def _solved(truth: Truth) -> dict[str, Any]:
    """Return the answer to the data, with the sd of an ideal adjustment."""
    exterior = lines.relative(truth.image[0], truth.image[1], truth.c)
    distance = _length(_model(truth, exterior), truth.bar)
    return {
        "exterior": exterior,
        "distance": distance,
        "sd": truth.precision()[1],
    }


def _model(truth: Truth, exterior: np.ndarray) -> np.ndarray:
    """Where the rays of the points meet (16, 3)."""
    first, second = np.insert(truth.image, 2, -truth.c, axis=2)
    second = second @ rotation.matrix(*exterior[3:])
    stations = np.array([LEFT[:3], exterior[:3]])
    return np.array(
        [lines.intersection(stations, two) for two in np.stack([first, second], 1)]
    )


def _length(model: np.ndarray, bar: float) -> float:
    """From P to Q in metres, where A and B are a bar apart."""
    A, B, P, Q = model[:4]
    return float(bar * np.linalg.norm(Q - P) / np.linalg.norm(B - A))
