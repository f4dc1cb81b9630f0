"""The task of chapter 1: the convention of a program whose manual is lost."""

from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_book.common.checks import CheckFailed
from pgm_book.task import Part, grey, named, table
from pgm_lab import frames, plot, simulate

GSD, C = 0.1, 24.0  # m and mm, of the flight that is asked for
NOISE, CONTRAST, DIAMETER = 3.0, 150.0, 9.0  # grey values, and pixels
WHOLE = CONTRAST * np.pi * (DIAMETER / 2) ** 2  # the grey values of a target, summed
WINDOW = 19  # pixels, of an ideal solution
# Of a centroid, in px: the formula of the lesson, with a target in the middle
CENTROID = NOISE * np.sqrt(WINDOW**2 * (WINDOW**2 - 1) / 12) / WHOLE
PROGRAM = 0.03  # pixels: how well the program measured
HAND = (
    0.0015  # of the way from the middle: lines through clicks give another pixel size
)
CONVENTIONS = (
    ("upper left", "right, down"),
    ("upper left", "down, right"),
    ("lower left", "right, up"),
    ("centre", "right, up"),
    ("centre", "right, down"),
)
# Half a pixel from an origin to the outer corner, or to half the number of columns
BESIDE = {"upper left": (-0.5, -0.5), "lower left": (-0.5, 0.5), "centre": (0.5, 0.5)}
STEPS = {"right": (1, 0), "left": (-1, 0), "down": (0, 1), "up": (0, -1)}
WANTED: dict[str, tuple[str, Any]] = {
    "origin": (f"one of {', '.join(BESIDE)}", None),
    "half_pixel": ("True or False", ()),
    "axes": ("two words such as 'right, up': of x, then of y", None),
    "pixel_size": ("one number, in mm", ()),
    "photo": ("(20, 2): x, y in mm of each", (20, 2)),
    "height": ("one number, in m", ()),
}
KEYS = tuple(WANTED)
CLICKED = (
    "Clicks are good to two pixels: fit the lines to the measured centres of all"
    " twenty, and keep all digits."
)
ASIDE = (
    "All photo coordinates are off by the same amount: by half a pixel, or by a corner"
    " of the window?"
)
ZERO = "Compare the zero with the centre of its pixel, or of the image, to 0.1 pixels."
PULL = (
    "Something pulls the centroids to the centres of their windows: a background that"
    " is left in, or a window that cuts the target off."
)


@dataclass(frozen=True)
class Truth:
    """The right answer, and where it comes from."""

    answer: dict[str, Any]
    image_size: tuple[int, int]
    pixels: np.ndarray  # (20, 2), true centres of the targets of plan.csv
    plan: np.ndarray  # (20, 2), mm
    program: np.ndarray  # (20, 2), the same targets in the program's convention
    background: float
    sd_size: float  # of the pixel size, relative to it

    @property
    def sd(self) -> float:
        """Standard deviation of a measured photo coordinate in mm."""
        return CENTROID * self.answer["pixel_size"]

    def photo(self, pixels: np.ndarray) -> np.ndarray:
        """Photo coordinates of pixels in this book's convention."""
        return frames.pixel_to_photo(
            pixels, self.image_size, 2 * [self.answer["pixel_size"]]
        )


