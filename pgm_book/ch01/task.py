"""The task of chapter 1: the convention of a program whose manual is lost."""

from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_book.common.checks import CheckFailed
from pgm_book.task import Answer, Part, grey, likeliest, named, table
from pgm_lab import frames, plot, simulate

NOISE, CONTRAST, DIAMETER = 3.0, 150.0, 9.0  # grey values, and pixels
WHOLE = CONTRAST * np.pi * (DIAMETER / 2) ** 2  # the grey values of a target, summed
# Of a centroid, in px: the formula of the lesson, with a target amid 19 × 19 pixels
CENTROID = NOISE * np.sqrt(19**2 * (19**2 - 1) / 12) / WHOLE
PROGRAM = 0.03  # pixels: how well the program measured
# Of the way from the middle: lines through clicks give another pixel size
HAND = 0.0015
# The zero as a share of the way from the centre of the first pixel to that of the last;
# half a pixel on from there, in half of all photos; and the axes
CONVENTIONS = (
    ((0, 0), (-0.5, -0.5), "right, down"),
    ((0, 0), (-0.5, -0.5), "down, right"),
    ((0, 1), (-0.5, 0.5), "right, up"),
    ((0.5, 0.5), (0.5, 0.5), "right, up"),
    ((0.5, 0.5), (0.5, 0.5), "right, down"),
)
STEPS = {"right": (1, 0), "left": (-1, 0), "down": (0, 1), "up": (0, -1)}
WANTED: dict[str, tuple[str, Any]] = {
    "zero": ("column, row of the program's zero, two numbers", (2,)),
    "axes": ("two words such as 'right, up': of x, then of y", None),
    "pixel_size": ("one number, in mm", ()),
    "photo": ("(20, 2): x, y in mm of each", (20, 2)),
}


@dataclass(frozen=True)
class Truth:
    """The right answer, where it comes from, and how exact it can be."""

    answer: Answer
    image_size: tuple[int, int]
    pixels: np.ndarray  # (20, 2), true centres of the targets of plan.csv
    plan: np.ndarray  # (20, 2), mm
    sd_size: float  # of the pixel size, relative to it
    sd: float  # of a photo coordinate, mm


def make(chance: np.random.RandomState) -> tuple[dict[str, Any], Truth]:
    """Twenty targets with the coordinates of a program, and twenty with a plan."""
    size = (2 * int(chance.uniform(440, 520)), 2 * int(chance.uniform(300, 360)))
    share, beside, axes = CONVENTIONS[int(chance.uniform(0, len(CONVENTIONS)))]
    half, p = chance.uniform() < 0.5, round(chance.uniform(0.0025, 0.008), 7)

    grid = np.stack(np.meshgrid(np.arange(8) + 0.5, np.arange(5) + 0.5), axis=-1)
    places = grid.reshape(-1, 2) * (size[0] / 8, size[1] / 5)
    places = chance.permutation(places + chance.uniform(-30, 30, (40, 2))).round(4)
    noise = NOISE * chance.standard_normal(size[::-1])
    values = int(chance.uniform(50, 80)) + noise  # the 40 of the lesson is wrong
    corners = np.round(places).astype(int) - 15
    discs = simulate.target(places - corners, DIAMETER, (31, 31), CONTRAST, 0.0)
    for (column, row), disc in zip(corners, discs):
        values[row : row + 31, column : column + 31] += disc

    zero = share * np.subtract(size, 1) + half * np.array(beside)
    turn = p * np.transpose([STEPS[one] for one in axes.split(", ")])
    given, others = places[:20], places[20:]
    short = HAND * (given - np.divide(size, 2))  # a hand that stops short
    clicked = np.round(given - short + chance.uniform(-0.7, 0.7, (20, 2)))
    printed = (given + PROGRAM * chance.standard_normal((20, 2)) - zero) @ turn
    planned = others + chance.uniform(-2, 2, (20, 2))
    plan, photo = (
        frames.pixel_to_photo(pixels, size, (p, p)) for pixels in (planned, others)
    )
    # Of one fitted slope, the weaker: from how far the points lie about their centre
    slopes = np.hypot(CENTROID, PROGRAM) / np.sqrt(20 * given.var(axis=0))
    answer = dict(zip(WANTED, (zero, axes, p, photo)))
    form = "{:.0f},{:.0f},{:.4f},{:.4f}"
    return {
        "targets.png": grey(values),
        "program.csv": table("column,row,x,y", form, np.hstack([clicked, printed])),
        "plan.csv": table("x,y", "{:.3f},{:.3f}", plan),
    }, Truth(answer, size, others, plan.round(3), float(slopes.max()), CENTROID * p)


def read(result: object) -> Answer:
    """Return the values of an answer, or say what is wanted."""
    found = named(result, WANTED)
    given = found["axes"]
    text = " ".join(given) if isinstance(given, list | tuple) else str(given)
    axes = text.casefold().replace(",", " ").split()
    if len(axes) != 2 or not set(axes) <= STEPS.keys():
        raise CheckFailed(f"axes must be {WANTED['axes'][0]}")
    return found | {"axes": ", ".join(axes)}


