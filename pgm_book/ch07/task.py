"""The task of chapter 7: how two satellite images lie, and what changed in between."""

from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import scipy.ndimage
from matplotlib.figure import Figure

from pgm_book.common.checks import CheckFailed
from pgm_book.common.figures import outline
from pgm_book.task import Part, grey, named, table
from pgm_lab import datasets, plot

SIZE, FINER = 320, 2  # px of each image; pixels of the scene in one of them
CENTRE = (SIZE - 1) / 2
NOISE = 1.5  # grey levels, of each image
# px: of one coordinate of a chip, on steep ground and more where it is flat: found from
# 1,800 chips, with what parabolas miss
SHIFT_SD, FLAT = 0.065, 25.0
FIELDS = "ABCDEFGH"
VALUES = ("dx", "dy", "scale", "turn", "rmse", "ce90")
UNITS = ("in px", "in px", "as a ratio", "in degrees", "in px", "in px")
WANTED: dict[str, tuple[str, Any]] = {
    name: (f"one number {unit}", ()) for name, unit in zip(VALUES, UNITS)
} | {"field": ("its letter", None)}

SIGN = "dx, dy: a shift is sensed minus reference."
EXCHANGED = "dx is along the columns, dy along the rows."
ORIGIN = "dx, dy: the shift is wanted at the centre of the image, not at pixel (0, 0)."
SCALE = (
    "scale: is a length in the sensed image larger or smaller than in the reference?"
)
NO_SCALE = "scale: 1 where lengths are equal, and not their difference from 1."
RADIANS = "turn: degrees are wanted."
SENSE = "turn: clockwise is positive, and rows are counted downwards."
RESIDUAL = "rmse: of the shifts as they are, before anything was corrected."
FACTOR = "ce90: nine of ten distances are below it. No normal distribution is needed."
BLUNDERS = (
    "Points under the cloud or on changed ground do not count: their shifts are far"
    " from what the others say."
)
LEFT_OUT = (
    "Good points were left out, those with the longest shifts: a scale or a turn makes"
    " good shifts differ. Compare each shift with the model, not with the median."
)
FIELD = "field: fetch the sensed image to the reference first, then compare each field."


@dataclass(frozen=True)
class Truth:
    """How the sensed image lies, what changed, and which points can be measured."""

    shift: np.ndarray  # px, at the centre
    scale: float
    turn: float  # radians, clockwise
    points: np.ndarray  # (n, 2), those that can be measured
    field: str
    reference: np.ndarray
    fields: np.ndarray  # left, top of each
    cloud: np.ndarray  # column, row, radius

    @property
    def shifts(self) -> np.ndarray:
        """True shifts of the points that can be measured."""
        return sensed_at(self.points, self.shift, self.scale, self.turn) - self.points

    @property
    def values(self) -> dict[str, float]:
        """The numbers that are asked for."""
        far = np.hypot(*self.shifts.T)
        known = (*self.shift, self.scale, np.degrees(self.turn))
        return dict(
            zip(VALUES, (*known, np.sqrt(np.mean(far**2)), np.quantile(far, 0.9)))
        )

    @property
    def sd(self) -> dict[str, float]:
        """Standard deviations by an affine model; scale and turn from one column."""
        chips, lever = self.chips, self.points[:, 0] - CENTRE
        shift = np.linalg.norm(chips) / len(chips)
        scale = np.linalg.norm(chips * lever) / np.sum(lever**2)
        # Which points can be measured moves RMSE and CE90 more than noise does
        known = (shift, shift, scale, np.degrees(scale), 0.15 / 3, 0.3 / 3)
        return dict(zip(VALUES, known))

    @property
    def chips(self) -> np.ndarray:
        """Standard deviations (n,) of one coordinate of each measured shift, px."""
        slopes = np.gradient(scipy.ndimage.gaussian_filter(1.0 * self.reference, 0.7))
        square = scipy.ndimage.uniform_filter(np.square(slopes).mean(axis=0), 21)
        steep = 21 * np.sqrt(square[tuple(self.points.T[::-1])])
        return np.hypot(SHIFT_SD, (FLAT / steep) ** 2)


def sensed_at(
    points: np.ndarray, shift: np.ndarray, scale: float, turn: float
) -> np.ndarray:
    """Where points (n, 2) of the reference lie in the sensed image."""
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    return CENTRE + shift + (points - CENTRE) @ np.array([(c, s), (-s, c)])