def make(chance: np.random.RandomState) -> tuple[dict[str, Any], Truth]:
    """Twenty targets with the coordinates of a program, and twenty with a plan."""
    size = (2 * int(chance.uniform(440, 520)), 2 * int(chance.uniform(300, 360)))
    origin, axes = CONVENTIONS[int(chance.uniform(0, len(CONVENTIONS)))]
    half = bool(chance.uniform() < 0.5)
    p = round(chance.uniform(0.0025, 0.008), 7)
    background = float(int(chance.uniform(30, 60)))

    grid = np.stack(np.meshgrid(np.arange(8) + 0.5, np.arange(5) + 0.5), axis=-1)
    places = grid.reshape(-1, 2) * (size[0] / 8, size[1] / 5)
    places = chance.permutation(places + chance.uniform(-30, 30, (40, 2))).round(4)
    values = background + NOISE * chance.standard_normal(size[::-1])
    corners = np.round(places).astype(int) - 15
    discs = simulate.target(places - corners, DIAMETER, (31, 31), CONTRAST, 0.0)
    for (column, row), disc in zip(corners, discs):
        values[row : row + 31, column : column + 31] += disc

    zero = _place(origin, size) + half * np.array(BESIDE[origin])
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
    answer = (origin, half, axes, p, photo, frames.flying_height(GSD, p, C))
    truth = Truth(
        dict(zip(KEYS, answer)), size, others, plan.round(3), (others - zero) @ turn,
        background, float(slopes.max()),
    )  # fmt: skip
    form = "{:.0f},{:.0f},{:.4f},{:.4f}"
    return {
        "targets.png": grey(values),
        "program.csv": table("column,row,x,y", form, np.hstack([clicked, printed])),
        "plan.csv": table("x,y", "{:.3f},{:.3f}", plan),
    }, truth


def _place(origin: str, size: tuple[int, int]) -> np.ndarray:
    """Pixel at which an origin lies: the centre of a corner pixel, or of the image."""
    share = {"upper left": (0, 0), "lower left": (0, 1), "centre": (0.5, 0.5)}
    return np.array(share[origin]) * np.subtract(size, 1)


def judge(truth: Truth, result: object) -> list[Part]:
    """Return how far each value is off; of the photo coordinates the mean square."""
    found, right = _read(result), truth.answer
    size, height = (found[k] / right[k] - 1 for k in ("pixel_size", "height"))
    return [
        *(Part(k, float(found[k] != right[k]), 0) for k in KEYS[:3]),
        Part("pixel_size", abs(size) / truth.sd_size),
        Part("photo", _rms(found["photo"] - right["photo"]) / truth.sd),
        Part("height", abs(height) / truth.sd_size),
    ]


def _read(result: object) -> dict[str, Any]:
    """Return the values of an answer, or say what is wanted."""
    found = named(result, WANTED)
    origin, axes = (_words(found[k]) for k in ("origin", "axes"))
    if origin not in BESIDE:
        raise CheckFailed(f"origin must be {WANTED['origin'][0]}")
    if len(axes.split()) != 2 or not set(axes.split()) <= STEPS.keys():
        raise CheckFailed(f"axes must be {WANTED['axes'][0]}")
    axes, half = axes.replace(" ", ", "), bool(found["half_pixel"])
    return found | {"origin": origin, "half_pixel": half, "axes": axes}


def _words(answer: object) -> str:
    """Return words in small letters with blanks between them, one spelling of each."""
    parts = answer if isinstance(answer, list | tuple) else [answer]
    words = " ".join(map(str, parts)).casefold().replace(",", " ").split()
    same = {"center": "centre", "top": "upper", "bottom": "lower"}
    return " ".join(same.get(word, word) for word in words)


def _rms(off: np.ndarray) -> float:
    return float(np.sqrt(np.mean(off**2)))


def slips(truth: Truth) -> dict[str, dict[str, Any]]:
    """Return what the likeliest wrong programs give."""
    return {words: truth.answer | {key: value} for words, key, value in _changes(truth)}