def judge(truth: Truth, found: Answer) -> list[Part]:
    """Return how far each value is off; of the photo coordinates the mean square."""
    right = truth.answer
    zero = np.abs(found["zero"] - right["zero"]).max()
    size = abs(found["pixel_size"] / right["pixel_size"] - 1)
    return [
        Part("zero", float(zero), 0.1, "px"),
        Part("axes", float(found["axes"] != right["axes"]), 0),
        Part("pixel_size", size / truth.sd_size),
        Part("photo", _rms(found["photo"] - right["photo"]) / truth.sd),
    ]


def _rms(off: np.ndarray) -> float:
    return float(np.sqrt(np.mean(off**2)))


def slips(truth: Truth) -> dict[str, Answer]:
    """Return what the likeliest wrong programs give."""
    zero, axes, p, photo = truth.answer.values()
    columns, rows = truth.image_size
    x, y = axes.split(", ")
    flip = {"up": "down", "down": "up", "right": "right"}
    return {
        "Do its coordinates grow with the row?": {"axes": f"{flip[x]}, {flip[y]}"},
        "Which of its coordinates follows the column?": {"axes": f"{y}, {x}"},
        "The zero is off by half a pixel: the centre of the first pixel is (0, 0).": {
            "zero": zero + 0.5
        },
        "Where are both its coordinates zero, by the straight lines?": {
            "zero": zero + (columns / 2, rows / 2)
        },
        "The pixel size is wanted in millimetres.": {"pixel_size": 1000 * p},
        "A pixel size has no sign.": {"pixel_size": -p},
        "In this book y of a photo points up.": {"photo": photo * (1, -1)},
        "image.shape begins with the rows, image_size with the columns.": {
            "photo": photo + p * (columns - rows) / 2
        },
        "Those are places of the plan: measure them.": {"photo": truth.plan},
    }


def hint(truth: Truth, found: Answer, wrong: list[str]) -> str:
    """Return the hint to what spoils all centroids, to a slip, or to what is off."""
    slip = likeliest(judge, truth, found, wrong, slips(truth))
    photo, right, sd = "photo" in wrong, truth.answer["photo"], truth.sd
    size = found["pixel_size"] / truth.answer["pixel_size"]
    off, away = found["photo"] - right, truth.plan - right
    pull, aside = np.sum(off * away) / np.sum(away**2), off.mean(axis=0)
    along = _rms(off - pull * away) < 0.8 * _rms(off)
    ordered = np.sort(found["photo"], axis=0) - np.sort(right, axis=0)
    hints = {
        "The centroids are off along the way to the centres of their windows: which"
        " grey value has the empty background of this photo?": (
            photo and along and 0.03 < abs(pull) and pull < 0.95
        ),
        slip: slip != "",
        "Clicks are good to two pixels: fit the lines to the measured centres of all"
        " twenty, and keep all digits.": "pixel_size" in wrong and abs(size - 1) < 0.01,
        "The targets are wanted in the order of plan.csv.": (
            photo and _rms(ordered) < 3 * sd
        ),
        "The photo coordinates are wanted in mm, from the centre of the photo.": (
            photo and _rms(off) > 50 * _rms(away)
        ),
        "All photo coordinates are off by the same amount: by half a pixel, or by a"
        " corner of the window?": (
            photo and _rms(off - aside) < min(_rms(aside) / 3, 6 * sd)
        ),
        f"Look again at {' and '.join(wrong)}: draw a plot.": True,
    }
    return next(words for words, holds in hints.items() if holds)


def picture(truth: Truth, found: Answer) -> tuple[Figure, str]:
    """Draw where the program has its zero and axes, and how far the targets are off."""
    zero, (columns, rows) = found["zero"], truth.image_size
    off = 1000 * (found["photo"] - truth.answer["photo"])
    fig, (left, right) = plt.subplots(1, 2, figsize=(10, 4.4))
    left.add_patch(plt.Rectangle((-0.5, -0.5), columns, rows, fill=False, linewidth=2))
    left.plot(*truth.pixels.T, "o", color=plot.BLUE)
    for name, word in zip("xy", found["axes"].split(", ")):
        end = zero + 0.3 * rows * np.array(STEPS[word])
        look = {"arrowstyle": "-|>", "color": plot.RED, "linewidth": 3, "shrinkA": 0}
        left.annotate("", end, zero, arrowprops=look)
        left.text(*(end + (14, -14)), name, color=plot.RED, fontsize=18)
    left.set(xlabel="column X (px)", ylabel="row Y (px)", aspect="equal")
    left.set(xlim=(-60, columns + 40), ylim=(rows + 40, -40))
    right.add_patch(plt.Circle((0, 0), 3000 * truth.sd, fill=False, linewidth=2))
    right.plot(*off.T, "o", color=plot.BLUE)
    right.set(xlabel="x, off (µm)", ylabel="y, off (µm)", aspect="equal")
    return fig, (
        f"Left, the photo with your twenty targets. The program's zero is at column"
        f" {zero[0]:.1f}, row {zero[1]:.1f}, its axes point {found['axes']}. Right, how"
        f" far your photo coordinates are off: {_rms(off):.2f} µm in the mean square."
        " The circle has three standard deviations."
    )