def make(
    chance: np.random.RandomState,
) -> tuple[dict[str, str | np.ndarray], Truth]:
    """Cut two images out of the Landsat scene; cloud and field are put into one."""
    shift = chance.choice([-1, 1], 2) * np.round(chance.uniform(1.5, 4.5, 2), 2)
    scale = 1 + chance.choice([-1, 1]) * np.round(chance.uniform(0.004, 0.009), 4)
    turn = np.radians(
        chance.randint(2)
        * chance.choice([-1, 1])
        * np.round(chance.uniform(0.2, 0.5), 2)
    )
    scene = datasets.landsat().grey.astype(float)
    scene = np.clip((scene - 5900) / (9300 - 5900), 0, 1) * 200 + 20
    scene = scipy.ndimage.gaussian_filter(scene, 1.2 * FINER)
    left, top = chance.randint(60, 1200 - FINER * SIZE - 60, 2)
    row, column = np.indices((SIZE, SIZE))
    pixels = np.stack([column.ravel(), row.ravel()], axis=1)

    def taken(at: np.ndarray) -> np.ndarray:
        places = (top + FINER * at[:, 1], left + FINER * at[:, 0])
        return scipy.ndimage.map_coordinates(scene, places, order=3).reshape(SIZE, SIZE)

    # A pixel of the sensed image shows the ground of this place of the reference
    back = (pixels - CENTRE - shift) @ np.array(
        [(np.cos(turn), -np.sin(turn)), (np.sin(turn), np.cos(turn))]
    ) / scale + CENTRE
    reference, sensed = taken(pixels), taken(back)
    fields, cloud = _places(reference, chance)
    changed = chance.randint(len(fields))
    inside = np.all(np.abs(back - fields[changed] - 20) <= 24, axis=1)
    sensed.ravel()[inside] = taken(back[:, ::-1])[inside.reshape(SIZE, SIZE)]
    sensed = sensed * chance.uniform(0.75, 0.95) + chance.uniform(5, 25)
    away = np.hypot(*(back - cloud[:2]).T).reshape(SIZE, SIZE)
    cover = np.clip((cloud[2] - away) / 8, 0, 1)
    sensed = sensed + cover * (235 - sensed)
    points = _points(chance)
    free = np.hypot(*(points - cloud[:2]).T) > cloud[2] + 16
    free &= np.any(np.abs(points - fields[changed] - 20) > 36, axis=1)
    free &= _texture(reference)[tuple(points.T[::-1])] > 4
    reference, sensed = (
        grey(one + NOISE * chance.standard_normal(one.shape))
        for one in (reference, sensed)
    )
    truth = Truth(
        shift, scale, turn, points[free], FIELDS[changed], reference, fields, cloud
    )
    rows = [(n, x, y, x + 40, y + 40) for n, (x, y) in zip(FIELDS, fields)]
    return {
        "reference.png": truth.reference,
        "sensed.png": sensed,
        "points.csv": table("column,row", "{},{}", points),
        "fields.csv": table("field,left,top,right,bottom", "{},{},{},{},{}", rows),
    }, truth


def _texture(image: np.ndarray) -> np.ndarray:
    """Standard deviation of the grey values of a chip around each pixel."""
    mean, square = (scipy.ndimage.uniform_filter(a, 21) for a in (image, image**2))
    return np.sqrt(np.maximum(square - mean**2, 0))


def _places(
    image: np.ndarray, chance: np.random.RandomState
) -> tuple[np.ndarray, np.ndarray]:
    """Eight fields of 41 by 41 pixels where the texture is strongest, and a cloud."""
    x, y = np.meshgrid(np.arange(5) * 55 + 30, np.arange(5) * 55 + 30)
    places = np.column_stack([x.ravel(), y.ravel()])
    texture = np.array([image[b : b + 41, a : a + 41].std() for a, b in places])
    radius = chance.uniform(30, 42)
    middle = places[chance.randint(len(places))] + 20
    far = np.hypot(*(places + 20 - middle).T) > radius + 30
    best = np.argsort(-np.where(far, texture, -1))[: len(FIELDS)]
    return places[np.sort(best)], np.array([*middle, radius])


def _points(chance: np.random.RandomState) -> np.ndarray:
    """Points (81, 2) in whole pixels, each in a square of its own."""
    x, y = np.meshgrid(np.arange(9) * 31 + 36, np.arange(9) * 31 + 36)
    return np.column_stack([x.ravel(), y.ravel()]) + chance.randint(-10, 11, (81, 2))