def _changes(truth: Truth) -> list[tuple[str, str, Any]]:
    """Return the likeliest slips: the hint, the value that is wrong, and what it is."""
    right, photo, (columns, rows) = (
        truth.answer,
        truth.answer["photo"],
        truth.image_size,
    )
    p, (x, y) = right["pixel_size"], right["axes"].split(", ")
    flip = {"up": "down", "down": "up", "right": "right"}
    near = np.round(frames.photo_to_pixel(truth.plan, truth.image_size, (p, p)))
    dark = truth.background * WINDOW**2
    pulled = truth.pixels + dark / (dark + WHOLE) * (near - truth.pixels)
    other = "centre" if right["origin"] == "upper left" else "upper left"
    middle = "The centre of the photo is half a pixel off."
    shape = "image.shape begins with the rows, image_size with the columns."
    window = "A centroid counts from the corner of its window. Where is that corner?"
    theirs = [("Those are the program's coordinates.", "photo", truth.program)]
    return [
        *(theirs if right["origin"] != "centre" else []),
        ("Do its coordinates grow with the row?", "axes", f"{flip[x]}, {flip[y]}"),
        ("Which of its coordinates follows the column?", "axes", f"{y}, {x}"),
        ("At which pixel are both its coordinates zero?", "origin", other),
        (CLICKED, "pixel_size", 1.001 * p),
        (ZERO, "half_pixel", not right["half_pixel"]),
        ("The pixel size is wanted in millimetres.", "pixel_size", 1000 * p),
        ("In this book y of a photo points up.", "photo", photo * (1, -1)),
        (middle, "photo", photo + (-p / 2, p / 2)),
        (middle, "photo", photo + (p / 2, -p / 2)),
        (shape, "photo", photo + p * (columns - rows) / 2),
        ("Those are places of the plan: measure them.", "photo", truth.plan),
        (window, "photo", truth.photo(truth.pixels - near + WINDOW // 2)),
        (PULL, "photo", truth.photo(pulled)),
        (
            "The height: in which units are its numbers?",
            "height",
            1000 * right["height"],
        ),
    ]


def hint(truth: Truth, result: object) -> str:
    """Return the hint to the first slip that explains a wrong value."""
    found, right = _read(result), truth.answer
    wrong = {part.name for part in judge(truth, result) if not part.holds}
    for words, key, value in _changes(truth):
        if key == "photo":
            same = _rms(found[key] - value) < 3 * truth.sd
        else:
            same = found[key] == value or (
                key in ("pixel_size", "height") and abs(found[key] / value - 1) < 0.01
            )
        if key in wrong and same:
            return words
    off, away = found["photo"] - right["photo"], truth.plan - right["photo"]
    pull, aside = np.sum(off * away) / np.sum(away**2), off.mean(axis=0)
    if "photo" in wrong and _rms(off) > 50 * _rms(away):
        return "The photo coordinates are wanted in mm, from the centre of the photo."
    if "photo" in wrong and _rms(off - aside) < min(_rms(aside) / 3, 6 * truth.sd):
        return ASIDE
    if "photo" in wrong and pull > 0.03 and _rms(off - pull * away) < _rms(off) / 2:
        return PULL
    return f"Look again at {' and '.join(k for k in KEYS if k in wrong)}: draw a plot."


def picture(truth: Truth, result: object) -> tuple[Figure, str]:
    """Draw where the program has its zero and axes, and how far the targets are off."""
    found, columns, rows = _read(result), *truth.image_size
    off = 1000 * (found["photo"] - truth.answer["photo"])
    fig, (left, right) = plt.subplots(1, 2, figsize=(10, 4.4))
    left.add_patch(plt.Rectangle((-0.5, -0.5), columns, rows, fill=False, linewidth=2))
    left.plot(*truth.pixels.T, "o", color=plot.BLUE)
    zero = _place(found["origin"], truth.image_size)
    for name, word in zip("xy", found["axes"].split(", ")):
        end = zero + 0.3 * rows * np.array(STEPS[word])
        look = {"arrowstyle": "-|>", "color": plot.RED, "linewidth": 3, "shrinkA": 0}
        left.annotate("", end, zero, arrowprops=look)
        left.text(*(end + (14, -14)), name, color=plot.RED, fontsize=18)
    left.set(xlabel="column X (px)", ylabel="row Y (px)", aspect="equal")
    left.set(xlim=(-60, columns + 40), ylim=(rows + 40, -40))
    left.set_title("your targets, the program's axes", loc="center")
    right.plot(*off.T, "o", color=plot.BLUE)
    t = np.linspace(0, 2 * np.pi, 91)
    right.plot(*(3000 * truth.sd * np.array([np.cos(t), np.sin(t)])), color=plot.BLACK)
    right.set(xlabel="x (µm)", ylabel="y (µm)", aspect="equal")
    right.set_title("yours minus the truth", loc="center")
    return fig, (
        f"Left, the photo with your twenty targets. The program's zero is"
        f" {found['origin']}, its axes point {found['axes']}. Right, how far your photo"
        f" coordinates are off: {_rms(off):.2f} µm in the mean square. The circle has"
        " three standard deviations."
    )