def judge(truth: Truth, result: object) -> list[Part]:
    """Return how far each value is off, and whether the field is right."""
    found, field = _answer(result)
    known, sd = truth.values, truth.sd
    parts = [
        Part(f"{name} {found[name]:.4g}", abs(found[name] - known[name]) / sd[name])
        for name in VALUES[:4]
    ]
    parts += [
        Part(name, abs(found[name] - known[name]), 3 * sd[name], "px")
        for name in VALUES[4:]
    ]
    return [*parts, Part("the field", float(field != truth.field), 0)]


def _answer(result: object) -> tuple[dict[str, float], str]:
    """Return the numbers by name, and the field; or say what is wanted."""
    found = named(result, WANTED)
    field = str(found.pop("field")).strip().upper()
    if field not in list(FIELDS):
        raise CheckFailed(f"field must be one of {', '.join(FIELDS)}")
    return found, field


def slips(truth: Truth) -> dict[str, dict]:
    """Return what the likeliest wrong programs give."""
    right = {**truth.values, "field": truth.field}
    known = truth.values
    dx, dy, turn = known["dx"], known["dy"], known["turn"] or 0.3
    corner = sensed_at(np.zeros((1, 2)), truth.shift, truth.scale, truth.turn)[0]
    other = FIELDS[FIELDS.index(truth.field) - 1]
    changes: dict[str, dict] = {
        SIGN: {"dx": -dx, "dy": -dy},
        EXCHANGED: {"dx": dy, "dy": dx},
        ORIGIN: {"dx": corner[0], "dy": corner[1]},
        SCALE: {"scale": 1 / known["scale"]},
        NO_SCALE: {"scale": known["scale"] - 1},
        SENSE: {"turn": -turn},
        RESIDUAL: {"rmse": 0.1},
        FACTOR: {"ce90": 1.5175 * known["rmse"]},
        BLUNDERS: {"rmse": known["rmse"] + 0.5, "ce90": known["ce90"] + 1},
        LEFT_OUT: {"ce90": known["ce90"] - 0.6},
        FIELD: {"field": other},
    }
    if truth.turn:
        changes[RADIANS] = {"turn": truth.turn}
    return {words: right | change for words, change in changes.items()}


def hint(truth: Truth, result: object) -> str:
    """Return the hint to the first value that is wrong."""
    found, field = _answer(result)
    known, sd = truth.values, truth.sd
    wrong = [n for n in VALUES if not abs(found[n] - known[n]) <= 3 * sd[n]]
    for words, slip in slips(truth).items():
        if wrong and all(abs(found[n] - slip[n]) <= 3 * sd[n] for n in wrong):
            return words
    if not wrong:
        return FIELD
    for name in ("ce90", "rmse"):
        if name in wrong:
            return BLUNDERS if found[name] > known[name] else LEFT_OUT
    return (
        f"{wrong[0]}: which points count? Search far enough, compare each shift with"
        " the model of shift, scale and turn, not with the median; leave out what is"
        " off, and adjust again."
    )


def picture(truth: Truth, result: object) -> tuple[Figure, str]:
    """Draw the reference with its fields, and the shifts by the result and in truth."""
    found, field = _answer(result)
    fig, ax = plt.subplots(figsize=(6.5, 6.5), layout="constrained")
    few = truth.reference[::2, ::2] // 16  # a small file
    edges = (-0.5, SIZE - 0.5, SIZE - 0.5, -0.5)
    ax.imshow(few, cmap="gray", extent=edges, interpolation="nearest")
    for name, (x, y) in zip(FIELDS, truth.fields):
        colour = plot.RED if name == field else plot.SKY
        outline(ax, (x + 20, y + 20), 41, colour, linewidth=2.5)
        ax.text(x + 3, y + 14, name, color=colour, fontsize=15, weight="bold")
    yours = sensed_at(
        truth.points,
        np.array([found["dx"], found["dy"]]),
        found["scale"],
        np.radians(found["turn"]),
    )
    arrows: dict[str, Any] = {"angles": "xy", "scale_units": "xy"}
    arrows |= {"scale": 0.2, "width": 0.005}
    for shifts, look in (
        (truth.shifts, {"color": plot.YELLOW, "width": 0.009, "label": "truth"}),
        (yours - truth.points, {"color": plot.BLUE, "label": "yours"}),
    ):
        ax.quiver(*truth.points.T, *shifts.T, **{**arrows, **look})
    ax.legend(loc="lower left", frameon=True, framealpha=1)
    ax.set(title="shifts, five times as long", xlabel="column (px)", ylabel="row (px)")
    ax.grid(False)
    return fig, (
        f"The reference image with eight fields, {field} in another colour, and the"
        f" shifts of {len(truth.points)} points as arrows, five times as long: those of"
        " your result lie on the true ones."
    )
